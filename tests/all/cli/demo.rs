//! `flywheel demo`: the whole chain on the bench inside the program.

use std::fs;
use std::path::Path;

use super::{done, json_of, parameter};

/// The words of a figure, in their order.
fn words(figure: &Path) -> Vec<String> {
    let svg =
        fs::read_to_string(figure).unwrap_or_else(|error| panic!("{}: {error}", figure.display()));
    let parts = svg.split("</text>");
    let texts = parts.filter_map(|part| part.rsplit_once('>'));
    texts.map(|(_, text)| text.trim().to_owned()).collect()
}

#[test]
fn the_demonstration_finds_its_own_friction_and_emits_the_controller() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().as_os_str();
    let json = json_of([
        "demo".as_ref(),
        "--out".as_ref(),
        out,
        "--json".as_ref(),
        "-".as_ref(),
    ]);

    let diagnosis = &json["diagnosis"];
    assert_eq!(diagnosis["verdict"], "explained");
    let steps = diagnosis["steps"].as_array().expect("steps");
    assert_eq!(steps.len(), 2, "one effect is missing");
    assert_eq!(steps[1]["effect"], "body-coulomb-friction");
    let (torque, std) = parameter(&steps[1], "body_coulomb_torque");
    let std = std.expect("a standard error");
    assert!(
        (torque - 4.0e-4).abs() < 4.0 * std + 4e-7,
        "{torque} ± {std}"
    );
    let rmse = |step: usize| {
        let rmse = &steps[step]["rmse"]["free swing 20 deg/angle"];
        rmse.as_f64().expect("an error")
    };
    assert!(rmse(0) > 10.0 * rmse(1), "the error falls");

    for run in json["closed_loop"]["runs"].as_array().expect("runs") {
        assert_eq!(run["fell"], false, "{run}");
    }
    for figure in json["figures"].as_array().expect("figures") {
        let path = Path::new(figure.as_str().expect("a path"));
        let svg = fs::read_to_string(path).expect("a figure");
        assert!(svg.contains("<svg"), "{}", path.display());
    }
    // The pictures of README and guide are those that a user sees.
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide");
    let figures = folder.path().join("figures");
    for (shown, drawn) in [
        (
            "base-model-free-swing-20-deg.svg",
            "base-model/compare-free-swing-20-deg.svg",
        ),
        ("staircase.svg", "staircase.svg"),
    ] {
        let own = words(&figures.join(drawn));
        assert!(own.len() > 10, "{own:?}");
        assert_eq!(
            words(&guide.join(shown)),
            own,
            "copy {drawn} to docs/guide/{shown}"
        );
    }
    let controller = folder.path().join("controller");
    for file in [
        "Cargo.toml",
        "src/lib.rs",
        "src/control.rs",
        "certificate.json",
    ] {
        assert!(controller.join(file).exists(), "{file}");
    }

    // What the demonstration leaves is a bench like any other.
    let bench = folder.path().join("demo");
    let text = done(["compare".as_ref(), bench.as_os_str()]);
    assert!(text.contains("body-coulomb-friction"), "{text}");
    let model = bench.join("model.toml");
    let text = done([
        "generate".as_ref(),
        model.as_os_str(),
        "--out".as_ref(),
        controller.as_os_str(),
        "--check".as_ref(),
    ]);
    assert!(text.contains("is what the generator emits"), "{text}");
    let again = tempfile::tempdir().expect("a folder");
    done(["demo".as_ref(), "--out".as_ref(), again.path().as_os_str()]);
    let law = |folder: &Path| fs::read_to_string(folder.join("controller/src/control.rs"));
    assert_eq!(
        law(again.path()).expect("the emitted law"),
        law(folder.path()).expect("the emitted law"),
        "the same demonstration writes the same controller"
    );
}
