//! Which physical effect does a model lack?
//!
//! Each file imports only from files above it in this table.
//!
//! | file | job |
//! |---|---|
//! | `thresholds` | the numbers that decide verdicts, and where each comes from |
//! | `economy` | the numbers that only save time |
//! | `remainder` | the structured residual of every series, in units of the series' noise |
//! | `physical` | fitted values that the cause of an effect cannot have |
//! | `candidate` | a model that was tried: plain data |
//! | `remains` | how large the residual is: against the noise, against the signal, and as a torque |
//! | `imperfection` | the misfit that the smoothed sign of dry friction alone leaves |
//! | `bench` | the inputs of a search: records, suspects, thresholds |
//! | `shown` | whether the measurements would show what one candidate adds to another |
//! | `applicable` | which effects are suspects for this bench |
//! | `evidence` | how strongly the measurements speak for one model against another |
//! | `score` | the score test: the gain that every suspect promises, and the starting points for its fit |
//! | `trial` | the fits of single effects on top of a candidate |
//! | `round` | one round of trials |
//! | `pool` | all candidates, and what follows from them without another fit: merging, ties, the simplest one |
//! | `search` | the search for the set of effects that explains the measurements |
//! | `short_windows` | whether driven logs must be read in short windows |
//! | `thinned` | logs that are read more sparsely than they were recorded |
//! | `path` | the way to the chosen candidate, one effect a step |
//! | `verdict` | the possible verdicts, and their wording |
//! | `decision` | which effects are certain, which are provisional, and which verdict follows |
//! | `open` | an explanation beside which the logs leave an inertia open |
//! | `steps` | the steps from the diagnosed model to the final one |
//! | `ranking` | the effects that could be missing, by probability |
//! | `genuine` | the probability that a library effect is real beside an unknown one |
//! | `validation` | how well a model predicts an experiment that its fit has not seen |
//! | `next_experiment` | the experiment that would separate explanations that tie |
//! | `report` | steps and suspects as the report shows them |
//! | `diagnosis` | from the logs to the verdict |

mod applicable;
mod bench;
mod candidate;
mod decision;
mod diagnosis;
mod double_swap;
mod economy;
mod evidence;
mod genuine;
#[cfg(test)]
mod hand_made;
mod imperfection;
mod next_experiment;
mod open;
mod path;
mod physical;
mod pool;
mod ranking;
mod remainder;
mod remains;
mod report;
mod round;
mod score;
mod search;
mod short_windows;
mod shown;
mod steps;
mod thinned;
mod thresholds;
mod trial;
mod validation;
mod verdict;

pub use applicable::applicable;
pub use bench::{IsCancelled, SearchBench};
pub use candidate::{Candidate, names};
pub use diagnosis::{Options, diagnose_with, suspects_of};
pub use imperfection::{Imperfection, Imperfections, imperfection};
pub use next_experiment::{Explanation, NextExperiment, Recipe, propose, tell_apart};
pub use physical::Unphysical;
pub use pool::Search;
pub use remains::{RemainingTorque, Remains, SeriesDiscrepancy};
pub use report::{Diagnosis, Step, Suspect};
pub use round::{Round, try_all};
pub use search::{prepared, search};
pub use shown::largest_trace;
pub use thresholds::Thresholds;
pub use validation::{HeldOut, Unseen, mean_fit_percent};
pub use verdict::Verdict;
