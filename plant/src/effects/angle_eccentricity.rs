//! The scale of the angle sensor does not turn about the pivot.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, Role};
use crate::hiding::Hiding;
use crate::physical::PhysicalRange;
use crate::{Kind, Output, Reading, Scalar};

/// measured angle = α + e sin(α + ψ)
#[derive(Clone, Copy, Debug)]
pub struct AngleEccentricity;

impl Effect for AngleEccentricity {
    const INFO: EffectInfo = EffectInfo {
        name: "angle-eccentricity",
        equation: "measured angle = α + e sin(α + ψ)",
        meaning: "the disc or magnet of the encoder is mounted beside the axis of the pivot",
        source: "Ernst, Digital Length and Angle Measurement Technology (1989), angle encoders: eccentricity of the graduation",
        fingerprint: "the measured angle runs ahead on one side and behind on the other, once a turn, against rate and gravity",
        prior: Prior { commonness: Commonness::Occasional, reason: "a disc or magnet that was mounted by hand is off centre by some hundredths of its radius" },
        role: Role::Sensor,
        parameters: &[ParameterInfo {
            name: "angle_eccentricity",
            unit: "rad",
            meaning: "amplitude e: distance of the two axes over the radius of the scale",
            plausible: (1e-4, 0.1),
            bounds: (0.0, 0.9),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        },
        ParameterInfo {
            name: "eccentricity_phase",
            unit: "rad",
            meaning: "phase ψ",
            plausible: (-std::f64::consts::PI, std::f64::consts::PI),
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        physical: &[PhysicalRange {
            parameter: 0,
            over: None,
            range: (0.0, 0.3),
            reason: "it is the displacement of the axis in radii of the disc",
        }],
        // An amplitude of 1 mrad, which is usual for encoders, with three phases a third of a turn
        // apart.
        starts: &[&[1e-3, 0.0], &[1e-3, 2.1], &[1e-3, -2.1]],
        absent: Some(&[0.0, 0.0]),
        confused_with: &["angle-offset"],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        senses: Some(Output::Angle),
        polar: Some((0, 1)),
        drawn_since: 1,
        hiding: Some(Hiding {
            parameters: |s, bench| vec![s, std::f64::consts::PI * bench.second],
            first_guess: 1e-2,
            beyond_plausible: false,
        }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn distort<S: Scalar>(p: &[S], reading: &mut Reading<S>) {
        let ahead = p[0] * (reading.angle_rad + p[1]).sin();
        reading.angle_rad += ahead;
    }
}
