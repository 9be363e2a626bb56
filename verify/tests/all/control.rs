//! The properties of the control law on extreme and random words, and the numbers of the
//! certificate against the compiled law.

use crate::certificate;

use certificate::{Certificate, rational};
use generated::control::{ANGLE_GAIN, RATE_GAIN, SHIFT, WHEEL_SPEED_GAIN};
use generated::{Angle, CURRENT_LIMIT, Current, Rate, WheelSpeed};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive};
use proptest::prelude::*;
use serde_json::Value;
use verify::properties::control::{accurate, accurate_in_64_bits, command_bits, total};

/// The gains, in the order of the states.
const GAINS: [i32; 3] = [ANGLE_GAIN, RATE_GAIN, WHEEL_SPEED_GAIN];

/// Words at which integer code breaks: ends, their neighbours, zero, and powers of two.
fn extreme_words() -> Vec<i32> {
    let mut words = vec![0, i32::MIN, i32::MIN + 1, i32::MAX, i32::MAX - 1];
    for power in [0, 1, 15, 16, 24, 29, 30] {
        let word = 1_i32 << power;
        words.extend([word, -word, word - 1, 1 - word]);
    }
    words
}

#[test]
fn holds_for_every_combination_of_extreme_words() {
    let words = extreme_words();
    for &angle in &words {
        for &rate in &words {
            for &wheel_speed in &words {
                total(angle, rate, wheel_speed);
                accurate(angle, rate, wheel_speed);
                accurate_in_64_bits(angle, rate, wheel_speed);
            }
        }
    }
}

/// States whose command comes out close to a limit or to zero, where one unit decides.
#[test]
fn holds_around_saturation_and_zero() {
    let one_ampere = 1_i128 << (SHIFT + Current::FRAC_NBITS);
    let limit = i128::from(CURRENT_LIMIT.to_bits()) << SHIFT;
    for target in [limit, -limit, 0, one_ampere] {
        for wheel_speed in [i32::MIN, -1, 0, 1, 12_345_678, i32::MAX] {
            let rest = target - i128::from(WHEEL_SPEED_GAIN) * i128::from(wheel_speed);
            let angle = rest / i128::from(ANGLE_GAIN);
            for offset in -3..=3 {
                let Some(angle) = (angle + offset).to_i32() else {
                    continue;
                };
                for rate in -3..=3 {
                    total(angle, rate, wheel_speed);
                    accurate(angle, rate, wheel_speed);
                    accurate_in_64_bits(angle, rate, wheel_speed);
                }
            }
        }
    }
}

/// Asserts that the command is the nearest one, halves upward; returns how far the exact sum lies
/// above the half between two commands, in units of the sum.
fn assert_nearest(words: [i32; 3]) -> i128 {
    let unit = 1_i128 << SHIFT;
    let limit = i128::from(CURRENT_LIMIT.to_bits());
    let exact: i128 = GAINS
        .iter()
        .zip(words)
        .map(|(gain, word)| i128::from(*gain) * i128::from(word))
        .sum();
    let above_half = exact.rem_euclid(unit) - unit / 2;
    let expected = exact.div_euclid(unit) + i128::from(above_half >= 0);
    assert_eq!(
        i128::from(command_bits(words[0], words[1], words[2])),
        expected.clamp(-limit, limit),
        "words {words:?}"
    );
    above_half
}

