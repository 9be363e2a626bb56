//! Panels on top of each other that share one horizontal axis: the layout
//! behind overlays and generic series.

use crate::annotation::{Limit, Marker, Quantity, Region};
use crate::axis::{Axis, extent};
use crate::frame::{self, Frame};
use crate::page::{self, Key, Mark, Page};
use crate::style::{self, LineRole};
use crate::svg::{Anchor, Stroke, Text};
use crate::text;
use std::borrow::Cow;

/// One named line.
#[derive(Debug, Clone)]
pub(crate) struct Trace<'a> {
    pub name: &'a str,
    pub role: LineRole,
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
    /// The meaning of the regions, for the legend.
    pub region_name: &'a str,
    pub markers: &'a [Marker<'a>],
    /// A part of the axis that is drawn a second time, larger, on the right.
    pub zoom: Option<(f64, f64)>,
}

const LANE: f64 = 14.0;
const LANES: usize = 3;

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
    page.note(
        "Right, enlarged: the part that the thick line at the foot of the left panels marks.",
    );
}

fn keys(stack: &Stack) -> Vec<Key> {
    let mut keys = Vec::new();
    for trace in stack.rows.iter().flat_map(|row| &row.traces) {
        keys.push(Key::line(trace.role, trace.name));
    }
    for (_, name) in stack.rows.iter().filter_map(|row| row.band) {
        let (fill, edge) = (style::BAND, style::BAND_EDGE);
        keys.push(Key::new(Mark::Band { fill, edge }, name));
    }
    if stack.rows.iter().any(|row| !row.limits.is_empty()) {
        let color = style::LIMIT;
        keys.push(Key::new(Mark::Dashed { color }, "limit"));
    }
    if !stack.regions.is_empty() {
        let color = style::REGION;
        keys.push(Key::new(Mark::Patch { color }, stack.region_name));
    }
    keys
}

/// The vertical axis of a row over the data within `window`, and the limits
/// that would flatten the data if the axis reached them.
fn y_axis<'a>(row: &'a Row, window: Option<(f64, f64)>) -> (Axis, Vec<&'a Limit<'a>>) {
    let whole = (f64::NEG_INFINITY, f64::INFINITY);
    let within = |(from, until): (f64, f64)| {
        let points = row.traces.iter().flat_map(|t| t.x.iter().zip(t.y.iter()));
        let inside = points.filter(move |(x, _)| (from..=until).contains(*x));
        extent(inside.map(|(_, y)| *y))
    };
    // A line may cross a window without a point in it.
    let data = within(window.unwrap_or(whole)).or_else(|| within(whole));
    let band = row.band.map_or(f64::NAN, |(half, _)| half);
    let ends = data.into_iter().flat_map(|(lo, hi)| [lo, hi]);
    let mut range = extent(ends.chain([-band, band]));
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
    is_whole: bool,
) -> f64 {
    let axes: Vec<_> = stack.rows.iter().map(|row| y_axis(row, window)).collect();
    let gutter = axes
        .iter()
        .map(|(axis, _)| frame::gutter(axis))
        .fold(0.0, f64::max);
    let plot_width = width - gutter - right_gutter(stack, &axes);
    let x_axis = Axis::linear(window, 0.005, frame::x_ticks(plot_width));

    let lane_rows = lane_rows(stack);
    let mut y = top;
    let mut frames = Vec::new();
    for (index, (row, (axis, _))) in stack.rows.iter().zip(&axes).enumerate() {
        y += frame::CAPTION;
        if index == 0 {
            y += lane_rows as f64 * LANE;
        }
        frames.push(Frame {
            left: left + gutter,
            top: y,
            width: plot_width,
            height: row.height,
            x: x_axis.clone(),
            y: axis.clone(),
        });
        y += row.height + 4.0;
    }
    for (index, ((row, frame), (_, outside))) in
        stack.rows.iter().zip(&frames).zip(&axes).enumerate()
    {
        panel(page, stack, row, frame);
        let lanes = if index == 0 { lane_rows as f64 } else { 0.0 };
        let baseline = frame.top - frame::CAPTION_GAP - lanes * LANE;
        let taken = frame.y_caption_at(&mut page.svg, left, baseline, row.quantity);
        let mut note = row.note.to_string();
        for limit in outside {
            let gap = if note.is_empty() { "" } else { " · " };
            note.push_str(&format!("{gap}{} lies outside", limit.name));
        }
        if is_whole {
            let room = frame.right() - left - taken - 16.0;
            page::right_note(&mut page.svg, frame.right(), baseline, room, &note);
        }
    }
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
        return y;
    };
    labels(page, stack, first, lane_rows, is_whole);
    if let (true, Some((from, until))) = (is_whole, stack.zoom) {
        let lo = from.max(last.x.lo);
        let hi = until.min(last.x.hi);
        if let (Some(a), Some(b)) = (last.at_x(lo), last.at_x(hi)) {
            let y = last.bottom() + 2.0;
            page.svg
                .line((a, y), (b, y), Stroke::solid(style::AXIS, 4.0));
        }
    }
    last.x_labels(&mut page.svg);
    last.x_caption(&mut page.svg, stack.x);
    last.bottom() + 38.0
}

