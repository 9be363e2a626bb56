//! What an effect more or less changes.

use serde::{Deserialize, Serialize};

use crate::comparison::ComparisonReport;
use crate::per_series::PerSeries;

/// A model before and after an effect was put in or taken out, both fitted to all experiments.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct EffectChange {
    /// The new model beside the measurements.
    #[serde(flatten)]
    pub after: ComparisonReport,
    /// The effects of the new model that hold only until an experiment has decided.
    pub provisional: Vec<String>,
    /// The effects of the old model.
    pub effects_before: Vec<String>,
    /// Its root mean square errors, SI units.
    pub rmse_before: PerSeries,
    /// Its fit, %.
    pub fit_percent_before: PerSeries,
}
