//! Figures of the results as SVG texts: each result has a method that draws it.

mod calibration;
mod closed_loop;
mod comparison;
mod decay;
mod design;
mod diagnosis;
mod loops;
mod torque_curve;

pub use loops::{NamedLoop, loop_drawings};
