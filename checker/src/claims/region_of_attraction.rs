//! A region of attraction of the pendulum itself, whose gravity is a sine, in exact arithmetic.
//!
//! From [`crate::claims::closed_loop_for_all_time`], this uses the set E = {x: ‖x‖ ≤ 1}, ‖x‖² = xᵀ P x. The linear loop maps
//! E into γ E, and in E no command saturates for any perturbations |v| ≤ V.
//!
//! **Gravity.** With g = G/(Θ − j_w), e = (0, 1, −1) and A of the linear model the pendulum obeys
//! ẋ = A x + B u + e g (sin α − α), so that after one sample
//!
//! x⁺ = F̂ x + Bd v + d,   d = ∫₀ᵀ exp(A (T − s)) e g (sin α(s) − α(s)) ds,   |sin α − α| ≤ |α|³/6.
//!
//! With a voltage drive, A, F̂, N and u are those of the held voltage ([`crate::claims::held_loop`]); no supply clips in E.
//!
//! **Between samples.** Let ‖x‖ = r at the sample, r₀ ≤ r ≤ 1. As long as |α| ≤ r a, |α̇| ≤ r b and
//! |φ̇| ≤ r c, the speeds change by at most what the model's rows allow, with |u| ≤ r (√(N P⁻¹ Nᵀ) + V/r₀). If
//! a, b, c are such that these limits then cannot be reached within one sample, they never are.
//!
//! **Decrease.** ‖exp(A τ) e‖ ≤ q for 0 ≤ τ ≤ T, with q from the series of the entries' magnitudes. Then
//! ‖d‖ ≤ r³ κ, κ = T g q a³/6, and
//!
//! ‖x⁺‖ ≤ γ r + κ r³ + p,   p = ‖Bd‖ V.
//!
//! If the right side is below r for r = r₁ and for r = r₀, it is so between, because it is convex in r.
//! Every start with ‖x‖ ≤ r₁ then stays there and reaches ‖x‖ < r₀, where it stays for the same reason.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::certificate::reader::{Certificate, CertifiedLoop, matrix};
use crate::claims::closed_loop_for_all_time::ClosedLoopBounds;
use crate::claims::control_law::EmittedLaw;
use crate::claims::held_loop::HeldLoop;
use crate::claims::outcome::ClaimOutcome;
use crate::exact::matrices::{Matrix, Vector, dot, inverse, quadratic};
use crate::exact::rational::{integer, power, root_above, rounded_up};

/// Shares of the set that are tried, in parts of its size.
const PARTS: i128 = 64;
/// Rounds in which the bounds between samples are enlarged.
const ROUNDS: usize = 40;
/// Terms of the series for q.
const TERMS: i128 = 24;

/// The region that was proved.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvedRegion {
    /// r₁: size of the region, E having 1.
    pub outer: BigRational,
    /// r₀: size of the set that every motion reaches.
    pub inner: BigRational,
    /// Largest angle, rate and wheel speed of the region (rad, rad/s, rad/s). Each largest value occurs together with
    /// suitable values of the others.
    pub extents: Vector,
    /// Largest angle from which a body at rest, with a wheel at rest, is in the region (rad), rounded down.
    pub from_rest: BigRational,
}

/// The numbers of one module.
struct Loop {
    t: BigRational,
    gravity: BigRational,
    a: Matrix,
    b: Vector,
    extents: Vector,
    command: BigRational,
    perturbation: BigRational,
    gamma: BigRational,
    pushed: BigRational,
    q: BigRational,
}

