//! Effects that another crate defines.

use plant::{
    Definition, Effect, EffectId, EffectInfo, ExternalEffect, ExternalError, Instant, Kind, Model,
    Output, ParameterInfo, Partials, Plant, Reading, Role, Scalar, Smoothing, State,
};

use crate::sensitivities::agree_with_finite_differences;
use crate::{VALUES, swing};

const fn parameter(name: &'static str, unit: &'static str) -> ParameterInfo {
    ParameterInfo {
        name,
        unit,
        meaning: "see the equation",
        plausible: (-10.0, 10.0),
        bounds: (f64::NEG_INFINITY, f64::INFINITY),
        is_torque: false,
        logarithmic: false,
        is_whole: false,
    }
}

/// A magnet near the path of the body: a z exp(−z²) with z = (α − c)/w, by the ordinary trait.
struct Magnet;

impl Effect for Magnet {
    const INFO: EffectInfo = EffectInfo {
        name: "magnet",
        equation: "−a z exp(−z²), z = (α − c)/w",
        role: Role::Body,
        parameters: &[
            parameter("magnet_torque", "N m"),
            parameter("magnet_angle", "rad"),
            parameter("magnet_width", "rad"),
        ],
        starts: &[&[1e-3, 0.1, 0.1]],
        shows_in: &[Kind::FreeSwing, Kind::Driven],
        ..EffectInfo::PLAIN
    };

    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        let z = (at.angle_rad - p[1]) / p[2];
        -(p[0] * z * (-(z * z)).exp())
    }
}

/// The same magnet with derivatives by hand.
struct MagnetByHand;

impl ExternalEffect for MagnetByHand {
    fn torque(
        &self,
        p: &[f64],
        at: &Instant<f64>,
        _v0: &Smoothing,
        partials: &mut Partials,
    ) -> f64 {
        let z = (at.angle_rad - p[1]) / p[2];
        let bell = (-z * z).exp();
        let slope = -p[0] * (1.0 - 2.0 * z * z) * bell;
        partials.at.angle_rad = slope / p[2];
        partials.p[0] = -z * bell;
        partials.p[1] = -slope / p[2];
        partials.p[2] = -slope * z / p[2];
        -p[0] * z * bell
    }
}

/// A torque on the wheel with five parameters that depends on everything.
struct Five;

impl Effect for Five {
    const INFO: EffectInfo = EffectInfo {
        name: "five",
        equation: "a tanh(φ̇/b) + c sin(φ + d) + e α α̇",
        role: Role::Wheel,
        parameters: &[
            parameter("five_a", "N m"),
            parameter("five_b", "rad/s"),
            parameter("five_c", "N m"),
            parameter("five_d", "rad"),
            parameter("five_e", "N m s/rad2"),
        ],
        starts: &[&[1e-3, 10.0, 1e-3, 0.0, 0.0]],
        shows_in: &[Kind::Driven],
        uses_wheel_angle: true,
        ..EffectInfo::PLAIN
    };

    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        p[0] * (at.wheel_speed_rad_s / p[1]).tanh()
            + p[2] * (at.wheel_angle_rad + p[3]).sin()
            + p[4] * at.angle_rad * at.rate_rad_s
    }
}

/// A motor whose torque falls with its speed.
struct Fading;

impl Effect for Fading {
    const INFO: EffectInfo = EffectInfo {
        name: "fading",
        equation: "torque = τ i/(1 + (φ̇/s)²)",
        role: Role::Motor,
        parameters: &[parameter("fading_speed", "rad/s")],
        starts: &[&[300.0]],
        shows_in: &[Kind::Driven],
        ..EffectInfo::PLAIN
    };

    fn current<S: Scalar>(p: &[S], current_a: S, at: &Instant<S>, _torque_constant: S) -> S {
        let ratio = at.wheel_speed_rad_s / p[0];
        current_a / (ratio * ratio + 1.0)
    }
}

/// A further torque of the motor that is proportional to the current.
struct MoreTorque;

impl Effect for MoreTorque {
    const INFO: EffectInfo = EffectInfo {
        name: "more-torque",
        equation: "−k i",
        role: Role::Wheel,
        parameters: &[parameter("more_torque_constant", "N m/A")],
        starts: &[&[1e-3]],
        shows_in: &[Kind::Driven],
        ..EffectInfo::PLAIN
    };

    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        -(p[0] * at.current_a)
    }
}

/// An encoder whose disc is not centred.
struct Eccentric;

impl Effect for Eccentric {
    const INFO: EffectInfo = EffectInfo {
        name: "eccentric",
        equation: "measured angle = α + e sin(α + ψ)",
        role: Role::Sensor,
        senses: Some(Output::Angle),
        parameters: &[
            parameter("eccentricity", "rad"),
            parameter("eccentricity_phase", "rad"),
        ],
        starts: &[&[1e-3, 0.0]],
        shows_in: &[Kind::FreeSwing, Kind::Driven],
        ..EffectInfo::PLAIN
    };

    fn distort<S: Scalar>(p: &[S], reading: &mut Reading<S>) {
        reading.angle_rad += p[0] * (reading.angle_rad + p[1]).sin();
    }
}

fn magnet_by_hand() -> EffectId {
    let define = || Definition {
        info: EffectInfo {
            name: "magnet-by-hand",
            ..Magnet::INFO
        },
        equations: Box::new(MagnetByHand),
    };
    EffectId::external("a magnet by hand", define).expect("a sound definition")
}

