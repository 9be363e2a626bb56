//! The measured speed of the wheel comes late.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo};
use crate::late_sensor::{DELAYED, delay};
use crate::{Kind, Output, Scalar};

/// y(t) = φ̇(t − δ)
#[derive(Clone, Copy, Debug)]
pub struct WheelSpeedDelay;

impl Effect for WheelSpeedDelay {
    const INFO: EffectInfo = EffectInfo {
        name: "wheel-speed-delay",
        equation: "y(t) = φ̇(t − δ)",
        meaning: "a speed that is counted over a window, or sent over a bus",
        source: "Åström & Wittenmark, Computer-Controlled Systems (3rd ed. 1997), ch. 2, systems with time delay",
        fingerprint: "the measured speed answers a step of the command late, while the body feels the torque at once",
        prior: Prior { commonness: Commonness::Occasional, reason: "a speed over a window of counts is late by half the window" },
        parameters: &[delay("wheel_speed_delay")],
        confused_with: &["wheel-speed-lag", "input-delay"],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        senses: Some(Output::WheelSpeed),
        ..DELAYED
    };

    #[inline(always)]
    fn delay_s<S: Scalar>(p: &[S]) -> Option<S> {
        Some(p[0])
    }
}
