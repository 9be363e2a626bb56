//! Kani harnesses: the properties on every input at once.
//!
//! Run all of them with `cargo kani -p verify`. Solvers: overflow and ranges close fastest with
//! Kani's default (CaDiCaL), comparison with exact arithmetic only with kissat.

use generated::CURRENT_LIMIT;

use crate::properties;

/// Claim `control-total`, every bit pattern.
#[kani::proof]
fn control_total() {
    let (angle, rate, wheel_speed) = (kani::any(), kani::any(), kani::any());
    properties::control::total(angle, rate, wheel_speed);
}

/// Claim `control-accurate`, every bit pattern.
#[kani::proof]
#[kani::solver(kissat)]
fn control_accurate() {
    let (angle, rate, wheel_speed) = (kani::any(), kani::any(), kani::any());
    properties::control::accurate(angle, rate, wheel_speed);
}

/// Both ends of the limit and commands between them are reached, so that the proofs above speak of
/// saturated and unsaturated commands alike.
#[kani::proof]
fn control_reaches_every_region() {
    let (angle, rate, wheel_speed) = (kani::any(), kani::any(), kani::any());
    let command = properties::control::command_bits(angle, rate, wheel_speed);
    let limit = CURRENT_LIMIT.to_bits();
    kani::cover!(command == limit, "saturated at the upper limit");
    kani::cover!(command == -limit, "saturated at the lower limit");
    kani::cover!(0 < command && command < limit, "positive, unsaturated");
    kani::cover!(-limit < command && command < 0, "negative, unsaturated");
}
