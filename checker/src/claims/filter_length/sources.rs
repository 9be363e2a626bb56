//! Step 6 of the argument in [`super::check`]: the origin of quaternions and corrections.

use std::collections::HashMap;

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::claims::filter_length::algebra::{FRACTION_BITS, every_word, unless};
use crate::claims::filter_total::{AttitudeLimits, Invariant, analysed};
use crate::domains::intervals::IntegerInterval;
use crate::domains::polynomials::Words;
use crate::exact::rational::power_of_two;
use crate::language::module::Module;
use crate::program::contract::{Contract, Range};
use crate::program::steps::{Program, Slot};

/// Where quaternions and corrections come from.
pub(crate) struct Sources {
    /// The largest β T that is handed to `scaled_correction`, as a word in Q35.
    pub(crate) beta: BigRational,
}

impl Sources {
    /// Looks at everything that makes or changes a state with a quaternion.
    pub(crate) fn read(
        module: &Module,
        contracts: &HashMap<usize, Contract>,
        around_one: &(BigRational, BigRational),
    ) -> Result<Sources, String> {
        let invariant = Invariant::read(module)?;
        let limits = AttitudeLimits::read(module)?;
        let mut sources = Sources {
            beta: BigRational::zero(),
        };
        let component = IntegerInterval::new(-limits.component, limits.component);
        let mut extended = contracts.clone();
        let half_angle = 4..7;
        for (name, narrow, to) in [
            ("madgwick::turned", half_angle, limits.rate),
            // The unit vector of an alignment; what `aligned` is then shown for.
            ("madgwick::aligned", 0..3, UP_MAX),
            ("madgwick::scaled_correction", 0..0, 0),
        ] {
            let (number, mut contract) = every_word(module, name)?;
            for range in &mut contract.requires {
                if narrow.contains(&range.word) {
                    (range.low, range.high) = (-to, to);
                }
            }
            if name != "madgwick::scaled_correction" {
                contract.ensures = (0..4)
                    .map(|word| Range {
                        word,
                        low: component.low,
                        high: component.high,
                    })
                    .collect();
            }
            extended.insert(number, contract);
        }
        let declarations = module.declarations();
        let mut changes = 0;
        for (number, function) in declarations.functions.iter().enumerate() {
            let mut names = declarations.word_names("", &function.result);
            let receiver = function.arguments.first().filter(|it| it.is_mutable);
            if let Some(receiver) = receiver {
                names.extend(declarations.word_names("self", &receiver.type_));
            }
            let Some(first) = names.iter().position(|name| is_state_of_an_owner(name)) else {
                continue;
            };
            let program = module
                .function_with_contracts(number, &extended)
                .map_err(|error| error.to_string())?;
            unless(
                names.len() == program.results.len(),
                "the words of a state are not where they should be",
            )?;
            // Its calls get what their contracts require.
            analysed(module, &extended, &function.name, &invariant, &[])?;
            let words = Words::of(&program);
            let quaternion = &program.results[first..first + 4];
            for tuple in words.alternatives(quaternion) {
                sources.quaternion(&function.name, &program, &words, &tuple, around_one)?;
            }
            changes += usize::from(receiver.is_some());
        }
        unless(changes > 0, "nothing changes a quaternion")?;
        Ok(sources)
    }

    /// Proof that a quaternion is turned, aligned, unchanged, or a constant of length 1.
    fn quaternion(
        &mut self,
        name: &str,
        program: &Program,
        words: &Words,
        tuple: &[Slot],
        around_one: &(BigRational, BigRational),
    ) -> Result<(), String> {
        let before = state_of(program);
        let symbols: Option<Vec<Slot>> = tuple.iter().map(|slot| words.symbol(*slot)).collect();
        let Some(symbols) = symbols else {
            let constants: Option<Vec<BigRational>> = tuple
                .iter()
                .map(|slot| words.form(*slot).number())
                .collect();
            let squared = constants.map(|words| {
                let sum: BigRational = words.iter().map(|word| word * word).sum();
                sum * power_of_two(-2 * FRACTION_BITS)
            });
            return unless(
                squared.is_some_and(|squared| around_one.0 <= squared && squared <= around_one.1),
                &format!("`{name}` makes a quaternion that is not known to be of length 1"),
            );
        };
        if before.as_ref() == Some(&symbols) {
            return Ok(());
        }
        let call = words
            .call(symbols[0])
            .filter(|call| call.results == symbols);
        match call {
            Some(call) if call.function == "aligned" => Ok(()),
            Some(call) if call.function == "turned" && call.arguments.len() == 12 => {
                // A quaternion that is turned may have been aligned just before.
                for turned in words.alternatives(&call.arguments[..4]) {
                    self.quaternion(name, program, words, &turned, around_one)?;
                }
                for tuple in words.alternatives(&call.arguments[7..]) {
                    self.correction(name, words, &tuple)?;
                }
                Ok(())
            }
            _ => Err(format!(
                "`{name}` has a quaternion that comes neither from `turned` nor from `aligned`"
            )),
        }
    }

    /// Proof that a correction is zero, or comes from `scaled_correction` with a constant β T.
    fn correction(&mut self, name: &str, words: &Words, tuple: &[Slot]) -> Result<(), String> {
        let numbers: Option<Vec<BigRational>> = tuple
            .iter()
            .map(|slot| words.form(*slot).number())
            .collect();
        if numbers.is_some_and(|numbers| numbers.iter().all(Zero::is_zero)) {
            return Ok(());
        }
        let call = words.call(tuple[0]).filter(|call| call.results == tuple);
        let beta = call
            .filter(|call| call.function == "scaled_correction")
            .and_then(|call| words.form(*call.arguments.last()?).number())
            .filter(|beta| !beta.is_negative());
        let beta = beta.ok_or_else(|| {
            format!(
                "`{name}` corrects by something else than `scaled_correction` with a constant β"
            )
        })?;
        if beta > self.beta {
            self.beta = beta;
        }
        Ok(())
    }
}

/// Largest component of a unit vector in Q28 that `aligned` may be given: 5·2²⁷.
pub(crate) const UP_MAX: i128 = 5 << 27;

/// Whether this is the first word of the quaternion of a struct that holds a state.
fn is_state_of_an_owner(name: &str) -> bool {
    name.ends_with(".state.quaternion[0]")
}

/// The words of the quaternion that the receiver has before.
fn state_of(program: &Program) -> Option<Vec<Slot>> {
    let first = program
        .inputs
        .iter()
        .position(|name| name.starts_with("self.") && is_state_of_an_owner(name))?;
    Some(program.arguments[first..first + 4].to_vec())
}
