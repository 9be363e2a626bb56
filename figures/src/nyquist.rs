//! Nyquist's plot: the open loop in the complex plane, with the point −1 that it must keep away from.

use crate::annotation::Quantity;
use crate::axis::Axis;
use crate::error::{FigureError, check_length};
use crate::frame::{self, Frame};
use crate::page::{self, Key, Mark, Page};
use crate::style::{self, LineRole};
use crate::svg::{Path, Stroke};

/// The open loops of one or several designs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Nyquist<'a> {
    /// The title: a sentence that says what the figure shows.
    pub title: &'a str,
    /// Details, written below the title; may be empty.
    pub subtitle: &'a str,
    /// The curves.
    pub curves: &'a [NyquistCurve<'a>],
}

/// The upper half of one curve: from low to high frequencies.
#[derive(Debug, Clone, Copy)]
pub struct NyquistCurve<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Gives the colour.
    pub role: LineRole,
    /// Real parts.
    pub re: &'a [f64],
    /// Imaginary parts.
    pub im: &'a [f64],
    /// Least distance from −1: the radius of the circle around it that the curve touches.
    pub modulus_margin: f64,
}

/// Half of the width of the drawn square.
const REACH: f64 = 3.0;
/// Points of a circle.
const CORNERS: usize = 180;

/// Draws with equal scales: the curves, their mirror images in thin lines, the unit circle, and for each curve the
/// circle around −1 that the curve touches.
///
/// # Errors
/// [`FigureError::Length`] if a curve has not one imaginary part for each real part.
pub fn nyquist(figure: &Nyquist) -> Result<String, FigureError> {
    for curve in figure.curves {
        let what = || format!("the curve \"{}\"", curve.name);
        check_length(figure.title, what, curve.re.len(), curve.im.len())?;
    }
    let mut page = Page::new(figure.title, figure.subtitle);
    let curves = figure.curves.iter();
    let mut keys: Vec<Key> = curves
        .map(|curve| Key::line(curve.role, curve.name))
        .collect();
    let color = LineRole::Residual.color();
    keys.push(Key::new(Mark::Cross { color }, "−1"));
    let color = style::LIMIT;
    keys.push(Key::new(
        Mark::Dashed { color },
        "unit circle, and the circle around −1 that each curve touches",
    ));
    page.legend(&keys);
    let side = 560.0;
    let axis = |middle: f64| {
        Axis::linear(
            Some((middle - REACH, middle + REACH)),
            0.0,
            frame::y_ticks(side),
        )
    };
    let frame = Frame {
        left: style::PAGE_MARGIN + 50.0,
        top: page.y + frame::CAPTION,
        width: side,
        height: side,
        x: axis(-1.5),
        y: axis(0.0),
    };
    frame.grid(&mut page.svg, true);
    frame.zero_line(&mut page.svg);
    frame.begin_clip(&mut page.svg);
    circle(
        &mut page,
        &frame,
        0.0,
        1.0,
        Stroke::dashed(style::LIMIT, 1.0),
    );
    for curve in figure.curves {
        circle(
            &mut page,
            &frame,
            -1.0,
            curve.modulus_margin,
            Stroke::dashed(curve.role.color(), 1.0),
        );
        page.svg.begin_series(curve.role.class(), curve.name);
        let mirrored: Vec<f64> = curve.im.iter().map(|im| -im).collect();
        frame.line(
            &mut page.svg,
            curve.re,
            &mirrored,
            Stroke::solid(curve.role.pale(), 1.2),
        );
        frame.line(
            &mut page.svg,
            curve.re,
            curve.im,
            Stroke::solid(curve.role.color(), 1.8),
        );
        page.svg.end();
    }
    if let Some(at) = frame.at(-1.0, 0.0) {
        page.svg.path(
            &page::cross(at, 5.0),
            Stroke::solid(LineRole::Residual.color(), 2.2),
        );
    }
    page.svg.end();
    frame.border(&mut page.svg);
    frame.y_labels(&mut page.svg);
    frame.x_labels(&mut page.svg);
    let quantity = |name| Quantity { name, unit: "" };
    frame.y_caption(
        &mut page.svg,
        style::PAGE_MARGIN,
        quantity("imaginary part"),
    );
    frame.x_caption(&mut page.svg, quantity("real part"));
    page.y = frame.bottom() + 38.0;
    Ok(page.finish())
}

fn circle(page: &mut Page, frame: &Frame, middle: f64, radius: f64, stroke: Stroke) {
    let mut path = Path::default();
    for corner in 0..=CORNERS {
        let turn = std::f64::consts::TAU * corner as f64 / CORNERS as f64;
        let Some((x, y)) = frame.at(middle + radius * turn.cos(), radius * turn.sin()) else {
            return;
        };
        if corner == 0 {
            path.move_to(x, y);
        } else {
            path.line_to(x, y);
        }
    }
    page.svg.path(&path, stroke);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_point_and_both_halves_are_there() {
        let curve = NyquistCurve {
            name: "loop <1>",
            role: LineRole::Model,
            re: &[-3.0, -1.0, -0.2],
            im: &[0.1, 0.8, 0.1],
            modulus_margin: 0.6,
        };
        let figure = Nyquist {
            title: "Nyquist",
            curves: &[curve],
            ..Default::default()
        };
        let text = nyquist(&figure).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        let of_loop = document
            .descendants()
            .find(|node| node.attribute("data-series") == Some("loop <1>"));
        let paths = of_loop
            .unwrap()
            .children()
            .filter(|node| node.has_tag_name("path"));
        assert_eq!(paths.count(), 2);
        let short = NyquistCurve {
            im: &[0.1],
            ..curve
        };
        assert!(
            nyquist(&Nyquist {
                curves: &[short],
                ..figure
            })
            .is_err()
        );
    }
}
