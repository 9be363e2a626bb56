//! Kani harnesses of the filter: each primitive's contract once, then the steps above them.
//!
//! A contract under `cfg_attr(kani, …)` is proved by a `proof_for_contract` harness and then stands in
//! for the function (`stub_verified`), so that the steps are proved from the contracts alone. Contracts of
//! long rows of products and of polynomials do not close as bits; they stand under `cfg_attr(any(), …)`,
//! where Kani does not see them, are proved by the checker by intervals (claim `primitives`), and stand
//! in by `stub`: `reciprocal_q29`, `arc_tangent_q31`, `normalised`, `unit_q28`, `correction_imu`,
//! `heading_turn`, `turned`, `turned_about_up`. (Kani refuses a plain stub of a function whose contract it sees.) Functions without
//! any contract stand in by `stub` too, each shown by a harness of its own here: `calibrate`, `without_motion`,
//! `length_squared`, `tracked`.

use generated::arc_tangent::{
    PI_Q28, QUARTER_PI_Q28, arc_tangent_q31, arc_tangent2, reciprocal_q29,
};
use generated::calibration::dot;
use generated::drift::{DriftGain, rate_error, tracked};
use generated::filter::FilterState;
use generated::madgwick::{
    COMPONENT_MAX, Correction, correction_imu, heading_turn, turned, turned_about_up, unit_q28,
};
use generated::pivot_angle::wrapped;
use generated::product::round_high;
use generated::root::{
    coarse_inverse_length, coarse_inverse_root_q30, inverse_length, inverse_root_q30, refined, seed,
};
use generated::scaling::{scaled_up2, scaled_up3, scaled_up4};
use generated::{calibration, lever_arm};

use crate::properties;
use crate::words::{any_within, assert_within};

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
#[kani::stub(reciprocal_q29, any_reciprocal)]
#[kani::stub(arc_tangent_q31, any_octant)]
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

// The stubs below replace a function by its contract: they return any result that the contract allows, for arguments
// that the contract allows. Rows of products with bounds that are no powers of two do not close as bits; these
// contracts are proved by the checker, which reads them in the source, by intervals.

fn any_reciprocal(n: i32) -> i32 {
    assert!((0x2000_0000..=0x4000_0000).contains(&n));
    let inverse = kani::any();
    kani::assume((-0x0c00_0000..=0x6000_0000).contains(&inverse));
    inverse
}

fn any_octant(t: i32) -> i32 {
    assert!(t >= 0);
    let angle = kani::any();
    kani::assume((0..=QUARTER_PI_Q28 + 256).contains(&angle));
    angle
}

/// A calibrated reading; [`calibration_in_range`] shows that it is one.
pub(crate) fn any_reading(_raw: [i16; 3], _line: &calibration::SensorLine) -> [i32; 3] {
    any_within(calibration::CALIBRATED_MAX)
}

/// A reading without the motion's part; [`lever_arm_in_range`] shows that it is one.
pub(crate) fn any_gravity(
    accel: [i32; 3],
    rate: i32,
    slow: i32,
    _arm: &lever_arm::LeverArm,
) -> [i32; 3] {
    let limit = calibration::CALIBRATED_MAX;
    assert_within(&accel, limit);
    assert_within(&[rate, slow], limit);
    any_within(0x4000_0000)
}

pub(crate) fn any_direction(v: [i32; 3]) -> [i32; 3] {
    assert_within(&v, 0x4000_0000);
    any_within(0x2800_0000)
}

pub(crate) fn any_correction(q: [i32; 4], measured_up: [i32; 3], beta: i32) -> Correction {
    assert_within(&q, COMPONENT_MAX);
    assert_within(&measured_up, 0x2800_0000);
    assert!((0..=0x1fff_ffff).contains(&beta));
    let gain: i32 = kani::any();
    kani::assume((0..=0x0980_0001).contains(&gain));
    kani::cover!(gain == 0x0980_0001, "the largest gain");
    Correction {
        direction: any_within(0x7000_0000),
        gain,
    }
}

fn any_heading_turn(q: [i32; 4], field: [i32; 3], limit: i32) -> i32 {
    assert_within(&q, COMPONENT_MAX);
    assert_within(&field, 0x2800_0000);
    assert!((0..=0x03ff_ffff).contains(&limit));
    let [half_angle] = any_within(0x03ff_ffff);
    half_angle
}

fn any_turn_about_up(q: [i32; 4], half_angle: i32) -> [i32; 4] {
    assert_within(&q, COMPONENT_MAX);
    assert_within(&[half_angle], 0x03ff_ffff);
    any_within(COMPONENT_MAX)
}

pub(crate) fn any_turn(q: [i32; 4], half_angle: [i32; 3], correction: &Correction) -> [i32; 4] {
    assert_within(&q, COMPONENT_MAX);
    assert_within(&half_angle, 0x2000_0000);
    assert_within(&correction.direction, 0x7000_0000);
    assert!((0..=0x0980_0001).contains(&correction.gain));
    any_within(COMPONENT_MAX)
}

