//! The change that adding or removing an effect makes.

use serde::{Deserialize, Serialize};

use crate::comparison::ComparisonReport;
use crate::per_series::PerSeries;

/// A model before and after an effect was added or removed, both fitted to all experiments.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct EffectChange {
    /// The new model, compared with the measurements.
    #[serde(flatten)]
    pub after: ComparisonReport,
    /// The provisional effects of the new model: an experiment must decide about them.
    pub provisional: Vec<String>,
    /// The effects of the old model.
    pub effects_before: Vec<String>,
    /// Root mean square errors of the old model, SI units.
    pub rmse_before: PerSeries,
    /// Fit of the old model, %.
    pub fit_percent_before: PerSeries,
}
