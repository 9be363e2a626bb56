//! A vector sensor before and after calibration: after, its readings lie on a
//! sphere around zero.

use crate::annotation::Quantity;
use crate::axis::{Axis, extent};
use crate::frame::{self, Frame};
use crate::page::{self, Key, Mark, Page};
use crate::style::{self, LineRole};
use crate::svg::{Path, Stroke};

/// Readings of a three-axis sensor.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sphere<'a> {
    /// The title: a sentence that says what the figure shows.
    pub title: &'a str,
    /// Details, written below the title; may be empty.
    pub subtitle: &'a str,
    /// Readings before the calibration.
    pub before: &'a [[f64; 3]],
    /// Unit before, such as "counts".
    pub before_unit: &'a str,
    /// Readings after the calibration.
    pub after: &'a [[f64; 3]],
    /// Unit after, such as "µT"; empty for a pure number.
    pub after_unit: &'a str,
    /// Radius of the sphere on which the calibrated readings should lie.
    pub radius: f64,
}

/// Draws two projections (x–y and x–z) before, on the left, and after, on the
/// right, with the circle on whose disc the calibrated readings should lie.
pub fn sphere(figure: &Sphere) -> String {
    let mut page = Page::new(figure.title, figure.subtitle);
    let mut keys = vec![
        Key::new(
            Mark::Dot {
                color: LineRole::Measurement.color(),
            },
            "before calibration",
        ),
        Key::new(
            Mark::Dot {
                color: LineRole::Model.color(),
            },
            "after calibration",
        ),
    ];
    if figure.radius > 0.0 {
        let color = style::TEXT;
        keys.push(Key::new(
            Mark::Line { color, width: 1.6 },
            "sphere to be reached",
        ));
    }
    page.legend(&keys);
    let full = style::PAGE_WIDTH - 2.0 * style::PAGE_MARGIN;
    let width = (full - 24.0) / 2.0;
    for (vertical, name) in [(1, "y"), (2, "z")] {
        let top = page.y + frame::CAPTION;
        let mut bottom = top;
        for after in [false, true] {
            let left = style::PAGE_MARGIN + if after { width + 24.0 } else { 0.0 };
            bottom = panel(&mut page, figure, after, (vertical, name), left, top, width);
        }
        page.y = bottom + 38.0;
    }
    page.finish()
}

fn panel(
    page: &mut Page,
    figure: &Sphere,
    after: bool,
    (vertical, vertical_name): (usize, &str),
    left: f64,
    top: f64,
    width: f64,
) -> f64 {
    let (points, unit, radius, role) = if after {
        (
            figure.after,
            figure.after_unit,
            figure.radius,
            LineRole::Model,
        )
    } else {
        (
            figure.before,
            figure.before_unit,
            0.0,
            LineRole::Measurement,
        )
    };
    let gutter = 56.0;
    let size = width - gutter - 40.0;
    // One scale for both axes of a panel, and zero always in sight.
    let reach = if radius > 0.0 { radius } else { 0.0 };
    let range = |axis: usize| {
        extent(points.iter().map(|p| p[axis]).chain([-reach, reach])).unwrap_or((-1.0, 1.0))
    };
    let (x, y) = (range(0), range(vertical));
    let half = ((x.1 - x.0).max(y.1 - y.0) / 2.0).max(1e-12) * 1.06;
    let axis = |(lo, hi): (f64, f64), ticks| {
        let middle = (lo + hi) / 2.0;
        Axis::linear(Some((middle - half, middle + half)), 0.0, ticks)
    };
    let frame = Frame {
        left: left + gutter,
        top,
        width: size,
        height: size,
        x: axis(x, frame::x_ticks(size)),
        y: axis(y, frame::y_ticks(size)),
    };
    frame.grid(&mut page.svg, true);
    frame.zero_line(&mut page.svg);
    if let Some(x) = frame
        .at_x(0.0)
        .filter(|x| (frame.left..frame.right()).contains(x))
    {
        let stroke = Stroke::solid("#B5B5B5", 1.0);
        page.svg.line((x, frame.top), (x, frame.bottom()), stroke);
    }
    let name = if after { "after" } else { "before" };
    page.svg.begin_series(role.class(), name);
    let projected = points.iter().map(|p| (p[0], p[vertical]));
    frame.dots(&mut page.svg, projected, 2.2, role.color());
    page.svg.end();
    if radius > 0.0 {
        let mut path = Path::default();
        for i in 0..120 {
            let angle = f64::from(i) / 120.0 * std::f64::consts::TAU;
            if let Some((x, y)) = frame.at(radius * angle.cos(), radius * angle.sin()) {
                if i == 0 {
                    path.move_to(x, y);
                } else {
                    path.line_to(x, y);
                }
            }
        }
        path.close();
        page.svg.path(&path, Stroke::solid(style::TEXT, 1.6));
    }
    frame.border(&mut page.svg);
    frame.y_labels(&mut page.svg);
    frame.x_labels(&mut page.svg);
    let quantity = |name| Quantity { name, unit };
    let taken = frame.y_caption(&mut page.svg, left, quantity(vertical_name));
    let room = frame.right() - left - taken - 12.0;
    page::right_note(
        &mut page.svg,
        frame.right(),
        top - frame::CAPTION_GAP,
        room,
        name,
    );
    frame.x_caption(&mut page.svg, quantity("x"));
    frame.bottom()
}
