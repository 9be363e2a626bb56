//! Axes: ranges that cover the data, ticks at round numbers, labels with
//! units, and the conversion from values to pixels.

use crate::annotation::Quantity;

/// The scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Spacing {
    Linear,
    /// Logarithmic; values that are not positive are not shown.
    Log,
}

/// A range of values with its ticks.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    pub lo: f64,
    pub hi: f64,
    pub spacing: Spacing,
    pub ticks: Vec<f64>,
    pub labels: Vec<String>,
    /// The labels are `(value − offset) / 10^exponent`.
    pub exponent: i32,
    pub offset: f64,
}

/// Smallest and largest finite value; `None` if there is none.
pub(crate) fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .into_iter()
        .filter(|v| v.is_finite())
        .fold(None, |range, v| match range {
            None => Some((v, v)),
            Some((lo, hi)) => Some((lo.min(v), hi.max(v))),
        })
}

/// Values beyond this size are drawn at this size, so that every sum and
/// difference on an axis is finite.
const LARGEST: f64 = 1e300;

/// A range that is too narrow for distinct ticks is widened around its middle.
fn widened((lo, hi): (f64, f64)) -> (f64, f64) {
    let (lo, hi) = (lo.clamp(-LARGEST, LARGEST), hi.clamp(-LARGEST, LARGEST));
    let size = lo.abs().max(hi.abs());
    if hi - lo > size * 1e-12 && hi - lo > 1e-300 {
        (lo, hi)
    } else if size < 1e-290 {
        (-1.0, 1.0)
    } else {
        (lo - 0.1 * size, hi + 0.1 * size)
    }
}

impl Axis {
    /// A linear axis over `range` widened by `pad` (a share of the range) on
    /// both sides, with about one tick for each of `wanted_ticks`.
    pub fn linear(range: Option<(f64, f64)>, pad: f64, wanted_ticks: f64) -> Axis {
        let (lo, hi) = widened(range.unwrap_or((0.0, 1.0)));
        let margin = (hi - lo) * pad;
        let (lo, hi) = (lo - margin, hi + margin);
        let (step, ticks) = round_ticks(lo, hi, wanted_ticks);
        let (labels, offset, exponent) = linear_labels(&ticks, step);
        Axis {
            lo,
            hi,
            spacing: Spacing::Linear,
            ticks,
            labels,
            exponent,
            offset,
        }
    }

    /// A logarithmic axis over the positive part of the data.
    pub fn log(range: Option<(f64, f64)>, wanted_ticks: f64) -> Axis {
        let (lo, hi) = range
            .filter(|(lo, hi)| *lo > 0.0 && hi.is_finite())
            .unwrap_or((1.0, 10.0));
        // At least 0.8 decades, so that noise is not magnified and two ticks of 1, 2, 5 lie
        // within.
        let (lo, hi) = (lo.max(1e-290).log10(), hi.clamp(1e-290, 1e290).log10());
        let missing = (0.8 - (hi - lo)).max(0.0) / 2.0;
        let margin = 0.05 * (hi - lo).max(0.8);
        let (lo, hi) = (lo - missing - margin, hi + missing + margin);
        let ticks = log_ticks(lo, hi, wanted_ticks);
        let labels = ticks.iter().map(|t| log_label(*t)).collect();
        Axis {
            lo: 10f64.powf(lo),
            hi: 10f64.powf(hi),
            spacing: Spacing::Log,
            ticks,
            labels,
            exponent: 0,
            offset: 0.0,
        }
    }

    /// An axis for named things at 0, 1, 2, …
    pub fn names(count: usize) -> Axis {
        Axis {
            lo: -0.5,
            hi: count.max(1) as f64 - 0.5,
            spacing: Spacing::Linear,
            ticks: (0..count).map(|i| i as f64).collect(),
            labels: vec![String::new(); count],
            exponent: 0,
            offset: 0.0,
        }
    }

