//! Claim `source-understood`: the sources are in the language, and nothing else is built or run with
//! them.

use crate::claims::outcome::ClaimOutcome;
use crate::language::emitted::Emitted;
use crate::language::module::Module;

/// For sources that were read as `module`: what lies beside them, and the manifest.
pub fn by_reading(emitted: &Emitted, module: &Module) -> ClaimOutcome {
    let functions = module.declarations().functions.len();
    ClaimOutcome::proved(
        check_surroundings(emitted)
            .map(|()| format!("{functions} functions in {} files", emitted.sources.len())),
    )
}

/// Nothing is built but the sources, with nothing but `fixed`.
fn check_surroundings(emitted: &Emitted) -> Result<(), String> {
    if let Some(stray) = emitted.strays.first() {
        return Err(format!("{stray} does not belong to an emitted crate"));
    }
    if !emitted.sources.iter().any(|(path, _)| path == "src/lib.rs") {
        return Err("there is no src/lib.rs".to_owned());
    }
    check_cargo(&emitted.cargo)
}

/// The crate depends on nothing but `fixed`, runs nothing while it is built, and forbids unsafe:
/// every line is one of those that an emitted manifest may hold.
fn check_cargo(text: &str) -> Result<(), String> {
    let mut section = "";
    let mut found = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let is_known = match section {
            _ if line.starts_with('[') => {
                section = line;
                ["[package]", "[dependencies]", "[lints.rust]"].contains(&line)
            }
            "[package]" => [
                "name",
                "version",
                "edition",
                "description",
                "license",
                "publish",
            ]
            .iter()
            .any(|key| {
                let rest = line.strip_prefix(key).map(str::trim_start);
                rest.is_some_and(|rest| rest.starts_with('='))
            }),
            "[dependencies]" => is_fixed(line),
            "[lints.rust]" => [
                FORBIDS_UNSAFE,
                "missing_docs = \"warn\"",
                "unexpected_cfgs = { level = \"warn\", check-cfg = ['cfg(kani)'] }",
            ]
            .contains(&line),
            _ => false,
        };
        if !is_known {
            return Err(format!("Cargo.toml holds `{line}`"));
        }
        found.push(line);
    }
    for needed in ["edition = \"2024\"", FORBIDS_UNSAFE] {
        if !found.contains(&needed) {
            return Err(format!("Cargo.toml does not say `{needed}`"));
        }
    }
    Ok(())
}

const FORBIDS_UNSAFE: &str = "unsafe_code = \"forbid\"";

/// `fixed` of crates.io, version 1, without its default features.
fn is_fixed(line: &str) -> bool {
    line.strip_prefix("fixed = { version = \"1.")
        .and_then(|rest| rest.strip_suffix("\", default-features = false }"))
        .is_some_and(|version| version.chars().all(|c| c.is_ascii_digit() || c == '.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependencies_are_looked_at() {
        let good = "[package]\nname = \"x\"\nedition = \"2024\"\n[lints.rust]\nunsafe_code = \"forbid\"\n[dependencies]\nfixed = { version = \"1.31\", default-features = false }\n";
        assert_eq!(check_cargo(good), Ok(()));
        for bad in [
            "libm = \"0.2\"",
            "fixed = { path = \"../evil\", default-features = false }",
            "fixed = { version = \"1.31\", default-features = false, package = \"evil\" }",
            "fixed = { version = \"1.31\", default-features = false, features = [\"std\"] }",
            "[build-dependencies]",
            "[features]",
            "[lib]",
            "fixed = \"1\"",
        ] {
            assert!(check_cargo(&format!("{good}{bad}\n")).is_err(), "{bad}");
        }
        for bad in ["lib.path = \"evil.rs\"", "dependencies.evil = \"1\""] {
            assert!(check_cargo(&format!("{bad}\n{good}")).is_err(), "{bad}");
        }
        for (from, to) in [
            ("\"forbid\"", "\"allow\""),
            ("\"2024\"", "\"2018\""),
            ("name =", "build = \"evil.rs\"\nname ="),
            ("unsafe_code", "missing_docs"),
        ] {
            assert!(check_cargo(&good.replace(from, to)).is_err(), "{to}");
        }
    }
}