/// Room at the right for the names of the limits that are drawn.
fn right_gutter(stack: &Stack, axes: &[(Axis, Vec<&Limit>)]) -> f64 {
    let drawn = stack
        .rows
        .iter()
        .zip(axes)
        .flat_map(|(row, (_, outside))| row.limits.iter().filter(|l| !outside.contains(l)));
    drawn
        .map(|limit| text::width(limit.name, style::NOTE_SIZE) + LIMIT_GAP + 2.0)
        .fold(8.0, f64::max)
        .min(130.0)
}

/// From the end of a limit's line to its name.
const LIMIT_GAP: f64 = 7.0;

fn panel(page: &mut Page, stack: &Stack, row: &Row, frame: &Frame) {
    for region in stack.regions {
        frame.stripe(&mut page.svg, region.from, region.until, style::REGION);
    }
    let is_empty = row.traces.iter().all(|trace| {
        let mut points = trace.x.iter().zip(trace.y.iter());
        !points.any(|(x, y)| frame.at(*x, *y).is_some())
    });
    if is_empty {
        let (x, y) = (
            frame.left + frame.width / 2.0,
            frame.top + frame.height / 2.0,
        );
        let at = Text::new(x, y + 4.0, style::LABEL_SIZE, style::TEXT_MUTED);
        page.svg.text(at.anchor(Anchor::Middle), "no data");
        frame.border(&mut page.svg);
        return;
    }
    if let Some((half, _)) = row.band {
        frame.band(&mut page.svg, -half, half, style::BAND);
    }
    frame.grid(&mut page.svg, true);
    frame.zero_line(&mut page.svg);
    for limit in row.limits {
        draw_limit(page, frame, limit);
    }
    frame.begin_clip(&mut page.svg);
    for trace in &row.traces {
        series(page, frame, trace);
    }
    // Dense data hide the band, so its edges lie on top of them.
    if let Some((half, _)) = row.band {
        for y in [frame.at_y(-half), frame.at_y(half)].into_iter().flatten() {
            let stroke = Stroke::solid(style::BAND_EDGE, 0.8);
            page.svg.line((frame.left, y), (frame.right(), y), stroke);
        }
    }
    page.svg.end();
    for marker in stack.markers {
        if let Some(x) = on_axis(frame, marker.at) {
            let (from, to) = ((x, frame.top), (x, frame.bottom()));
            page.svg.line(from, to, MARKER);
        }
    }
    frame.border(&mut page.svg);
    frame.y_labels(&mut page.svg);
}

const MARKER: Stroke = Stroke {
    color: style::TEXT_MUTED,
    width: 1.0,
    dash: "2 3",
};

