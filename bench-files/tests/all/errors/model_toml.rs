//! Errors of model.toml.

use std::path::Path;

use bench_files::ModelFile;

use super::assert_says;

const PARAMETERS: &str = "[parameters.total_inertia]\nvalue = 2.3e-3\n";

const EFFECTS: &str = "[effects]\npresent = [\"body-viscous-friction\"]\n";

#[test]
fn model_toml() {
    let cases: Vec<(&str, String, &[&str])> = vec![
        (
            "empty",
            String::new(),
            &[
                "model.toml:1:1",
                "lacks \"effects\"",
                "body-viscous-friction",
            ],
        ),
        (
            "no effects",
            PARAMETERS.into(),
            &["model.toml", "lacks \"effects\"", "body-viscous-friction"],
        ),
        (
            "no list of effects",
            format!("{PARAMETERS}[effects]\n"),
            &["model.toml:3:1", "lacks \"present\""],
        ),
        (
            "unknown effect",
            format!("{PARAMETERS}[effects]\npresent = [\"body-coulomb\"]\n"),
            &[
                "model.toml:4:12",
                "unknown effect \"body-coulomb\"",
                "did you mean \"body-coulomb-friction\"",
            ],
        ),
        (
            "an effect twice",
            format!("{PARAMETERS}[effects]\npresent = [\"angle-offset\", \"angle-offset\"]\n"),
            &[
                "model.toml:4:28",
                "\"angle-offset\" cannot be used together with",
                "already",
            ],
        ),
        (
            "an effect and one that contains it",
            format!(
                "{PARAMETERS}[effects]\npresent = [\"body-stribeck-friction\", \"body-coulomb-friction\"]\n"
            ),
            &[
                "model.toml:4:38",
                "\"body-coulomb-friction\" cannot be used together with \"body-stribeck-friction\"",
                "contains the other",
            ],
        ),
        (
            "unknown parameter",
            format!("[parameters.total_inertai]\nvalue = 1.0\n{EFFECTS}"),
            &[
                "model.toml:1:13",
                "unknown parameter \"total_inertai\"",
                "did you mean \"total_inertia\"",
            ],
        ),
        (
            "no value",
            format!("[parameters.total_inertia]\nstd = 1.0\n{EFFECTS}"),
            &[
                "model.toml:1:1",
                "[parameters.total_inertia] lacks \"value\"",
            ],
        ),
        (
            "text for value",
            format!("[parameters.total_inertia]\nvalue = \"1.0\"\n{EFFECTS}"),
            &["model.toml:2:9", "must be a number"],
        ),
        (
            "negative inertia",
            format!("[parameters.total_inertia]\nvalue = -1.0\n{EFFECTS}"),
            &["model.toml:2:9", "\"total_inertia\" is -1", "between"],
        ),
        (
            "negative standard error",
            format!("[parameters.total_inertia]\nvalue = 1e-3\nstd = -1e-6\n{EFFECTS}"),
            &["model.toml:3:7", "\"std\" is -0.000001", "zero or positive"],
        ),
        (
            "another unit",
            format!("[parameters.total_inertia]\nvalue = 23.0\nunit = \"kg cm2\"\n{EFFECTS}"),
            &["model.toml:3:8", "\"kg m2\"", "\"kg cm2\"", "convert"],
        ),
        (
            "a slip in a section's name",
            format!("{PARAMETERS}{EFFECTS}[desing]\nsample_time = 0.001\n"),
            &["model.toml:5:2", "\"desing\"", "did you mean \"design\""],
        ),
        (
            "a slip in the design",
            format!("{PARAMETERS}{EFFECTS}[design]\nsampletime = 0.001\n"),
            &[
                "model.toml:6:1",
                "\"sampletime\" in [design]",
                "did you mean \"sample_time\"",
            ],
        ),
        (
            "design without weights",
            format!("{PARAMETERS}{EFFECTS}[design]\nsample_time = 0.001\n"),
            &[
                "model.toml:5:1",
                "[design] lacks \"state_weights\"",
                "[25.0, 0.5, 5e-4]",
            ],
        ),
        (
            "a negative weight",
            format!(
                "{PARAMETERS}{EFFECTS}[design]\nsample_time = 0.001\nstate_weights = [1, -1, 1]\ncurrent_weight = 1\ncurrent_limit = 2\n"
            ),
            &[
                "model.toml:7:17",
                "\"state_weights\" is -1",
                "zero or positive",
            ],
        ),
        (
            "sample time below zero",
            format!(
                "{PARAMETERS}{EFFECTS}[design]\nsample_time = -1\nstate_weights = [1, 1, 1]\ncurrent_weight = 1\ncurrent_limit = 2\n"
            ),
            &["model.toml:6:15", "\"sample_time\" is -1", "positive"],
        ),
    ];
    for (case, toml, parts) in cases {
        match ModelFile::parse(&toml, Path::new("model.toml")) {
            Ok(_) => panic!("{case}: parsed"),
            Err(error) => assert_says(case, &error, parts),
        }
    }
}

