//! Damaged folders that a whole `prove DIR` must not let pass: each is a copy of the committed one, changed on disk
//! in a way of Rust or of Cargo that has a meaning of its own.
//!
//! The digests of the audited texts, which would notice every change of a source, are switched off: another row has
//! to notice it. Only a harness, which Kani reads alone, is left to them.

use std::fs;

use checker::prove::{ProofVerdict, prove, verdict};
use checker::{ClaimOutcome, ProofSettings};

use crate::folders::copied;

/// One change of a file.
enum Change {
    /// The file's first `from` becomes `to`.
    Replaced(&'static str, &'static str, &'static str),
    /// A file, with its folder.
    Written(&'static str, &'static str),
}

use Change::{Replaced, Written};

struct Attack {
    what: &'static str,
    changes: &'static [Change],
    /// The row that fails, or what the error says.
    noticed: &'static str,
}

const LINE: &str = "src/line.rs";
const MANIFEST: &str = "Cargo.toml";

const ATTACKS: &[Attack] = &[
    Attack {
        what: "a constant function turns the slope round at compile time",
        changes: &[
            Replaced(
                LINE,
                "word as i64 * line.scale as i64",
                "word as i64 * SIGN * line.scale as i64",
            ),
            Replaced(
                LINE,
                "/// The value of the line",
                "const fn sign(x: i64) -> i64 {\n    if x > 0 { -x } else { x }\n}\nconst SIGN: i64 = sign(1);\n\n/// The value of the line",
            ),
        ],
        noticed: "physical-signs",
    },
    Attack {
        what: "a trait's method takes the place of one of the prelude's",
        changes: &[Replaced(
            LINE,
            "/// The value of the line",
            "trait Clone {\n    fn clone(&self) -> i64;\n}\nimpl Clone for i64 {\n    fn clone(&self) -> i64 {\n        -*self\n    }\n}\n\n/// The value of the line",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a field is found through Deref",
        changes: &[Replaced(
            LINE,
            "/// The value of the line",
            "impl core::ops::Deref for Line {\n    type Target = i32;\n    fn deref(&self) -> &i32 {\n        &self.low\n    }\n}\n\n/// The value of the line",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a type of the crate's own with the methods of one of `fixed`",
        changes: &[Replaced(
            "src/control.rs",
            "pub type Current = fixed::types::I3F29;",
            "#[derive(Clone, Copy, Debug, PartialEq, Eq)]\npub struct Current(i32);\nimpl Current {\n    pub const fn from_bits(bits: i32) -> Current {\n        Current(-bits)\n    }\n    pub const fn to_bits(self) -> i32 {\n        self.0\n    }\n}",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a function that is generic over a constant",
        changes: &[
            Replaced(
                LINE,
                "word as i64 * line.scale as i64",
                "turned::<-1>(word) * line.scale as i64",
            ),
            Replaced(
                LINE,
                "/// The value of the line",
                "fn turned<const S: i64>(word: i32) -> i64 {\n    word as i64 * S\n}\n\n/// The value of the line",
            ),
        ],
        noticed: "source-understood",
    },
    Attack {
        what: "a macro takes the place of assert",
        changes: &[Replaced(
            "src/lib.rs",
            "pub mod",
            "macro_rules! assert {\n    ($($x:tt)*) => {};\n}\npub mod",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a suffix makes a literal another number",
        changes: &[Replaced(
            LINE,
            "line.offset) >> line.shift",
            "line.offset - (0x80_u8 as i8 as i64 * 0x1_0000_0000_i64)) >> line.shift",
        )],
        noticed: "supervisor",
    },
    Attack {
        what: "an underscore stands in a number of another size",
        changes: &[Replaced(
            "src/bias_observer.rs",
            "0x7fff_ffff",
            "0x7_fff_fff",
        )],
        noticed: "step-total",
    },
    Attack {
        what: "a module lies in another file",
        changes: &[
            Replaced(
                "src/lib.rs",
                "pub mod line;",
                "#[path = \"../line.rs\"]\npub mod line;",
            ),
            Written("line.rs", "pub struct Line;\n"),
        ],
        noticed: "source-understood",
    },
    Attack {
        what: "a file is included",
        changes: &[
            Replaced(
                LINE,
                "/// The value of the line",
                "include!(\"../turned.txt\");\n\n/// The value of the line",
            ),
            Written("turned.txt", "const SIGN: i64 = -1;\n"),
        ],
        noticed: "source-understood",
    },
    Attack {
        what: "a text is included as a number",
        changes: &[
            Replaced(
                LINE,
                "word as i64 * line.scale as i64",
                "word as i64 * include!(\"../turned.txt\") * line.scale as i64",
            ),
            Written("turned.txt", "-1\n"),
        ],
        noticed: "source-understood",
    },
    Attack {
        what: "a build script under another name",
        changes: &[
            Replaced(
                MANIFEST,
                "publish = false",
                "publish = false\nbuild = \"src.txt\"",
            ),
            Written(
                "src.txt",
                "fn main() { println!(\"cargo:rustc-cfg=kani\"); }\n",
            ),
        ],
        noticed: "source-understood",
    },
    Attack {
        what: "another `fixed` by a patch",
        changes: &[Replaced(
            MANIFEST,
            "[lints.rust]",
            "[patch.crates-io]\nfixed = { path = \"other\" }\n\n[lints.rust]",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "another `fixed` by its package",
        changes: &[Replaced(
            MANIFEST,
            "fixed = { version",
            "fixed = { package = \"half\", version",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "another `fixed` by a configuration of Cargo",
        changes: &[Written(
            ".cargo/config.toml",
            "[source.crates-io]\nreplace-with = \"other\"\n",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a library that is linked",
        changes: &[Replaced(
            MANIFEST,
            "publish = false",
            "publish = false\nlinks = \"control\"",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a symbol that others call",
        changes: &[Replaced(
            LINE,
            "/// The value of the line",
            "/// Copies nothing.\n#[unsafe(no_mangle)]\npub extern \"C\" fn memcpy(to: i32, from: i32, count: i32) -> i32 {\n    to\n}\n\n/// The value of the line",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a profile without checks of overflow",
        changes: &[Replaced(
            MANIFEST,
            "[lints.rust]",
            "[profile.dev]\noverflow-checks = false\n\n[lints.rust]",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a library at another path",
        changes: &[
            Replaced(
                MANIFEST,
                "[dependencies]",
                "[lib]\npath = \"other.rs\"\n\n[dependencies]",
            ),
            Written("other.rs", "#![no_std]\n"),
        ],
        noticed: "source-understood",
    },
    Attack {
        what: "a comment of documentation that ends early for who does not see it",
        changes: &[Replaced(
            LINE,
            "/// Slope times 2^shift, at most 2³⁰.",
            "/// Slope \u{2067}times 2^shift, at most 2³⁰.\u{2069}",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "documentation as an attribute that is read from a file",
        changes: &[Replaced(
            LINE,
            "/// Slope times 2^shift, at most 2³⁰.",
            "#[doc = include_str!(\"../README.md\")]",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a carriage return hides a line of code in a comment",
        changes: &[Replaced(
            LINE,
            "/// The value of the line",
            "// \rpub const X: i32 = 1;\n/// The value of the line",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a crate renames `fixed` at its root",
        changes: &[Replaced(
            "src/lib.rs",
            "pub mod",
            "extern crate fixed as core;\npub mod",
        )],
        noticed: "source-understood",
    },
    Attack {
        what: "a name in the certificate twice",
        changes: &[Replaced(
            "certificate.json",
            "\"sample_time_s\": \"0.001\",",
            "\"sample_time_s\": \"0.001\",\n  \"sample_time_s\": \"0.002\",",
        )],
        noticed: "duplicate field",
    },
    Attack {
        what: "a harness that proves nothing",
        changes: &[Replaced(
            "verify/src/proofs.rs",
            "fn control_total() {",
            "fn control_total() {\n    return;",
        )],
        noticed: "texts-audited",
    },
];

/// The rows that fail, or the error, of a folder with these changes.
fn noticed(changes: &[Change], audited_texts: bool) -> Result<Vec<String>, String> {
    let folder = copied("../generated");
    for change in changes {
        match change {
            Replaced(file, from, to) => {
                let path = folder.path().join(file);
                let text = fs::read_to_string(&path).unwrap();
                assert!(text.contains(from), "{file} has no `{from}`");
                fs::write(&path, text.replacen(from, to, 1)).unwrap();
            }
            Written(file, text) => {
                let path = folder.path().join(file);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(&path, text).unwrap();
            }
        }
    }
    let settings = ProofSettings {
        cases: 300,
        seed: 5,
        audited_texts,
        compiled: false,
        smt: false,
        kani: false,
        closed_loop: false,
        python: false,
        filter_length: false,
        ..ProofSettings::default()
    };
    let rows = prove(folder.path(), None, &settings, &|_| ()).map_err(|error| error.to_string())?;
    for row in &rows {
        if let ClaimOutcome::Failed(why) = &row.outcome {
            println!(
                "    {} by {}: {}",
                row.id,
                row.engine,
                why.lines().next().unwrap_or("")
            );
        }
    }
    match verdict(&rows) {
        ProofVerdict::Fails(claims) => Ok(claims),
        ProofVerdict::Holds | ProofVerdict::Unsettled(_) => Ok(Vec::new()),
    }
}

#[test]
fn no_damaged_folder_passes() {
    let mut missed = Vec::new();
    for attack in ATTACKS {
        println!("{}", attack.what);
        let is_noticed = match noticed(attack.changes, attack.noticed == "texts-audited") {
            Ok(claims) => claims.iter().any(|claim| claim == attack.noticed),
            Err(why) => {
                println!("    {why}");
                why.contains(attack.noticed)
            }
        };
        if !is_noticed {
            missed.push(attack.what);
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

/// What changes nothing that is computed is no claim's matter but that of the audited texts.
#[test]
fn what_changes_no_word_is_left_to_the_digests() {
    let changes = [Replaced(
        LINE,
        "#[inline]\npub fn on_line",
        "#[inline(never)]\npub fn on_line",
    )];
    assert_eq!(noticed(&changes, false), Ok(Vec::new()));
    assert_eq!(
        noticed(&changes, true),
        Ok(vec!["texts-audited".to_owned()])
    );
}
