//! The claims, one file or folder each: how every applicable engine decides the claim.
//!
//! | file | claim, or what several use |
//! |---|---|
//! | [`source_understood`], [`texts_audited`], [`compiled_agrees`], [`certificate_consistent`], [`hardware_words`], [`physical_signs`] | the claims of that name |
//! | `certified_ends`, `drift_words` | where drive and wheel sensor end, and the drift's words: parts of `certificate-consistent` and `hardware-words` |
//! | [`gains_optimal`] | K against the weights, part of `certificate-consistent` |
//! | [`model_matches`] | the certificate against the user's model.toml |
//! | [`control_total`], [`control_accurate`], [`control_accurate_real_gains`], [`control_monotone`] | of the control law |
//! | [`primitives`], [`filter_total`], [`filter_length`], [`filter_accurate`], [`filter_exact`] | of the attitude filter |
//! | [`step_total`], [`supervisor`] | of the full step |
//! | [`encoder_exact`], [`encoder_loop_stable`] | of encoders, and of the loop with them or with a voltage drive |
//! | [`closed_loop_stable`], [`bias_observer_stable`], [`closed_loop_for_all_time`], [`closed_loop_second`], [`region_of_attraction`], [`stable_for_parameters`] | of the loop |
//! | [`loop_from_rest`] | `closed-loop-for-all-time` and `region-of-attraction` with the window of an encoder |
//! | `parameter_model`, `parameter_region` | the linear model as a function of its parameters, and which of them identification allows |
//! | [`control_law`] | the law that the source implements |
//! | [`sampling`] | the sampled model compared with the continuous one |
//! | [`bias_observer_numbers`], [`bias_observer_words`] | the observer of the angle's bias |
//! | [`named_words`], [`functions`], [`random`] | words and functions by name, random numbers |
//! | `upright` | the attitude that the filter reports as upright |
//! | `comparison` | two statements of one number |
//! | [`outcome`] | the result of a claim, and the engines |

pub mod bias_observer_numbers;
pub mod bias_observer_stable;
pub mod bias_observer_words;
pub mod certificate_consistent;
pub(crate) mod certified_ends;
pub mod closed_loop_agreement;
pub mod closed_loop_for_all_time;
pub(crate) mod closed_loop_response;
pub mod closed_loop_second;
pub mod closed_loop_stable;
pub(crate) mod comparison;
pub mod compiled_agrees;
pub mod control_accurate;
pub mod control_accurate_real_gains;
pub mod control_law;
pub mod control_monotone;
pub mod control_total;
pub(crate) mod drift_words;
pub mod emitted_observer;
pub mod encoder_exact;
pub mod encoder_loop_stable;
pub mod filter_accurate;
pub mod filter_exact;
pub mod filter_length;
pub mod filter_total;
pub mod functions;
pub mod gains_optimal;
pub mod hardware_words;
pub mod held_loop;
pub mod loop_as_shipped;
pub mod loop_from_rest;
pub mod model_matches;
pub mod monitor;
pub mod named_words;
pub mod outcome;
pub(crate) mod parameter_model;
pub(crate) mod parameter_region;
pub mod physical_signs;
pub mod primitives;
pub mod random;
pub mod region_of_attraction;
pub mod sampling;
pub mod source_understood;
pub mod stable_for_parameters;
pub mod step_total;
pub mod supervisor;
pub mod texts_audited;
pub(crate) mod upright;
pub(crate) mod window_lag;
