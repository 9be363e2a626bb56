//! Kani proofs of the contracts of products, roundings and clamps, which every module has.

use generated::product::{clamp, clamp_wide, mul_high, round_high};

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
