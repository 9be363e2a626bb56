//! Functions of one word that an audit runs on every input.

use crate::claims::filter_exact::second::{
    TWO_PI, arc_tangent, inverse_length, inverse_root, reciprocal, root_seed, wrapped,
};

/// A function of one word, the words that it must return, and the range of its argument.
#[derive(Clone, Copy, Debug)]
pub struct OneWord {
    /// Its file in an emitted crate.
    pub file: &'static str,
    /// Its name.
    pub name: &'static str,
    /// The checker's own statement of it.
    pub wanted: fn(i128) -> i128,
    /// Smallest and largest word that it may be given.
    pub domain: (i32, i32),
    /// Ends to which the statement itself clamps its word first; beyond them it is not computed
    /// again.
    pub clamped: (i32, i32),
}

/// All of them.
pub const ONE_WORD: [OneWord; 8] = {
    const ROOT: (i32, i32) = (0x1000_0000, 0x3fff_ffff);
    const ALL: (i32, i32) = (i32::MIN, i32::MAX);
    const LENGTH: (i32, i32) = (0x0400_0000, 0x3fff_ffff);
    const RATIO: (i32, i32) = (0x2000_0000, 0x4000_0000);
    const TURN: (i32, i32) = (-(TWO_PI as i32), TWO_PI as i32);
    const fn entry(
        file: &'static str,
        name: &'static str,
        wanted: fn(i128) -> i128,
        domain: (i32, i32),
        clamped: (i32, i32),
    ) -> OneWord {
        OneWord {
            file,
            name,
            wanted,
            domain,
            clamped,
        }
    }
    const FILE: &str = "src/root.rs";
    [
        entry(FILE, "seed", root_seed, ROOT, ROOT),
        entry(FILE, "inverse_root_q30", |n| inverse_root(n, 2), ROOT, ROOT),
        entry(
            FILE,
            "coarse_inverse_root_q30",
            |n| inverse_root(n, 1),
            ROOT,
            ROOT,
        ),
        entry(
            FILE,
            "inverse_length",
            |n| inverse_length(n, 2),
            ALL,
            LENGTH,
        ),
        entry(
            FILE,
            "coarse_inverse_length",
            |n| inverse_length(n, 1),
            ALL,
            LENGTH,
        ),
        entry(
            "src/arc_tangent.rs",
            "reciprocal_q29",
            reciprocal,
            RATIO,
            RATIO,
        ),
        entry(
            "src/arc_tangent.rs",
            "arc_tangent_q31",
            arc_tangent,
            (0, i32::MAX),
            (0, i32::MAX),
        ),
        entry("src/pivot_angle.rs", "wrapped", wrapped, TURN, TURN),
    ]
};
