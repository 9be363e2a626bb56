//! Lines with bands of uncertainty, in stacked panels on one axis that may count decades: responses of a loop, Bode's
//! plot, sweeps.

use crate::annotation::{Limit, Quantity};
use crate::axis::{Axis, extent};
use crate::error::{FigureError, check_length};
use crate::frame::{self, Frame};
use crate::page::{self, Key, Mark, Page};
use crate::panels::Panels;
use crate::style::{self, LineRole};
use crate::svg::{Path, Stroke, Text};
use crate::text;

/// Panels on one axis, from top to bottom.
#[derive(Debug, Clone, Copy, Default)]
pub struct Banded<'a> {
    /// The title: a sentence that says what the figure shows.
    pub title: &'a str,
    /// Details, written below the title; may be empty.
    pub subtitle: &'a str,
    /// The shared horizontal axis.
    pub x: Quantity<'a>,
    /// Whether the horizontal axis is logarithmic.
    pub x_in_decades: bool,
    /// The meaning of the bands, for the legend.
    pub band_name: &'a str,
    /// The panels.
    pub panels: &'a [BandedPanel<'a>],
}

/// One panel.
#[derive(Debug, Clone, Copy, Default)]
pub struct BandedPanel<'a> {
    /// Name and unit of the vertical axis.
    pub quantity: Quantity<'a>,
    /// Whether the vertical axis is logarithmic.
    pub in_decades: bool,
    /// Its lines.
    pub lines: &'a [BandedLine<'a>],
    /// Dashed lines.
    pub limits: &'a [Limit<'a>],
}

/// One line and its band.
#[derive(Debug, Clone, Copy)]
pub struct BandedLine<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Gives the colour.
    pub role: LineRole,
    /// Horizontal values.
    pub x: &'a [f64],
    /// Vertical values; NaN leaves a gap.
    pub y: &'a [f64],
    /// Lower and upper edge of the band; both empty where there is none.
    pub band: (&'a [f64], &'a [f64]),
}

/// Draws the panels.
///
/// # Errors
/// [`FigureError::Length`] if a line or an edge has not one value for each x.
pub fn banded(figure: &Banded) -> Result<String, FigureError> {
    let lines = || figure.panels.iter().flat_map(|panel| panel.lines);
    for line in lines() {
        let what = || format!("the line \"{}\"", line.name);
        check_length(figure.title, what, line.x.len(), line.y.len())?;
        for edge in [line.band.0, line.band.1] {
            if !(line.band.0.is_empty() && line.band.1.is_empty()) {
                check_length(figure.title, what, line.x.len(), edge.len())?;
            }
        }
    }
    let mut page = Page::new(figure.title, figure.subtitle);
    let mut keys: Vec<Key> = lines()
        .map(|line| Key::line(line.role, line.name))
        .collect();
    if let Some(line) = lines().find(|line| !line.band.0.is_empty()) {
        let color = line.role.pale();
        keys.push(Key::new(Mark::Patch { color }, figure.band_name));
    }
    page.legend(&keys);

    let height = (520.0 / figure.panels.len().max(1) as f64).clamp(110.0, 300.0);
    let axes: Vec<Axis> = figure
        .panels
        .iter()
        .map(|panel| y_axis(panel, height))
        .collect();
    let limits = figure.panels.iter().flat_map(|panel| panel.limits);
    let right = limits
        .map(|limit| text::width(limit.name, style::NOTE_SIZE) + 9.0)
        .fold(8.0, f64::max);
    let panels = Panels::new(&axes, height, 4.0, right);
    let whole = extent(lines().flat_map(|line| line.x.iter().copied()));
    let x = if figure.x_in_decades {
        Axis::log(whole, frame::x_ticks(panels.width))
    } else {
        Axis::linear(whole, 0.005, frame::x_ticks(panels.width))
    };
    panels.draw(&mut page, (&x, figure.x), figure.panels, axes, draw);
    Ok(page.finish())
}

