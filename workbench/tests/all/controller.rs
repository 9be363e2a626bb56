//! From a model to a controller.

use std::path::{Path, PathBuf};

use workbench::{ControlDesign, SimulationSettings};

use crate::bench::{session, silent};

fn thesis(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../models")
        .join(name)
}

/// Matrix 4.4 with the weights behind the gains that the thesis prints. Its file has the six digits of
/// the printed matrix.
#[test]
fn the_weights_of_the_thesis_give_its_gains() {
    let design = ControlDesign::read(&thesis("thesis-4.4.toml")).expect("a design");
    let report = design.report().expect("a report");
    let golden = [-24.2672423, -2.12973867, -0.0225875821];
    for (gain, golden) in report.gains.iter().zip(golden) {
        assert!((gain / golden - 1.0).abs() < 1e-5, "{gain} {golden}");
    }
    assert!((report.recovery_angle_rad.to_degrees() - 15.86).abs() < 0.01);
    let usual = session().usual_design();
    assert_eq!(report.state_weights, usual.state_weights);
    assert_eq!(report.current_weight, usual.current_weight);
    assert_eq!(report.sample_time_s, usual.sample_time_s);
}

/// A larger weight of the current makes a gentler loop.
#[test]
fn other_weights_give_another_controller() {
    let mut session = session();
    session.identify(&silent()).expect("a fit");
    let design = session.design().expect("a design");
    let mut wishes = session.usual_design();
    assert_eq!(*design.wishes(), wishes, "the usual one unless asked");
    wishes.current_weight = 4.0;
    let gentler = session.design_for(wishes).expect("a design");
    assert!(gentler.gains()[2].abs() < design.gains()[2].abs());
    assert_eq!(design.name(), "two logs", "named by its bench");
}

#[test]
fn what_is_generated_is_simulated_and_stands() {
    let design = ControlDesign::read(&thesis("thesis-3.5.3.toml")).expect("a design");
    let controller = design.generate(None).expect("a controller");
    let paths: Vec<&str> = controller.files().map(|(path, _)| path).collect();
    assert!(paths.contains(&"src/control.rs"), "{paths:?}");
    assert_eq!(paths.last(), Some(&"certificate.json"));
    let folder = tempfile::tempdir().expect("a folder");
    let changed = controller.write(folder.path()).expect("written");
    assert_eq!(changed.len(), paths.len());
    assert!(
        controller
            .differing(folder.path())
            .expect("read")
            .is_empty()
    );

    let report = design
        .simulate(&SimulationSettings::default(), &silent())
        .expect("a closed loop");
    // On a bench with more gravity than the model says, the motor lifts less.
    let gravity = design.file().parameter("gravity_torque").expect("G").value;
    let heavier = SimulationSettings {
        parameters: &[("gravity_torque", 1.1 * gravity)],
        ..Default::default()
    };
    let heavier = design.simulate(&heavier, &silent()).expect("a closed loop");
    assert!(heavier.recovery.emitted_law_rad < report.recovery.emitted_law_rad);
    assert_eq!(heavier.gains, report.gains);
    assert!(report.runs.iter().all(|run| !run.fell));
    let files = report.files().expect("figures and tables");
    let figures = files.iter().filter(|file| file.is_figure());
    assert!(figures.clone().count() >= report.runs.len());
    for figure in figures {
        assert!(figure.text.contains("</svg>"), "{}", figure.name);
    }
}
