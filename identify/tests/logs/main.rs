//! From logs to parameters and to the places where a model fails: recovery of known truth from
//! simulated logs, and figures of real ones.

mod breakdown;
mod contradiction;
mod correlation;
mod other_rig;
mod outside;
mod real;
mod recovery;
mod simulated;
