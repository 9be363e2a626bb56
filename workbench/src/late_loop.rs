//! The loop with all delays and filters of the bench: the age of the sensors' readings, their filters and delays, and
//! one sample of computation; and the same loop designed at other sample times.

use bench_files::{AngleSensor, WheelSpeedSensor};
use design::{
    DesignError, Lateness, LinearController, SensorLateness, SensorNoise, eigenvalues,
    late_margins, noise_in_late_loop,
};
use plant::{Kind, Output, Plant};
use serde::{Deserialize, Serialize};

use crate::control_design::ControlDesign;
use crate::design_report::LoopMargins;
use crate::error::Error;
use crate::loop_expectations::ExpectationSettings;

/// Sample times that are tried, in s: round numbers.
const SAMPLE_TIMES_S: [f64; 19] = [
    0.25e-3, 0.5e-3, 0.8e-3, 1e-3, 1.25e-3, 2e-3, 2.5e-3, 4e-3, 5e-3, 6e-3, 8e-3, 10e-3, 12e-3,
    16e-3, 20e-3, 25e-3, 32e-3, 40e-3, 50e-3,
];

/// The shortest sample time that is tried if the sensors' rate is not known, as a share of the design's sample time.
const SHORTEST_SHARE: f64 = 0.25;

/// Smallest modulus margin, the distance of the open loop from −1, with which a sample time is sensible. Disturbances
/// are then amplified at most twofold (Åström and Hägglund, "PID Controllers", 2nd ed. 1995, section 4.5: 1.3 to 2 is
/// usual).
const LEAST_MODULUS: f64 = 0.5;

/// A pole with a smaller modulus comes from the delay alone and is not reported.
const LEAST_POLE: f64 = 1e-3;

/// The loop as the bench's hardware makes it: the result of [`ControlDesign::late_loop`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LateLoop {
    /// The delays and lags of the bench, one by one.
    pub parts: Vec<LatePart>,
    /// The loop at the design's own sample time; `None` if it is unstable.
    pub law: Option<LatePoint>,
    /// The loop with a law that predicts the state by the model; `None` if it is unstable.
    pub predicting: Option<LatePoint>,
    /// Time over which that law predicts the state, s.
    pub ahead_s: f64,
    /// The design at other sample times, from short to long.
    pub sample_times: Vec<SampleTimeRow>,
}

/// One delay or lag of the bench.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LatePart {
    /// "the current", "the angle", "the rate" or "the wheel speed".
    pub what: String,
    /// The delay, or the time constant of a filter, s.
    pub late_s: f64,
    /// The cause, in words.
    pub why: String,
}

/// A loop with these delays and lags.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LatePoint {
    /// Real and imaginary part of the poles, as continuous equivalents, 1/s; those of the delay itself are left out.
    pub poles_per_s: Vec<[f64; 2]>,
    /// The margins of the loop beyond these delays and lags.
    pub margins: LoopMargins,
    /// Standard deviation of the true angle by the sensors' noise.
    pub noise_angle_rad: f64,
    /// Standard deviation of the current by the sensors' noise.
    pub noise_current_a: f64,
}

/// The design at one sample time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SampleTimeRow {
    /// The sample time.
    pub sample_time_s: f64,
    /// The loop of u = −K x, designed at that sample time; `None` if there is no design, or if the loop is unstable.
    pub law: Option<LatePoint>,
    /// The loop with prediction, designed at that sample time; `None` as for `law`.
    pub predicting: Option<LatePoint>,
    /// Whether the sample time is sensible.
    pub sensible: bool,
    /// The reason why the sample time is not sensible; empty if it is.
    pub why: String,
}

