//! From real gains and ranges to the integers of the control law, in exact arithmetic.
//!
//! **Formats.** Each state and the command get the finest 32-bit format that holds their range.
//!
//! **Binary point of the products.** Let fᵢ be the fraction bits of state i. For a common point P
//! of the products, gain i has gᵢ = P − fᵢ fraction bits and the word Nᵢ = round(−Kᵢ 2^gᵢ). A
//! state's word is at most 2³¹ in magnitude, so for every bit pattern
//!
//! |Σ Nᵢ Xᵢ + 2^(s−1)| ≤ 2³¹ Σ|Nᵢ| + 2^(s−1),   s = P − f_current ≥ 1.
//!
//! P is the largest for which this is at most 2⁶³ − 1 and each Nᵢ fits 32 bits.
//!
//! **Error.** Rounding changes the sum by at most half a unit of the command. Saturation does not increase the distance
//! of two numbers, and two limits L, L′ change a saturated number by at most |L − L′|.
//! Together, the larger of the two bounds holds (case by case: both saturated, one, none). So
//!
//! - against the quantised gains: ½ unit;
//! - against the real gains: max(½ unit + Σ|Nᵢ 2^−gᵢ + Kᵢ| rᵢ, |L − L′|) for |xᵢ| ≤ rᵢ.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};

use crate::exact::{ShortestDecimal, nearest, outward, power_of_two};
use crate::format::Format;
use crate::ir::{Gain, IntegerLaw, StateInput, StepBounds, Term};
use crate::refusal::Refusal;
use crate::spec::ModuleSpec;

/// The largest number of bits that the rounding may remove: its half unit must fit 64 bits.
const LARGEST_SHIFT: u32 = 62;

/// The names of the three states, in the order of x.
struct State {
    type_name: &'static str,
    argument: &'static str,
    meaning: &'static str,
    unit: &'static str,
    range_name: &'static str,
    constant: &'static str,
    symbol: &'static str,
    gain_unit: &'static str,
}

const STATES: [State; 3] = [
    State {
        type_name: "Angle",
        argument: "angle",
        meaning: "Body angle relative to upright",
        unit: "rad",
        range_name: "angle range",
        constant: "ANGLE_GAIN",
        symbol: "K₁",
        gain_unit: "A/rad",
    },
    State {
        type_name: "Rate",
        argument: "rate",
        meaning: "Angular rate of the body",
        unit: "rad/s",
        range_name: "rate range",
        constant: "RATE_GAIN",
        symbol: "K₂",
        gain_unit: "A s/rad",
    },
    State {
        type_name: "WheelSpeed",
        argument: "wheel_speed",
        meaning: "Speed of the wheel relative to the body",
        unit: "rad/s",
        range_name: "wheel speed range",
        constant: "WHEEL_SPEED_GAIN",
        symbol: "K₃",
        gain_unit: "A s/rad",
    },
];

