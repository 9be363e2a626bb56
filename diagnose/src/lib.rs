//! Which physical effect does a model lack?
//!
//! A file imports only from those above it.
//!
//! | file | job |
//! |---|---|
//! | `thresholds` | the numbers that decide verdicts, and where each comes from |
//! | `economy` | the numbers that only save time |
//! | `remainder` | what a model leaves of every series, in units of its noise |
//! | `candidate` | a model that was tried: plain data |
//! | `remains` | how large that is against noise and signal, and as a torque |
//! | `imperfection` | what the smoothed sign of dry friction alone leaves |
//! | `bench` | what a search works on, and what it keeps of it |
//! | `shown` | whether a sensor would show what one candidate adds to another |
//! | `applicable` | which effects are suspects at all |
//! | `evidence` | how strongly the measurements speak for one model against another |
//! | `score` | the score test: what every suspect promises, and from where it may be fitted |
//! | `trial` | the fits of single effects on top of a candidate |
//! | `round` | one round of trials |
//! | `pool` | what was tried, and what follows from it without another fit: merging, ties, the simplest |
//! | `search` | the search for the set of effects that explains the measurements |
//! | `short_windows` | whether driven logs must be read in short windows |
//! | `thinned` | logs that are read more sparsely than they were recorded |
//! | `path` | the way to the chosen candidate, one effect a step |
//! | `verdict` | the verdict that the findings come to |
//! | `decision` | what is certain, what is taken provisionally, and the verdict |
//! | `steps` | the steps from the model as it was to the last one |
//! | `ranking` | the effects that could be missing, by probability |
//! | `genuine` | how probable an effect is beside something unknown |
//! | `validation` | how well a model predicts an experiment that its fit has not seen |
//! | `next_experiment` | the experiment that would separate explanations which tie |
//! | `report` | steps and suspects, as they are reported |
//! | `diagnosis` | from the logs to the verdict |

mod applicable;
mod bench;
mod candidate;
mod decision;
mod diagnosis;
mod economy;
mod evidence;
mod genuine;
#[cfg(test)]
mod hand_made;
mod imperfection;
mod next_experiment;
mod path;
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
pub use diagnosis::{Options, diagnose_with};
pub use imperfection::{Imperfection, Imperfections, imperfection};
pub use next_experiment::{NextExperiment, Recipe, propose};
pub use pool::Search;
pub use remains::{RemainingTorque, Remains};
pub use report::{Diagnosis, Step, Suspect};
pub use round::{Round, try_all};
pub use search::{prepared, search};
pub use shown::largest_trace;
pub use thresholds::Thresholds;
pub use validation::{HeldOut, Unseen, mean_fit_percent};
pub use verdict::Verdict;
