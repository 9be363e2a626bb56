//! Exact arithmetic on the decimals that the certificate prints.
//!
//! A decimal number times powers of two stays a finite decimal, so every bound here has an exact
//! value; where it is printed short, it is rounded outward.

use num_bigint::{BigInt, Sign};
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

/// A finite `f64` as the decimal number that it prints as.
#[derive(Debug, Clone, PartialEq)]
pub struct ShortestDecimal {
    /// Shortest decimal that reads back as the same `f64`.
    pub text: String,
    /// The value of `text`, exactly.
    pub value: BigRational,
}

impl ShortestDecimal {
    /// The shortest decimal of `value`, which must be finite.
    pub fn new(value: f64) -> Self {
        debug_assert!(value.is_finite());
        // Adding zero turns −0 into 0.
        let printed = format!("{:?}", value + 0.0);
        let text = printed
            .strip_suffix(".0")
            .map_or(printed.clone(), str::to_owned);
        let value = parse(&text).expect("a finite f64 prints as a decimal");
        Self { text, value }
    }

    /// The same number with the opposite sign.
    pub fn negated(&self) -> Self {
        let text = match self.text.strip_prefix('-') {
            Some(positive) => positive.to_owned(),
            None if self.value.is_zero() => self.text.clone(),
            None => format!("-{}", self.text),
        };
        Self {
            text,
            value: -&self.value,
        }
    }
}

/// Reads `[-]digits[.digits][e[-]digits]`; `None` for anything else.
pub fn parse(text: &str) -> Option<BigRational> {
    let (mantissa, exponent) = match text.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (text, 0),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits: BigInt = format!("{whole}{fraction}").parse().ok()?;
    let places = i32::try_from(fraction.len()).ok()?;
    let power = exponent.checked_sub(places)?;
    Some(BigRational::from(digits) * power_of(10, power))
}

/// 2 to the power of `exponent`, which may be negative.
pub fn power_of_two(exponent: i32) -> BigRational {
    power_of(2, exponent)
}

fn power_of(base: u32, exponent: i32) -> BigRational {
    let magnitude = BigInt::from(base).pow(exponent.unsigned_abs());
    if exponent < 0 {
        BigRational::new_raw(BigInt::one(), magnitude)
    } else {
        BigRational::from(magnitude)
    }
}

/// Nearest integer, halves away from zero.
pub fn nearest(value: &BigRational) -> BigInt {
    value.round().to_integer()
}

/// Scientific notation with at most `digits` significant digits, the magnitude rounded up.
///
/// The text is exact if the number has at most `digits` digits. The magnitude of the printed number is never below that
/// of `value`, as a bound requires.
pub fn outward(value: &BigRational, digits: u32) -> String {
    if value.is_zero() {
        return "0".to_owned();
    }
    let sign = if value.is_negative() { "-" } else { "" };
    let magnitude = value.abs();

    // The exponent from the number of digits of numerator and denominator is right or one off.
    let mut exponent = decimal_length(magnitude.numer()) - decimal_length(magnitude.denom());
    if magnitude < power_of(10, exponent) {
        exponent -= 1;
    }
    let last_place = exponent + 1 - i32::try_from(digits).expect("a handful of digits");
    let scaled = &magnitude / power_of(10, last_place);
    let (quotient, remainder) = scaled.numer().div_rem(scaled.denom());
    let mut mantissa = if remainder.is_zero() {
        quotient
    } else {
        quotient + 1
    };
    // Rounding up may carry into one more digit: 9.99 becomes 10.0.
    if decimal_length(&mantissa) > i32::try_from(digits).expect("a handful of digits") {
        mantissa /= 10;
        exponent += 1;
    }
    let text = mantissa.to_string();
    let (first, rest) = text.split_at(1);
    let rest = rest.trim_end_matches('0');
    let point = if rest.is_empty() { "" } else { "." };
    match exponent {
        0 => format!("{sign}{first}{point}{rest}"),
        _ => format!("{sign}{first}{point}{rest}e{exponent}"),
    }
}

fn decimal_length(value: &BigInt) -> i32 {
    debug_assert!(value.sign() == Sign::Plus);
    i32::try_from(value.to_string().len()).expect("a number of a few hundred digits")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_exact() {
        let cases = [
            (0.1, "0.1", (1, 10)),
            (-24.5, "-24.5", (-49, 2)),
            (4e-9, "4e-9", (1, 250_000_000)),
            (2.0, "2", (2, 1)),
            (-0.0, "0", (0, 1)),
        ];
        for (value, text, (numerator, denominator)) in cases {
            let decimal = ShortestDecimal::new(value);
            assert_eq!(decimal.text, text);
            assert_eq!(
                decimal.value,
                BigRational::new(numerator.into(), denominator.into())
            );
            assert_eq!(decimal.negated().value, -decimal.value.clone());
            assert_eq!(parse(&decimal.negated().text), Some(-decimal.value));
        }
    }

    #[test]
    fn outward_never_prints_less() {
        let ratio = |n: i64, d: i64| BigRational::new(n.into(), d.into());
        let cases = [
            (ratio(1, 3), 3, "3.34e-1"),
            (ratio(-1, 3), 3, "-3.34e-1"),
            (ratio(9999, 10_000), 3, "1"),
            (ratio(1, 1 << 30), 40, "9.31322574615478515625e-10"),
            (ratio(12_345, 1), 2, "1.3e4"),
            (ratio(100, 1), 5, "1e2"),
            (ratio(1, 1000), 5, "1e-3"),
            (ratio(0, 1), 5, "0"),
        ];
        for (value, digits, text) in cases {
            assert_eq!(outward(&value, digits), text);
            let read = parse(text).expect("what was printed");
            assert!(read.abs() >= value.abs());
        }
    }

    #[test]
    fn nonsense_is_no_decimal() {
        for text in ["", "-", "1.2.3", "0x1", "1e", "NaN", "1e99999999999"] {
            assert_eq!(parse(text), None, "{text:?}");
        }
    }
}
