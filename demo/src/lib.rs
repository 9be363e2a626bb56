//! The bench of `flywheel demo`: a folder as a user would have it, inside the program.
//!
//! The files in `bench/` are simulated by [`make`], with noise from a fixed seed, and committed;
//! `cargo run -p demo --example make` writes them anew, and a test holds them against it. Nothing in
//! them was measured.

#![warn(missing_docs)]

mod make;

pub use make::{COULOMB_TORQUE_NM, make};

/// A file of the bench.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// Its name in the folder.
    pub name: &'static str,
    /// What is in it.
    pub text: String,
}

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../bench/", $name)))),*]
    };
}

/// The bench's files, name and content, as committed.
pub const FILES: [(&str, &str); 9] = files![
    "bench.toml",
    "spin-up-0.2A.csv",
    "spin-up-0.4A.csv",
    "spin-up-0.6A.csv",
    "spin-up-0.4A-reversed.csv",
    "coast-down.csv",
    "free-swing-20deg.csv",
    "free-swing-50deg.csv",
    "balance.csv",
];
