//! The hardware around the control law: sensors and drive.

use attitude::AttitudeSpec;

/// Sensors and optional bias observer. The drive is described by [`crate::spec::PwmDrive`].
#[derive(Debug, Clone, PartialEq)]
pub struct HardwareSpec {
    /// Inertial sensor, mounting and filter. Its sample time is that of the module.
    pub attitude: AttitudeSpec,
    /// How the wheel's speed is read.
    pub wheel: WheelSensor,
    /// Wheel speed per count (rad/s): of the converter, of the driver's word, or of the counts that the encoder turns
    /// over its window.
    pub wheel_speed_per_count: f64,
    /// Wheel speed at zero counts (rad/s).
    pub wheel_speed_at_zero: f64,
    /// Count at or below which the speed may be any.
    pub wheel_low: i32,
    /// Count at or above which the speed may be any.
    pub wheel_high: i32,
    /// Rate of new gyroscope samples, Hz; `None` for one in each step.
    pub gyro_rate_hz: Option<f64>,
    /// The accelerometer's scale from its part or as stated (m/s² per count), with which its
    /// calibrated scale is compared; `None` if only a calibration is known.
    pub accelerometer_m_s2_per_count: Option<f64>,
    /// The meaning of the words, for the author of the firmware: lines of text.
    pub registers: Vec<String>,
    /// Observer of a constant bias of the angle, which would keep the wheel turning; `None` for no observer.
    pub bias_observer: Option<BiasObserverSpec>,
}

/// How the wheel's speed is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WheelSensor {
    /// Counts of a converter, from zero up.
    Converter,
    /// Signed words of the motor's driver.
    Driver,
    /// Counts of an encoder, whose turn over a window is the speed.
    Encoder(EncoderSpec),
}

/// An absolute encoder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderSpec {
    /// Counts per turn; negative if they fall while the angle rises.
    pub counts_per_turn: f64,
    /// The count begins again at zero after 2^`bits`.
    pub bits: u32,
    /// Steps over which the turn is taken; the speed is half of them old.
    pub window: u32,
}

/// The largest window of an encoder, in steps.
pub const WINDOW_MAX: u32 = 16;

impl EncoderSpec {
    /// Angle of one count (rad).
    pub fn rad_per_count(&self) -> f64 {
        core::f64::consts::TAU / self.counts_per_turn
    }

    /// Speed for one count over the window, sampled every `sample_time_s` (rad/s).
    pub fn rad_s_per_count(&self, sample_time_s: f64) -> f64 {
        self.rad_per_count() / (f64::from(self.window) * sample_time_s)
    }

    /// The count after which it begins again at zero.
    pub fn wrap(&self) -> i32 {
        1 << self.bits
    }

    /// Counts over the window that it shows at most, either way: half of a wrap in each step less one count.
    pub fn most_counts(&self) -> i32 {
        (self.wrap() / 2 - 1) * self.window as i32
    }
}

impl HardwareSpec {
    /// The thesis bench: its sensors by their data sheets, ADS1015 with
    /// rpm = 8.53108 count − 6594.5 between the ends ∓6594.5 rpm of the drive's speed signal, no bias
    /// observer.
    pub fn thesis_bench() -> Self {
        let rpm = core::f64::consts::TAU / 60.0;
        HardwareSpec {
            attitude: AttitudeSpec::thesis(),
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
