//! The measured speed of the wheel is filtered.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo};
use crate::late_sensor::{LAGGING, time_constant};
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
        parameters: &[time_constant("wheel_speed_lag")],
        confused_with: &["wheel-speed-delay", "motor-lag"],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        senses: Some(Output::WheelSpeed),
        ..LAGGING
    };

    #[inline(always)]
    fn lag_s<S: Scalar>(p: &[S]) -> Option<S> {
        Some(p[0])
    }
}
