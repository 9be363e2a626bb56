//! Effects that users write: read, refused with their place, kept in a model that stands alone.

use std::path::Path;

use bench_files::{Bench, ModelFile, OwnEffect};
use plant::{EffectId, Instant, Smoothing};

use crate::common::{Folder, csv, one};

const MAGNET: &str = "role = \"body\"
torque = \"a*z*exp(-z^2)\"
z = \"(angle - centre)/width\"
fingerprint = \"a bump in the torque at one angle\"
[parameters.centre]
unit = \"rad\"
start = [0.1, 0.2]
bounds = [-1.0, 1.0]
[parameters.a]
unit = \"N m\"
start = 1e-3
[parameters.width]
unit = \"rad\"
start = 0.05
bounds = [0.01, 1.0]
";

fn load(effect: &str) -> Result<Vec<OwnEffect>, String> {
    let folder = Folder::bench(
        &one("free-swing", ""),
        &csv("time_s,angle_rad", 8, |i| format!("{i},0.1")),
    );
    std::fs::create_dir(folder.path().join("effects")).expect("a folder");
    folder.write("effects/magnet.toml", effect.as_bytes());
    let bench = Bench::load(folder.path()).map_err(|error| error.to_string())?;
    Ok(bench.own_effects)
}

fn at(angle_rad: f64) -> Instant<f64> {
    Instant {
        angle_rad,
        rate_rad_s: 0.3,
        wheel_angle_rad: 0.0,
        wheel_speed_rad_s: 0.0,
        current_a: 0.0,
        memory: 0.0,
    }
}

#[test]
fn the_torque_is_that_of_the_formula_against_the_motion() {
    let own = load(MAGNET).expect("an effect");
    let effect = own[0].effect;
    let info = effect.info();
    assert_eq!(info.name, "own:magnet");
    // The amplitude comes first, whatever the order of the file.
    let names: Vec<&str> = info.parameters.iter().map(|one| one.name).collect();
    assert_eq!(names, ["magnet_a", "magnet_centre", "magnet_width"]);
    assert_eq!(info.starts, [[1e-3, 0.1, 0.05], [1e-3, 0.2, 0.05]]);
    assert_eq!(info.absent, Some(&[0.0, 0.1, 0.05][..]));
    let z = (0.17 - 0.15) / 0.04_f64;
    let torque = effect.torque(&[2e-3, 0.15, 0.04], &at(0.17), &Smoothing::SIMULATION);
    assert!(
        (torque + 2e-3 * z * (-z * z).exp()).abs() < 1e-15,
        "{torque}"
    );
}

/// Friction of a gear: it grows with the torque that the gear carries.
#[test]
fn a_torque_may_look_at_the_current() {
    let own = load(
        "role = \"wheel\"
torque = \"-c*abs(current)*sign(wheel_speed)\"
[parameters.c]
unit = \"N m/A\"
start = 1e-3
",
    );
    let effect = own.expect("an effect")[0].effect;
    let instant = Instant {
        wheel_speed_rad_s: 100.0,
        current_a: -0.6,
        ..at(0.0)
    };
    let torque = effect.torque(&[2e-3], &instant, &Smoothing::SIMULATION);
    assert!((torque - 1.2e-3).abs() < 1e-15, "{torque}");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    for (from, to, parts) in [
        (
            "a*z*exp(-z^2)",
            "a*z*exp(-y^2)",
            &["magnet.toml:2:20", "\"y\" is not defined", "angle"][..],
        ),
        (
            "(angle - centre)/width",
            "(angle - centre/width",
            &["magnet.toml:3:27", "closing parenthesis"],
        ),
        (
            "(angle - centre)/width",
            "z + 1",
            &["magnet.toml:3:6", "depends on itself"],
        ),
        (
            "role = \"body\"",
            "role = \"bdy\"",
            &["magnet.toml:1:8", "\"body\""],
        ),
        ("start = 1e-3\n", "", &["magnet.toml", "start"]),
        (
            "start = 0.05",
            "start = 5.0",
            &["magnet.toml:14:9", "between 0.01 and 1"],
        ),
        (
            "[-1.0, 1.0]",
            "[1.0, -1.0]",
            &["magnet.toml:8:10", "below the second"],
        ),
        ("unit = \"N m\"\n", "", &["magnet.toml", "unit"]),
        (
            "z = ",
            "rate = ",
            &["magnet.toml:3", "has a meaning already"],
        ),
    ] {
        assert!(MAGNET.contains(from), "{from}");
        let error = load(&MAGNET.replacen(from, to, 1)).expect_err(to);
        for part in parts {
            assert!(error.contains(part), "{part} is not in: {error}");
        }
    }
}

#[test]
fn a_model_brings_its_own_effects_along() {
    let own = load(MAGNET).expect("an effect").remove(0);
    let mut model = ModelFile::new();
    model.effects.push(own.effect);
    model.own_effects.push(own.clone());
    let names = [
        ("total_inertia", 2e-3),
        ("magnet_a", 1.5e-3),
        ("magnet_centre", 0.12),
        ("magnet_width", 0.06),
    ];
    for (name, value) in names {
        model.set_parameter(bench_files::Parameter {
            name: name.to_owned(),
            value,
            std: None,
            unit: String::new(),
            source: String::new(),
        });
    }
    let text = model.to_toml();
    let again = ModelFile::parse(&text, Path::new("model.toml"))
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(again, model);
    // The same content is the same effect, wherever it was read.
    assert_eq!(again.own_effects, [own]);
    assert_eq!(again.to_toml(), text);
    // Without the effect its definition goes.
    let mut without = again;
    without
        .effects
        .retain(|effect| EffectId::ALL.contains(effect));
    assert!(!without.to_toml().contains("[own"), "{}", without.to_toml());
}
