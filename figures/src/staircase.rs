//! The error of each experiment after each effect that was added.

use crate::annotation::Quantity;
use crate::axis::{Axis, extent, three_digits};
use crate::error::{FigureError, check_length};
use crate::frame::{self, Frame};
use crate::page::{self, Key, Mark, Page};
use crate::style::{self, LineRole};
use crate::svg::{Anchor, Path, Stroke, Text};
use crate::text;

/// Errors over the steps of a diagnosis.
#[derive(Debug, Clone, Copy, Default)]
pub struct Staircase<'a> {
    /// The title: a sentence that says what the figure shows.
    pub title: &'a str,
    /// Details, written below the title; may be empty.
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
    /// Root mean square error divided by the standard deviation of the sensor's
    /// noise, one value per step; NaN where there is none.
    pub rmse_over_floor: &'a [f64],
}

const FIT: LineRole = LineRole::Model;
const HELD_OUT: LineRole = LineRole::Other(0);
const LABEL_WIDTH: f64 = 260.0;
/// Up to this number of lines, every line has its name.
const ALL_NAMED: usize = 14;
/// Of more lines, only some have their names: the first number of lines with the largest errors in the last step, and
/// lines with the largest error in any step until the second number is reached.
const NAMED: (usize, usize) = (4, 8);
const BAND: &str = "#DCE3EA";

/// Draws error over floor, on a logarithmic axis, against the steps. The name of each experiment stands at that end
/// of its line at which the errors are larger, with the first and the last error. Of many experiments the
/// worst are drawn by name, the others as the band in which they lie.
///
/// # Errors
/// [`FigureError::Length`] if a trace has not one value for each step.
pub fn staircase(figure: &Staircase) -> Result<String, FigureError> {
    for trace in figure.traces {
        let what = || format!("the trace \"{}\"", trace.name);
        let found = trace.rmse_over_floor.len();
        check_length(figure.title, what, figure.steps.len(), found)?;
    }
    let (named, others) = worst(figure.traces);
    let mut page = Page::new(figure.title, figure.subtitle);
    let mut keys = vec![
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
    ];
    if !others.is_empty() {
        let what = format!("{} more, all in this band", others.len());
        keys.push(Key::new(Mark::Patch { color: BAND }, what));
    }
    page.legend(&keys);
    let height = (named.len() as f64 * 15.0).clamp(280.0, 720.0);
    let values = figure.traces.iter().flat_map(|t| t.rmse_over_floor);
    let range = extent(values.copied().filter(|v| *v > 0.0).chain([1.0]));
    let y = Axis::log(range, frame::y_ticks(height));
    let gutter = frame::gutter(&y);
    let bad_end = bad_end(figure.traces);
    let frame = Frame {
        left: match bad_end {
            // The ticks then stand at the right.
            End::First => style::PAGE_MARGIN + LABEL_WIDTH,
            End::Last => style::PAGE_MARGIN + gutter,
        },
        top: page.y + frame::CAPTION,
        width: style::PAGE_WIDTH - 2.0 * style::PAGE_MARGIN - gutter - LABEL_WIDTH,
        height,
        x: Axis::names(figure.steps.len()),
        y,
    };
    if let Some(path) = band(&frame, &others, figure.steps.len()) {
        page.svg.begin_series("others", "all other experiments");
        page.svg.area(&path, BAND);
        page.svg.end();
    }
    frame.grid(&mut page.svg, false);
    let quantity = Quantity {
        name: "RMSE / sensor noise",
        unit: "",
    };
    let caption_left = match bad_end {
        End::First => frame.left,
        End::Last => style::PAGE_MARGIN,
    };
    frame.y_caption(&mut page.svg, caption_left, quantity);
    if let Some(y) = frame.at_y(1.0) {
        let stroke = Stroke::dashed(style::LIMIT, 1.4);
        page.svg.line((frame.left, y), (frame.right(), y), stroke);
    }
    for trace in &named {
        draw_trace(&mut page, &frame, trace);
    }
    frame.border(&mut page.svg);
    match bad_end {
        End::First => tick_labels_at_right(&mut page, &frame),
        End::Last => frame.y_labels(&mut page.svg),
    }
    end_labels(&mut page, &frame, &named, bad_end);
    let lines = step_labels(&mut page, &frame, figure.steps);
    page.y = frame.bottom() + 10.0 + lines as f64 * 14.0;
    Ok(page.finish())
}

/// One end of the lines: the first or the last step.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    First,
    Last,
}

/// The end at which the errors are larger; there the lines are apart.
fn bad_end(traces: &[StaircaseTrace]) -> End {
    let sum = |end: End| -> f64 {
        let ends = traces.iter().filter_map(|trace| at_end(trace, end));
        ends.map(|(_, value)| value.ln()).sum()
    };
    if sum(End::First) > sum(End::Last) {
        End::First
    } else {
        End::Last
    }
}

/// Step and value of the outermost point of a trace that can be drawn, at this end.
fn at_end(trace: &StaircaseTrace, end: End) -> Option<(usize, f64)> {
    let mut drawn = trace
        .rmse_over_floor
        .iter()
        .copied()
        .enumerate()
        .filter(|(_, value)| value.is_finite() && *value > 0.0);
    match end {
        End::First => drawn.next(),
        End::Last => drawn.next_back(),
    }
}

