//! Discretisation with a zero-order hold: the exact difference equation of ẋ = A x + B u if u is
//! constant from one sample to the next, also if u reaches the plant with a delay.
//!
//! Both matrices come from one matrix exponential (C. Van Loan, "Computing integrals involving
//! the matrix exponential", IEEE TAC 23(3), 1978, eq. 1.2):
//!
//! ```text
//! exp([[A, B], [0, 0]] T) = [[Ad, Bd], [0, I]],   Bd = ∫₀ᵀ exp(A s) ds B
//! ```

use crate::error::DesignError;
use crate::matrix::{check_finite, check_positive, check_shape};
use nalgebra::DMatrix;

/// The difference equation x⁺ = Ad x + Bd u.
#[derive(Clone, Debug, PartialEq)]
pub struct Discrete {
    /// Ad (n×n).
    pub state: DMatrix<f64>,
    /// Bd (n×m).
    pub input: DMatrix<f64>,
}

/// The difference equation x⁺ = Ad x + Bp u₋ + Bn u for an input that reaches the plant with a delay of
/// a fraction of the sample time; u₋ is the previous input.
#[derive(Clone, Debug, PartialEq)]
pub struct DelayedDiscrete {
    /// Ad (n×n).
    pub state: DMatrix<f64>,
    /// Bp (n×m), the part of the previous input.
    pub previous_input: DMatrix<f64>,
    /// Bn (n×m), the part of the new input.
    pub new_input: DMatrix<f64>,
}

/// exp(`matrix`) by scaling, Taylor series and squaring.
///
/// The plain series is used, not a Padé approximation: without a linear solve, every entry is accurate by
/// itself, even one that is nine orders of magnitude smaller than its neighbours (the wheel's
/// friction in the row of the angle).
///
/// # Errors
/// [`DesignError::NotFinite`] if an entry is not finite or the exponential overflows.
pub fn exponential(matrix: &DMatrix<f64>) -> Result<DMatrix<f64>, DesignError> {
    check_finite("the exponent of a matrix exponential", matrix)?;
    // The largest column sum; below 1/2, 20 terms leave less than 2^-20/20! ≈ 4e-25.
    let norm = matrix
        .column_iter()
        .map(|column| column.abs().sum())
        .fold(0.0, f64::max);
    let squarings = if norm > 0.5 {
        (norm / 0.5).log2().ceil() as i32
    } else {
        0
    };
    if squarings > 60 {
        return Err(DesignError::NotFinite {
            what: "a matrix exponential (the sample time is far too long for this model)",
        });
    }
    let scaled = matrix * 0.5_f64.powi(squarings);
    let mut term = DMatrix::identity(matrix.nrows(), matrix.ncols());
    let mut sum = term.clone();
    for order in 1..=20 {
        term = &term * &scaled / f64::from(order);
        sum += &term;
    }
    for _ in 0..squarings {
        sum = &sum * &sum;
    }
    check_finite(
        "a matrix exponential (the sample time is far too long for this model)",
        &sum,
    )?;
    Ok(sum)
}

/// The zero-order hold of ẋ = A x + B u with A n×n, B n×m and any sample time in s.
///
/// # Errors
/// Wrong shapes, entries that are not finite, a sample time that is not positive.
pub fn zero_order_hold(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    sample_time_s: f64,
) -> Result<Discrete, DesignError> {
    check_positive("the sample time in s", sample_time_s)?;
    held_for(a, b, sample_time_s)
}

/// The zero-order hold over a time in s, which may be zero.
pub(crate) fn held_for(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    time_s: f64,
) -> Result<Discrete, DesignError> {
    let (states, inputs) = (a.nrows(), b.ncols());
    check_shape("the state matrix A", a, states, states)?;
    check_shape("the input matrix B", b, states, inputs)?;
    let mut augmented = DMatrix::zeros(states + inputs, states + inputs);
    augmented.view_mut((0, 0), (states, states)).copy_from(a);
    augmented
        .view_mut((0, states), (states, inputs))
        .copy_from(b);
    let exponential = exponential(&(augmented * time_s))?;
    Ok(Discrete {
        state: exponential.view((0, 0), (states, states)).into_owned(),
        input: exponential.view((0, states), (states, inputs)).into_owned(),
    })
}

