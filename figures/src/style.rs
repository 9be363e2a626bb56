//! The one palette and the one set of sizes of every figure.
//!
//! The colours are dark enough for a white page (contrast at least 3:1, the
//! WCAG 2.1 limit for graphical objects) and stay apart for readers with
//! deuteranopia and protanopia; tests at the end of this file measure both.
//! They follow the palette of Okabe and Ito (2008), darkened where that
//! palette is too light for thin lines.

/// The meaning of a line or a marker. A role has the same colour in every figure, so a reader
/// learns the colours once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineRole {
    /// The readings of the sensors: grey, drawn wide and below everything else.
    Measurement,
    /// The predictions of the model: blue.
    Model,
    /// Measurement minus model: vermilion.
    Residual,
    /// The emitted fixed-point law: dark green.
    FixedPoint,
    /// The floating-point law: violet, drawn wide so that the
    /// fixed-point line on top of it leaves it visible.
    Float,
    /// Anything else; the number picks one of four further colours.
    Other(usize),
}

const OTHERS: [&str; 4] = ["#882255", "#8A6D00", "#332288", "#44808F"];
const OTHERS_PALE: [&str; 4] = ["#DDB3C8", "#DDD2A6", "#BDB7DD", "#B9D3DA"];

impl LineRole {
    /// The colour as `#rrggbb`.
    pub fn color(self) -> &'static str {
        match self {
            LineRole::Measurement => "#8C8C8C",
            LineRole::Model => "#0064A8",
            LineRole::Residual => "#D55E00",
            LineRole::FixedPoint => "#004D38",
            LineRole::Float => "#B25CFF",
            LineRole::Other(number) => OTHERS[number % OTHERS.len()],
        }
    }

    /// Stroke width of a line in pixels. A lower line is wider than the line on top of it, so that
    /// both are seen where they agree.
    pub(crate) fn line_width(self) -> f64 {
        match self {
            LineRole::Measurement => 2.6,
            LineRole::Float => 4.0,
            LineRole::Model | LineRole::FixedPoint => 1.2,
            LineRole::Residual => 1.0,
            LineRole::Other(_) => 1.5,
        }
    }

    /// A pale version of the colour, for clouds around a point.
    pub(crate) fn pale(self) -> &'static str {
        match self {
            LineRole::Measurement => "#CFCFCF",
            LineRole::Model => "#A8CBE5",
            LineRole::Residual => "#F4C4A1",
            LineRole::FixedPoint => "#A3CFC2",
            LineRole::Float => "#E3C8F8",
            LineRole::Other(number) => OTHERS_PALE[number % OTHERS_PALE.len()],
        }
    }

    /// Class attribute in the SVG.
    pub(crate) fn class(self) -> &'static str {
        match self {
            LineRole::Measurement => "measurement",
            LineRole::Model => "model",
            LineRole::Residual => "residual",
            LineRole::FixedPoint => "fixed-point",
            LineRole::Float => "float",
            LineRole::Other(_) => "other",
        }
    }
}

pub(crate) const TEXT: &str = "#1F1F1F";
pub(crate) const TEXT_MUTED: &str = "#5E5E5E";
pub(crate) const GRID: &str = "#E4E4E4";
pub(crate) const AXIS: &str = "#4A4A4A";
pub(crate) const LIMIT: &str = "#6B6B6B";
/// Shaded regions: where the model fails, where a loop is unstable.
pub(crate) const REGION: &str = "#FBE7C6";
/// The band of the sensor's own noise, and its edge, which is drawn on top of the data.
pub(crate) const BAND: &str = "#DCE9F3";
pub(crate) const BAND_EDGE: &str = "#2F4F6B";

pub(crate) const FONT: &str = "Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif";
pub(crate) const TITLE_SIZE: f64 = 16.0;
pub(crate) const LABEL_SIZE: f64 = 12.0;
pub(crate) const TICK_SIZE: f64 = 11.0;
pub(crate) const NOTE_SIZE: f64 = 10.5;

/// Width of every page in pixels.
pub(crate) const PAGE_WIDTH: f64 = 900.0;
/// Empty border of a page in pixels.
pub(crate) const PAGE_MARGIN: f64 = 16.0;

#[cfg(test)]
mod tests {
    use super::*;

    fn linear_rgb(hex: &str) -> [f64; 3] {
        [1, 3, 5].map(|at| {
            let value = u8::from_str_radix(&hex[at..at + 2], 16).unwrap();
            let value = f64::from(value) / 255.0;
            if value <= 0.04045 {
                value / 12.92
            } else {
                ((value + 0.055) / 1.055).powf(2.4)
            }
        })
    }

    fn multiply(matrix: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum::<f64>())
    }

    /// CIE L*a*b* for the D65 white point.
    fn lab(rgb: [f64; 3]) -> [f64; 3] {
        let xyz = multiply(
            [
                [0.4124564, 0.3575761, 0.1804375],
                [0.2126729, 0.7151522, 0.0721750],
                [0.0193339, 0.119_192, 0.9503041],
            ],
            rgb,
        );
        let white = [0.95047, 1.0, 1.08883];
        let mut f = [0.0; 3];
        for i in 0..3 {
            let t = (xyz[i] / white[i]).max(0.0);
            f[i] = if t > 216.0 / 24389.0 {
                t.cbrt()
            } else {
                (24389.0 / 27.0 * t + 16.0) / 116.0
            };
        }
        [
            116.0 * f[1] - 16.0,
            500.0 * (f[0] - f[1]),
            200.0 * (f[1] - f[2]),
        ]
    }

    const ROLES: [LineRole; 5] = [
        LineRole::Measurement,
        LineRole::Model,
        LineRole::Residual,
        LineRole::FixedPoint,
        LineRole::Float,
    ];

    #[test]
    fn roles_stay_apart_for_colour_blind_readers() {
        // Machado, Oliveira and Fernandes (2009), severity 1.0.
        let views = [
            (
                "full colour",
                [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            ),
            (
                "deuteranopia",
                [
                    [0.367322, 0.860646, -0.227968],
                    [0.280085, 0.672501, 0.047413],
                    [-0.011820, 0.042940, 0.968881],
                ],
            ),
            (
                "protanopia",
                [
                    [0.152286, 1.052583, -0.204868],
                    [0.114503, 0.786281, 0.099216],
                    [-0.003882, -0.048116, 1.051998],
                ],
            ),
        ];
        for (view, matrix) in views {
            for (i, a) in ROLES.iter().enumerate() {
                for b in &ROLES[i + 1..] {
                    let la = lab(multiply(matrix, linear_rgb(a.color())));
                    let lb = lab(multiply(matrix, linear_rgb(b.color())));
                    let distance = la
                        .iter()
                        .zip(lb)
                        .map(|(x, y)| (x - y).powi(2))
                        .sum::<f64>()
                        .sqrt();
                    // A just noticeable difference is 2.3; ten of them are
                    // safe for thin lines side by side.
                    assert!(
                        distance > 23.0,
                        "{view}: {a:?} and {b:?} only {distance:.1}"
                    );
                }
            }
        }
    }

    #[test]
    fn colours_are_readable_on_white_paper() {
        let others = (0..OTHERS.len()).map(LineRole::Other);
        for role in ROLES.into_iter().chain(others) {
            let rgb = linear_rgb(role.color());
            let luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
            let contrast = 1.05 / (luminance + 0.05);
            assert!(contrast >= 3.0, "{role:?}: contrast {contrast:.2}");
        }
    }
}
