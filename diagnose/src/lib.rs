//! Which physical effect does a model lack?
//!
//! | file | job |
//! |---|---|
//! | `candidate` | a model that was tried |
//! | `suspects` | the score test of every effect, and the refit of those that promise something |
//! | `evidence` | how strongly the measurements speak for one model against another |
//! | `search` | the search for the set of effects that explains the measurements |

mod candidate;
mod evidence;
mod search;
mod suspects;

pub use candidate::Candidate;
pub use evidence::{DECISIVE, TIE, effective, log_evidence, residual};
pub use search::{
    REMAINS, Search, largest_remainder, largest_trace, names, noise, remainders, search,
};
pub use suspects::{applicable, try_all, without};
