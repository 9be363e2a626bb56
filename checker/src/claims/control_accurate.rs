//! Claim `control-accurate`: the command is within half a unit of the saturated law with the
//! quantised gains.

use crate::certificate::reader::Certificate;
use crate::claims::control_law::EmittedLaw;
use crate::claims::outcome::ClaimOutcome;
use crate::claims::random::Random;
use crate::domains::machine::Machine;
use crate::domains::smt::{Question, SolverAnswer, TIMEOUT_MS, answered};
use crate::exact::rational::{exponent, half, integer, power_of_two, rounded_up};
use crate::language::module::Module;
use crate::program::steps::Program;

/// Checks the rounding of the law in the source, and that its gains are the stated ones.
pub fn by_intervals(certificate: &Certificate, law: &EmittedLaw) -> ClaimOutcome {
    let bound = rounded_up(&law.rounding, 4);
    let gains_agree = certificate
        .constants
        .iter()
        .zip(&law.gains)
        .all(|(c, gain)| integer(c.raw.into()) * power_of_two(-exponent(c.fraction_bits)) == *gain);
    if law.rounding > law.unit() * half() {
        ClaimOutcome::Failed(format!("off by up to {bound} A, more than half a unit"))
    } else if !gains_agree {
        ClaimOutcome::Failed("the gains of the source are not those of the certificate".to_owned())
    } else {
        ClaimOutcome::Proved(format!("{bound} A"))
    }
}

/// The question to z3: |command 2ˢ − clamp(Σ N X, ±limit 2ˢ)| ≤ 2ˢ⁻¹, with words, shift and
/// limit of the certificate.
pub fn by_smt(program: &Program, certificate: &Certificate) -> SolverAnswer {
    let ask = || {
        let mut question = Question::new(TIMEOUT_MS)?;
        let arguments = question.arguments(program, "x")?;
        let results = question.results(program, &arguments)?;
        let shift = certificate.bounds.shift;
        if shift == 0 || shift > 62 {
            return Err("the certificate states no law".to_owned());
        }
        let c = &question.context;
        let mut sum = question.number(0);
        for (constant, argument) in certificate.constants.iter().zip(&arguments) {
            let gain = question.number(constant.raw.into());
            sum = c.plus(sum, c.times(gain, *argument));
        }
        let scale = 1_i128 << shift;
        let limit = i128::from(certificate.constants[3].raw) * scale;
        let (low, high) = (question.number(-limit), question.number(limit));
        let saturated = question.clamped(sum, low, high);
        let error = c.sub(c.times(results[0], question.number(scale)), saturated);
        let wanted = question.within(error, -scale / 2, scale / 2);
        question.ask(wanted)
    };
    answered(ask())
}

/// Words at which integer code breaks.
const EXTREMES: [i128; 11] = [
    i32::MIN as i128,
    i32::MIN as i128 + 1,
    -(1 << 30),
    -65_536,
    -1,
    0,
    1,
    65_535,
    1 << 30,
    i32::MAX as i128 - 1,
    i32::MAX as i128,
];

/// Runs `control` on extreme and random words against the words of the certificate, in exact
/// integers: within half a unit of the saturated law, and monotone.
///
/// # Errors
/// The first words for which it is not.
pub fn by_random_runs(
    module: &Module,
    certificate: &Certificate,
    cases: usize,
    seed: u64,
) -> Result<usize, String> {
    let program = module.function("control").ok_or("there is no `control`")?;
    if program.arguments.len() != 3 || program.results.len() != 1 {
        return Err("`control` does not take three words and give one".to_owned());
    }
    let mut machine = Machine::new(program);
    let mut random = Random::new(seed);
    let mut done = 0;
    for a in EXTREMES {
        for b in EXTREMES {
            for c in EXTREMES {
                one_command(&mut machine, certificate, [a, b, c])?;
                done += 1;
            }
        }
    }
    for _ in 0..cases {
        let words = [random.word(), random.word(), random.word()];
        let command = one_command(&mut machine, certificate, words)?;
        let state = (random.next() % 3) as usize;
        let mut raised = words;
        raised[state] = (words[state] + random.word().abs()).min(i32::MAX.into());
        let other = one_command(&mut machine, certificate, raised)?;
        let rises = certificate.constants[state].raw >= 0;
        if (rises && other < command) || (!rises && other > command) {
            return Err(format!("not monotone between {words:?} and {raised:?}"));
        }
        done += 1;
    }
    Ok(done)
}

fn one_command(
    machine: &mut Machine,
    certificate: &Certificate,
    words: [i128; 3],
) -> Result<i128, String> {
    let [a, b, c, limit] = &certificate.constants;
    let shift = certificate.bounds.shift.clamp(1, 62);
    let command = machine.call(&words).map_err(|trap| trap.to_string())?[0];
    let exact =
        i128::from(a.raw) * words[0] + i128::from(b.raw) * words[1] + i128::from(c.raw) * words[2];
    let limit = i128::from(limit.raw.max(0)) << shift;
    let error = (command << shift) - exact.clamp(-limit, limit);
    if error.abs() > 1 << (shift - 1) {
        return Err(format!(
            "the command for {words:?} is {command}, off by {error}/2^{shift} units"
        ));
    }
    Ok(command)
}
