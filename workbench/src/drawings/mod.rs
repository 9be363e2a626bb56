//! Figures of the results, as the text of SVG files: each result has a method that draws it.

mod calibration;
mod closed_loop;
mod comparison;
mod decay;
mod design;
mod diagnosis;
mod torque_curve;
