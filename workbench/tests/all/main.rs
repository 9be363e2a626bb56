//! Tests of the library's public interface, on the bench of the demonstration.

mod bench;
mod benches;
mod bring_up;
mod calling_off;
mod controller;
mod hardware;
mod learned;
#[cfg(unix)]
mod line_faults;
mod loops;
mod magnet;
mod monitored;
mod pivot_attacks;
mod results;
mod session;
mod sliders;
mod sound_modules;
