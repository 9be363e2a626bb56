//! The nonlinear and the linear model compared with the measured free swings and spin-ups of a bench (thesis
//! figures 3.5 and 3.6).

use bench_files::Bench;
use identify::{Effort, Output, Record, Window};
use plant::{Kind, Model};
use serde::{Deserialize, Serialize};
use simulate::linear_validity::{
    LinearRange, MeasuredPeriod, MeasuredSpinUp, MeasuredSwing, SpinUpOverMeasurement,
    SwingOverMeasurement, linear_range, over_measurement, spin_up_over_measurement,
};

use crate::control_design::ControlDesign;
use crate::error::Error;
use crate::numbers::{percent, significant};

/// Number of periods over which a swing is compared.
pub(crate) const PERIODS: usize = 10;
/// Largest relative error of the period with which the linear model counts as valid.
const PERIOD_SHARE: f64 = 0.01;

/// Both models compared with the measured free swings of a bench.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct MeasuredSwings {
    /// Swing by swing.
    pub swings: Vec<SwingLinearity>,
    /// Largest relative error of the period that counts as valid.
    pub period_share: f64,
    /// Period of the linear model; `None`, here and below, if no period could be measured.
    pub linear_period_s: Option<f64>,
    /// Smallest and largest amplitude at which the period was measured.
    pub measured_amplitudes_rad: Option<[f64; 2]>,
    /// Range of amplitudes in which the measured period equals that of the linear model.
    pub period_good_between_rad: Option<[f64; 2]>,
    /// The next larger measured amplitude, at which the period differs from that of the linear model.
    pub period_off_from_rad: Option<f64>,
}

/// Both models compared with one measured free swing.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SwingLinearity {
    /// The experiment.
    pub experiment: String,
    /// Amplitude of the linear model from the common start.
    pub amplitude_rad: f64,
    /// RMS of measurement − nonlinear model over the first periods, relative to the amplitude.
    pub nonlinear_error: f64,
    /// RMS of measurement − linear model over the first periods, relative to the amplitude.
    pub linear_error: f64,
    /// The curves.
    #[serde(skip)]
    pub curves: Option<SwingOverMeasurement>,
}

/// Both models compared with one measured spin-up.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SpinUpLinearity {
    /// The experiment.
    pub experiment: String,
    /// Largest measured speed.
    pub largest_wheel_speed_rad_s: f64,
    /// RMS of measurement − nonlinear model, relative to the largest speed.
    pub nonlinear_error: f64,
    /// RMS of measurement − linear model, relative to the largest speed.
    pub linear_error: f64,
    /// The curves.
    #[serde(skip)]
    pub curves: Option<SpinUpOverMeasurement>,
}

/// Fits only the start of a log to the model.
fn started(record: &Record, model: &Model, values: &[f64]) -> Vec<Window> {
    let windows = vec![identify::final_windows(record, values)];
    let values = values.to_vec();
    let fitted = identify::refit(&[record], model, values, windows, &[], Effort::FULL);
    fitted.windows.into_iter().flatten().collect()
}

impl SwingLinearity {
    /// For every free swing that has an angle; `None` if the bench has no such swing.
    pub(crate) fn of_bench(
        bench: &Bench,
        designed: &ControlDesign,
    ) -> Result<Option<MeasuredSwings>, Error> {
        let failed = |source| designed.simulate_error(source);
        let (model, values) = (designed.model(), designed.values());
        let mut swings = Vec::new();
        let mut periods = Vec::new();
        for experiment in &bench.experiments {
            if experiment.kind != Kind::FreeSwing {
                continue;
            }
            let record = Record::from_experiment(experiment);
            let Some(channel) = record.channel(Output::Angle) else {
                continue;
            };
            let mut whole_rad = vec![f64::NAN; record.len()];
            let mut start = None;
            for window in &started(&record, model, values) {
                identify::simulate(&record, window, model, values, |k, reading, state| {
                    whole_rad[k] = reading.angle_rad;
                    if k == 0 {
                        start = Some([state.angle_rad, state.rate_rad_s]);
                    }
                });
            }
            let Some(start) = start else { continue };
            let measured = MeasuredSwing {
                time_s: &record.time_s,
                angle_rad: &channel.samples,
                whole_rad: &whole_rad,
                start,
            };
            let over = over_measurement(model, values, &measured, PERIODS).map_err(failed)?;
            swings.push(SwingLinearity {
                experiment: record.name.clone(),
                amplitude_rad: over.amplitude_rad,
                nonlinear_error: over.whole_error,
                linear_error: over.linear_error,
                curves: Some(over),
            });
            let found = identify::decay(&record).map_or(Vec::new(), |decay| decay.periods);
            periods.extend(found.iter().map(|at| MeasuredPeriod {
                amplitude_rad: at.amplitude_rad,
                period_s: at.value,
                std_s: at.std,
            }));
        }
        let range = linear_range(model, values, &periods, PERIOD_SHARE).map_err(failed)?;
        Ok((!swings.is_empty()).then(|| MeasuredSwings::new(swings, range)))
    }
}

