//! From logs to an emitted crate.

use super::*;

/// From logs to the emitted crate: identify, compare, add, remove, design, generate, --check.
#[test]
fn the_whole_chain() {
    let folder = tempfile::tempdir().expect("folder");
    let bench = folder.path().join("bench");
    fs::create_dir(&bench).expect("folder");
    bench::write(&bench);
    let untouched = contents(&bench);
    let model = folder.path().join("model.toml");
    let out = folder.path().join("figures");
    let (bench, model, out) = (
        bench.to_str().expect("path"),
        model.to_str().expect("path"),
        out.to_str().expect("path"),
    );

    let text = done(["identify", bench, "--model", model, "--out", out]);
    for part in [
        "made here: 3 experiments",
        "total_inertia",
        "±",
        "swing",
        "Written: ",
    ] {
        assert!(text.contains(part), "{part:?} is not in\n{text}");
    }
    let viscous = json_of([
        "compare", bench, "--model", model, "--out", out, "--json", "-",
    ]);
    let rmse = |json: &Value| json["rmse"]["swing/angle"].as_f64().expect("RMSE");
    let noise_rad = (0.2 / 12_f64.sqrt()).to_radians();
    assert!(
        rmse(&viscous) > 5.0 * noise_rad,
        "dry friction is missing: {}",
        rmse(&viscous)
    );
    let place = &viscous["where"][0];
    assert_eq!(place["experiment"], "swing", "{place}");
    assert_eq!(place["significant"], true, "{place}");
    let from = place["from"].as_f64().expect("from");
    assert!(from < place["to"].as_f64().expect("to"), "{place}");
    for name in ["compare-swing.svg", "compare-spin-up-minus-0.5-a.svg"] {
        let svg = fs::read_to_string(Path::new(out).join(name)).expect(name);
        assert!(svg.contains("<svg"), "{name}");
    }

    let dry = json_of([
        "add",
        "body-coulomb-friction",
        "--bench",
        bench,
        "--model",
        model,
        "--json",
        "-",
    ]);
    assert!(
        rmse(&dry) < 1.1 * noise_rad,
        "down to the noise: {}",
        rmse(&dry)
    );
    assert!(dry["rmse_before"]["swing/angle"].as_f64() > Some(5.0 * noise_rad));
    for (name, truth, relative) in [
        ("total_inertia", bench::TOTAL_INERTIA, 0.005),
        ("wheel_inertia", bench::WHEEL_INERTIA, 0.005),
        ("body_coulomb_torque", bench::COULOMB_TORQUE, 0.03),
        ("wheel_viscous_friction", bench::WHEEL_FRICTION, 0.02),
    ] {
        let (value, std) = parameter(&dry, name);
        assert!(
            (value / truth - 1.0).abs() < relative,
            "{name} = {value}, the truth is {truth}"
        );
        assert!(
            std.is_some_and(|std| std > 0.0 && std < 0.1 * truth),
            "{name}: {std:?}"
        );
    }
    assert_eq!(
        parameter(&dry, "gravity_torque"),
        (bench::GRAVITY_TORQUE, None)
    );
    let again = json_of([
        "compare", bench, "--model", model, "--out", out, "--json", "-",
    ]);
    assert!(
        (rmse(&again) / rmse(&dry) - 1.0).abs() < 1e-3,
        "compare shows what was fitted"
    );

    let gone = json_of([
        "remove",
        "body-coulomb-friction",
        "--bench",
        bench,
        "--model",
        model,
        "--json",
        "-",
    ]);
    assert!((rmse(&gone) / rmse(&viscous) - 1.0).abs() < 1e-3);
    done([
        "add",
        "body-coulomb-friction",
        "--bench",
        bench,
        "--model",
        model,
    ]);

    let design = json_of(["design", model, "--out", out, "--json", "-"]);
    assert_eq!(design["controllability_rank"], 3);
    assert_eq!(design["pole_uncertainty"]["correlated"], true);
    let fitted = fs::read_to_string(model).expect("model.toml");
    let dry_and_viscous =
        "\"body_viscous_friction\", \"wheel_viscous_friction\", \"body_coulomb_torque\"]";
    assert!(
        fitted.contains("[correlation]\nparameters = [\"total_inertia\", \"wheel_inertia\", "),
        "{fitted}"
    );
    assert!(fitted.contains(dry_and_viscous), "{fitted}");
    // Without the section the same standard errors count as independent, and the poles say so.
    let (before, after) = fitted.split_once("[correlation]").expect("there");
    let rest = &after[after.find("\n[").expect("another section")..];
    let alone = folder.path().join("independent.toml");
    fs::write(&alone, format!("{before}{rest}")).expect("write");
    let alone = alone.to_str().expect("path");
    let independent = json_of(["design", alone, "--out", out, "--json", "-"]);
    assert_eq!(independent["pole_uncertainty"]["correlated"], false);
    assert_eq!(independent["gains"], design["gains"]);
    assert_ne!(
        independent["pole_uncertainty"]["open_loop_std"],
        design["pole_uncertainty"]["open_loop_std"]
    );
    let crate_folder = folder.path().join("emitted");
    let emitted = crate_folder.to_str().expect("path");
    let generated = json_of(["generate", model, "--out", emitted, "--json", "-"]);
    assert_eq!(generated["gains"], design["gains"]);
    for name in ["Cargo.toml", "src/lib.rs", "certificate.json"] {
        assert!(crate_folder.join(name).is_file(), "{name}");
    }
    done(["generate", model, "--out", emitted, "--check"]);
    // The same in C, in a folder of its own.
    let in_c = folder.path().join("in-c");
    let in_c = in_c.to_str().expect("a path in UTF-8");
    done(["generate", model, "--out", in_c, "--language", "c"]);
    done([
        "generate",
        model,
        "--out",
        in_c,
        "--language",
        "c",
        "--check",
    ]);
    for file in [
        "src/flywheel.h",
        "src/flywheel.c",
        "library.properties",
        "examples/flywheel/flywheel.ino",
    ] {
        assert!(Path::new(in_c).join(file).exists(), "{file}");
    }
    let certificate = fs::read_to_string(Path::new(in_c).join("certificate.json"));
    let certificate: Value =
        serde_json::from_str(&certificate.expect("a certificate")).expect("JSON");
    assert_eq!(certificate["language"], "c");

    // --reset goes back to the base model.
    let reset = json_of([
        "identify", bench, "--reset", "--model", model, "--json", "-",
    ]);

    // Rows and columns in the order of the names, each parameter one with itself.
    let correlation = &reset["correlation"];
    let names = correlation["parameters"].as_array().expect("names");
    assert!(names.len() > 2, "{names:?}");
    for (index, row) in correlation["matrix"]
        .as_array()
        .expect("rows")
        .iter()
        .enumerate()
    {
        assert_eq!(row.as_array().expect("row").len(), names.len());
        assert_eq!(row[index], 1.0);
    }
    assert_eq!(
        reset["effects"],
        serde_json::json!(["body-viscous-friction", "wheel-viscous-friction"])
    );
    assert_eq!(
        contents(Path::new(bench)),
        untouched,
        "the bench's own folder stays as it was"
    );
}