impl ControlDesign {
    /// The loop with the delays and filters of the bench's hardware, at the design's sample time and at others.
    ///
    /// # Errors
    /// [`Error::Design`] if a number is not finite.
    pub fn late_loop(&self, settings: &ExpectationSettings) -> Result<LateLoop, Error> {
        let (parts, lateness) = self.lateness(settings.delay_s);
        let own_s = self.wishes().sample_time_s;
        let (law, predicting) = self.late_points(&lateness, settings)?;
        // At shorter sample times the sensors give no fresh readings, or the times are far from the wished one.
        let shortest_s = self
            .freshest_s()
            .unwrap_or(SHORTEST_SHARE * own_s)
            .min(own_s);
        let mut times: Vec<f64> = SAMPLE_TIMES_S.to_vec();
        times.retain(|time_s| *time_s >= shortest_s && (time_s / own_s - 1.0).abs() > 1e-9);
        times.push(own_s);
        times.sort_by(f64::total_cmp);
        let mut sample_times = Vec::new();
        for time_s in times {
            let row = self.sample_time_row(time_s, settings)?;
            let is_over = row.law.is_none() && row.predicting.is_none() && time_s > own_s;
            sample_times.push(row);
            if is_over {
                break;
            }
        }
        Ok(LateLoop {
            parts,
            law,
            predicting,
            ahead_s: ahead_s(&lateness),
            sample_times,
        })
    }

    fn sample_time_row(
        &self,
        sample_time_s: f64,
        settings: &ExpectationSettings,
    ) -> Result<SampleTimeRow, Error> {
        let mut row = SampleTimeRow {
            sample_time_s,
            law: None,
            predicting: None,
            sensible: false,
            why: String::new(),
        };
        let mut wishes = *self.wishes();
        wishes.sample_time_s = sample_time_s;
        let designed = match self.with_wishes(wishes) {
            Ok(designed) => designed,
            Err(Error::Design { source, .. }) => {
                row.why = source.to_string();
                return Ok(row);
            }
            Err(error) => return Err(error),
        };
        let (_, lateness) = designed.lateness(settings.delay_s);
        (row.law, row.predicting) = designed.late_points(&lateness, settings)?;
        row.why = match (&row.law, self.freshest_s()) {
            (None, _) => "with these delays and lags the loop is unstable".to_owned(),
            (Some(_), Some(fresh_s)) if sample_time_s < fresh_s * (1.0 - 1e-9) => {
                "the sensors give no fresh reading for every sample".to_owned()
            }
            (Some(law), _) if law.margins.modulus_margin < LEAST_MODULUS => format!(
                "disturbances are amplified up to {:.1}-fold",
                1.0 / law.margins.modulus_margin
            ),
            _ => String::new(),
        };
        row.sensible = row.why.is_empty();
        Ok(row)
    }

    /// Time between two fresh readings of the fastest inertial sensor that the loop needs, s.
    fn freshest_s(&self) -> Option<f64> {
        let hardware = self.file().hardware.as_ref()?;
        if matches!(hardware.angle, Some(AngleSensor::Encoder { .. })) {
            return None;
        }
        let rate_hz = hardware.gyroscope.as_ref()?.rate_hz?;
        Some(1.0 / rate_hz)
    }

    /// The delays and lags of the bench, for the report and as numbers; `delay_s` is a further delay of the current.
    fn lateness(&self, delay_s: f64) -> (Vec<LatePart>, Lateness) {
        let sample_time_s = self.wishes().sample_time_s;
        let plant = Plant::new(self.model(), self.values(), Kind::Balance);
        let mut parts = Vec::new();
        let mut part = |what: &str, late_s: f64, why: &str| {
            if late_s > 0.0 {
                parts.push(LatePart {
                    what: what.to_owned(),
                    late_s,
                    why: why.to_owned(),
                });
            }
            late_s.max(0.0)
        };
        let current_s = part(
            "the current",
            sample_time_s,
            "the computation, which takes at most one sample",
        ) + part(
            "the current",
            self.own_delay_s(),
            "the model's effect input-delay",
        ) + part(
            "the current",
            delay_s,
            "the additional delay that was asked for",
        );

        let hardware = self.file().hardware.as_ref();
        let gyroscope = hardware.and_then(|hardware| hardware.gyroscope.as_ref());
        let rad_per_count = match hardware.and_then(|hardware| hardware.angle.as_ref()) {
            Some(AngleSensor::Encoder {
                counts_per_turn, ..
            }) => Some(std::f64::consts::TAU / counts_per_turn),
            _ => None,
        };
        let gyro_rate_hz = gyroscope.and_then(|sensor| sensor.rate_hz);
        let age_s = gyro_rate_hz.map_or(0.0, |rate_hz| 0.5 / rate_hz);
        let (angle, rate) = (Output::Angle, Output::Rate);
        let mut own = |output: Output, what: &str| {
            let (lag_s, delay_s) = plant.sensor_times_s(output);
            SensorLateness {
                lag_s: part(what, lag_s, "the model's effect of a lag (time constant)"),
                delay_s: part(what, delay_s, "the model's effect of a delay"),
            }
        };
        let mut sensors = [
            own(angle, "the angle"),
            own(rate, "the rate"),
            own(Output::WheelSpeed, "the wheel speed"),
        ];
        if let Some(rad_per_count) = rad_per_count {
            let window = self.rate_needs().window(rad_per_count);
            let mean_s = 0.5 * f64::from(window) * sample_time_s;
            let why = "the difference of counts over the window of the encoder on the pivot";
            sensors[1].delay_s += part("the rate", mean_s, why);
        } else {
            let why = "the mean age of a reading of the gyroscope";
            sensors[1].delay_s += part("the rate", age_s, why);
            // The attitude filter integrates the gyroscope; the accelerometer only corrects slowly.
            let filtered = sensors[1];
            sensors[0].lag_s += part("the angle", filtered.lag_s, "integrated from the rate");
            sensors[0].delay_s += part("the angle", filtered.delay_s, "integrated from the rate");
        }
        let wheel = hardware.and_then(|hardware| hardware.wheel_speed.as_ref());
        if let Some(WheelSpeedSensor::Encoder { window, .. }) = wheel {
            let mean_s = 0.5 * f64::from(*window) * sample_time_s;
            let why = "the difference of counts over the encoder's window";
            sensors[2].delay_s += part("the wheel speed", mean_s, why);
        }
        (parts, Lateness { current_s, sensors })
    }

