//! Numbers for people, with as many digits as are meaningful.

/// Largest number of digits of a number in a table or a sentence; files and JSON contain all digits.
const DIGITS: usize = 4;

/// A value with its standard error, both to the same decimal place, the error with two digits:
/// `(2.303 ± 0.012)e-3`. If the error is smaller than the fourth digit of the value, each has its own
/// digits: `0.002303 ± 1.2e-6`. Without a standard error, the value has four digits.
pub fn with_uncertainty(value: f64, std: Option<f64>) -> String {
    match std {
        Some(std) if std.is_finite() && std > 0.0 && value.is_finite() => {
            let exponent = exponent_of(value.abs().max(std));
            let plain = (-2..4).contains(&exponent);
            let shift = if plain { 0 } else { exponent };
            let decimals = usize::try_from(shift + 1 - exponent_of(std)).unwrap_or(0);
            if exponent - exponent_of(std) + 2 > DIGITS as i32 {
                return format!("{} ± {}", number(value), significant(std, 2));
            }
            let scale = 10_f64.powi(-shift);
            let text = format!("{:.decimals$} ± {:.decimals$}", value * scale, std * scale);
            if plain {
                text
            } else {
                format!("({text})e{exponent}")
            }
        }
        _ => number(value),
    }
}

/// A number for a sentence or a table: at most four significant digits.
pub fn number(value: f64) -> String {
    significant(value, DIGITS)
}

/// Below this fit, in %, the prediction is off by more than ten times the scatter of the signal: it follows nothing.
const DIVERGED: f64 = -900.0;

/// A fit in percent with at most four digits; a dash if there is none, as for a constant signal, and "diverged" for a
/// prediction that left the signal altogether.
pub fn fit_percent(value: f64) -> String {
    if !value.is_finite() {
        "–".to_owned()
    } else if value < DIVERGED {
        "diverged".to_owned()
    } else if value.abs() < 99.995 {
        format!("{value:.2} %")
    } else {
        format!("{} %", number(value))
    }
}

/// A number with this many significant digits and no trailing zeros.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    // Rounded first, since 9.9999996 rounds to 10, which has another exponent.
    let rounded: f64 = format!("{value:.*e}", digits.saturating_sub(1))
        .parse()
        .unwrap_or(value);
    let exponent = exponent_of(rounded.abs());
    if (-4..7).contains(&exponent) {
        let decimals =
            usize::try_from(i32::try_from(digits).unwrap_or(17) - 1 - exponent).unwrap_or(0);
        without_zeros(&format!("{rounded:.decimals$}"))
    } else {
        let text = format!("{rounded:.*e}", digits.saturating_sub(1));
        match text.split_once('e') {
            Some((mantissa, exponent)) => format!("{}e{exponent}", without_zeros(mantissa)),
            None => text,
        }
    }
}

fn without_zeros(text: &str) -> String {
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text.to_owned()
    }
}

fn exponent_of(positive: f64) -> i32 {
    positive.log10().floor() as i32
}

/// A share in percent to two digits: `0.034` is `3.4 %`.
pub fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 2))
}

/// An angle in degrees to three digits: `1.25°`.
pub fn degrees(angle_rad: f64) -> String {
    format!("{}°", significant(angle_rad.to_degrees(), 3))
}

/// A complex number as `a + bj`, or `a` where it is real, with six digits: for matrices and their eigenvalues.
pub fn complex(re: f64, im: f64) -> String {
    complex_with(re, im, 6)
}

/// A complex number for a sentence: at most four significant digits.
pub fn complex_number(re: f64, im: f64) -> String {
    complex_with(re, im, DIGITS)
}

fn complex_with(re: f64, im: f64, digits: usize) -> String {
    if im == 0.0 {
        return significant(re, digits);
    }
    let sign = if im < 0.0 { '−' } else { '+' };
    format!(
        "{} {sign} {}j",
        significant(re, digits),
        significant(im.abs(), digits)
    )
}

/// A number in a unit with the prefix that makes it readable: `22.3 mrad`.
pub fn with_prefix(value: f64, unit: &str) -> String {
    let (scale, prefix) = match value.abs() {
        size if size == 0.0 || size >= 0.1 => (1.0, ""),
        size if size >= 1e-4 => (1e3, "m"),
        _ => (1e6, "µ"),
    };
    format!("{} {prefix}{unit}", significant(value * scale, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_carry_the_digits_that_their_errors_allow() {
        let cases = [
            (2.30344e-3, Some(1.2e-5), "(2.303 ± 0.012)e-3"),
            (-2.30344e-3, Some(1.2e-5), "(-2.303 ± 0.012)e-3"),
            (2.30344e-3, Some(1.2e-6), "0.002303 ± 1.2e-6"),
            (0.25, Some(3.0e-301), "0.25 ± 3e-301"),
            (0.0335, Some(0.0001), "0.03350 ± 0.00010"),
            (12.345678, Some(0.5), "12.35 ± 0.50"),
            (1.0e-7, Some(3.0e-6), "(0.1 ± 3.0)e-6"),
            (123456.0, Some(1000.0), "(1.235 ± 0.010)e5"),
            (1234.5, Some(100.0), "1234 ± 100"),
            (0.245158, None, "0.2452"),
            (2.30344e-3, None, "0.002303"),
            (1.36125e-5, None, "1.361e-5"),
            (9.81, None, "9.81"),
            (0.99999999, None, "1"),
            (0.0, Some(0.0), "0"),
            (1e300, None, "1e300"),
            (f64::NAN, None, "NaN"),
        ];
        for (value, std, expected) in cases {
            assert_eq!(with_uncertainty(value, std), expected);
        }
    }

    #[test]
    fn fits_have_four_digits_or_none() {
        for (value, expected) in [
            (99.204, "99.20 %"),
            (100.0, "100 %"),
            (-12.3456, "-12.35 %"),
            (-623.456, "-623.5 %"),
            (-123_456.0, "diverged"),
            (f64::NAN, "–"),
            (f64::NEG_INFINITY, "–"),
        ] {
            assert_eq!(fit_percent(value), expected);
        }
    }

    #[test]
    fn prefixes_and_complex_numbers() {
        assert_eq!(with_prefix(0.0223, "rad"), "22.3 mrad");
        assert_eq!(with_prefix(0.598, "rad/s"), "0.598 rad/s");
        assert_eq!(with_prefix(3.2e-5, "N m s"), "32 µN m s");
        assert_eq!(degrees(-2.154), "-123°");
        assert_eq!(degrees(0.021_816_6), "1.25°");
        assert_eq!(complex(-11.9, 0.0), "-11.9");
        assert_eq!(complex(-1.5, -2.25), "-1.5 − 2.25j");
    }
}
