//! Claims `closed-loop-for-all-time` and `region-of-attraction` from rest, where an encoder has a window or an
//! observer corrects the angle.
//!
//! The rate by an encoder on the pivot is the difference of two angles that it showed, and the angles of its window
//! are states of the loop. An ellipsoid in so many states has room for next to no rounding of counts: it bounds an
//! error of the rate as if it never ended, while the error of a reading acts on the rate forwards and, a window
//! later, backwards. With a long window of an encoder on the wheel there may be no ellipsoid either, and the state of
//! an observer of the angle's bias is slow and depends on the start. So the starts are those of a user, at rest, and
//! the argument is the one of [`crate::claims::loop_as_shipped`]: the largest effect of a start and of every input,
//! added up over all time, and bounds that follow from themselves. Here it is applied to the plant of these two
//! claims, the stated linear model, without delay, dry friction and noise, and with sensors that return the nearest
//! count.
//!
//! **For all time.** With z the emitted loop's states, z̄ those of the loop with the real gains −K, the same windows and
//! no rounding, F̂ the matrix of the emitted loop and N the emitted gains, the difference e = z − z̄ obeys
//!
//! e⁺ = F̂ e + B (v + (N + K) z̄) + readings,
//!
//! with v the rounding of words, duty and counts. z̄ is bounded by its own start and windows; means over a window are
//! within the bounds between samples. With an observer, z̄ has one in real numbers, that of the stated decimals; what
//! the words make of z̄ besides is an input of the observer's state.
//!
//! **Region.** The same bounds with gravity as a sine, from the largest start at rest for which they close, and those that
//! every such motion finally keeps.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::certificate::reader::{Certificate, vector};
use crate::claims::control_law::EmittedLaw;
use crate::claims::emitted_observer::EmittedObserver;
use crate::claims::loop_as_shipped::NoBounds;
use crate::claims::loop_as_shipped::bounds::{Apart, Bounds, Difference, kept_up, largest_start};
use crate::claims::loop_as_shipped::errors::SensorErrors;
use crate::claims::loop_as_shipped::plant::Loop;
use crate::claims::loop_as_shipped::responses::Responses;
use crate::claims::outcome::ClaimOutcome;
use crate::claims::region_of_attraction::{NoRegion, gravity_of};
use crate::exact::rational::{power, rounded_up};

/// What is proved of the two loops of the linear model.
#[derive(Clone, Debug, PartialEq)]
pub struct ForAllTime {
    /// Largest angle of a start at rest (rad).
    pub start: BigRational,
    /// Bounds of the emitted loop.
    pub bounds: Bounds,
    /// How far it is from the loop in real numbers.
    pub difference: Difference,
}

/// The region that is proved.
#[derive(Clone, Debug, PartialEq)]
pub struct FromRest {
    /// Largest angle of a start at rest (rad).
    pub start: BigRational,
    /// Bounds of the motion.
    pub bounds: Bounds,
    /// Bounds that every such motion reaches, and then keeps.
    pub kept: Bounds,
}

/// The emitted loop, with gravity as in the linear model; its responses serve both claims.
pub struct LoopFromRest {
    model: Loop,
    responses: Responses,
    errors: SensorErrors,
}

impl LoopFromRest {
    /// The loop of a module.
    ///
    /// # Errors
    /// [`NoBounds`].
    pub fn of(certificate: &Certificate, law: &EmittedLaw) -> Result<LoopFromRest, NoBounds> {
        let model = Loop::as_stated(certificate, law)?;
        Ok(LoopFromRest {
            responses: Responses::of(&model)?,
            errors: SensorErrors::of_counts(certificate, law)?,
            model,
        })
    }

    /// The two loops of the linear model: gravity is no sine.
    ///
    /// # Errors
    /// [`NoBounds`].
    pub fn for_all_time(
        &self,
        certificate: &Certificate,
        law: &EmittedLaw,
    ) -> Result<ForAllTime, NoBounds> {
        let straight = |model: &Loop| Loop {
            gravity: BigRational::zero(),
            ..model.clone()
        };
        let real = EmittedLaw {
            gains: vector(&certificate.gains).map(|gain| -gain),
            observer: EmittedObserver::stated(certificate),
            ..law.clone()
        };
        let real_model = straight(&Loop::as_stated(certificate, &real)?);
        let real_responses = Responses::of(&real_model)?;
        let model = straight(&self.model);
        let own = largest_start(&model, &self.responses, &self.errors)?;
        let start = own.min(largest_start(&real_model, &real_responses, &self.errors)?);
        // The loop in real numbers has no errors; with them its bounds are larger.
        let of_real = Bounds::from_rest(&real_model, &real_responses, &self.errors, &start)?;
        let apart = apart(
            law,
            &real,
            &of_real,
            &of_real.state_of_observer(&real_model),
        );
        Ok(ForAllTime {
            bounds: Bounds::from_rest(&model, &self.responses, &self.errors, &start)?,
            difference: Difference::of(&model, &self.responses, &self.errors, &apart)?,
            start,
        })
    }

