//! The check of the data, on benches whose faults are known.

mod corrections;
mod kinds;
mod known_faults;
mod recordings;
mod simulated;