/// The outcome of the claim, with the bounds of `closed-loop-for-all-time` if that claim holds.
pub fn by_exact_arithmetic(
    certificate: &Certificate,
    bounds: Option<&ClosedLoopBounds>,
    law: &EmittedLaw,
) -> ClaimOutcome {
    let (Some(stated), Some(bounds)) = (&certificate.closed_loop, bounds) else {
        return ClaimOutcome::NotRun("it needs closed-loop-for-all-time".to_owned());
    };
    match check(certificate, stated, bounds, law) {
        Ok(region) => ClaimOutcome::Proved(format!(
            "from rest at up to {} rad; from {} times the ellipsoid (which reaches {} rad, {} rad/s and {} rad/s, not all at once) into {} times it",
            rounded_up(
                &((&region.from_rest * power(10, 4)).floor() * power(10, -4)),
                4
            ),
            rounded_up(&region.outer, 3),
            rounded_up(&region.extents[0], 3),
            rounded_up(&region.extents[1], 3),
            rounded_up(&region.extents[2], 3),
            rounded_up(&region.inner, 3)
        )),
        Err(NoRegion::Unphysical(why)) => ClaimOutcome::Failed(why),
        Err(NoRegion::NotShown(why)) => ClaimOutcome::NotRun(why),
    }
}

/// Why no region is shown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoRegion {
    /// The stated numbers do not describe a pendulum, or contradict each other.
    #[error("{0}")]
    Unphysical(String),
    /// The argument fails. A region may exist all the same.
    #[error("{0}")]
    NotShown(String),
}

/// Gravity's entry of the stated matrix may be printed with six digits.
fn is_gravity_of(a: &BigRational, gravity: &BigRational) -> bool {
    (a - gravity).abs() <= gravity.abs() * power(10, -5)
}

/// g = G/(Θ − j_w) (1/s²), which is that of the stated A.
///
/// # Errors
/// [`NoRegion`] for numbers that are those of no pendulum, and for a spring, which the argument does not hold.
pub(crate) fn gravity_of(certificate: &Certificate) -> Result<BigRational, NoRegion> {
    let parameter = |name: &str| {
        let found = certificate.parameters.iter().find(|p| p.name == name);
        found.map(|p| p.value.value.clone()).ok_or_else(|| {
            NoRegion::Unphysical(format!(
                "the certificate does not state the parameter {name}"
            ))
        })
    };
    let carried = parameter("total_inertia")? - parameter("wheel_inertia")?;
    if !carried.is_positive() {
        return Err(NoRegion::Unphysical(
            "total_inertia - wheel_inertia is not positive".to_owned(),
        ));
    }
    let gravity = parameter("gravity_torque")? / carried;
    if !gravity.is_positive() {
        return Err(NoRegion::Unphysical(
            "the gravity torque is not positive".to_owned(),
        ));
    }
    // The sine and the linear model have the same gravity. A spring would need another argument.
    let a = &certificate.plant.a[1][0].value;
    if !is_gravity_of(a, &gravity) {
        let why = format!(
            "A[1][0] is {}, gravity makes it {}",
            rounded_up(a, 7),
            rounded_up(&gravity, 7)
        );
        let has_spring = certificate
            .parameters
            .iter()
            .any(|parameter| parameter.unit.contains("N m/rad"));
        return Err(if has_spring {
            NoRegion::NotShown(format!("{why}: a spring is not part of the argument"))
        } else {
            NoRegion::Unphysical(why)
        });
    }
    Ok(gravity)
}

/// Finds the largest region that the argument above shows, and the smallest set to which it comes.
///
/// # Errors
/// A sentence that says what is missing, or that nothing could be shown.
pub fn check(
    certificate: &Certificate,
    stated: &CertifiedLoop,
    bounds: &ClosedLoopBounds,
    law: &EmittedLaw,
) -> Result<ProvedRegion, NoRegion> {
    let gravity = gravity_of(certificate)?;
    let p = matrix(&stated.ellipsoid);
    let not_shown = |why: &str| NoRegion::NotShown(why.to_owned());
    let root = |value: &BigRational| root_above(value).ok_or(not_shown("a negative square"));
    let t = certificate.sample_time_s.value.clone();
    let held = HeldLoop::of(certificate);
    let a = held.a.clone();
    let inverse = inverse(&p).ok_or(not_shown("the matrix of the ellipsoid is singular"))?;
    let one = BigRational::one();
    let all = Loop {
        q: largest_response(&a, &t, &p).map_err(NoRegion::NotShown)?,
        gravity,
        b: held.b.clone(),
        extents: bounds.extents.clone(),
        command: root(&quadratic(&inverse, &held.gains(&law.gains)))?,
        perturbation: bounds
            .cases
            .iter()
            .map(|case| case.perturbation.clone())
            .max()
            .ok_or(not_shown("no perturbations are stated"))?,
        pushed: &bounds.perturbation_share * (&one - &stated.contraction.value),
        gamma: stated.contraction.value.clone(),
        a,
        t,
    };
    let share = |part: i128| integer(part) / integer(PARTS);
    // The smallest inner set for the largest outer one.
    for outer in (1..=PARTS).rev().map(share) {
        let inner = (1..PARTS)
            .map(share)
            .take_while(|inner| *inner < outer)
            .find(|inner| all.decreases(inner, inner) && all.decreases(inner, &outer));
        if let Some(inner) = inner {
            return Ok(ProvedRegion {
                from_rest: &outer / root(&p[0][0])?,
                extents: all.extents.map(|extent| extent * &outer),
                outer,
                inner,
            });
        }
    }
    Err(not_shown(
        "gravity as a sine could take the loop out of every share of its invariant set",
    ))
}

