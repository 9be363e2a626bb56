//! The program from outside.

mod bias_observer;
mod cli;
mod emitted;
mod guide;
mod hardware;
mod harness_crates;
mod raw_counts;
