//! The errors of fitted parameters hang together as the fit says, and a controller's poles are as
//! uncertain as that makes them: against the scatter over many refits.

use std::f64::consts::{PI, TAU};

use design::{PoleUncertainty, UncertainParameters, pole_uncertainty};
use identify::{Fit, FitProblem, identify};
use nalgebra::{DMatrix, RowVector3};
use plant::{GRAVITY_TORQUE, Kind, Model, TOTAL_INERTIA};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::simulated::{Experiment, Physics, VALUES, free_swing, simulate, spin_up};

const SEED: u64 = 2026;
const REFITS: u64 = 80;

/// A bench of which only the torque constant is known: G and Θ have their common scale from a driven
/// swing, their quotient from the period. The noise of the recorded current moves wheel and body.
fn fit(seed: u64) -> Fit {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let drive = |t: f64| 0.5 * (TAU * 1.1 * t).sin();
    let forward = |_: f64| 0.6;
    let driven = Experiment {
        kind: Kind::Driven,
        current: &drive,
        ..free_swing("driven", 0.1, 8.0)
    };
    let experiments = [
        spin_up("spin-up", &forward, 6.0),
        free_swing("free swing", 0.35, 12.0),
        driven,
    ];
    let simulated = experiments.map(|experiment| simulate(&Physics::base(), &experiment, &mut rng));
    let known = [None, None, None, Some(VALUES[3])];
    let problem = FitProblem::from_records(simulated.to_vec(), known, Default::default());
    let found = identify(&problem.expect("records"), &Model::base(), None);
    found.expect("a fit").fit
}

/// The poles of a fit; `correlated`: with the correlations of its errors, else as if independent.
fn poles(fit: &Fit, correlated: bool) -> PoleUncertainty {
    let infos = fit.model.parameters();
    let parameters: Vec<_> = (0..infos.len())
        .map(|at| (infos[at].name, fit.values[at], fit.std(at).unwrap_or(0.0)))
        .collect();
    let (positions, matrix) = fit.correlation().expect("several parameters");
    let between = |a: &str, b: &str| {
        let at = |name| positions.iter().position(|&at| infos[at].name == name);
        match (at(a), at(b)) {
            (Some(row), Some(column)) if correlated => matrix[(row, column)],
            _ => 0.0,
        }
    };
    let model = |values: &[f64]| {
        plant::linearise(&fit.model, values, PI, None).map_err(|error| error.to_string())
    };
    let gains = RowVector3::new(-24.267242, -2.129739, -0.02258758);
    let parameters = UncertainParameters::correlated(&parameters, between);
    pole_uncertainty(&parameters, &model, &gains, 1e-3, 400, SEED).expect("poles")
}

