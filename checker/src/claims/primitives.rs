//! Claim `primitives`: every function with a contract in the source keeps that contract.
//!
//! Each function is proved separately, by halving its domain ([`crate::domains::halving::prove`]), with calls
//! of proved functions replaced by their contracts. Random runs compare it with the function that it approximates.

use std::collections::HashMap;

use crate::claims::functions::{Functions, near, same};
use crate::claims::outcome::ClaimOutcome;
use crate::claims::random::Random;
use crate::domains::halving::prove;
use crate::language::contracts::stated;
use crate::language::module::Module;
use crate::program::contract::Contract;

/// Largest number of boxes for the proof of a contract.
const BOXES: usize = 400_000;

/// A primitive and its contract.
#[derive(Clone, Debug, PartialEq)]
pub struct Primitive {
    /// Name, with its file: `root::inverse_length`.
    pub name: String,
    /// Number of the function.
    pub number: usize,
    /// The stated contract.
    pub contract: Contract,
    /// Number of boxes of the proof, or the reason why there is none.
    pub proof: Result<usize, String>,
}

/// Proves every contract in the source.
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
                // With the calls inlined, if their contracts say too little.
                let short = prove(&program, &contract, 2_000).or_else(|_| {
                    let whole = module.program(number).unwrap_or(&program);
                    prove(whole, &contract, BOXES)
                });
                short.map_err(|finding| finding.to_string())
            });
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

/// The contracts that the analysis of the steps uses: those whose proof needed halving. The other functions
/// are small, and inlining them gives more information than their contracts.
pub fn proved(primitives: &[Primitive]) -> HashMap<usize, Contract> {
    primitives
        .iter()
        .filter(|primitive| primitive.proof.as_ref().is_ok_and(|boxes| *boxes > 1))
        .map(|primitive| (primitive.number, primitive.contract.clone()))
        .collect()
}

/// The outcome over all primitives.
pub fn by_intervals(primitives: &[Primitive]) -> ClaimOutcome {
    let failed: Vec<String> = primitives
        .iter()
        .filter(|primitive| !primitive.contract.is_partial)
        .filter_map(|primitive| {
            let why = primitive.proof.as_ref().err()?;
            Some(format!("{}: {why}", primitive.name))
        })
        .collect();
    let in_place = primitives.iter().filter(|p| p.contract.is_partial).count();
    let boxes: usize = primitives
        .iter()
        .filter_map(|p| p.proof.as_ref().ok())
        .sum();
    if primitives.is_empty() {
        ClaimOutcome::Failed("no function of the source states a contract".to_owned())
    } else if failed.is_empty() {
        ClaimOutcome::Proved(format!(
            "contracts: {} over {boxes} box(es) of arguments, {in_place} more where the primitive is called",
            primitives.len() - in_place
        ))
    } else {
        ClaimOutcome::Failed(failed.join("; "))
    }
}

/// Runs the primitives and compares them with the functions that they implement: products, clamps and lines exactly,
/// scaling by its definition, roots, reciprocal and arc tangent within the errors stated in their documentation.
///
/// # Errors
/// The first case in which they differ.
pub fn by_random_runs(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    let f = Functions(module);
    let mut random = Random::new(seed);
    for case in 0..cases {
        let (a, b) = (random.word(), random.word());
        same(
            "mul_high",
            &[a, b],
            &f.call("mul_high", &[a, b])?,
            &[(a * b) >> 32],
        )?;
        let sum = (random.word() << 29) + random.word();
        let wanted = (sum + (1 << 31)) >> 32;
        same(
            "round_high",
            &[sum],
            &f.call("round_high", &[sum])?,
            &[wanted],
        )?;
        let (low, high) = (b.min(a), b.max(a));
        let value = random.word();
        let arguments = [value, low, high];
        same(
            "clamp",
            &arguments,
            &f.call("clamp", &arguments)?,
            &[value.clamp(low, high)],
        )?;
        let limit = a.abs().min(i32::MAX.into());
        let wide = (random.word() << 10) + random.word();
        let arguments = [wide, limit];
        let wanted = wide.clamp(-limit, limit);
        same(
            "clamp_wide",
            &arguments,
            &f.call("clamp_wide", &arguments)?,
            &[wanted],
        )?;
        let shift = 1 + random.count(30.0).abs();
        let line = [
            value,
            random.word() >> 2,
            random.word() << 20,
            shift,
            low,
            high,
        ];
        let wanted = ((line[0] * line[1] + line[2]) >> shift).clamp(low, high);
        same("on_line", &line, &f.call("on_line", &line)?, &[wanted])?;
        // The rest is of the attitude filter.
        if module.function("Attitude::new").is_none() {
            continue;
        }
        let wanted = (a >> 1) + (b >> 1);
        same(
            "slow_rate",
            &[a, b],
            &f.call("slow_rate", &[a, b])?,
            &[wanted],
        )?;
        motion(&f, &mut random)?;
        saturation(&f, &mut random, case)?;
        scaling(&f, &mut random)?;
        roots(&f, &mut random)?;
        calibration(&f, &mut random)?;
    }
    Ok(cases)
}