#[test]
fn correlations_that_no_errors_can_have() {
    let section = |parameters: &str, matrix: &str| {
        let mut toml = String::new();
        for name in ["total_inertia", "gravity_torque", "wheel_inertia"] {
            toml.push_str(&format!("[parameters.{name}]\nvalue = 0.1\nstd = 1e-3\n"));
        }
        format!(
            "{toml}[parameters.torque_constant]\nvalue = 0.0335\n{EFFECTS}[correlation]\n\
             parameters = {parameters}\nmatrix = {matrix}\n"
        )
    };
    let two = r#"["total_inertia", "gravity_torque"]"#;
    let three = r#"["total_inertia", "gravity_torque", "wheel_inertia"]"#;
    let cases: [(&str, String, &[&str]); 13] = [
        (
            "unknown name",
            section(r#"["total_inertia", "gravty_torque"]"#, "[[1, 0], [0, 1]]"),
            &[
                "model.toml:15:32",
                "\"gravty_torque\"",
                "did you mean \"gravity_torque\"",
            ],
        ),
        (
            "no standard error",
            section(
                r#"["total_inertia", "torque_constant"]"#,
                "[[1, 0], [0, 1]]",
            ),
            &[
                "model.toml:15:32",
                "unknown parameter with a std \"torque_constant\"",
            ],
        ),
        (
            "a name twice",
            section(r#"["total_inertia", "total_inertia"]"#, "[[1, 0], [0, 1]]"),
            &[
                "model.toml:15:32",
                "\"total_inertia\" is already in this list",
            ],
        ),
        (
            "no names",
            section("[]", "[]"),
            &["model.toml:15:14", "[correlation] lacks \"parameters\""],
        ),
        (
            "no matrix",
            section(two, "[[1, 0], [0, 1]]").replace("matrix = [[1, 0], [0, 1]]\n", ""),
            &["model.toml:14:1", "[correlation] lacks \"matrix\""],
        ),
        (
            "a row too short",
            section(two, "[[1, 0], [1]]"),
            &[
                "model.toml:16:10",
                "2 rows of 2 numbers",
                "a list of 2 values",
            ],
        ),
        (
            "a row too few",
            section(three, "[[1, 0, 0], [0, 1, 0]]"),
            &["model.toml:16:10", "3 rows of 3 numbers"],
        ),
        (
            "not finite",
            section(two, "[[1, nan], [nan, 1]]"),
            &["model.toml:16:10", "finite"],
        ),
        (
            "covariances instead",
            section(two, "[[1e-6, 1e-7], [1e-7, 1e-6]]"),
            &[
                "model.toml:16:12",
                "\"total_inertia with total_inertia\" is 0.000001",
                "must be 1",
            ],
        ),
        (
            "beyond one",
            section(two, "[[1, 1.2], [1.2, 1]]"),
            &[
                "model.toml:16:15",
                "\"total_inertia with gravity_torque\" is 1.2",
                "between -1 and 1",
            ],
        ),
        (
            "not symmetric",
            section(two, "[[1, 0.9], [0.8, 1]]"),
            &[
                "model.toml:16:22",
                "\"gravity_torque with total_inertia\" is 0.8",
                "0.9",
                "symmetric",
            ],
        ),
        (
            // Eigenvalues 1.9, 1.9 and −0.8.
            "each pair possible, not all three",
            section(three, "[[1, 0.9, 0.9], [0.9, 1, -0.9], [0.9, -0.9, 1]]"),
            &[
                "model.toml:16:10",
                "smallest eigenvalue",
                "-0.8",
                "zero or positive",
            ],
        ),
        (
            "a slip in the name",
            section(two, "[[1, 0], [0, 1]]").replace("[correlation]", "[correlations]"),
            &["model.toml:14:2", "did you mean \"correlation\""],
        ),
    ];
    for (case, toml, parts) in cases {
        match ModelFile::parse(&toml, Path::new("model.toml")) {
            Ok(_) => panic!("{case}: parsed"),
            Err(error) => assert_says(case, &error, parts),
        }
    }
    // One of rank one is possible: two parameters that move as one.
    let one = section(two, "[[1, -1], [-1, 1]]");
    assert!(ModelFile::parse(&one, Path::new("model.toml")).is_ok());
}

#[test]
fn a_model_that_lacks_a_parameter_or_the_design() {
    let toml = format!("{PARAMETERS}{EFFECTS}");
    let file = ModelFile::parse(&toml, Path::new("m.toml")).expect("parses");
    let error = file.parameter_vector().expect_err("no wheel inertia");
    assert_says(
        "base",
        &error,
        &[
            "m.toml",
            "[parameters.wheel_inertia]",
            "every model",
            "kg m2",
        ],
    );
    let error = file.require_design().expect_err("no design");
    assert_says(
        "design",
        &error,
        &["m.toml", "lacks \"design\"", "sample_time = 0.001"],
    );

    let mut full = file.clone();
    for name in ["wheel_inertia", "gravity_torque", "torque_constant"] {
        full.set_parameter(bench_files::Parameter {
            name: name.to_string(),
            value: 1e-3,
            std: None,
            unit: String::new(),
            source: String::new(),
        });
    }
    let error = full.parameter_vector().expect_err("no friction");
    assert_says(
        "effect",
        &error,
        &[
            "[parameters.body_viscous_friction]",
            "effect \"body-viscous-friction\"",
            "N m s/rad",
        ],
    );
}
