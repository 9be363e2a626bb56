//! Stability of the sampled linear loop with the quantised gains, in exact arithmetic.
//!
//! Jury's criterion for z³ + a z² + b z + c: all roots lie inside the unit circle exactly if
//! 1 + a + b + c > 0, 1 − a + b − c > 0, |c| < 1 and |b − a c| < 1 − c² (E. I. Jury, *Theory and
//! Application of the z-Transform Method*, 1964).

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed};

use crate::exact::{ShortestDecimal, power_of_two};
use crate::ir::IntegerLaw;
use crate::refusal::Refusal;
use crate::spec::ModuleSpec;

type Matrix = [[BigRational; 3]; 3];

/// Refuses a law whose loop Ad − Bd K is not asymptotically stable.
///
/// # Errors
/// [`Refusal::Unstable`].
pub fn require_stable(spec: &ModuleSpec, law: &IntegerLaw) -> Result<(), Refusal> {
    // The gains of the terms are −K, so the loop is Ad + Bd N.
    let mut closed_loop: Matrix = spec
        .ad
        .map(|row| row.map(|entry| ShortestDecimal::new(entry).value));
    for (row, input) in closed_loop.iter_mut().zip(spec.bd) {
        let input = ShortestDecimal::new(input).value;
        for (entry, term) in row.iter_mut().zip(&law.terms) {
            let gain = BigRational::from(BigInt::from(term.gain.raw))
                * power_of_two(-(term.gain.fraction_bits as i32));
            *entry += &input * gain;
        }
    }
    if roots_inside_unit_circle(&characteristic_polynomial(&closed_loop)) {
        Ok(())
    } else {
        Err(Refusal::Unstable {
            sample_time_s: spec.sample_time_s,
        })
    }
}

/// Coefficients a, b, c of det(z I − M) = z³ + a z² + b z + c.
fn characteristic_polynomial(m: &Matrix) -> [BigRational; 3] {
    let minor = |i: usize, j: usize| &m[i][i] * &m[j][j] - &m[i][j] * &m[j][i];
    let trace = &m[0][0] + &m[1][1] + &m[2][2];
    let minors = minor(0, 1) + minor(0, 2) + minor(1, 2);
    let determinant = &m[0][0] * minor(1, 2)
        - &m[0][1] * (&m[1][0] * &m[2][2] - &m[1][2] * &m[2][0])
        + &m[0][2] * (&m[1][0] * &m[2][1] - &m[1][1] * &m[2][0]);
    [-trace, minors, -determinant]
}

fn roots_inside_unit_circle([a, b, c]: &[BigRational; 3]) -> bool {
    let one = BigRational::one();
    &one + a + b + c > BigRational::default()
        && &one - a + b - c > BigRational::default()
        && c.abs() < one
        && (b - a * c).abs() < &one - c * c
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polynomials with known roots r, s, t: a = −(r+s+t), b = rs+rt+st, c = −rst.
    #[test]
    fn jury_agrees_with_known_roots() {
        let cases = [
            ([0.9, 0.5, -0.3], true),
            ([0.999_999, 0.999_999, 0.999_999], true),
            ([-0.999_999, 0.1, 0.2], true),
            ([1.0, 0.5, 0.5], false),
            ([-1.0, 0.5, 0.5], false),
            ([1.01, 0.5, 0.5], false),
            ([2.0, 2.0, 2.0], false),
            ([2.0, 2.0, 0.1], false),
            ([-2.0, -2.0, 0.1], false),
            ([2.0, -2.0, 0.0], false),
        ];
        for (roots, stable) in cases {
            let [r, s, t] = roots.map(|root| ShortestDecimal::new(root).value);
            let polynomial = [
                -(&r + &s + &t),
                &r * &s + &r * &t + &s * &t,
                -(&r * &s * &t),
            ];
            assert_eq!(
                roots_inside_unit_circle(&polynomial),
                stable,
                "roots {roots:?}"
            );
        }
        // A complex pair ρ e^±iθ and a real root: z² − 2ρ cos θ z + ρ².
        for (magnitude, stable) in [(0.99, true), (1.0, false), (1.01, false)] {
            let rho = ShortestDecimal::new(magnitude).value;
            let two_cos = ShortestDecimal::new(1.2).value * &rho;
            let square = &rho * &rho;
            let t = ShortestDecimal::new(0.5).value;
            let polynomial = [-(&two_cos + &t), &square + &two_cos * &t, -(&square * &t)];
            assert_eq!(roots_inside_unit_circle(&polynomial), stable, "{magnitude}");
        }
    }

    #[test]
    fn characteristic_polynomial_of_a_companion_matrix() {
        // The companion matrix of z³ + 2 z² − 3 z + 5.
        let m = [[0.0, 0.0, -5.0], [1.0, 0.0, 3.0], [0.0, 1.0, -2.0]]
            .map(|row| row.map(|entry| ShortestDecimal::new(entry).value));
        let expected = [2.0, -3.0, 5.0].map(|entry| ShortestDecimal::new(entry).value);
        assert_eq!(characteristic_polynomial(&m), expected);
    }
}
