//! From logs to parameters and to the places where a model fails: recovery of known truth from
//! simulated logs, and figures of real ones.

mod averages;
mod breakdown;
mod coarse;
mod common;
mod contradiction;
mod correlation;
mod early_steps;
mod learned;
mod left_out;
mod neighbour;
mod other_rig;
mod outside;
mod pushes;
mod real;
mod recovery;
mod scales;
mod selection;
mod sensors;
mod simulated;
mod solver;
mod standard_errors;
mod wheel_angle;
