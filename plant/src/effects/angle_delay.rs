//! The measured angle comes late.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo};
use crate::late_sensor::{DELAYED, delay};
use crate::{Kind, Output, Scalar};

/// y(t) = α(t − δ)
#[derive(Clone, Copy, Debug)]
pub struct AngleDelay;

impl Effect for AngleDelay {
    const INFO: EffectInfo = EffectInfo {
        name: "angle-delay",
        equation: "y(t) = α(t − δ)",
        meaning: "a camera, a bus, or a filter with linear phase between the sensor and the clock of the log",
        source: "Åström & Wittenmark, Computer-Controlled Systems (3rd ed. 1997), ch. 2, systems with time delay",
        fingerprint: "the measured angle is late against the integral of the rate, by the same time at every speed",
        prior: Prior { commonness: Commonness::Rare, reason: "encoders are read at once; cameras and attitude filters are not" },
        parameters: &[delay("angle_delay")],
        confused_with: &[],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Angle),
        ..DELAYED
    };

    #[inline(always)]
    fn delay_s<S: Scalar>(p: &[S]) -> Option<S> {
        Some(p[0])
    }
}
