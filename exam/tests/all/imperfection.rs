//! The error that a model's smoothed dry friction causes is not taken for a missing effect.

use diagnose::{Verdict, imperfection};
use exam::{Answer, Mark, draw, fitted, mark};
use identify::{Effort, Output, Progress, identify};
use plant::{EffectId, Kind, Model};

/// Benches whose dry friction really sticks, as the exam simulates it, with a balance log in which the body stops
/// often. The error of the smoothed sign in this log is predicted from the model alone.
#[test]
fn the_misfit_of_a_smoothed_sign_is_predicted() {
    for seed in [326, 520] {
        let bench = draw(seed).expect("a bench");
        let answer = Answer::of(&bench);
        let problem = &bench.problem;
        let base = identify(problem, &Model::base(), None).expect("a fit").fit;
        let records = problem.all_records();
        let truth = fitted(problem, &base.minimum, &answer.effects, &answer);
        let found = imperfection(problem, &records, &truth, Effort::ROUGH);
        let mut imperfection = found.rms_over_noise.iter();
        for (record, traces) in records.iter().zip(&truth.traces) {
            for (channel, trace) in record.channels.iter().zip(traces) {
                let predicted = *imperfection.next().expect("one for each series");
                let place = format!("seed {seed}, {}", record.name);
                if record.kind == Kind::Balance && channel.output == Output::Angle {
                    let misfit = (trace.rmse / channel.noise_std).powi(2) - 1.0;
                    let share = predicted / misfit.max(0.0).sqrt();
                    assert!((0.6..1.1).contains(&share), "{place}: {share}");
                } else if record.kind == Kind::SpinUp {
                    assert!(predicted < 0.05, "{place}: {predicted}");
                }
            }
        }
    }
}

/// A wheel that sticks, in logs that show it only in motion. A dead zone of the motor takes the same torque away, but
/// has no smoothed sign: the two must tie.
#[test]
fn dry_friction_loses_no_tie_by_its_smoothed_sign() {
    let bench = draw(4006).expect("a bench");
    let answer = Answer::of(&bench);
    assert_eq!(answer.effects, [EffectId::WheelCoulombFriction]);
    let paper =
        mark(&bench.problem, &answer, EffectId::ALL, &Progress::silent()).expect("a verdict");
    assert_eq!(paper.verdict, Verdict::Ambiguous);
    for effect in [EffectId::WheelCoulombFriction, EffectId::MotorDeadZone] {
        assert!(
            paper.ambiguous_between.contains(&vec![effect]),
            "{:?}",
            paper.ambiguous_between
        );
    }
    // The predicted error of the smoothed sign is part of the residuals sample by sample: without it they are smaller.
    let problem = &bench.problem;
    let base = identify(problem, &Model::base(), None).expect("a fit").fit;
    let truth = fitted(problem, &base.minimum, &answer.effects, &answer);
    let without = imperfection(problem, &problem.all_records(), &truth, Effort::ROUGH).rmse_without;
    let own = truth.rmse();
    assert_eq!(without.len(), own.len());
    assert!(
        without
            .iter()
            .zip(&own)
            .any(|(without, own)| *without < 0.995 * own),
        "{without:?} of {own:?}"
    );
}

#[test]
fn without_dry_friction_there_is_none() {
    let bench = draw(3).expect("a bench");
    let answer = Answer::of(&bench);
    assert_eq!(answer.effects, [EffectId::BodyQuadraticDrag]);
    let problem = &bench.problem;
    let base = identify(problem, &Model::base(), None).expect("a fit").fit;
    let truth = fitted(problem, &base.minimum, &answer.effects, &answer);
    let imperfection =
        imperfection(problem, &problem.all_records(), &truth, Effort::ROUGH).rms_over_noise;
    assert!(imperfection.iter().all(|&value| value == 0.0));
}

/// In the first bench, the error of the smoothed sign looks like Stribeck friction at the smoothing speed. In the
/// second, a fit with cogging alone ended in a local minimum, so that dry friction of the body seemed to be needed,
/// too.
#[test]
fn neither_a_smoothed_sign_nor_a_stuck_fit_is_taken_for_an_effect() {
    for (seed, effect) in [
        (520, EffectId::BodyCoulombFriction),
        (328, EffectId::WheelCogging),
    ] {
        let bench = draw(seed).expect("a bench");
        let paper = mark(
            &bench.problem,
            &Answer::of(&bench),
            EffectId::ALL,
            &Progress::silent(),
        )
        .expect("a verdict");
        assert_eq!(paper.named, [effect], "seed {seed}");
        assert_eq!(paper.mark, Mark::Right, "seed {seed}");
    }
}

/// Dry friction of a wheel that really sticks, without a log in which the wheel stands still. An offset of the current
/// fits as well, and better than friction with a smoothed sign; the verdict must still be a tie.
#[test]
fn dry_friction_does_not_lose_by_its_smoothed_sign() {
    let bench = draw(992).expect("a bench");
    let mut truth = Answer::of(&bench).effects;
    truth.sort();
    let paper = mark(
        &bench.problem,
        &Answer::of(&bench),
        EffectId::ALL,
        &Progress::silent(),
    )
    .expect("a verdict");
    assert_eq!(paper.verdict, Verdict::Ambiguous);
    assert!(truth.contains(&EffectId::WheelCoulombFriction));
    assert!(
        paper.ambiguous_between.contains(&truth),
        "{:?}",
        paper.ambiguous_between
    );
}
