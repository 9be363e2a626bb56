//! The closed loop for all time, from the decimals of the certificate, in exact arithmetic.
//!
//! Two loops start in the same state x₀. The first is the linear model under u = −K x in real numbers,
//! x̄⁺ = F x̄ with F = Ad − Bd K. The second has the emitted law, with gains N (≈ −K). This law
//! receives the state with an error δ, |δᵢ| ≤ hᵢ (rounding to words, or to a sensor's steps and words), and rounds
//! its sum with an error ρ, |ρ| ≤ half a unit:
//!
//! u = N (x + δ) + ρ,   x⁺ = F̂ x + Bd v,   F̂ = Ad + Bd N,   v = N δ + ρ,   |v| ≤ V = Σ|Nᵢ| hᵢ + ½ unit.
//!
//! **Invariant set.** E = {x: xᵀ P x ≤ 1}, with ‖x‖² = xᵀ P x. If γ² P − Fᵀ P F and γ² P − F̂ᵀ P F̂ are
//! positive definite and ‖Bd‖ V ≤ 1 − γ, both loops stay in E. In E, |N x| ≤ √(N P⁻¹ Nᵀ); if that
//! and V stay below the limit, no command saturates, and if √(P⁻¹)ᵢᵢ + hᵢ stays within the range of
//! the words, no input does.
//!
//! **Voltage drive.** The same with the numbers of [`crate::claims::held_loop`]: Bd and Ad are those of a held voltage,
//! N and K those of w = V/R, and V includes what the wheel speed's error does to w. The set then also respects the half
//! spaces |w| ≤ V_max/R in which the supply does not clip; the limit of the current is still that of N x, with the gains
//! of the current. R and k_e are the stated ones, and the winding's inductance is neglected.
//!
//! **Encoder on the wheel.** The second loop sees the mean speed over a window, and as rounding the difference of two
//! counts ([`crate::claims::window_lag`]). The first sees the wheel's speed itself.
//!
//! **Difference.** While both stay in E, x_k = F̂ᵏ x₀ + Σ F̂ʲ Bd v and x̄_k = Fᵏ x₀. For a row C the
//! difference e = x − x̄ obeys, with ‖r‖* = √(r P⁻¹ rᵀ),
//!
//! |C e_k| ≤ V S_k + G_k,   S_k = Σ_{j<k} |C F̂ʲ Bd|,   G_k = ‖C F̂ᵏ − C Fᵏ‖*,
//!
//! The bound is reached by some perturbations |v| ≤ V and some x₀ in E: matching signs give the sum, and the
//! x₀ at which E touches the plane with normal C (F̂ᵏ − Fᵏ) gives G_k. The largest value over k is therefore not
//! only a bound, but the worst case. From k = n on, S and G are bounded by
//! S_n + ‖C‖* ‖Bd‖ γⁿ/(1 − γ) and 2 ‖C‖* γⁿ.
//! [`crate::claims::closed_loop_response`] adds it up.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::certificate::reader::{Certificate, CertifiedLoop, matrix, vector};
use crate::claims::closed_loop_response::Response;
use crate::claims::control_law::EmittedLaw;
use crate::claims::held_loop::HeldLoop;
use crate::claims::outcome::ClaimOutcome;
use crate::claims::window_lag::WindowLag;
use crate::exact::matrices::{
    Matrix, Vector, inverse, is_positive_definite, product, quadratic, transposed,
};
use crate::exact::rational::{exponent, half, integer, power_of_two, root_above, rounded_up};

/// The names of the states.
const STATES: [&str; 3] = ["angle", "rate", "wheel speed"];

/// Stated bounds may be rounded up by this share, not more.
fn slack() -> BigRational {
    BigRational::new(1.into(), 1_000_000_000.into())
}

/// The properties of the closed loop that were proved; numbers that are not exact are rounded up.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedLoopBounds {
    /// Largest magnitudes of the states in E.
    pub extents: Vector,
    /// Largest |K x| in E (A).
    pub command: BigRational,
    /// ‖Bd‖ V/(1 − γ) for the largest V: at most 1.
    pub perturbation_share: BigRational,
    /// Bound of the terms that are not added up, for the current and V = 1 A.
    pub rest: BigRational,
    /// For each case of the certificate.
    pub cases: Vec<CaseBounds>,
}

/// The effect of one kind of perturbation.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseBounds {
    /// Its name.
    pub name: String,
    /// hᵢ.
    pub half_steps: Vector,
    /// V (A).
    pub perturbation: BigRational,
    /// Of each state.
    pub states: Vector,
    /// Of K x (A).
    pub command: BigRational,
}

