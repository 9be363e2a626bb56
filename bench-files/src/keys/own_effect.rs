//! The file of an effect of one's own.

use super::{KeySection, NEEDED, key};

/// The file itself.
pub(super) const EFFECT: KeySection = KeySection {
    name: "own",
    heading: "effects/NAME.toml",
    meaning: "An effect in a formula. Every other key is a definition that the torque may use.",
    keys: &[
        key(
            "role",
            "",
            NEEDED,
            "role = \"body\"",
            "on what the torque acts: \"body\" or \"wheel\"",
        ),
        key(
            "torque",
            "N m",
            NEEDED,
            "torque = \"a*z*exp(-z^2)\"",
            "the torque as it acts, positive towards positive angles",
        ),
        key(
            "fingerprint",
            "",
            "none",
            "fingerprint = \"a bump in the torque at one angle\"",
            "what to look for, one sentence",
        ),
        key(
            "parameters",
            "",
            NEEDED,
            "[parameters.a]",
            "the section below, once for each parameter",
        ),
    ],
};

/// A parameter of the formula.
pub(super) const PARAMETERS: KeySection = KeySection {
    name: "own.parameters",
    heading: "[parameters.a]",
    meaning: "A parameter of the formula.",
    keys: &[
        key("unit", "", NEEDED, "unit = \"N m\"", "its SI unit"),
        key(
            "start",
            "`unit`",
            NEEDED,
            "start = [0.1, 0.2]",
            "start values of the fit; several, if one might lead nowhere",
        ),
        key(
            "bounds",
            "`unit`",
            "none",
            "bounds = [-0.5, 0.5]",
            "the allowed range",
        ),
    ],
};
