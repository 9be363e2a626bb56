//! The emitted law of any model, executed bit for bit from its source. No compiler is needed between
//! `generate` and `simulate`, and every overflow is detected.

use crate::law::{Law, LawFailure, Measured, WordFormats, WordLaw};
use checker::program::{Program, Type};
use checker::{Machine, Module};

/// The function `control` of an emitted crate.
#[derive(Clone, Debug)]
pub struct InterpretedLaw {
    program: Program,
    formats: WordFormats,
}

impl InterpretedLaw {
    /// The law in `module`.
    ///
    /// # Errors
    /// [`LawFailure`] where the crate has no function `control` from three fixed-point words to
    /// one.
    pub fn new(module: &Module) -> Result<Self, LawFailure> {
        let failure = |message: &str| LawFailure {
            message: message.to_owned(),
        };
        let program = module
            .function("control")
            .ok_or_else(|| failure("the emitted crate has no function `control`"))?;
        let formats = match (
            program.argument_types.as_slice(),
            program.result_types.as_slice(),
        ) {
            (
                [
                    Type::Fixed(angle),
                    Type::Fixed(rate),
                    Type::Fixed(wheel_speed),
                ],
                [Type::Fixed(current)],
            ) => WordFormats {
                state: [*angle, *rate, *wheel_speed],
                current: *current,
            },
            _ => {
                return Err(failure(
                    "the function `control` of the emitted crate does not take an angle, a rate \
                     and a wheel speed and return a current",
                ));
            }
        };
        Ok(InterpretedLaw {
            program: program.clone(),
            formats,
        })
    }
}

impl Law for InterpretedLaw {
    fn name(&self) -> &str {
        "emitted law"
    }

    fn command_a(&mut self, measured: &Measured) -> Result<f64, LawFailure> {
        let call = |words: [i32; 3]| {
            words_of(&self.program, &words.map(i128::from))?
                .first()
                .and_then(|word| i32::try_from(*word).ok())
                .ok_or_else(|| LawFailure {
                    message: "the emitted law returned no 32-bit word".to_owned(),
                })
        };
        WordLaw::new("emitted law", self.formats, call).command_a(measured)
    }
}

/// The words that `program` returns.
pub(crate) fn words_of(program: &Program, arguments: &[i128]) -> Result<Vec<i128>, LawFailure> {
    Machine::new(program)
        .call(arguments)
        .map(<[i128]>::to_vec)
        .map_err(|trap| LawFailure {
            message: trap.to_string(),
        })
}
