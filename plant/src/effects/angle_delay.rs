//! The measured angle comes late.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, Role, Timing};
use crate::hiding::Hiding;
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
        role: Role::Sensor,
        parameters: &[ParameterInfo {
            name: "angle_delay",
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
        confused_with: &[],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Angle),
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
