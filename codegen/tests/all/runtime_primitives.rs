//! The emitted primitives against exact or double-precision arithmetic: exhaustively where the
//! domain allows, else on dense grids and random arguments.
//!
//! The error budget of each primitive is stated in its documentation and held here.

use codegen::helpers::arc_tangent::{PI_Q28, arc_tangent2};
use codegen::helpers::product::{clamp, clamp_wide, mul_high, round_high};
use codegen::helpers::root::{
    coarse_inverse_length, inverse_length, inverse_root_q30, refined, seed,
};
use codegen::helpers::scaling::{SCALED_MIN, scaled_up2, scaled_up3, scaled_up4};
use proptest::prelude::*;
use std::f64::consts::PI;

const Q30: f64 = (1u64 << 30) as f64;

/// The ranges of the contracts, which are wider than the true ones, on every argument.
#[test]
fn contracts_of_the_inverse_root() {
    for n in 0x1000_0000..0x4000_0000 {
        let y = seed(n);
        assert!((0x1200_0000..=0x4980_0000).contains(&y));
        let next = refined(2 * n, y);
        assert!(next >= 0 && next - y <= y >> 6);
    }
}

/// Every argument of a full octave pair.
#[test]
fn inverse_root_on_every_argument() {
    let (mut worst, mut least, mut most) = (0.0_f64, i32::MAX, 0);
    for n in 0x1000_0000..0x4000_0000 {
        let found = inverse_root_q30(n);
        let exact = Q30 / (f64::from(n) / f64::from(1 << 28)).sqrt();
        worst = worst.max((f64::from(found) - exact).abs());
        least = least.min(found);
        most = most.max(found);
    }
    println!("inverse root: worst error {worst:.2} units, range {least}..={most}");
    assert!(worst <= 8.0, "{worst}");
    assert!(
        least >= 0x1fff_fff0 && most <= 0x4000_0000,
        "{least} {most}"
    );
}

#[test]
fn inverse_length_over_its_range() {
    let (mut worst, mut coarse) = (0.0_f64, 0.0_f64);
    for n in (0x0400_0000..0x4000_0000).step_by(7) {
        let exact = Q30 / (f64::from(n) / f64::from(1 << 26)).sqrt();
        worst = worst.max((f64::from(inverse_length(n)) - exact).abs());
        coarse = coarse.max((f64::from(coarse_inverse_length(n)) / exact - 1.0).abs());
    }
    println!("inverse length: worst error {worst:.2} units, coarse {coarse:.2e}");
    assert!(coarse <= 2e-5, "{coarse}");
    assert!(worst <= 8.0, "{worst}");
    for n in [i32::MIN, -1, 0, 1, 0x03ff_ffff, 0x4000_0000, i32::MAX] {
        let y = inverse_length(n);
        assert!((0x1000_0000..=0x4000_0000).contains(&y), "{n} {y}");
    }
}

fn angle_error(y: i32, x: i32) -> f64 {
    let found = f64::from(arc_tangent2(y, x)) / f64::from(1 << 28);
    let exact = f64::from(y).atan2(f64::from(x));
    let difference = (found - exact).rem_euclid(2.0 * PI);
    difference.min(2.0 * PI - difference)
}

/// A dense grid of directions at lengths down to a few units, where the components' own rounding
/// is part of the exact argument and not an error.
#[test]
fn arc_tangent_on_a_dense_grid() {
    let mut worst = 0.0_f64;
    for length in [
        1 << 30,
        (1 << 30) - 12_345,
        1 << 29,
        300_000_001,
        1 << 22,
        5000,
        37,
        3,
    ] {
        for step in 0..1_000_000 {
            let direction = 2.0 * PI * f64::from(step) / 1e6;
            let x = (f64::from(length) * direction.cos()).round() as i32;
            let y = (f64::from(length) * direction.sin()).round() as i32;
            worst = worst.max(angle_error(y, x));
        }
    }
    println!("arc tangent: worst error {worst:.3e} rad");
    assert!(worst <= 4e-7, "{worst}");
}

