//! Claims `loop-as-shipped` and `motion-kept-up`: the loop from raw counts to the motor, with what a bench
//! adds to the equations, in exact arithmetic.
//!
//! **Loop.** x = (angle, rate, wheel speed). At a sample the step sees x + ε and commands N (x + ε) + ρ. The drive
//! turns the duty of this command into a current with an error of half a count, which begins to flow after a delay.
//! With w = N x and all errors in n, |n| ≤ ν, the current is w + n. The motion is
//!
//! ẋ = A x + B (w + n) + e f + e_w f_w,   e = (0, 1, −1),   e_w = (0, 1/D, −Θ/(j_w D)),
//!
//! where A has viscous friction alone. f holds dry friction, |f| ≤ μ/D, whatever its course, and the
//! gravity that the straight line leaves out, g |sin α − α| ≤ g |α|³/6; f_w holds dry friction and cogging of the wheel.
//!
//! **Voltage drive.** It holds w = V/R = N x + κ φ̇, and the loop is the same with the A and N of a held voltage
//! ([`crate::claims::held_loop`]). The bounds then also stay below the end of the supply. R and k_e are the stated ones, and
//! the winding's inductance is neglected.
//!
//! **Encoder on the wheel.** Its speed is the turn over the last N steps, and N states more say which ([`layout`]). What
//! is read of the turn is off by the errors of two readings. Before it is armed the wheel has been at rest for the window.
//!
//! **Encoder on the pivot.** It takes the place of the filter. Its rate is the difference of two angles that it showed,
//! M steps apart; what it showed in the last M steps are M states more ([`layout`]). An error of a reading is an input of
//! its own, since the loop knows what it does later. Before it is armed the body has been at rest for the window, and the
//! readings in it are off by half a count at most.
//!
//! **Observer of the angle's bias.** Its state s is one more of z, with s = −ℓ₁ α₀ at the start, where it sees no bias
//! ([`crate::claims::emitted_observer`]). It knows the command with all its errors: what is shown or rounded wrong acts on the
//! current and on s together, and only together it is far smaller than both bounds added up. So these errors are inputs of
//! one sample each, as a reading of the encoder on the pivot is. The bounds then also stay below the largest estimate, and
//! below the end of the word of s.
//!
//! **Delay.** It is a part d of the sample time, 0 ≤ d ≤ 1, which stays within one quarter of the sample at all steps.
//! At the middle of each quarter the loop in z = (x, w of the last step) is z⁺ = F z. The deviation of d from the
//! middle adds at most T/8 of the current's change w − w⁻ ([`plant`]).
//!
//! **Responses.** For a row C and an input v the sum of |C Fʲ v| over all j is a bound, and the best one, of what
//! inputs within ±1 can do ([`responses`]). From rest at α₀ each quantity C z is then bounded by
//! |α₀| max |C Fʲ e₁| + Σ sums × sizes of the inputs.
//!
//! **Induction.** The sizes depend on the bounds themselves: the sine on the angle, an old reading of the gyroscope on the
//! acceleration, the delay on the current's change. Bounds b with (what follows from b) ≤ b hold at
//! every step if they hold at the first ([`bounds`]).
//!
//! **Filter.** Its correction is a relay: it turns the estimate by at most 2βT a step towards the direction that the
//! accelerometer shows. Nothing is linearised ([`errors`]).
//!
//! **What stays.** The influence of the start decays. The bounds within which every motion finally stays therefore obey
//! the same inequality with α₀ = 0. From the bounds above it is applied again until nothing changes; that is
//! `motion-kept-up`, with rounding and dry friction alone.

pub mod bounds;
mod carried;
pub mod errors;
pub mod inertial;
pub mod layout;
pub mod plant;
pub mod responses;
pub mod small_gain;

use num_rational::BigRational;

use crate::certificate::reader::Certificate;
use crate::claims::control_law::EmittedLaw;
use crate::claims::outcome::ClaimOutcome;
use crate::exact::rational::{power, rounded_up};
use bounds::{Bounds, kept_up, largest_start};
use errors::{BodyErrors, SensorErrors};
use plant::{DELAYS, Loop};
use responses::Responses;

/// Why the claim is not settled.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoBounds {
    /// The argument does not cover the module, or fails for it.
    #[error("{0}")]
    NotShown(String),
    /// The certificate contradicts itself.
    #[error("{0}")]
    Unphysical(String),
}

/// The bounds that were proved for a module.
#[derive(Clone, Debug, PartialEq)]
pub struct ShippedLoop {
    /// Largest angle at which the loop may be armed at rest (rad).
    pub start: BigRational,
    /// Bounds of the motion after arming.
    pub bounds: Bounds,
    /// The errors of the sensors that the bounds allow for.
    pub errors: SensorErrors,
    /// Bounds of the motion that rounding and dry friction keep up.
    pub kept_up: Bounds,
}

