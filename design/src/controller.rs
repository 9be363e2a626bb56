//! Linear controllers and the loops that they close around the sampled plant.

use crate::error::DesignError;
use crate::matrix::check_shape;
use nalgebra::{DMatrix, RowVector3};

/// A discrete linear controller c⁺ = Ac c + Bc y, u = Cc c + Dc y, with y the measured state and u the
/// current in A.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearController {
    /// Ac (p×p); empty for plain state feedback.
    pub state: DMatrix<f64>,
    /// Bc (p×n).
    pub measurement: DMatrix<f64>,
    /// Cc (1×p).
    pub output: DMatrix<f64>,
    /// Dc (1×n).
    pub feedthrough: DMatrix<f64>,
}

impl LinearController {
    /// u = −K y with `gains` K in A/rad, A s/rad, A s/rad.
    pub fn state_feedback(gains: &RowVector3<f64>) -> Self {
        LinearController {
            state: DMatrix::zeros(0, 0),
            measurement: DMatrix::zeros(0, 3),
            output: DMatrix::zeros(1, 0),
            feedthrough: DMatrix::from_fn(1, 3, |_, column| -gains[column]),
        }
    }

    /// Number of its own states.
    pub fn order(&self) -> usize {
        self.state.nrows()
    }

    fn check(&self, plant_states: usize) -> Result<(), DesignError> {
        let order = self.order();
        check_shape("Ac of the controller", &self.state, order, order)?;
        check_shape(
            "Bc of the controller",
            &self.measurement,
            order,
            plant_states,
        )?;
        check_shape("Cc of the controller", &self.output, 1, order)?;
        check_shape("Dc of the controller", &self.feedthrough, 1, plant_states)
    }

    /// The state matrix of the loop with x⁺ = Ad x + Bd u; its states are (x, c).
    ///
    /// # Errors
    /// Wrong shapes.
    pub fn closed_loop(
        &self,
        ad: &DMatrix<f64>,
        bd: &DMatrix<f64>,
    ) -> Result<DMatrix<f64>, DesignError> {
        let (n, order) = (ad.nrows(), self.order());
        check_shape("the state matrix Ad", ad, n, n)?;
        check_shape("the input matrix Bd", bd, n, 1)?;
        self.check(n)?;
        let mut closed = DMatrix::zeros(n + order, n + order);
        closed
            .view_mut((0, 0), (n, n))
            .copy_from(&(ad + bd * &self.feedthrough));
        closed
            .view_mut((0, n), (n, order))
            .copy_from(&(bd * &self.output));
        closed
            .view_mut((n, 0), (order, n))
            .copy_from(&self.measurement);
        closed
            .view_mut((n, n), (order, order))
            .copy_from(&self.state);
        Ok(closed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::poles::spectral_radius;
    use crate::thesis;
    use crate::zero_order_hold::zero_order_hold;

    #[test]
    fn a_loop_without_delay_has_the_golden_poles() {
        let hold = zero_order_hold(&thesis::a(), &thesis::b(), 1e-3).unwrap();
        let closed = LinearController::state_feedback(&thesis::golden_gains())
            .closed_loop(&hold.state, &hold.input)
            .unwrap();
        assert!((spectral_radius(&closed).unwrap() - 0.99544999).abs() < 1e-8);
    }
}