pub(crate) fn any_angle(q: [i32; 4], _mounting: i32) -> i32 {
    assert_within(&q, COMPONENT_MAX);
    let [angle] = any_within(PI_Q28 + 1);
    angle
}

/// The squared length of a reading; [`length_in_range`] shows it.
pub(crate) fn any_length(v: [i32; 3]) -> i32 {
    assert_within(&v, 0x4000_0000);
    let squared = kani::any();
    kani::assume((0..=0x3000_0000).contains(&squared));
    squared
}

/// The error of the rate; the checker shows its range by intervals.
pub(crate) fn any_rate_error(q: [i32; 4], correction: &Correction) -> [i32; 3] {
    assert_within(&q, COMPONENT_MAX);
    assert_within(&correction.direction, 0x7000_0000);
    assert!((0..=0x0980_0001).contains(&correction.gain));
    kani::any()
}

/// A followed drift; [`drift_in_range`] shows it.
pub(crate) fn any_drift(_drift: i32, _error: i32, gain: &DriftGain) -> i32 {
    let [drift] = any_within(gain.limit);
    drift
}

#[kani::proof]
fn length_in_range() {
    let v: [i32; 3] = kani::any();
    for word in v {
        kani::assume((-0x4000_0000..=0x4000_0000).contains(&word));
    }
    let squared = lever_arm::length_squared(v);
    kani::cover!(squared == 0x3000_0000, "the longest");
    assert!((0..=0x3000_0000).contains(&squared));
}

/// Any drift within its limit and any error.
#[kani::proof]
fn drift_in_range() {
    let gain = &generated::constants::FILTER.drift;
    let drift = kani::any();
    kani::assume((-gain.limit..=gain.limit).contains(&drift));
    let next = tracked(drift, kani::any(), gain);
    kani::cover!(next == gain.limit, "the largest drift");
    assert!((-gain.limit..=gain.limit).contains(&next));
}

/// Any state within the invariant's ranges.
fn any_state() -> FilterState {
    let state = FilterState {
        quaternion: kani::any(),
        rate: kani::any(),
        slow_rate: kani::any(),
    };
    kani::assume(properties::attitude::in_ranges(&state));
    kani::cover!(
        state.quaternion[0] == COMPONENT_MAX,
        "the largest component"
    );
    state
}

/// Any state within the invariant's ranges, any reading.
#[kani::proof]
#[kani::stub(calibration::calibrate, any_reading)]
#[kani::stub(lever_arm::without_motion, any_gravity)]
#[kani::stub(lever_arm::length_squared, any_length)]
#[kani::stub(unit_q28, any_direction)]
#[kani::stub(correction_imu, any_correction)]
#[kani::stub(turned, any_turn)]
fn filter_total() {
    let (gyro, accel) = (kani::any(), kani::any());
    kani::cover!(accel == [0; 3], "free fall");
    kani::cover!(gyro == [i16::MIN; 3], "the gyroscope at its limit");
    properties::attitude::six_axes_keep_ranges(&any_state(), gyro, accel);
}

/// The turn by the magnetometer, of any state within the invariant's ranges and any reading.
#[kani::proof]
#[kani::stub(calibration::calibrate, any_reading)]
#[kani::stub(lever_arm::length_squared, any_length)]
#[kani::stub(unit_q28, any_direction)]
#[kani::stub(heading_turn, any_heading_turn)]
#[kani::stub(turned_about_up, any_turn_about_up)]
fn filter_total_heading() {
    let mag = kani::any();
    kani::cover!(mag == [0; 3], "no field");
    properties::attitude::heading_keeps_ranges(&any_state(), mag);
}

/// As [`filter_total`], with the gyroscope's drift, of any size within its limit.
#[kani::proof]
#[kani::stub(calibration::calibrate, any_reading)]
#[kani::stub(lever_arm::without_motion, any_gravity)]
#[kani::stub(lever_arm::length_squared, any_length)]
#[kani::stub(unit_q28, any_direction)]
#[kani::stub(correction_imu, any_correction)]
#[kani::stub(turned, any_turn)]
#[kani::stub(rate_error, any_rate_error)]
#[kani::stub(tracked, any_drift)]
fn filter_total_tracked() {
    let limit = generated::constants::FILTER.drift.limit;
    let drift: [i32; 3] = any_within(limit);
    properties::attitude::tracked_step_keeps_ranges(&any_state(), drift, kani::any(), kani::any());
}

/// Any components: the two rows of products fit, and the turn by the mounting angle is within half a turn.
#[kani::proof]
#[kani::stub_verified(round_high)]
#[kani::stub_verified(arc_tangent2)]
#[kani::stub_verified(wrapped)]
fn filter_total_angle() {
    let q: [i32; 4] = any_within(COMPONENT_MAX);
    properties::attitude::angle_is_within_half_a_turn(q);
}