    /// The position of `value` between the ends, from 0 to 1; `None` if it is not on the axis.
    pub fn fraction(&self, value: f64) -> Option<f64> {
        let fraction = match self.spacing {
            Spacing::Linear => (value.clamp(-LARGEST, LARGEST) - self.lo) / (self.hi - self.lo),
            Spacing::Log if value > 0.0 => (value / self.lo).log10() / (self.hi / self.lo).log10(),
            Spacing::Log => return None,
        };
        fraction.is_finite().then_some(fraction)
    }

    /// "name (unit)", with the power of ten of the labels included, as an SI
    /// prefix if the unit takes one.
    pub fn caption(&self, quantity: Quantity) -> String {
        let mut caption = quantity.name.to_owned();
        if self.offset != 0.0 {
            let sign = if self.offset > 0.0 { '−' } else { '+' };
            caption.push_str(&format!(" {sign} {}", plain(self.offset.abs())));
        }
        let unit = match si_prefix(self.exponent) {
            _ if self.exponent == 0 => quantity.unit.to_owned(),
            Some(prefix) if PREFIXABLE.contains(&quantity.unit) => {
                format!("{prefix}{}", quantity.unit)
            }
            _ => format!("10{} {}", superscript(self.exponent), quantity.unit),
        };
        let unit = unit.trim();
        if !unit.is_empty() {
            caption.push_str(&format!(" ({unit})"));
        }
        caption
    }
}

/// The step of 1, 2 or 5 times a power of ten whose number of ticks comes
/// closest to `wanted`, at least two, and these ticks.
fn round_ticks(lo: f64, hi: f64, wanted: f64) -> (f64, Vec<f64>) {
    let power = 10f64.powf(((hi - lo) / wanted).log10().floor());
    let mut best: Option<(f64, f64, Vec<f64>)> = None;
    for digit in [10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1] {
        let step = digit * power;
        let ticks = multiples(lo, hi, step);
        let miss = (ticks.len() as f64 - wanted).abs();
        let better = best.as_ref().is_none_or(|(least, _, _)| miss < *least);
        if ticks.len() >= 2 && better {
            best = Some((miss, step, ticks));
        }
    }
    match best {
        Some((_, step, ticks)) => (step, ticks),
        // The two ends are always possible as ticks.
        None => (hi - lo, vec![lo, hi]),
    }
}

/// Ticks between 10^lo and 10^hi: 1, 2, 5 or 1, 3 of each decade or 1 of every
/// n-th decade, whichever gives closest to `wanted` ticks, at least two.
fn log_ticks(lo: f64, hi: f64, wanted: f64) -> Vec<f64> {
    let patterns: [(&[f64], f64); 8] = [
        (&[1.0], 20.0),
        (&[1.0], 10.0),
        (&[1.0], 5.0),
        (&[1.0], 3.0),
        (&[1.0], 2.0),
        (&[1.0], 1.0),
        (&[1.0, 3.0], 1.0),
        (&[1.0, 2.0, 5.0], 1.0),
    ];
    let mut best: Option<(f64, Vec<f64>)> = None;
    for (digits, every) in patterns {
        let decades = multiples(lo - every, hi, every);
        let ticks: Vec<f64> = decades
            .iter()
            .flat_map(|decade| digits.iter().map(|digit| digit * 10f64.powf(*decade)))
            .filter(|tick| (lo..=hi).contains(&tick.log10()))
            .collect();
        let miss = (ticks.len() as f64 - wanted).abs();
        if ticks.len() >= 2 && best.as_ref().is_none_or(|(least, _)| miss < *least) {
            best = Some((miss, ticks));
        }
    }
    match best {
        Some((_, ticks)) => ticks,
        None => vec![10f64.powf(lo), 10f64.powf(hi)],
    }
}

