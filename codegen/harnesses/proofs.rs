//! Kani harnesses: the properties on every input at once.
//!
//! Run all of them with `cargo kani` in the folder of this crate. A harness is called like the claim that it settles.
//! Solvers: overflow and ranges close fastest with Kani's default (CaDiCaL), comparison with exact
//! arithmetic only with kissat. Each `cover!` shows that a region which a claim speaks of is
//! reached at all.

use generated::CURRENT_LIMIT;

use crate::properties;

/// Every bit pattern of the three inputs.
#[kani::proof]
fn control_total() {
    let (angle, rate, wheel_speed) = (kani::any(), kani::any(), kani::any());
    let command = properties::control::total(angle, rate, wheel_speed);

    let limit = CURRENT_LIMIT.to_bits();
    kani::cover!(command == limit, "saturated at the upper limit");
    kani::cover!(command == -limit, "saturated at the lower limit");
    kani::cover!(0 < command && command < limit, "positive, unsaturated");
    kani::cover!(-limit < command && command < 0, "negative, unsaturated");
}

/// Every bit pattern of the three inputs.
#[kani::proof]
#[kani::solver(kissat)]
fn control_accurate() {
    let (angle, rate, wheel_speed) = (kani::any(), kani::any(), kani::any());
    properties::control::accurate_in_64_bits(angle, rate, wheel_speed);
}
