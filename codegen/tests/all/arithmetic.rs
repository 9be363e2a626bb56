//! For every specification: either it is refused, or the integers that stand in the emitted source
//! keep the bounds that the certificate states. The source is read back and evaluated here, with
//! checked arithmetic, so the generator's own data does not count as evidence.

use crate::thesis;

use codegen::spec::{ModuleSpec, PhysicalRanges, PwmDrive};
use codegen::{EmittedFile, Refusal, control, emit};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};
use proptest::prelude::*;

/// What the emitted `src/control.rs` says.
struct Law {
    state_bits: [u32; 3],
    current_bits: u32,
    gains: [i64; 3],
    limit: i64,
    shift: u32,
}

impl Law {
    fn read(source: &str) -> Self {
        let fraction_bits = |name: &str| {
            let alias = between(source, &format!("pub type {name} = fixed::types::I"), ";");
            let (whole, fraction) = alias.split_once('F').unwrap();
            let (whole, fraction): (u32, u32) = (whole.parse().unwrap(), fraction.parse().unwrap());
            assert_eq!(whole + fraction, 32);
            fraction
        };
        let integer = |start: &str, end: &str| -> i64 {
            let text = between(source, start, end).replace('_', "");
            text.parse().unwrap()
        };
        Self {
            state_bits: ["Angle", "Rate", "WheelSpeed"].map(fraction_bits),
            current_bits: fraction_bits("Current"),
            gains: ["ANGLE", "RATE", "WHEEL_SPEED"]
                .map(|name| integer(&format!("pub const {name}_GAIN: i32 = "), ";")),
            limit: integer("CURRENT_LIMIT: Current = Current::from_bits(", ")"),
            shift: integer("SHIFT: u32 = ", ";") as u32,
        }
    }

    /// The emitted function, with every operation checked for overflow.
    fn command(&self, words: [i32; 3]) -> i32 {
        let sum = self
            .gains
            .iter()
            .zip(words)
            .map(|(gain, word)| gain.checked_mul(word.into()).unwrap())
            .try_fold(0_i64, i64::checked_add)
            .unwrap();
        let half_unit = 1_i64.checked_shl(self.shift - 1).unwrap();
        let command = sum.checked_add(half_unit).unwrap() >> self.shift;
        command.clamp(-self.limit, self.limit).try_into().unwrap()
    }

    /// −N x without rounding or saturation, in A.
    fn exact(&self, words: [i32; 3]) -> BigRational {
        let sum: BigInt = self
            .gains
            .iter()
            .zip(words)
            .map(|(gain, word)| BigInt::from(*gain) * word)
            .sum();
        rational(sum) / power_of_two(self.shift + self.current_bits)
    }
}

fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    let (_, rest) = text
        .split_once(start)
        .unwrap_or_else(|| panic!("no {start:?}"));
    rest.split_once(end).unwrap().0
}

fn rational(value: impl Into<BigInt>) -> BigRational {
    BigRational::from(value.into())
}

fn power_of_two(exponent: u32) -> BigRational {
    rational(BigInt::from(1) << exponent)
}

fn decimal(value: f64) -> BigRational {
    codegen::exact::parse(&format!("{value:?}")).unwrap()
}

fn emitted_source(spec: &ModuleSpec) -> Result<EmittedFile, Refusal> {
    spec.validate()?;
    Ok(emit::control_rs::file(spec, &control::derive(spec)?))
}

/// Asserts every bound of the module for these words, given as fractions of a full turn of the
/// word or of the physical range.
fn assert_bounds(spec: &ModuleSpec, words: [i32; 3]) {
    let law = Law::read(&emitted_source(spec).unwrap().contents);
    let bounds = control::derive(spec).unwrap().bounds;
    let command = rational(law.command(words)) / power_of_two(law.current_bits);

    // Claim control-total: nothing above overflowed, and the limit holds.
    assert!(command.abs() <= decimal(spec.current_limit_a));

    // Claim control-accurate.
    let limit = rational(law.limit) / power_of_two(law.current_bits);
    let saturated = law.exact(words).clamp(-limit.clone(), limit);
    assert!((&command - saturated).abs() <= bounds.rounding);
    assert_eq!(
        bounds.rounding,
        power_of_two(law.current_bits + 1).recip(),
        "half a unit"
    );

    // Claim control-accurate-real-gains.
    let ranges = [
        spec.ranges.angle_rad,
        spec.ranges.rate_rad_s,
        spec.ranges.wheel_speed_rad_s,
    ];
    let mut real = BigRational::default();
    let mut within = true;
    for i in 0..3 {
        let state = rational(words[i]) / power_of_two(law.state_bits[i]);
        within &= state.abs() <= decimal(ranges[i]);
        real -= decimal(spec.gains[i]) * state;
    }
    if within {
        let limit = decimal(spec.current_limit_a);
        let error = (command - real.clamp(-limit.clone(), limit)).abs();
        assert!(error <= bounds.real_gains, "off by {error}");
    }
}

