//! A controller around a bench whose current and sensors are late, and the law that predicts the state at which a late
//! current arrives.

use crate::controller::LinearController;
use crate::error::DesignError;
use crate::late::{Delay, LatePlant, Lateness};
use crate::matrix::check_shape;
use crate::zero_order_hold::held_for;
use nalgebra::{DMatrix, RowVector3};

impl LinearController {
    /// The state matrix of the loop with ẋ = A x + B u, sampled at `sample_time_s`, if the
    /// current reaches the plant with the delay `delay_s` (any delay, not only whole samples). Its states are
    /// (x, u₋₁, u₋₂, …, c).
    ///
    /// # Errors
    /// Wrong shapes, a sample time that is not positive, a negative delay.
    pub fn closed_loop_with_delay(
        &self,
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        sample_time_s: f64,
        delay_s: f64,
    ) -> Result<DMatrix<f64>, DesignError> {
        self.late_closed_loop(a, b, sample_time_s, &Lateness::of_current(delay_s))
    }

    /// The state matrix of the loop with ẋ = A x + B u, sampled at `sample_time_s`, with current and sensors late by
    /// any times. Its states are (x, filters of the sensors, past commands, past readings, c).
    ///
    /// # Errors
    /// Wrong shapes, a sample time that is not positive, a negative delay.
    pub fn late_closed_loop(
        &self,
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        sample_time_s: f64,
        lateness: &Lateness,
    ) -> Result<DMatrix<f64>, DesignError> {
        let plant = LatePlant::new(a, b, sample_time_s, lateness)?.augmented();
        self.seeing(&plant.output)?
            .closed_loop(&plant.state, &plant.input)
    }

    /// This controller, reading the sensors y = `output` x, as a controller of the plant's states x.
    pub(crate) fn seeing(&self, output: &DMatrix<f64>) -> Result<LinearController, DesignError> {
        let (order, sensors) = (self.order(), output.nrows());
        check_shape("Bc of the controller", &self.measurement, order, sensors)?;
        check_shape("Dc of the controller", &self.feedthrough, 1, sensors)?;
        Ok(LinearController {
            state: self.state.clone(),
            measurement: &self.measurement * output,
            output: self.output.clone(),
            feedthrough: &self.feedthrough * output,
        })
    }

