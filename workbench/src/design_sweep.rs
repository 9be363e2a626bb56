//! A design repeated over the values of one of its settings.

use serde::{Deserialize, Serialize};

use crate::control_design::ControlDesign;
use crate::error::Error;
use crate::loop_expectations::ExpectationSettings;
use crate::output_file::OutputFile;

/// The settings that a sweep can vary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Swept {
    /// Weight of the angle, 1/rad².
    AngleWeight,
    /// Weight of the rate, s²/rad².
    RateWeight,
    /// Weight of the wheel speed, s²/rad².
    WheelSpeedWeight,
    /// Weight of the current, 1/A².
    CurrentWeight,
    /// Sample time, s.
    SampleTime,
    /// Largest current, A.
    CurrentLimit,
    /// Delay from the command to the current in the motor, s.
    Delay,
}

impl Swept {
    /// All settings.
    pub const ALL: [Swept; 7] = [
        Swept::AngleWeight,
        Swept::RateWeight,
        Swept::WheelSpeedWeight,
        Swept::CurrentWeight,
        Swept::SampleTime,
        Swept::CurrentLimit,
        Swept::Delay,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Swept::AngleWeight => "angle-weight",
            Swept::RateWeight => "rate-weight",
            Swept::WheelSpeedWeight => "wheel-speed-weight",
            Swept::CurrentWeight => "current-weight",
            Swept::SampleTime => "sample-time",
            Swept::CurrentLimit => "current-limit",
            Swept::Delay => "delay",
        }
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Swept::AngleWeight => "1/rad²",
            Swept::RateWeight | Swept::WheelSpeedWeight => "s²/rad²",
            Swept::CurrentWeight => "1/A²",
            Swept::SampleTime | Swept::Delay => "s",
            Swept::CurrentLimit => "A",
        }
    }

    /// Its name as words.
    pub fn spoken(self) -> String {
        self.name().replace('-', " ")
    }
}

/// A sweep: the result of [`ControlDesign::sweep`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DesignSweep {
    /// The setting that varies.
    pub swept: Swept,
    /// One row for each value.
    pub rows: Vec<SweepRow>,
}

/// The design at one value.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SweepRow {
    /// The value, in the unit of the setting.
    pub value: f64,
    /// The design at this value; `None` if there is none.
    pub point: Option<SweepPoint>,
    /// The reason why there is no design, a sentence; empty if there is one.
    pub failure: String,
}

/// The main numbers of a design.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SweepPoint {
    /// K in A/rad, A s/rad, A s/rad.
    pub gains: [f64; 3],
    /// Real part of the slowest pole, 1/s.
    pub slowest_pole_per_s: f64,
    /// Real part of the fastest pole, 1/s.
    pub fastest_pole_per_s: f64,
    /// Phase margin with the delay.
    #[serde(with = "crate::named::unbounded")]
    pub phase_margin_rad: f64,
    /// Further delay that the loop tolerates.
    #[serde(with = "crate::named::unbounded")]
    pub delay_margin_s: f64,
    /// Smallest distance of the open loop from −1.
    pub modulus_margin: f64,
    /// asin(τ u_max/G).
    pub recovery_angle_rad: f64,
    /// Largest angle under a torque of a tenth of the motor's.
    pub step_angle_rad: f64,
    /// Standard deviation of the angle under the sensors' noise.
    pub noise_angle_rad: f64,
    /// Standard deviation of the current under the sensors' noise.
    pub noise_current_a: f64,
}

impl ControlDesign {
    /// The design at each value of one setting, with all other settings unchanged. A value without a design has a row with
    /// the reason.
    pub fn sweep(
        &self,
        swept: Swept,
        values: &[f64],
        settings: &ExpectationSettings,
    ) -> DesignSweep {
        let rows = values.iter().map(|&value| {
            let point = self.sweep_point(swept, value, settings);
            let (point, failure) = match point {
                Ok(point) => (Some(point), String::new()),
                Err(error) => (None, error.to_string()),
            };
            SweepRow {
                value,
                point,
                failure,
            }
        });
        DesignSweep {
            swept,
            rows: rows.collect(),
        }
    }

    fn sweep_point(
        &self,
        swept: Swept,
        value: f64,
        settings: &ExpectationSettings,
    ) -> Result<SweepPoint, Error> {
        let mut wishes = *self.wishes();
        let mut delay_s = settings.delay_s;
        match swept {
            Swept::AngleWeight => wishes.state_weights[0] = value,
            Swept::RateWeight => wishes.state_weights[1] = value,
            Swept::WheelSpeedWeight => wishes.state_weights[2] = value,
            Swept::CurrentWeight => wishes.current_weight = value,
            Swept::SampleTime => wishes.sample_time_s = value,
            Swept::CurrentLimit => wishes.current_limit_a = value,
            Swept::Delay => delay_s = value,
        }
        let designed = self.with_wishes(wishes)?;
        let delay_s = delay_s + designed.own_delay_s();
        let (a, b) = designed.matrices();
        let controller = design::LinearController::state_feedback(&designed.design().gains);
        let margins =
            design::margins_with_delay(&a, &b, &controller, wishes.sample_time_s, delay_s)
                .map_err(|source| designed.design_error(source))?;
        let noise = designed.noise_expectation(delay_s, &settings.noise)?;
        let poles = designed.design().closed_loop_poles_per_s();
        let real = poles.iter().map(|pole| pole.re);
        Ok(SweepPoint {
            gains: designed.gains(),
            slowest_pole_per_s: real.clone().fold(f64::NEG_INFINITY, f64::max),
            fastest_pole_per_s: real.fold(f64::INFINITY, f64::min),
            phase_margin_rad: margins.phase_margin_rad,
            delay_margin_s: margins.delay_margin_s,
            modulus_margin: margins.modulus_margin,
            recovery_angle_rad: designed.design().recovery_angle_rad,
            step_angle_rad: designed.largest_angle_of_step_rad(delay_s)?,
            noise_angle_rad: noise.angle_rad,
            noise_current_a: noise.current_a,
        })
    }
}

impl DesignSweep {
    /// The rows as a table; cells without a design are empty, and the last column says why.
    ///
    /// # Errors
    /// [`Error::Table`].
    pub fn table(&self) -> Result<OutputFile, Error> {
        let head = [
            "value",
            "gain_angle_A_per_rad",
            "gain_rate_A_s_per_rad",
            "gain_wheel_speed_A_s_per_rad",
            "slowest_pole_per_s",
            "fastest_pole_per_s",
            "phase_margin_rad",
            "delay_margin_s",
            "modulus_margin",
            "recovery_angle_rad",
            "step_angle_rad",
            "noise_angle_rad",
            "noise_current_A",
            "why_none",
        ];
        let rows = self.rows.iter().map(|row| {
            let numbers = row.point.as_ref().map(|point| {
                [
                    point.gains[0],
                    point.gains[1],
                    point.gains[2],
                    point.slowest_pole_per_s,
                    point.fastest_pole_per_s,
                    point.phase_margin_rad,
                    point.delay_margin_s,
                    point.modulus_margin,
                    point.recovery_angle_rad,
                    point.step_angle_rad,
                    point.noise_angle_rad,
                    point.noise_current_a,
                ]
            });
            std::array::from_fn(|column| match column {
                0 => row.value.to_string(),
                13 => row.failure.clone(),
                _ => numbers.map_or(String::new(), |numbers| numbers[column - 1].to_string()),
            })
        });
        OutputFile::of_records(&format!("sweep-{}", self.swept.name()), &head, rows)
    }
}
