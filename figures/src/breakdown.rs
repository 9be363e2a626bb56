//! Figure: the residual over physical coordinates.

use crate::annotation::Quantity;
use crate::axis::{Axis, extent};
use crate::frame::{self, Frame};
use crate::page::{self, Key, Mark, Page};
use crate::style::{self, LineRole};
use crate::svg::{Anchor, Text};

/// Small panels, one for each coordinate.
#[derive(Debug, Clone, Copy, Default)]
pub struct Breakdown<'a> {
    /// The message of the figure, as a sentence.
    pub title: &'a str,
    /// A second line; may be empty.
    pub subtitle: &'a str,
    /// The panels.
    pub panels: &'a [BreakdownPanel<'a>],
}

/// The residual of one channel over one coordinate.
#[derive(Debug, Clone, Copy, Default)]
pub struct BreakdownPanel<'a> {
    /// Amplitude, speed, angle, …
    pub coordinate: Quantity<'a>,
    /// The residual and its unit.
    pub residual: Quantity<'a>,
    /// Bins along the coordinate.
    pub bins: &'a [ResidualBin],
    /// Standard deviation of the sensor's noise, in the unit of the residual;
    /// NaN or zero if unknown.
    pub sensor_std: f64,
    /// A short summary; may be empty.
    pub note: &'a str,
}

/// One bin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ResidualBin {
    /// Lower edge in the unit of the coordinate.
    pub from: f64,
    /// Upper edge.
    pub until: f64,
    /// Mean residual; NaN if the bin is empty.
    pub mean: f64,
    /// Standard error of the mean.
    pub mean_std: f64,
    /// This bin's share of the sum of squared residuals, 0 to 1.
    pub share_of_error: f64,
}

const COLUMNS: usize = 3;
const RESIDUAL_HEIGHT: f64 = 130.0;
const SHARE_HEIGHT: f64 = 44.0;
const CELL_HEIGHT: f64 = frame::CAPTION + RESIDUAL_HEIGHT + 20.0 + SHARE_HEIGHT + 46.0;

/// Draws, for each coordinate, the mean residual of each bin with two standard
/// errors, and below it the bin's share of the error.
pub fn breakdown(figure: &Breakdown) -> String {
    let mut page = Page::new(figure.title, figure.subtitle);
    let mut keys = vec![
        Key::new(
            Mark::Dot {
                color: LineRole::Residual.color(),
            },
            "mean residual in the bin ±2 standard errors",
        ),
        Key::new(
            Mark::Patch { color: SHARE_COLOR },
            "the bin's share of the squared error",
        ),
    ];
    if figure.panels.iter().any(|p| p.sensor_std > 0.0) {
        let mark = Mark::Patch { color: style::BAND };
        keys.push(Key::new(mark, "±σ of the sensor's noise"));
    }
    page.legend(&keys);
    let columns = match figure.panels.len() {
        4 => 2,
        count => count.clamp(1, COLUMNS),
    };
    let full = style::PAGE_WIDTH - 2.0 * style::PAGE_MARGIN;
    let gap = 24.0;
    let width = (full - gap * (columns - 1) as f64) / columns as f64;
    let top = page.y;
    for (index, panel) in figure.panels.iter().enumerate() {
        let left = style::PAGE_MARGIN + (index % columns) as f64 * (width + gap);
        let y = top + (index / columns) as f64 * CELL_HEIGHT;
        cell(&mut page, panel, left, y, width);
    }
    page.y = top + figure.panels.len().div_ceil(columns) as f64 * CELL_HEIGHT;
    page.finish()
}

const SHARE_COLOR: &str = "#E3A857";

fn cell(page: &mut Page, panel: &BreakdownPanel, left: f64, top: f64, width: f64) {
    let bins = panel.bins;
    let range = extent(bins.iter().flat_map(|b| [b.from, b.until]));
    let band = if panel.sensor_std > 0.0 {
        panel.sensor_std
    } else {
        0.0
    };
    let values = bins.iter().flat_map(|b| {
        let half = if b.mean_std.is_finite() {
            2.0 * b.mean_std
        } else {
            0.0
        };
        [b.mean - half, b.mean + half]
    });
    let y = Axis::linear(
        extent(values.chain([-band, band])),
        0.08,
        frame::y_ticks(RESIDUAL_HEIGHT),
    );
    let share_top = extent(bins.iter().map(|b| b.share_of_error * 100.0));
    let share_top = share_top.map_or(1.0, |(_, hi)| hi).max(1.0);
    let share = Axis::linear(Some((0.0, share_top * 1.05)), 0.0, 3.0);
    let gutter = frame::gutter(&y).max(frame::gutter(&share));
    let plot_width = width - gutter - 6.0;
    let x = Axis::linear(range, 0.0, frame::x_ticks(plot_width) + 1.0);
    let upper = Frame {
        left: left + gutter,
        top: top + frame::CAPTION,
        width: plot_width,
        height: RESIDUAL_HEIGHT,
        x: x.clone(),
        y,
    };
    let lower = Frame {
        left: left + gutter,
        top: upper.bottom() + 20.0,
        width: plot_width,
        height: SHARE_HEIGHT,
        x,
        y: share,
    };
    let name = format!("{} over {}", panel.residual.name, panel.coordinate.name);
    if band > 0.0 {
        upper.band(&mut page.svg, -band, band, style::BAND);
    }
    upper.grid(&mut page.svg, false);
    upper.zero_line(&mut page.svg);
    page.svg.begin_series(LineRole::Residual.class(), &name);
    for bin in bins {
        let middle = (bin.from + bin.until) / 2.0;
        let half = 2.0 * bin.mean_std;
        let (low, high) = (bin.mean - half, bin.mean + half);
        upper.error_bar(
            &mut page.svg,
            middle,
            bin.mean,
            low,
            high,
            LineRole::Residual,
        );
    }
    page.svg.end();
    upper.border(&mut page.svg);
    upper.y_labels(&mut page.svg);
    let taken = upper.y_caption(&mut page.svg, left, panel.residual);
    let room = upper.right() - left - taken - 12.0;
    if room > 40.0 {
        let top = upper.top - frame::CAPTION_GAP;
        page::right_note(&mut page.svg, upper.right(), top, room, panel.note);
    }

    lower.grid(&mut page.svg, false);
    for bin in bins {
        let height = lower.at(bin.until, bin.share_of_error * 100.0);
        if let (Some((right, y)), Some(left)) = (height, lower.at_x(bin.from)) {
            let bar = (right - left - 1.0).max(0.8);
            page.svg
                .rect(left + 0.5, y, bar, lower.bottom() - y, SHARE_COLOR);
        }
    }
    lower.border(&mut page.svg);
    lower.y_labels(&mut page.svg);
    let at = Text::new(
        lower.right(),
        lower.top - 5.0,
        style::NOTE_SIZE,
        style::TEXT_MUTED,
    );
    page.svg.text(at.anchor(Anchor::End), "share of error (%)");
    lower.x_labels(&mut page.svg);
    lower.x_caption(&mut page.svg, panel.coordinate);
}
