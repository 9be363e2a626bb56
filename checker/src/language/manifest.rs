//! `Cargo.toml` of an emitted crate, and of its harness crate: the only entries that they may have.

use toml_edit::{DocumentMut, Item, TableLike, Value};

/// The entries of the manifest that other modules need.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Manifest {
    /// Name of the package.
    pub name: String,
    /// Version of the crate `fixed` that is asked for, `1.31`.
    pub fixed_version: String,
}

/// Reads a manifest: a package of edition 2024 that depends on nothing but `fixed` of crates.io,
/// version 1, without its default features, runs nothing while it is built, and forbids unsafe code.
///
/// # Errors
/// A sentence that names the first key that is missing or not allowed.
pub fn read(text: &str) -> Result<Manifest, String> {
    let document: DocumentMut = text
        .parse()
        .map_err(|error| format!("Cargo.toml is no TOML: {error}").replace('\n', " "))?;
    let root = document.as_table();
    only(root, "", &["package", "dependencies", "lints"])?;

    let package = table(root, "package")?;
    let texts = ["name", "version", "edition", "description", "license"];
    only(package, "package.", &[&texts[..], &["publish"]].concat())?;
    for key in texts {
        if package.contains_key(key) {
            string(package, "package.", key)?;
        }
    }
    expect(package, "package.", "edition", "2024")?;
    let name = string(package, "package.", "name")?;
    let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_-".contains(c);
    if !name.starts_with(|c: char| c.is_ascii_lowercase()) || !name.chars().all(is_name) {
        return Err(format!(
            "Cargo.toml: package.name is `{name}`, which is no plain name"
        ));
    }
    if package
        .get("publish")
        .is_some_and(|item| item.as_bool() != Some(false))
    {
        return Err("Cargo.toml: package.publish is not false".to_owned());
    }

    let dependencies = table(root, "dependencies")?;
    only(dependencies, "dependencies.", &["fixed"])?;
    let fixed = table(dependencies, "fixed")?;
    only(
        fixed,
        "dependencies.fixed.",
        &["version", "default-features"],
    )?;
    let version = string(fixed, "dependencies.fixed.", "version")?;
    let is_one = version.strip_prefix("1.").is_some_and(|rest| {
        !rest.is_empty() && rest.chars().all(|c| c.is_ascii_digit() || c == '.')
    });
    if !is_one {
        return Err(format!(
            "Cargo.toml asks for `fixed` {version}, not for a version 1.x"
        ));
    }
    if fixed.get("default-features").and_then(Item::as_bool) != Some(false) {
        return Err("Cargo.toml takes the default features of `fixed`".to_owned());
    }

    check_lints(root)?;
    Ok(Manifest {
        name: name.to_owned(),
        fixed_version: version.to_owned(),
    })
}

/// Unsafe code is forbidden, and no lint is weaker than the emitted one.
fn check_lints(root: &dyn TableLike) -> Result<(), String> {
    let lints = table(root, "lints")?;
    only(lints, "lints.", &["rust"])?;
    let rust = table(lints, "rust")?;
    only(
        rust,
        "lints.rust.",
        &["unsafe_code", "missing_docs", "unexpected_cfgs"],
    )?;
    expect(rust, "lints.rust.", "unsafe_code", "forbid")?;
    if rust.contains_key("missing_docs") {
        expect(rust, "lints.rust.", "missing_docs", "warn")?;
    }
    if rust.contains_key("unexpected_cfgs") {
        let cfgs = table(rust, "unexpected_cfgs")?;
        only(cfgs, "lints.rust.unexpected_cfgs.", &["level", "check-cfg"])?;
        expect(cfgs, "lints.rust.unexpected_cfgs.", "level", "warn")?;
        let list = cfgs.get("check-cfg").and_then(Item::as_array);
        let known = list.map(|list| list.iter().map(Value::as_str).collect::<Vec<_>>());
        if known.as_deref() != Some(&[Some("cfg(kani)")]) {
            return Err("Cargo.toml: check-cfg knows more than cfg(kani)".to_owned());
        }
    }
    Ok(())
}

/// Reads the manifest of the harness crate beside the crate called `name`: a package of edition 2024 that depends on
/// that crate alone, runs nothing while it is built, and forbids unsafe code.
///
/// # Errors
/// A sentence that names the first key that is missing or not allowed.
pub fn read_harness(text: &str, name: &str) -> Result<(), String> {
    let check = || {
        let document: DocumentMut = text
            .parse()
            .map_err(|error| format!("Cargo.toml is no TOML: {error}").replace('\n', " "))?;
        let root = document.as_table();
        only(root, "", &["package", "dependencies", "lints", "workspace"])?;
        let package = table(root, "package")?;
        let texts = ["name", "version", "edition", "description", "license"];
        let others = ["publish", "metadata"];
        only(package, "package.", &[&texts[..], &others].concat())?;
        for key in texts {
            string(package, "package.", key)?;
        }
        expect(package, "package.", "edition", "2024")?;
        check_metadata(package)?;
        let dependencies = table(root, "dependencies")?;
        only(dependencies, "dependencies.", &["generated"])?;
        let generated = table(dependencies, "generated")?;
        let path = "dependencies.generated.";
        only(generated, path, &["path", "package"])?;
        expect(generated, path, "path", "..")?;
        if generated.contains_key("package") || name != "generated" {
            expect(generated, path, "package", name)?;
        }
        check_lints(root)?;
        only(table(root, "workspace")?, "workspace.", &[])
    };
    check().map_err(|why: String| format!("verify/{why}"))
}

