//! The properties of the emitted code under proptest, and the claims that they belong to.

mod attitude;
mod certificate;
mod claims;
mod control;
mod modes;
mod supervisor;