    /// u = −K x̂, where x̂ is the predicted state of the plant `ahead_s` (s) after the sample: the model carries the
    /// measured state forward under the commands that are on their way. For a current that is late by `ahead_s`, this
    /// law is optimal with the gains of the plant without delay, because no command changes the cost before it arrives.
    /// The controller's states are the commands u₋₁, u₋₂, … that are on their way.
    ///
    /// # Errors
    /// Wrong shapes, a sample time that is not positive, a negative time.
    pub fn predicting(
        gains: &RowVector3<f64>,
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        sample_time_s: f64,
        ahead_s: f64,
    ) -> Result<LinearController, DesignError> {
        Lateness::of_current(ahead_s).check()?;
        let gains = DMatrix::from_row_slice(1, 3, gains.as_slice());
        let ahead = Delay::new(ahead_s, sample_time_s);
        let order = ahead.whole + usize::from(ahead.part_s > 0.0);
        let mut output = DMatrix::zeros(1, order);
        for index in 0..order {
            // With j = index + 1, the command u₋ⱼ arrives at `ahead_s` − j T and acts for one sample time. If that time
            // is negative, it has arrived before this sample and acts only for the rest of its sample time.
            let rest_s = index as f64 * sample_time_s;
            let acts = held_for(a, b, (ahead_s - rest_s).clamp(0.0, sample_time_s))?;
            let rest = held_for(a, b, rest_s)?;
            output[index] = -(&gains * rest.state * acts.input)[0];
        }
        let mut state = DMatrix::zeros(order, order);
        for index in 1..order {
            state[(index, index - 1)] = 1.0;
        }
        let lead = held_for(a, b, ahead_s)?;
        let feedthrough = -(&gains * lead.state);
        let mut measurement = DMatrix::zeros(order, 3);
        if order > 0 {
            // u₋₁ is the command of this sample, at the next one.
            measurement.row_mut(0).copy_from(&feedthrough);
            state.row_mut(0).copy_from(&output);
        }
        Ok(LinearController {
            state,
            measurement,
            output,
            feedthrough,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::late::SensorLateness;
    use crate::margins::late_margins;
    use crate::poles::eigenvalues;
    use crate::thesis;
    use crate::zero_order_hold::zero_order_hold;
    use nalgebra::DVector;

    const T: f64 = 1e-3;

    fn law() -> LinearController {
        LinearController::state_feedback(&thesis::golden_gains())
    }

    /// Simulates the loop independently: the plant in small steps, late currents and readings from tables of the past.
    /// Each filter has the exact response to an input that is held over a small step.
    fn simulate(
        controller: &LinearController,
        lateness: &Lateness,
        samples: usize,
    ) -> DVector<f64> {
        const PARTS: i64 = 200;
        let small_s = T / PARTS as f64;
        let fine = zero_order_hold(&thesis::a(), &thesis::b(), small_s).unwrap();
        let parts = |time_s: f64| (time_s / small_s).round() as i64;
        let mut x = DVector::from_column_slice(&[0.01, 0.0, 0.0]);
        let mut filtered: Vec<DVector<f64>> = Vec::new();
        let mut shown = DVector::zeros(3);
        let mut commands: Vec<f64> = Vec::new();
        let mut c = DVector::zeros(controller.order());
        for part in 0..samples as i64 * PARTS {
            for sensor in 0..3 {
                let lag_s = lateness.sensors[sensor].lag_s;
                if lag_s == 0.0 {
                    shown[sensor] = x[sensor];
                }
            }
            filtered.push(shown.clone());
            if part % PARTS == 0 {
                let y = DVector::from_fn(3, |sensor, _| {
                    let at = part - parts(lateness.sensors[sensor].delay_s);
                    if at < 0 {
                        0.0
                    } else {
                        filtered[at as usize][sensor]
                    }
                });
                commands.push((&controller.output * &c + &controller.feedthrough * &y)[0]);
                c = &controller.state * &c + &controller.measurement * &y;
            }
            let at = part - parts(lateness.current_s);
            let current = if at < 0 {
                0.0
            } else {
                commands[(at / PARTS) as usize]
            };
            let next = &fine.state * &x + fine.input.column(0) * current;
            for sensor in 0..3 {
                let lag_s = lateness.sensors[sensor].lag_s;
                if lag_s > 0.0 {
                    // The mean over the step.
                    let held = 0.5 * (x[sensor] + next[sensor]);
                    shown[sensor] = held + (shown[sensor] - held) * (-small_s / lag_s).exp();
                }
            }
            x = next;
        }
        x
    }

    #[test]
    fn late_sensors_and_a_late_current_match_a_simulation_in_small_steps() {
        let sensor = |lag_s, delay_s| SensorLateness { lag_s, delay_s };
        let cases = [
            (
                0.0,
                [sensor(0.0, 0.25e-3), sensor(0.0, 1e-3), sensor(0.0, 2.5e-3)],
            ),
            (
                0.6e-3,
                [sensor(0.0, 0.0), sensor(0.0, 0.2e-3), sensor(0.0, 0.9e-3)],
            ),
            (
                1e-3,
                [
                    sensor(0.0, 2.2e-3),
                    sensor(4e-3, 0.0),
                    sensor(20e-3, 0.7e-3),
                ],
            ),
            (
                2.3e-3,
                [
                    sensor(1e-3, 0.4e-3),
                    sensor(1e-3, 0.4e-3),
                    sensor(0.0, 3e-3),
                ],
            ),
        ];
        for (current_s, sensors) in cases {
            let lateness = Lateness { current_s, sensors };
            let ahead_s = current_s + 0.4e-3;
            let predicting = LinearController::predicting(
                &thesis::golden_gains(),
                &thesis::a(),
                &thesis::b(),
                T,
                ahead_s,
            )
            .unwrap();
            for controller in [law(), predicting] {
                let closed = controller
                    .late_closed_loop(&thesis::a(), &thesis::b(), T, &lateness)
                    .unwrap();
                let mut x = DVector::zeros(closed.nrows());
                x[0] = 0.01;
                for _ in 0..250 {
                    x = &closed * x;
                }
                let simulated = simulate(&controller, &lateness, 250);
                let size = simulated.norm();
                let difference = (x.rows(0, 3) - &simulated).norm();
                // A filter whose input is held at its mean over a step h is off by (h/T)²/12 in its slope.
                assert!(
                    difference < 3e-5 * size,
                    "{lateness:?}: {difference:e} of {size:e}"
                );
            }
        }
    }

    /// The loop with the predicting law has the poles of the loop without delay, and poles at zero for the commands on
    /// their way (Manitius and Olbrot, "Finite spectrum assignment problem for systems with delays", IEEE TAC 24(4),
    /// 1979).
    #[test]
    fn prediction_gives_back_the_poles_without_delay() {
        let (a, b) = (thesis::a(), thesis::b());
        let plain = law()
            .late_closed_loop(&a, &b, T, &Lateness::default())
            .unwrap();
        let wanted = eigenvalues(&plain).unwrap();
        for ahead_s in [0.0, 0.3e-3, 1e-3, 2.7e-3, 12e-3] {
            let law =
                LinearController::predicting(&thesis::golden_gains(), &a, &b, T, ahead_s).unwrap();
            let closed = law
                .late_closed_loop(&a, &b, T, &Lateness::of_current(ahead_s))
                .unwrap();
            let found = eigenvalues(&closed).unwrap();
            for pole in &wanted {
                let nearest = found
                    .iter()
                    .map(|other| (other - pole).norm())
                    .fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-7, "{ahead_s}: {pole} off by {nearest:e}");
            }
        }
    }

    /// Simulates the loop independently: the plant in small steps, the commands in a queue.
    fn simulate_a_late_current(delay_s: f64, samples: usize) -> DVector<f64> {
        let (a, b) = (thesis::a(), thesis::b());
        let (sample_time, parts) = (1e-3, 100);
        let fine = zero_order_hold(&a, &b, sample_time / f64::from(parts)).unwrap();
        let mut x = DVector::from_column_slice(&[0.01, 0.0, 0.0]);
        let mut commands = Vec::new();
        let late = (delay_s / sample_time * f64::from(parts)).round() as i64;
        for sample in 0..samples {
            commands.push(-(thesis::gains() * &x)[0]);
            for part in 0..parts {
                let at = sample as i64 * i64::from(parts) + i64::from(part) - late;
                let current = if at < 0 {
                    0.0
                } else {
                    commands[(at / i64::from(parts)) as usize]
                };
                x = &fine.state * &x + fine.input.column(0) * current;
            }
        }
        x
    }

    #[test]
    fn delays_of_any_length_match_a_simulation_in_small_steps() {
        let controller = LinearController::state_feedback(&RowVector3::new(
            thesis::gains()[0],
            thesis::gains()[1],
            thesis::gains()[2],
        ));
        for delay_s in [0.0, 0.25e-3, 1e-3, 2.5e-3, 7e-3] {
            let closed = controller
                .closed_loop_with_delay(&thesis::a(), &thesis::b(), 1e-3, delay_s)
                .unwrap();
            let mut x = DVector::zeros(closed.nrows());
            x[0] = 0.01;
            for _ in 0..300 {
                x = &closed * x;
            }
            let small_steps = simulate_a_late_current(delay_s, 300);
            let difference = (x.rows(0, 3) - &small_steps).norm();
            assert!(difference < 1e-9, "{delay_s}: {difference:e}");
        }
    }

    /// A delay of two milliseconds in all sensors reduces the delay margin by two milliseconds.
    #[test]
    fn late_sensors_come_off_the_delay_margin() {
        let margin = |lateness: &Lateness| {
            late_margins(&thesis::a(), &thesis::b(), &law(), T, lateness)
                .unwrap()
                .delay_margin_s
        };
        let late = SensorLateness {
            lag_s: 0.0,
            delay_s: 2e-3,
        };
        let whole = margin(&Lateness::default());
        let left = margin(&Lateness {
            current_s: 0.7e-3,
            sensors: [late; 3],
        });
        assert!((left + 2.7e-3 - whole).abs() < 1e-8, "{left} of {whole}");
    }
}
