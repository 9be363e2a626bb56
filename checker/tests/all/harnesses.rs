//! The harness crate that is emitted beside the controller's `src`.

use std::fs;
use std::path::Path;

use checker::claims::texts_audited;
use checker::prove::{ClaimOutcome, Emitted};

use crate::folders::copied;

#[test]
fn a_harness_that_was_changed_is_no_audited_text() {
    let emitted = Emitted::read(Path::new("../generated")).unwrap();
    assert!(emitted.harnesses.len() > 5 && emitted.harness_cargo.is_some());
    let ClaimOutcome::Proved(found) = texts_audited::by_digest(&emitted) else {
        panic!("the committed harnesses are not audited");
    };
    assert!(found.contains("of harnesses"), "{found}");
    // A proof of nothing: the assertion is gone, an assumption is too strong, a harness is left out.
    for (from, to) in [
        (
            "assert!(command <= limit, \"the command is above the limit\");",
            "",
        ),
        (
            "kani::assume(limit >= 1);",
            "kani::assume(limit >= 1 && false);",
        ),
        ("#[kani::proof]\nfn control_total", "fn control_total"),
        // An attribute under a condition takes it away as well.
        (
            "#[kani::proof]\nfn control_total",
            "#[cfg_attr(kani, cfg(not(kani)))]\n#[kani::proof]\nfn control_total",
        ),
    ] {
        let mut damaged = emitted.clone();
        let mut count = 0;
        for (_, text) in &mut damaged.harnesses {
            count += text.matches(from).count();
            *text = text.replace(from, to);
        }
        assert_eq!(count, 1, "{from}");
        assert!(
            matches!(texts_audited::by_digest(&damaged), ClaimOutcome::Failed(_)),
            "{from}"
        );
    }
}

#[test]
fn nothing_else_lies_in_the_harness_crate() {
    let folder = copied("../generated");
    let strays = || Emitted::read(folder.path()).unwrap().strays;
    assert_eq!(strays(), [""; 0]);
    // Cargo's own files are no part of it.
    let at = |name: &str| folder.path().join("verify").join(name);
    fs::write(at("Cargo.lock"), "").unwrap();
    fs::create_dir(at("target")).unwrap();
    assert_eq!(strays(), [""; 0]);
    fs::write(at("build.rs"), "fn main() {}").unwrap();
    fs::create_dir(at(".cargo")).unwrap();
    fs::write(at("src/properties/notes.txt"), "").unwrap();
    assert_eq!(
        strays(),
        [
            "verify/.cargo",
            "verify/build.rs",
            "verify/src/properties/notes.txt"
        ]
    );
    // Without its harness crate the folder is still an emitted crate.
    fs::remove_dir_all(folder.path().join("verify")).unwrap();
    let emitted = Emitted::read(folder.path()).unwrap();
    assert!(emitted.harnesses.is_empty() && emitted.harness_cargo.is_none());
}
