//! Claim `filter-total`: no overflow for any reading, and an invariant that every step of the
//! attitude filter keeps.
//!
//! The steps are analysed with the calls of proved primitives ([`crate::claims::primitives`])
//! replaced by their contracts: the arguments must lie in the stated ranges, and only
//! the stated ranges of the results are used.

use std::collections::HashMap;

use crate::domains::intervals::{IntegerInterval, every_bit_pattern, ranges};
use crate::language::module::Module;
use crate::program::contract::Contract;
use crate::program::steps::Program;

/// The invariant of the words of a state: the quaternion's components and the rates are within the
/// limits stated in the source; all other words may have any value.
pub(crate) struct Invariant {
    /// Limits of the words of an attitude; `None` in a module without one.
    pub(crate) attitude: Option<AttitudeLimits>,
    /// Largest turn of an encoder in a step; `None` without an encoder.
    pub(crate) turn: Option<i128>,
    /// Largest count of an encoder.
    pub(crate) count: Option<i128>,
}

/// Largest words of an attitude and of the window that sets it.
pub(crate) struct AttitudeLimits {
    pub(crate) component: i128,
    pub(crate) rate: i128,
    sum: i128,
    drift: i128,
}

/// A constant of the source that limits something.
fn limit(module: &Module, file: &str, name: &str) -> Result<i128, String> {
    match module.constant(file, name) {
        Some([word]) if *word > 0 => Ok(*word),
        _ => Err(format!(
            "the source has no positive constant {file}::{name}"
        )),
    }
}

impl AttitudeLimits {
    pub(crate) fn read(module: &Module) -> Result<AttitudeLimits, String> {
        Ok(AttitudeLimits {
            component: limit(module, "madgwick", "COMPONENT_MAX")?,
            rate: limit(module, "calibration", "CALIBRATED_MAX")?,
            sum: limit(module, "supervisor", "SUM_MAX")?,
            drift: limit(module, "drift", "DRIFT_MAX")?,
        })
    }
}

impl Invariant {
    pub(crate) fn read(module: &Module) -> Result<Invariant, String> {
        let attitude = match module.function("Attitude::new") {
            Some(_) => Some(AttitudeLimits::read(module)?),
            None => None,
        };
        Ok(Invariant {
            attitude,
            turn: limit(module, "encoder", "TURN_MAX").ok(),
            count: limit(module, "encoder", "COUNT_MAX").ok(),
        })
    }

    fn of(&self, name: &str) -> Option<IntegerInterval> {
        self.of_attitude(name).or_else(|| self.of_encoder(name))
    }

    /// Of the words of an attitude, and of the window that sets it.
    fn of_attitude(&self, name: &str) -> Option<IntegerInterval> {
        let limits = self.attitude.as_ref()?;
        let within = |most: i128| Some(IntegerInterval::new(-most, most));
        if name.contains(".quaternion[") {
            within(limits.component)
        } else if name.starts_with("self.") && name.contains("drift[") {
            within(limits.drift)
        } else if name.contains(".window.sum[") {
            within(limits.sum)
        } else if name.ends_with("state.rate") || name.ends_with("state.slow_rate") {
            within(limits.rate)
        } else {
            None
        }
    }

    /// Of the words of an encoder, by itself or in a controller.
    fn of_encoder(&self, name: &str) -> Option<IntegerInterval> {
        let (turn, count) = (self.turn?, self.count?);
        if !name.starts_with("self.") {
            return None;
        }
        let is_turn = [".newest[", ".newer[", ".older[", ".oldest["]
            .iter()
            .any(|part| name.contains(part));
        if is_turn {
            Some(IntegerInterval::new(-turn, turn))
        } else if name.ends_with("wheel.count") || name.ends_with("body.count") {
            Some(IntegerInterval::new(0, count))
        } else {
            None
        }
    }

    fn arguments(&self, program: &Program) -> Vec<IntegerInterval> {
        let mut domain = every_bit_pattern(program);
        for (interval, name) in domain.iter_mut().zip(&program.inputs) {
            if let Some(narrow) = self.of(name) {
                *interval = narrow;
            }
        }
        domain
    }

    /// Whether the words of the state after a step satisfy the invariant. The state's words come
    /// last among the results and first among the arguments.
    pub(crate) fn is_kept(
        &self,
        program: &Program,
        results: &[IntegerInterval],
    ) -> Result<(), String> {
        let names: Vec<&String> = program
            .inputs
            .iter()
            .filter(|name| name.starts_with("self."))
            .collect();
        let state = &results[results.len().saturating_sub(names.len())..];
        for (name, found) in names.iter().zip(state) {
            if let Some(wanted) = self.of(name)
                && !found.is_within(wanted)
            {
                return Err(format!(
                    "`{}` may leave {name} in [{}, {}], the invariant is [{}, {}]",
                    program.name, found.low, found.high, wanted.low, wanted.high
                ));
            }
        }
        Ok(())
    }
}

/// The invariant holds at the start, and alignment and both steps keep it for every
/// reading, without overflow.
///
/// # Errors
/// A sentence with the place in the source.
pub fn check(module: &Module, contracts: &HashMap<usize, Contract>) -> Result<(), String> {
    let invariant = Invariant::read(module)?;
    let start = analysed(module, contracts, "Attitude::new", &invariant, &[])?;
    let names = module
        .function("Attitude::update_imu")
        .ok_or("there is no Attitude::update_imu")?;
    invariant.is_kept(names, &start)?;
    for name in [
        "Attitude::align",
        "Attitude::align_to",
        "Attitude::update_imu",
        "Attitude::update_marg",
    ] {
        let results = analysed(module, contracts, name, &invariant, &[])?;
        let program = module
            .function(name)
            .ok_or_else(|| format!("there is no {name}"))?;
        invariant.is_kept(program, &results)?;
    }
    for name in ["Attitude::quaternion", "Attitude::angle", "Attitude::rate"] {
        analysed(module, contracts, name, &invariant, &[])?;
    }
    Ok(())
}

/// Ranges of the results of `name` for a state in the invariant and any readings.
pub(crate) fn analysed(
    module: &Module,
    contracts: &HashMap<usize, Contract>,
    name: &str,
    invariant: &Invariant,
    fixed: &[(usize, IntegerInterval)],
) -> Result<Vec<IntegerInterval>, String> {
    let number = module
        .function_number(name)
        .ok_or_else(|| format!("there is no {name}"))?;
    let program = module
        .function_with_contracts(number, contracts)
        .map_err(|error| error.to_string())?;
    let mut domain = invariant.arguments(&program);
    for (word, interval) in fixed {
        domain[*word] = *interval;
    }
    ranges(&program, &domain).map_err(|finding| finding.to_string())
}
