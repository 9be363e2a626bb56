//! A torque over one coordinate of the motion, with its band.

use crate::annotation::Quantity;
use crate::axis::{Axis, extent};
use crate::frame::{self, Frame};
use crate::page::{Key, Mark, Page};
use crate::style::{self, LineRole};
use crate::svg::{Path, Stroke};

/// A torque that was found without a formula.
#[derive(Debug, Clone, Copy, Default)]
pub struct TorqueCurve<'a> {
    /// The title: a sentence that says what the figure shows.
    pub title: &'a str,
    /// Details, written below the title; may be empty.
    pub subtitle: &'a str,
    /// The horizontal axis, such as the body's angle.
    pub coordinate: Quantity<'a>,
    /// The torque and its unit.
    pub torque: Quantity<'a>,
    /// The curve, by increasing coordinate.
    pub points: &'a [TorqueCurvePoint],
}

/// One point of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TorqueCurvePoint {
    /// The coordinate.
    pub at: f64,
    /// The torque.
    pub value: f64,
    /// Its standard error; NaN where it is unknown.
    pub std: f64,
}

const HEIGHT: f64 = 320.0;

/// Draws the curve within two standard errors.
pub fn torque_curve(figure: &TorqueCurve) -> String {
    let mut page = Page::new(figure.title, figure.subtitle);
    let color = LineRole::Residual.color();
    page.legend(&[
        Key::line(LineRole::Residual, figure.torque.name),
        Key::new(
            Mark::Patch {
                color: LineRole::Residual.pale(),
            },
            "±2 standard errors",
        ),
    ]);
    let band = |point: &TorqueCurvePoint| {
        let half = if point.std.is_finite() {
            2.0 * point.std
        } else {
            0.0
        };
        (point.value - half, point.value + half)
    };
    let values = figure.points.iter().map(|point| point.value);
    let core = extent(values.chain([0.0]));
    let ends = extent(figure.points.iter().flat_map(|point| {
        let (low, high) = band(point);
        [low, high]
    }));
    // A band that is wide at the ends must not flatten the curve.
    let range = match (core, ends) {
        (Some((low, high)), Some((band_low, band_high))) => {
            let room = 0.5 * (high - low);
            Some((
                low.min(band_low.max(low - room)),
                high.max(band_high.min(high + room)),
            ))
        }
        (core, _) => core,
    };
    let y = Axis::linear(range, 0.06, frame::y_ticks(HEIGHT));
    let gutter = frame::gutter(&y);
    let width = style::PAGE_WIDTH - 2.0 * style::PAGE_MARGIN - gutter - 8.0;
    let frame = Frame {
        left: style::PAGE_MARGIN + gutter,
        top: page.y + frame::CAPTION,
        width,
        height: HEIGHT,
        x: Axis::linear(
            extent(figure.points.iter().map(|point| point.at)),
            0.02,
            frame::x_ticks(width),
        ),
        y,
    };
    frame.begin_clip(&mut page.svg);
    let mut path = Path::default();
    let upper = figure.points.iter().map(|point| (point.at, band(point).1));
    let lower = figure
        .points
        .iter()
        .rev()
        .map(|point| (point.at, band(point).0));
    let mut corners = upper.chain(lower).filter_map(|(x, y)| frame.at(x, y));
    if let Some((x, y)) = corners.next() {
        path.move_to(x, y);
        for (x, y) in corners {
            path.line_to(x, y);
        }
        path.close();
        page.svg.area(&path, LineRole::Residual.pale());
    }
    page.svg.end();
    frame.grid(&mut page.svg, true);
    frame.zero_line(&mut page.svg);
    frame.begin_clip(&mut page.svg);
    page.svg
        .begin_series(LineRole::Residual.class(), figure.torque.name);
    let at: Vec<f64> = figure.points.iter().map(|point| point.at).collect();
    let values: Vec<f64> = figure.points.iter().map(|point| point.value).collect();
    frame.line(&mut page.svg, &at, &values, Stroke::solid(color, 1.8));
    page.svg.end();
    page.svg.end();
    frame.border(&mut page.svg);
    frame.y_labels(&mut page.svg);
    frame.y_caption(&mut page.svg, style::PAGE_MARGIN, figure.torque);
    frame.x_labels(&mut page.svg);
    frame.x_caption(&mut page.svg, figure.coordinate);
    page.y = frame.bottom() + 38.0;
    page.finish()
}
