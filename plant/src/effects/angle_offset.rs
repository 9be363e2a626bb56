//! A constant error of the angle sensor.

use crate::effect::{Effect, EffectInfo, Linearised, MAX_PARAMETERS, ParameterInfo, Reading, Role};
use crate::{Kind, Scalar};

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
        replaces: &[],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        has_kink: false,
        product: None,
        limit: None,
        linearised: Linearised::LeftOut,
    };

    #[inline(always)]
    fn distort<S: Scalar>(p: &[S; MAX_PARAMETERS], reading: &mut Reading<S>) {
        reading.angle_rad += p[0];
    }
}
