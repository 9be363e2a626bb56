//! A scale error of the rate sensor.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, RateFault, Role};
use crate::hiding::Hiding;
use crate::physical::PhysicalRange;
use crate::{Kind, Output, Reading, Scalar};

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
        prior: Prior { commonness: Commonness::Occasional, reason: "data sheets allow some per cent" },
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
        physical: &[PhysicalRange {
            parameter: 0,
            over: None,
            range: (-0.3, 0.3),
            reason: "a gyroscope is within 10 % of its data sheet, and a range or unit that is set wrong is a factor of two or more",
        }],
        starts: &[&[0.0]],
        absent: Some(&[0.0]),
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Rate),
        rate_fault: Some(RateFault::Scale),
        hiding: Some(Hiding { parameters: |s, bench| vec![bench.side * s], first_guess: 1e-2, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn distort<S: Scalar>(p: &[S], reading: &mut Reading<S>) {
        reading.rate_rad_s = reading.rate_rad_s * (p[0] + 1.0);
    }
}
