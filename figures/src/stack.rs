//! Panels on top of each other that share one horizontal axis: the layout
//! behind overlays and generic series.

use crate::axis::{Axis, extent};
use crate::frame::{self, Frame};
use crate::page::{self, Key, Mark, Page};
use crate::style::{self, Role};
use crate::svg::{Stroke, Text};
use crate::text;
use crate::{Limit, Marker, Quantity, Region};
use std::borrow::Cow;

/// One named line.
#[derive(Debug, Clone)]
pub(crate) struct Trace<'a> {
    pub name: &'a str,
    pub role: Role,
    pub x: &'a [f64],
    pub y: Cow<'a, [f64]>,
}

/// One panel.
#[derive(Debug, Clone)]
pub(crate) struct Row<'a> {
    pub quantity: Quantity<'a>,
    pub note: Cow<'a, str>,
    pub height: f64,
    pub traces: Vec<Trace<'a>>,
    /// Half height and name of a band around zero.
    pub band: Option<(f64, &'a str)>,
    pub limits: &'a [Limit<'a>],
}

/// All panels of a figure.
#[derive(Debug, Clone)]
pub(crate) struct Stack<'a> {
    pub x: Quantity<'a>,
    pub rows: Vec<Row<'a>>,
    pub regions: &'a [Region<'a>],
    pub markers: &'a [Marker<'a>],
    /// A part of the axis that is drawn a second time, larger, on the right.
    pub zoom: Option<(f64, f64)>,
}

const LANE: f64 = 14.0;
const LANES: usize = 3;
/// Room above a panel for its caption.
const CAPTION: f64 = 24.0;

/// Draws the legend and the panels.
pub(crate) fn draw(page: &mut Page, stack: &Stack) {
    page.legend(&keys(stack));
    let whole = extent(
        stack
            .rows
            .iter()
            .flat_map(|row| &row.traces)
            .flat_map(|trace| trace.x.iter().copied()),
    );
    let top = page.y;
    let full = style::PAGE_WIDTH - 2.0 * style::PAGE_MARGIN;
    let Some(zoom) = stack.zoom.filter(|z| z.0 < z.1) else {
        page.y = column(page, stack, whole, style::PAGE_MARGIN, full, top, true);
        return;
    };
    let first = full * 0.58;
    let below = column(page, stack, whole, style::PAGE_MARGIN, first, top, true);
    let left = style::PAGE_MARGIN + first + 20.0;
    let right = column(
        page,
        stack,
        Some(zoom),
        left,
        full - first - 20.0,
        top,
        false,
    );
    page.y = below.max(right);
    page.note("Right: a part of the same axis, enlarged.");
}

fn keys(stack: &Stack) -> Vec<Key> {
    let mut keys = Vec::new();
    for trace in stack.rows.iter().flat_map(|row| &row.traces) {
        keys.push(Key::line(trace.role, trace.name));
    }
    for (_, name) in stack.rows.iter().filter_map(|row| row.band) {
        keys.push(Key::new(Mark::Patch { color: style::BAND }, name));
    }
    if stack.rows.iter().any(|row| !row.limits.is_empty()) {
        let color = style::LIMIT;
        keys.push(Key::new(Mark::Dashed { color }, "limit"));
    }
    if !stack.regions.is_empty() {
        let color = style::REGION;
        keys.push(Key::new(
            Mark::Patch { color },
            "where the error is largest",
        ));
    }
    keys
}

