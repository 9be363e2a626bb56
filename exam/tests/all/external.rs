//! An effect that is defined outside of this program: the exam hides it, the diagnosis fits and names it.

use std::sync::Arc;

use diagnose::Verdict;
use exam::{Answer, Mark, StatedTorque, TrueInstant, draw_stated, mark};
use identify::Progress;
use plant::{
    Effect, EffectId, EffectInfo, Hiding, Instant, Kind, Linearised, ParameterInfo, Role, Scalar,
    Smoothing,
};

/// A magnet on the body that passes a magnet on the frame: a z exp(−z²), z = (α − β)/w.
#[derive(Clone, Copy, Debug)]
struct Magnet;

const fn parameter(
    name: &'static str,
    unit: &'static str,
    plausible: (f64, f64),
    bounds: (f64, f64),
    is_torque: bool,
) -> ParameterInfo {
    ParameterInfo {
        name,
        unit,
        meaning: name,
        plausible,
        bounds,
        is_torque,
        logarithmic: false,
        is_whole: false,
    }
}

impl Effect for Magnet {
    const INFO: EffectInfo = EffectInfo {
        name: "test-magnet",
        equation: "a z exp(−z²), z = (α − β)/w",
        meaning: "a magnet passes another one",
        source: "this test",
        fingerprint: "a kink in the swing at one angle",
        role: Role::Body,
        parameters: &[
            parameter("magnet_torque", "N m", (1e-5, 1e-1), (-10.0, 10.0), true),
            parameter("magnet_angle", "rad", (-0.5, 0.5), (-1.0, 1.0), false),
            parameter("magnet_width", "rad", (0.02, 0.3), (0.02, 0.5), false),
        ],
        starts: &[
            &[1e-4, 0.1, 0.08],
            &[1e-4, -0.1, 0.08],
            &[1e-4, 0.2, 0.08],
            &[1e-4, -0.2, 0.08],
        ],
        shows_in: &[Kind::FreeSwing, Kind::Driven],
        linearised: Linearised::LeftOut,
        hiding: Some(Hiding {
            parameters: |s, bench| {
                let angle = bench.side * bench.between(0.05, 0.3);
                vec![bench.gravity_torque * s, angle, 0.06 + 0.02 * bench.second]
            },
            first_guess: 1e-2,
            beyond_plausible: false,
        }),
        ..EffectInfo::PLAIN
    };

    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        let z = (at.angle_rad - p[1]) / p[2];
        p[0] * z * (-(z * z)).exp()
    }
}

#[test]
fn an_effect_from_outside_is_hidden_fitted_and_named() {
    let effect = EffectId::of::<Magnet>().expect("a sound description");
    // The exam's own statement of the torque.
    let torque = StatedTorque {
        on_body: true,
        torque: Arc::new(|p: &[f64], at: &TrueInstant| {
            let z = (at.angle_rad - p[1]) / p[2];
            p[0] * z / (z * z).exp()
        }),
    };
    let bench = draw_stated(3, effect, &torque).expect("a bench");
    assert!((0.9..33.2).contains(&bench.sizes[0]), "{:?}", bench.sizes);
    let answer = Answer::of(&bench);
    assert_eq!(answer.effects, [effect]);
    let paper = mark(
        &bench.problem,
        &answer,
        &bench.suspects,
        &Progress::silent(),
    )
    .expect("a verdict");
    assert_eq!(paper.verdict, Verdict::Explained);
    assert_eq!(paper.named, [effect]);
    assert_eq!(paper.mark, Mark::Right);
    assert_eq!(paper.intervals.len(), 3);
    for interval in &paper.intervals {
        assert!(
            (interval.value - interval.truth).abs() < 4.0 * interval.std,
            "{interval:?}"
        );
    }
}
