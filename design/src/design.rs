//! The complete design in one call.

use crate::accepted::{regulator_with_margins, require_that_the_cost_sees, stable_friction_check};
use crate::angle_bias::sampled_rest_per_angle_bias;
use crate::bias_observer::BiasObserver;
use crate::controller::LinearController;
use crate::dare::DareSolution;
use crate::error::DesignError;
use crate::friction::FrictionCheck;
use crate::lqr::DiscreteRegulator;
use crate::margins::{Margins, margins};
use crate::matrix::{check_positive, of_model};
use crate::poles::{Pole, poles};
use crate::recovery::recovery_angle_rad;
use crate::settings::Settings;
use crate::structural::{StructuralRank, controllability, observability};
use crate::zero_order_hold::Discrete;
use nalgebra::{Complex, DMatrix, RowVector3, Vector3};
use plant::LinearModel;

/// A controller, with the properties of its loop. The states are (angle from upright in rad, rate in
/// rad/s, wheel speed in rad/s), the law is u = −K x.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// The requirements.
    pub settings: Settings,
    /// A (3×3) and B (3×1).
    pub model: LinearModel,
    /// Ad (3×3) and Bd (3×1) of the zero-order hold.
    pub discrete: Discrete,
    /// K in A/rad, A s/rad, A s/rad.
    pub gains: RowVector3<f64>,
    /// Cost to go, residual and number of doublings of the Riccati equation.
    pub riccati: DareSolution,
    /// Eigenvalues of A, in 1/s.
    pub open_loop_poles: Vec<Pole>,
    /// Eigenvalues of Ad − Bd K.
    pub closed_loop_poles: Vec<Pole>,
    /// Whether the current can reach every state, and how well.
    pub controllability: StructuralRank,
    /// Whether angle, rate and wheel speed together show every state, and how well.
    pub observability: StructuralRank,
    /// Whether each sensor alone shows every state, and how well; with the name of the sensor.
    pub observability_of_sensor: [(&'static str, StructuralRank); 3],
    /// The largest angle from which the motor can bring the body back, asin(τ u_max/G), in rad.
    pub recovery_angle_rad: f64,
    /// Gain, phase, delay and modulus margins of the loop.
    pub margins: Margins,
    /// Steady wheel speed per rad of bias of the measured angle, in rad/s per rad.
    pub wheel_speed_per_angle_bias: f64,
    /// The loop at both extremes of Coulomb friction, if they were given.
    pub friction: Option<FrictionCheck>,
}

impl Design {
    /// Designs the controller of `model` for `settings` and checks the loop.
    ///
    /// # Errors
    /// Those of [`crate::discrete_regulator`]; [`DesignError::CostBlind`] if a mode that does not decay by itself does
    /// not enter the cost; [`DesignError::SampleTimeTooLong`] if the loop would become unstable with
    /// the delay of one sample that the computation may take;
    /// [`DesignError::UnstableLoop`] if it is unstable without Coulomb friction;
    /// [`DesignError::NotAPendulum`].
    pub fn new(model: &LinearModel, settings: &Settings) -> Result<Design, DesignError> {
        let (a, b) = of_model(model)?;
        settings.weights.matrices()?;
        check_positive("the sample time in s", settings.sample_time_s)?;
        let recovery_angle_rad = recovery_angle_rad(model, settings.current_limit_a)?;
        require_that_the_cost_sees(model, &settings.weights)?;
        let (regulator, margins) = regulator_with_margins(model, settings)?;
        let DiscreteRegulator {
            discrete,
            gains,
            riccati,
        } = regulator;
        let controller = LinearController::state_feedback(&gains);
        let closed = controller.closed_loop(&discrete.state, &discrete.input)?;
        let friction = settings
            .friction_extremes
            .map(|extremes| stable_friction_check(&extremes, &gains, settings.sample_time_s))
            .transpose()?;
        let rest = sampled_rest_per_angle_bias(model, &gains, settings.sample_time_s)?;
        let sensor = |index: usize| {
            let mut output = DMatrix::zeros(1, 3);
            output[index] = 1.0;
            observability(&a, &output)
        };
        Ok(Design {
            settings: settings.clone(),
            model: *model,
            open_loop_poles: poles(&a)?,
            closed_loop_poles: poles(&closed)?,
            controllability: controllability(&a, &b)?,
            observability: observability(&a, &DMatrix::identity(3, 3))?,
            observability_of_sensor: [
                ("angle", sensor(0)?),
                ("rate", sensor(1)?),
                ("wheel speed", sensor(2)?),
            ],
            recovery_angle_rad,
            margins,
            wheel_speed_per_angle_bias: rest[2],
            friction,
            discrete,
            gains,
            riccati,
        })
    }

    /// Relative residual of the Riccati equation.
    pub fn dare_residual(&self) -> f64 {
        self.riccati.residual
    }

    /// Continuous equivalents of the closed loop's poles, in 1/s.
    pub fn closed_loop_poles_per_s(&self) -> Vec<Complex<f64>> {
        self.closed_loop_poles
            .iter()
            .map(|pole| pole.continuous_equivalent(self.settings.sample_time_s))
            .collect()
    }

    /// An observer of a constant angle bias. It is five times slower than the slowest motion
    /// of the loop, so that the two do not interact; `noise` as in [`BiasObserver::new`].
    ///
    /// # Errors
    /// Those of [`BiasObserver::new`]; [`DesignError::UnstableLoop`] if regulator and observer
    /// together are unstable.
    pub fn bias_observer(&self, noise: &Vector3<f64>) -> Result<BiasObserver, DesignError> {
        let slowest_per_s = self
            .closed_loop_poles_per_s()
            .iter()
            .map(|pole| -pole.re)
            .fold(f64::INFINITY, f64::min);
        let observer = BiasObserver::new(
            &self.model,
            self.settings.sample_time_s,
            5.0 / slowest_per_s,
            noise,
        )?;
        let (a, b) = of_model(&self.model)?;
        margins(
            &a,
            &b,
            &observer.controller(&self.gains),
            self.settings.sample_time_s,
        )?;
        Ok(observer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::FrictionExtremes;
    use crate::thesis;

    fn settings() -> Settings {
        Settings {
            sample_time_s: 1e-3,
            weights: thesis::weights(),
            current_limit_a: 2.0,
            friction_extremes: None,
        }
    }

    #[test]
    fn thesis_bench() {
        let mut settings = settings();
        let mut none = thesis::PARAMETERS;
        none[4] = 2.12e-5;
        settings.friction_extremes = Some(FrictionExtremes {
            none: thesis::model_of(none),
            all: thesis::model(),
            smoothing_speed_rad_s: 0.0846768,
        });
        let design = Design::new(&thesis::model(), &settings).unwrap();
        for (gain, golden) in design.gains.iter().zip(thesis::golden_gains().iter()) {
            assert!((gain - golden).abs() < 3e-9 * golden.abs());
        }
        assert_eq!(design.controllability.rank, 3);
        assert_eq!(design.observability.rank, 3);
        assert!((design.recovery_angle_rad.to_degrees() - 15.86).abs() < 0.005);
        assert!(design.dare_residual() < 1e-12);
        assert!((design.wheel_speed_per_angle_bias.to_radians() + 19.2).abs() < 0.05);
        assert!(
            design
                .closed_loop_poles_per_s()
                .iter()
                .all(|pole| pole.re < 0.0)
        );
        let friction = design.friction.as_ref().unwrap();
        assert!(friction.none.is_stable() && friction.all.is_stable());
        // The slowest pole is at −4.56 1/s, so the observer takes about a second.
        let observer = design
            .bias_observer(&Vector3::new(2e-3, 1e-3, 0.5))
            .unwrap();
        assert!((observer.time_constant_s - 5.0 * 1e-3 / -0.99544999_f64.ln()).abs() < 1e-5);
    }

    #[test]
    fn a_sample_time_that_is_too_long_is_named_with_one_that_works() {
        for sample_time_s in [0.15, 1.0, 60.0, 1e6] {
            let mut settings = settings();
            settings.sample_time_s = sample_time_s;
            match Design::new(&thesis::model(), &settings) {
                Err(DesignError::SampleTimeTooLong { longest_s, .. }) => {
                    settings.sample_time_s = longest_s;
                    assert!(Design::new(&thesis::model(), &settings).is_ok());
                }
                other => panic!("{sample_time_s}: {other:?}"),
            }
        }
    }

    /// These weights are so unequal that only a sample time of nanoseconds would work. A larger current weight is the
    /// advice that can be followed.
    #[test]
    fn a_sample_time_that_no_controller_has_is_not_advised() {
        let mut settings = settings();
        settings.sample_time_s = 0.01;
        settings.weights.state = Vector3::new(1e-5, 1e4, 10.0);
        settings.weights.current = 1e-6;
        let error = Design::new(&thesis::model(), &settings).unwrap_err();
        let DesignError::SampleTimeTooLong { larger_weight, .. } = error else {
            panic!("{error:?}");
        };
        let said = error.to_string();
        let weight = larger_weight.unwrap();
        assert!(
            said.contains(&format!("a current weight of at least {weight}")),
            "{said}"
        );
        assert!(!said.contains("a sample time of at most"), "{said}");
        settings.weights.current = weight;
        assert!(Design::new(&thesis::model(), &settings).is_ok());
    }

    /// Without wheel friction and without a weight on the wheel speed, the wheel keeps its speed. A weight of 1e-20 is
    /// too small to change that.
    #[test]
    fn a_cost_that_does_not_see_the_wheel_is_refused() {
        let mut parameters = thesis::PARAMETERS;
        parameters[5] = 0.0;
        let model = thesis::model_of(parameters);
        for (weight, time) in [(0.0, 1e-3), (0.0, 0.0119), (1e-20, 1e-3)] {
            let mut settings = settings();
            settings.weights.state[2] = weight;
            settings.sample_time_s = time;
            match Design::new(&model, &settings) {
                Err(DesignError::CostBlind { state, .. }) => assert_eq!(state, "wheel"),
                other => panic!("{weight}: {other:?}"),
            }
        }
        // A weight so small that the doubling iteration does not converge.
        let mut nothing = settings();
        nothing.weights.state[2] = 1e-30;
        nothing.sample_time_s = 1e-4;
        assert!(Design::new(&model, &nothing).is_err());
        // With friction the wheel comes to rest by itself.
        let mut with_friction = settings();
        with_friction.weights.state[2] = 0.0;
        assert!(Design::new(&thesis::model(), &with_friction).is_ok());
        // The angle has no weight.
        let mut blind = settings();
        blind.weights.state = Vector3::zeros();
        assert!(matches!(
            Design::new(&thesis::model(), &blind),
            Err(DesignError::CostBlind { state: "angle", .. })
        ));
    }

    #[test]
    fn a_bench_without_a_motor_is_named() {
        let mut model = thesis::model();
        model.input *= 0.0;
        assert!(matches!(
            Design::new(&model, &settings()),
            Err(DesignError::NotAPendulum { .. })
        ));
        // The motor turns only the wheel, which does not act on the body.
        let mut model = thesis::model();
        model.input[1] = 1e-300;
        model.state[(1, 2)] = 0.0;
        assert!(matches!(
            Design::new(&model, &settings()),
            Err(DesignError::NotStabilisable { .. })
        ));
    }

    #[test]
    fn a_model_that_is_not_finite_is_named() {
        let mut model = thesis::model();
        model.state[(1, 0)] = f64::NAN;
        assert!(matches!(
            Design::new(&model, &settings()),
            Err(DesignError::NotFinite { .. })
        ));
    }

    #[test]
    fn a_design_that_needs_friction_is_refused() {
        let mut settings = settings();
        // An extreme that these gains cannot hold: eight times the gravity.
        let mut heavy = thesis::PARAMETERS;
        heavy[2] *= 8.0;
        settings.friction_extremes = Some(FrictionExtremes {
            none: thesis::model_of(heavy),
            all: thesis::model(),
            smoothing_speed_rad_s: 0.0846768,
        });
        assert!(matches!(
            Design::new(&thesis::model(), &settings),
            Err(DesignError::UnstableLoop { .. })
        ));
    }
}
