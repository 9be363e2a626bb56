//! The effect of the sensors' noise on the loop: the motion of the body, and the fluctuation of the current.
//!
//! The law sees x + v, with v normal, independent from sample to sample. Then u = −K (x + v), and the covariance P of
//! the loop's state settles where P = M P Mᵀ + Bv R Bvᵀ (the discrete Lyapunov equation; Kwakernaak and Sivan, "Linear
//! Optimal Control Systems", 1972, section 6.2). It is summed by doubling: after k steps the sum has 2ᵏ terms.

use nalgebra::{DMatrix, RowVector3};

use crate::controller::LinearController;
use crate::error::DesignError;
use crate::late::{LatePlant, Lateness};
use crate::matrix::{check_finite, of_model};
use crate::poles::spectral_radius;
use plant::LinearModel;

/// Standard deviations of the noise of a single sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNoise {
    /// Noise of the angle, rad.
    pub angle_rad: f64,
    /// Noise of the rate, rad/s.
    pub rate_rad_s: f64,
    /// Noise of the wheel speed, rad/s.
    pub wheel_speed_rad_s: f64,
}

/// Standard deviations in the loop if noise is the only disturbance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseInLoop {
    /// Standard deviation of the true angle, rad.
    pub angle_rad: f64,
    /// Standard deviation of the true wheel speed, rad/s.
    pub wheel_speed_rad_s: f64,
    /// Standard deviation of the commanded current, A.
    pub current_a: f64,
}

/// Largest number of doublings: 2⁶⁰ samples are longer than any bench runs.
const MOST_DOUBLINGS: usize = 60;

/// The effect of `noise` on the loop of u = −`gains` x around `model`, with the current `delay_s` (s) late.
///
/// # Errors
/// [`DesignError::UnstableLoop`]; numbers that are not finite.
pub fn noise_in_loop(
    model: &LinearModel,
    gains: &RowVector3<f64>,
    sample_time_s: f64,
    delay_s: f64,
    noise: &SensorNoise,
) -> Result<NoiseInLoop, DesignError> {
    let controller = LinearController::state_feedback(gains);
    let lateness = Lateness::of_current(delay_s);
    noise_in_late_loop(model, &controller, sample_time_s, &lateness, noise)
}

