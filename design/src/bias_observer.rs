//! An observer that estimates a constant bias of the measured angle, so that the wheel comes to rest.
//!
//! The measured state is y = x + b e₁ with an unknown constant b (rad). With x⁺ = Ad x + Bd u,
//!
//! ```text
//! y⁺ − Ad y − Bd u = c b,   c = (I − Ad) e₁
//! ```
//!
//! so every step shows b through c: the body is measured to lean, but does not fall. A reduced
//! Luenberger observer (with one state) averages this, b̂⁺ = b̂ + ℓᵀ(y⁺ − Ad y − Bd u − c b̂), and its
//! error decays with λ = 1 − ℓᵀc. In causal form, with z = b̂ − ℓᵀy,
//!
//! ```text
//! b̂ = z + ℓᵀ y,   u = −K (y − b̂ e₁),   z⁺ = λ z + (λ ℓᵀ − ℓᵀ Ad) y − ℓᵀ Bd u
//! ```
//!
//! (D. Luenberger, "Observers for multivariable systems", IEEE TAC 11(2), 1966). The poles are
//! those of the regulator, and λ. If u is the current after saturation, the observer does not
//! wind up. Two more properties follow from the equation of rest. At rest with b̂ = b, the wheel
//! stands still for *any* true parameters. A constant torque d on the body acts like the bias
//! −d/G, so the observer stops the wheel in that case, too.
//!
//! ℓ is the direction with the least sensor noise: with noise covariance R of y, ℓ ∝ R⁻¹c.

use crate::controller::LinearController;
use crate::error::DesignError;
use crate::matrix::{check_positive, of_model};
use crate::zero_order_hold::zero_order_hold;
use nalgebra::{DMatrix, DVector, RowVector3, Vector3};
use plant::LinearModel;

/// The observer in the form that the controller executes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BiasObserver {
    /// λ, dimensionless.
    pub decay: f64,
    /// ℓᵀ: direct feedthrough from the measured state to the estimate; rad per unit of each state.
    pub direct: RowVector3<f64>,
    /// λ ℓᵀ − ℓᵀ Ad: from the measured state into z; rad per unit of each state.
    pub from_measurement: RowVector3<f64>,
    /// −ℓᵀ Bd: from the current into z, in rad/A.
    pub from_current: f64,
    /// −T/ln λ in s.
    pub time_constant_s: f64,
}

impl BiasObserver {
    /// The observer for `model` sampled at `sample_time_s`, whose error decays with the time constant
    /// `time_constant_s`. `noise` is the standard deviation of each measured state (angle in rad,
    /// rate in rad/s, wheel speed in rad/s); only the ratios matter.
    ///
    /// # Errors
    /// Quantities that are not positive, entries that are not finite;
    /// [`DesignError::NotAPendulum`] if a bias has no effect (no gravity).
    pub fn new(
        model: &LinearModel,
        sample_time_s: f64,
        time_constant_s: f64,
        noise: &Vector3<f64>,
    ) -> Result<Self, DesignError> {
        check_positive(
            "the time constant of the bias observer in s",
            time_constant_s,
        )?;
        for deviation in noise {
            check_positive("the standard deviation of a measured state", *deviation)?;
        }
        let (a, b) = of_model(model)?;
        let hold = zero_order_hold(&a, &b, sample_time_s)?;
        let mut unit = DVector::zeros(3);
        unit[0] = 1.0;
        let trace = &unit - &hold.state * &unit;
        let weighted = DVector::from_fn(3, |row, _| trace[row] / noise[row].powi(2));
        let seen = weighted.dot(&trace);
        if seen == 0.0 {
            return Err(DesignError::NotAPendulum {
                what: "the bias observer",
                why: "without gravity, a bias of the angle has no effect that could be observed",
            });
        }
        let decay = (-sample_time_s / time_constant_s).exp();
        let direct = (weighted * ((1.0 - decay) / seen)).transpose();
        let from_measurement = &direct * decay - &direct * &hold.state;
        Ok(BiasObserver {
            decay,
            from_measurement: RowVector3::from_iterator(from_measurement.iter().copied()),
            from_current: -(&direct * &hold.input)[0],
            direct: RowVector3::from_iterator(direct.iter().copied()),
            time_constant_s,
        })
    }

