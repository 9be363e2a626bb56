//! Static figures as SVG: plain data in, the text of an SVG file out.
//!
//! Every kind of figure is one file with one struct of borrowed slices and one
//! function. None computes results; they draw what the other crates found.
//! All share one palette ([`LineRole`]), one page and one set of axes, so that
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
//! Most figures here are stacked panels on one time axis, and the writer for
//! them is short.
#![warn(missing_docs)]

mod annotation;
mod axis;
mod decimate;
mod error;
mod frame;
mod page;
mod stack;
mod style;
mod svg;
mod text;

mod banded;
mod breakdown;
mod confusion;
mod decay;
mod nyquist;
mod overlay;
mod panels;
mod poles;
mod reliability;
mod series;
mod sphere;
mod staircase;
mod suspects;
mod torque_curve;

pub use annotation::{Limit, Marker, Quantity, Region};
pub use banded::{Banded, BandedLine, BandedPanel, banded};
pub use breakdown::{Breakdown, BreakdownPanel, ResidualBin, breakdown};
pub use confusion::{Confusion, confusion};
pub use decay::{Decay, DecayPanel, DecayPoint, decay};
pub use error::FigureError;
pub use nyquist::{Nyquist, NyquistCurve, nyquist};
pub use overlay::{Overlay, OverlayChannel, overlay};
pub use poles::{Plane, PoleSet, Poles, poles};
pub use reliability::{Reliability, ReliabilityBin, reliability};
pub use series::{Line, Panel, Series, series};
pub use sphere::{Sphere, sphere};
pub use staircase::{Staircase, StaircaseTrace, staircase};
pub use style::LineRole;
pub use suspects::{SuspectBar, Suspects, suspects};
pub use torque_curve::{TorqueCurve, TorqueCurvePoint, torque_curve};
