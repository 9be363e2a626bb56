//! One file per command: its arguments, and what it does with them.

pub mod add;
pub mod bring_up;
pub mod calibrate;
pub mod check;
pub mod compare;
pub mod demo;
pub mod design;
pub mod diagnose;
pub mod effects;
pub mod exam;
pub mod generate;
pub mod identify;
pub mod lab;
pub mod mutate;
pub mod new;
pub mod prove;
pub mod record;
pub mod remove;
pub mod report;
pub mod simulate;
