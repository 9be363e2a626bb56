//! Model over measurement with the residual below, for one experiment.

use crate::annotation::{Marker, Quantity, Region};
use crate::error::{FigureError, check_length};
use crate::page::Page;
use crate::stack::{self, Row, Stack, Trace};
use crate::style::LineRole;
use std::borrow::Cow;

/// One experiment.
#[derive(Debug, Clone, Copy, Default)]
pub struct Overlay<'a> {
    /// The title: a sentence that says what the figure shows.
    pub title: &'a str,
    /// Details, written below the title; may be empty.
    pub subtitle: &'a str,
    /// Time of each sample in s; a gap in the log is a NaN in the channels.
    pub time_s: &'a [f64],
    /// The measured channels.
    pub channels: &'a [OverlayChannel<'a>],
    /// The time spans in which the model fails, in s.
    pub regions: &'a [Region<'a>],
    /// Pushes and other instants, in s.
    pub markers: &'a [Marker<'a>],
    /// Beginning and end, in s, of a part to enlarge beside the whole.
    pub zoom_s: Option<(f64, f64)>,
}

/// One sensor of the experiment.
#[derive(Debug, Clone, Copy, Default)]
pub struct OverlayChannel<'a> {
    /// Name and unit of the measured quantity.
    pub quantity: Quantity<'a>,
    /// The readings of the sensor, one value per sample.
    pub measurement: &'a [f64],
    /// The predictions of the model, one value per sample.
    pub model: &'a [f64],
    /// Standard deviation of the sensor's noise in the unit of the channel;
    /// NaN or zero where it is unknown.
    pub sensor_std: f64,
    /// A short summary such as "RMSE 19.1 mrad, fit 83 %"; may be empty.
    pub note: &'a str,
}

/// Draws for each channel measurement and model, and below them the residual
/// (measurement − model) with a band of two standard deviations of the
/// sensor's noise, all on one time axis.
///
/// # Errors
/// [`FigureError::Length`] if a channel has not one value for each sample.
pub fn overlay(figure: &Overlay) -> Result<String, FigureError> {
    let samples = figure.time_s.len();
    let mut rows = Vec::new();
    // Many channels share the page, so each gets less of its height.
    let height = (480.0 / figure.channels.len().max(1) as f64).clamp(110.0, 220.0);
    for channel in figure.channels {
        let name = channel.quantity.name;
        let what = || format!("the measurement of {name}");
        check_length(figure.title, what, samples, channel.measurement.len())?;
        let what = || format!("the model of {name}");
        check_length(figure.title, what, samples, channel.model.len())?;
        let residual: Vec<f64> = channel
            .measurement
            .iter()
            .zip(channel.model)
            .map(|(measured, modelled)| measured - modelled)
            .collect();
        let trace = |name, role, y| Trace {
            name,
            role,
            x: figure.time_s,
            y,
        };
        rows.push(Row {
            quantity: channel.quantity,
            note: channel.note.into(),
            height,
            traces: vec![
                trace(
                    "measurement",
                    LineRole::Measurement,
                    Cow::Borrowed(channel.measurement),
                ),
                trace("model", LineRole::Model, Cow::Borrowed(channel.model)),
            ],
            band: None,
            limits: &[],
        });
        rows.push(Row {
            quantity: Quantity {
                name: "residual",
                unit: channel.quantity.unit,
            },
            note: Cow::Borrowed(""),
            height: height * 0.55,
            traces: vec![trace(
                "residual = measurement − model",
                LineRole::Residual,
                Cow::Owned(residual),
            )],
            band: (channel.sensor_std > 0.0)
                .then_some((2.0 * channel.sensor_std, "±2σ of the sensor noise")),
            limits: &[],
        });
    }
    let mut page = Page::new(figure.title, figure.subtitle);
    let stack = Stack {
        x: Quantity {
            name: "time",
            unit: "s",
        },
        rows,
        regions: figure.regions,
        region_name: "where the error is largest",
        markers: figure.markers,
        zoom: figure.zoom_s,
    };
    stack::draw(&mut page, &stack);
    Ok(page.finish())
}
