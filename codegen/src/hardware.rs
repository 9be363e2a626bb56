//! The hardware around the control law: sensors and drive.

use attitude::AttitudeSpec;

/// Sensors and optional bias observer. The drive is described by [`crate::spec::PwmDrive`].
#[derive(Debug, Clone, PartialEq)]
pub struct HardwareSpec {
    /// How the body's angle and rate are read.
    pub body: BodySensor,
    /// How the wheel's speed is read.
    pub wheel: WheelSensor,
    /// Wheel speed per count (rad/s): of the converter, of the driver's word, or of the counts that the encoder turns
    /// over its window.
    pub wheel_speed_per_count: f64,
    /// Wheel speed at zero counts (rad/s).
    pub wheel_speed_at_zero: f64,
    /// Lower end of the sensor's range: at or below this count the true speed is unknown.
    pub wheel_low: i32,
    /// Upper end of the sensor's range: at or above this count the true speed is unknown.
    pub wheel_high: i32,
    /// Rate of new gyroscope samples, Hz; `None` for one in each step.
    pub gyro_rate_hz: Option<f64>,
    /// The accelerometer's scale from its part or as stated (m/s² per count), with which its
    /// calibrated scale is compared; `None` if only a calibration is known.
    pub accelerometer_m_s2_per_count: Option<f64>,
    /// The meaning of the words, for the author of the firmware: lines of text.
    pub registers: Vec<String>,
    /// Observer of a constant bias of the angle, because such a bias keeps the wheel turning; `None` for no observer.
    pub bias_observer: Option<BiasObserverSpec>,
}

/// How the body's angle and rate are read.
#[derive(Debug, Clone, PartialEq)]
pub enum BodySensor {
    /// Gyroscope and accelerometer: sensors, mounting and filter. The sample time is that of the module.
    Inertial(Box<AttitudeSpec>),
    /// An encoder on the pivot.
    Encoder(BodyEncoder),
}

/// An encoder on the pivot. The rate is the difference of its counts over the window, divided by the duration of the
/// window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyEncoder {
    /// The encoder.
    pub encoder: EncoderSpec,
    /// Its count with the body upright.
    pub zero: u32,
    /// Largest rate that the word shows (rad/s). A higher rate reads as this one.
    pub largest_rate_rad_s: f64,
}

/// How the wheel's speed is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WheelSensor {
    /// Counts of a converter, from zero up.
    Converter,
    /// Signed words of the motor's driver.
    Driver,
    /// Counts of an encoder: their difference over a window, divided by its duration, is the speed.
    Encoder(EncoderSpec),
}

/// An absolute encoder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderSpec {
    /// Counts per turn; negative if they fall while the angle rises.
    pub counts_per_turn: f64,
    /// The count begins again at zero after 2^`bits`.
    pub bits: u32,
    /// Number of steps over which the difference of the counts is taken. The speed is late by half of this time.
    pub window: u32,
}

/// The largest window of an encoder, in steps.
pub const WINDOW_MAX: u32 = 16;

/// Largest change of the command by one count of the rate, as a share of the largest current. With a larger share the
/// current jumps to and fro; with a smaller one the window, and with it the delay of the rate, is longer than needed.
const COUNT_SHARE: f64 = 0.125;

/// Largest delay of the rate, as a share of the loop's delay margin.
const DELAY_SHARE: f64 = 0.25;

/// The numbers of the loop that decide the window of an encoder on the pivot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateNeeds {
    /// Time between two samples (s).
    pub sample_time_s: f64,
    /// Current per rate, either sign (A s/rad).
    pub rate_gain: f64,
    /// Largest current (A).
    pub current_limit_a: f64,
    /// Delay of the whole loop at which it becomes unstable (s).
    pub delay_margin_s: f64,
}

impl RateNeeds {
    /// The window, in steps, for an encoder with this angle per count.
    ///
    /// A count of the rate, δ/(N T), changes the command by K₂ δ/(N T), and the rate is N T/2 late. The window is the
    /// shortest one with which a count is at most [`COUNT_SHARE`] of the largest current; but its delay is at most
    /// [`DELAY_SHARE`] of the loop's margin, and it has 1 to [`WINDOW_MAX`] steps.
    pub fn window(&self, rad_per_count: f64) -> u32 {
        let largest_step_rad_s = COUNT_SHARE * self.current_limit_a / self.rate_gain.abs();
        let fine = (rad_per_count.abs() / (self.sample_time_s * largest_step_rad_s)).ceil();
        let early = (2.0 * DELAY_SHARE * self.delay_margin_s / self.sample_time_s).floor();
        // A cast saturates; NaN becomes zero.
        (fine.min(early) as u32).clamp(1, WINDOW_MAX)
    }
}

impl EncoderSpec {
    /// Angle of one count (rad).
    pub fn rad_per_count(&self) -> f64 {
        core::f64::consts::TAU / self.counts_per_turn
    }

    /// Speed for one count over the window, sampled every `sample_time_s` (rad/s).
    pub fn rad_s_per_count(&self, sample_time_s: f64) -> f64 {
        self.rad_per_count() / (f64::from(self.window) * sample_time_s)
    }

    /// The number of counts after which the count starts again at zero.
    pub fn wrap(&self) -> i32 {
        1 << self.bits
    }

    /// Largest number of counts over the window in either direction: half of a wrap in each step, minus one count.
    pub fn most_counts(&self) -> i32 {
        (self.wrap() / 2 - 1) * self.window as i32
    }
}

impl HardwareSpec {
    /// The inertial sensors; `None` where an encoder shows the body.
    pub fn attitude(&self) -> Option<&AttitudeSpec> {
        match &self.body {
            BodySensor::Inertial(attitude) => Some(attitude),
            BodySensor::Encoder(_) => None,
        }
    }

    /// The encoder on the pivot, where there is one.
    pub fn body_encoder(&self) -> Option<&BodyEncoder> {
        match &self.body {
            BodySensor::Inertial(_) => None,
            BodySensor::Encoder(encoder) => Some(encoder),
        }
    }

    /// The thesis bench: its sensors by their data sheets, ADS1015 with
    /// rpm = 8.53108 count − 6594.5 between the ends ∓6594.5 rpm of the drive's speed signal, no bias
    /// observer.
    pub fn thesis_bench() -> Self {
        let rpm = core::f64::consts::TAU / 60.0;
        HardwareSpec {
            body: BodySensor::Inertial(Box::new(AttitudeSpec::thesis())),
            wheel: WheelSensor::Converter,
            wheel_speed_per_count: 8.53108 * rpm,
            wheel_speed_at_zero: -6594.5 * rpm,
            wheel_low: 0,
            wheel_high: 1_546,
            gyro_rate_hz: Some(800.0),
            accelerometer_m_s2_per_count: Some(attitude::STANDARD_GRAVITY / 4096.0),
            registers: Vec::new(),
            bias_observer: None,
        }
    }
}

/// An observer of the angle's bias: b = z + `direct` y, z' = `decay` z + `from_states` y +
/// `from_current` u, with y = (angle, rate, wheel speed) as measured and u the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BiasObserverSpec {
    /// Dimensionless, within (−1, 1).
    pub decay: f64,
    /// rad per unit of each state.
    pub direct: [f64; 3],
    /// rad per unit of each state.
    pub from_states: [f64; 3],
    /// rad/A.
    pub from_current: f64,
    /// The estimate stays within ± this (rad).
    pub limit_rad: f64,
}
