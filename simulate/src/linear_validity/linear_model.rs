//! The linear models: free swing around hanging, and spin-up around standstill. Each is the exact Jacobian at rest of
//! those terms that have one there.

use crate::error::{SimulateError, check_positive};
use crate::transient::values_of;
use design::zero_order_hold::{exponential, zero_order_hold};
use nalgebra::DMatrix;
use plant::{Dual, Kind, Linearised, Model, Plant, Scalar, State};
use std::f64::consts::TAU;

/// The free swing linearised at α = 0, wheel locked.
pub(super) struct LinearSwing {
    /// [[0, 1], [∂α̈/∂α, ∂α̈/∂α̇]].
    matrix: DMatrix<f64>,
    /// Angle of rest, rad; not 0 if a cable pulls the body aside.
    pub(super) rest_rad: f64,
}

impl LinearSwing {
    pub(super) fn of(model: &Model, values: &[f64]) -> LinearSwing {
        let constants: Vec<Dual<2>> = values.iter().map(|value| Dual::constant(*value)).collect();
        let plant = Plant::new(model, &constants, Kind::FreeSwing);
        let at = State {
            angle_rad: Dual::variable(0.0, 0),
            rate_rad_s: Dual::variable(0.0, 1),
            ..State::rest()
        };
        let (rate_dot, _) = plant.derivative(&at, Dual::constant(0.0), 0.0);
        let [by_angle, by_rate] = rate_dot.derivatives;
        LinearSwing {
            matrix: DMatrix::from_row_slice(2, 2, &[0.0, 1.0, by_angle, by_rate]),
            rest_rad: -rate_dot.value / by_angle,
        }
    }

    /// Its period in s, damping included.
    pub(super) fn period_s(&self) -> Result<f64, SimulateError> {
        let a = &self.matrix;
        let square = -a[(1, 0)] - 0.25 * a[(1, 1)].powi(2);
        check_positive("the square of the swing's frequency in 1/s2", square)?;
        Ok(TAU / square.sqrt())
    }

    /// The angle in rad at every time of `time_s`; `start` is the angle (rad) and the rate (rad/s) at the first of
    /// them.
    pub(super) fn run(&self, start: [f64; 2], time_s: &[f64]) -> Result<Vec<f64>, SimulateError> {
        let mut x = DMatrix::from_column_slice(2, 1, &[start[0] - self.rest_rad, start[1]]);
        let mut angles = vec![start[0]];
        let (mut step_s, mut step) = (0.0, DMatrix::identity(2, 2));
        for pair in time_s.windows(2) {
            // The sampling interval of a log is constant, up to the resolution of its clock.
            if ((pair[1] - pair[0]) - step_s).abs() > 1e-9 * step_s {
                step_s = pair[1] - pair[0];
                step = exponential(&(&self.matrix * step_s))?;
            }
            x = &step * &x;
            angles.push(self.rest_rad + x[0]);
        }
        Ok(angles)
    }
}

/// The spin-up linearised at rest: φ̈ = a φ̇ + b i.
pub(super) struct LinearSpinUp {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
}

impl LinearSpinUp {
    pub(super) fn of(model: &Model, values: &[f64]) -> LinearSpinUp {
        let (smooth_model, smooth_values) = smooth_part(model, values);
        let constants: Vec<Dual<2>> = smooth_values.iter().map(|v| Dual::constant(*v)).collect();
        let linear = Plant::new(&smooth_model, &constants, Kind::SpinUp);
        let at = State {
            wheel_speed_rad_s: Dual::variable(0.0, 0),
            ..State::rest()
        };
        let (_, slope) = linear.derivative(&at, Dual::variable(0.0, 1), 0.0);
        LinearSpinUp {
            a: DMatrix::from_element(1, 1, slope.derivatives[0]),
            b: DMatrix::from_element(1, 1, slope.derivatives[1]),
        }
    }

    /// Wheel speed in rad/s at the samples; the current is held between them.
    pub(super) fn run(
        &self,
        start_rad_s: f64,
        time_s: &[f64],
        current_a: &[f64],
    ) -> Result<Vec<f64>, SimulateError> {
        let mut speeds = vec![start_rad_s];
        let mut step_s = f64::NAN;
        let mut hold = None;
        for (pair, current) in time_s.windows(2).zip(current_a) {
            let interval_s = pair[1] - pair[0];
            if interval_s != step_s {
                step_s = interval_s;
                hold = Some(zero_order_hold(&self.a, &self.b, step_s)?);
            }
            if let (Some(hold), Some(speed)) = (&hold, speeds.last()) {
                speeds.push(hold.state[0] * speed + hold.input[0] * current);
            }
        }
        Ok(speeds)
    }
}

/// The part of a model that has a Jacobian at rest, with its parameters.
pub(super) fn smooth_part(model: &Model, values: &[f64]) -> (Model, Vec<f64>) {
    let effects: Vec<_> = model
        .effects()
        .iter()
        .copied()
        .filter(|effect| effect.info().linearised == Linearised::Exactly)
        .collect();
    let part = Model::with_effects(&effects);
    let values = values_of(&part, model, values);
    (part, values)
}