/// The linear loop with real gains, F, and the one with the emitted gains, F̂, with what the drive holds.
pub fn loops(certificate: &Certificate, law: &EmittedLaw) -> (Matrix, Matrix) {
    HeldLoop::of(certificate).loops(certificate, law)
}

/// The outcome of the claim, and the bounds if it holds. [`crate::claims::loop_from_rest`] decides it where
/// an encoder on the pivot shows the body.
pub fn by_exact_arithmetic(
    certificate: &Certificate,
    law: &EmittedLaw,
) -> (ClaimOutcome, Option<ClosedLoopBounds>) {
    let Some(stated) = &certificate.closed_loop else {
        let why =
            "the certificate states none: no set was found that the perturbations cannot leave";
        return (ClaimOutcome::NotRun(why.to_owned()), None);
    };
    match check(certificate, stated, law) {
        Ok(bounds) => {
            let parts: Vec<_> = bounds
                .cases
                .iter()
                .map(|case| {
                    format!(
                        "{}: {} rad, {} rad/s, {} rad/s, {} A",
                        case.name,
                        rounded_up(&case.states[0], 3),
                        rounded_up(&case.states[1], 3),
                        rounded_up(&case.states[2], 3),
                        rounded_up(&case.command, 3)
                    )
                })
                .collect();
            (ClaimOutcome::Proved(parts.join("; ")), Some(bounds))
        }
        Err(why) => (ClaimOutcome::Failed(why), None),
    }
}

/// Checks the closed-loop part of the certificate.
///
/// # Errors
/// A sentence that names what does not hold.
pub fn check(
    certificate: &Certificate,
    stated: &CertifiedLoop,
    law: &EmittedLaw,
) -> Result<ClosedLoopBounds, String> {
    let bounds = bounds(certificate, stated, law)?;
    is_as_stated("the rest of the sum", &bounds.rest, &stated.rest.value)?;
    for (found, stated) in bounds.cases.iter().zip(&stated.cases) {
        let of = |what: &str| format!("{what} for {}", found.name);
        for (index, name) in STATES.iter().enumerate() {
            is_as_stated(
                &of(&format!("the bound of the {name}")),
                &found.states[index],
                &stated.states[index].value,
            )?;
        }
        is_as_stated(
            &of("the bound of the command"),
            &found.command,
            &stated.command.value,
        )?;
    }
    Ok(bounds)
}

/// A stated bound is not below the true one, and above it by no more than its last digits.
pub(crate) fn is_as_stated(
    what: &str,
    found: &BigRational,
    stated: &BigRational,
) -> Result<(), String> {
    if stated < found {
        return Err(format!(
            "{what} is stated as {}, but is {}",
            rounded_up(stated, 12),
            rounded_up(found, 12)
        ));
    }
    if *stated > found * (BigRational::one() + slack()) {
        return Err(format!(
            "{what} is stated as {}, which is more than the {} that follows",
            rounded_up(stated, 12),
            rounded_up(found, 12)
        ));
    }
    Ok(())
}

