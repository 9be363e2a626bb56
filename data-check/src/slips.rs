//! The usual mistakes with units and signs, as factors.

use crate::thresholds::slips::NEAR;
use std::f64::consts::{PI, TAU};

/// Radians in degrees.
pub(crate) const DEGREES: f64 = 180.0 / PI;
/// rad/s in revolutions a minute.
pub(crate) const RPM: f64 = 60.0 / TAU;

/// Ratios between two units of the same quantity.
const SIZES: [f64; 6] = [DEGREES, RPM, TAU, 1e3, 1e6, 1e9];

/// The known factor nearest to `factor`: a ratio of the list or its inverse, either with the sign of `factor`; or −1.
/// `None` for a factor near 1, and for one that is not near a known ratio.
pub(crate) fn slip(factor: f64) -> Option<f64> {
    let near = |size: f64| (factor.abs() / size).ln().abs() < NEAR;
    if near(1.0) {
        return (factor < 0.0).then_some(-1.0);
    }
    let sizes = SIZES.iter().flat_map(|size| [*size, 1.0 / size]);
    let found = sizes.filter(|size| near(*size)).min_by(|a, b| {
        let off = |size: &f64| (factor.abs() / size).ln().abs();
        off(a).total_cmp(&off(b))
    })?;
    Some(found.copysign(factor))
}

/// A number with at most three significant digits, for sentences.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-3..5).contains(&exponent) {
        return format!("{value:.2e}");
    }
    let decimals = usize::try_from(2 - exponent).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_found_within_their_errors_and_nothing_else_is_one() {
        for (factor, expected) in [
            (57.0, Some(DEGREES)),
            (-57.9, Some(-DEGREES)),
            (1.0 / 56.0, Some(1.0 / DEGREES)),
            (9.2, Some(RPM)),
            (6.3, Some(TAU)),
            (-1.05, Some(-1.0)),
            (1020.0, Some(1e3)),
            (1.08, None),
            (2.0, None),
            (0.4, None),
            (30.0, None),
        ] {
            assert_eq!(slip(factor), expected, "{factor}");
        }
    }

    #[test]
    fn numbers_in_sentences_are_short() {
        for (value, expected) in [
            (57.29577, "57.3"),
            (-1.0, "-1"),
            (0.104719, "0.105"),
            (9.5493, "9.55"),
            (1234.5, "1234"),
            (2.3e-5, "2.30e-5"),
        ] {
            assert_eq!(short(value), expected);
        }
    }
}
