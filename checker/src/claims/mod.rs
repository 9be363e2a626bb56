//! One file a claim: how it is settled.

pub mod bias_observer_stable;
pub mod certificate_consistent;
pub mod closed_loop_for_all_time;
pub mod control_law;
pub mod filter_accurate;
pub mod filter_exact;
pub mod filter_length;
pub mod filter_total;
pub mod hardware_words;
pub mod region_of_attraction;
pub mod stable_for_parameters;