    /// The loops of the law u = −K x and of the law that predicts, each `None` if it is unstable.
    fn late_points(
        &self,
        lateness: &Lateness,
        settings: &ExpectationSettings,
    ) -> Result<(Option<LatePoint>, Option<LatePoint>), Error> {
        let (a, b) = self.matrices();
        let (gains, sample_time_s) = (self.design().gains, self.wishes().sample_time_s);
        let in_design = |source| self.design_error(source);
        let predicting =
            LinearController::predicting(&gains, &a, &b, sample_time_s, ahead_s(lateness))
                .map_err(in_design)?;
        let law = LinearController::state_feedback(&gains);
        Ok((
            self.late_point(&law, lateness, settings)?,
            self.late_point(&predicting, lateness, settings)?,
        ))
    }

    fn late_point(
        &self,
        controller: &LinearController,
        lateness: &Lateness,
        settings: &ExpectationSettings,
    ) -> Result<Option<LatePoint>, Error> {
        let (a, b) = self.matrices();
        let sample_time_s = self.wishes().sample_time_s;
        let in_design = |source| self.design_error(source);
        let margins = match late_margins(&a, &b, controller, sample_time_s, lateness) {
            Ok(margins) => margins,
            Err(DesignError::UnstableLoop { .. }) => return Ok(None),
            Err(error) => return Err(in_design(error)),
        };
        let closed = controller
            .late_closed_loop(&a, &b, sample_time_s, lateness)
            .map_err(in_design)?;
        let poles = eigenvalues(&closed).map_err(in_design)?;
        let mut poles_per_s: Vec<[f64; 2]> = poles
            .iter()
            .filter(|pole| pole.norm() > LEAST_POLE)
            .map(|pole| pole.ln() / sample_time_s)
            .map(|pole| [pole.re, pole.im])
            .collect();
        poles_per_s.sort_by(|left, right| right[0].total_cmp(&left[0]));
        let ([angle_rad, rate_rad_s, wheel_speed_rad_s], _) = settings.noise.or_assumed();
        let noise = SensorNoise {
            angle_rad,
            rate_rad_s,
            wheel_speed_rad_s,
        };
        let noise = noise_in_late_loop(
            &self.design().model,
            controller,
            sample_time_s,
            lateness,
            &noise,
        )
        .map_err(in_design)?;
        Ok(Some(LatePoint {
            poles_per_s,
            margins: LoopMargins::of(&margins),
            noise_angle_rad: noise.angle_rad,
            noise_current_a: noise.current_a,
        }))
    }
}

/// The time in s over which the law must predict: the delay of the current plus that of the rate, the sensor that
/// matters most. A filter's time constant counts as a delay.
fn ahead_s(lateness: &Lateness) -> f64 {
    let rate = lateness.sensors[1];
    lateness.current_s + rate.lag_s + rate.delay_s
}
