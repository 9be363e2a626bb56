//! The residual that no effect explains, and whether it matters.

use design::torque_response;
use diagnose::{RemainingTorque, SeriesDiscrepancy};
use identify::{FitProblem, TorqueOn};
use plant::torque_inputs;
use serde::{Deserialize, Serialize};

use crate::control_design::ControlDesign;
use crate::numbers::{significant, with_prefix};

/// The size of the unexplained residual.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RemainsReport {
    /// The largest structured remainder, in units of its sensor's noise.
    pub over_noise: f64,
    /// The same remainder relative to the standard deviation of the measured series.
    pub over_signal: f64,
    /// What is not explained in the series with that remainder; `None` if nothing remains.
    pub discrepancy: Option<DiscrepancyReport>,
    /// Root mean square of the missing torque in the experiment where it is largest, N m. `None` if the logs show no
    /// torque, or do not determine its scale.
    #[serde(rename = "torque_Nm")]
    pub torque_nm: Option<f64>,
    /// The body on which the torque acts: `body` or `wheel`.
    pub torque_on: Option<String>,
    /// The experiment in which the torque is largest.
    pub experiment: Option<String>,
    /// The effect of a torque of that size on the controlled pendulum; `None` if no controller could be designed.
    pub closed_loop: Option<ClosedLoopDeviation>,
}

/// What no effect explains in a series, as a random process beside the noise of its sensor: with the covariance
/// δ² exp(−|t − t′|/ℓ) cos ω(t − t′).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiscrepancyReport {
    /// The series, as "experiment/channel".
    pub series: String,
    /// Its standard deviation δ.
    pub std: f64,
    /// The unit of δ.
    pub unit: String,
    /// Its correlation time ℓ, s.
    pub correlation_time_s: f64,
    /// Its angular frequency ω, rad/s; 0 if it does not oscillate.
    pub frequency_rad_s: f64,
}

impl DiscrepancyReport {
    fn new(found: &SeriesDiscrepancy) -> DiscrepancyReport {
        let output = found.output;
        DiscrepancyReport {
            series: format!("{}/{}", found.experiment, output.name()),
            std: found.process.std,
            unit: output.unit().to_owned(),
            correlation_time_s: found.process.time_s,
            frequency_rad_s: found.process.frequency_rad_s,
        }
    }
}

/// The root mean square deviation of the controlled pendulum, under a torque of the frequency to which the loop is
/// most sensitive. It is an upper bound for every other torque of that size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClosedLoopDeviation {
    /// Deviation of the angle, rad.
    pub angle_rad: f64,
    /// Deviation of the current, A.
    #[serde(rename = "current_A")]
    pub current_a: f64,
}

impl RemainsReport {
    /// The report on the residual `found`, with its effect in the loop of `design`; `problem` says whether the logs
    /// determine the scale of torques.
    pub(crate) fn new(
        found: &diagnose::Remains,
        problem: &FitProblem,
        design: Option<&ControlDesign>,
    ) -> RemainsReport {
        let torque = found.torque.as_ref().filter(|torque| match torque.on {
            TorqueOn::Body | TorqueOn::BodyByCommand => problem.body_scale_known,
            TorqueOn::Wheel => problem.wheel_scale_known,
        });
        RemainsReport {
            over_noise: found.over_noise,
            over_signal: found.over_signal,
            discrepancy: found.discrepancy.as_ref().map(DiscrepancyReport::new),
            torque_nm: torque.map(|torque| torque.rms_nm),
            torque_on: torque.map(|torque| name(torque.on).to_owned()),
            experiment: torque.map(|torque| torque.experiment.clone()),
            closed_loop: torque.and_then(|torque| deviation(torque, design?)),
        }
    }

    /// The meaning of these numbers, in one or two sentences.
    pub fn sentence(&self) -> String {
        let mut text = format!(
            "What remains is {} times the noise of the sensor and {} % of the measured signal.",
            significant(self.over_noise, 2),
            significant(100.0 * self.over_signal, 2)
        );
        if let Some(found) = &self.discrepancy {
            text.push_str(&format!(
                " It is a deviation of {} ({}) with a correlation time of {} s.",
                with_prefix(found.std, &found.unit),
                found.series,
                significant(found.correlation_time_s, 2)
            ));
        }
        if let (Some(torque), Some(on), Some(experiment)) =
            (self.torque_nm, &self.torque_on, &self.experiment)
        {
            text.push_str(&format!(
                " As a torque on the {on} it is {} mN m ({experiment})",
                significant(1e3 * torque, 2)
            ));
            text.push_str(&match self.closed_loop {
                Some(loop_) => format!(
                    "; a torque of that size moves the controlled pendulum by at most {}° and the \
                     current by at most {} A.",
                    significant(loop_.angle_rad.to_degrees(), 2),
                    significant(loop_.current_a, 2)
                ),
                None => ".".to_owned(),
            });
        }
        text
    }
}

fn name(on: TorqueOn) -> &'static str {
    match on {
        TorqueOn::Body | TorqueOn::BodyByCommand => "body",
        TorqueOn::Wheel => "wheel",
    }
}

fn deviation(torque: &RemainingTorque, design: &ControlDesign) -> Option<ClosedLoopDeviation> {
    let [body, wheel] = torque_inputs(design.model(), design.values());
    let input = match torque.on {
        TorqueOn::Body | TorqueOn::BodyByCommand => body,
        TorqueOn::Wheel => wheel,
    };
    let response = torque_response(design.design(), &input).ok()?;
    Some(ClosedLoopDeviation {
        angle_rad: response.angle_rad_per_nm * torque.rms_nm,
        current_a: response.current_a_per_nm * torque.rms_nm,
    })
}
