//! The logs of a rig that nothing here was made for: 20 Hz, a measured current with a bias, drop-outs
//! of the wheel's speed, a controller and masses that are not known.

use bench_files::Bench;
use identify::{FitProblem, Identification, Output, identify};
use plant::Model;

use crate::simulated::data;

/// The experiments of a bench in the rig's own columns.
fn identified(logs: &[(&str, &str, &str)]) -> (FitProblem, Identification) {
    let mut text = String::new();
    for (file, kind, extra) in logs {
        let path = data(&format!("real/{file}"));
        let path = path.canonicalize().expect("a path");
        text.push_str(&format!(
            "[[experiment]]\nname = \"{file}\"\nkind = \"{kind}\"\nfile = \"{}\"\n\
             columns = {{ time = \"t_s\", angle = \"pend_rad\", wheel_speed = \"wheel_rad_s\", \
             current = \"current_A\" }}\ncurrent_meaning = \"measured\"\n{extra}\n",
            path.display()
        ));
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("bench.toml"), text).expect("written");
    let bench = Bench::load(folder.path()).unwrap_or_else(|error| panic!("{error}"));
    let problem = FitProblem::new(&bench).expect("records");
    let found = identify(&problem, &Model::base(), None).expect("a fit");
    for (record, traces) in problem.records.iter().zip(&found.traces) {
        for trace in traces {
            eprintln!(
                "{} {}: rmse {:.3e}, fit {:.1} %",
                record.name,
                trace.output.name(),
                trace.rmse,
                trace.fit_percent
            );
        }
    }
    for statement in &found.statements {
        eprintln!("{statement}");
    }
    (problem, found)
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_balance_log_is_fitted_per_unit_of_inertia_and_its_pushes_are_found() {
    let log = (
        "tud_rwp_balance_LQR_20Hz.csv",
        "balance",
        "offset = { angle = 3.14159265, current = -0.1 }",
    );
    let (problem, found) = identified(&[log]);
    for push in &found.pushes[0] {
        eprintln!("push at {:.2} s: {:.2e}", push.time_s, push.impulse_nms);
    }
    // Six times the resting body is hit; most of what follows is the loop that brings it back, but
    // not all of that can be told.
    let hits = [5.27, 7.13, 16.60, 25.10, 27.19, 28.39];
    for hit in hits {
        let near = |time: f64| (time - hit).abs() < 0.1;
        assert!(
            found.pushes[0].iter().any(|push| near(push.time_s)),
            "{hit}"
        );
    }
    assert!(found.pushes[0].len() < 2 * hits.len());
    assert!(!problem.body_scale_known);
    assert!(found.fit.values.iter().all(|value| value.is_finite()));
    let scale = "per unit of inertia only";
    assert!(found.statements.iter().any(|each| each.contains(scale)));
    // Windows of 0.25 s hold five samples: the start takes most of what they know, and the answer to
    // a push cannot be told from the push, which is said.
    assert!(
        found
            .statements
            .iter()
            .any(|each| each.contains("fit percentage says little"))
    );
    for trace in &found.traces[0] {
        assert!(trace.fit_percent > 0.0, "{}", trace.output.name());
    }
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_driven_logs_are_fitted_together() {
    let offset = "offset = { current = -0.1 }";
    let (problem, found) = identified(&[
        ("tud_rwp_wheel_step_20Hz.csv", "driven", offset),
        ("tud_rwp_wheel_square_20Hz.csv", "driven", offset),
        ("tud_rwp_chirp_20Hz.csv", "driven", offset),
    ]);
    assert!(found.fit.values.iter().all(|value| value.is_finite()));
    // Where the model is worse than the mean, a sentence says so.
    for (record, traces) in problem.records.iter().zip(&found.traces) {
        for trace in traces {
            let place = format!(
                "{}/{}: the model is worse",
                record.name,
                trace.output.name()
            );
            let said = found.statements.iter().any(|each| each.starts_with(&place));
            assert_eq!(said, trace.fit_percent < 0.0, "{place}");
        }
    }
    // The chirp swings the body the most; its period is that of the free pendulum.
    let chirp = found.traces[2]
        .iter()
        .find(|trace| trace.output == Output::Angle)
        .expect("an angle");
    assert!(chirp.rmse.is_finite());
    assert!(problem.coupled);
}