impl Loop {
    /// Whether γ r + κ r³ + p < r at this r, for κ with r₀ = `inner`.
    fn decreases(&self, inner: &BigRational, r: &BigRational) -> bool {
        let Some(angle) = self.largest_angle(inner) else {
            return false;
        };
        let cube = &angle * &angle * &angle / integer(6);
        let kappa = &self.t * &self.gravity * &self.q * cube;
        &self.gamma * r + kappa * r * r * r + &self.pushed < *r
    }

    /// The bound a of |α|/r between samples; `None` if it does not settle.
    fn largest_angle(&self, inner: &BigRational) -> Option<BigRational> {
        let current = &self.command + &self.perturbation / inner;
        let mut bounds = self.extents.clone();
        for _ in 0..ROUNDS {
            let reached = self.reached(&bounds, &current);
            if reached.iter().zip(&bounds).all(|(new, old)| new < old) {
                return Some(bounds[0].clone());
            }
            // A little more than the value that was reached, in few digits.
            bounds = reached.map(|value| {
                let scaled = value * power(10, 9) * (integer(1) + power(10, -6));
                scaled.ceil() / power(10, 9)
            });
        }
        None
    }

    /// The largest change of angle, rate and wheel speed within one sample while they stay within `bounds`.
    fn reached(&self, bounds: &Vector, current: &BigRational) -> Vector {
        // The term sin α − α adds to the angle's share at most g α²/6 times α.
        let sine = &self.gravity * &bounds[0] * &bounds[0] / integer(6);
        [0, 1, 2].map(|i| {
            let row = self.a[i].clone().map(|entry| entry.abs());
            let mut change = dot(&row, bounds) + self.b[i].abs() * current;
            if i > 0 {
                change += &sine * &bounds[0];
            }
            &self.extents[i] + &self.t * change
        })
    }
}

/// q ≥ ‖exp(A τ) e‖ for 0 ≤ τ ≤ T.
fn largest_response(a: &Matrix, t: &BigRational, p: &Matrix) -> Result<BigRational, String> {
    let scaled: Matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| a[i][j].abs() * t));
    let sums = scaled.each_ref().map(|row| row.iter().sum::<BigRational>());
    let norm = sums.iter().max().cloned().unwrap_or_default();
    // The terms after the last are then at most (8/25)^j of it, together less than it.
    if norm > integer(8) {
        return Err("the sample time is too long for the bound: |A| T is above 8".to_owned());
    }
    let e: Vector = [0, 1, -1].map(integer);
    let mut term: Vector = [0, 1, 1].map(integer);
    let mut change: Vector = [0, 1, 2].map(|_| BigRational::zero());
    let mut left = BigRational::one();
    for k in 1..=TERMS {
        term = [0, 1, 2].map(|i| dot(&scaled[i], &term) / integer(k));
        left = left * &norm / integer(k);
        for (sum, entry) in change.iter_mut().zip(&term) {
            *sum += entry;
        }
    }
    let root = |value: &BigRational| root_above(value).ok_or("a negative square".to_owned());
    let mut q = root(&quadratic(p, &e))?;
    for (i, change) in change.iter().enumerate() {
        q += (change + &left) * root(&p[i][i])?;
    }
    Ok(q)
}
