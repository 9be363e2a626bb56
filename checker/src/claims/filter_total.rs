//! Attitude filter and full step: no overflow for any reading, and an invariant that every step
//! keeps.
//!
//! Primitives whose contracts stand at them in the source are proved first, each alone, by
//! halving their domains ([`crate::domains::intervals::prove`]). The steps above are then analysed with the
//! calls of proved primitives replaced by their contracts: what they are given must lie in the
//! stated ranges, and nothing but the stated ranges is known of their results.

use std::collections::HashMap;

use crate::domains::intervals::{Interval, every_bit_pattern, prove, ranges};
use crate::language::contracts::stated;
use crate::language::module::Module;
use crate::program::contract::Contract;
use crate::program::steps::Program;

/// How many boxes a contract may take.
const BOXES: usize = 400_000;

/// A primitive and its contract.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// Name, with its file: `root::inverse_length`.
    pub name: String,
    /// Number of the function.
    pub number: usize,
    /// What is stated.
    pub contract: Contract,
    /// Boxes that the proof took, or why there is none.
    pub proof: Result<usize, String>,
}

/// Proves every contract that stands in the source.
pub fn primitives(module: &Module) -> Vec<Primitive> {
    let declarations = module.declarations();
    let mut found: Vec<(usize, usize, Contract)> = Vec::new();
    for number in 0..declarations.functions.len() {
        if let (Some(contract), Some(program)) = (stated(module, number), module.program(number)) {
            found.push((program.len(), number, contract));
        }
    }
    // Small ones first, because larger ones call them.
    found.sort_by_key(|(size, number, _)| (*size, *number));
    let mut proved = HashMap::new();
    let mut primitives = Vec::new();
    for (_, number, contract) in found {
        let function = &declarations.functions[number];
        let proof = module
            .function_with_contracts(number, &proved)
            .map_err(|error| error.to_string())
            .and_then(|program| {
                // With the calls in place where their contracts say too little.
                let short = prove(&program, &contract, 2_000).or_else(|_| {
                    let whole = module.program(number).unwrap_or(&program);
                    prove(whole, &contract, BOXES)
                });
                short.map_err(|finding| finding.to_string())
            })
            .map(|effort| effort.boxes);
        if proof.as_ref().is_ok_and(|boxes| *boxes > 1) {
            proved.insert(number, contract.clone());
        }
        primitives.push(Primitive {
            name: format!(
                "{}::{}",
                declarations.files[function.module].module, function.name
            ),
            number,
            contract,
            proof,
        });
    }
    primitives
}

/// The contracts that the steps above use: those whose proof needed halving. The other functions
/// are small, and putting them in place says more than their contracts.
pub fn proved(primitives: &[Primitive]) -> HashMap<usize, Contract> {
    primitives
        .iter()
        .filter(|primitive| primitive.proof.as_ref().is_ok_and(|boxes| *boxes > 1))
        .map(|primitive| (primitive.number, primitive.contract.clone()))
        .collect()
}

/// The invariant of the words of a state: the quaternion's components and the rates within the
/// limits that the source states, everything else of any value.
pub(crate) struct Invariant {
    pub(crate) component: i128,
    pub(crate) rate: i128,
}

impl Invariant {
    pub(crate) fn read(module: &Module) -> Result<Invariant, String> {
        let limit = |file: &str, name: &str| match module.constant(file, name) {
            Some([word]) if *word > 0 => Ok(*word),
            _ => Err(format!(
                "the source has no positive constant {file}::{name}"
            )),
        };
        Ok(Invariant {
            component: limit("madgwick", "COMPONENT_MAX")?,
            rate: limit("calibration", "CALIBRATED_MAX")?,
        })
    }

    fn of(&self, name: &str) -> Option<Interval> {
        if name.contains(".quaternion[") {
            Some(Interval::new(-self.component, self.component))
        } else if name.ends_with("state.rate") || name.ends_with("state.slow_rate") {
            Some(Interval::new(-self.rate, self.rate))
        } else {
            None
        }
    }

    fn arguments(&self, program: &Program) -> Vec<Interval> {
        let mut domain = every_bit_pattern(program);
        for (interval, name) in domain.iter_mut().zip(&program.inputs) {
            if let Some(narrow) = self.of(name) {
                *interval = narrow;
            }
        }
        domain
    }

    /// Whether the words of a state that a step leaves keep the invariant; the state's words come
    /// last among the results and first among the arguments.
    fn is_kept(&self, program: &Program, results: &[Interval]) -> Result<(), String> {
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

/// Claim 3: the invariant holds at the start, and alignment and both steps keep it for every
/// reading, without overflow.
///
/// # Errors
/// A sentence with the place in the source.
pub fn check_filter(module: &Module, contracts: &HashMap<usize, Contract>) -> Result<(), String> {
    let invariant = Invariant::read(module)?;
    let start = analysed(module, contracts, "Attitude::new", &invariant, &[])?;
    let names = module
        .function("Attitude::update_imu")
        .ok_or("there is no Attitude::update_imu")?;
    invariant.is_kept(names, &start)?;
    for name in [
        "Attitude::align",
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

/// Claim 5: raw counts of any value give a duty within `low` and `high`, and exactly `zero` when
/// not armed; the state keeps its invariant.
///
/// # Errors
/// A sentence with the place in the source.
pub fn check_step(
    module: &Module,
    contracts: &HashMap<usize, Contract>,
    low: u16,
    zero: u16,
    high: u16,
) -> Result<(), String> {
    let invariant = Invariant::read(module)?;
    let name = "Controller::step";
    let program = module
        .function(name)
        .ok_or("there is no Controller::step")?;
    let start = analysed(module, contracts, "Controller::new", &invariant, &[])?;
    invariant.is_kept(program, &start)?;
    let armed = program
        .inputs
        .iter()
        .position(|name| name == "self.is_armed")
        .ok_or("the controller has no flag is_armed")?;
    let is_armed_at_start = start[start.len() - own_words(program) + armed];
    if is_armed_at_start != Interval::point(0) {
        return Err("a new controller is armed".to_owned());
    }
    let cases = [
        (0, Interval::point(zero.into())),
        (1, Interval::new(low.into(), high.into())),
    ];
    for (flag, wanted) in cases {
        let fixed = [(armed, Interval::point(flag))];
        let results = analysed(module, contracts, name, &invariant, &fixed)?;
        if !results[0].is_within(wanted) {
            return Err(format!(
                "with is_armed = {flag} the duty may lie in [{}, {}], not within [{}, {}]",
                results[0].low, results[0].high, wanted.low, wanted.high
            ));
        }
        invariant.is_kept(program, &results)?;
    }
    Ok(())
}

fn own_words(program: &Program) -> usize {
    let is_own = |name: &&String| name.starts_with("self.");
    program.inputs.iter().filter(is_own).count()
}

/// Ranges of the results of `name` for a state in the invariant and any readings.
pub(crate) fn analysed(
    module: &Module,
    contracts: &HashMap<usize, Contract>,
    name: &str,
    invariant: &Invariant,
    fixed: &[(usize, Interval)],
) -> Result<Vec<Interval>, String> {
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