    /// The region from rest, with gravity as a sine.
    ///
    /// # Errors
    /// [`NoBounds`].
    pub fn from_rest(&self, certificate: &Certificate) -> Result<FromRest, NoBounds> {
        gravity_of(certificate).map_err(|why| match why {
            NoRegion::Unphysical(why) => NoBounds::Unphysical(why),
            NoRegion::NotShown(why) => NoBounds::NotShown(why),
        })?;
        let (model, responses, errors) = (&self.model, &self.responses, &self.errors);
        let start = largest_start(model, responses, errors)?;
        let bounds = Bounds::from_rest(model, responses, errors, &start)?;
        Ok(FromRest {
            kept: kept_up(model, responses, errors, &bounds)?,
            start,
            bounds,
        })
    }
}

/// How far the numbers of the emitted law are from those of the real one, for bounds of the real loop and of its
/// observer's state.
fn apart(law: &EmittedLaw, real: &EmittedLaw, of_real: &Bounds, state: &BigRational) -> Apart {
    let differs = |one: &[BigRational; 3], other: &[BigRational; 3]| -> BigRational {
        let both = one.iter().zip(other).zip(&of_real.states);
        both.map(|((one, other), bound)| (one - other).abs() * bound)
            .sum()
    };
    let held = differs(&law.of_readings(), &real.of_readings());
    match (&law.observer, &real.observer) {
        (Some(own), Some(stated)) => Apart {
            held: held + (&law.gains[0] - &real.gains[0]).abs() * state,
            state: differs(&own.into_state(&law.gains), &stated.into_state(&real.gains))
                + (own.own_decay(&law.gains) - stated.own_decay(&real.gains)).abs() * state,
        },
        _ => Apart {
            held,
            state: BigRational::zero(),
        },
    }
}

/// Whether the two claims are about starts at rest: an encoder is on the pivot, the module has an observer of the
/// angle's bias, or an encoder is on the wheel and no ellipsoid is stated.
pub fn applies(certificate: &Certificate) -> bool {
    let hardware = &certificate.hardware;
    let has_set = certificate.closed_loop.is_some();
    hardware.body_encoder().is_some()
        || certificate.bias_observer.is_some()
        || (hardware.wheel_speed.encoder.is_some() && !has_set)
}

/// Both claims: for all time, and the region.
pub fn by_exact_arithmetic(
    certificate: &Certificate,
    law: &EmittedLaw,
) -> (ClaimOutcome, ClaimOutcome) {
    if certificate.closed_loop.is_some() {
        let why = "an ellipsoid of the pendulum's three states is stated, but the angles in the window of an encoder on the \
                   pivot, or the observer of the angle's bias, are states of the loop too";
        let open = ClaimOutcome::NotRun("it needs closed-loop-for-all-time".to_owned());
        return (ClaimOutcome::Failed(why.to_owned()), open);
    }
    let shown = match LoopFromRest::of(certificate, law) {
        Ok(shown) => shown,
        Err(why) => return (outcome(Err(why.clone())), outcome(Err(why))),
    };
    let for_all_time = shown.for_all_time(certificate, law).map(|found| {
        format!(
            "from rest at up to {} rad, within {}: differs by at most {}",
            rounded_down(&found.start),
            four(&found.bounds.states, &found.bounds.command),
            four(&found.difference.states, &found.difference.command)
        )
    });
    let region = shown.from_rest(certificate).map(|found| found.said());
    (outcome(for_all_time), outcome(region))
}

/// The region alone, where the stated ellipsoid has none.
pub fn region(certificate: &Certificate, law: &EmittedLaw) -> ClaimOutcome {
    let shown = LoopFromRest::of(certificate, law);
    outcome(shown.and_then(|shown| Ok(shown.from_rest(certificate)?.said())))
}

impl FromRest {
    fn said(&self) -> String {
        format!(
            "from rest at up to {} rad, within {}; comes to, and stays within, {}",
            rounded_down(&self.start),
            four(&self.bounds.states, &self.bounds.command),
            four(&self.kept.states, &self.kept.command)
        )
    }
}

/// An angle, rounded down to steps of 1e-5 rad.
fn rounded_down(value: &BigRational) -> String {
    rounded_up(&((value * power(10, 5)).floor() * power(10, -5)), 6)
}

/// Bounds of the states and of the command.
fn four(states: &[BigRational; 3], command: &BigRational) -> String {
    let three = |value: &BigRational| rounded_up(value, 3);
    format!(
        "{} rad, {} rad/s, {} rad/s, {} A",
        three(&states[0]),
        three(&states[1]),
        three(&states[2]),
        three(command)
    )
}

fn outcome(found: Result<String, NoBounds>) -> ClaimOutcome {
    match found {
        Ok(detail) => ClaimOutcome::Proved(detail),
        Err(NoBounds::NotShown(why)) => ClaimOutcome::NotRun(why),
        Err(NoBounds::Unphysical(why)) => ClaimOutcome::Failed(why),
    }
}