/// The multiples of `step` within `lo..=hi`.
fn multiples(lo: f64, hi: f64, step: f64) -> Vec<f64> {
    let slack = 1e-9;
    let first = (lo / step - slack).ceil();
    let last = (hi / step + slack).floor();
    let count = (last - first).clamp(-1.0, 100.0) as i64;
    (0..=count)
        .map(|i| (first + i as f64) * step)
        // A rounding error must not turn zero into 1e-17.
        .map(|tick| if tick.abs() < step * 1e-9 { 0.0 } else { tick })
        .collect()
}

/// Labels of equally spaced ticks, with the offset and the power of ten that
/// were removed to keep them short.
fn linear_labels(ticks: &[f64], step: f64) -> (Vec<String>, f64, i32) {
    let largest = ticks.iter().fold(0.0f64, |m, t| m.max(t.abs()));
    let first = ticks.first().copied().unwrap_or(0.0);
    let offset = if largest / step >= 1e5 {
        let coarse = 10f64.powf((step * ticks.len() as f64).log10().ceil());
        (first / coarse).floor() * coarse
    } else {
        0.0
    };
    let largest = ticks.iter().fold(0.0f64, |m, t| m.max((t - offset).abs()));
    let exponent = if largest > 0.0 && !(0.1..1e5).contains(&largest) {
        (largest.log10() / 3.0).floor() as i32 * 3
    } else {
        0
    };
    let scale = 10f64.powi(exponent);
    let decimals = (-(step / scale).log10() - 1e-9).ceil().clamp(0.0, 12.0) as usize;
    let labels = ticks
        .iter()
        .map(|t| minus_sign(format!("{:.decimals$}", (t - offset) / scale + 0.0)))
        .collect();
    (labels, offset, exponent)
}

fn log_label(value: f64) -> String {
    if (0.00099..99_999.0).contains(&value) {
        let decimals = (-value.log10() - 1e-9).ceil().max(0.0);
        return format!("{value:.*}", decimals as usize);
    }
    let exponent = (value.log10() + 1e-9).floor();
    let digit = (value / 10f64.powf(exponent)).round();
    let power = format!("10{}", superscript(exponent as i32));
    if digit == 1.0 {
        power
    } else {
        format!("{digit}·{power}")
    }
}

/// A number in few characters: fixed point if that is short, otherwise
/// with a power of ten. At most 12 significant digits.
fn plain(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e13).contains(&value.abs()) {
        return minus_sign(format!("{value:e}"));
    }
    let decimals = (11.0 - value.abs().max(1.0).log10().floor()).clamp(0.0, 8.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    minus_sign(text.to_owned())
}

/// A measured number with three significant digits.
pub(crate) fn three_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 {
            "0".into()
        } else {
            "–".into()
        };
    }
    let exponent = value.abs().log10().floor();
    if !(-3.0..6.0).contains(&exponent) {
        return minus_sign(format!("{value:.2e}"));
    }
    minus_sign(format!("{value:.*}", (2.0 - exponent).max(0.0) as usize))
}

fn minus_sign(text: String) -> String {
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    match text.strip_prefix('-') {
        Some(rest) if is_zero => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            '9' => '⁹',
            _ => '⁰',
        })
        .collect()
}

/// Units that read well with an SI prefix in front.
const PREFIXABLE: [&str; 12] = [
    "rad", "rad/s", "rad/s²", "A", "V", "s", "m", "N", "N m", "N m s", "J", "W",
];