/// The vertical axis of a row over what lies within `window`, and the limits
/// that would flatten the data if the axis reached them.
fn y_axis<'a>(row: &'a Row, window: Option<(f64, f64)>) -> (Axis, Vec<&'a Limit<'a>>) {
    let (from, until) = window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let values = row.traces.iter().flat_map(|trace| {
        let points = trace.x.iter().zip(trace.y.iter());
        points
            .filter(|(x, _)| (from..=until).contains(*x))
            .map(|(_, y)| *y)
    });
    let band = row.band.map_or(f64::NAN, |(half, _)| half);
    let mut range = extent(values.chain([-band, band]));
    let mut outside = Vec::new();
    for limit in row.limits.iter().filter(|limit| limit.value.is_finite()) {
        let (lo, hi) = range.unwrap_or((limit.value, limit.value));
        let (new_lo, new_hi) = (lo.min(limit.value), hi.max(limit.value));
        if new_hi - new_lo <= 4.0 * (hi - lo) || hi == lo {
            range = Some((new_lo, new_hi));
        } else {
            outside.push(limit);
        }
    }
    let axis = Axis::linear(range, 0.05, frame::y_ticks(row.height));
    (axis, outside)
}

/// Draws one column of panels; returns the height at which it ends.
fn column(
    page: &mut Page,
    stack: &Stack,
    window: Option<(f64, f64)>,
    left: f64,
    width: f64,
    top: f64,
    with_labels: bool,
) -> f64 {
    let axes: Vec<_> = stack.rows.iter().map(|row| y_axis(row, window)).collect();
    let gutter = axes
        .iter()
        .map(|(axis, _)| frame::gutter(axis))
        .fold(0.0, f64::max);
    let limit_labels = stack.rows.iter().flat_map(|row| row.limits);
    let right_gutter = limit_labels
        .map(|limit| text::width(limit.name, style::NOTE_SIZE) + 6.0)
        .fold(8.0, f64::max)
        .min(130.0);
    let plot_width = width - gutter - right_gutter;
    let x_axis = Axis::linear(window, 0.005, frame::x_ticks(plot_width));

    let mut y = top;
    let lane_rows = lane_rows(stack);
    let lanes_top = y;
    y += lane_rows as f64 * LANE;
    let mut frames = Vec::new();
    for (row, (axis, _)) in stack.rows.iter().zip(&axes) {
        y += CAPTION;
        frames.push(Frame {
            left: left + gutter,
            top: y,
            width: plot_width,
            height: row.height,
            x: x_axis.clone(),
            y: axis.clone(),
        });
        y += row.height + 6.0;
    }
    for ((row, frame), (_, outside)) in stack.rows.iter().zip(&frames).zip(&axes) {
        panel(page, stack, row, frame);
        let taken = frame.y_caption(&mut page.svg, left, row.quantity);
        let mut note = row.note.to_string();
        for limit in outside {
            let gap = if note.is_empty() { "" } else { " · " };
            note.push_str(&format!("{gap}{} lies outside", limit.name));
        }
        if with_labels {
            let room = frame.right() - left - taken - 16.0;
            page::right_note(&mut page.svg, frame.right(), frame.top - 7.0, room, &note);
        }
    }
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
        return y;
    };
    if lane_rows > 0 {
        events(page, stack, first, last, lanes_top, lane_rows, with_labels);
    }
    last.x_labels(&mut page.svg);
    last.x_caption(&mut page.svg, stack.x);
    last.bottom() + 38.0
}

fn panel(page: &mut Page, stack: &Stack, row: &Row, frame: &Frame) {
    for region in stack.regions {
        frame.stripe(&mut page.svg, region.from, region.until, style::REGION);
    }
    if let Some((half, _)) = row.band {
        frame.band(&mut page.svg, -half, half, style::BAND);
    }
    frame.grid(&mut page.svg, true);
    frame.zero_line(&mut page.svg);
    for limit in row.limits {
        let Some(y) = frame.at_y(limit.value) else {
            continue;
        };
        if y < frame.top || y > frame.bottom() {
            continue;
        }
        let stroke = Stroke::dashed(style::LIMIT, 1.2);
        page.svg.line((frame.left, y), (frame.right(), y), stroke);
        let at = Text::new(
            frame.right() + 4.0,
            y + 3.6,
            style::NOTE_SIZE,
            style::TEXT_MUTED,
        );
        let name = text::shorten(limit.name, style::NOTE_SIZE, 126.0);
        page.svg.text(at, &name);
    }
    frame.begin_clip(&mut page.svg);
    for trace in &row.traces {
        series(page, frame, trace);
    }
    page.svg.end();
    frame.border(&mut page.svg);
    frame.y_labels(&mut page.svg);
}

