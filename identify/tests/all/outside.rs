//! Effects that another crate brings along are fitted like those of the library.

use identify::{Identification, MAX_UNKNOWNS, Unknowns, Window, identify, normal};
use plant::{
    Definition, Effect, EffectId, EffectInfo, Instant, Kind, Model, ParameterInfo, Role, Scalar,
    Smoothing,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::simulated::{Now, Physics, VALUES, free_swing, problem, simulate, spin_up};

const fn parameter(name: &'static str, unit: &'static str, is_torque: bool) -> ParameterInfo {
    ParameterInfo {
        name,
        unit,
        meaning: "see the equation",
        plausible: (-1.0, 1.0),
        bounds: (f64::NEG_INFINITY, f64::INFINITY),
        is_torque,
        logarithmic: false,
        is_whole: false,
    }
}

/// z exp(−z²), the shape of the torque of a magnet beside the path.
fn bell<S: Scalar>(z: S) -> S {
    z * (-(z * z)).exp()
}

/// A magnet near the path of the body.
struct Magnet;

impl Effect for Magnet {
    const INFO: EffectInfo = EffectInfo {
        name: "magnet",
        equation: "−a z exp(−z²), z = (α − c)/w",
        role: Role::Body,
        parameters: &[
            parameter("magnet_torque", "N m", true),
            parameter("magnet_angle", "rad", false),
            parameter("magnet_width", "rad", false),
        ],
        starts: &[&[1e-3, 0.17, 0.1], &[1e-3, -0.17, 0.1]],
        absent: Some(&[0.0, 0.2, 0.1]),
        shows_in: &[Kind::FreeSwing, Kind::Driven],
        ..EffectInfo::PLAIN
    };

    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        -(p[0] * bell((at.angle_rad - p[1]) / p[2]))
    }
}

/// Two magnets of one width.
struct TwoMagnets;

impl Effect for TwoMagnets {
    const INFO: EffectInfo = EffectInfo {
        name: "two-magnets",
        equation: "−Σ aᵢ zᵢ exp(−zᵢ²), zᵢ = (α − cᵢ)/w",
        parameters: &[
            parameter("magnets_width", "rad", false),
            parameter("left_torque", "N m", true),
            parameter("left_angle", "rad", false),
            parameter("right_torque", "N m", true),
            parameter("right_angle", "rad", false),
        ],
        starts: &[&[0.12, 1e-3, -0.27, 1e-3, 0.33]],
        absent: Some(&[0.1, 0.0, -0.3, 0.0, 0.3]),
        ..Magnet::INFO
    };

    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        let one = |torque: S, place: S| torque * bell((at.angle_rad - place) / p[0]);
        -(one(p[1], p[2]) + one(p[3], p[4]))
    }
}

/// A curve of twenty-one straight pieces over the angle: more parameters than one simulation carries lanes for,
/// together with everything else.
struct Curve;

const KNOTS: usize = 22;

impl Effect for Curve {
    const INFO: EffectInfo = EffectInfo {
        name: "curve",
        equation: "Σ cⱼ max(0, 1 − |α/w − j|)",
        // Named when it is defined.
        parameters: &[],
        starts: &[&[0.0; KNOTS]],
        absent: Some(&[0.0; KNOTS]),
        ..Magnet::INFO
    };

    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        let mut torque = S::zero();
        for (index, &knot) in p.iter().enumerate() {
            let place = index as f64 - 0.5 * (KNOTS - 1) as f64;
            let near = -(at.angle_rad * 10.0 - place).abs() + 1.0;
            if near.value() > 0.0 {
                torque += knot * near;
            }
        }
        torque
    }
}

