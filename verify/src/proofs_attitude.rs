//! Kani harnesses of the filter: each primitive's contract once, then the steps above them.
//!
//! A contract is proved by a `proof_for_contract` harness and then stands in for the function
//! (`stub_verified`), so that the steps are proved from the contracts alone.

use generated::arc_tangent::{arc_tangent_q31, arc_tangent2, reciprocal_q29};
use generated::calibration::dot;
use generated::madgwick::COMPONENT_MAX;
use generated::pivot_angle::wrapped;
use generated::product::{clamp, clamp_wide, mul_high, round_high};
use generated::root::{inverse_length, inverse_root_q30, refined, seed, square_root_q30};
use generated::scaling::{scaled_up2, scaled_up3, scaled_up4};
use generated::{calibration, lever_arm, madgwick};

#[kani::proof_for_contract(mul_high)]
fn mul_high_contract() {
    mul_high(kani::any(), kani::any());
}

#[kani::proof_for_contract(round_high)]
fn round_high_contract() {
    round_high(kani::any());
}

#[kani::proof_for_contract(clamp)]
fn clamp_contract() {
    clamp(kani::any(), kani::any(), kani::any());
}

#[kani::proof_for_contract(clamp_wide)]
fn clamp_wide_contract() {
    clamp_wide(kani::any(), kani::any());
}

#[kani::proof_for_contract(seed)]
fn seed_contract() {
    seed(kani::any());
}

#[kani::proof_for_contract(refined)]
fn refined_contract() {
    refined(kani::any(), kani::any());
}

#[kani::proof_for_contract(inverse_root_q30)]
#[kani::stub_verified(seed)]
#[kani::stub_verified(refined)]
fn inverse_root_contract() {
    inverse_root_q30(kani::any());
}

#[kani::proof_for_contract(inverse_length)]
#[kani::stub_verified(inverse_root_q30)]
fn inverse_length_contract() {
    inverse_length(kani::any());
}

#[kani::proof_for_contract(square_root_q30)]
#[kani::stub_verified(inverse_root_q30)]
fn square_root_contract() {
    square_root_q30(kani::any());
}

#[kani::proof_for_contract(reciprocal_q29)]
fn reciprocal_contract() {
    reciprocal_q29(kani::any());
}

#[kani::proof_for_contract(arc_tangent_q31)]
fn arc_tangent_contract() {
    arc_tangent_q31(kani::any());
}

#[kani::proof_for_contract(scaled_up2)]
fn scaled_up2_contract() {
    scaled_up2(kani::any());
}

#[kani::proof_for_contract(scaled_up3)]
fn scaled_up3_contract() {
    scaled_up3(kani::any());
}

#[kani::proof_for_contract(scaled_up4)]
fn scaled_up4_contract() {
    scaled_up4(kani::any());
}

#[kani::proof_for_contract(arc_tangent2)]
#[kani::stub_verified(scaled_up2)]
#[kani::stub_verified(reciprocal_q29)]
#[kani::stub_verified(arc_tangent_q31)]
fn arc_tangent2_contract() {
    arc_tangent2(kani::any(), kani::any());
}

#[kani::proof_for_contract(wrapped)]
fn wrapped_contract() {
    wrapped(kani::any());
}

#[kani::proof_for_contract(dot)]
fn dot_contract() {
    dot(kani::any(), kani::any(), kani::any(), kani::any());
}

/// Raw counts of any value through the constants of this bench.
#[kani::proof]
fn calibration_in_range() {
    let raw: [i16; 3] = kani::any();
    for line in [
        &generated::constants::FILTER.gyro,
        &generated::constants::FILTER.accel,
        &generated::constants::FILTER.mag,
    ] {
        for value in calibration::calibrate(raw, line) {
            let limit = calibration::CALIBRATED_MAX;
            assert!((-limit..=limit).contains(&value));
        }
    }
}

/// Any rates and any calibrated reading.
#[kani::proof]
fn lever_arm_in_range() {
    let limit = calibration::CALIBRATED_MAX;
    let (accel, rate, slow): ([i32; 3], i32, i32) = (kani::any(), kani::any(), kani::any());
    for word in [accel[0], accel[1], accel[2], rate, slow] {
        kani::assume((-limit..=limit).contains(&word));
    }
    kani::cover!(rate == limit && slow == -limit, "the largest excess");
    let next = lever_arm::slow_rate(slow, rate);
    assert!((-limit..=limit).contains(&next));
    let arm = &generated::constants::FILTER.lever_arm;
    for value in lever_arm::without_motion(accel, rate, slow, arm) {
        assert!((-0x4000_0000..=0x4000_0000).contains(&value));
    }
}

/// Any quaternion that a step adds up: within ±3·2²⁹.
#[kani::proof]
fn normalised_in_range() {
    let q: [i32; 4] = kani::any();
    for component in q {
        kani::assume((-0x6000_0000..=0x6000_0000).contains(&component));
    }
    kani::cover!(q[0] == 0x6000_0000, "the largest component");
    for component in madgwick::normalised(q) {
        assert!((-COMPONENT_MAX..=COMPONENT_MAX).contains(&component));
    }
}