#[test]
fn the_rounding_is_to_nearest_with_halves_upward() {
    for word in -20_000..20_000 {
        assert_nearest([word, 0, 0]);
        assert_nearest([word, -word, 7 * word]);
    }
    // Sums at the half and next to it. The gain with the fewest factors of two, g = odd·2^v, moves
    // the sum in the finest steps; its word for a given rest is that rest times 1/odd mod 2^SHIFT.
    let finest = (0..3).min_by_key(|i| GAINS[*i].trailing_zeros()).unwrap();
    let v = GAINS[finest].trailing_zeros();
    let odd = GAINS[finest] >> v;
    // Newton's iteration doubles the correct low bits: 3, 6, 12, 24, 48.
    let inverse = (0..4).fold(i64::from(odd), |x, _| {
        x.wrapping_mul(2_i64.wrapping_sub(x.wrapping_mul(odd.into())))
    });
    assert!(v < SHIFT, "no sum is a half");
    let steps_to_half = 1_i64 << (SHIFT - 1 - v);
    for step in -3..=3 {
        let word = (steps_to_half + step).wrapping_mul(inverse);
        let mut words = [0; 3];
        words[finest] = word.rem_euclid(1 << (SHIFT - v)).to_i32().unwrap();
        assert_eq!(assert_nearest(words), i128::from(step) << v);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn total_on_random_words(angle: i32, rate: i32, wheel_speed: i32) {
        total(angle, rate, wheel_speed);
    }

    /// Random words nearly always saturate, so the words are drawn with random lengths.
    #[test]
    fn accurate_on_random_words(
        angle: i32, rate: i32, wheel_speed: i32, shifts in prop::array::uniform3(0_u32..31),
    ) {
        let (angle, rate, wheel_speed) = (angle >> shifts[0], rate >> shifts[1], wheel_speed >> shifts[2]);
        accurate(angle, rate, wheel_speed);
        accurate_in_64_bits(angle, rate, wheel_speed);
    }

    /// Claim `control-accurate-real-gains`, in exact rational arithmetic.
    #[test]
    fn accurate_against_the_real_gains(fractions in prop::array::uniform3(-1.0_f64..=1.0)) {
        let certificate = Certificate::read();
        let words = words_within_the_ranges(certificate, fractions);
        assert_real_gains(certificate, words);
    }

    /// The emitted law against the law in double precision, the way a simulation uses it.
    #[test]
    fn agrees_with_double_precision(fractions in prop::array::uniform3(-1.0_f64..=1.0)) {
        let certificate = Certificate::read();
        let [angle, rate, wheel_speed] = words_within_the_ranges(certificate, fractions);
        let (angle, rate, wheel_speed) = (
            Angle::from_bits(angle), Rate::from_bits(rate), WheelSpeed::from_bits(wheel_speed),
        );
        let gains: Vec<f64> = (0..3).map(|i| number(&certificate.json["gains"][i])).collect();
        let limit = number(&certificate.constant("CURRENT_LIMIT")["real"]);
        let float = -(gains[0] * angle.to_num::<f64>()
            + gains[1] * rate.to_num::<f64>()
            + gains[2] * wheel_speed.to_num::<f64>());
        let float = float.clamp(-limit, limit);
        let emitted = generated::control(angle, rate, wheel_speed).to_num::<f64>();
        // The float itself is off by a few roundings of its largest term, about 1e-13 A.
        let bound = number(&certificate.json["bounds"]["real_gains_A"]) + 1e-12;
        prop_assert!((emitted - float).abs() <= bound, "{emitted} against {float}");
    }
}

/// The corners of the physical ranges, where the error against the real gains is largest.
#[test]
fn accurate_against_the_real_gains_at_the_corners() {
    let certificate = Certificate::read();
    for corner in 0..27 {
        let fractions = [corner % 3, corner / 3 % 3, corner / 9].map(|i| f64::from(i) - 1.0);
        assert_real_gains(certificate, words_within_the_ranges(certificate, fractions));
    }
}

/// The certificate speaks of the module that was compiled here.
#[test]
fn the_certificate_states_the_compiled_numbers() {
    let certificate = Certificate::read();
    let constants = [
        (
            "ANGLE_GAIN",
            ANGLE_GAIN,
            SHIFT + Current::FRAC_NBITS - Angle::FRAC_NBITS,
        ),
        (
            "RATE_GAIN",
            RATE_GAIN,
            SHIFT + Current::FRAC_NBITS - Rate::FRAC_NBITS,
        ),
        (
            "WHEEL_SPEED_GAIN",
            WHEEL_SPEED_GAIN,
            SHIFT + Current::FRAC_NBITS - WheelSpeed::FRAC_NBITS,
        ),
        (
            "CURRENT_LIMIT",
            CURRENT_LIMIT.to_bits(),
            Current::FRAC_NBITS,
        ),
    ];
    for (name, raw, fraction_bits) in constants {
        let stated = certificate.constant(name);
        assert_eq!(stated["raw"], raw, "{name}");
        assert_eq!(stated["fraction_bits"], fraction_bits, "{name}");
        // Nearest word; the limit is rounded toward zero.
        let error = rational(&stated["real"]) * power_of_two(fraction_bits) - integer(raw);
        let half = BigRational::new(1.into(), 2.into());
        if name == "CURRENT_LIMIT" {
            assert!(!error.is_negative() && error < BigRational::one(), "{name}");
        } else {
            assert!(error.abs() <= half, "{name}");
        }
    }
    let formats = [Angle::FRAC_NBITS, Rate::FRAC_NBITS, WheelSpeed::FRAC_NBITS];
    for (index, fraction_bits) in formats.into_iter().enumerate() {
        assert_eq!(
            certificate.json["inputs"][index]["fraction_bits"],
            fraction_bits
        );
    }
    assert_eq!(
        certificate.json["output"]["fraction_bits"],
        Current::FRAC_NBITS
    );
}

/// The stated bound is what the stated numbers add up to, not more than its last digit above.
#[test]
fn the_stated_bound_is_tight() {
    let certificate = Certificate::read();
    let mut bound = BigRational::new(1.into(), 2.into()) / power_of_two(Current::FRAC_NBITS);
    let names = ["ANGLE_GAIN", "RATE_GAIN", "WHEEL_SPEED_GAIN"];
    for (index, name) in names.into_iter().enumerate() {
        let constant = certificate.constant(name);
        let bits = constant["fraction_bits"].as_u64().unwrap() as u32;
        let raw = constant["raw"].as_i64().unwrap() as i32;
        let error = integer(raw) / power_of_two(bits) - rational(&constant["real"]);
        bound += error.abs() * rational(&certificate.json["inputs"][index]["range"]);
    }
    let stated = rational(&certificate.json["bounds"]["real_gains_A"]);
    assert!(stated >= bound);
    assert!(stated - &bound < bound / integer(1_000_000));
}

/// Words at the given fractions of the physical ranges, rounded toward zero.
fn words_within_the_ranges(certificate: &Certificate, fractions: [f64; 3]) -> [i32; 3] {
    let mut index = 0;
    fractions.map(|fraction| {
        let input = &certificate.json["inputs"][index];
        index += 1;
        let bits = input["fraction_bits"].as_u64().unwrap() as u32;
        let fraction = BigRational::from_float(fraction).unwrap();
        let word = rational(&input["range"]) * power_of_two(bits) * fraction;
        word.trunc().to_integer().to_i32().unwrap()
    })
}

/// |u − clamp(−K x, ±limit)| ≤ bound with the decimal numbers of the certificate.
fn assert_real_gains(certificate: &Certificate, words: [i32; 3]) {
    let [angle, rate, wheel_speed] = words;
    let command =
        integer(command_bits(angle, rate, wheel_speed)) / power_of_two(Current::FRAC_NBITS);
    let mut exact = BigRational::default();
    for (index, word) in words.into_iter().enumerate() {
        let bits = certificate.json["inputs"][index]["fraction_bits"]
            .as_u64()
            .unwrap() as u32;
        exact -= rational(&certificate.json["gains"][index]) * integer(word) / power_of_two(bits);
    }
    let limit = rational(&certificate.constant("CURRENT_LIMIT")["real"]);
    let saturated = exact.clamp(-limit.clone(), limit);
    let error = (command - saturated).abs();
    let bound = rational(&certificate.json["bounds"]["real_gains_A"]);
    assert!(error <= bound, "words {words:?}: off by {error}");
}

fn integer(value: i32) -> BigRational {
    BigRational::from(BigInt::from(value))
}

fn power_of_two(exponent: u32) -> BigRational {
    BigRational::from(BigInt::one() << exponent)
}

fn number(text: &Value) -> f64 {
    text.as_str().unwrap().parse().unwrap()
}
