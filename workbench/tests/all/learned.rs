//! Learned curves and own effects in a session: they do not change the verdict, they lower the error, and model.toml
//! contains all that defines them.

use std::path::Path;

use workbench::{
    ControlDesign, Coordinate, FilesInMemory, ModelFile, PerSeries, Session, TorquePart, Verdict,
    check_own_effect,
};

use crate::bench::silent;
use crate::magnet;

const OWN: &str = "role = \"body\"
torque = \"a*z*exp(-z^2)\"
z = \"(angle - centre)/width\"
[parameters.a]
unit = \"N m\"
start = 1e-3
[parameters.centre]
unit = \"rad\"
start = 0.0
bounds = [-0.6, 0.6]
[parameters.width]
unit = \"rad\"
start = 0.1
bounds = [0.01, 0.5]
";

fn session(more: &[(&'static str, String)]) -> Session {
    session_of(magnet::files(), more)
}

fn session_of(files: Vec<(&'static str, String)>, more: &[(&'static str, String)]) -> Session {
    let all = files.iter().chain(more);
    let files: FilesInMemory = all.map(|(name, text)| (*name, text.as_str())).collect();
    Session::from_files(&files).expect("a bench")
}

/// The largest root mean square error in units of its sensor's noise (1.2 mrad and 4 mrad/s).
fn worst(rmse: &PerSeries) -> f64 {
    let ratios = rmse.iter().map(|(series, rmse)| match series.channel {
        workbench::Output::Angle => rmse / 1.2e-3,
        _ => rmse / 4e-3,
    });
    ratios.fold(0.0, f64::max)
}

#[test]
fn a_learned_curve_lowers_the_error_and_explains_nothing() {
    let mut session = session(&[]);
    session.identify(&silent()).expect("a fit");
    let found = session.diagnose(&silent()).expect("a diagnosis");
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.sentence);
    let missing = found.missing_torque.as_ref().expect("a curve");
    assert_eq!(missing.coordinate, "angle");
    assert!(
        found.sentence.contains("This learned curve can be added"),
        "{}",
        found.sentence
    );
    // The curve is the torque of the magnet, up to the part of it that a changed gravity torque follows.
    let far: Vec<f64> = missing
        .points
        .iter()
        .filter(|point| (0.05..0.3).contains(&point.at))
        .map(|point| point.torque - magnet::torque(point.at))
        .collect();
    let off = far.iter().fold(0.0, |most: f64, one| most.max(one.abs()));
    assert!(off < 6e-4, "{off}");
    let names: Vec<String> = found
        .drawings()
        .expect("figures")
        .into_iter()
        .map(|file| file.name)
        .collect();
    assert!(
        names.contains(&"missing-torque.svg".to_owned()),
        "{names:?}"
    );

    let change = session.add_learned("angle", &silent()).expect("a curve");
    let (before, after) = (worst(&change.rmse_before), worst(&change.after.rmse));
    println!("{before:.2} -> {after:.2}");
    assert!(before > 5.0 && after < 1.5, "{before} -> {after}");
    assert!(change.after.effects.contains(&"learned-angle".to_owned()));
    assert!(!has_left(&change.after.statements));

    // The model that is written and read again makes the same predictions.
    let text = session.model().expect("a model").to_toml();
    assert!(
        text.contains("[learned.angle]") && !text.contains("learned_angle_1"),
        "{text}"
    );
    let read = ModelFile::parse(&text, Path::new("model.toml")).expect("a model");
    session.set_model(read.clone());
    let compared = session.compare(&silent()).expect("a comparison");
    let again = worst(&compared.rmse);
    assert!((again / after - 1.0).abs() < 1e-3, "{after} {again}");

    // No log shows the curve upright: the controller is designed without it.
    assert_eq!(
        curve_slopes(&read),
        ["learned-angle: included with slope zero, because no log shows it upright"]
    );

    // A second diagnosis has the same verdict, and the curve is no suspect.
    let found = session.diagnose(&silent()).expect("a diagnosis");
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.sentence);
    assert!(
        found
            .suspects
            .iter()
            .all(|one| !one.effect.starts_with("learned"))
    );
    assert!(
        found
            .last_model
            .effects
            .contains(&"learned-angle".to_owned())
    );
    assert!(worst(&found.last_model.rmse) < 1.5);

    let change = session
        .remove_learned("angle", &silent())
        .expect("no curve");
    assert!(worst(&change.after.rmse) > 5.0);
    assert!(
        !session
            .model()
            .expect("a model")
            .to_toml()
            .contains("learned")
    );
}

/// Whether a statement says that the curve left something.
fn has_left(statements: &[String]) -> bool {
    statements.iter().any(|one| one.contains("knots"))
}

