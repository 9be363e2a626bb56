//! The measured rate comes late.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, Role, Timing};
use crate::hiding::Hiding;
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
        role: Role::Sensor,
        parameters: &[ParameterInfo {
            name: "rate_delay",
            unit: "s",
            meaning: "delay δ",
            plausible: (2e-4, 0.1),
            bounds: (0.0, 1.0),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[0.0]],
        absent: Some(&[0.0]),
        confused_with: &["rate-lag"],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Rate),
        sensor_timing: Some(Timing::Delay),
        drawn_since: 1,
        hiding: Some(Hiding { parameters: |s, _| vec![s], first_guess: 5e-3, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn delay_s<S: Scalar>(p: &[S]) -> Option<S> {
        Some(p[0])
    }
}
