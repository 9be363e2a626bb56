//! What the minimisation and the score test promise.

use crate::common::{fitted, parameter, short_bench};
use crate::simulated::{Now, Physics, free_swing, problem, simulate};
use identify::{
    Cancelled, Effort, IdentifyError, KnownScore, Outcome, Progress, Record, Unknowns, carry_over,
    cost, describe, identify_until, refit, score_test,
};
use plant::{EffectId, Model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What is known of a fit is not worked out again, unless other samples count.
#[test]
fn a_fit_is_described_where_it_is_the_bench_s_own() {
    let whole = problem(short_bench(&Physics::base(), 2860));
    let found = fitted(&whole, &[]);
    let again = describe(&whole, &found.fit).expect("its own fit");
    assert_eq!(again.fit.values, found.fit.values);
    assert_eq!(again.statements, found.statements);
    assert_eq!(again.traces[0][0].rmse, found.traces[0][0].rmse);
    let mut other = whole.clone();
    other.records[2].weight[100..200].fill(0.0);
    assert!(describe(&other, &found.fit).is_none());
}

#[test]
fn the_cost_without_derivatives_is_that_of_the_fit() {
    let whole = problem(short_bench(&Physics::base(), 2950));
    let (thin, _) = whole.thinned(63.0);
    for problem in [&whole, &thin] {
        let fit = fitted(problem, &[EffectId::WheelCogging, EffectId::MotorLag]).fit;
        let again = cost(
            &problem.all_records(),
            &fit.model,
            &fit.values,
            &fit.minimum.windows,
        );
        assert!((again / fit.minimum.cost - 1.0).abs() < 1e-9, "{again}");
    }
}

/// A fit that would not come to where it matters ends early; one that does ends where it would have anyway.
#[test]
fn a_goal_ends_only_fits_that_do_not_reach_it() {
    let cable = |now: &Now| -2e-3 * (now.angle - 0.5);
    let physics = Physics {
        on_body: &cable,
        ..Physics::base()
    };
    let bench = problem(short_bench(&physics, 2960));
    let records = bench.all_records();
    let found = fitted(&bench, &[EffectId::BodyCableSpring]).fit;
    // The curve of Stribeck lies along a curved valley.
    let other = fitted(&bench, &[EffectId::BodyStribeckFriction]).fit;
    let refitted = |fit: &identify::Fit, effort: Effort| {
        let mut values = fit.values.clone();
        *values.last_mut().expect("a parameter") *= 3.0;
        let windows = fit.minimum.windows.clone();
        let free = bench.free(&fit.model);
        refit(&records, &fit.model, values, windows, &free, effort)
    };
    let goal = 1.5 * found.minimum.cost;
    assert!(other.minimum.cost > 3.0 * goal, "{}", other.minimum.cost);
    let efforts = [Effort::FULL, Effort::FULL.towards(goal)];
    let [free, aimed] = efforts.map(|effort| refitted(&other, effort));
    assert_eq!(aimed.outcome, Outcome::Outclassed);
    assert!(aimed.evaluations < free.evaluations, "{}", free.evaluations);
    let [free, aimed] = efforts.map(|effort| refitted(&found, effort));
    assert_eq!(free.values, aimed.values);
    assert!(aimed.outcome.was_successful());
}

#[test]
fn a_fit_that_is_called_off_ends_before_its_next_evaluation() {
    let bench = problem(short_bench(&Physics::base(), 2970));
    let model = Model::base();
    let asked = AtomicUsize::new(0);
    // In the middle of the fit.
    let cancelled = || asked.fetch_add(1, Ordering::Relaxed) >= 7;
    let progress = Progress {
        say: &|_| {},
        cancelled: &cancelled,
    };
    let found = identify_until(&bench, &model, None, &progress);
    assert_eq!(found.err(), Some(IdentifyError::Cancelled(Cancelled)));
    let after = asked.load(Ordering::Relaxed);
    assert!(after <= 9, "asked {after} times");
    let fit = fitted(&bench, &[]).fit;
    let mut values = fit.values.clone();
    values[0] *= 1.1;
    let windows = fit.minimum.windows.clone();
    let effort = Effort::FULL.until(&|| true);
    let records = bench.all_records();
    let ended = refit(&records, &model, values.clone(), windows, &[0, 2], effort);
    assert_eq!(ended.outcome, Outcome::Cancelled);
    assert_eq!((ended.values, ended.evaluations), (values, 1));
}

/// Many suspects are scored in one simulation, and records that a suspect does not touch are not simulated
/// again: neither may change what a suspect promises.
#[test]
fn a_suspect_promises_the_same_alone_and_beside_others_at_zero() {
    let problem = problem(short_bench(&Physics::base(), 2800));
    let records = problem.all_records();
    let base = fitted(&problem, &[]).fit;
    let suspects = [
        EffectId::BodyQuadraticDrag,
        EffectId::WheelQuadraticDrag,
        EffectId::CurrentOffset,
        EffectId::AngleOffset,
    ];
    let unknowns = |model: &Model| Unknowns::new(model, &problem.free(model));
    let at_zero = |model: &Model| {
        let zeros = vec![0.0; model.parameter_count()];
        carry_over(&base.model, &base.values, model, &zeros)
    };
    let windows = &base.minimum.windows;
    let of_base = score_test(
        &records,
        &base.model,
        &base.values,
        windows,
        &unknowns(&base.model),
        None,
    );
    let all = suspects
        .iter()
        .fold(Model::base(), |model, &effect| model.with(effect));
    let together = score_test(
        &records,
        &all,
        &at_zero(&all),
        windows,
        &unknowns(&all),
        None,
    );
    for effect in suspects {
        let model = base.model.with(effect);
        let (values, own) = (at_zero(&model), unknowns(&model));
        let known = KnownScore {
            model: &base.model,
            values: &base.values,
            unknowns: &unknowns(&base.model),
            score_test: &of_base,
            leaves_no_trace: &|_| false,
        };
        let every = vec![true; own.free.len()];
        let [alone, reused] = [None, Some(known)].map(|known| {
            let score_test = score_test(&records, &model, &values, windows, &own, known);
            score_test.step(&values, &own, &every).cost
        });
        let names = all.parameters();
        let whole = unknowns(&all);
        let moves: Vec<bool> = whole
            .free
            .iter()
            .map(|&at| model.position_of(names[at].name).is_some())
            .collect();
        let beside = together.step(&at_zero(&all), &whole, &moves).cost;
        let gain = of_base.cost() - alone;
        for other in [reused, beside] {
            assert!(
                (other - alone).abs() < 1e-6 * (1.0 + gain.abs()),
                "{effect:?} {alone} {other}"
            );
        }
    }
}

/// From one cable to another that is as taut the way is straight in stiffness and stiffness times rest angle.
#[test]
fn a_cable_is_found_from_a_wrong_one_in_few_steps() {
    let (stiffness, rest_angle) = (2e-3, 0.5);
    let cable = |now: &Now| -stiffness * (now.angle - rest_angle);
    let physics = Physics {
        on_body: &cable,
        ..Physics::base()
    };
    for seed in 2700..2703 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let records = [
            free_swing("free swing 20 deg", 20f64.to_radians(), 20.0),
            free_swing("free swing 52 deg", 52f64.to_radians(), 20.0),
        ]
        .iter()
        .map(|experiment| simulate(&physics, experiment, &mut rng))
        .collect();
        let problem = problem(records);
        let found = fitted(&problem, &[EffectId::BodyCableSpring]);
        let model = &found.fit.model;
        let at = model.position(EffectId::BodyCableSpring).expect("a cable");
        let mut values = found.fit.values.clone();
        values[at] *= 0.25;
        values[at + 1] *= 4.0;
        let records = problem.all_records();
        let windows = found.fit.minimum.windows.clone();
        let free = problem.free(model);
        let again = refit(&records, model, values, windows, &free, Effort::FULL);
        assert!(
            again.evaluations <= 12,
            "seed {seed}: {}",
            again.evaluations
        );
        assert!(
            (again.cost - found.fit.minimum.cost).abs() < 0.1,
            "seed {seed}"
        );
        for (name, truth) in [
            ("cable_stiffness", stiffness),
            ("cable_rest_angle", rest_angle),
        ] {
            let (value, std) = parameter(&found, name);
            assert!(
                (value - truth).abs() < 4.0 * std,
                "seed {seed} {name}: {value} {std}"
            );
        }
    }
}