/// The unstable pole of the open loop with its two standard errors (first order, drawn), 1/s.
fn unstable(study: &PoleUncertainty) -> (f64, f64, f64) {
    let pole = study
        .open_loop
        .iter()
        .max_by(|a, b| a.value.re.total_cmp(&b.value.re))
        .expect("three poles");
    (pole.value.re, pole.std_re, pole.sampled_std_re)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn covariance(a: &[f64], b: &[f64]) -> f64 {
    let products = a.iter().zip(b).map(|(x, y)| (x - mean(a)) * (y - mean(b)));
    products.sum::<f64>() / (a.len() - 1) as f64
}

#[test]
fn poles_scatter_over_refits_as_the_correlations_say() {
    let fits: Vec<Fit> = (0..REFITS)
        .into_par_iter()
        .map(|index| fit(SEED + index))
        .collect();
    let n = REFITS as f64;

    // Fisher: atanh of a sample correlation scatters by 1/√(n − 3) about that of the truth.
    let series =
        |position: usize| -> Vec<f64> { fits.iter().map(|fit| fit.values[position]).collect() };
    let (inertia, gravity) = (series(TOTAL_INERTIA), series(GRAVITY_TORQUE));
    let spread = (covariance(&inertia, &inertia) * covariance(&gravity, &gravity)).sqrt();
    let scattered = covariance(&inertia, &gravity) / spread;
    let stated: Vec<f64> = fits
        .iter()
        .map(|fit| {
            let (positions, matrix) = fit.correlation().expect("several");
            let at = |wanted| positions.iter().position(|&p| p == wanted).expect("free");
            matrix[(at(TOTAL_INERTIA), at(GRAVITY_TORQUE))]
        })
        .collect();
    let stated = mean(&stated);
    println!("seed {SEED}: correlation of inertia and gravity {stated}, over refits {scattered}");
    assert!(stated > 0.9, "{stated}");
    let off = scattered.atanh() - stated.atanh();
    assert!(off.abs() < 4.0 / (n - 3.0).sqrt(), "{scattered} {stated}");

    // A standard deviation from n values has the relative standard error 1/√(2n).
    let infos = fits[0].model.parameters();
    for position in fit(SEED).correlation().expect("several").0 {
        let values = series(position);
        let scatter = covariance(&values, &values).sqrt();
        let stds: Vec<f64> = fits.iter().filter_map(|fit| fit.std(position)).collect();
        let (stated, name) = (mean(&stds), infos[position].name);
        println!("seed {SEED}: {name} over refits ± {scatter}, stated ± {stated}");
        let ratio = scatter / stated;
        assert!(
            (ratio - 1.0).abs() < 4.0 / (2.0 * n).sqrt(),
            "{name}: {ratio}"
        );
    }

    let with: Vec<_> = fits.iter().map(|fit| unstable(&poles(fit, true))).collect();
    let without: Vec<_> = fits
        .iter()
        .map(|fit| unstable(&poles(fit, false)))
        .collect();
    let values: Vec<f64> = with.iter().map(|pole| pole.0).collect();
    let scatter = covariance(&values, &values).sqrt();
    let of = |poles: &[(f64, f64, f64)], part: fn(&(f64, f64, f64)) -> f64| -> f64 {
        mean(&poles.iter().map(part).collect::<Vec<_>>())
    };
    let (first_order, drawn) = (of(&with, |p| p.1), of(&with, |p| p.2));
    let independent = of(&without, |p| p.1);
    println!(
        "seed {SEED}: unstable pole over refits ± {scatter}, first order ± {first_order}, drawn ± \
         {drawn}, as if independent ± {independent}"
    );
    let allowed = 4.0 / (2.0 * n).sqrt();
    for stated in [first_order, drawn] {
        assert!(
            (scatter / stated - 1.0).abs() < allowed,
            "{scatter} {stated}"
        );
    }
    assert!(independent > 3.0 * scatter, "{independent} {scatter}");
}

#[test]
fn the_correlations_of_a_fit_are_possible() {
    let fit = fit(SEED);
    let (positions, matrix) = fit.correlation().expect("several");
    let with_std: Vec<usize> = (0..fit.values.len())
        .filter(|&position| fit.std(position).is_some())
        .collect();
    assert_eq!(positions, with_std);
    assert_eq!(matrix, matrix.transpose());
    assert!(matrix.diagonal().iter().all(|entry| *entry == 1.0));
    let least = matrix.clone().symmetric_eigenvalues().min();
    assert!(least > -1e-12, "{least}");
    // With the standard errors they are the covariance again.
    let covariance = fit.covariance.as_ref().expect("determined");
    let std = |row: usize| fit.std(positions[row]).expect("has one");
    let again = DMatrix::from_fn(matrix.nrows(), matrix.nrows(), |row, column| {
        matrix[(row, column)] * std(row) * std(column)
    });
    for row in 0..again.nrows() {
        for column in 0..again.nrows() {
            let off = (again[(row, column)] - covariance[(row, column)]).abs();
            assert!(off < 1e-9 * std(row) * std(column), "{row}, {column}");
        }
    }
}
