//! The closed loop in coordinates in which each mode decays by itself, for the harness crate.
//!
//! Let e be the difference between the states of the loop with the emitted law and of the loop with the same gains in
//! real numbers. In a step e becomes F e + Bd w, where F = Ad + Bd N is the loop's matrix, and w the difference between
//! the emitted command and N x. With the left eigenvectors of F as the rows of T, each coordinate of z = T e of a loop
//! with three real modes satisfies |zᵢ⁺| ≤ |λᵢ| |zᵢ| + |Tᵢ Bd| |w|. The rows are scaled so that |zᵢ| ≤ 1 holds for all
//! time.
//!
//! For a complex pair a ± jb the real and the imaginary part of its eigenvector are two rows, with
//! |z₁⁺| ≤ |a| |z₁| + |b| |z₂| + |T₁ Bd| |w|, and z₂ likewise. The box |z| ≤ 1 is then mapped into itself only if
//! |a| + |b| < 1, and no other choice of three coordinates does better (Bitsoris, Int. J. Control 47 (1988)): a pair
//! that turns faster than it decays has no such coordinates.

use nalgebra::{Complex, ComplexField, Matrix3, RowVector3, Vector3};

use crate::ir::IntegerLaw;
use crate::spec::ModuleSpec;

/// In the harness, the word 2^28 stands for a coordinate of 1, its largest value.
const BOX_BITS: i32 = 28;
/// Fraction bits of a mode's decay.
const DECAY_BITS: i32 = 30;
/// Bits by which the harness divides the words of the states.
const PART_BITS: i32 = 4;
/// Share of a step that is left for rounding outward.
const MARGIN: f64 = 1e-3;

/// Error that double precision may add to an entry of T F T⁻¹, whose entries are at most about one.
const ROUNDING: f64 = 1e-12;

/// One mode in the units of the harness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModeWords {
    /// Factor of the coordinate in a step, in Q30, rounded up.
    pub decay: i64,
    /// Largest amount that the other coordinates add in a step.
    pub rest: i64,
    /// Amount that one unit of the command's difference adds in a step.
    pub input: i64,
}

/// The modes of a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    /// T, row by row: per rad, per rad/s, per rad/s.
    pub rows: [[f64; 3]; 3],
    /// The words of each mode.
    pub words: [ModeWords; 3],
    /// Whether the last two modes are a complex pair.
    pub has_pair: bool,
}

/// The modes of the loop; `None` where no box of them is mapped into itself.
pub fn derive(spec: &ModuleSpec, law: &IntegerLaw) -> Option<Modes> {
    let unit = |bits: u32| 2f64.powi(-(bits as i32));
    let gains = RowVector3::from_fn(|_, i| {
        let gain = &law.terms[i].gain;
        f64::from(gain.raw) * unit(gain.fraction_bits)
    });
    let input = Vector3::from_column_slice(&spec.bd);
    let f = Matrix3::from_fn(|i, j| spec.ad[i][j]) + input * gains;

    // The largest |w|, in 2^−PART_BITS units of the sum of products: half a unit of the command, and half a word of
    // each state.
    let shift = law.shift as i32;
    let half = 2f64.powi(shift - 1 + PART_BITS);
    let raw = law
        .terms
        .iter()
        .map(|term| f64::from(term.gain.raw.unsigned_abs()));
    let worst = half + 2f64.powi(PART_BITS - 1) * raw.sum::<f64>();
    let count_a = unit(law.current.fraction_bits) * 2f64.powi(-shift - PART_BITS);

    // The row, scaled such that its coordinate stays within 1 for all time: in a step at most the share `remains` of
    // the coordinate remains, and each ampere of the command's difference adds at most `push` (before scaling).
    let scaled = |row: RowVector3<f64>, remains: f64, push: f64| {
        row * ((1.0 - remains) * (1.0 - MARGIN) / (push * count_a * worst))
    };
    let mut rows = Matrix3::zeros();
    let values = f.eigenvalues();
    let has_pair = values.is_none();
    if let Some(values) = values {
        for (i, value) in values.iter().enumerate() {
            let row = left_eigenvector(&f, *value);
            let push = (row * input)[0].abs();
            rows.set_row(i, &scaled(row, value.abs(), push));
        }
    } else {
        let values = f.complex_eigenvalues();
        let real = values.iter().find(|value| value.im == 0.0)?.re;
        let of_pair = values.iter().find(|value| value.im > 0.0)?;
        let row = left_eigenvector(&f, real);
        let push = (row * input)[0].abs();
        rows.set_row(0, &scaled(row, real.abs(), push));

        let remains = of_pair.re.abs() + of_pair.im.abs();
        if remains >= 1.0 {
            return None;
        }
        let row = left_eigenvector(&f.map(Complex::from), *of_pair);
        // The phase of an eigenvector is free. It is chosen so that the command's difference adds the same amount to
        // both parts.
        let pushed = (row * input.map(Complex::from))[0];
        let turn = Complex::from_polar(1.0, std::f64::consts::FRAC_PI_4 - pushed.arg());
        let row = row * turn;
        let push = pushed.norm() * std::f64::consts::FRAC_1_SQRT_2;
        rows.set_row(1, &scaled(row.map(|entry| entry.re), remains, push));
        rows.set_row(2, &scaled(row.map(|entry| entry.im), remains, push));
    }
    if !rows.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let decoupled = rows * f * rows.try_inverse()?;
    let scale = 2f64.powi(DECAY_BITS + BOX_BITS);
    let up = |value: f64| (value * (1.0 + 1e-9)).ceil() as i64 + 1;
    let words = [0, 1, 2].map(|i| ModeWords {
        decay: up(decoupled[(i, i)].abs() * 2f64.powi(DECAY_BITS)),
        // The exact entries beside the diagonal are zero, but for a pair; these are the rounding of T, and of this
        // product.
        rest: up((0..3)
            .filter(|j| *j != i)
            .map(|j| {
                let is_of_pair = has_pair && i > 0 && j > 0;
                let factor = if is_of_pair { 1.0 } else { 2.0 };
                factor * decoupled[(i, j)].abs() + ROUNDING
            })
            .sum::<f64>()
            * scale),
        input: up((rows.row(i) * input)[0].abs() * count_a * scale),
    });
    let fits = |mode: &ModeWords| {
        let next = mode.decay as f64 * 2f64.powi(BOX_BITS) + mode.rest as f64;
        next + mode.input as f64 * worst <= scale
    };
    words.iter().all(fits).then(|| Modes {
        rows: [0, 1, 2].map(|i| [0, 1, 2].map(|j| rows[(i, j)])),
        words,
        has_pair,
    })
}

/// A row v with v F = `value` v: the longest row of the adjugate of F − `value`.
fn left_eigenvector<T>(f: &Matrix3<T>, value: T) -> RowVector3<T>
where
    T: ComplexField<RealField = f64> + Copy,
{
    let m = f - Matrix3::identity() * value;
    let columns = [m.column(0), m.column(1), m.column(2)];
    // The rows of the adjugate are the cross products of the columns.
    let candidates = [
        columns[1].cross(&columns[2]),
        columns[2].cross(&columns[0]),
        columns[0].cross(&columns[1]),
    ];
    let mut longest = candidates[0];
    for candidate in candidates {
        if candidate.norm() > longest.norm() {
            longest = candidate;
        }
    }
    longest.transpose()
}
