//! A scale error of the rate sensor.

use crate::effect::{Effect, EffectInfo, Linearised, MAX_PARAMETERS, ParameterInfo, Reading, Role};
use crate::{Kind, Scalar};

/// measured rate = (1 + s) α̇
#[derive(Clone, Copy, Debug)]
pub struct GyroScale;

impl Effect for GyroScale {
    const INFO: EffectInfo = EffectInfo {
        name: "gyro-scale",
        equation: "measured rate = (1 + s) α̇",
        meaning: "sensitivity tolerance of the gyroscope",
        source: "thesis 3.2.1",
        fingerprint: "the measured rate is a fixed fraction larger or smaller than the derivative of the angle",
        role: Role::Sensor,
        parameters: &[ParameterInfo {
            name: "gyro_scale_error",
            unit: "1",
            meaning: "relative error of the sensitivity",
            plausible: (-0.1, 0.1),
            bounds: (-0.9, 2.0),
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
        reading.rate_rad_s = reading.rate_rad_s * (p[0] + 1.0);
    }
}