/// Derives the control law from a valid `spec` ([`ModuleSpec::validate`]).
///
/// # Errors
/// A [`Refusal`] if a range, a gain or the limit does not fit, or the error bound reaches one
/// count of the drive.
pub fn derive(spec: &ModuleSpec) -> Result<IntegerLaw, Refusal> {
    let ranges = [
        spec.ranges.angle_rad,
        spec.ranges.rate_rad_s,
        spec.ranges.wheel_speed_rad_s,
    ];
    let mut formats = [Format { fraction_bits: 0 }; 3];
    for ((format, range), state) in formats.iter_mut().zip(ranges).zip(&STATES) {
        *format = Format::for_range(&ShortestDecimal::new(range).value).ok_or(
            Refusal::RangeTooLarge {
                what: state.range_name,
                range,
            },
        )?;
    }

    let drive_range = ShortestDecimal::new(spec.drive.current_range_a());
    let current = Format::for_range(&drive_range.value).ok_or(Refusal::RangeTooLarge {
        what: "current range of the drive",
        range: spec.drive.current_range_a(),
    })?;
    let limit = ShortestDecimal::new(spec.current_limit_a);
    let limit_raw = limit_word(spec, &limit, &drive_range, current)?;

    let feedback = spec.gains.map(|gain| ShortestDecimal::new(gain).negated());
    if feedback
        .iter()
        .all(|gain| gain.value == BigRational::default())
    {
        return Err(Refusal::NoGain);
    }
    let (product_fraction_bits, words) = common_binary_point(&feedback, &formats, current)
        .ok_or(Refusal::GainsTooLarge { gains: spec.gains })?;

    let mut index = 0;
    let terms = STATES.map(|state| {
        let format = formats[index];
        let fraction_bits = product_fraction_bits - format.fraction_bits;
        let real = feedback[index].clone();
        let raw = words[index];
        let error = BigRational::from(BigInt::from(raw)) * power_of_two(-(fraction_bits as i32))
            - &real.value;
        let term = Term {
            input: StateInput {
                type_name: state.type_name,
                argument: state.argument,
                meaning: state.meaning,
                unit: state.unit,
                range: ShortestDecimal::new(ranges[index]),
                format,
            },
            gain: Gain {
                constant: state.constant,
                symbol: state.symbol,
                unit: state.gain_unit,
                real,
                raw,
                fraction_bits,
                error,
            },
        };
        index += 1;
        term
    });

    let bounds = bounds(&terms, current, &limit, limit_raw);
    let count = &drive_range.value / BigRational::from(BigInt::from(spec.drive.counts()));
    if bounds.real_gains >= count {
        return Err(Refusal::Inaccurate {
            bound_a: outward(&bounds.real_gains, 3),
            count_a: outward(&count, 3),
        });
    }

    Ok(IntegerLaw {
        terms,
        product_fraction_bits,
        shift: product_fraction_bits - current.fraction_bits,
        current,
        limit,
        limit_raw,
        bounds,
    })
}

fn limit_word(
    spec: &ModuleSpec,
    limit: &ShortestDecimal,
    drive_range: &ShortestDecimal,
    current: Format,
) -> Result<i32, Refusal> {
    if limit.value > drive_range.value {
        return Err(Refusal::LimitAboveDrive {
            limit_a: spec.current_limit_a,
            drive_a: spec.drive.current_range_a(),
        });
    }
    let word = (&limit.value * current.units_per_one())
        .floor()
        .to_integer();
    match word.to_i32() {
        Some(word) if word > 0 => Ok(word),
        _ => Err(Refusal::LimitBelowResolution {
            limit_a: spec.current_limit_a,
            resolution_a: outward(&current.unit(), 3),
        }),
    }
}

/// The largest common binary point of the products with its gain words, if there is one.
fn common_binary_point(
    feedback: &[ShortestDecimal; 3],
    states: &[Format; 3],
    current: Format,
) -> Option<(u32, [i32; 3])> {
    // Every gain needs at least zero fraction bits, and the rounding at least one bit to remove.
    let finest_state = states.iter().map(|format| format.fraction_bits).max()?;
    let lowest = finest_state.max(current.fraction_bits + 1);
    let highest = current.fraction_bits + LARGEST_SHIFT;
    (lowest..=highest).rev().find_map(|point| {
        let mut words = [0_i32; 3];
        for ((word, gain), state) in words.iter_mut().zip(feedback).zip(states) {
            let fraction_bits = point - state.fraction_bits;
            let scaled = &gain.value * power_of_two(fraction_bits as i32);
            *word = nearest(&scaled).to_i32().filter(|word| *word != i32::MIN)?;
        }
        let half_unit = 1_i128 << (point - current.fraction_bits - 1);
        let sum: i128 = words.iter().map(|word| i128::from(word.abs())).sum();
        let worst = sum * (1_i128 << 31) + half_unit;
        (worst <= i128::from(i64::MAX)).then_some((point, words))
    })
}

fn bounds(
    terms: &[Term; 3],
    current: Format,
    limit: &ShortestDecimal,
    limit_raw: i32,
) -> StepBounds {
    let half = BigRational::new(1.into(), 2.into());
    let rounding = current.unit() * &half;
    let mut unsaturated = rounding.clone();
    let mut state_rounding = BigRational::default();
    for term in terms {
        unsaturated += term.gain.error.abs() * &term.input.range.value;
        state_rounding += term.gain.real.value.abs() * term.input.format.unit() * &half;
    }
    let limit_error =
        (&limit.value - BigRational::from(BigInt::from(limit_raw)) * current.unit()).abs();
    StepBounds {
        rounding,
        real_gains: unsaturated.max(limit_error),
        state_rounding,
    }
}