/// The effect of `noise` on the loop of any linear controller, with delays of current and sensors. `noise` is the noise
/// of the readings, after the sensors' filters.
///
/// # Errors
/// [`DesignError::UnstableLoop`]; numbers that are not finite.
pub fn noise_in_late_loop(
    model: &LinearModel,
    controller: &LinearController,
    sample_time_s: f64,
    lateness: &Lateness,
    noise: &SensorNoise,
) -> Result<NoiseInLoop, DesignError> {
    let (a, b) = of_model(model)?;
    let plant = LatePlant::new(&a, &b, sample_time_s, lateness)?.augmented();
    let seeing = controller.seeing(&plant.output)?;
    let closed = seeing.closed_loop(&plant.state, &plant.input)?;
    check_finite("the closed loop", &closed)?;
    let radius = spectral_radius(&closed)?;
    if radius >= 1.0 {
        return Err(DesignError::UnstableLoop {
            loop_name: "whose noise is wanted",
            spectral_radius: radius,
            cure: "raise the current weight, or shorten the delay",
        });
    }
    let (states, size) = (plant.state.nrows(), closed.nrows());
    let stds = DMatrix::from_diagonal(&nalgebra::dvector![
        noise.angle_rad,
        noise.rate_rad_s,
        noise.wheel_speed_rad_s
    ]);
    // The noise of a sample enters the plant through the command, and enters the controller directly.
    let mut enters = DMatrix::zeros(size, 3);
    enters
        .rows_mut(0, states)
        .copy_from(&(&plant.input * &controller.feedthrough * &stds));
    enters
        .rows_mut(states, size - states)
        .copy_from(&(&controller.measurement * &stds));
    let command_variance = (&controller.feedthrough * &stds).norm_squared();
    // The part of the command that follows from the states, without the noise of this sample.
    let mut command = DMatrix::zeros(1, size);
    command
        .columns_mut(0, states)
        .copy_from(&seeing.feedthrough);
    command
        .columns_mut(states, size - states)
        .copy_from(&controller.output);
    let mut covariance: DMatrix<f64> = &enters * enters.transpose();
    let mut leap = closed;
    for _ in 0..MOST_DOUBLINGS {
        let more = &leap * &covariance * leap.transpose();
        let (growth, size) = (more.amax(), covariance.amax());
        covariance += more;
        if growth <= 1e-14 * size {
            break;
        }
        leap = &leap * &leap;
    }
    let by_state = (&command * &covariance * command.transpose())[0];
    let root = |variance: f64| variance.max(0.0).sqrt();
    Ok(NoiseInLoop {
        angle_rad: root(covariance[(0, 0)]),
        wheel_speed_rad_s: root(covariance[(2, 2)]),
        // State and noise of the same sample are independent: their variances add.
        current_a: root(by_state + command_variance),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis;
    use crate::zero_order_hold::zero_order_hold;
    use nalgebra::Vector3;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const NOISE: SensorNoise = SensorNoise {
        angle_rad: 1e-3,
        rate_rad_s: 4e-3,
        wheel_speed_rad_s: 0.6,
    };

    /// The same standard deviations from a simulation of the difference equation. A queue of commands makes delays of
    /// whole samples.
    #[test]
    fn simulation_agrees() {
        let hold = zero_order_hold(&thesis::a(), &thesis::b(), 1e-3).unwrap();
        let gains = thesis::golden_gains();
        for (late, seed) in [(0_usize, 11_u64), (2, 12)] {
            let found =
                noise_in_loop(&thesis::model(), &gains, 1e-3, late as f64 * 1e-3, &NOISE).unwrap();
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
            let mut state = Vector3::zeros();
            let mut queue = std::collections::VecDeque::from(vec![0.0; late]);
            let samples = 600_000;
            let (mut angle, mut wheel, mut current) = (0.0, 0.0, 0.0);
            for _ in 0..samples {
                let seen = state + Vector3::new(1e-3 * draw(), 4e-3 * draw(), 0.6 * draw());
                let command = -(gains * seen)[0];
                queue.push_back(command);
                let acting = queue.pop_front().unwrap();
                angle += state[0] * state[0];
                wheel += state[2] * state[2];
                current += command * command;
                let next = &hold.state * state + hold.input.column(0) * acting;
                state = Vector3::new(next[0], next[1], next[2]);
            }
            let std = |sum: f64| (sum / f64::from(samples)).sqrt();
            // The slowest motion of the loop takes 0.22 s, so 600 s contain some 1400 independent values: a standard
            // error of 1/√2800 = 1.9 %. The tolerance is four standard errors.
            for (simulated, exact) in [
                (std(angle), found.angle_rad),
                (std(wheel), found.wheel_speed_rad_s),
                (std(current), found.current_a),
            ] {
                assert!(
                    (simulated / exact - 1.0).abs() < 0.076,
                    "seed {seed}, late {late}: {simulated} {exact}"
                );
            }
        }
    }

    /// Without noise nothing moves, and twice the noise doubles every standard deviation.
    #[test]
    fn unrest_is_proportional_to_noise() {
        let gains = thesis::golden_gains();
        let of = |factor: f64| {
            let noise = SensorNoise {
                angle_rad: factor * NOISE.angle_rad,
                rate_rad_s: factor * NOISE.rate_rad_s,
                wheel_speed_rad_s: factor * NOISE.wheel_speed_rad_s,
            };
            noise_in_loop(&thesis::model(), &gains, 1e-3, 0.5e-3, &noise).unwrap()
        };
        assert_eq!(of(0.0).current_a, 0.0);
        assert!((of(2.0).angle_rad / of(1.0).angle_rad - 2.0).abs() < 1e-9);
        // The current fluctuates by at least the gains times the noise of the same sample.
        let straight = (24.2672423_f64 * 1e-3)
            .hypot(2.12973867 * 4e-3)
            .hypot(0.0225875821 * 0.6);
        assert!(of(1.0).current_a > straight && of(1.0).current_a < 1.5 * straight);
    }

    #[test]
    fn an_unstable_loop_has_no_noise() {
        let none = noise_in_loop(&thesis::model(), &RowVector3::zeros(), 1e-3, 0.0, &NOISE);
        assert!(matches!(none, Err(DesignError::UnstableLoop { .. })));
    }
}