fn bounds(
    certificate: &Certificate,
    stated: &CertifiedLoop,
    law: &EmittedLaw,
) -> Result<ClosedLoopBounds, String> {
    let held = HeldLoop::of(certificate);
    let (exact, quantised) = held.loops(certificate, law);
    let bd = held.bd.clone();
    let k = vector(&certificate.gains);
    let p = matrix(&stated.ellipsoid);
    let gamma = &stated.contraction.value;
    let one = BigRational::one();

    for (i, row) in p.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            if *entry != p[j][i] {
                return Err("the matrix of the ellipsoid is not symmetric".to_owned());
            }
        }
    }
    if !is_positive_definite(&p) {
        return Err("the matrix of the ellipsoid is not positive definite".to_owned());
    }
    if !gamma.is_positive() || *gamma >= one {
        return Err(format!(
            "the contraction {} is not between 0 and 1",
            stated.contraction
        ));
    }
    for (name, matrix) in [("real", &exact), ("emitted", &quantised)] {
        let image = product(&transposed(matrix), &product(&p, matrix));
        let margin: Matrix =
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| gamma * gamma * &p[i][j] - &image[i][j]));
        if !is_positive_definite(&margin) {
            return Err(format!(
                "the loop with the {name} gains does not map the ellipsoid into {} times itself",
                stated.contraction
            ));
        }
    }

    // A positive definite matrix has an inverse, and its quadratic forms have roots.
    let inverse = inverse(&p).ok_or("the matrix of the ellipsoid is singular")?;
    let root = |value: &BigRational| root_above(value).ok_or("a negative square");
    let reach = |row: &Vector| root(&quadratic(&inverse, row));
    let input_norm = root(&quadratic(&p, &bd))?;
    let mut rows: Vec<Vector> = Vec::new();
    for i in 0..3 {
        let mut row = [0, 1, 2].map(|_| BigRational::zero());
        row[i] = one.clone();
        rows.push(row);
    }
    rows.push(k.clone());

    let half_unit = law.unit() * half();
    let command = reach(&k)?;
    let emitted_command = reach(&law.gains)?;
    let held_gains = held.gains(&law.gains);
    let held_real = held.gains(&k.each_ref().map(|gain| -gain));
    let (held_command, held_real) = (reach(&held_gains)?, reach(&held_real)?);
    if held.reach.as_ref().is_some_and(|most| held_real > *most) {
        return Err(
            "the real law asks for more than the supply within the invariant set".to_owned(),
        );
    }
    if command > certificate.constants[3].real.value {
        return Err("the real law saturates within the invariant set".to_owned());
    }
    let extents = [reach(&rows[0])?, reach(&rows[1])?, reach(&rows[2])?];
    // The cheap checks come before the long sums.
    for (index, name) in STATES.iter().enumerate() {
        is_as_stated(
            &format!("the extent of the invariant set along the {name}"),
            &extents[index],
            &stated.extents[index].value,
        )?;
    }
    is_as_stated(
        "the largest command in the invariant set",
        &command,
        &stated.command.value,
    )?;
    let names: Vec<&str> = stated.cases.iter().map(|case| case.name.as_str()).collect();
    if names != ["words", "sensors"] {
        return Err(format!(
            "the cases are {names:?}; they are to be words and sensors"
        ));
    }
    let lag = WindowLag::of(certificate, stated)?;
    let mut words = law.half_words();
    words[2] += &lag.speed;
    let readings = [1, 1, lag.readings].map(integer);
    let sensors: Vector =
        [0, 1, 2].map(|i| &words[i] + stated.sensor_steps[i].value.abs() * half() * &readings[i]);

    let mut noises = Vec::new();
    let mut largest_share = BigRational::zero();
    for (name, half_steps) in names.iter().zip([words, sensors]) {
        let with = |gains: &Vector| -> BigRational {
            let steps = gains.iter().zip(&half_steps);
            &half_unit
                + steps
                    .map(|(gain, step)| gain.abs() * step)
                    .sum::<BigRational>()
        };
        let (noise, of_current) = (with(&held_gains), with(&law.gains));
        lag.check(certificate, &held, &extents, &held_gains, &noise, &reach)?;
        let share = &input_norm * &noise / (&one - gamma);
        if share > one {
            return Err(format!(
                "perturbations by {name} may leave the invariant set: they need {} of it",
                rounded_up(&share, 3)
            ));
        }
        largest_share = largest_share.max(share);
        if &emitted_command + &of_current > law.limit {
            return Err(format!(
                "the emitted law may saturate within the invariant set ({name})"
            ));
        }
        if held
            .reach
            .as_ref()
            .is_some_and(|most| &held_command + &noise > *most)
        {
            return Err(format!(
                "the supply may clip within the invariant set ({name})"
            ));
        }
        for index in 0..3 {
            let largest_word =
                integer(i32::MAX.into()) * power_of_two(-exponent(law.state_bits[index]));
            let reached = &extents[index] + &half_steps[index];
            if reached > largest_word || reached > certificate.inputs[index].range.value {
                return Err(format!(
                    "the invariant set reaches beyond the range of `{}` ({name})",
                    certificate.inputs[index].argument
                ));
            }
        }
        noises.push((*name, half_steps, noise));
    }

    is_as_stated(
        "the share of the perturbations",
        &largest_share,
        &stated.perturbation_share.value,
    )?;
    for ((_, _, noise), case) in noises.iter().zip(&stated.cases) {
        is_as_stated(
            &format!("the perturbation for {}", case.name),
            noise,
            &case.perturbation.value,
        )?;
    }

    let levels: Vec<BigRational> = noises.iter().map(|(_, _, noise)| noise.clone()).collect();
    let response = Response {
        exact: &exact,
        quantised: &quantised,
        bd: &bd,
        inverse: &inverse,
        input_norm,
        gamma,
        terms: stated.terms,
    };
    let mut worst = Vec::new();
    let mut rest = BigRational::zero();
    for row in &rows {
        let (of_row, rest_of_row) = response.worst(row, &levels)?;
        worst.push(of_row);
        rest = rest_of_row;
    }
    let cases = noises
        .into_iter()
        .enumerate()
        .map(|(case, (name, half_steps, perturbation))| CaseBounds {
            name: name.to_owned(),
            half_steps,
            perturbation,
            states: [0, 1, 2].map(|i| worst[i][case].clone()),
            command: worst[3][case].clone(),
        })
        .collect();
    Ok(ClosedLoopBounds {
        extents,
        command,
        perturbation_share: largest_share,
        rest,
        cases,
    })
}