#[test]
fn an_effect_from_outside_is_differentiated_like_one_of_the_library() {
    let magnet = EffectId::of::<Magnet>().expect("a sound description");
    for effect in [magnet, magnet_by_hand()] {
        agree_with_finite_differences(effect, &[4e-3, 0.1, 0.08]);
    }
    let five = EffectId::of::<Five>().expect("a sound description");
    agree_with_finite_differences(five, &[2e-3, 30.0, 1e-3, 0.4, 1e-3]);
    let fading = EffectId::of::<Fading>().expect("a sound description");
    agree_with_finite_differences(fading, &[80.0]);
    let more = EffectId::of::<MoreTorque>().expect("a sound description");
    agree_with_finite_differences(more, &[3e-3]);
    let eccentric = EffectId::of::<Eccentric>().expect("a sound description");
    agree_with_finite_differences(eccentric, &[0.01, 0.3]);
}

/// A magnet conserves the energy of a swing, but changes its period.
#[test]
fn a_magnet_takes_no_energy_from_the_swing() {
    let values = [
        &[VALUES[0], VALUES[1], VALUES[2], VALUES[3], 0.0, 0.0],
        &[4e-3, 0.1, 0.08][..],
    ];
    for effect in [EffectId::of::<Magnet>().expect("sound"), magnet_by_hand()] {
        let model = Model::base().with(effect);
        let plant = Plant::new(&model, &values.concat(), Kind::FreeSwing);
        let states = swing(&plant, 0.3, 1e-3, 1500);
        let (a, w) = (4e-3, 0.08);
        // −a z exp(−z²) against the motion is the slope of a w exp(−z²)/2.
        let energy = |state: &State<f64>| {
            let z = (state.angle_rad - 0.1) / w;
            0.5 * VALUES[0] * state.rate_rad_s.powi(2) - VALUES[2] * state.angle_rad.cos()
                + 0.5 * a * w * (-z * z).exp()
        };
        let first = energy(&states[0]);
        let swing_j = VALUES[2] * (1.0 - 0.3f64.cos());
        for state in &states {
            assert!((energy(state) - first).abs() < 1e-6 * swing_j, "{effect:?}");
        }
        let plain = Plant::new(&Model::base(), values[0], Kind::FreeSwing);
        let other = swing(&plain, 0.3, 1e-3, 1500);
        assert!((other[1500].angle_rad - states[1500].angle_rad).abs() > 1e-3);
    }
}

/// A torque k i beside τ i is a torque constant of τ + k, also behind a motor that saturates, and in the linear model.
#[test]
fn a_torque_on_the_current_is_a_larger_torque_constant() {
    let more = EffectId::of::<MoreTorque>().expect("sound");
    let model = Model::base().with(EffectId::MotorSaturation);
    let (saturation, k) = (1.5, 4e-3);
    let with = {
        let model = model.with(more);
        let mut values = VALUES.to_vec();
        values.resize(model.parameters().len(), 0.0);
        values[model.position(EffectId::MotorSaturation).expect("added")] = saturation;
        values[model.position(more).expect("added")] = k;
        (model, values)
    };
    let larger = {
        let mut values = VALUES.to_vec();
        values[plant::TORQUE_CONSTANT] += k;
        values.push(saturation);
        (model, values)
    };
    let state = State {
        angle_rad: 3.0,
        rate_rad_s: 0.4,
        wheel_speed_rad_s: 50.0,
        ..State::rest()
    };
    for kind in [Kind::FreeSwing, Kind::SpinUp, Kind::Balance, Kind::Driven] {
        for current_a in [-2.0, 0.0, 0.7] {
            let [a, b] = [&with, &larger].map(|(model, values)| {
                Plant::new(model, values, kind).derivative(&state, current_a, 0.0)
            });
            let off = (a.0 - b.0).abs() + (a.1 - b.1).abs();
            assert!(off < 1e-9, "{kind:?} {current_a}: {a:?} {b:?}");
        }
    }
}

#[test]
fn equal_definitions_are_one_effect() {
    let one = EffectId::of::<Magnet>().expect("sound");
    assert_eq!(one, EffectId::of::<Magnet>().expect("sound"));
    assert_eq!(magnet_by_hand(), magnet_by_hand());
    assert_ne!(one, magnet_by_hand());
    // External effects come after those of the library, in any order of adding.
    let model = Model::base().with(one).with(EffectId::GyroBias);
    assert_eq!(model.effects().last(), Some(&one));
    assert_eq!(model.range_of(one).map(|own| own.len()), Some(3));
    let at = model.position(one).expect("added");
    assert_eq!(model.effect_at(at + 2), Some(one));
    assert_eq!(model.effect_at(plant::TORQUE_CONSTANT), None);
}

#[test]
fn a_description_that_contradicts_itself_is_refused() {
    let with = |content: &str, info: EffectInfo| {
        EffectId::external(content, || Definition {
            info,
            equations: Box::new(MagnetByHand),
        })
    };
    let taken = EffectInfo {
        name: "wheel-cogging",
        ..Magnet::INFO
    };
    let error = with("name of the library", taken).expect_err("taken");
    assert!(matches!(error, ExternalError::NameTaken { .. }));
    let short = EffectInfo {
        starts: &[&[1e-3]],
        ..Magnet::INFO
    };
    let sensor = EffectInfo {
        role: Role::Sensor,
        ..Magnet::INFO
    };
    const OF_THE_BASE_MODEL: &[plant::ParameterInfo] = &[
        parameter("gravity_torque", "N m"),
        parameter("magnet_angle", "rad"),
        parameter("magnet_width", "rad"),
    ];
    let base = EffectInfo {
        parameters: OF_THE_BASE_MODEL,
        ..Magnet::INFO
    };
    for (content, info) in [
        ("too short a start", short),
        ("no sensor", sensor),
        ("a base parameter", base),
    ] {
        let error = with(content, info).expect_err("incomplete");
        assert!(matches!(error, ExternalError::Incomplete { .. }), "{error}");
    }
}
