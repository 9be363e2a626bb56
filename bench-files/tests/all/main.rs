//! Tests of what a user of the crate sees.

mod calibration;
mod common;
mod drop_outs;
mod errors;
mod formats;
mod garbage;
mod hardware;
mod learned;
mod logs;
mod model_file;
mod outline;
mod own_effects;
mod shared_data;