fn series(page: &mut Page, frame: &Frame, trace: &Trace) {
    page.svg.begin_series(trace.role.class(), trace.name);
    let shown = trace.x.iter().zip(trace.y.iter());
    let shown = shown
        .filter(|(x, y)| y.is_finite() && (frame.x.lo..=frame.x.hi).contains(*x))
        .count();
    // Few measurements are points, not a line that nobody measured.
    if trace.role == Role::Measurement && (shown as f64) < frame.width / 8.0 {
        let points = trace.x.iter().copied().zip(trace.y.iter().copied());
        frame.dots(&mut page.svg, points, 4.0, trace.role.color());
    } else {
        let stroke = Stroke::solid(trace.role.color(), trace.role.line_width());
        if frame.line(&mut page.svg, trace.x, &trace.y, stroke) {
            page.note(
                "Long series are drawn with the first, lowest, highest and last value of each \
                 pixel column; no peak is lost.",
            );
        }
    }
    page.svg.end();
}

/// Rows of labels that regions and markers need above the panels.
fn lane_rows(stack: &Stack) -> usize {
    let labels = stack.regions.iter().map(|region| region.label);
    let labels = labels.chain(stack.markers.iter().map(|marker| marker.label));
    let count = labels.filter(|label| !label.is_empty()).count();
    match count {
        0..=1 => count,
        2..=4 => 2,
        _ => LANES,
    }
}

/// Labels of regions and markers above the first panel, and the lines of the
/// markers through all panels.
fn events(
    page: &mut Page,
    stack: &Stack,
    first: &Frame,
    last: &Frame,
    top: f64,
    rows: usize,
    with_labels: bool,
) {
    let on_axis = |value: f64| {
        let x = first.at_x(value)?;
        (first.left - 0.5..=first.right() + 0.5)
            .contains(&x)
            .then_some(x)
    };
    let mut labels: Vec<(f64, &str)> = Vec::new();
    for region in stack.regions {
        let from = region.from.max(first.x.lo);
        let until = region.until.min(first.x.hi);
        if from <= until {
            if let Some(x) = on_axis((from + until) / 2.0) {
                labels.push((x, region.label));
            }
        }
    }
    let stroke = Stroke {
        color: style::TEXT_MUTED,
        width: 1.0,
        dash: "2 3",
    };
    for marker in stack.markers {
        if let Some(x) = on_axis(marker.at) {
            page.svg
                .line((x, first.top - 4.0), (x, last.bottom()), stroke);
            labels.push((x, marker.label));
        }
    }
    if !with_labels {
        return;
    }
    labels.retain(|(_, label)| !label.is_empty());
    let widest = (first.width / 2.0).max(60.0);
    let texts: Vec<String> = labels
        .iter()
        .map(|(_, label)| text::shorten(label, style::NOTE_SIZE, widest))
        .collect();
    let sizes: Vec<(f64, f64)> = labels
        .iter()
        .zip(&texts)
        .map(|((x, _), text)| (*x, text::width(text, style::NOTE_SIZE)))
        .collect();
    let places = page::lanes(&sizes, first.left, first.right(), rows);
    let mut hidden = 0;
    for (place, text) in places.iter().zip(&texts) {
        let Some((row, x)) = place else {
            hidden += 1;
            continue;
        };
        // The first lane is the lowest, next to the panel's caption.
        let y = top + (rows - row) as f64 * LANE - 2.0;
        let at = Text::new(*x, y, style::NOTE_SIZE, style::TEXT_MUTED);
        page.svg.text(at, text);
    }
    if hidden > 0 {
        page.note(format!(
            "{hidden} of {} labels above the panels are left out for lack of room; their marks are drawn.",
            texts.len()
        ));
    }
}
