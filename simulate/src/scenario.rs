//! The runs of the thesis: the transient of figure 4.4, the disturbance rejection of figure 4.5,
//! and half a minute with pushes, figure 5.1.
//!
//! The thesis prints neither the start angle nor the size of its pushes. Here they are defined relative to the
//! bench, to be comparable between benches. The start is 60 % of the largest angle
//! that the current allows, asin(T/G). A push lasts about half a radian of the fall, 1/ω with
//! ω² = G/(Θ − j_w), and its size is a share of the motor's torque T.

use crate::closed_loop::{ClosedLoop, LoopTrace, at_rest};
use crate::error::{SimulateError, check_positive};
use crate::law::Law;
use crate::push::Push;
use plant::State;

/// A run: its start, its duration and its disturbances.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// A short name, for files and headings.
    pub name: &'static str,
    /// The purpose of the run in one sentence.
    pub about: &'static str,
    /// The start.
    pub start: State<f64>,
    /// The duration in s.
    pub duration_s: f64,
    /// The pushes on the body.
    pub pushes: Vec<Push>,
}

/// The parameters of a bench that determine the size of its scenarios; SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// T = τ u_max in N m.
    pub largest_torque: f64,
    /// G in N m.
    pub gravity_torque: f64,
    /// Θ − j_w in kg m².
    pub carried_inertia: f64,
}

impl Scale {
    /// The scale of a bench with this current limit, from its parameters in the order of
    /// [`plant::Model::parameters`].
    ///
    /// # Errors
    /// Quantities that are not positive.
    pub fn new(values: &[f64], current_limit_a: f64) -> Result<Scale, SimulateError> {
        let scale = Scale {
            largest_torque: values[plant::TORQUE_CONSTANT] * current_limit_a,
            gravity_torque: values[plant::GRAVITY_TORQUE],
            carried_inertia: values[plant::TOTAL_INERTIA] - values[plant::WHEEL_INERTIA],
        };
        check_positive(
            "the largest torque of the motor in N m",
            scale.largest_torque,
        )?;
        check_positive("the gravity torque in N m", scale.gravity_torque)?;
        check_positive(
            "total_inertia - wheel_inertia in kg m2",
            scale.carried_inertia,
        )?;
        Ok(scale)
    }

    /// The largest angle at which the motor can hold the body, asin(T/G), in rad.
    pub fn holding_angle_rad(&self) -> f64 {
        (self.largest_torque / self.gravity_torque).min(1.0).asin()
    }

    fn push(&self, time_s: f64, share: f64) -> Push {
        let fall_s = (self.carried_inertia / self.gravity_torque).sqrt();
        Push::new(time_s, share * self.largest_torque, 0.5 * fall_s)
    }
}

impl Scenario {
    /// Figure 4.4: released at 60 % of the largest angle.
    pub fn transient(scale: &Scale) -> Scenario {
        Scenario {
            name: "transient",
            about: "the body is released at 60 % of the largest angle that the current allows",
            start: at_rest(0.6 * scale.holding_angle_rad()),
            duration_s: 3.0,
            pushes: vec![],
        }
    }

    /// Figure 4.5: one push on the balanced body.
    pub fn disturbance(scale: &Scale) -> Scenario {
        Scenario {
            name: "disturbance",
            about: "one push on the balanced body, f = a exp(-b (t - ti)^2)",
            start: at_rest(0.0),
            duration_s: 4.0,
            pushes: vec![scale.push(1.0, 0.4)],
        }
    }

    /// Figure 5.1: half a minute with pushes to either side.
    pub fn half_minute(scale: &Scale) -> Scenario {
        Scenario {
            name: "half-minute",
            about: "30 s of balancing with pushes to either side",
            start: at_rest(0.2 * scale.holding_angle_rad()),
            duration_s: 30.0,
            pushes: [
                (5.0, 0.3),
                (10.0, -0.4),
                (15.0, 0.5),
                (20.0, -0.3),
                (22.0, -0.3),
                (26.0, 0.4),
            ]
            .map(|(time_s, share)| scale.push(time_s, share))
            .to_vec(),
        }
    }

    /// The three scenarios.
    pub fn all(scale: &Scale) -> [Scenario; 3] {
        [
            Scenario::transient(scale),
            Scenario::disturbance(scale),
            Scenario::half_minute(scale),
        ]
    }

    /// Runs every law on its own copy of the bench `on`, with the same noise, and with the scenario's
    /// pushes instead of those of `on`.
    ///
    /// # Errors
    /// Times that are not positive; a law that fails; a motion that is no longer finite.
    pub fn run(
        &self,
        on: &ClosedLoop<'_>,
        laws: &mut [&mut dyn Law],
    ) -> Result<Vec<LoopTrace>, SimulateError> {
        let disturbed = ClosedLoop {
            pushes: self.pushes.clone(),
            ..on.clone()
        };
        laws.iter_mut()
            .map(|law| disturbed.run(&self.start, self.duration_s, *law, false))
            .collect()
    }
}