/// Kani reads its settings here: the two that the harnesses need, and none that leaves out a check.
fn check_metadata(package: &dyn TableLike) -> Result<(), String> {
    if !package.contains_key("metadata") {
        return Ok(());
    }
    let metadata = table(package, "metadata")?;
    only(metadata, "package.metadata.", &["kani"])?;
    let kani = table(metadata, "kani")?;
    only(kani, "package.metadata.kani.", &["unstable"])?;
    let path = "package.metadata.kani.unstable.";
    let unstable = table(kani, "unstable")?;
    only(unstable, path, &["function-contracts", "stubbing"])
}

/// No keys but these.
fn only(table: &dyn TableLike, path: &str, known: &[&str]) -> Result<(), String> {
    match table.iter().find(|(key, _)| !known.contains(key)) {
        Some((key, _)) => Err(format!("Cargo.toml holds `{path}{key}`")),
        None => Ok(()),
    }
}

fn table<'a>(within: &'a dyn TableLike, key: &str) -> Result<&'a dyn TableLike, String> {
    within
        .get(key)
        .and_then(Item::as_table_like)
        .ok_or_else(|| format!("Cargo.toml has no table `{key}`"))
}

fn string<'a>(within: &'a dyn TableLike, path: &str, key: &str) -> Result<&'a str, String> {
    within
        .get(key)
        .and_then(Item::as_str)
        .ok_or_else(|| format!("Cargo.toml: {path}{key} is no text"))
}

fn expect(within: &dyn TableLike, path: &str, key: &str, wanted: &str) -> Result<(), String> {
    match string(within, path, key)? {
        found if found == wanted => Ok(()),
        found => Err(format!(
            "Cargo.toml: {path}{key} is `{found}`, not `{wanted}`"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::{read, read_harness};

    #[test]
    fn the_harness_crate_depends_on_the_emitted_one_alone() {
        let good = "[package]\nname = \"x-verify\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\
                    description = \"\"\nlicense = \"\"\n[dependencies]\ngenerated = { path = \"..\" }\n\
                    [lints.rust]\nunsafe_code = \"forbid\"\n[workspace]\n";
        read_harness(good, "generated").unwrap();
        assert!(read_harness(good, "other").is_err());
        let renamed = good.replace("\"..\"", "\"..\", package = \"other\"");
        read_harness(&renamed, "other").unwrap();
        let unstable = "[package.metadata.kani.unstable]\nstubbing = true\n[dep";
        read_harness(&good.replace("[dep", unstable), "generated").unwrap();
        for (from, to) in [
            ("[workspace]", ""),
            ("[workspace]", "[workspace]\nmembers = [\"y\"]"),
            ("[workspace]", "[build-dependencies]\n[workspace]"),
            ("\"..\"", "\"../..\""),
            ("[lints", "evil = \"1\"\n[lints"),
            ("forbid", "allow"),
            ("edition", "build = \"evil.rs\"\nedition"),
            (
                "[dep",
                "[package.metadata.kani.flags]\nno-default-checks = true\n[dep",
            ),
            ("[dep", "[package.metadata.other]\n[dep"),
        ] {
            let error = read_harness(&good.replace(from, to), "generated").unwrap_err();
            assert!(error.starts_with("verify/Cargo.toml"), "{to}: {error}");
        }
    }

    #[test]
    fn whatever_cargo_would_obey_is_looked_at() {
        let good = "[package]\nname = \"x\"\nedition = \"2024\"\npublish = false\n[lints.rust]\nunsafe_code = \"forbid\"\n[dependencies]\nfixed = { version = \"1.31\", default-features = false }\n";
        assert_eq!(read(good).unwrap().fixed_version, "1.31");
        for bad in [
            "libm = \"0.2\"",
            "[build-dependencies]",
            "[features]\na = []",
            "[lib]\npath = \"y.rs\"",
            "fixed.git = \"https://example.org\"",
            "[patch.crates-io]\nfixed = { path = \"evil\" }",
            "[profile.release]\noverflow-checks = false",
            "[workspace]",
            "[[bin]]\nname = \"y\"",
            "[target.'cfg(unix)'.dependencies]\nlibm = \"0.2\"",
        ] {
            assert!(read(&format!("{good}{bad}\n")).is_err(), "{bad}");
        }
        for bad in [
            "lib.path = \"evil.rs\"",
            "dependencies.evil = \"1\"",
            "x = \"\"\"\n",
        ] {
            assert!(read(&format!("{bad}\n{good}")).is_err(), "{bad}");
        }
        for (from, to) in [
            ("\"forbid\"", "\"allow\""),
            ("\"2024\"", "\"2018\""),
            ("name =", "build = \"evil.rs\"\nname ="),
            ("unsafe_code", "missing_docs"),
            ("\"1.31\"", "\"2\""),
            ("\"1.31\"", "\"1.31\", package = \"evil\""),
            ("default-features = false", "path = \"../evil\""),
            (
                "default-features = false",
                "default-features = false, features = [\"std\"]",
            ),
            ("{ version = \"1.31\", default-features = false }", "\"1\""),
            ("publish = false", "links = \"x\""),
            ("\"x\"", "\"X y\""),
        ] {
            assert!(read(&good.replace(from, to)).is_err(), "{to}");
        }
    }
}