impl MeasuredSwings {
    /// One sentence on the range of amplitudes in which the linear model has the measured period.
    pub fn range_sentence(&self) -> String {
        let degrees = |angle_rad: f64| format!("{:.1}°", angle_rad.to_degrees());
        let (Some(period_s), Some([least, most])) =
            (self.linear_period_s, self.measured_amplitudes_rad)
        else {
            return "no swing is long and clean enough to measure its period".to_owned();
        };
        let measured = format!("measured from {} to {}", degrees(least), degrees(most));
        let period = format!("{} s", significant(period_s, 4));
        let share = percent(self.period_share);
        match self.period_good_between_rad {
            None => format!(
                "at no amplitude is the period within {share} of the linear model's {period} ({measured})"
            ),
            Some([from, to]) => {
                let end = match self.period_off_from_rad {
                    Some(off) => format!(", off from {} on", degrees(off)),
                    None => String::new(),
                };
                format!(
                    "the period is within {share} of the linear model's {period} from {} to {}{end} ({measured})",
                    degrees(from),
                    degrees(to)
                )
            }
        }
    }

    fn new(swings: Vec<SwingLinearity>, range: Option<LinearRange>) -> MeasuredSwings {
        MeasuredSwings {
            swings,
            period_share: PERIOD_SHARE,
            linear_period_s: range.map(|range| range.linear_period_s),
            measured_amplitudes_rad: range.map(|range| range.measured_rad.into()),
            period_good_between_rad: range.and_then(|range| range.good_rad).map(<[f64; 2]>::from),
            period_off_from_rad: range.and_then(|range| range.off_from_rad),
        }
    }
}

impl SpinUpLinearity {
    /// For every spin-up with a wheel speed and a known current.
    pub(crate) fn of_bench(
        bench: &Bench,
        designed: &ControlDesign,
    ) -> Result<Vec<SpinUpLinearity>, Error> {
        let (model, values) = (designed.model(), designed.values());
        let mut found = Vec::new();
        for experiment in &bench.experiments {
            if experiment.kind != Kind::SpinUp || experiment.log.current_a.is_none() {
                continue;
            }
            let record = Record::from_experiment(experiment);
            let Some(channel) = record.channel(Output::WheelSpeed) else {
                continue;
            };
            let mut whole_rad_s = vec![f64::NAN; record.len()];
            for window in &started(&record, model, values) {
                identify::simulate(&record, window, model, values, |k, reading, _| {
                    whole_rad_s[k] = reading.wheel_speed_rad_s;
                });
            }
            let measured = MeasuredSpinUp {
                time_s: &record.time_s,
                wheel_speed_rad_s: &channel.samples,
                current_a: &record.current_a,
                whole_rad_s: &whole_rad_s,
            };
            let over = spin_up_over_measurement(model, values, &measured)
                .map_err(|source| designed.simulate_error(source))?;
            found.push(SpinUpLinearity {
                experiment: record.name.clone(),
                largest_wheel_speed_rad_s: over.largest_rad_s,
                nonlinear_error: over.whole_error,
                linear_error: over.linear_error,
                curves: Some(over),
            });
        }
        Ok(found)
    }
}