fn si_prefix(exponent: i32) -> Option<&'static str> {
    Some(match exponent {
        -12 => "p",
        -9 => "n",
        -6 => "µ",
        -3 => "m",
        3 => "k",
        6 => "M",
        9 => "G",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn quantity<'a>(name: &'a str, unit: &'a str) -> Quantity<'a> {
        Quantity { name, unit }
    }

    fn check(axis: &Axis, lo: f64, hi: f64, longest_step: f64) -> Result<(), TestCaseError> {
        prop_assert!(axis.lo <= lo && hi <= axis.hi, "{axis:?} for {lo}..{hi}");
        prop_assert!(axis.ticks.len() >= 2, "{axis:?}");
        prop_assert_eq!(axis.ticks.len(), axis.labels.len());
        for pair in axis.ticks.windows(2) {
            prop_assert!(pair[0] < pair[1], "{axis:?}");
        }
        for pair in axis.labels.windows(2) {
            prop_assert!(pair[0] != pair[1], "{axis:?}");
        }
        // At the ends no stretch without a tick is longer than the longest
        // between ticks.
        let at: Vec<f64> = axis
            .ticks
            .iter()
            .map(|t| axis.fraction(*t).expect("ticks lie on the axis"))
            .collect();
        let longest = at
            .windows(2)
            .map(|w| w[1] - w[0])
            .fold(longest_step, f64::max);
        prop_assert!(at[0] >= -1e-6 && at[0] <= longest + 1e-6, "{axis:?}");
        let last = at[at.len() - 1];
        prop_assert!(
            last <= 1.0 + 1e-6 && 1.0 - last <= longest + 1e-6,
            "{axis:?}"
        );
        Ok(())
    }

    proptest! {
        #[test]
        fn linear_ticks_are_monotone_and_cover_the_data(
            middle in -1e6..1e6f64, scale in -12.0..8.0f64, wanted in 2.0..12.0f64,
        ) {
            let half = 10f64.powf(scale);
            let axis = Axis::linear(Some((middle - half, middle + half)), 0.04, wanted);
            check(&axis, middle - half, middle + half, 0.0)?;
        }

        #[test]
        fn log_ticks_are_monotone_and_cover_the_data(
            lo in -30.0..30.0f64, decades in 0.0..20.0f64, wanted in 3.0..12.0f64,
        ) {
            let (lo, hi) = (10f64.powf(lo), 10f64.powf(lo + decades));
            let axis = Axis::log(Some((lo, hi)), wanted);
            // The longest step within a decade is from 3 to 10; it need not lie
            // between two ticks of this axis.
            let longest = (10f64 / 3.0).log10() / (axis.hi / axis.lo).log10();
            check(&axis, lo, hi, longest)?;
        }

        #[test]
        fn a_constant_has_an_axis(value in prop::num::f64::NORMAL | prop::num::f64::ZERO) {
            let axis = Axis::linear(Some((value, value)), 0.04, 5.0);
            prop_assert!(axis.lo.is_finite() && axis.hi.is_finite() && axis.lo < axis.hi);
            prop_assert!(axis.ticks.len() >= 2, "{:?}", axis);
            let fraction = axis.fraction(value).expect("on the axis");
            prop_assert!((0.0..=1.0).contains(&fraction), "{fraction}");
        }
    }

    #[test]
    fn labels_carry_units_and_powers() {
        let small = Axis::linear(Some((-0.02, 0.02)), 0.0, 5.0);
        assert_eq!(
            small.caption(quantity("residual", "rad")),
            "residual (mrad)"
        );
        assert_eq!(small.labels, ["−20", "−10", "0", "10", "20"]);
        assert_eq!(
            small.caption(quantity("friction", "kg m2")),
            "friction (10⁻³ kg m2)"
        );

        let offset = Axis::linear(Some((1e9, 1e9 + 0.0042)), 0.0, 5.0);
        assert_eq!(
            offset.caption(quantity("time", "s")),
            "time − 1000000000 (ms)"
        );
        assert_eq!(offset.labels, ["0", "1", "2", "3", "4"]);

        let wide = Axis::linear(Some((0.0, 60.0)), 0.0, 7.0);
        assert_eq!(wide.labels, ["0", "10", "20", "30", "40", "50", "60"]);
        assert_eq!(wide.caption(quantity("share", "")), "share");
    }

    #[test]
    fn log_labels_read_as_numbers() {
        for (value, label) in [
            (0.001, "0.001"),
            (0.05, "0.05"),
            (0.2, "0.2"),
            (1.0, "1"),
            (50.0, "50"),
            (2000.0, "2000"),
            (1e6, "10⁶"),
            (2e-7, "2·10⁻⁷"),
        ] {
            assert_eq!(log_label(value), label);
        }
    }
}
