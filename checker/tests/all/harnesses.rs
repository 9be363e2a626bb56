//! The harness crate that is emitted beside the controller's `src`.

use std::fs;
use std::path::Path;
use std::process::Command;

use checker::claims::texts_audited;
use checker::prove::kani::write_crates;
use checker::prove::{ClaimOutcome, Emitted};

use crate::folders::copied;

/// A stand-in of Kani's macros: each keeps its item. `stub` says in addition that the two functions have one signature,
/// as Kani demands it.
const MACROS: &str = r#"
use proc_macro::TokenStream;
macro_rules! kept { ($($name:ident)*) => { $(
    #[proc_macro_attribute]
    pub fn $name(_: TokenStream, item: TokenStream) -> TokenStream { item }
)* } }
kept! { proof solver requires ensures }
fn with(checked: String, item: TokenStream) -> TokenStream {
    let mut tokens: TokenStream = format!("const _: fn() = || {{ let _ = [{checked}]; }};").parse().unwrap();
    tokens.extend(item);
    tokens
}
#[proc_macro_attribute]
pub fn stub(two: TokenStream, item: TokenStream) -> TokenStream { with(two.to_string(), item) }
#[proc_macro_attribute]
pub fn stub_verified(one: TokenStream, item: TokenStream) -> TokenStream { with(one.to_string(), item) }
#[proc_macro_attribute]
pub fn proof_for_contract(one: TokenStream, item: TokenStream) -> TokenStream { with(one.to_string(), item) }
"#;

/// A stand-in of Kani's library; nothing of it is run.
const LIBRARY: &str = r#"
pub use kani_macros::*;
pub fn any<T>() -> T { unreachable!() }
pub fn assume(_: bool) {}
#[macro_export]
macro_rules! cover { ($condition:expr, $what:literal) => { let _: (bool, &str) = ($condition, $what); }; }
"#;

/// What `prove` gives to Kani compiles, as a library and under Kani's flag with a stand-in of Kani: every name and
/// type of every harness is right for the crate that it was emitted with.
#[test]
fn what_kani_gets_compiles() {
    let emitted = Emitted::read(Path::new("../generated")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    write_crates(root, &emitted, "1.31").unwrap();
    let run = |command: &mut Command| {
        let output = command.current_dir(root).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{command:?}: {said}");
    };
    run(Command::new("cargo")
        .args([
            "check",
            "--offline",
            "--quiet",
            "--manifest-path",
            "verify/Cargo.toml",
        ])
        .env("CARGO_TARGET_DIR", root.join("target")));

    // Kani sets its flag for its own crates too; others, of which some know it, are left as Cargo has compiled them.
    let checked = root.join("target/debug/deps");
    let entries = fs::read_dir(&checked).unwrap();
    let fixed = entries
        .map(|entry| entry.unwrap().path())
        .find(|path| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            name.starts_with("libfixed-") && name.ends_with(".rmeta")
        })
        .unwrap();
    let rustc = |name: &str, source: &str, arguments: &[&str]| {
        run(Command::new("rustc")
            .args([
                "--edition",
                "2024",
                "--crate-name",
                name,
                source,
                "--out-dir",
                ".",
            ])
            .args(["--check-cfg", "cfg(kani)", "-L", "."])
            .arg("-L")
            .arg(format!("dependency={}", checked.display()))
            .args(arguments));
    };
    fs::write(root.join("kani_macros.rs"), MACROS).unwrap();
    fs::write(root.join("kani.rs"), LIBRARY).unwrap();
    rustc(
        "kani_macros",
        "kani_macros.rs",
        &["--crate-type", "proc-macro", "--extern", "proc_macro"],
    );
    let library = ["--crate-type", "lib", "--emit", "metadata"];
    rustc(
        "kani",
        "kani.rs",
        &[&library[..], &["--extern", "kani_macros"]].concat(),
    );
    let with_kani = [&library[..], &["--extern", "kani", "--cfg", "kani"]].concat();
    let extern_fixed = format!("fixed={}", fixed.display());
    let own = [&with_kani[..], &["--extern", &extern_fixed]].concat();
    rustc("generated", "src/lib.rs", &own);
    let harness = [&with_kani[..], &["--extern", "generated"]].concat();
    rustc("verify", "verify/src/lib.rs", &harness);
}

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
