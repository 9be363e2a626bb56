//! Figure: the decay of a free swing; decay rate, period, or another quantity over amplitude.

use crate::annotation::Quantity;
use crate::axis::{Axis, extent};
use crate::error::{FigureError, check_length};
use crate::frame::{self, Frame};
use crate::page::{self, Key, Mark, Page};
use crate::panels::Panels;
use crate::style::{self, LineRole};
use crate::svg::Stroke;

/// Panels over the amplitude.
#[derive(Debug, Clone, Copy, Default)]
pub struct Decay<'a> {
    /// The message of the figure, as a sentence.
    pub title: &'a str,
    /// A second line; may be empty.
    pub subtitle: &'a str,
    /// The shared horizontal axis, such as amplitude in rad.
    pub amplitude: Quantity<'a>,
    /// The panels, such as decay rate and period.
    pub panels: &'a [DecayPanel<'a>],
}

/// One quantity over the amplitude.
#[derive(Debug, Clone, Copy, Default)]
pub struct DecayPanel<'a> {
    /// Name and unit.
    pub quantity: Quantity<'a>,
    /// Measured points.
    pub points: &'a [DecayPoint],
    /// Amplitudes of the model's line; empty without a model.
    pub model_amplitude: &'a [f64],
    /// Values of the model's line.
    pub model: &'a [f64],
    /// A short summary; may be empty.
    pub note: &'a str,
}

/// One measured point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DecayPoint {
    /// Amplitude.
    pub amplitude: f64,
    /// The quantity of the panel.
    pub value: f64,
    /// Its standard error; NaN if unknown.
    pub std: f64,
}

/// Draws the measured points with two standard errors and the model's line.
///
/// # Errors
/// [`FigureError::Length`] unless a model's line has one value for each
/// amplitude.
pub fn decay(figure: &Decay) -> Result<String, FigureError> {
    for panel in figure.panels {
        let what = || format!("the model of {}", panel.quantity.name);
        let (expected, found) = (panel.model_amplitude.len(), panel.model.len());
        check_length(figure.title, what, expected, found)?;
    }
    let mut page = Page::new(figure.title, figure.subtitle);
    let color = LineRole::Measurement.color();
    let mut keys = vec![Key::new(
        Mark::Dot { color },
        "measurement ±2 standard errors",
    )];
    if figure.panels.iter().any(|p| !p.model.is_empty()) {
        keys.push(Key::line(LineRole::Model, "model"));
    }
    page.legend(&keys);
    let height = (460.0 / figure.panels.len().max(1) as f64).clamp(130.0, 280.0);
    let amplitudes = figure.panels.iter().flat_map(|p| {
        let points = p.points.iter().map(|point| point.amplitude);
        points.chain(p.model_amplitude.iter().copied())
    });
    let range = extent(amplitudes.chain([0.0]));
    let axes: Vec<Axis> = figure.panels.iter().map(|p| y_axis(p, height)).collect();
    let panels = Panels::new(&axes, height, 8.0, 8.0);
    let x = Axis::linear(range, 0.02, frame::x_ticks(panels.width));
    panels.draw(&mut page, (&x, figure.amplitude), figure.panels, axes, draw);
    Ok(page.finish())
}

/// The axis covers every point and the model. An error bar that would flatten
/// all others is cut.
fn y_axis(panel: &DecayPanel, height: f64) -> Axis {
    let values = panel.points.iter().map(|point| point.value);
    let core = extent(values.chain(panel.model.iter().copied()));
    let bars = panel
        .points
        .iter()
        .filter(|point| point.std.is_finite())
        .flat_map(|p| [p.value - 2.0 * p.std, p.value + 2.0 * p.std]);
    let range = match (core, extent(bars)) {
        (Some((lo, hi)), Some((bar_lo, bar_hi))) if hi > lo => {
            let room = hi - lo;
            Some((lo.min(bar_lo.max(lo - room)), hi.max(bar_hi.min(hi + room))))
        }
        (Some((lo, hi)), Some((bar_lo, bar_hi))) => Some((lo.min(bar_lo), hi.max(bar_hi))),
        (core, _) => core,
    };
    Axis::linear(range, 0.06, frame::y_ticks(height))
}

fn draw(page: &mut Page, frame: &Frame, panel: &DecayPanel) {
    frame.grid(&mut page.svg, true);
    frame.begin_clip(&mut page.svg);
    if !panel.model.is_empty() {
        page.svg.begin_series(LineRole::Model.class(), "model");
        let stroke = Stroke::solid(LineRole::Model.color(), 1.8);
        frame.line(&mut page.svg, panel.model_amplitude, panel.model, stroke);
        page.svg.end();
    }
    page.svg
        .begin_series(LineRole::Measurement.class(), panel.quantity.name);
    for point in panel.points {
        let half = 2.0 * point.std;
        frame.error_bar(
            &mut page.svg,
            point.amplitude,
            point.value,
            point.value - half,
            point.value + half,
            LineRole::Measurement,
        );
    }
    page.svg.end();
    page.svg.end();
    frame.border(&mut page.svg);
    frame.y_labels(&mut page.svg);
    let taken = frame.y_caption(&mut page.svg, style::PAGE_MARGIN, panel.quantity);
    let room = frame.right() - style::PAGE_MARGIN - taken - 16.0;
    page::right_note(
        &mut page.svg,
        frame.right(),
        frame.top - frame::CAPTION_GAP,
        room,
        panel.note,
    );
}