/// The parameters of the motor come back from a thinned log as from the whole one.
#[test]
fn a_thinned_log_says_what_the_whole_log_says() {
    let (zone, lag) = (0.03, 0.008);
    let motor = |current: f64| current.signum() * (current.abs() - zone).max(0.0);
    let physics = Physics {
        motor: &motor,
        motor_lag_s: lag,
        ..Physics::base()
    };
    for seed in 2900..2902 {
        let whole = problem(short_bench(&physics, seed));
        let (thin, steps) = whole.thinned(63.0);
        assert_eq!(steps, [1, 1, 2, 2, 4], "seed {seed}");
        let effects = [EffectId::MotorDeadZone, EffectId::MotorLag];
        let found = [&whole, &thin].map(|problem| fitted(problem, &effects));
        for (found, problem) in found.iter().zip([&whole, &thin]) {
            let observations: usize = problem.records.iter().map(Record::observations).sum();
            let mean_square = found.fit.minimum.cost / observations as f64;
            let spread = (2.0 / observations as f64).sqrt();
            assert!(
                (mean_square - 1.0).abs() < 6.0 * spread + 0.02,
                "seed {seed}: {mean_square}"
            );
        }
        for (name, truth) in [("dead_zone", zone), ("motor_lag", lag)] {
            for found in &found {
                let (value, std) = parameter(found, name);
                assert!(
                    (value - truth).abs() < 4.0 * std,
                    "seed {seed} {name}: {value} {std}"
                );
            }
        }
    }
}