/// The vertical axis of a panel. It covers the lines, and it extends towards bands and limits by at most twice the
/// range that it then has, so that the lines do not look flat.
fn y_axis(panel: &BandedPanel, height: f64) -> Axis {
    let lines = panel.lines.iter();
    let core = extent(lines.clone().flat_map(|line| line.y.iter().copied()));
    let edges = extent(lines.flat_map(|line| line.band.0.iter().chain(line.band.1).copied()));
    let limits = extent(panel.limits.iter().map(|limit| limit.value));
    let mut range = core;
    for more in [edges, limits].into_iter().flatten() {
        if let Some((low, high)) = range {
            let room = 2.0 * (high - low).max(f64::MIN_POSITIVE);
            range = Some((
                low.min(more.0.max(low - room)),
                high.max(more.1.min(high + room)),
            ));
        }
    }
    if panel.in_decades {
        Axis::log(range, frame::y_ticks(height))
    } else {
        Axis::linear(range, 0.06, frame::y_ticks(height))
    }
}

fn draw(page: &mut Page, frame: &Frame, panel: &BandedPanel) {
    frame.begin_clip(&mut page.svg);
    for line in panel.lines {
        let mut outline = Path::default();
        let upper = line.x.iter().zip(line.band.1);
        let lower = line.x.iter().zip(line.band.0).rev();
        let points = upper.chain(lower).filter_map(|(x, y)| frame.at(*x, *y));
        for (index, (x, y)) in points.enumerate() {
            if index == 0 {
                outline.move_to(x, y);
            } else {
                outline.line_to(x, y);
            }
        }
        outline.close();
        page.svg.area(&outline, line.role.pale());
    }
    page.svg.end();
    frame.grid(&mut page.svg, true);
    frame.zero_line(&mut page.svg);
    for limit in panel.limits {
        let Some(y) = frame
            .at_y(limit.value)
            .filter(|y| (frame.top..=frame.bottom()).contains(y))
        else {
            continue;
        };
        let stroke = Stroke::dashed(style::LIMIT, 1.2);
        page.svg.line((frame.left, y), (frame.right(), y), stroke);
        let at = Text::new(
            frame.right() + 7.0,
            y + 3.6,
            style::NOTE_SIZE,
            style::TEXT_MUTED,
        );
        page.svg.text(at, limit.name);
    }
    frame.begin_clip(&mut page.svg);
    for line in panel.lines {
        page.svg.begin_series(line.role.class(), line.name);
        let stroke = Stroke::solid(line.role.color(), line.role.line_width().max(1.4));
        if frame.line(&mut page.svg, line.x, line.y, stroke) {
            page.note(page::REDUCED);
        }
        page.svg.end();
    }
    page.svg.end();
    frame.border(&mut page.svg);
    frame.y_labels(&mut page.svg);
    frame.y_caption(&mut page.svg, style::PAGE_MARGIN, panel.quantity);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure<'a>(panels: &'a [BandedPanel<'a>]) -> Banded<'a> {
        Banded {
            title: "Response",
            x_in_decades: true,
            band_name: "95 %",
            panels,
            ..Default::default()
        }
    }

    /// The band is an area between its edges, under the line, and inside its panel's clip.
    #[test]
    fn a_band_is_filled_and_lies_below_the_line() {
        let x = [1.0, 10.0, 100.0];
        let line = BandedLine {
            name: "design",
            role: LineRole::Model,
            x: &x,
            y: &[0.0, 1.0, 0.5],
            band: (&[-0.1, 0.8, 0.4], &[0.1, 1.2, 0.6]),
        };
        let panels = [BandedPanel {
            quantity: Quantity {
                name: "angle",
                unit: "rad",
            },
            lines: &[line],
            limits: &[Limit {
                value: 1.1,
                name: "limit",
            }],
            ..Default::default()
        }];
        let text = banded(&figure(&panels)).unwrap();
        let area = text.find(&format!("fill=\"{}\"/>\n", LineRole::Model.pale()));
        let line = text.find(&format!("stroke=\"{}\"", LineRole::Model.color()));
        assert!(area.is_some() && line.is_some());
        assert!(text.rfind("data-series=\"design\"") > area);
        assert!(text.contains(">limit<") && text.contains("95 %"));
        let document = roxmltree::Document::parse(&text).unwrap();
        assert_eq!(document.root_element().tag_name().name(), "svg");
    }

    #[test]
    fn an_edge_of_the_wrong_length_is_named() {
        let line = BandedLine {
            name: "short",
            role: LineRole::Model,
            x: &[1.0, 2.0],
            y: &[1.0, 2.0],
            band: (&[1.0], &[1.0, 2.0]),
        };
        let panels = [BandedPanel {
            lines: &[line],
            ..Default::default()
        }];
        let error = banded(&figure(&panels)).unwrap_err();
        assert!(error.to_string().contains("short"), "{error}");
    }
}
