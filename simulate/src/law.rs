//! Control laws. Each receives the same measured state, and returns the current that it commands.

use design::BiasObserver;
use nalgebra::{RowVector3, Vector3};

/// The measured state at one sample.
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

/// The reason why a law gave no command: emitted code that is executed from its source can, in principle, fail.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the control law failed: {message}")]
pub struct LawFailure {
    /// The cause of the failure.
    pub message: String,
}

/// A control law.
pub trait Law {
    /// A short name for tables and figures.
    fn name(&self) -> &str;

    /// Returns to the state before the first sample.
    fn reset(&mut self) {}

    /// The current to command, in A.
    ///
    /// # Errors
    /// [`LawFailure`] if the law cannot be evaluated.
    fn command_a(&mut self, measured: &Measured) -> Result<f64, LawFailure>;
}

/// u = −K x, clipped, in double precision. The emitted law approximates it.
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

/// A law on fixed-point words: the emitted law of a model, or any other function
/// from the words of the measured state to the word of the current.
pub struct WordLaw<F> {
    name: String,
    formats: WordFormats,
    call: F,
}

/// Number of fraction bits of the words of an emitted law; all are signed 32-bit words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WordFormats {
    /// Fraction bits of `Angle`, `Rate` and `WheelSpeed`.
    pub state: [u32; 3],
    /// Fraction bits of `Current`.
    pub current: u32,
}

impl<F: FnMut([i32; 3]) -> Result<i32, LawFailure>> WordLaw<F> {
    /// The law that `call` computes on words of these formats.
    pub fn new(name: impl Into<String>, formats: WordFormats, call: F) -> Self {
        WordLaw {
            name: name.into(),
            formats,
            call,
        }
    }
}

impl<F: FnMut([i32; 3]) -> Result<i32, LawFailure>> Law for WordLaw<F> {
    fn name(&self) -> &str {
        &self.name
    }

    fn command_a(&mut self, measured: &Measured) -> Result<f64, LawFailure> {
        let state = measured.vector();
        let mut words = [0; 3];
        for ((word, value), fraction_bits) in
            words.iter_mut().zip(state.iter()).zip(self.formats.state)
        {
            if !value.is_finite() {
                return Err(LawFailure {
                    message: "a measured value is not finite".to_owned(),
                });
            }
            // Rounded to the nearest word, as in the crate `fixed`; saturated at the ends of the format,
            // as `as` does.
            *word = (value * unit(fraction_bits)).round_ties_even() as i32;
        }
        (self.call)(words).map(|word| f64::from(word) / unit(self.formats.current))
    }
}

/// Units of a word per 1.0.
fn unit(fraction_bits: u32) -> f64 {
    2.0_f64.powi(fraction_bits as i32)
}

/// The exact law on the measured angle minus the estimated bias.
#[derive(Clone, Debug, PartialEq)]
pub struct BiasObservingLaw {
    regulator: ExactLaw,
    observer: BiasObserver,
    state: f64,
    estimate_rad: f64,
}

impl BiasObservingLaw {
    /// `regulator` with `observer`, whose estimate starts at zero.
    pub fn new(regulator: ExactLaw, observer: BiasObserver) -> Self {
        BiasObservingLaw {
            regulator,
            observer,
            state: 0.0,
            estimate_rad: 0.0,
        }
    }

    /// The present estimate of the angle's bias, in rad.
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