/// The lever-arm correction with any lever.
fn motion(f: &Functions, random: &mut Random) -> Result<(), String> {
    let limit = 1_i128 << 29;
    let accel = [0; 3].map(|_| random.count(limit as f64));
    let shift = random.next() % 20;
    let [rate, slow] = [0; 2].map(|_| random.count(limit as f64) >> shift);
    let arm = [0; 4].map(|_| random.count(2f64.powi(30)) >> (random.next() % 24));
    let squared = (rate * rate + (1 << 31)) >> 32;
    let excess = rate - slow;
    let x = (squared * arm[0] + excess * arm[3]) >> 16;
    let y = (squared * arm[1] - excess * arm[2]) >> 16;
    let wanted = [
        accel[0] + x.clamp(-limit, limit),
        accel[1] + y.clamp(-limit, limit),
        accel[2],
    ];
    let arguments = [&accel[..], &[rate, slow], &arm].concat();
    let found = f.call("without_motion", &arguments)?;
    same("without_motion", &arguments, &found, &wanted)
}

fn saturation(f: &Functions, random: &mut Random, case: usize) -> Result<(), String> {
    let clip = [0; 3].map(|_| 1 + random.count(32_766.0).abs());
    let limit = clip[case % 3];
    let ends = [-32_768, 32_767, 0, limit, -limit, limit - 1, 1 - limit];
    let mut raw = clip.map(|limit| random.count(limit as f64 * 0.9));
    raw[case % 3] = ends[case / 3 % ends.len()];
    let wanted = raw
        .iter()
        .zip(clip)
        .any(|(count, limit)| count.abs() >= limit);
    let arguments = [raw, clip].concat();
    same(
        "is_saturated",
        &arguments,
        &f.call("is_saturated", &arguments)?,
        &[i128::from(wanted)],
    )
}

/// A scaled vector is the vector times a power of two; its largest component is at least 2²⁹.
fn scaling(f: &Functions, random: &mut Random) -> Result<(), String> {
    // Least component for which that is promised, and the range that is kept.
    let kinds = [
        ("scaled_up2", 2, 1, 1_i128 << 30),
        ("scaled_up3", 3, 1 << 14, 1 << 30),
        ("scaled_up4", 4, 1, 7 << 28),
    ];
    for (name, length, least, limit) in kinds {
        let shift = random.next() % 31;
        let v: Vec<i128> = (0..length)
            .map(|_| random.count(limit as f64) >> shift)
            .collect();
        let found = f.call(name, &v)?;
        let largest = |v: &[i128]| v.iter().map(|x| x.abs()).max().unwrap_or(0);
        let factor = largest(&found) / largest(&v).max(1);
        let is_scaled =
            factor.count_ones() == 1 && v.iter().zip(&found).all(|(x, y)| x * factor == *y);
        let is_long = largest(&v) < least || largest(&found) >= 1 << 29;
        let is_zero = largest(&v) == 0 && largest(&found) == 0;
        if !(is_zero || is_scaled && is_long) || largest(&found) > limit {
            return Err(format!("{name} of {v:?} is {found:?}"));
        }
    }
    Ok(())
}

fn roots(f: &Functions, random: &mut Random) -> Result<(), String> {
    let one = 2f64.powi(30);
    // Branches meet at powers of two and their neighbours.
    let bits = 22 + random.count(8.0).abs();
    let exact = (1_i128 << bits) + random.count(2.0);
    let any = random.word().abs();
    for n in [exact, any] {
        let within = |low: i128, high: i128| n.clamp(low, high);
        let m = within(1 << 28, (1 << 30) - 1);
        let wanted = one / (m as f64 / 2f64.powi(28)).sqrt();
        near(
            "inverse_root_q30",
            m,
            f.call("inverse_root_q30", &[m])?[0],
            wanted,
            8.5,
        )?;
        let m = within(1 << 26, (1 << 30) - 1);
        let wanted = one / (m as f64 / 2f64.powi(26)).sqrt();
        near(
            "inverse_length",
            n,
            f.call("inverse_length", &[n])?[0],
            wanted,
            8.5,
        )?;
        let m = within(1 << 29, 1 << 30);
        let wanted = 2f64.powi(59) / m as f64;
        near(
            "reciprocal_q29",
            m,
            f.call("reciprocal_q29", &[m])?[0],
            wanted,
            24.5,
        )?;
    }
    let shift = random.next() % 28;
    let [y, x] = [0; 2].map(|_| random.count(one) >> shift);
    let wanted = (y as f64).atan2(x as f64) * 2f64.powi(28);
    near(
        "arc_tangent2",
        y,
        f.call("arc_tangent2", &[y, x])?[0],
        wanted,
        4.5e-7 * 2f64.powi(28),
    )
}

/// A sensor with any bias and cross-axis terms, not only the bench's.
fn calibration(f: &Functions, random: &mut Random) -> Result<(), String> {
    let raw = [0; 3].map(|_| random.count(32_767.0));
    let bias = [0; 3].map(|_| random.count(2f64.powi(28)));
    let matrix = [[0; 3]; 3].map(|row| row.map(|_: i32| random.count(2f64.powi(29))));
    let mut arguments = raw.to_vec();
    arguments.extend(bias);
    arguments.extend(matrix.iter().flatten());
    // The rounding of the three products: no further bits here.
    arguments.extend([0, 1]);
    let found = f.call("calibrate", &arguments)?;
    for (row, value) in matrix.iter().zip(&found) {
        let exact: i128 = (0..3).map(|i| row[i] * (raw[i] * 32_768 - bias[i])).sum();
        let wanted = exact as f64 / 2f64.powi(32);
        near("calibrate", raw[0], *value, wanted, 2.01)?;
    }
    Ok(())
}
