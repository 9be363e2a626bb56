//! Checks an emitted controller without trusting, or sharing code with, its generator.
//!
//! | file | job |
//! |---|---|
//! | [`module`] | an emitted crate: read, resolved, with its constants |
//! | [`language`] | its declarations; what is not in the language is refused |
//! | [`lower`] | function bodies to the one form that everything below reads |
//! | [`program`] | that form |
//! | [`interpret`] | runs a function, finding every overflow |
//! | [`contract`] | ranges that functions promise each other |
//! | [`intervals`] | ranges of every word; contracts by halving the domain |
//! | [`forms`] | words as linear forms of the arguments |
//! | [`polynomial`] | words as polynomials of symbols |
//! | [`exact`], [`enclosure`] | rational numbers; outward-rounded intervals |
//! | [`certificate`] | `certificate.json`, read strictly |
//! | [`claims`] | the claims |
//! | [`consistency`] | the certificate against the source, field by field |
//! | [`hardware`] | the words of sensors and drive against their real numbers |
//! | [`bias_observer`] | the observer of the angle's bias: numbers, words, loop |
//! | [`control_law`] | claims about the control law |
//! | [`filter`] | claims about the attitude filter and the full step |
//! | [`length`] | the length of the filter's quaternion |
//! | [`closed_loop`] | the loop for all time |
//! | [`attraction`] | a region from which the pendulum itself returns |
//! | [`reference`] | the filter's equations in double precision, and random runs against them |
//! | [`smt`] | questions to z3 |
//! | [`document`] | CLAIMS.md |
//! | [`mutate`] | damages the source and shows which engine notices |
//! | [`prove`] | every claim by every engine |
//! | [`words`] | the filter's functions a second time in exact integers, and runs against them |
//! | [`stability`] | sampling, stability, stability over the parameters' region |

#![warn(missing_docs)]

pub mod certificate;
pub mod claims;
pub mod document;
pub mod domains;
pub mod exact;
pub mod language;
pub mod mutate;
pub mod program;
pub mod prove;

pub use domains::machine::{Machine, Trap};
pub use language::module::{Module, ReadError};
pub use program::place::{Place, SourceError};
pub use prove::{ClaimResult, Outcome, ProveError, Settings};
