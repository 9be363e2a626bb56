//! A constant error of the rate sensor.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, RateFault, Role};
use crate::hiding::Hiding;
use crate::physical::PhysicalRange;
use crate::{Kind, Output, Reading, Scalar};

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
        prior: Prior { commonness: Commonness::Usual, reason: "every gyroscope has one, and it moves with temperature" },
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
        physical: &[PhysicalRange {
            parameter: 0,
            over: None,
            range: (-0.5, 0.5),
            reason: "data sheets bound the zero-rate output by 20 deg/s, 0.35 rad/s",
        }],
        starts: &[&[0.0]],
        absent: Some(&[0.0]),
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Rate),
        rate_fault: Some(RateFault::Bias),
        hiding: Some(Hiding { parameters: |s, bench| vec![bench.side * s], first_guess: 1e-2, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn distort<S: Scalar>(p: &[S], reading: &mut Reading<S>) {
        reading.rate_rad_s += p[0];
    }
}
