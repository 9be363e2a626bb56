//! The norm of the attitude's quaternion: every step keeps it within 1 ± 2⁻¹¹ (squared).
//!
//! Ranges of components cannot express this. It is proved by algebra on the source itself, with
//! words as polynomials ([`crate::domains::polynomials`]) and rational arithmetic:
//!
//! 1. `inverse_length`, `coarse_inverse_length`: n r² is 1 to within a stated share, by halving
//!    the range of n.
//! 2. `scaled_correction`: the product of direction and gain is therefore no longer than a bound C.
//! 3. `turned`: without the correction, the squares of the sum are, as polynomials, those of
//!    q times 1 + ‖h‖², with h the half-angles. The norm of the sum is thus known within C and rounding.
//! 4. `normalised`: its result is q S(ε), with ε the excess of ‖q‖² over 1, and (1 + ε) S(ε)² is 1
//!    within about 5ε³/8, with the coefficients of the source.
//! 5. `aligned`: four times a unit vector from `unit_q28`, which is a unit vector by step 1.
//! 6. Every change of the attitude's quaternion comes from `turned` or `aligned`, or leaves it
//!    unchanged, and a new quaternion is 1.
//!
//! The absence of overflow, and the ranges of half-angles and directions, are proved by
//! [`crate::claims::filter_total`]; this claim holds together with `filter-total`.

use std::collections::HashMap;

use num_rational::BigRational;
use num_traits::One;

use crate::claims::filter_length::aligned::aligned;
use crate::claims::filter_length::choices::clamp_is_nearest;
use crate::claims::filter_length::correction::correction;
use crate::claims::filter_length::normalised::normalised;
use crate::claims::filter_length::sources::Sources;
use crate::claims::filter_length::turned::turned;
use crate::claims::outcome::ClaimOutcome;
use crate::exact::rational::{power_of_two, rounded_up};
use crate::language::module::Module;
use crate::program::contract::Contract;

/// Largest distance of the squared length from 1, as a power of two: 2⁻¹¹.
pub const TOLERANCE_BITS: i32 = 11;

/// The bounds that were found for the squared length.
#[derive(Clone, Debug, PartialEq)]
pub struct SquaredNorms {
    /// Least and largest after a step with the correction, before it is normalised.
    pub before: (BigRational, BigRational),
    /// Smallest and largest squared length after a step.
    pub after_step: (BigRational, BigRational),
    /// Least and largest after an alignment.
    pub after_alignment: (BigRational, BigRational),
}

/// The outcome of the claim.
pub fn by_exact_arithmetic(module: &Module, contracts: &HashMap<usize, Contract>) -> ClaimOutcome {
    ClaimOutcome::proved(check(module, contracts).map(|lengths| {
        format!(
            "squared length after a step: {}; after an alignment: {}",
            distances(&lengths.after_step),
            distances(&lengths.after_alignment)
        )
    }))
}

/// Claim `filter-length`. `contracts` are those that [`crate::claims::primitives::proved`] allows.
///
/// # Errors
/// A sentence on what could not be shown.
pub fn check(
    module: &Module,
    contracts: &HashMap<usize, Contract>,
) -> Result<SquaredNorms, String> {
    clamp_is_nearest(module)?;
    let tolerance = power_of_two(-TOLERANCE_BITS);
    let around_one = (
        BigRational::one() - &tolerance,
        BigRational::one() + &tolerance,
    );
    let sources = Sources::read(module, contracts, &around_one)?;
    let correction = correction(module, &sources.beta)?;
    let before = turned(module, &around_one, &correction)?;
    let after_step = normalised(module, &before)?;
    let after_alignment = aligned(module)?;
    for (what, found) in [("a step", &after_step), ("an alignment", &after_alignment)] {
        if found.0 < around_one.0 || found.1 > around_one.1 {
            return Err(format!(
                "the squared length after {what} is not shown to be within 1 ± 2^-{TOLERANCE_BITS}"
            ));
        }
    }
    Ok(SquaredNorms {
        before,
        after_step,
        after_alignment,
    })
}

/// Both ends as distances from 1, rounded up, for a sentence.
fn distances(squared: &(BigRational, BigRational)) -> String {
    let text = |value: BigRational| rounded_up(&value, 2);
    let below = BigRational::one() - &squared.0;
    let above = &squared.1 - BigRational::one();
    format!("{} below, {} above", text(below), text(above))
}
