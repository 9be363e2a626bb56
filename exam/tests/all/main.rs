//! Tests of the exam, and of the diagnosis with the exam's benches.

mod awkward_logs;
mod cancelled;
mod clock;
mod cogging;
mod data;
mod examined;
mod external;
mod imperfection;
mod learned;
mod scales;
mod sensors;
mod teeth;
mod thesis_bench;
mod wheel_friction;
