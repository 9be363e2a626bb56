//! The hardware around the control law: sensors in, drive out.

use attitude::AttitudeSpec;

/// Sensors, converter and optional bias observer; the drive stands in [`crate::spec::PwmDrive`].
#[derive(Debug, Clone, PartialEq)]
pub struct HardwareSpec {
    /// Inertial sensor, mounting and filter. Its sample time is that of the module.
    pub attitude: AttitudeSpec,
    /// Wheel speed per count of the converter (rad/s).
    pub wheel_speed_per_count: f64,
    /// Wheel speed at zero counts (rad/s).
    pub wheel_speed_at_zero: f64,
    /// Finds a constant bias of the angle, which would keep the wheel turning; off if `None`.
    pub bias_observer: Option<BiasObserverSpec>,
}

impl HardwareSpec {
    /// The thesis bench: its sensors by their data sheets, ADS1015 with
    /// rpm = 8.53108 count − 6594.5, no bias observer.
    pub fn thesis_bench() -> Self {
        let rpm = core::f64::consts::TAU / 60.0;
        HardwareSpec {
            attitude: AttitudeSpec::thesis(),
            wheel_speed_per_count: 8.53108 * rpm,
            wheel_speed_at_zero: -6594.5 * rpm,
            bias_observer: None,
        }
    }
}

/// An observer of the angle's bias: b = z + `direct` y, z' = `decay` z + `from_states` y +
/// `from_current` u, with y = (angle, rate, wheel speed) as measured and u the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BiasObserverSpec {
    /// Without unit, within (−1, 1).
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