/// Words at `fractions` of the physical ranges, or, beyond 1, at that fraction of the whole format.
fn words(spec: &ModuleSpec, fractions: [f64; 3]) -> [i32; 3] {
    let law = Law::read(&emitted_source(spec).unwrap().contents);
    let ranges = [
        spec.ranges.angle_rad,
        spec.ranges.rate_rad_s,
        spec.ranges.wheel_speed_rad_s,
    ];
    let mut words = [0; 3];
    for i in 0..3 {
        words[i] = if fractions[i].abs() <= 1.0 {
            let state = decimal(ranges[i]) * BigRational::from_float(fractions[i]).unwrap();
            let word = state * power_of_two(law.state_bits[i]);
            word.trunc().to_integer().to_i32().unwrap()
        } else {
            // 1 … 2 is the whole format: −2 is i32::MIN, 2 is i32::MAX (the cast saturates).
            ((fractions[i].abs() - 1.0).copysign(fractions[i]) * 2_f64.powi(31)) as i32
        };
    }
    words
}

/// Log-uniform over twelve decades around one, of either sign.
fn magnitude() -> impl Strategy<Value = f64> {
    (-6.0..6.0_f64).prop_map(|exponent| 10_f64.powf(exponent))
}

prop_compose! {
    fn any_spec()(
        gains in prop::array::uniform3((magnitude(), prop::sample::select(vec![-1.0, 0.0, 1.0]))),
        ranges in prop::array::uniform3(magnitude()),
        drive in magnitude(),
        limit_fraction in 0.0..1.1_f64,
    ) -> ModuleSpec {
        ModuleSpec {
            gains: gains.map(|(magnitude, sign)| sign * magnitude),
            ranges: PhysicalRanges {
                angle_rad: ranges[0],
                rate_rad_s: ranges[1],
                wheel_speed_rad_s: ranges[2],
            },
            drive: PwmDrive { amperes_per_count: drive / 26_214.0, ..PwmDrive::THESIS_BENCH },
            current_limit_a: drive * limit_fraction,
            ..thesis::spec()
        }
    }
}

prop_compose! {
    /// Gains and ranges within three decades of the thesis bench: mostly accepted.
    fn plausible_spec()(
        gains in prop::array::uniform3(-1.5..1.5_f64),
        ranges in prop::array::uniform3(-1.5..1.5_f64),
        signs in prop::array::uniform3(prop::bool::ANY),
        drive in 0.5..20.0_f64,
        limit_fraction in 0.01..=1.0_f64,
    ) -> ModuleSpec {
        let mut spec = thesis::spec();
        for i in 0..3 {
            spec.gains[i] *= 10_f64.powf(gains[i]) * if signs[i] { 1.0 } else { -1.0 };
        }
        spec.ranges.angle_rad *= 10_f64.powf(ranges[0]);
        spec.ranges.rate_rad_s *= 10_f64.powf(ranges[1]);
        spec.ranges.wheel_speed_rad_s *= 10_f64.powf(ranges[2]);
        spec.drive.amperes_per_count = drive / 26_214.0;
        spec.current_limit_a = spec.drive.current_range_a() * limit_fraction;
        spec
    }
}

const CORNERS: [f64; 9] = [-2.0, -1.5, -1.0, -1e-9, 0.0, 1e-9, 1.0, 1.5, 2.0];

fn fractions() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(prop_oneof![
        prop::sample::select(CORNERS.to_vec()),
        -1.0..=1.0_f64,
        -2.0..=2.0_f64,
        // Near zero, where the command does not saturate.
        (-1.0..=1.0_f64).prop_map(|x| x * 1e-3),
    ])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn refused_or_within_its_bounds(spec in any_spec(), fractions in fractions()) {
        if emitted_source(&spec).is_ok() {
            assert_bounds(&spec, words(&spec, fractions));
        }
    }

    #[test]
    fn plausible_modules_keep_their_bounds(spec in plausible_spec(), fractions in fractions()) {
        match emitted_source(&spec) {
            Ok(_) => assert_bounds(&spec, words(&spec, fractions)),
            // Only a bound above one count of the drive may stop a plausible module.
            Err(refusal) => prop_assert!(matches!(refusal, Refusal::Inaccurate { .. }), "{refusal}"),
        }
    }
}

#[test]
fn the_thesis_bench_at_every_corner() {
    let spec = thesis::spec();
    for angle in CORNERS {
        for rate in CORNERS {
            for wheel_speed in CORNERS {
                assert_bounds(&spec, words(&spec, [angle, rate, wheel_speed]));
            }
        }
    }
}

/// The binary point is as fine as it can be: one more bit would let the sum or a gain overflow.
#[test]
fn no_bit_is_given_away() {
    let law = control::derive(&thesis::spec()).unwrap();
    let doubled: i128 = law
        .terms
        .iter()
        .map(|t| 2 * i128::from(t.gain.raw).abs())
        .sum();
    let word_overflows = law
        .terms
        .iter()
        .any(|t| t.gain.raw.checked_mul(2).is_none());
    let sum_overflows = (doubled << 31) + (1 << law.shift) > i128::from(i64::MAX);
    assert!(word_overflows || sum_overflows);
    // Derived by hand for half a turn, ±35.745 rad/s, ±690.58 rad/s and ±2.2 A.
    let state_bits = law
        .terms
        .clone()
        .map(|term| term.input.format.fraction_bits);
    let gain_bits = law.terms.clone().map(|term| term.gain.fraction_bits);
    assert_eq!(state_bits, [29, 25, 21]);
    assert_eq!(gain_bits, [25, 29, 33]);
    assert_eq!((law.current.fraction_bits, law.shift), (29, 25));
}
