//! Any named lines in stacked panels on one axis.

use crate::annotation::{Limit, Marker, Quantity, Region};
use crate::error::{FigureError, check_length};
use crate::page::Page;
use crate::stack::{self, Row, Stack, Trace};
use crate::style::LineRole;
use std::borrow::Cow;

/// Panels on one axis, from top to bottom.
#[derive(Debug, Clone, Copy, Default)]
pub struct Series<'a> {
    /// The title: a sentence that says what the figure shows.
    pub title: &'a str,
    /// Details, written below the title; may be empty.
    pub subtitle: &'a str,
    /// The shared horizontal axis, such as time in s.
    pub x: Quantity<'a>,
    /// The panels.
    pub panels: &'a [Panel<'a>],
    /// Stretches to shade.
    pub regions: &'a [Region<'a>],
    /// The meaning of the shading, for the legend.
    pub region_name: &'a str,
    /// Instants to mark.
    pub markers: &'a [Marker<'a>],
    /// Beginning and end, in the unit of the horizontal axis, of a part to enlarge beside the whole.
    pub zoom: Option<(f64, f64)>,
}

/// One panel.
#[derive(Debug, Clone, Copy, Default)]
pub struct Panel<'a> {
    /// Name and unit of the vertical axis.
    pub quantity: Quantity<'a>,
    /// Its lines; the first is drawn first and lies below the others.
    pub lines: &'a [Line<'a>],
    /// Dashed lines. A limit so far away that the data would look flat is named in words instead.
    pub limits: &'a [Limit<'a>],
    /// A short summary; may be empty.
    pub note: &'a str,
}

/// One named line.
#[derive(Debug, Clone, Copy)]
pub struct Line<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// The meaning of the line, which decides its colour.
    pub role: LineRole,
    /// Horizontal values.
    pub x: &'a [f64],
    /// Vertical values; NaN leaves a gap.
    pub y: &'a [f64],
}

/// Draws the panels.
///
/// # Errors
/// [`FigureError::Length`] if a line has not one y for each x.
pub fn series(figure: &Series) -> Result<String, FigureError> {
    let height = (560.0 / figure.panels.len().max(1) as f64).clamp(100.0, 300.0);
    let mut rows = Vec::new();
    for panel in figure.panels {
        let mut traces = Vec::new();
        for line in panel.lines {
            let what = || format!("the line \"{}\"", line.name);
            check_length(figure.title, what, line.x.len(), line.y.len())?;
            traces.push(Trace {
                name: line.name,
                role: line.role,
                x: line.x,
                y: Cow::Borrowed(line.y),
            });
        }
        rows.push(Row {
            quantity: panel.quantity,
            note: panel.note.into(),
            height,
            traces,
            band: None,
            limits: panel.limits,
        });
    }
    let mut page = Page::new(figure.title, figure.subtitle);
    let stack = Stack {
        x: figure.x,
        rows,
        regions: figure.regions,
        region_name: figure.region_name,
        markers: figure.markers,
        zoom: figure.zoom,
    };
    stack::draw(&mut page, &stack);
    Ok(page.finish())
}
