//! The measured rate comes late.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo};
use crate::late_sensor::{DELAYED, delay};
use crate::{Kind, Output, Scalar};

/// y(t) = α̇(t − δ)
#[derive(Clone, Copy, Debug)]
pub struct RateDelay;

impl Effect for RateDelay {
    const INFO: EffectInfo = EffectInfo {
        name: "rate-delay",
        equation: "y(t) = α̇(t − δ)",
        meaning: "a bus, or a filter with linear phase between the sensor and the clock of the log",
        source: "Åström & Wittenmark, Computer-Controlled Systems (3rd ed. 1997), ch. 2, systems with time delay",
        fingerprint: "the measured rate is late against the derivative of the angle, by the same time at every speed, and not smaller",
        prior: Prior { commonness: Commonness::Occasional, reason: "a sensor that is read by a slower loop than the others" },
        parameters: &[delay("rate_delay")],
        confused_with: &["rate-lag"],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Rate),
        ..DELAYED
    };

    #[inline(always)]
    fn delay_s<S: Scalar>(p: &[S]) -> Option<S> {
        Some(p[0])
    }
}
