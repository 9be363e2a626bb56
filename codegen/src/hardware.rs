//! The hardware around the control law: sensors and drive.

use attitude::AttitudeSpec;

/// Sensors, converter and optional bias observer. The drive is described by [`crate::spec::PwmDrive`].
#[derive(Debug, Clone, PartialEq)]
pub struct HardwareSpec {
    /// Inertial sensor, mounting and filter. Its sample time is that of the module.
    pub attitude: AttitudeSpec,
    /// Wheel speed per count of the converter (rad/s).
    pub wheel_speed_per_count: f64,
    /// Wheel speed at zero counts (rad/s).
    pub wheel_speed_at_zero: f64,
    /// Count at the lower end of the converter's range.
    pub wheel_low: u16,
    /// Count at its upper end.
    pub wheel_high: u16,
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

impl HardwareSpec {
    /// The thesis bench: its sensors by their data sheets, ADS1015 with
    /// rpm = 8.53108 count − 6594.5 between the ends ∓6594.5 rpm of the drive's speed signal, no bias
    /// observer.
    pub fn thesis_bench() -> Self {
        let rpm = core::f64::consts::TAU / 60.0;
        HardwareSpec {
            attitude: AttitudeSpec::thesis(),
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
