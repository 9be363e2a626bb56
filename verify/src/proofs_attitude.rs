//! Kani harnesses of the filter: each primitive's contract once, then the steps above them.
//!
//! A contract is proved by a `proof_for_contract` harness and then stands in for the function
//! (`stub_verified`), so that the steps are proved from the contracts alone.

use generated::arc_tangent::{arc_tangent_q31, arc_tangent2, reciprocal_q29};
use generated::calibration::dot;
use generated::filter::FilterState;
use generated::madgwick::{
    COMPONENT_MAX, Correction, component_q30, correction_imu, correction_marg, normalised,
    scaled_correction, turned, unit_q28, up_q28,
};
use generated::pivot_angle::wrapped;
use generated::product::{clamp, clamp_wide, mul_high, round_high};
use generated::root::{
    coarse_inverse_length, coarse_inverse_root_q30, inverse_length, inverse_root_q30, refined,
    seed, square_root_q30,
};
use generated::scaling::{scaled_up2, scaled_up3, scaled_up4};
use generated::{Controller, Sample, calibration, lever_arm};

use crate::properties;

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

#[kani::proof_for_contract(normalised)]
fn normalised_contract() {
    normalised(kani::any());
}

#[kani::proof_for_contract(unit_q28)]
#[kani::stub_verified(scaled_up3)]
#[kani::stub_verified(inverse_length)]
#[kani::stub_verified(mul_high)]
#[kani::stub_verified(round_high)]
fn unit_contract() {
    unit_q28(kani::any());
}

#[kani::proof_for_contract(up_q28)]
#[kani::stub_verified(round_high)]
fn up_contract() {
    up_q28(kani::any());
}

#[kani::proof_for_contract(coarse_inverse_length)]
#[kani::stub_verified(coarse_inverse_root_q30)]
fn coarse_inverse_length_contract() {
    coarse_inverse_length(kani::any());
}

#[kani::proof_for_contract(coarse_inverse_root_q30)]
#[kani::stub_verified(seed)]
#[kani::stub_verified(refined)]
fn coarse_inverse_root_contract() {
    coarse_inverse_root_q30(kani::any());
}

#[kani::proof_for_contract(scaled_correction)]
#[kani::stub_verified(scaled_up4)]
#[kani::stub_verified(coarse_inverse_length)]
#[kani::stub_verified(mul_high)]
fn scaled_correction_contract() {
    scaled_correction(kani::any(), kani::any(), kani::any());
}

#[kani::proof_for_contract(correction_imu)]
#[kani::stub_verified(up_q28)]
#[kani::stub_verified(round_high)]
#[kani::stub_verified(scaled_correction)]
fn correction_imu_contract() {
    correction_imu(kani::any(), kani::any(), kani::any());
}

#[kani::proof_for_contract(component_q30)]
#[kani::stub_verified(mul_high)]
fn component_contract() {
    component_q30(kani::any(), kani::any());
}

/// With range and size of each product in its place, forty of them are sums of words.
#[kani::proof_for_contract(correction_marg)]
#[kani::stub_verified(up_q28)]
#[kani::stub_verified(mul_high)]
#[kani::stub_verified(component_q30)]
#[kani::stub_verified(square_root_q30)]
#[kani::stub_verified(correction_imu)]
#[kani::stub_verified(scaled_correction)]
fn correction_marg_contract() {
    correction_marg(kani::any(), kani::any(), kani::any(), kani::any());
}

#[kani::proof_for_contract(turned)]
#[kani::stub_verified(round_high)]
#[kani::stub_verified(normalised)]
fn turned_contract() {
    let correction = Correction {
        direction: kani::any(),
        gain: kani::any(),
    };
    turned(kani::any(), kani::any(), &correction);
}

/// Any state within the invariant's ranges, any reading.
#[kani::proof]
#[kani::stub_verified(unit_q28)]
#[kani::stub_verified(correction_imu)]
#[kani::stub_verified(correction_marg)]
#[kani::stub_verified(turned)]
#[kani::stub_verified(round_high)]
#[kani::stub_verified(arc_tangent2)]
fn filter_total() {
    let state = FilterState {
        quaternion: kani::any(),
        rate: kani::any(),
        slow_rate: kani::any(),
    };
    kani::assume(properties::attitude::in_ranges(&state));
    let (gyro, accel, mag) = (kani::any(), kani::any(), kani::any());
    kani::cover!(
        state.quaternion[0] == COMPONENT_MAX,
        "the largest component"
    );
    kani::cover!(
        accel == [0; 3] && mag == [0; 3],
        "free fall without a field"
    );
    kani::cover!(gyro == [i16::MIN; 3], "the gyroscope at its limit");
    properties::attitude::step_keeps_ranges(&state, gyro, accel, mag);
}

/// Any two samples in a row. The contract of `turned` leaves any attitude within its ranges after the
/// first, and the gyroscope any rate, so that the second is a step from any state.
#[kani::proof]
#[kani::stub_verified(unit_q28)]
#[kani::stub_verified(correction_imu)]
#[kani::stub_verified(correction_marg)]
#[kani::stub_verified(turned)]
#[kani::stub_verified(round_high)]
#[kani::stub_verified(arc_tangent2)]
fn step_total() {
    let mut controller = Controller::new();
    for _ in 0..2 {
        let sample = Sample {
            gyro: kani::any(),
            accel: kani::any(),
            mag: kani::any(),
            wheel_adc: kani::any(),
        };
        let is_armed = kani::any();
        kani::cover!(is_armed && sample.mag.is_some(), "armed, nine axes");
        kani::cover!(!is_armed && sample.mag.is_none(), "not armed, six axes");
        properties::attitude::duty_within_limits(&mut controller, &sample, is_armed);
    }
}
