//! A torque that was learned from the logs: a smooth curve over one coordinate of the motion.
//!
//! A learned torque stands in for physics that no effect of the library describes; it does not explain this physics.
//! Its parameters are the torques in N m at the knots of a cubic spline ([`Spline`]).

use std::sync::{Mutex, PoisonError};

use nalgebra::DMatrix;

use crate::effect::{EffectInfo, Instant, Linearised, ParameterInfo, Role, Smoothing};
use crate::external::{Definition, ExternalEffect, Partials};
use crate::learned_curve::{FEWEST_KNOTS, LearnedCoordinate, LearnedCurve, MOST_KNOTS};
use crate::spline::Spline;
use crate::{EffectId, Kind};

impl LearnedCoordinate {
    /// Where the torque acts.
    pub fn role(self) -> Role {
        match self {
            LearnedCoordinate::Angle | LearnedCoordinate::Rate => Role::Body,
            LearnedCoordinate::WheelSpeed | LearnedCoordinate::WheelAngle => Role::Wheel,
        }
    }

    /// The coordinate at an instant.
    pub fn of<S: Copy>(self, at: &Instant<S>) -> S {
        match self {
            LearnedCoordinate::Angle => at.angle_rad,
            LearnedCoordinate::Rate => at.rate_rad_s,
            LearnedCoordinate::WheelSpeed => at.wheel_speed_rad_s,
            LearnedCoordinate::WheelAngle => at.wheel_angle_rad,
        }
    }

    fn part(self, at: &mut Instant<f64>) -> &mut f64 {
        match self {
            LearnedCoordinate::Angle => &mut at.angle_rad,
            LearnedCoordinate::Rate => &mut at.rate_rad_s,
            LearnedCoordinate::WheelSpeed => &mut at.wheel_speed_rad_s,
            LearnedCoordinate::WheelAngle => &mut at.wheel_angle_rad,
        }
    }
}

impl LearnedCurve {
    /// The effect: a torque in N m on body or wheel, with one parameter for each knot. `None` with fewer knots than
    /// [`FEWEST_KNOTS`], more than [`MOST_KNOTS`], or knots that do not increase.
    pub fn effect(
        coordinate: LearnedCoordinate,
        knots: &[f64],
        penalty: Option<DMatrix<f64>>,
    ) -> Option<EffectId> {
        if !(FEWEST_KNOTS..=MOST_KNOTS).contains(&knots.len()) {
            return None;
        }
        let spline = Spline::new(knots, coordinate.period())?;
        let numbers = penalty.iter().flat_map(|matrix| matrix.iter());
        let bits: Vec<u64> = knots
            .iter()
            .chain(numbers)
            .map(|number| number.to_bits())
            .collect();
        let content = format!("{} {bits:x?}", coordinate.effect_name());
        let curve = LearnedCurve {
            coordinate,
            spline,
            penalty,
        };
        EffectId::external(&content, || definition(curve)).ok()
    }
}

/// The name of the parameter of knot number `knot`, counted from 0. Each name is leaked only once.
fn parameter_name(coordinate: LearnedCoordinate, knot: usize) -> &'static str {
    static NAMES: Mutex<Vec<(LearnedCoordinate, usize, &'static str)>> = Mutex::new(vec![]);
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    let known = names
        .iter()
        .find(|(of, at, _)| (*of, *at) == (coordinate, knot));
    if let Some((_, _, name)) = known {
        return name;
    }
    let name: &'static str = format!("learned_{}_{}", coordinate.name(), knot + 1).leak();
    names.push((coordinate, knot, name));
    name
}

fn definition(curve: LearnedCurve) -> Definition {
    let coordinate = curve.coordinate;
    let knots = curve.spline.knots();
    let parameters: Vec<ParameterInfo> = (0..knots.len())
        .map(|knot| ParameterInfo {
            name: parameter_name(coordinate, knot),
            unit: "N m",
            meaning: format!(
                "torque where {} is {:.4} {}",
                coordinate.words(),
                knots[knot],
                coordinate.unit()
            )
            .leak(),
            plausible: (f64::NEG_INFINITY, f64::INFINITY),
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        })
        .collect();
    let zeros: &'static [f64] = vec![0.0; knots.len()].leak();
    let shows_in: &'static [Kind] = match coordinate.role() {
        Role::Wheel => &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        _ => &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
    };
    let curve: &'static LearnedCurve = Box::leak(Box::new(curve));
    let text: &'static str = format!(
        "a smooth torque over {} that was learned from the logs; it explains nothing",
        coordinate.words()
    )
    .leak();
    Definition {
        info: EffectInfo {
            name: coordinate.effect_name(),
            equation: "Σ c_j B_j(s), cubic B-splines",
            meaning: text,
            source: "de Boor, A Practical Guide to Splines (2001), ch. XIV",
            fingerprint: text,
            role: coordinate.role(),
            parameters: parameters.leak(),
            starts: vec![zeros].leak(),
            absent: Some(zeros),
            shows_in,
            linearised: match coordinate {
                // The turn of the wheel is no state of the controller.
                LearnedCoordinate::WheelAngle => Linearised::LeftOut,
                _ => Linearised::Exactly,
            },
            uses_wheel_angle: coordinate == LearnedCoordinate::WheelAngle,
            learned: Some(curve),
            ..EffectInfo::PLAIN
        },
        equations: Box::new(LearnedTorque(curve)),
    }
}

/// The torque of a learned curve, against the motion.
struct LearnedTorque(&'static LearnedCurve);

impl ExternalEffect for LearnedTorque {
    fn torque(
        &self,
        p: &[f64],
        at: &Instant<f64>,
        _v0: &Smoothing,
        partials: &mut Partials,
    ) -> f64 {
        let LearnedCurve {
            coordinate, spline, ..
        } = self.0;
        let (mut weights, mut slopes) = ([0.0; MOST_KNOTS], [0.0; MOST_KNOTS]);
        let (weights, slopes) = (&mut weights[..p.len()], &mut slopes[..p.len()]);
        spline.weights(coordinate.of(at), weights, slopes);
        let (mut torque, mut slope) = (0.0, 0.0);
        for (index, value) in p.iter().enumerate() {
            torque += weights[index] * value;
            slope += slopes[index] * value;
            partials.p[index] = -weights[index];
        }
        *coordinate.part(&mut partials.at) = -slope;
        -torque
    }
}
