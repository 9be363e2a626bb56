//! The fit: from records and a model to the minimum of the squared residuals.
//!
//! | file | job |
//! |---|---|
//! | `start` | a first guess of the base parameters, computed from the samples |
//! | `ratios`, `rows` | the ratios of parameters that enter linearly, and the linear least squares that give them |
//! | `integrated` | the same for logs with few samples, from the integrated equations |
//! | `unknowns` | shared parameters, and the nuisance parameters of a window |
//! | `simulation` | the simulation of one window |
//! | `sensitivity` | the same with exact derivatives, summed into normal equations |
//! | `normal_equations` | all windows together, with their nuisance parameters eliminated |
//! | `solver`, `effort` | the Levenberg–Marquardt iteration, and when it ends |
//! | `score_test` | the gain that one step promises, without taking it |
//! | `transition` | the motion from sample to sample, linearised |
//! | `windows` | where windows begin, and their starts |
//! | `comparison` | the prediction compared with the measurement |
//! | `means` | whether a fit is better than predicting the mean of every series |
//! | `cogging` | starts for a fit of cogging |
//! | `schedule` | the growing windows of a fit that starts from scratch |
//! | `early` | fewer samples of dense logs until the last of them |

mod cogging;
mod comparison;
mod early;
mod effort;
mod integrated;
mod means;
mod normal_equations;
mod ratios;
mod rows;
mod schedule;
mod score_test;
mod sensitivity;
mod simulation;
mod solver;
mod start;
mod transition;
mod unknowns;
mod windows;

pub use cogging::{CoggingStart, cogging_start, settled};
pub use comparison::{PredictedSeries, traces, traces_that_count};
pub use effort::{Effort, Outcome};
pub(crate) use integrated::integrated_ratios;
pub(crate) use means::is_lost_swing;
pub use means::{NoBetterThanMean, cost_of_means, failed_series};
pub use ratios::Ratios;
pub(crate) use schedule::fit_in_stages;
pub use schedule::{fit_from_scratch, fit_windowed, refit};
pub use score_test::{KnownScore, RecordScore, ScoreStep, ScoreTest, score_test};
pub(crate) use sensitivity::counts;
pub use sensitivity::{MAX_UNKNOWNS, Observation, WindowNormal, normal, normal_observed};
pub(crate) use simulation::early_steps;
pub use simulation::{simulate, simulate_smoothed};
pub use solver::{Minimum, cost, minimise};
pub(crate) use start::driving_samples;
pub use start::{base_values, ratios};
pub(crate) use transition::transitions_backwards;
pub use unknowns::{Nuisance, Unknowns, Window, acts, is_of_wheel, relevant};
pub(crate) use windows::guess;
pub use windows::{final_windows, guessed, joined};