    /// b̂ in rad from the observer's state z and the measured state.
    pub fn estimate_rad(&self, state: f64, measured: &Vector3<f64>) -> f64 {
        state + (self.direct * measured)[0]
    }

    /// The next z, from z, the measured state and the commanded current in A.
    pub fn advance(&self, state: f64, measured: &Vector3<f64>, current_a: f64) -> f64 {
        self.decay * state + (self.from_measurement * measured)[0] + self.from_current * current_a
    }

    /// Regulator and observer as one controller from measured state to current, for the margins:
    /// u = −K (y − b̂ e₁) inserted into the observer's equations.
    pub fn controller(&self, gains: &RowVector3<f64>) -> LinearController {
        let output = gains[0];
        let feedthrough = self.direct * gains[0] - gains;
        let measurement = self.from_measurement + feedthrough * self.from_current;
        LinearController {
            state: DMatrix::from_element(1, 1, self.decay + self.from_current * output),
            measurement: DMatrix::from_row_slice(1, 3, measurement.as_slice()),
            output: DMatrix::from_element(1, 1, output),
            feedthrough: DMatrix::from_row_slice(1, 3, feedthrough.as_slice()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::margins::margins;
    use crate::poles::eigenvalues;
    use crate::thesis;
    use proptest::prelude::*;

    const NOISE: Vector3<f64> = Vector3::new(2e-3, 1e-3, 0.5);
    const SAMPLE_TIME: f64 = 1e-3;

    fn observer() -> BiasObserver {
        BiasObserver::new(&thesis::model(), SAMPLE_TIME, 1.0, &NOISE).unwrap()
    }

    /// Runs the loop around `model` with a bias of the measured angle and a constant current
    /// limit; (final state, b̂).
    fn run(
        model: &LinearModel,
        bias: f64,
        observer: Option<&BiasObserver>,
        seconds: f64,
    ) -> (DVector<f64>, f64) {
        let (a, b) = of_model(model).unwrap();
        let hold = zero_order_hold(&a, &b, SAMPLE_TIME).unwrap();
        let gains = thesis::golden_gains();
        let mut x = DVector::zeros(3);
        let (mut z, mut estimate) = (0.0, 0.0);
        for _ in 0..(seconds / SAMPLE_TIME) as usize {
            let measured = Vector3::new(x[0] + bias, x[1], x[2]);
            if let Some(observer) = observer {
                estimate = observer.estimate_rad(z, &measured);
            }
            let corrected = measured - Vector3::new(estimate, 0.0, 0.0);
            let current = -(gains * corrected)[0];
            let current = current.clamp(-2.0, 2.0);
            if let Some(observer) = observer {
                z = observer.advance(z, &measured, current);
            }
            x = &hold.state * x + hold.input.column(0) * current;
        }
        (x, estimate)
    }

    #[test]
    fn one_degree_no_longer_turns_the_wheel() {
        let degree = 1.0_f64.to_radians();
        let (without, _) = run(&thesis::model(), degree, None, 30.0);
        assert!((without[2] + 19.2).abs() < 0.05, "{}", without[2]);
        let (with, estimate) = run(&thesis::model(), degree, Some(&observer()), 30.0);
        assert!(with[2].abs() < 1e-6, "{}", with[2]);
        assert!((estimate - degree).abs() < 1e-9);
    }

    #[test]
    fn the_estimate_decays_as_designed() {
        // The decay does not depend on the motion of the loop meanwhile, nor on its current limit.
        let bias = 0.02;
        for seconds in [0.5, 1.0, 2.0] {
            let (_, estimate) = run(&thesis::model(), bias, Some(&observer()), seconds);
            // The last estimate belongs to the sample before the last state. The first one is b̂ = ℓᵀy.
            let steps = (seconds / SAMPLE_TIME) as i32 - 1;
            let start = observer().direct[0] * bias;
            let left = (bias - start) * observer().decay.powi(steps);
            assert!(
                (bias - estimate - left).abs() < 1e-9,
                "{estimate} after {seconds}"
            );
        }
    }

    #[test]
    fn poles_are_those_of_regulator_and_observer() {
        let hold = zero_order_hold(&thesis::a(), &thesis::b(), SAMPLE_TIME).unwrap();
        let gains = thesis::golden_gains();
        let mut separate = eigenvalues(
            &LinearController::state_feedback(&gains)
                .closed_loop(&hold.state, &hold.input)
                .unwrap(),
        )
        .unwrap();
        separate.push(observer().decay.into());
        separate.sort_by(|left, right| left.re.total_cmp(&right.re));
        let together = observer()
            .controller(&gains)
            .closed_loop(&hold.state, &hold.input)
            .unwrap();
        for (pole, golden) in eigenvalues(&together).unwrap().iter().zip(separate) {
            assert!((pole - golden).norm() < 1e-9, "{pole} {golden}");
        }
    }

    #[test]
    fn the_observer_takes_little_of_the_margins() {
        let (a, b) = (thesis::a(), thesis::b());
        let gains = thesis::golden_gains();
        let plain = margins(
            &a,
            &b,
            &LinearController::state_feedback(&gains),
            SAMPLE_TIME,
        )
        .unwrap();
        let with = margins(&a, &b, &observer().controller(&gains), SAMPLE_TIME).unwrap();
        assert!(
            with.phase_margin_rad > 0.85 * plain.phase_margin_rad,
            "{with:?}"
        );
        assert!(
            with.delay_margin_s > 0.85 * plain.delay_margin_s,
            "{with:?}"
        );
    }

    #[test]
    fn least_noise_passes_through_the_chosen_direction() {
        let observer = observer();
        let noise_of = |direct: &RowVector3<f64>| direct.component_mul(&NOISE.transpose()).norm();
        let least = noise_of(&observer.direct);
        let hold = zero_order_hold(&thesis::a(), &thesis::b(), SAMPLE_TIME).unwrap();
        let trace = Vector3::new(
            1.0 - hold.state[(0, 0)],
            -hold.state[(1, 0)],
            -hold.state[(2, 0)],
        );
        for other in [Vector3::x(), Vector3::y(), Vector3::z()] {
            // Every direction is scaled so that the observer has the same decay.
            let scaled = other.transpose() * ((1.0 - observer.decay) / other.dot(&trace));
            assert!(noise_of(&scaled) >= least);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(30))]
        /// The bench differs from the model by up to 15 %: the wheel still comes to rest.
        #[test]
        fn the_wheel_rests_whatever_the_true_parameters(
            scale in prop::array::uniform6(-0.15..0.15_f64),
            bias in -0.01..0.01_f64,
        ) {
            let mut parameters = thesis::PARAMETERS;
            for (parameter, scale) in parameters.iter_mut().zip(scale) {
                *parameter *= 1.0 + scale;
            }
            let bench = thesis::model_of(parameters);
            let (rest, estimate) = run(&bench, bias, Some(&observer()), 60.0);
            prop_assert!(rest[2].abs() < 1e-6, "wheel at {}", rest[2]);
            prop_assert!((estimate - bias).abs() < 1e-9);
        }
    }

    #[test]
    fn bad_settings_are_named() {
        let model = thesis::model();
        assert!(BiasObserver::new(&model, SAMPLE_TIME, 0.0, &NOISE).is_err());
        assert!(BiasObserver::new(&model, SAMPLE_TIME, 1.0, &Vector3::zeros()).is_err());
        let mut weightless = model;
        weightless.state[(1, 0)] = 0.0;
        weightless.state[(2, 0)] = 0.0;
        assert!(matches!(
            BiasObserver::new(&weightless, SAMPLE_TIME, 1.0, &NOISE),
            Err(DesignError::NotAPendulum { .. })
        ));
    }
}
