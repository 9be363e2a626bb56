//! A constant error of the rate sensor.

use crate::effect::{Effect, EffectInfo, Linearised, MAX_PARAMETERS, ParameterInfo, Reading, Role};
use crate::{Kind, Scalar};

/// measured rate = α̇ + b
#[derive(Clone, Copy, Debug)]
pub struct GyroBias;

impl Effect for GyroBias {
    const INFO: EffectInfo = EffectInfo {
        name: "gyro-bias",
        equation: "measured rate = α̇ + b",
        meaning: "rest bias of the gyroscope",
        source: "thesis 3.2.1",
        fingerprint: "the measured rate has a mean that the angle does not integrate",
        role: Role::Sensor,
        parameters: &[ParameterInfo {
            name: "gyro_bias",
            unit: "rad/s",
            meaning: "measured minus true rate",
            plausible: (-0.1, 0.1),
            bounds: (-5.0, 5.0),
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
        reading.rate_rad_s += p[0];
    }
}
