//! `flywheel demo`: the whole chain on the bench inside the program.

use std::fs;
use std::path::Path;

use super::{done, json_of, parameter};

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
