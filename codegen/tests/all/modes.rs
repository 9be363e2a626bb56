//! The modes of the closed loop, for loops whose poles are chosen.

use codegen::control;
use codegen::modes::{Modes, derive};
use codegen::spec::ModuleSpec;
use nalgebra::{Matrix3, RowVector3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::thesis;

/// The bench of the thesis with gains that place the poles at `real` and a ± jb (Ackermann's formula).
fn with_poles(real: f64, (a, b): (f64, f64)) -> ModuleSpec {
    let mut spec = thesis::spec();
    let (ad, bd) = plant(&spec);
    let reach = Matrix3::from_columns(&[bd, ad * bd, ad * ad * bd]);
    let one = Matrix3::identity();
    let wanted = (ad - one * real) * (ad * ad - ad * (2.0 * a) + one * (a * a + b * b));
    let last = RowVector3::new(0.0, 0.0, 1.0);
    let gains = last * reach.try_inverse().expect("controllable") * wanted;
    spec.gains = [gains[0], gains[1], gains[2]];
    spec
}

fn plant(spec: &ModuleSpec) -> (Matrix3<f64>, Vector3<f64>) {
    let ad = Matrix3::from_fn(|i, j| spec.ad[i][j]);
    (ad, Vector3::from_column_slice(&spec.bd))
}

fn modes(spec: &ModuleSpec) -> Option<Modes> {
    derive(spec, &control::derive(spec).expect("a law"))
}

/// Runs of e⁺ = F e + Bd w stay in the box |T e| ≤ 1, with w as large as a command's rounding can be.
#[test]
fn a_slowly_turning_pair_stays_in_its_box() {
    let pair = (0.985, 0.011);
    let spec = with_poles(0.9985, pair);
    let law = control::derive(&spec).expect("a law");
    let found = derive(&spec, &law).expect("|a| + |b| is below 1");
    assert!(found.has_pair);
    let unit = |bits: u32| 2f64.powi(-(bits as i32));
    // Half a unit of the command, and half a word of every state.
    let of_states: f64 = law
        .terms
        .iter()
        .map(|term| f64::from(term.gain.raw.unsigned_abs()) * 0.5)
        .sum();
    let worst_a = unit(law.current.fraction_bits) * (0.5 + of_states / 2f64.powi(law.shift as i32));
    let (ad, bd) = plant(&spec);
    let gains = RowVector3::from_fn(|_, i| {
        let gain = &law.terms[i].gain;
        f64::from(gain.raw) * unit(gain.fraction_bits)
    });
    let f = ad + bd * gains;
    let rows = Matrix3::from_fn(|i, j| found.rows[i][j]);
    let seed = 20;
    println!("seed {seed}");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut largest = Vector3::zeros();
    for run in 0..6 {
        let mut e = Vector3::zeros();
        for _ in 0..20_000 {
            // Half of the runs push every mode outward for as long as it goes.
            let z = rows * e;
            let push = match run % 2 {
                0 => z[run / 2].signum() * (rows.row(run / 2) * bd)[0].signum(),
                _ => rng.random_range(-1.0..1.0),
            };
            e = f * e + bd * (worst_a * push);
            largest = largest.sup(&(rows * e).abs());
        }
    }
    assert!(largest.max() <= 1.0, "{largest}");
    // A real mode that is pushed outward for ever reaches its bound.
    assert!(largest[0] > 0.99, "{largest}");
}

#[test]
fn a_pair_that_turns_faster_than_it_decays_has_no_box() {
    assert!(modes(&with_poles(0.9985, (0.99, 0.012))).is_none());
    assert!(modes(&with_poles(0.9985, (0.99, 0.008))).is_some());
    let real = modes(&thesis::spec()).expect("three real modes");
    assert!(!real.has_pair);
}
