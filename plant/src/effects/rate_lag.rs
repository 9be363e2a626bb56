//! The measured rate is filtered.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, Role, Timing};
use crate::hiding::Hiding;
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
        role: Role::Sensor,
        parameters: &[ParameterInfo {
            name: "rate_lag",
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
        confused_with: &["rate-delay"],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Rate),
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