#[test]
fn arc_tangent_at_its_corners() {
    assert_eq!(arc_tangent2(0, 0), 0);
    assert_eq!(arc_tangent2(0, 1), 0);
    assert_eq!(arc_tangent2(0, -1), PI_Q28);
    for edge in [
        1,
        2,
        3,
        (1 << 29) - 1,
        1 << 29,
        (1 << 29) + 1,
        (1 << 30) - 1,
        1 << 30,
    ] {
        for other in [0, 1, edge / 2, edge - 1, edge] {
            for (y, x) in [(edge, other), (other, edge)] {
                for (y, x) in [(y, x), (-y, x), (y, -x), (-y, -x)] {
                    assert!(angle_error(y, x) <= 4e-7, "{y} {x}");
                }
            }
        }
    }
}

/// What scaling must do whatever the vector: keep the direction exactly and the range.
fn assert_scaled(before: &[i32], after: &[i32], largest: i32) {
    let factor = before
        .iter()
        .zip(after)
        .find(|(b, _)| **b != 0)
        .map_or(1, |(b, a)| a / b);
    assert!(
        factor >= 1 && factor & (factor - 1) == 0,
        "{before:?} {after:?}"
    );
    for (b, a) in before.iter().zip(after) {
        assert_eq!(
            i64::from(*b) * i64::from(factor),
            i64::from(*a),
            "{before:?}"
        );
        assert!(a.abs() <= largest);
    }
}

fn is_long(v: &[i32]) -> bool {
    v.iter().any(|c| c.abs() >= SCALED_MIN)
}

/// Components of every size: a sign, a bit length and random bits below it.
fn component(bits: u32) -> impl Strategy<Value = i32> {
    (0..=bits, any::<i32>()).prop_map(
        |(bits, word)| {
            if bits == 0 { 0 } else { word >> (31 - bits) }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn products_are_the_upper_words(a in any::<i32>(), b in any::<i32>()) {
        let exact = i128::from(a) * i128::from(b);
        prop_assert_eq!(i128::from(mul_high(a, b)), exact.div_euclid(1 << 32));
        let sum = i64::from(a) * i64::from(b);
        prop_assert_eq!(i128::from(round_high(sum)), (exact + (1 << 31)).div_euclid(1 << 32));
    }

    #[test]
    fn clamps_are_the_nearest(value in any::<i32>(), wide in any::<i64>(), a in any::<i32>(), b in any::<i32>()) {
        prop_assert_eq!(clamp(value, a.min(b), a.max(b)), value.clamp(a.min(b), a.max(b)));
        let limit = a & i32::MAX;
        prop_assert_eq!(i64::from(clamp_wide(wide, limit)), wide.clamp(-i64::from(limit), i64::from(limit)));
    }

    #[test]
    fn scaling_keeps_direction(a in component(30), b in component(30), c in component(30), d in component(30)) {
        let two = scaled_up2([a, b]);
        assert_scaled(&[a, b], &two, 1 << 30);
        prop_assert!(is_long(&two) || [a, b] == [0, 0]);
        let three = scaled_up3([a, b, c]);
        assert_scaled(&[a, b, c], &three, 1 << 30);
        prop_assert!(is_long(&three) || [a, b, c].iter().all(|x| x.abs() < 1 << 14));
        let four = scaled_up4([a, b, c, d]);
        assert_scaled(&[a, b, c, d], &four, 1 << 30);
        prop_assert!(is_long(&four) || [a, b, c, d] == [0, 0, 0, 0]);
    }

    #[test]
    fn arc_tangent_of_random_vectors(y in component(30), x in component(30)) {
        prop_assume!((y, x) != (0, 0));
        prop_assert!(angle_error(y, x) <= 4e-7, "{} {}: {}", y, x, angle_error(y, x));
    }
}
