//! Control laws. All see the same measured state and return the current that they command.

use design::BiasObserver;
use nalgebra::{RowVector3, Vector3};

/// What the controller is told, at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Body angle from upright in rad.
    pub angle_rad: f64,
    /// Body rate in rad/s.
    pub rate_rad_s: f64,
    /// Wheel speed relative to the body in rad/s.
    pub wheel_speed_rad_s: f64,
}

impl Measured {
    /// (angle, rate, wheel speed).
    pub fn vector(&self) -> Vector3<f64> {
        Vector3::new(self.angle_rad, self.rate_rad_s, self.wheel_speed_rad_s)
    }
}

/// Why a law gave no command: emitted code that is run from its source can fail, in principle.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the control law failed: {message}")]
pub struct LawFailure {
    /// What happened.
    pub message: String,
}

/// A control law.
pub trait Law {
    /// A short name for tables and figures.
    fn name(&self) -> &str;

    /// Back to the state before the first sample.
    fn reset(&mut self) {}

    /// The current to command, in A.
    ///
    /// # Errors
    /// [`LawFailure`] where the law cannot be evaluated.
    fn command_a(&mut self, measured: &Measured) -> Result<f64, LawFailure>;
}

/// u = −K x, clipped, in double precision: what the emitted law approximates.
#[derive(Clone, Debug, PartialEq)]
pub struct ExactLaw {
    /// K in A/rad, A s/rad, A s/rad.
    pub gains: RowVector3<f64>,
    /// Largest current in A.
    pub limit_a: f64,
}

impl Law for ExactLaw {
    fn name(&self) -> &str {
        "exact law"
    }

    fn command_a(&mut self, measured: &Measured) -> Result<f64, LawFailure> {
        Ok(-(self.gains * measured.vector())[0].clamp(-self.limit_a, self.limit_a))
    }
}

/// The emitted fixed-point law of the thesis bench, as compiled into this program (crate
/// `generated`). Laws emitted for other models are run from their source instead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CompiledLaw;

impl Law for CompiledLaw {
    fn name(&self) -> &str {
        "emitted law"
    }

    fn command_a(&mut self, measured: &Measured) -> Result<f64, LawFailure> {
        let state = measured.vector();
        if state.iter().any(|value| !value.is_finite()) {
            return Err(LawFailure {
                message: "a measured value is not finite".to_owned(),
            });
        }
        let current = generated::control(
            generated::Angle::saturating_from_num(state[0]),
            generated::Rate::saturating_from_num(state[1]),
            generated::WheelSpeed::saturating_from_num(state[2]),
        );
        Ok(current.to_num::<f64>())
    }
}

/// The exact law on an angle from which the observed bias has been taken out.
#[derive(Clone, Debug, PartialEq)]
pub struct BiasObservingLaw {
    regulator: ExactLaw,
    observer: BiasObserver,
    state: f64,
    estimate_rad: f64,
}

impl BiasObservingLaw {
    /// `regulator` with `observer`, which starts knowing nothing.
    pub fn new(regulator: ExactLaw, observer: BiasObserver) -> Self {
        BiasObservingLaw {
            regulator,
            observer,
            state: 0.0,
            estimate_rad: 0.0,
        }
    }

    /// The bias of the angle that is believed at the moment, in rad.
    pub fn estimate_rad(&self) -> f64 {
        self.estimate_rad
    }
}

impl Law for BiasObservingLaw {
    fn name(&self) -> &str {
        "exact law with bias observer"
    }

    fn reset(&mut self) {
        self.state = 0.0;
        self.estimate_rad = 0.0;
    }

    fn command_a(&mut self, measured: &Measured) -> Result<f64, LawFailure> {
        let state = measured.vector();
        self.estimate_rad = self.observer.estimate_rad(self.state, &state);
        let current = self.regulator.command_a(&Measured {
            angle_rad: measured.angle_rad - self.estimate_rad,
            ..*measured
        })?;
        self.state = self.observer.advance(self.state, &state, current);
        Ok(current)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The gains behind the emitted law (physics of the thesis bench at 1 ms).
    fn exact() -> ExactLaw {
        ExactLaw {
            gains: RowVector3::new(-24.2672423, -2.12973867, -0.0225875821),
            limit_a: 2.0,
        }
    }

    proptest! {
        /// Within the stated ranges the emitted law is off by less than a tenth of a microampere
        /// from rounding its gains and as much from rounding the state.
        #[test]
        fn the_emitted_law_is_the_exact_one_rounded(
            angle_rad in -3.1..3.1_f64,
            rate_rad_s in -35.0..35.0_f64,
            wheel_speed_rad_s in -700.0..700.0_f64,
        ) {
            let measured = Measured { angle_rad, rate_rad_s, wheel_speed_rad_s };
            let one = exact().command_a(&measured).unwrap();
            let other = CompiledLaw.command_a(&measured).unwrap();
            prop_assert!((one - other).abs() < 2e-7, "{one} {other}");
        }
    }

    #[test]
    fn values_beyond_every_format_still_give_the_limit() {
        let measured = Measured {
            angle_rad: 1e300,
            rate_rad_s: 1e300,
            wheel_speed_rad_s: 1e300,
        };
        // Falling forward: positive current drives the body backward.
        assert_eq!(CompiledLaw.command_a(&measured).unwrap(), 2.0);
        let not_a_number = Measured {
            angle_rad: f64::NAN,
            ..measured
        };
        assert!(CompiledLaw.command_a(&not_a_number).is_err());
    }
}
