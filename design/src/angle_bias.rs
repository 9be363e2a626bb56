//! The effect of a bias of the measured angle: a wheel that never stops.
//!
//! If the measured angle is the true one plus b, the law adds the current −K₁ b. The loop comes to rest where the body
//! leans just enough to keep the wheel turning against its friction:
//!
//! ```text
//! (A − B K) x = B K₁ b   (continuous),   (I − Ad + Bd K) x = −Bd K₁ b   (sampled)
//! ```

use crate::error::DesignError;
use crate::matrix::of_model;
use crate::zero_order_hold::zero_order_hold;
use nalgebra::{DMatrix, DVector, RowVector3, Vector3};
use plant::LinearModel;

/// The state (angle, rate, wheel speed) in which the continuous loop u = −K x comes to rest, per rad of
/// angle bias.
///
/// # Errors
/// A singular loop; entries that are not finite.
pub fn rest_per_angle_bias(
    model: &LinearModel,
    gains: &RowVector3<f64>,
) -> Result<Vector3<f64>, DesignError> {
    let (a, b) = of_model(model)?;
    let gain = DMatrix::from_fn(1, 3, |_, column| gains[column]);
    solve(a - &b * gain, b.column(0) * gains[0])
}

/// The state (angle, rate, wheel speed) in which the loop sampled at `sample_time_s` comes to rest, per rad of angle
/// bias. With the same gains, the continuous loop comes to rest in the same state, because a held input is a constant
/// input at rest.
///
/// # Errors
/// A singular loop; entries that are not finite; a sample time that is not positive.
pub fn sampled_rest_per_angle_bias(
    model: &LinearModel,
    gains: &RowVector3<f64>,
    sample_time_s: f64,
) -> Result<Vector3<f64>, DesignError> {
    let (a, b) = of_model(model)?;
    let hold = zero_order_hold(&a, &b, sample_time_s)?;
    let gain = DMatrix::from_fn(1, 3, |_, column| gains[column]);
    let loop_matrix = DMatrix::identity(3, 3) - hold.state + &hold.input * gain;
    solve(loop_matrix, hold.input.column(0) * -gains[0])
}

fn solve(matrix: DMatrix<f64>, right: DVector<f64>) -> Result<Vector3<f64>, DesignError> {
    let rest = matrix.lu().solve(&right).ok_or(DesignError::Singular {
        what: "the closed loop",
        cure: "design gains that stabilise this model",
    })?;
    Ok(Vector3::new(rest[0], rest[1], rest[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lqr::continuous_regulator;
    use crate::thesis;

    #[test]
    fn one_degree_on_the_thesis_bench() {
        let model = thesis::model();
        let degree = 1.0_f64.to_radians();
        let continuous = continuous_regulator(&model, &thesis::weights()).unwrap();
        let rest = rest_per_angle_bias(&model, &continuous.gains).unwrap() * degree;
        assert!((rest[2] + 19.1).abs() < 0.05, "{}", rest[2]);
        assert!(rest[1].abs() < 1e-12);
        let sampled =
            sampled_rest_per_angle_bias(&model, &thesis::golden_gains(), 1e-3).unwrap() * degree;
        assert!((sampled[2] + 19.2).abs() < 0.05, "{}", sampled[2]);
    }

    #[test]
    fn sampling_does_not_move_the_rest() {
        let model = thesis::model();
        let gains = thesis::golden_gains();
        let one = rest_per_angle_bias(&model, &gains).unwrap();
        let other = sampled_rest_per_angle_bias(&model, &gains, 1e-3).unwrap();
        assert!((one - other).norm() < 1e-9 * one.norm());
    }
}
