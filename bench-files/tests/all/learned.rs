//! Learned curves in model.toml: read, written, refused with their place.

use std::path::Path;

use bench_files::ModelFile;
use plant::{Instant, Smoothing};

const BASE: &str = "[parameters.total_inertia]
value = 2.3e-3
std = 1e-6
[effects]
present = [\"body-viscous-friction\", \"learned-angle\"]
[learned.angle]
knots = [-0.3, -0.1, 0.0, 0.2]
torque = [0.0, 1e-3, -1e-3, 2e-3]
std = [1e-4, 1e-4, 1e-4, 1e-4]
";

fn read(text: &str) -> Result<ModelFile, String> {
    ModelFile::parse(text, Path::new("model.toml")).map_err(|error| error.to_string())
}

fn torque(file: &ModelFile, angle_rad: f64) -> f64 {
    let effect = file.model().learned().next().expect("a curve");
    let values: Vec<f64> = effect
        .info()
        .parameters
        .iter()
        .map(|info| file.parameter(info.name).expect("a torque").value)
        .collect();
    let at = Instant {
        angle_rad,
        rate_rad_s: 1.0,
        wheel_angle_rad: 2.0,
        wheel_speed_rad_s: 3.0,
        current_a: 0.0,
        memory: 0.0,
    };
    // Torques of the library are against the motion.
    -effect.torque(&values, &at, &Smoothing::SIMULATION)
}

#[test]
fn a_curve_takes_its_values_at_the_knots_and_is_constant_outside() {
    let file = read(BASE).expect("a model");
    for (angle, expected) in [
        (-0.1, 1e-3),
        (0.0, -1e-3),
        (0.2, 2e-3),
        (3.0, 2e-3),
        (-2.0, 0.0),
    ] {
        assert!((torque(&file, angle) - expected).abs() < 1e-15, "{angle}");
    }
}

#[test]
fn what_is_written_reads_the_same() {
    let file = read(BASE).expect("a model");
    let text = file.to_toml();
    assert_eq!(text, BASE);
    assert_eq!(read(&text).expect("a model"), file);
    // It is part of the model whether it is listed or not.
    let unlisted = read(&BASE.replace(", \"learned-angle\"", "")).expect("a model");
    assert_eq!(unlisted.effects, file.effects);
}

#[test]
fn a_curve_that_is_none_is_refused_with_its_place() {
    for (old, new, expected) in [
        ("0.0, 0.2]", "0.0, -0.2]", "model.toml:7:9: knots increase"),
        (
            "1e-3, 2e-3]",
            "1e-3]",
            "model.toml:8:10: there are 4 knots, but 3 values here",
        ),
        ("1e-4, 1e-4]", "-1e-4, 1e-4]", "model.toml:9:7"),
        ("[learned.angle]", "[learned.height]", "model.toml:6:10"),
        ("knots = [-0.3, -0.1, 0.0, 0.2]\n", "", "knots"),
        (
            "knots = [-0.3, -0.1, 0.0, 0.2]",
            "knots = [0.1, 0.2, 0.3]",
            "4 to 24 knots; there are 3",
        ),
    ] {
        let error = read(&BASE.replace(old, new)).expect_err("no curve");
        assert!(error.contains(expected), "{error}");
    }
    let start = BASE.find("[learned").expect("a section");
    let error = read(&BASE[..start]).expect_err("no section");
    assert!(error.contains("needs a section [learned.angle]"), "{error}");
}
