//! Typed results as text for people.

pub mod bring_up;
pub mod calibration;
pub mod closed_loop;
pub mod comparison;
pub mod decay;
pub mod design;
pub mod design_change;
pub mod designs;
pub mod diagnosis;
pub mod effects;
pub mod exam;
pub mod findings;
mod head_lines;
pub mod new_bench;
pub mod proof;
pub mod recording;
