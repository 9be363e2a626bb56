//! The measured rate is filtered.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo};
use crate::late_sensor::{LAGGING, time_constant};
use crate::{Kind, Output, Scalar};

/// T ẏ = v − y, v the rate, y = v at the first sample
#[derive(Clone, Copy, Debug)]
pub struct RateLag;

impl Effect for RateLag {
    const INFO: EffectInfo = EffectInfo {
        name: "rate-lag",
        equation: "T ẏ = v − y, v the rate, y = v at the first sample",
        meaning: "the low-pass filter of the gyroscope",
        source: "Oppenheim & Willsky, Signals and Systems (2nd ed. 1997), ch. 6.6, first-order low-pass",
        fingerprint: "the measured rate is late and a little small against the derivative of the angle, the more so the faster it changes",
        prior: Prior { commonness: Commonness::Occasional, reason: "gyroscopes have a low-pass filter that can be set far too low" },
        parameters: &[time_constant("rate_lag")],
        confused_with: &["rate-delay"],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Rate),
        ..LAGGING
    };

    #[inline(always)]
    fn lag_s<S: Scalar>(p: &[S]) -> Option<S> {
        Some(p[0])
    }
}
