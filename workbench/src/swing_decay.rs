//! The decay of the free swings of a bench, measured and according to the model.

use identify::{AtAmplitude, DecayLaw, FreeDecay, PredictedSeries, Record};
use parallel::parallel_map;
use serde::{Deserialize, Serialize};

use crate::named;

/// A free swing that is long enough to show its decay. The measured values come from the samples
/// alone, without a model.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SwingDecay {
    /// The experiment.
    pub experiment: String,
    /// The fitted laws for the amplitude, the best first.
    pub laws: Vec<AmplitudeLaw>,
    /// Change of the small-swing period from the largest to the smallest amplitude, %.
    #[serde(with = "named::gap")]
    pub period_drift_percent: f64,
    /// Standard error of this change, %.
    #[serde(with = "named::gap")]
    pub period_drift_percent_std: f64,
    /// The measured curves over the amplitude.
    #[serde(skip)]
    pub measured: Option<FreeDecay>,
    /// The simulated curves over the amplitude, if the simulation is available.
    #[serde(skip)]
    pub simulated: Option<FreeDecay>,
}

/// A law dA/dt = −(C + V A + Q A²) for the amplitude A of a swing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AmplitudeLaw {
    /// C, rad/s: dry friction. `None` for a term that the law does not have, here and below.
    pub dry: Option<f64>,
    /// Standard error of C.
    pub dry_std: Option<f64>,
    /// V, 1/s: viscous friction.
    pub viscous: Option<f64>,
    /// Standard error of V.
    pub viscous_std: Option<f64>,
    /// Q, 1/(rad s): drag.
    pub quadratic: Option<f64>,
    /// Standard error of Q.
    pub quadratic_std: Option<f64>,
    /// Root mean square residual of the amplitude, relative to the amplitude.
    pub relative_rms: f64,
}

/// A curve over the amplitude: amplitudes in rad, and the values there.
pub(crate) type OverAmplitude = (Vec<f64>, Vec<f64>);

/// The free swings that are long enough to show a decay.
pub(crate) fn swing_decays(records: &[Record], traces: &[Vec<PredictedSeries>]) -> Vec<SwingDecay> {
    let each = records.iter().zip(traces);
    let decays = parallel_map(each, |(record, traces)| {
        let measured = identify::decay(record)?;
        let mut simulated = record.clone();
        for (channel, trace) in simulated.channels.iter_mut().zip(traces) {
            channel.samples.clone_from(&trace.predicted);
        }
        Some(SwingDecay {
            experiment: record.name.clone(),
            laws: measured.laws.iter().map(AmplitudeLaw::of).collect(),
            period_drift_percent: measured.period_drift_percent.value,
            period_drift_percent_std: measured.period_drift_percent.std,
            measured: Some(measured),
            simulated: identify::decay(&simulated),
        })
    });
    decays.into_iter().flatten().collect()
}

impl AmplitudeLaw {
    fn of(law: &DecayLaw) -> AmplitudeLaw {
        let value = |index: usize| law.has[index].then_some(law.coefficients[index].value);
        let std = |index: usize| law.has[index].then_some(law.coefficients[index].std);
        AmplitudeLaw {
            dry: value(0),
            dry_std: std(0),
            viscous: value(1),
            viscous_std: std(1),
            quadratic: value(2),
            quadratic_std: std(2),
            relative_rms: law.relative_rms,
        }
    }

    /// The terms of the law: symbol, unit, value, standard error.
    pub fn terms(&self) -> Vec<(&'static str, &'static str, f64, Option<f64>)> {
        [
            ("C", "rad/s", self.dry, self.dry_std),
            ("V", "1/s", self.viscous, self.viscous_std),
            ("Q", "1/(rad s)", self.quadratic, self.quadratic_std),
        ]
        .into_iter()
        .filter_map(|(symbol, unit, value, std)| Some((symbol, unit, value?, std)))
        .collect()
    }
}

/// Amplitudes and values.
pub(crate) fn over_amplitude(series: &[AtAmplitude]) -> OverAmplitude {
    series.iter().map(|at| (at.amplitude_rad, at.value)).unzip()
}