/// A ripple with a period of 0.06 rad: the swing of 52 degrees has a knot every 0.08 rad at best.
#[test]
fn a_torque_finer_than_the_knots_is_said_to_be() {
    let ripple = |angle: f64| 4e-3 * (std::f64::consts::TAU * angle / 0.06).sin();
    let mut session = session_of(magnet::files_of(ripple, 0.0), &[]);
    session.identify(&silent()).expect("a fit");
    let change = session.add_learned("angle", &silent()).expect("a curve");
    println!("{:?}", change.after.statements);
    assert!(worst(&change.after.rmse) > 1.5);
    assert!(has_left(&change.after.statements));
}

fn curve_slopes(file: &ModelFile) -> Vec<String> {
    let mut file = file.clone();
    // The swings show nothing of the wheel; its parameters are taken from the thesis.
    for (name, value) in [
        ("wheel_inertia", 1.36e-4),
        ("torque_constant", 0.0335),
        ("wheel_viscous_friction", 1.75e-5),
    ] {
        file.set_parameter(workbench::Parameter {
            name: name.to_owned(),
            value,
            std: None,
            unit: String::new(),
            source: String::new(),
        });
    }
    let design = ControlDesign::of(file).expect("a controller");
    design.upright_notes()
}

#[test]
fn an_effect_of_ones_own_explains_the_magnet() {
    let mut session = session(&[("effects/magnet.toml", OWN.to_owned())]);
    session.identify(&silent()).expect("a fit");
    let change = session
        .add_effect("own:magnet", &silent())
        .expect("an effect");
    let after = worst(&change.after.rmse);
    assert!(after < 1.1, "{after}");
    let file = session.model().expect("a model").clone();
    let centre = file.parameter("magnet_centre").expect("a centre").value;
    assert!((centre - 0.15).abs() < 2e-3, "{centre}");
    // The torque upright is a guess, which the model states.
    assert!(file.to_toml().contains("unseen_upright = [\"own:magnet\"]"));
    assert_eq!(
        curve_slopes(&file),
        ["own:magnet: included with slope zero, because no log shows it upright"]
    );
}

/// A magnet beside dry friction, with start values far from the magnet: the missing torque shows its position.
#[test]
fn the_diagnosis_finds_an_effect_of_ones_own_beside_another() {
    let files = magnet::files_with_dry_friction(3e-4);
    let mut session = session_of(files, &[("effects/magnet.toml", OWN.to_owned())]);
    session.identify(&silent()).expect("a fit");
    let found = session.diagnose(&silent()).expect("a diagnosis");
    assert_eq!(found.verdict, Verdict::Explained, "{}", found.sentence);
    let effects = &found.last_model.effects;
    for effect in ["body-coulomb-friction", "own:magnet"] {
        assert!(effects.iter().any(|one| one == effect), "{effects:?}");
    }
    assert!(worst(&found.last_model.rmse) < 1.1);
    let parameters = found.last_model.parameters.iter();
    for parameter in parameters {
        let truth = match parameter.name.as_str() {
            "magnet_a" => 0.006,
            "magnet_centre" => 0.15,
            "magnet_width" => 0.06,
            "body_coulomb_torque" => 3e-4,
            _ => continue,
        };
        let std = parameter.std.expect("a standard error");
        let off = (parameter.value - truth).abs();
        assert!(off < 4.0 * std, "{}: {off} for {std}", parameter.name);
    }
}

/// The fingerprint of the magnet. Without the effect, the model lacks the magnet's torque over the angle, the same in
/// both directions of the motion. With the effect, nothing is missing there.
#[test]
fn the_fingerprint_of_a_magnet_is_a_torque_over_the_angle() {
    let mut session = session(&[("effects/magnet.toml", OWN.to_owned())]);
    session.identify(&silent()).expect("a fit");
    let found = session
        .fingerprint("own:magnet", &silent())
        .expect("a fingerprint");
    let torques = found.torques();
    let first = torques.first().expect("it shows");
    assert_eq!(first.coordinate, Coordinate::Angle);
    assert_eq!(first.part, TorquePart::Mean);
    let largest = |points: &[[f64; 3]]| {
        let sizes = points.iter().map(|point| point[1].abs());
        sizes.fold(0.0, f64::max)
    };
    // The curve's own extremes are ±0.006 e^(−½)/√2 = ±2.57e-3 N m.
    let (without, with) = (largest(&first.without), largest(&first.with));
    assert!((1.5e-3..3.5e-3).contains(&without), "{without}");
    assert!(with < 0.25 * without, "{with} of {without}");
}

#[test]
fn the_text_of_an_effect_is_checked_with_line_and_column() {
    assert_eq!(
        check_own_effect("magnet", OWN).expect("fine"),
        ["a", "centre", "width"]
    );
    let wrong = OWN.replace("a*z*exp", "a*q*exp");
    let error = check_own_effect("magnet", &wrong).expect_err("no q");
    assert_eq!(
        (error.line, error.position),
        (Some(2), Some(13)),
        "{error:?}"
    );
    assert!(check_own_effect("../magnet", OWN).is_err());
}
