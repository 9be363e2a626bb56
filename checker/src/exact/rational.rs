//! Exact rational arithmetic on the decimals of the certificate, without floating point.

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

/// Fraction bits as an exponent.
pub(crate) fn exponent(bits: u32) -> i32 {
    i32::try_from(bits).unwrap_or(i32::MAX)
}

/// Reads `[-]digits[.digits][e[-]digits]`; `None` for anything else, and for exponents beyond
/// ±400 (no double has them).
pub fn decimal(text: &str) -> Option<BigRational> {
    let (mantissa, exponent) = match text.split_once('e') {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (text, 0),
    };
    let (sign, mantissa) = match mantissa.strip_prefix('-') {
        Some(rest) => (-1, rest),
        None => (1, mantissa),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let is_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || !is_digits(whole) || !is_digits(fraction) || exponent.abs() > 400 {
        return None;
    }
    if mantissa.ends_with('.') || mantissa.len() > 400 {
        return None;
    }
    let digits: BigInt = format!("{whole}{fraction}").parse().ok()?;
    let places = i32::try_from(fraction.len()).ok()?;
    Some(BigRational::from(digits * sign) * power(10, exponent - places))
}

/// `base` to the power of `exponent`, which may be negative.
pub fn power(base: u32, exponent: i32) -> BigRational {
    let magnitude = BigInt::from(base).pow(exponent.unsigned_abs());
    if exponent < 0 {
        BigRational::new_raw(BigInt::one(), magnitude)
    } else {
        BigRational::from(magnitude)
    }
}

/// 2^`exponent`.
pub fn power_of_two(exponent: i32) -> BigRational {
    power(2, exponent)
}

/// An integer as a rational.
pub fn integer(value: i128) -> BigRational {
    BigRational::from(BigInt::from(value))
}

/// A number at or above `value`, by less than 2⁻¹⁰⁰, whose digits are few: long chains of bounds stay fast.
pub fn short_above(value: BigRational) -> BigRational {
    BigRational::from((value * power_of_two(100)).ceil().to_integer()) * power_of_two(-100)
}

/// One half.
pub fn half() -> BigRational {
    BigRational::new(1.into(), 2.into())
}

/// Bits after the point of the square roots below.
const ROOT_BITS: i32 = 256;

/// A number at or above √`value`, by less than 2⁻²⁵⁶; `None` for a negative one.
pub fn root_above(value: &BigRational) -> Option<BigRational> {
    if value.is_negative() {
        return None;
    }
    let scaled = value * power_of_two(2 * ROOT_BITS);
    let floor = scaled.ceil().to_integer();
    let root = floor.sqrt();
    let root = if &root * &root == floor {
        root
    } else {
        root + 1
    };
    Some(BigRational::from(root) * power_of_two(-ROOT_BITS))
}

/// A number at or below √`value`, by less than 2⁻²⁵⁶; `None` for a negative one.
pub fn root_below(value: &BigRational) -> Option<BigRational> {
    if value.is_negative() {
        return None;
    }
    let scaled = value * power_of_two(2 * ROOT_BITS);
    let root = scaled.floor().to_integer().sqrt();
    Some(BigRational::from(root) * power_of_two(-ROOT_BITS))
}

/// Scientific notation with at most `digits` significant digits, the magnitude rounded up; exact
/// where the number has no more digits.
pub fn rounded_up(value: &BigRational, digits: u32) -> String {
    if value.is_zero() {
        return "0".to_owned();
    }
    let magnitude = value.abs();
    // Find the exponent with 10^exponent <= magnitude < 10^(exponent + 1).
    let length = |number: &BigInt| i32::try_from(number.to_string().len()).unwrap_or(i32::MAX);
    let mut exponent = length(magnitude.numer()) - length(magnitude.denom());
    if magnitude < power(10, exponent) {
        exponent -= 1;
    }
    let places = i32::try_from(digits).unwrap_or(40) - 1;
    let scaled = magnitude * power(10, places - exponent);
    let (quotient, rest) = scaled.numer().div_rem(scaled.denom());
    let mut mantissa = if rest.is_zero() {
        quotient
    } else {
        quotient + 1
    };
    if length(&mantissa) > places + 1 {
        mantissa /= 10;
        exponent += 1;
    }
    let text = mantissa.to_string();
    let (first, rest) = text.split_at(1);
    let rest = rest.trim_end_matches('0');
    let sign = if value.is_negative() { "-" } else { "" };
    let point = if rest.is_empty() { "" } else { "." };
    if exponent == 0 {
        format!("{sign}{first}{point}{rest}")
    } else {
        format!("{sign}{first}{point}{rest}e{exponent}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn d(text: &str) -> BigRational {
        decimal(text).unwrap()
    }

    #[test]
    fn decimals() {
        assert_eq!(d("-0.125"), BigRational::new((-1).into(), 8.into()));
        assert_eq!(d("4.5e-2"), BigRational::new(9.into(), 200.into()));
        assert_eq!(d("12e2"), integer(1200));
        for text in [
            "", "-", ".5", "5.", "1e", "+1", "1E5", "0x1", "1_0", "NaN", "1e999",
        ] {
            assert!(decimal(text).is_none(), "{text:?}");
        }
        assert_eq!(rounded_up(&(integer(1) / integer(3)), 3), "3.34e-1");
        assert_eq!(rounded_up(&d("-9.999"), 3), "-1e1");
        assert_eq!(rounded_up(&d("0.00125"), 9), "1.25e-3");
    }

    #[test]
    fn roots_enclose() {
        for text in ["2", "0.25", "0", "1e-30", "123456789.125"] {
            let value = d(text);
            let (low, high) = (root_below(&value).unwrap(), root_above(&value).unwrap());
            assert!(&low * &low <= value && value <= &high * &high);
            assert!(high - low <= power_of_two(-255));
        }
        assert!(root_above(&d("-1")).is_none());
    }
}