/// Both claims: the loop as shipped, and the motion that is kept up.
pub fn by_exact_arithmetic(
    certificate: &Certificate,
    law: &EmittedLaw,
) -> (ClaimOutcome, ClaimOutcome) {
    match check(certificate, law) {
        Ok(shown) => {
            let three = |value: &BigRational| rounded_up(value, 3);
            let bounds = &shown.bounds;
            let errors = &shown.errors;
            let of_body = match &errors.body {
                BodyErrors::Inertial(body) => format!(
                    "error of the filter within {} rad; errors of the sensors within {} rad/s (gyroscope, an axis), {} m/s2 (accelerometer, an axis), {} rad/s (wheel), remaining drift {} rad/s",
                    three(&bounds.angle),
                    three(&body.gyro_axis),
                    three(&body.accel_axis),
                    three(&errors.wheel_speed),
                    three(&body.drift),
                ),
                BodyErrors::Pivot(body) => format!(
                    "errors of the sensors within {} rad (a reading of the pivot), {} rad/s (the rate of two readings), {} rad/s (wheel)",
                    three(&errors.reading),
                    three(&body.rate),
                    three(&errors.wheel_speed),
                ),
                // The loop as shipped has no sensor that measures directly.
                BodyErrors::Counts(body) => format!(
                    "errors of the sensors within {} rad, {} rad/s",
                    three(&body.angle),
                    three(&body.rate),
                ),
            };
            let of_observer = match &errors.observer {
                Some(_) => format!(", estimated bias {} rad", three(&bounds.estimate)),
                None => String::new(),
            };
            let shipped = format!(
                "armed at rest within {} rad: angle within {} rad, rate {} rad/s, wheel speed {} rad/s, current {} A{of_observer}; {of_body}",
                rounded_down(&shown.start),
                three(&bounds.states[0]),
                three(&bounds.states[1]),
                three(&bounds.states[2]),
                three(&bounds.command),
            );
            let kept = &shown.kept_up;
            let kept_up = format!(
                "angle within {} rad, rate {} rad/s, wheel speed {} rad/s, current {} A",
                three(&kept.states[0]),
                three(&kept.states[1]),
                three(&kept.states[2]),
                three(&kept.command),
            );
            (ClaimOutcome::Proved(shipped), ClaimOutcome::Proved(kept_up))
        }
        Err(NoBounds::NotShown(why)) => {
            (ClaimOutcome::NotRun(why.clone()), ClaimOutcome::NotRun(why))
        }
        Err(NoBounds::Unphysical(why)) => {
            (ClaimOutcome::Failed(why.clone()), ClaimOutcome::NotRun(why))
        }
    }
}

/// A positive number, rounded down to steps of 1e-5.
fn rounded_down(value: &BigRational) -> String {
    let steps = power(10, 5);
    rounded_up(&((value * &steps).floor() / steps), 6)
}

/// Finds the largest start, and the bounds that follow.
///
/// # Errors
/// [`NoBounds`].
pub fn check(certificate: &Certificate, law: &EmittedLaw) -> Result<ShippedLoop, NoBounds> {
    let noisy = SensorErrors::of(certificate, law, true)?;
    let quiet = SensorErrors::of(certificate, law, false)?;
    let mut shown: Option<ShippedLoop> = None;
    let loops = std::thread::scope(|scope| {
        let all = DELAYS.map(|eighths| {
            scope.spawn(move || {
                let model = Loop::of(certificate, law, eighths)?;
                let responses = Responses::of(&model)?;
                Ok((model, responses))
            })
        });
        let join = |run: std::thread::ScopedJoinHandle<'_, Result<_, NoBounds>>| {
            run.join()
                .unwrap_or_else(|_| Err(NoBounds::NotShown("the computation broke off".to_owned())))
        };
        all.into_iter().map(join).collect::<Result<Vec<_>, _>>()
    })?;
    // All four delays have the same start, the smallest of the four. Of each bound the largest counts.
    let mut start: Option<BigRational> = None;
    for (model, responses) in &loops {
        let own = largest_start(model, responses, &noisy)?;
        start = Some(start.map_or(own.clone(), |other| other.min(own)));
    }
    let start = start.unwrap_or_default();
    for (model, responses) in &loops {
        let bounds = Bounds::from_rest(model, responses, &noisy, &start)?;
        let rest = kept_up(model, responses, &quiet, &bounds)?;
        shown = Some(match shown {
            None => ShippedLoop {
                start: start.clone(),
                bounds,
                errors: noisy.clone(),
                kept_up: rest,
            },
            Some(other) => ShippedLoop {
                bounds: other.bounds.larger(bounds),
                kept_up: other.kept_up.larger(rest),
                ..other
            },
        });
    }
    shown.ok_or_else(|| NoBounds::NotShown("no delay was looked at".to_owned()))
}