/// `--check` is exit code 1, and changes nothing, as soon as one byte differs.
#[test]
fn check_finds_a_changed_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().to_str().expect("path");
    let model = models().join("thesis-4.4.toml");
    let model = model.to_str().expect("path");
    done(["generate", model, "--out", out]);
    done(["generate", model, "--out", out, "--check"]);
    let file = folder.path().join("src/control.rs");
    let changed = fs::read_to_string(&file)
        .expect("control.rs")
        .replace("HALF", "HALVE");
    fs::write(&file, &changed).expect("write");

    let output = flywheel(["generate", model, "--out", out, "--check"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        stdout(&output).contains("control.rs"),
        "{}",
        stdout(&output)
    );
    assert_eq!(fs::read_to_string(&file).expect("control.rs"), changed);
    done(["generate", model, "--out", out]);
    done(["generate", model, "--out", out, "--check"]);
}

/// Every mutant is in the summary and in the file, most are caught, and the crate stays as it was.
#[test]
fn mutants_of_the_emitted_crate() {
    let generated = Path::new(env!("CARGO_MANIFEST_DIR")).join("generated");
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("mutants.csv");
    let before = contents(&generated.join("src"));
    let json: Value = serde_json::from_slice(
        &flywheel([
            OsStr::new("mutate"),
            generated.as_os_str(),
            OsStr::new("--most"),
            OsStr::new("2"),
            OsStr::new("--csv"),
            csv.as_os_str(),
            OsStr::new("--json"),
            OsStr::new("-"),
        ])
        .stdout,
    )
    .expect("JSON on standard output");
    assert_eq!(
        contents(&generated.join("src")),
        before,
        "nothing is touched"
    );
    let verdicts = json["verdicts"].as_array().unwrap();
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let summary = &json["summary"];
    assert_eq!(number(&summary["mutants"]), verdicts.len());
    let caught = verdicts
        .iter()
        .filter(|verdict| !verdict["noticed"].as_array().unwrap().is_empty())
        .count();
    assert_eq!(number(&summary["caught"]), caught);
    assert!(10 * caught > 9 * verdicts.len(), "{caught}");
    let rows = csv::Reader::from_path(csv).unwrap().records().count();
    assert_eq!(rows, verdicts.len());
    refused(
        [OsStr::new("mutate"), folder.path().as_os_str()],
        &[
            "is no emitted crate",
            "no certificate.json",
            "flywheel generate",
        ],
    );
}

#[test]
fn an_effect_that_is_there_is_not_added_again() {
    let folder = tempfile::tempdir().expect("folder");
    bench::write(folder.path());
    let bench = folder.path().to_str().expect("path");
    refused(
        ["add", "body-viscous-friction", "--bench", bench],
        &["body-viscous-friction is not added", "already"],
    );
    done(["identify", bench]);
    refused(
        ["remove", "wheel-cogging", "--bench", bench],
        &[
            "does not have wheel-cogging",
            "body-viscous-friction, wheel-viscous-friction",
        ],
    );
}
