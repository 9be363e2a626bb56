//! The check of the data, on benches whose faults are known.

mod columns;
mod corrections;
mod cures;
mod hostile;
mod kinds;
mod known_faults;
mod matrix;
mod recordings;
mod silent;
mod simulated;
