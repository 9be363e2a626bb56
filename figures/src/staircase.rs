//! The error of each experiment after each effect that was added.

use crate::annotation::Quantity;
use crate::axis::{Axis, extent, three_digits};
use crate::error::{FigureError, check_length};
use crate::frame::{self, Frame};
use crate::page::{self, Key, Mark, Page};
use crate::style::{self, LineRole};
use crate::svg::{Anchor, Stroke, Text};
use crate::text;

/// Errors over the steps of a diagnosis.
#[derive(Debug, Clone, Copy, Default)]
pub struct Staircase<'a> {
    /// What is seen, as a sentence.
    pub title: &'a str,
    /// More about it; may be empty.
    pub subtitle: &'a str,
    /// Names of the steps: "base model", "+ body-coulomb-friction", …
    pub steps: &'a [&'a str],
    /// One line for each experiment and channel.
    pub traces: &'a [StaircaseTrace<'a>],
}

/// The error of one experiment.
#[derive(Debug, Clone, Copy, Default)]
pub struct StaircaseTrace<'a> {
    /// Name of experiment and channel.
    pub name: &'a str,
    /// Whether the fit did not see this experiment.
    pub held_out: bool,
    /// Root mean square error over the standard deviation of the sensor's
    /// noise, one value per step; NaN where there is none.
    pub rmse_over_floor: &'a [f64],
}

const FIT: LineRole = LineRole::Model;
const HELD_OUT: LineRole = LineRole::Other(0);
const LABEL_WIDTH: f64 = 260.0;

/// Draws error over floor, on a logarithmic axis, against the steps; the name
/// and the last error of each experiment stand at the right end of its line.
///
/// # Errors
/// [`FigureError::Length`] if a trace has not one value for each step.
pub fn staircase(figure: &Staircase) -> Result<String, FigureError> {
    for trace in figure.traces {
        let what = || format!("the trace \"{}\"", trace.name);
        let found = trace.rmse_over_floor.len();
        check_length(figure.title, what, figure.steps.len(), found)?;
    }
    let mut page = Page::new(figure.title, figure.subtitle);
    page.legend(&[
        Key::new(
            Mark::Dot { color: FIT.color() },
            "experiment in the fit (filled, solid)",
        ),
        Key::new(
            Mark::Ring {
                color: HELD_OUT.color(),
            },
            "experiment held out (open, dashed)",
        ),
        Key::new(
            Mark::Dashed {
                color: style::LIMIT,
            },
            "floor: the sensor's noise",
        ),
    ]);
    let height = (figure.traces.len() as f64 * 15.0).clamp(280.0, 720.0);
    let values = figure.traces.iter().flat_map(|t| t.rmse_over_floor);
    let range = extent(values.copied().filter(|v| *v > 0.0).chain([1.0]));
    let y = Axis::log(range, frame::y_ticks(height));
    let gutter = frame::gutter(&y);
    let frame = Frame {
        left: style::PAGE_MARGIN + gutter,
        top: page.y + frame::CAPTION,
        width: style::PAGE_WIDTH - 2.0 * style::PAGE_MARGIN - gutter - LABEL_WIDTH,
        height,
        x: Axis::names(figure.steps.len()),
        y,
    };
    frame.grid(&mut page.svg, false);
    let quantity = Quantity {
        name: "RMSE / sensor noise",
        unit: "",
    };
    frame.y_caption(&mut page.svg, style::PAGE_MARGIN, quantity);
    if let Some(y) = frame.at_y(1.0) {
        let stroke = Stroke::dashed(style::LIMIT, 1.4);
        page.svg.line((frame.left, y), (frame.right(), y), stroke);
    }
    for trace in figure.traces {
        draw_trace(&mut page, &frame, trace);
    }
    frame.border(&mut page.svg);
    frame.y_labels(&mut page.svg);
    end_labels(&mut page, &frame, figure.traces);
    let lines = step_labels(&mut page, &frame, figure.steps);
    page.y = frame.bottom() + 10.0 + lines as f64 * 14.0;
    Ok(page.finish())
}

fn role(trace: &StaircaseTrace) -> LineRole {
    if trace.held_out { HELD_OUT } else { FIT }
}

fn draw_trace(page: &mut Page, frame: &Frame, trace: &StaircaseTrace) {
    let color = role(trace).color();
    let steps: Vec<f64> = (0..trace.rmse_over_floor.len()).map(|i| i as f64).collect();
    page.svg
        .begin_series(if trace.held_out { "held-out" } else { "fit" }, trace.name);
    let stroke = if trace.held_out {
        Stroke::dashed(color, 1.3)
    } else {
        Stroke::solid(color, 1.3)
    };
    frame.line(&mut page.svg, &steps, trace.rmse_over_floor, stroke);
    for (step, value) in steps.iter().zip(trace.rmse_over_floor) {
        if let Some(at) = frame.at(*step, *value) {
            let fill = if trace.held_out { "#FFFFFF" } else { color };
            page.svg.circle(at, 3.4, fill, Stroke::solid(color, 1.5));
        }
    }
    page.svg.end();
}

/// Names at the right, moved apart, each joined to the end of its line.
fn end_labels(page: &mut Page, frame: &Frame, traces: &[StaircaseTrace]) {
    let ends: Vec<(&StaircaseTrace, (f64, f64), f64)> = traces
        .iter()
        .filter_map(|trace| {
            let mut values = trace.rmse_over_floor.iter().enumerate().rev();
            values.find_map(|(step, value)| Some((trace, frame.at(step as f64, *value)?, *value)))
        })
        .collect();
    let wanted: Vec<f64> = ends.iter().map(|(_, at, _)| at.1).collect();
    let placed = page::spread(&wanted, 13.5, frame.top, frame.bottom());
    let x = frame.right() + 10.0;
    for ((trace, end, value), y) in ends.iter().zip(placed) {
        let color = role(trace).color();
        let stroke = Stroke::solid("#C4C4C4", 0.8);
        page.svg.line((end.0 + 5.0, end.1), (x - 3.0, y), stroke);
        let ratio = format!("{}×", three_digits(*value));
        let room = LABEL_WIDTH - 14.0 - text::width(&ratio, style::NOTE_SIZE) - 8.0;
        let name = text::shorten_middle(trace.name, style::NOTE_SIZE, room);
        let at = Text::new(x, y + 3.6, style::NOTE_SIZE, color);
        page.svg.text(at, &name);
        let right = style::PAGE_WIDTH - style::PAGE_MARGIN;
        let at = Text::new(right, y + 3.6, style::NOTE_SIZE, color).anchor(Anchor::End);
        page.svg.text(at, &ratio);
    }
}

/// Names of the steps below the axis; returns the number of lines.
fn step_labels(page: &mut Page, frame: &Frame, steps: &[&str]) -> usize {
    let room = frame.width / steps.len().max(1) as f64 - 8.0;
    let mut most = 1;
    for (index, step) in steps.iter().enumerate() {
        let Some(x) = frame.at_x(index as f64) else {
            continue;
        };
        let lines = text::wrap(step, style::TICK_SIZE, room, 4);
        most = most.max(lines.len());
        for (line, content) in lines.iter().enumerate() {
            let y = frame.bottom() + 16.0 + 13.0 * line as f64;
            let at = Text::new(x, y, style::TICK_SIZE, style::TEXT);
            page.svg.text(at.anchor(Anchor::Middle), content);
        }
    }
    most
}
