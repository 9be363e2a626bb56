//! A constant error of the angle sensor.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, Role, StartFrom};
use crate::hiding::Hiding;
use crate::{Kind, Output, Reading, Scalar};

/// measured angle = α + b
#[derive(Clone, Copy, Debug)]
pub struct AngleOffset;

impl Effect for AngleOffset {
    const INFO: EffectInfo = EffectInfo {
        name: "angle-offset",
        equation: "measured angle = α + b",
        meaning: "the zero of the angle sensor is not the vertical",
        source: "thesis 5.1",
        fingerprint: "a free swing settles around an angle that is not zero; the balancing wheel settles at a speed that is not zero",
        prior: Prior { commonness: Commonness::Usual, reason: "the zero of an angle sensor is set by hand" },
        role: Role::Sensor,
        parameters: &[ParameterInfo {
            name: "angle_offset",
            unit: "rad",
            meaning: "measured minus true angle",
            plausible: (-0.1, 0.1),
            bounds: (-3.2, 3.2),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[0.0]],
        absent: Some(&[0.0]),
        confused_with: &["body-cable-spring", "angle-eccentricity"],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Angle),
        angle_power: Some(0),
        start_from: StartFrom::AngleZero,
        hiding: Some(Hiding { parameters: |s, bench| vec![bench.side * s], first_guess: 5e-3, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn distort<S: Scalar>(p: &[S], reading: &mut Reading<S>) {
        reading.angle_rad += p[0];
    }
}
