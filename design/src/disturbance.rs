//! The response of the closed loop to a disturbing torque.
//!
//! With x⁺ = (Ad − Bd K) x + Ed d, and d held over a sample, the response of the angle to a torque d of frequency ω
//! is |c (e^{jωT} I − Ad + Bd K)⁻¹ Ed| |d|; for the current, −K replaces c. The largest gain over all
//! frequencies is the H∞ norm (Zhou, Doyle & Glover, "Robust and Optimal Control", 1996, section 4.3). For any torque
//! with mean square d², the root mean square of the angle is at most the norm times d.

use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix, DVector, Vector3};

use crate::controller::LinearController;
use crate::design::Design;
use crate::error::DesignError;
use crate::zero_order_hold::zero_order_hold;

/// Number of frequencies, evenly spaced on a logarithmic scale. A loop with three states has no peak so narrow that it
/// lies between two of them.
const FREQUENCIES: usize = 600;
/// Lowest frequency, as a share of the highest, which is half the sampling frequency.
const LOWEST: f64 = 1e-6;

/// The largest gains of a closed loop from a torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueResponse {
    /// To the angle, rad/(N m).
    pub angle_rad_per_nm: f64,
    /// To the current, A/(N m).
    pub current_a_per_nm: f64,
}

/// The largest gains over all frequencies of the loop of `design`, from a torque that enters ẋ = A x + B u + E d
/// through `torque_input` E, in units of row per N m and second.
///
/// # Errors
/// Entries that are not finite.
pub fn torque_response(
    design: &Design,
    torque_input: &Vector3<f64>,
) -> Result<TorqueResponse, DesignError> {
    let a = DMatrix::from_iterator(3, 3, design.model.state.iter().copied());
    let e = DMatrix::from_iterator(3, 1, torque_input.iter().copied());
    let time_s = design.settings.sample_time_s;
    let disturbed = zero_order_hold(&a, &e, time_s)?.input;
    let controller = LinearController::state_feedback(&design.gains);
    let closed = controller.closed_loop(&design.discrete.state, &design.discrete.input)?;
    let complex = |real: f64| Complex::new(real, 0.0);
    let closed = closed.map(complex);
    let disturbed: DVector<Complex<f64>> = disturbed.column(0).map(complex);
    let gains = design.gains.map(complex);
    let mut largest = TorqueResponse {
        angle_rad_per_nm: 0.0,
        current_a_per_nm: 0.0,
    };
    for index in 0..FREQUENCIES {
        let share = index as f64 / (FREQUENCIES - 1) as f64;
        let turn = PI * LOWEST.powf(1.0 - share);
        let z = Complex::from_polar(1.0, turn);
        let resolvent = DMatrix::identity(3, 3).map(|one: Complex<f64>| one * z) - &closed;
        let Some(state) = resolvent.lu().solve(&disturbed) else {
            continue;
        };
        let current: Complex<f64> = (0..3).map(|row| gains[row] * state[row]).sum();
        largest.angle_rad_per_nm = largest.angle_rad_per_nm.max(state[0].norm());
        largest.current_a_per_nm = largest.current_a_per_nm.max(current.norm());
    }
    Ok(largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::thesis::model;

    /// The mean square of the angle under a torque of any one frequency stays below the bound, and a torque of the
    /// worst frequency nearly reaches it: by simulation of the difference equation.
    #[test]
    fn no_sine_moves_the_loop_further() {
        let design = Design::new(&model(), &Settings::usual(None)).unwrap();
        let input = Vector3::new(0.0, 461.0, -461.0);
        let bound = torque_response(&design, &input).unwrap();
        let a = DMatrix::from_iterator(3, 3, design.model.state.iter().copied());
        let e = DMatrix::from_iterator(3, 1, input.iter().copied());
        let held = zero_order_hold(&a, &e, design.settings.sample_time_s).unwrap();
        let closed = LinearController::state_feedback(&design.gains)
            .closed_loop(&design.discrete.state, &design.discrete.input)
            .unwrap();
        let amplitude = |turn: f64| {
            let mut state = DVector::zeros(3);
            let mut largest = [0.0f64; 2];
            for step in 0..60_000 {
                let torque = (turn * f64::from(step)).sin();
                state = &closed * state + &held.input * torque;
                if step > 50_000 {
                    let current: f64 = (0..3).map(|row| design.gains[row] * state[row]).sum();
                    largest = [
                        largest[0].max(state[0].abs()),
                        largest[1].max(current.abs()),
                    ];
                }
            }
            largest
        };
        let turns = (0..40).map(|index| PI * 1e-4f64.powf(1.0 - f64::from(index) / 39.0));
        let mut reached = [0.0f64; 2];
        for turn in turns {
            let [angle, current] = amplitude(turn);
            assert!(angle <= bound.angle_rad_per_nm * (1.0 + 1e-6));
            assert!(current <= bound.current_a_per_nm * (1.0 + 1e-6));
            reached = [reached[0].max(angle), reached[1].max(current)];
        }
        assert!(
            reached[0] > 0.9 * bound.angle_rad_per_nm,
            "{reached:?} {bound:?}"
        );
        assert!(
            reached[1] > 0.9 * bound.current_a_per_nm,
            "{reached:?} {bound:?}"
        );
    }
}
