//! The bench around an emitted controller.

use super::controller::RawController;
use super::sensors::RawSensors;
use crate::closed_loop::{Actuator, Answer, ClosedLoop, Instant, LoopTrace, at_rest};
use crate::error::SimulateError;
use crate::law::Measured;
use crate::motion::Motion;
use crate::push::Push;
use crate::recovery::{Recovery, bisect, decided_after_s};
use crate::scenario::Scale;
use crate::sensors::Sensors;
use plant::Plant;
use rand_chacha::ChaCha8Rng;

/// The bench around an emitted controller.
#[derive(Clone, Debug)]
pub struct RawLoop<'a> {
    /// The plant.
    pub plant: &'a Plant<f64>,
    /// Sensors and drive.
    pub sensors: RawSensors,
    /// Largest current of a current drive, A; a voltage drive does not use it.
    pub drive_limit_a: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// Time in s for which the body is held at its start, before the controller is armed and the body is released. The
    /// filter aligns during this time.
    pub held_s: f64,
    /// Whether the firmware asks to arm before every sample after the release, whatever the status. Otherwise it asks
    /// once, at the release.
    pub asks_again: bool,
    /// Pushes on the body; their times count from the release.
    pub pushes: Vec<Push>,
    /// Seed of the sensors' noise.
    pub seed: u64,
}

impl<'a> RawLoop<'a> {
    /// `plant` with these sensors at 1 kHz and the drive of the thesis, held for 1 s.
    pub fn new(plant: &'a Plant<f64>, sensors: RawSensors, seed: u64) -> RawLoop<'a> {
        RawLoop {
            plant,
            sensors,
            drive_limit_a: Actuator::OF_THE_THESIS.limit_a,
            sample_time_s: 1e-3,
            held_s: 1.0,
            asks_again: false,
            pushes: Vec::new(),
            seed,
        }
    }

    /// Holds the body at `angle_rad` from upright while the filter aligns. Then arms `controller`
    /// and runs it for `duration_s`, or, if `until_fall` is set, until the body is horizontal. The measured
    /// angle in the record is that of the controller, the measured wheel speed that of the sensor's counts (with an
    /// encoder the true one); the rate is the true one.
    ///
    /// # Errors
    /// Times that are not positive; emitted code that fails; a motion that is no longer finite.
    pub fn run(
        &self,
        angle_rad: f64,
        duration_s: f64,
        controller: &mut dyn RawController,
        until_fall: bool,
    ) -> Result<LoopTrace, SimulateError> {
        let start = at_rest(angle_rad);
        let on = ClosedLoop {
            motion: Motion::Nonlinear(self.plant),
            sensors: Sensors::PERFECT,
            actuator: Actuator {
                // The supply limits the voltage, and so the duty, not the current.
                limit_a: match self.sensors.voltage {
                    Some(_) => f64::MAX,
                    None => self.drive_limit_a,
                },
                step_a: 0.0,
            },
            sample_time_s: self.sample_time_s,
            computation_s: 0.0,
            pushes: self.pushes.clone(),
            seed: self.seed,
        };
        controller.reset();
        let held = (self.held_s / self.sample_time_s).round() as usize;
        let mut is_held = true;
        let sample = |instant: &Instant<'_>, random: &mut ChaCha8Rng| {
            if is_held {
                for _ in 0..held {
                    controller.step(&self.sensors.sample(&start, 0.0, random))?;
                }
                controller.arm()?;
                is_held = false;
            } else if self.asks_again {
                controller.arm()?;
            }
            let (acceleration, _) =
                self.plant
                    .derivative(instant.state, instant.flowing_a, instant.push);
            let counts = self.sensors.sample(instant.state, acceleration, random);
            let duty = controller.step(&counts)?;
            let speed = instant.state.wheel_speed_rad_s;
            let of_wheel = |current_a: f64| {
                self.plant
                    .derivative(instant.state, current_a, instant.push)
                    .1
            };
            let period_s = self.sample_time_s;
            Ok(Answer {
                measured: Measured {
                    angle_rad: controller.angle_rad()?,
                    rate_rad_s: instant.state.rate_rad_s,
                    wheel_speed_rad_s: self
                        .sensors
                        .wheel_speed_rad_s(counts.wheel)
                        .unwrap_or(speed),
                },
                command_a: self.sensors.mean_current_a(duty, speed, period_s, of_wheel),
            })
        };
        on.run_sampled(&start, duration_s, sample, |trace| {
            until_fall && trace.fell_at_s.is_some()
        })
        .map(|(trace, _)| trace)
    }

    /// The largest angle from which `controller` brings the body back, with the error
    /// `resolution_rad`.
    ///
    /// # Errors
    /// Times or a resolution that are not positive; emitted code that fails; a motion that is no longer finite.
    pub fn largest_recoverable_angle(
        &self,
        scale: &Scale,
        controller: &mut dyn RawController,
        resolution_rad: f64,
    ) -> Result<Recovery, SimulateError> {
        bisect(scale, resolution_rad, |angle_rad| {
            self.run(angle_rad, decided_after_s(scale), controller, true)
                .map(|trace| trace.fell_at_s.is_none())
        })
    }
}
