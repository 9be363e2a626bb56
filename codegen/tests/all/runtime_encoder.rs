//! Encoders and voltage drives: counts to turns, currents and speeds to the duty.

use codegen::control;
use codegen::hardware_words::{DutyWords, derive};
use codegen::helpers::encoder::{Encoder, EncoderNumbers, TURN_MAX, within_half};
use codegen::helpers::plane::on_plane;
use proptest::prelude::*;

use crate::benches::{with_voltage, with_wheel_encoder};
use crate::thesis;

/// Every difference of two counts of 12 bits is taken the shorter way round.
#[test]
fn the_shorter_way_round() {
    for difference in -4095..=4095_i32 {
        let found = within_half(difference, 4096);
        assert_eq!((found - difference).rem_euclid(4096), 0, "{difference}");
        assert!((-2048..2048).contains(&found), "{difference}: {found}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// The turn over the window is the difference of two places, however often the count wraps between them.
    #[test]
    fn the_turn_is_exact(
        bits in 4..=16_u32,
        window in 1..=16_i32,
        start in any::<i32>(),
        turns in prop::collection::vec(-1.0..1.0_f64, 40),
    ) {
        let wrap = 1 << bits;
        let numbers = EncoderNumbers { wrap, window, jump: wrap };
        let mut encoder = Encoder::new();
        let mut places = vec![i64::from(start)];
        for turn in turns {
            let count = places[places.len() - 1].rem_euclid(wrap.into());
            encoder.update(count as u16, &numbers);
            let before = places.len().saturating_sub(window as usize + 1);
            let wanted = places[places.len() - 1] - places[before];
            prop_assert_eq!(i64::from(encoder.turned(&numbers)), wanted);
            let most = f64::from(wrap / 2 - 1);
            places.push(places[places.len() - 1] + (turn * most) as i64);
        }
    }

    /// Any counts are accepted, and no step turns by more than half a wrap.
    #[test]
    fn any_counts(counts in prop::collection::vec(any::<u16>(), 40), bits in 4..=16_u32) {
        let numbers = EncoderNumbers { wrap: 1 << bits, window: 16, jump: 5 };
        let mut encoder = Encoder::default();
        for count in counts {
            encoder.update(count, &numbers);
            prop_assert!(encoder.turned(&numbers).abs() <= 16 * TURN_MAX);
            prop_assert!((0..numbers.wrap).contains(&encoder.count()));
        }
    }
}

/// A wheel at steady speed is not taken for a jump, neither at its first count nor across the wrap; a count out of line
/// is, at once.
#[test]
fn a_jump_is_noticed() {
    let spec = with_wheel_encoder(8);
    let words = derive(&spec, &control::derive(&spec).unwrap()).unwrap();
    let numbers = words.wheel_encoder.unwrap();
    // A sixty-fourth of a turn, and four times what 2 A do in a millisecond.
    let in_a_step = 261.555 * 2.0 * 1e-6 / std::f64::consts::TAU * 4096.0;
    assert_eq!(numbers.jump, (64.0 + 4.0 * in_a_step).ceil() as i32);
    let mut encoder = Encoder::new();
    let mut count = 3000;
    for _ in 0..100 {
        encoder.update(count, &numbers);
        assert!(!encoder.has_jumped());
        count = (count + 390) % 4096;
    }
    encoder.update((count + 100) % 4096, &numbers);
    assert!(encoder.has_jumped());
}

/// V = R u + k_e w over the whole range of both words, to half a count and the rounding of the slopes. Beyond the supply
/// voltage the duty stays at its end.
#[test]
fn duty_of_every_current_and_speed() {
    let spec = with_voltage(thesis::spec());
    let law = control::derive(&spec).unwrap();
    let words = derive(&spec, &law).unwrap();
    let DutyWords::Plane(plane) = &words.duty else {
        panic!("{:?}", words.duty);
    };
    let unit = |bits: u32| 2f64.powi(-(bits as i32));
    let current_unit = unit(law.current.fraction_bits);
    let speed_unit = unit(law.terms[2].input.format.fraction_bits);
    let mut ends = [0, 0];
    let all = || (i64::from(i32::MIN)..=i64::from(i32::MAX)).step_by(10_000_019);
    for current in all() {
        for speed in all() {
            let duty = on_plane(current as i32, speed as i32, plane);
            let volts = 2.3 * current as f64 * current_unit + 0.0335 * speed as f64 * speed_unit;
            let exact = (32_768.0 + volts / (24.0 / 32_767.0)).clamp(1.0, 65_535.0);
            assert!(
                (f64::from(duty) - exact).abs() < 0.51,
                "{current} {speed}: {duty}"
            );
            ends[0] += usize::from(duty == 1);
            ends[1] += usize::from(duty == 65_535);
        }
    }
    assert!(ends[0] > 100 && ends[1] > 100, "{ends:?}");
    assert_eq!(on_plane(0, 0, plane), 32_768);
}
