//! The controlled plant: the nonlinear one, or its linear model.

use nalgebra::Vector3;
use plant::{Drive, Late, LinearModel, Plant, Reading, State};
use std::f64::consts::PI;

/// The linear model as a plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearMotion {
    /// ẋ = A x + B u about upright.
    pub model: LinearModel,
    /// 1/(Θ − j_w) in 1/(kg m²): a push f enters as (0, 1, −1)ᵀ f/(Θ − j_w).
    pub per_push: f64,
}

impl LinearMotion {
    fn derivative(&self, x: &Vector3<f64>, current_a: f64, push: f64) -> Vector3<f64> {
        let push = push * self.per_push;
        self.model.state * x + self.model.input * current_a + Vector3::new(0.0, push, -push)
    }

    /// One step of the classical Runge-Kutta method.
    fn step(&self, x: &Vector3<f64>, drive: &Drive<f64>, h: f64) -> Vector3<f64> {
        let [start, middle, end] = drive.push;
        let u = drive.current_a;
        let k1 = self.derivative(x, u, start);
        let k2 = self.derivative(&(x + k1 * (0.5 * h)), u, middle);
        let k3 = self.derivative(&(x + k2 * (0.5 * h)), u, middle);
        let k4 = self.derivative(&(x + k3 * h), u, end);
        x + (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0)
    }
}

/// The plant of a loop.
#[derive(Clone, Copy, Debug)]
pub enum Motion<'a> {
    /// The model with all its effects.
    Nonlinear(&'a Plant<f64>),
    /// Its linear model.
    Linear(&'a LinearMotion),
}

impl Motion<'_> {
    /// The sensors with a lag or a delay, in a run from `start` before which everything stood still; `None` if the
    /// plant has none.
    pub fn late_sensors(&self, start: &State<f64>) -> Option<Late<f64>> {
        match self {
            Motion::Nonlinear(plant) => plant.late_sensors(start),
            Motion::Linear(_) => None,
        }
    }

    /// The state under `drive` at the end of a span of time.
    pub fn step(
        &self,
        state: &State<f64>,
        drive: &Drive<f64>,
        (from_s, to_s): (f64, f64),
        late: Option<&mut Late<f64>>,
    ) -> State<f64> {
        match self {
            Motion::Nonlinear(plant) => plant.step_with(state, drive, (from_s, to_s), late),
            Motion::Linear(linear) => {
                let step_s = to_s - from_s;
                let x = Vector3::new(
                    state.angle_rad - PI,
                    state.rate_rad_s,
                    state.wheel_speed_rad_s,
                );
                let x = linear.step(&x, drive, step_s);
                State {
                    angle_rad: x[0] + PI,
                    rate_rad_s: x[1],
                    wheel_speed_rad_s: x[2],
                    current_a: drive.current_a,
                    ..*state
                }
            }
        }
    }

    /// The readings of the model's sensors, without noise.
    pub fn read(&self, state: &State<f64>, late: Option<&Late<f64>>, time_s: f64) -> Reading<f64> {
        match self {
            Motion::Nonlinear(plant) => plant.read_late(state, late, time_s),
            Motion::Linear(_) => Reading {
                angle_rad: state.angle_rad,
                rate_rad_s: state.rate_rad_s,
                wheel_speed_rad_s: state.wheel_speed_rad_s,
            },
        }
    }

    /// The delay of the current in the model, s.
    pub fn delay_s(&self) -> f64 {
        match self {
            Motion::Nonlinear(plant) => plant.delay_s().unwrap_or(0.0).max(0.0),
            Motion::Linear(_) => 0.0,
        }
    }
}