/// The zero-order hold of an input that arrives `delay_s` after the sample, 0 ≤ delay ≤ T.
///
/// The previous input acts during the first `delay_s` of the interval, the new one during the rest:
/// Bp = exp(A (T − δ)) Γ(δ), Bn = Γ(T − δ), with Γ the input matrix of a hold of that length
/// (Åström and Wittenmark, "Computer-Controlled Systems", 3rd ed., section 2.3).
///
/// # Errors
/// Wrong shapes, entries that are not finite, a sample time that is not positive; [`DesignError::NotFinite`] for a
/// delay outside 0..=T.
pub fn zero_order_hold_delayed(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    sample_time_s: f64,
    delay_s: f64,
) -> Result<DelayedDiscrete, DesignError> {
    check_positive("the sample time in s", sample_time_s)?;
    if !(0.0..=sample_time_s).contains(&delay_s) {
        return Err(DesignError::NotFinite {
            what: "a delay within one sample (it must lie between zero and the sample time)",
        });
    }
    let early = held_for(a, b, delay_s)?;
    let late = held_for(a, b, sample_time_s - delay_s)?;
    Ok(DelayedDiscrete {
        state: &late.state * &early.state,
        previous_input: &late.state * &early.input,
        new_input: late.input,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis;
    use proptest::prelude::*;

    #[test]
    fn thesis_bench_at_one_millisecond() {
        let discrete = zero_order_hold(&thesis::a(), &thesis::b(), 1e-3).unwrap();
        thesis::assert_close(
            &discrete.state,
            &[
                [
                    1.0000565121511045,
                    0.0009987930157013504,
                    4.038510074499915e-09,
                ],
                [
                    0.11297901394396843,
                    0.9976058435651088,
                    8.073610399618353e-06,
                ],
                [
                    -0.1129717406856116,
                    0.002394001092951494,
                    0.9998632271118966,
                ],
            ]
            .concat(),
            1e-9,
        );
        thesis::assert_close(
            &discrete.input,
            &[
                -7.721853550980166e-06,
                -0.015437187471891671,
                0.26151845692206843,
            ],
            1e-9,
        );
    }

    /// The oracle: classical Runge-Kutta on the continuous equation with the input held.
    fn integrate(a: &DMatrix<f64>, b: &DMatrix<f64>, time: f64, steps: usize) -> Discrete {
        let h = time / steps as f64;
        let step = |x: &DMatrix<f64>, drive: &DMatrix<f64>| {
            let slope = |x: &DMatrix<f64>| a * x + drive;
            let k1 = slope(x);
            let k2 = slope(&(x + &k1 * (h / 2.0)));
            let k3 = slope(&(x + &k2 * (h / 2.0)));
            let k4 = slope(&(x + &k3 * h));
            x + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0)
        };
        let mut state = DMatrix::identity(a.nrows(), a.nrows());
        let mut input = DMatrix::zeros(b.nrows(), b.ncols());
        let none = DMatrix::zeros(a.nrows(), a.nrows());
        for _ in 0..steps {
            state = step(&state, &none);
            input = step(&input, b);
        }
        Discrete { state, input }
    }

    proptest! {
        #[test]
        fn agrees_with_runge_kutta(
            entries in prop::collection::vec(-5.0..5.0_f64, 16),
            time in 1e-4..0.3_f64,
        ) {
            let a = DMatrix::from_row_slice(3, 3, &entries[..9]);
            let b = DMatrix::from_row_slice(3, 2, &entries[9..15]);
            let held = zero_order_hold(&a, &b, time).unwrap();
            let integrated = integrate(&a, &b, time, 2000);
            prop_assert!((held.state - integrated.state).amax() < 1e-9);
            prop_assert!((held.input - integrated.input).amax() < 1e-9);
        }

        #[test]
        fn two_halves_make_a_whole(
            entries in prop::collection::vec(-30.0..30.0_f64, 12),
            time in 1e-5..0.2_f64,
            part in 0.0..1.0_f64,
        ) {
            let a = DMatrix::from_row_slice(3, 3, &entries[..9]);
            let b = DMatrix::from_row_slice(3, 1, &entries[9..]);
            let whole = zero_order_hold(&a, &b, time).unwrap();
            let split = zero_order_hold_delayed(&a, &b, time, part * time).unwrap();
            let size = whole.state.amax().max(whole.input.amax());
            prop_assert!((split.state - &whole.state).amax() < 1e-12 * size);
            // The same input before and after the delay is an input without delay.
            let both = split.previous_input + split.new_input;
            prop_assert!((both - &whole.input).amax() < 1e-12 * size);
        }
    }

    #[test]
    fn rotation_is_exact() {
        let turn = DMatrix::from_row_slice(2, 2, &[0.0, -1.0, 1.0, 0.0]) * 10.0;
        let result = exponential(&turn).unwrap();
        assert!((result[(0, 0)] - 10.0_f64.cos()).abs() < 1e-13);
        assert!((result[(1, 0)] - 10.0_f64.sin()).abs() < 1e-13);
    }

    #[test]
    fn bad_input_is_named() {
        let (a, b) = (thesis::a(), thesis::b());
        assert!(matches!(
            zero_order_hold(&a, &b, 0.0),
            Err(DesignError::NotPositive { .. })
        ));
        assert!(matches!(
            zero_order_hold(&a, &b, f64::NAN),
            Err(DesignError::NotFinite { .. })
        ));
        assert!(matches!(
            zero_order_hold(&a, &b.transpose(), 1e-3),
            Err(DesignError::WrongShape { .. })
        ));
        assert!(matches!(
            zero_order_hold(&(a * 1e30), &b, 1.0),
            Err(DesignError::NotFinite { .. })
        ));
    }
}
