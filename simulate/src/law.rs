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
/// `generated`). Laws emitted for other models are run from their source instead,
/// [`crate::InterpretedLaw`].
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

/// A law in fixed-point words: what is emitted for a model, run from its source or in any other
/// way that maps the words of the measured state to the word of the current.
pub struct WordLaw<F> {
    name: String,
    formats: WordFormats,
    call: F,
}

/// Bits after the binary point of the words of an emitted law, all of them signed 32-bit words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WordFormats {
    /// Of `Angle`, `Rate` and `WheelSpeed`.
    pub state: [u32; 3],
    /// Of `Current`.
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
            // To the nearest word, as the crate `fixed` converts; beyond the format to its end,
            // as `as` does.
            *word = (value * unit(fraction_bits)).round_ties_even() as i32;
        }
        (self.call)(words).map(|word| f64::from(word) / unit(self.formats.current))
    }
}

/// Units of a word per one.
fn unit(fraction_bits: u32) -> f64 {
    2.0_f64.powi(fraction_bits as i32)
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

    /// The gains that the emitted law states to be rounded from.
    fn exact() -> ExactLaw {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../generated");
        let certificate = checker::certificate::Certificate::read(&folder).unwrap();
        let gain = |index: usize| certificate.gains[index].text.parse::<f64>().unwrap();
        ExactLaw {
            gains: RowVector3::new(gain(0), gain(1), gain(2)),
            limit_a: 2.0,
        }
    }

    thread_local! {
        static EXACT: ExactLaw = exact();
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
            let one = EXACT.with(|exact| exact.clone().command_a(&measured)).unwrap();
            let other = CompiledLaw.command_a(&measured).unwrap();
            prop_assert!((one - other).abs() < 2e-7, "{one} {other}");
        }
    }

    /// The words of the compiled law, called through the interface that interpreted laws use.
    fn word_law() -> impl Law {
        let formats = WordFormats {
            state: [
                generated::Angle::FRAC_NBITS,
                generated::Rate::FRAC_NBITS,
                generated::WheelSpeed::FRAC_NBITS,
            ],
            current: generated::Current::FRAC_NBITS,
        };
        WordLaw::new("words", formats, |[angle, rate, wheel_speed]| {
            Ok(generated::control(
                generated::Angle::from_bits(angle),
                generated::Rate::from_bits(rate),
                generated::WheelSpeed::from_bits(wheel_speed),
            )
            .to_bits())
        })
    }

    proptest! {
        #[test]
        fn words_are_converted_as_the_compiled_law_converts_them(
            angle_rad in -6.0..6.0_f64,
            rate_rad_s in -100.0..100.0_f64,
            wheel_speed_rad_s in -2000.0..2000.0_f64,
        ) {
            let measured = Measured { angle_rad, rate_rad_s, wheel_speed_rad_s };
            let one = CompiledLaw.command_a(&measured).unwrap();
            prop_assert_eq!(one, word_law().command_a(&measured).unwrap());
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
        assert_eq!(word_law().command_a(&measured).unwrap(), 2.0);
        let not_a_number = Measured {
            angle_rad: f64::NAN,
            ..measured
        };
        assert!(CompiledLaw.command_a(&not_a_number).is_err());
        assert!(word_law().command_a(&not_a_number).is_err());
    }
}