fn draw_limit(page: &mut Page, frame: &Frame, limit: &Limit) {
    let Some(y) = frame.at_y(limit.value) else {
        return;
    };
    if y < frame.top || y > frame.bottom() {
        return;
    }
    let stroke = Stroke::dashed(style::LIMIT, 1.2);
    page.svg.line((frame.left, y), (frame.right(), y), stroke);
    let name = text::shorten(limit.name, style::NOTE_SIZE, 130.0 - LIMIT_GAP);
    let x = frame.right() + LIMIT_GAP;
    let at = Text::new(x, y + 3.6, style::NOTE_SIZE, style::TEXT_MUTED);
    page.svg.text(at, &name);
}

/// The horizontal position of a value that lies within the panel.
fn on_axis(frame: &Frame, value: f64) -> Option<f64> {
    let x = frame.at_x(value)?;
    (frame.left - 0.5..=frame.right() + 0.5)
        .contains(&x)
        .then_some(x)
}

fn series(page: &mut Page, frame: &Frame, trace: &Trace) {
    page.svg.begin_series(trace.role.class(), trace.name);
    let shown = trace.x.iter().zip(trace.y.iter());
    let shown = shown
        .filter(|(x, y)| y.is_finite() && (frame.x.lo..=frame.x.hi).contains(*x))
        .count();
    // Few measurements are points, not a line that nobody measured.
    if trace.role == LineRole::Measurement && (shown as f64) < frame.width / 8.0 {
        let points = trace.x.iter().copied().zip(trace.y.iter().copied());
        frame.dots(&mut page.svg, points, 4.0, trace.role.color());
    } else {
        let stroke = Stroke::solid(trace.role.color(), trace.role.line_width());
        if frame.line(&mut page.svg, trace.x, &trace.y, stroke) {
            page.note(page::REDUCED);
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

/// Labels of regions and markers between the first panel and its caption.
fn labels(page: &mut Page, stack: &Stack, first: &Frame, rows: usize, is_whole: bool) {
    let regions = stack.regions.iter().filter_map(|region| {
        let from = region.from.max(first.x.lo);
        let until = region.until.min(first.x.hi);
        let x = on_axis(first, (from + until) / 2.0)?;
        (from <= until).then_some((x, region.label, false))
    });
    let markers = stack
        .markers
        .iter()
        .filter_map(|marker| Some((on_axis(first, marker.at)?, marker.label, true)));
    let labels: Vec<(f64, &str, bool)> = regions
        .chain(markers)
        .filter(|(_, label, _)| !label.is_empty())
        .collect();
    let widest = (first.width / 2.0).max(60.0);
    let texts: Vec<String> = labels
        .iter()
        .map(|(_, label, _)| text::shorten(label, style::NOTE_SIZE, widest))
        .collect();
    let sizes: Vec<(f64, f64)> = labels
        .iter()
        .zip(&texts)
        .map(|((x, _, _), text)| (*x, text::width(text, style::NOTE_SIZE)))
        .collect();
    let places = page::lanes(&sizes, first.left, first.right(), rows);
    // The first lane is the lowest. Leaders first, so that a label in a lower
    // lane covers the leader of one above it.
    let baseline = |row: usize| first.top - 5.0 - row as f64 * LANE;
    for (place, (x, _, is_marker)) in places.iter().zip(&labels) {
        if let (Some((row, _)), true) = (place, is_marker) {
            page.svg
                .line((*x, baseline(*row) + 3.0), (*x, first.top), MARKER);
        }
    }
    let mut hidden = 0;
    for ((place, text), (_, width)) in places.iter().zip(&texts).zip(&sizes) {
        let Some((row, x)) = place else {
            hidden += 1;
            continue;
        };
        let y = baseline(*row);
        page.svg
            .rect(x - 1.0, y - 9.0, width + 2.0, 11.0, "#FFFFFF");
        let at = Text::new(*x, y, style::NOTE_SIZE, style::TEXT_MUTED);
        page.svg.text(at, text);
    }
    if hidden > 0 && is_whole {
        page.note(format!(
            "{hidden} of {} labels above the panels are left out for lack of room; their marks are drawn.",
            texts.len()
        ));
    }
}
