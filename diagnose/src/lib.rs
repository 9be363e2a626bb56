//! Which physical effect does a model lack?
//!
//! | file | job |
//! |---|---|
//! | `candidate` | a model that was tried |
//! | `suspects` | the score test of every effect, and the refit of those that promise something |
//! | `imperfection` | what the smoothed sign of dry friction alone leaves |
//! | `evidence` | how strongly the measurements speak for one model against another |
//! | `search` | the search for the set of effects that explains the measurements |
//! | `validation` | how well a model predicts an experiment that its fit has not seen |
//! | `next_experiment` | the experiment that would separate explanations which tie |
//! | `hidden_cogging` | whether driven logs must be read in short windows |
//! | `genuine` | how probable an effect is beside something unknown |
//! | `diagnosis` | the verdict, and what it rests on |
//! | `exam/` | benches with a hidden effect, and how the verdicts on them are marked |

mod candidate;
mod diagnosis;
mod evidence;
pub mod exam;
mod genuine;
mod hidden_cogging;
mod imperfection;
mod next_experiment;
mod search;
mod suspects;
mod validation;

pub use candidate::Candidate;
pub use diagnosis::{Diagnosis, Options, Step, Suspect, Verdict, diagnose, diagnose_with};
pub use evidence::{TIE, effective, log_evidence, residual};
pub use imperfection::Imperfection;
pub use next_experiment::propose;
pub use search::{
    LEAST_TRACE, LEAST_TRACE_BESIDE, REMAINS, Search, largest_remainder, largest_trace, names,
    noise, prepared, remainders, search, shows,
};
pub use suspects::{Bench, Round, applicable, try_all, without};
pub use validation::{HeldOut, held_out, mean_fit_percent};
