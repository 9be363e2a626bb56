//! The checks that a regulator must pass, and settings that pass them where the stated ones do not.

use crate::controller::LinearController;
use crate::error::DesignError;
use crate::friction::{FrictionCheck, FrictionExtremes, friction_check};
use crate::lqr::{DiscreteRegulator, Weights, discrete_regulator};
use crate::margins::{Margins, margins};
use crate::matrix::of_model;
use crate::poles::{eigenvalues, spectral_radius};
use crate::settings::Settings;
use crate::structural::reach;
use nalgebra::{Complex, RowVector3};
use plant::LinearModel;

/// Longest time constant of the slowest motion of a loop, s. A slower loop does not stabilise a bench in
/// practice: the wheel would run away while everything else is balanced.
const SLOWEST_DECAY_S: f64 = 3600.0;

/// Smallest relative difference between the cost and the same cost without the mode. For a smaller difference, rounding
/// decides.
const SEES_MIN: f64 = 1e-12;

/// Names of the states whose modes may not decay by themselves.
const STATE_NAMES: [&str; 2] = ["angle", "wheel"];

/// Refuses zero weights on a mode that does not decay by itself.
///
/// # Errors
/// [`DesignError::CostBlind`] with the state that dominates the mode.
pub(crate) fn require_that_the_cost_sees(
    model: &LinearModel,
    weights: &Weights,
) -> Result<(), DesignError> {
    let (a, _) = of_model(model)?;
    let (q, _) = weights.matrices()?;
    let seen = q.map(f64::sqrt);
    for mode in eigenvalues(&a)? {
        if mode.re < -1.0 / SLOWEST_DECAY_S {
            continue;
        }
        if reach(&a.transpose(), &seen.transpose(), mode)? < SEES_MIN {
            return Err(DesignError::CostBlind {
                state: state_of(mode),
                how: "its weight is zero, and without control it does not come to rest".to_owned(),
            });
        }
    }
    Ok(())
}

/// The state that dominates a mode of A: the angle for a mode that falls, the wheel for one that stays.
fn state_of(mode: Complex<f64>) -> &'static str {
    if mode.re > 1.0 / SLOWEST_DECAY_S {
        STATE_NAMES[0]
    } else {
        STATE_NAMES[1]
    }
}

/// The regulator at one sample time, with the margins of its loop.
fn regulator_at(
    model: &LinearModel,
    settings: &Settings,
    sample_time_s: f64,
) -> Result<(DiscreteRegulator, Margins), DesignError> {
    let regulator = discrete_regulator(model, &settings.weights, sample_time_s)?;
    let controller = LinearController::state_feedback(&regulator.gains);
    let discrete = &regulator.discrete;
    let closed = controller.closed_loop(&discrete.state, &discrete.input)?;
    let slowest = spectral_radius(&closed)?;
    // ρ^(t/T) = e⁻¹.
    let decay_s = -sample_time_s / slowest.ln();
    if !(0.0..=SLOWEST_DECAY_S).contains(&decay_s) {
        return Err(DesignError::CostBlind {
            state: STATE_NAMES[1],
            how: format!(
                "the loop would take {decay_s:.1e} s to come to rest (largest pole modulus \
                 {slowest:.12})"
            ),
        });
    }
    let (a, b) = of_model(model)?;
    let margins = margins(&a, &b, &controller, sample_time_s)?;
    Ok((regulator, margins))
}

/// The regulator at the required sample time, with its margins. If that sample time is too long, the error contains
/// a shorter one that works.
pub(crate) fn regulator_with_margins(
    model: &LinearModel,
    settings: &Settings,
) -> Result<(DiscreteRegulator, Margins), DesignError> {
    let (delay_margin_s, error) = match regulator_at(model, settings, settings.sample_time_s) {
        Ok((regulator, margins)) if margins.delay_margin_s >= settings.sample_time_s => {
            return Ok((regulator, margins));
        }
        Ok((_, margins)) => (margins.delay_margin_s, None),
        // Wrong weights are wrong at every sample time.
        Err(error @ DesignError::CostBlind { .. }) => return Err(error),
        Err(error) => (0.0, Some(error)),
    };
    // If a shorter sample time works, the sample time was the cause. The shorter one is rounded to two digits, as a
    // user will type it, before it is tried.
    let mut shorter_s = settings.sample_time_s;
    for _ in 0..60 {
        shorter_s = two_digits(0.5 * shorter_s);
        if shorter_s <= 0.0 {
            break;
        }
        if is_accepted(model, settings, shorter_s) {
            return Err(DesignError::SampleTimeTooLong {
                sample_time_s: settings.sample_time_s,
                delay_margin_s,
                longest_s: shorter_s,
                current_weight: settings.weights.current,
                larger_weight: larger_current_weight(model, settings),
            });
        }
    }
    Err(error.unwrap_or(DesignError::UnstableLoop {
        loop_name: "with a delay of one sample",
        spectral_radius: 1.0,
            cure: "no sample time gives enough delay margin with these weights; raise the current weight",
    }))
}

/// A larger current weight of two digits with which the design passes every check at its own sample time. The weight is
/// doubled until a design passes. `None` if no design does.
fn larger_current_weight(model: &LinearModel, settings: &Settings) -> Option<f64> {
    let mut slower = settings.clone();
    (0..80).find_map(|_| {
        slower.weights.current = two_digits(2.0 * slower.weights.current);
        is_accepted(model, &slower, settings.sample_time_s).then_some(slower.weights.current)
    })
}

/// Whether a design at this sample time passes every check.
fn is_accepted(model: &LinearModel, settings: &Settings, sample_time_s: f64) -> bool {
    let Ok((regulator, margins)) = regulator_at(model, settings, sample_time_s) else {
        return false;
    };
    let friction = |extremes: &FrictionExtremes| {
        stable_friction_check(extremes, &regulator.gains, sample_time_s).is_ok()
    };
    margins.delay_margin_s >= sample_time_s
        && settings.friction_extremes.as_ref().is_none_or(friction)
}

/// The largest number of two digits that does not exceed a positive one, as read from its decimal form.
fn two_digits(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 0.0;
    }
    let exponent = value.log10().floor() as i32 - 1;
    let digits = (value / 10f64.powi(exponent) * (1.0 + 1e-12)).floor();
    format!("{digits:.0}e{exponent}").parse().unwrap_or(0.0)
}

/// Checks the loop at both extremes of friction. A loop that is unstable without friction is an error, because the
/// bench would fall. A loop that is unstable with all friction hunts, and the check reports this.
pub(crate) fn stable_friction_check(
    extremes: &FrictionExtremes,
    gains: &RowVector3<f64>,
    sample_time_s: f64,
) -> Result<FrictionCheck, DesignError> {
    let check = friction_check(extremes, gains, sample_time_s)?;
    if check.none.is_stable() {
        Ok(check)
    } else {
        Err(DesignError::UnstableLoop {
            loop_name: "without Coulomb friction",
            spectral_radius: check.none.spectral_radius,
            cure: "the design relies on friction that is not always there; raise \
                   friction_linearisation_speed or leave it out",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_read_back() {
        for (value, text) in [
            (0.15, "0.15"),
            (0.0119, "0.011"),
            (4.56e-7, "0.00000045"),
            (0.1, "0.1"),
            (99.9, "99"),
            (2e-3, "0.002"),
        ] {
            assert_eq!(two_digits(value).to_string(), text);
        }
    }
}