fn fitted(on_body: &(dyn Fn(&Now) -> f64 + Sync), effect: EffectId, seed: u64) -> Identification {
    let physics = Physics {
        on_body,
        ..Physics::base()
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let forward = |_: f64| 0.6;
    let records = [
        spin_up("spin-up 0.6 A", &forward, 3.0),
        free_swing("free swing 20 deg", 20f64.to_radians(), 10.0),
        free_swing("free swing 52 deg", 52f64.to_radians(), 10.0),
    ]
    .iter()
    .map(|experiment| simulate(&physics, experiment, &mut rng))
    .collect();
    let model = Model::base().with(effect);
    identify(&problem(records), &model, None).expect("a fit")
}

fn recovers(effect: EffectId, truth: &[f64], on_body: &(dyn Fn(&Now) -> f64 + Sync)) {
    for seed in [2900, 2901] {
        let found = fitted(on_body, effect, seed);
        let own = found.fit.model.range_of(effect).expect("in the model");
        for (at, &truth) in own.zip(truth) {
            let name = found.fit.model.parameters()[at].name;
            let (value, std) = (found.fit.values[at], found.fit.std(at).unwrap_or(f64::NAN));
            assert!(
                (value - truth).abs() < 4.0 * std,
                "seed {seed} {name}: {value} ± {std}, truth {truth}"
            );
            assert!(std < 0.1 * truth.abs(), "seed {seed} {name}: ± {std}");
        }
    }
}

#[test]
fn an_effect_of_three_parameters_from_outside_is_recovered() {
    let magnet = EffectId::of::<Magnet>().expect("a sound description");
    let truth = [1.5e-3, 0.15, 0.08];
    recovers(magnet, &truth, &|now: &Now| {
        truth[0] * bell((now.angle - truth[1]) / truth[2])
    });
}

#[test]
fn an_effect_of_five_parameters_from_outside_is_recovered() {
    let magnets = EffectId::of::<TwoMagnets>().expect("a sound description");
    let truth = [0.12, 1.5e-3, -0.25, 1.2e-3, 0.35];
    recovers(magnets, &truth, &|now: &Now| {
        let one = |torque: f64, place: f64| torque * bell((now.angle - place) / truth[0]);
        one(truth[1], truth[2]) + one(truth[3], truth[4])
    });
}

/// With more unknowns than one simulation carries, the normal equations are those of the parts.
#[test]
fn more_unknowns_than_one_simulation_carries_are_taken_in_parts() {
    let curve = EffectId::external("a curve of straight pieces", || {
        let named = (0..KNOTS).map(|knot| parameter(format!("knot_{knot}").leak(), "N m", true));
        Definition {
            info: EffectInfo {
                parameters: named.collect::<Vec<_>>().leak(),
                ..Curve::INFO
            },
            ..Definition::of::<Curve>()
        }
    })
    .expect("a sound description");
    let experiment = free_swing("free swing 52 deg", 52f64.to_radians(), 2.0);
    let record = simulate(
        &Physics::base(),
        &experiment,
        &mut ChaCha8Rng::seed_from_u64(1),
    );
    let model = Model::base().with(curve);
    let mut values = VALUES.to_vec();
    values.resize(model.parameter_count(), 1e-4);
    let window = Window {
        samples: 0..record.len(),
        nuisances: vec![52f64.to_radians(), 0.0],
    };
    let free: Vec<usize> = (0..values.len()).collect();
    let unknowns = Unknowns::new(&model, &free);
    // Wheel inertia, torque constant and wheel friction do not show.
    let globals: Vec<usize> = free
        .iter()
        .copied()
        .filter(|at| ![1, 3, 5].contains(at))
        .collect();
    assert!(globals.len() + window.nuisances.len() > MAX_UNKNOWNS);
    let whole = normal(&record, &window, &model, &values, &unknowns, &globals);
    for part in globals.chunks(7) {
        let own = normal(&record, &window, &model, &values, &unknowns, part);
        assert!((own.cost - whole.cost).abs() < 1e-9 * whole.cost);
        for (row, at) in part.iter().enumerate() {
            let to_row = globals
                .iter()
                .position(|global| global == at)
                .expect("a part");
            for (column, at) in part.iter().enumerate() {
                let to_column = globals
                    .iter()
                    .position(|global| global == at)
                    .expect("a part");
                let (a, b) = (
                    own.hessian[(row, column)],
                    whole.hessian[(to_row, to_column)],
                );
                assert!((a - b).abs() <= 1e-9 * a.abs(), "{at}: {a} {b}");
            }
            let (a, b) = (own.gradient[row], whole.gradient[to_row]);
            assert!((a - b).abs() <= 1e-9 * a.abs() + 1e-9, "{a} {b}");
        }
    }
}
