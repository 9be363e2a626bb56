//! A fit beside the fit of a neighbouring model.

use identify::{FitProblem, Progress, fit_from_neighbour};
use plant::{EffectId, Model};

use crate::common::{fitted, short_bench};
use crate::simulated::{Physics, VALUES};

/// An effect can only lower the cost of a fit that starts where the smaller model ended, and taking the effect out
/// again leads back to the smaller model's minimum.
#[test]
fn a_larger_model_never_costs_more_than_the_smaller_one() {
    let seed = 20_261;
    println!("seed {seed}");
    let records = short_bench(&Physics::base(), seed);
    let known = [None, Some(VALUES[1]), None, None];
    let problem = FitProblem::from_records(records, known, Default::default()).expect("records");
    let small = fitted(&problem, &[]);
    for effect in [
        EffectId::BodyCoulombFriction,
        EffectId::WheelQuadraticDrag,
        EffectId::CurrentOffset,
    ] {
        let model = Model::base().with(effect);
        let progress = Progress::silent();
        let large = fit_from_neighbour(&problem, &small.fit, &model, &progress)
            .unwrap_or_else(|error| panic!("{}: {error}", effect.name()));
        let (before, after) = (small.fit.minimum.cost, large.fit.minimum.cost);
        assert!(
            after <= before * (1.0 + 1e-9),
            "{}: {before} before, {after} with the effect",
            effect.name()
        );
        let back = fit_from_neighbour(&problem, &large.fit, &Model::base(), &progress)
            .unwrap_or_else(|error| panic!("without {}: {error}", effect.name()));
        let back = back.fit.minimum.cost;
        assert!(
            (back - before).abs() <= 1e-6 * before,
            "without {} again: {back}, before {before}",
            effect.name()
        );
    }
}
