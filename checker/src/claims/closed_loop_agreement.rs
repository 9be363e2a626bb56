//! Claim `closed-loop-agreement`: the loop with the emitted law stays beside the loop with the same gains in real numbers,
//! mode by mode.
//!
//! The two loops differ by e, and e⁺ = F e + Bd w with F = Ad + Bd N, where w is what the emitted command, of states that
//! are rounded to words, differs from N x. `control-accurate` and the rounding bound |w| by W. With rows T
//! of the certificate and z = T e, the matrix M = T F T⁻¹ gives
//!
//! |zᵢ⁺| ≤ |Mᵢᵢ| |zᵢ| + Σⱼ |Mᵢⱼ| |zⱼ| + |Tᵢ Bd| |w|,
//!
//! and all |zᵢ| stay at most 1 if the right side is at most 1 for |z| = 1 and |w| = W. Real modes have no Mᵢⱼ; a complex
//! pair a ± jb has |Mᵢⱼ| = |b|, and such a box only if |a| + |b| < 1. The harness of the same name proves
//! this step on the emitted `control` in the integers of `verify/src/modes.rs`; here these
//! integers are shown to be at least what the exact matrices make them.

use num_rational::BigRational;
use num_traits::Signed;

use crate::certificate::reader::{Certificate, matrix, vector};
use crate::claims::closed_loop_for_all_time::loops;
use crate::claims::control_law::EmittedLaw;
use crate::claims::outcome::ClaimOutcome;
use crate::exact::matrices::{dot, inverse, product};
use crate::exact::rational::{exponent, half, integer, power_of_two, rounded_up};
use crate::language::emitted::Emitted;
use crate::language::module::Module;

/// The file of the harness crate that holds the integers.
const FILE: &str = "verify/src/modes.rs";

/// Names of its constants.
const MODES: [&str; 3] = ["FIRST", "SECOND", "THIRD"];

/// Fraction bits of a decay; bits of the largest coordinate; bits by which a word of a state is divided.
const DECAY_BITS: i32 = 30;
const BOX_BITS: i32 = 28;
const PART_BITS: i32 = 4;

/// Decides the claim for the modes of the certificate.
pub fn by_exact_arithmetic(
    certificate: &Certificate,
    emitted: &Emitted,
    module: &Module,
    law: &EmittedLaw,
) -> ClaimOutcome {
    if certificate.modes.is_none() {
        // The intervals stand in a file of the harness crate that not every module has.
        return match emitted.harnesses.iter().any(|(path, _)| path == FILE) {
            true => ClaimOutcome::NotRun(NO_MODES.to_owned()),
            false => ClaimOutcome::NotApplicable(NO_HARNESSES.to_owned()),
        };
    }
    if certificate.drive.voltage.is_some() {
        return ClaimOutcome::Failed(
            "modes are stated, but the harness knows the difference of a current alone, not that of a voltage"
                .to_owned(),
        );
    }
    ClaimOutcome::proved(check(certificate, emitted, module, law))
}

/// Why a loop may have no such coordinates.
pub(crate) const NO_MODES: &str = "the certificate states no box of modes that every step maps into itself; a pair of \
                                   complex modes a ± jb has one only if |a| + |b| < 1";

/// Why a module may state no such intervals.
const NO_HARNESSES: &str = "the intervals are those of a held current and the states themselves, not of a voltage or the turn \
                            over an encoder's window";

/// The integers of one mode.
struct Mode {
    decay: BigRational,
    rest: BigRational,
    input: BigRational,
}

fn check(
    certificate: &Certificate,
    emitted: &Emitted,
    module: &Module,
    law: &EmittedLaw,
) -> Result<String, String> {
    let rows = certificate.modes.as_ref().ok_or(NO_MODES)?;
    let rows = matrix(rows);
    let (_, loop_matrix) = loops(certificate, law);
    let back = inverse(&rows).ok_or("the rows of the modes are no coordinates")?;
    let decoupled = product(&product(&rows, &loop_matrix), &back);
    let input = vector(&certificate.plant.bd);

    // W in sixteenths of a unit of the sum of products, and that unit in A.
    let shift = module
        .constant("control", "SHIFT")
        .and_then(|words| words.first());
    let shift = shift.and_then(|shift| i32::try_from(*shift).ok());
    let shift = shift.ok_or("src/control.rs has no SHIFT")?;
    let count_a = power_of_two(-exponent(law.current_bits) - shift - PART_BITS);
    let of_states: BigRational = (0..3)
        .map(|i| law.gains[i].abs() * half() * power_of_two(-exponent(law.state_bits[i])))
        .sum();
    let worst_a = &law.rounding + of_states;
    let worst = &worst_a / &count_a;

    let one = power_of_two(DECAY_BITS + BOX_BITS);
    let stated = stated(emitted)?;
    for (i, mode) in stated.iter().enumerate() {
        let name = MODES[i];
        let others: BigRational = (0..3)
            .filter(|j| *j != i)
            .map(|j| decoupled[i][j].abs())
            .sum();
        let wanted = [
            (
                "decay",
                &mode.decay,
                decoupled[i][i].abs() * power_of_two(DECAY_BITS),
            ),
            ("rest", &mode.rest, others * &one),
            (
                "input",
                &mode.input,
                dot(&rows[i], &input).abs() * &count_a * &one,
            ),
        ];
        for (field, found, least) in wanted {
            if *found < least {
                return Err(format!(
                    "{FILE}: {name}.{field} is {found}, the loop needs {}",
                    rounded_up(&least, 12)
                ));
            }
        }
        let next = &mode.decay * power_of_two(BOX_BITS) + &mode.rest + &mode.input * &worst;
        if next > one {
            return Err(format!("{FILE}: a step may leave the interval of {name}"));
        }
    }
    let bounds = [("rad", 0), ("rad/s", 1), ("rad/s", 2)].map(|(unit, k)| {
        let bound: BigRational = back[k].iter().map(Signed::abs).sum();
        format!("{} {unit}", rounded_up(&bound, 3))
    });
    Ok(format!(
        "the states differ by at most {}, for commands off by up to {} A",
        bounds.join(", "),
        rounded_up(&worst_a, 3)
    ))
}

/// The integers in the harness crate.
fn stated(emitted: &Emitted) -> Result<[Mode; 3], String> {
    let text = emitted.harnesses.iter().find(|(path, _)| path == FILE);
    let (_, text) = text.ok_or(format!("there is no {FILE}"))?;
    let file = Module::parse(&[("src/modes.rs", text)]).map_err(|error| error.to_string())?;
    let word = |name: &str, field: &str| -> Result<BigRational, String> {
        let words = file.constant_words("modes", name).unwrap_or_default();
        let wanted = format!("{name}.{field}");
        let found = words.iter().find(|(known, _)| *known == wanted);
        found
            .map(|(_, word)| integer(*word))
            .ok_or_else(|| format!("{FILE} has no {wanted}"))
    };
    let mode = |name: &str| -> Result<Mode, String> {
        Ok(Mode {
            decay: word(name, "decay")?,
            rest: word(name, "rest")?,
            input: word(name, "input")?,
        })
    };
    Ok([mode(MODES[0])?, mode(MODES[1])?, mode(MODES[2])?])
}
