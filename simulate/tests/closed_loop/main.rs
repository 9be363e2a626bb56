//! Tests of whole closed loops on the thesis bench.

mod bench;
mod emitted_law;
mod independent_simulation;
mod interpreted_law;
mod physics;
mod studies;
