//! The stated gains are those of the stated model and weights: they satisfy their Riccati equation.
//!
//! The cost ∫ xᵀ Q x + R u² dt of the sampled loop, u constant over each sample, is Σ (x, u)ᵀ W (x, u) with
//!
//! W = ∫₀ᵀ exp(M t)ᵀ diag(Q, R) exp(M t) dt,   M = (A B; 0 0).
//!
//! Let P be the cost of the loop with K, P = Fᵀ P F + (1, −K)ᵀ W (1, −K). The best first command is then −K′ x with
//! K′ = (W_uu + Bdᵀ P Bd)⁻¹ (Bdᵀ P Ad + W_ux). K is optimal exactly if K′ = K, and K′ − K is the distance of K
//! from the optimum, up to its square (Kleinman's iteration). Computed in double precision.

use crate::certificate::reader::{Certificate, StatedDecimal};

/// Share by which a gain may be off.
const TOLERANCE: f64 = 1e-5;
/// The first interval of the doubling is T over 2 to this power.
const DOUBLINGS: u32 = 12;

type Matrix = [[f64; 4]; 4];

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    core::array::from_fn(|i| core::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

fn transposed(a: &Matrix) -> Matrix {
    core::array::from_fn(|i| core::array::from_fn(|j| a[j][i]))
}

fn sum(a: &Matrix, b: &Matrix) -> Matrix {
    core::array::from_fn(|i| core::array::from_fn(|j| a[i][j] + b[i][j]))
}

fn scaled(a: &Matrix, factor: f64) -> Matrix {
    a.map(|row| row.map(|entry| entry * factor))
}

/// xᵀ W x for the columns of x.
fn congruent(w: &Matrix, x: &Matrix) -> Matrix {
    product(&transposed(x), &product(w, x))
}

/// exp of a small matrix by its series.
fn exponential(m: &Matrix) -> Matrix {
    let one: Matrix =
        core::array::from_fn(|i| core::array::from_fn(|j| f64::from(u8::from(i == j))));
    let (mut total, mut term) = (one, one);
    for k in 1..=20 {
        term = scaled(&product(&term, m), 1.0 / f64::from(k));
        total = sum(&total, &term);
    }
    total
}

/// Checks K against the weights.
///
/// # Errors
/// A sentence that names the gain, with what it should be.
pub fn check(certificate: &Certificate) -> Result<(), String> {
    let number = |stated: &StatedDecimal| stated.text.parse::<f64>().map_err(|e| e.to_string());
    let three = |stated: &[StatedDecimal; 3]| -> Result<[f64; 3], String> {
        Ok([
            number(&stated[0])?,
            number(&stated[1])?,
            number(&stated[2])?,
        ])
    };
    let plant = &certificate.plant;
    let (b, k) = (three(&plant.b)?, three(&certificate.gains)?);
    let q = three(&certificate.weights.state)?;
    let r = number(&certificate.weights.current)?;
    let period = number(&certificate.sample_time_s)?;
    let is_weight = q.iter().all(|weight| *weight >= 0.0) && r > 0.0;
    if !is_weight {
        return Err("the weights are not those of a cost: Q not negative, R positive".to_owned());
    }
    let mut m = Matrix::default();
    for i in 0..3 {
        m[i][..3].copy_from_slice(&three(&plant.a[i])?);
        m[i][3] = b[i];
    }
    let mut weights = Matrix::default();
    for (i, weight) in q.into_iter().chain([r]).enumerate() {
        weights[i][i] = weight;
    }

    // Simpson's rule on a very short interval, then doubled: W(2h) = W(h) + E(h)ᵀ W(h) E(h).
    let h = period / 2f64.powi(DOUBLINGS as i32);
    let (half, mut e) = (
        exponential(&scaled(&m, h / 2.0)),
        exponential(&scaled(&m, h)),
    );
    let ends = sum(&weights, &congruent(&weights, &e));
    let mut w = scaled(
        &sum(&ends, &scaled(&congruent(&weights, &half), 4.0)),
        h / 6.0,
    );
    for _ in 0..DOUBLINGS {
        w = sum(&w, &congruent(&w, &e));
        e = product(&e, &e);
    }
    // Now e holds Ad and Bd. F and the cost of one step, in the upper left.
    let mut feedback = Matrix::default();
    for i in 0..3 {
        feedback[i][i] = 1.0;
        feedback[3][i] = -k[i];
    }
    let mut f = product(&e, &feedback);
    f[3] = [0.0; 4];
    let mut p = congruent(&w, &feedback);
    for _ in 0..64 {
        p = sum(&p, &congruent(&p, &f));
        f = product(&f, &f);
    }
    if !p.iter().flatten().all(|entry| entry.is_finite()) {
        return Err("the loop with the stated gains has no finite cost".to_owned());
    }
    // The cost of one sample plus the cost of all later ones, as a quadratic form of (x, u).
    let mut left = e;
    left[3] = [0.0; 4];
    let form = sum(&w, &congruent(&p, &left));
    for (i, gain) in k.into_iter().enumerate() {
        let best = form[3][i] / form[3][3];
        let least = 1e-9 * k.iter().map(|gain| gain.abs()).fold(0.0, f64::max);
        let off = (best - gain).abs();
        if off.is_nan() || off > TOLERANCE * gain.abs() + least {
            return Err(format!(
                "gains[{i}] is {gain}, model and weights make it about {best}"
            ));
        }
    }
    Ok(())
}