/// The traces that are named, in their order, and the others.
fn worst<'t>(
    traces: &'t [StaircaseTrace<'t>],
) -> (Vec<&'t StaircaseTrace<'t>>, Vec<&'t StaircaseTrace<'t>>) {
    if traces.len() <= ALL_NAMED {
        return (traces.iter().collect(), vec![]);
    }
    let last = |trace: &StaircaseTrace| at_end(trace, End::Last).map_or(0.0, |(_, value)| value);
    let largest = |trace: &StaircaseTrace| {
        let finite = trace
            .rmse_over_floor
            .iter()
            .copied()
            .filter(|v| v.is_finite());
        finite.fold(0.0, f64::max)
    };
    let by = |size: &dyn Fn(&StaircaseTrace) -> f64| -> Vec<usize> {
        let mut order: Vec<usize> = (0..traces.len()).collect();
        order.sort_by(|a, b| size(&traces[*b]).total_cmp(&size(&traces[*a])));
        order
    };
    let mut named: Vec<usize> = by(&last).into_iter().take(NAMED.0).collect();
    for index in by(&largest) {
        if named.len() < NAMED.1 && !named.contains(&index) {
            named.push(index);
        }
    }
    let of = |is_named: bool| {
        let indices = (0..traces.len()).filter(|index| named.contains(index) == is_named);
        indices.map(|index| &traces[index]).collect()
    };
    (of(true), of(false))
}

/// The band in which traces lie at every step.
fn band(frame: &Frame, traces: &[&StaircaseTrace], steps: usize) -> Option<Path> {
    let ends: Vec<(f64, (f64, f64))> = (0..steps)
        .filter_map(|step| {
            let values = traces.iter().map(|trace| trace.rmse_over_floor[step]);
            let range = extent(values.filter(|value| *value > 0.0))?;
            Some((step as f64, range))
        })
        .collect();
    let upper = ends.iter().filter_map(|(x, range)| frame.at(*x, range.1));
    let lower = ends
        .iter()
        .rev()
        .filter_map(|(x, range)| frame.at(*x, range.0));
    let mut corners = upper.chain(lower);
    let mut path = Path::default();
    let (x, y) = corners.next()?;
    path.move_to(x, y);
    for (x, y) in corners {
        path.line_to(x, y);
    }
    path.close();
    Some(path)
}

fn tick_labels_at_right(page: &mut Page, frame: &Frame) {
    for (tick, label) in frame.y.ticks.iter().zip(&frame.y.labels) {
        if let Some(y) = frame.at_y(*tick) {
            let at = Text::new(frame.right() + 6.0, y + 3.8, style::TICK_SIZE, style::TEXT);
            page.svg.text(at, label);
        }
    }
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

/// Names beside one end of the lines, moved apart, each joined to its line, with the first and the last error.
fn end_labels(page: &mut Page, frame: &Frame, traces: &[&StaircaseTrace], side: End) {
    let ends: Vec<(&StaircaseTrace, (f64, f64), String)> = traces
        .iter()
        .filter_map(|trace| {
            let (step, value) = at_end(trace, side)?;
            let at = frame.at(step as f64, value)?;
            let times = |value: f64| format!("{}×", three_digits(value));
            let (first, last) = (at_end(trace, End::First)?, at_end(trace, End::Last)?);
            let ratio = if first.0 == last.0 {
                times(last.1)
            } else {
                format!("{} → {}", times(first.1), times(last.1))
            };
            Some((*trace, at, ratio))
        })
        .collect();
    let wanted: Vec<f64> = ends.iter().map(|(_, at, _)| at.1).collect();
    let placed = page::spread(&wanted, 13.5, frame.top, frame.bottom());
    // Names at the outer edge of the page, numbers beside the lines.
    let (left, right) = match side {
        End::First => (style::PAGE_MARGIN, frame.left - 10.0),
        End::Last => (frame.right() + 10.0, style::PAGE_WIDTH - style::PAGE_MARGIN),
    };
    let rooms: Vec<f64> = ends
        .iter()
        .map(|(_, _, ratio)| right - left - text::width(ratio, style::NOTE_SIZE) - 8.0)
        .collect();
    let names: Vec<&str> = ends.iter().map(|(trace, _, _)| trace.name).collect();
    let names = text::shorten_apart(&names, style::NOTE_SIZE, &rooms);
    for (((trace, end, ratio), y), name) in ends.iter().zip(placed).zip(&names) {
        let color = role(trace).color();
        let stroke = Stroke::solid("#C4C4C4", 0.8);
        let (from, to) = match side {
            End::First => (end.0 - 5.0, right + 3.0),
            End::Last => (end.0 + 5.0, left - 3.0),
        };
        page.svg.line((from, end.1), (to, y), stroke);
        page.svg
            .text(Text::new(left, y + 3.6, style::NOTE_SIZE, color), name);
        let at = Text::new(right, y + 3.6, style::NOTE_SIZE, color).anchor(Anchor::End);
        page.svg.text(at, ratio);
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
