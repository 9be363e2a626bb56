//! Static figures as SVG: plain data in, the text of an SVG file out.
//!
//! Every kind of figure is one file with one struct of borrowed slices and one
//! function. None computes results; they draw what the other crates found.
//! All share one palette ([`Role`]), one page and one set of axes, so that
//! measurement, model, residual, fixed-point law and float law look the same
//! everywhere. Pages are light and 900 pixels wide. Text that does not fit is
//! shortened or wrapped; labels stand beside the data, never on them.
//!
//! Values that are not finite leave gaps. Long series are reduced to the
//! first, lowest, highest and last value of each pixel column, which draws the
//! same picture, and the figure says so. The output depends on the input
//! alone: equal data give equal files.
//!
//! # Why a writer of our own
//! kuva 0.6, the plotting library that was tried first, takes 50 s of processor
//! time to compile, writes 0.95 MB for a line of 50,000 points, ends a line at
//! its first NaN and writes the NaN into the file, gives stacked panels
//! different left edges so that one instant is not above itself, and numbers
//! its clip paths by a global counter so that equal data give different files.
//! Stacked panels on one time axis are most of what is drawn here; the writer
//! for them is short.
#![warn(missing_docs)]

mod axis;
mod decimate;
mod frame;
mod page;
mod stack;
mod style;
mod svg;
mod text;

mod breakdown;
mod confusion;
mod decay;
mod overlay;
mod poles;
mod reliability;
mod series;
mod sphere;
mod staircase;
mod suspects;

pub use breakdown::{Breakdown, BreakdownPanel, ResidualBin, breakdown};
pub use confusion::{Confusion, confusion};
pub use decay::{Decay, DecayPanel, DecayPoint, decay};
pub use overlay::{Channel, Overlay, overlay};
pub use poles::{Plane, PoleSet, Poles, poles};
pub use reliability::{Reliability, ReliabilityBin, reliability};
pub use series::{Line, Panel, Series, series};
pub use sphere::{Sphere, sphere};
pub use staircase::{Staircase, StaircaseTrace, staircase};
pub use style::Role;
pub use suspects::{Suspect, Suspects, suspects};

/// A name with its unit, for axes and captions.
///
/// SI units take a prefix where the numbers are small ("mrad" for "rad");
/// others are preceded by a power of ten.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Quantity<'a> {
    /// What is plotted, such as "angle".
    pub name: &'a str,
    /// Its unit, such as "rad"; empty for a pure number.
    pub unit: &'a str,
}

/// A stretch of the horizontal axis to shade, such as where a model fails.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Region<'a> {
    /// Beginning, in the unit of the axis.
    pub from: f64,
    /// End, in the unit of the axis.
    pub until: f64,
    /// Short label, such as "41 % of the error"; may be empty.
    pub label: &'a str,
}

/// An instant to mark through all panels, such as a push.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Marker<'a> {
    /// Where, in the unit of the axis.
    pub at: f64,
    /// Short label, such as "3.1 mN m s"; may be empty.
    pub label: &'a str,
}

/// A value that must not be passed, drawn as a dashed line.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limit<'a> {
    /// The value, in the unit of the panel.
    pub value: f64,
    /// Short label, such as "2 A".
    pub name: &'a str,
}

/// Why a figure could not be made.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// Two slices that belong together differ in length.
    #[error("figure \"{figure}\": {what} has {found} values where {expected} are needed")]
    Length {
        /// Title of the figure.
        figure: String,
        /// The slice that does not fit.
        what: String,
        /// Length that was needed.
        expected: usize,
        /// Length that was found.
        found: usize,
    },
}

/// Checks that `what` of the figure `figure` has `expected` values.
fn check_length(
    figure: &str,
    what: impl FnOnce() -> String,
    expected: usize,
    found: usize,
) -> Result<(), FigureError> {
    if expected == found {
        return Ok(());
    }
    Err(FigureError::Length {
        figure: figure.to_owned(),
        what: what(),
        expected,
        found,
    })
}
