//! Tests of whole closed loops on the thesis bench.

mod attitude_filters;
mod bench;
mod body_encoder;
mod compiled;
mod emitted_law;
mod faults;
mod independent_simulation;
mod interpreted_law;
mod monitor;
mod physics;
mod raw_counts;
mod rounding;
mod studies;
