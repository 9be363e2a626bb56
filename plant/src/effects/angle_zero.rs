//! A constant error of the angle sensor that differs from log to log.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, Role};
use crate::{Kind, Output, Reading, Scalar};

/// measured angle = α + b, one constant b for each log
#[derive(Clone, Copy, Debug)]
pub struct AngleZero;

impl Effect for AngleZero {
    const INFO: EffectInfo = EffectInfo {
        name: "angle-zero",
        equation: "measured angle = α + b, one constant b for each log",
        meaning: "the angle was zeroed before each log (an incremental encoder), or the rig was moved between them",
        source: "thesis 5.1, the zero of the angle sensor; here one for each log",
        fingerprint: "each free swing settles around an angle of its own",
        prior: Prior { commonness: Commonness::Occasional, reason: "an incremental encoder is zero where it was switched on" },
        role: Role::Sensor,
        parameters: &[ParameterInfo {
            name: "angle_zero/EXPERIMENT",
            unit: "rad",
            meaning: "measured minus true angle in that log",
            plausible: (-0.1, 0.1),
            bounds: (-3.2, 3.2),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[0.0]],
        absent: Some(&[0.0]),
        replaces: &["angle-offset"],
        angle_power: Some(0),
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Angle),
        per_log: Some("angle_offset"),
        drawn_since: u32::MAX,
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn distort<S: Scalar>(p: &[S], reading: &mut Reading<S>) {
        reading.angle_rad += p[0];
    }
}
