//! The measured speed of the wheel is filtered.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, Role, Timing};
use crate::hiding::Hiding;
use crate::{Kind, Output, Scalar};

/// T ẏ = v − y, v the speed of the wheel, y = v at the first sample
#[derive(Clone, Copy, Debug)]
pub struct WheelSpeedLag;

impl Effect for WheelSpeedLag {
    const INFO: EffectInfo = EffectInfo {
        name: "wheel-speed-lag",
        equation: "T ẏ = v − y, v the speed of the wheel, y = v at the first sample",
        meaning: "the filter of the speed output of a drive, or a speed that is averaged from the counts of an encoder",
        source: "Oppenheim & Willsky, Signals and Systems (2nd ed. 1997), ch. 6.6, first-order low-pass",
        fingerprint: "after a step of the command the measured speed rises gradually, while the body feels the torque at once",
        prior: Prior { commonness: Commonness::Occasional, reason: "speeds from commutation or counts are filtered" },
        role: Role::Sensor,
        parameters: &[ParameterInfo {
            name: "wheel_speed_lag",
            unit: "s",
            meaning: "time constant T",
            plausible: (2e-4, 0.1),
            bounds: (0.0, 10.0),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[0.0]],
        absent: Some(&[0.0]),
        confused_with: &["wheel-speed-delay", "motor-lag"],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        senses: Some(Output::WheelSpeed),
        sensor_timing: Some(Timing::Lag),
        drawn_since: 1,
        hiding: Some(Hiding { parameters: |s, _| vec![s], first_guess: 5e-3, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn lag_s<S: Scalar>(p: &[S]) -> Option<S> {
        Some(p[0])
    }
}
