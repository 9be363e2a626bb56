//! Every claim by every engine.

pub mod kani;
pub mod results;
pub mod run;
pub mod settings;
pub mod settle;

pub use crate::claims::outcome::ClaimOutcome;
pub use crate::language::emitted::Emitted;
pub use crate::language::emitted_error::EmittedError;
pub use results::{ClaimResult, ProofVerdict, passed, verdict};
pub use run::{ProveError, prove};
pub use settings::ProofSettings;
pub use settle::{settle, settle_saying, settle_telling};
