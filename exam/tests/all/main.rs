//! The exam examined, and the diagnosis by the exam's benches.

mod cancelled;
mod cogging;
mod data;
mod examined;
mod external;
mod imperfection;
mod learned;
mod sensors;
