//! `flywheel design`: other weights, designs side by side, sweeps and exports.

use super::*;

fn model(name: &str) -> String {
    models().join(name).display().to_string()
}

/// The weights of the thesis, said on the command line for another model, as excursions and as weights, are one design;
/// the model's file stays as it is.
#[test]
fn weights_and_excursions_on_the_command_line() {
    let out = tempfile::tempdir().expect("a folder");
    let out = out.path().display().to_string();
    let of = |more: &[&str]| {
        let mut arguments = vec![
            "design".to_owned(),
            model("thesis-3.5.3.toml"),
            "--out".to_owned(),
            out.clone(),
        ];
        arguments.extend(more.iter().map(|one| (*one).to_owned()));
        arguments.extend(["--json".to_owned(), "-".to_owned()]);
        json_of(arguments)
    };
    let weights = of(&["--weights", "25,0.5,0.0005,4"]);
    assert_eq!(weights["current_weight"], 4.0);
    let excursions = of(&[
        "--excursions",
        "0.2,1.4142135623730951,44.72135954999579,0.5",
    ]);
    for index in 0..3 {
        let gain = |of: &Value| of["gains"][index].as_f64().expect("a gain");
        assert!((gain(&weights) / gain(&excursions) - 1.0).abs() < 1e-9);
    }
    let late = of(&["--delay", "0.005"]);
    let margin = |of: &Value| {
        of["expectations"]["margins"]["delay_margin_s"]
            .as_f64()
            .expect("a margin")
    };
    let stored = of(&[]);
    assert!((margin(&stored) - margin(&late) - 0.005).abs() < 1e-7);
}

#[test]
fn side_by_side_with_a_sweep_and_exports() {
    let out = tempfile::tempdir().expect("a folder");
    let text = done([
        "design",
        &model("thesis-4.4.toml"),
        "--out",
        &out.path().display().to_string(),
        "--sweep",
        "current-weight=0.1:10:5",
        "--export",
        "python,matlab",
        "--compare",
        &model("thesis-3.5.3.toml"),
    ]);
    for part in [
        "What the loop does",
        "Other sample times",
        "Side by side",
        "Over the current weight",
        "recovers from",
        "sweep-current-weight.csv",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    for name in [
        "step-response.svg",
        "bode.svg",
        "nyquist.svg",
        "compare-bode.svg",
        "compare-poles.svg",
        "sweep-current-weight.svg",
        "model_thesis_4_4.py",
        "model_thesis_4_4.m",
    ] {
        assert!(out.path().join(name).is_file(), "{name}");
    }
    // A dearer current makes smaller gains: the first column of gains falls from row to row in size.
    let table = fs::read_to_string(out.path().join("sweep-current-weight.csv")).expect("a table");
    let gains: Vec<f64> = table
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .nth(3)
                .and_then(|cell| cell.parse::<f64>().ok())
                .expect("a gain")
                .abs()
        })
        .collect();
    assert!(
        gains.len() == 5 && gains.windows(2).all(|pair| pair[1] < pair[0]),
        "{gains:?}"
    );
}

#[test]
fn slips_on_the_command_line_are_named() {
    let model = model("thesis-4.4.toml");
    for (more, parts) in [
        (
            vec!["--weights", "1,2,3"],
            vec!["3 numbers are given, and four are needed"],
        ),
        (vec!["--weights", "1,2,x,4"], vec!["\"x\" is no number"]),
        (
            vec!["--sweep", "mass=1:2:3"],
            vec!["\"mass\" is none of angle-weight"],
        ),
        (vec!["--sweep", "delay=2:1:3"], vec!["FROM < TO"]),
        (
            vec!["--excursions", "0,1,1,1"],
            vec!["--excursions", "greater than zero"],
        ),
        (
            vec!["--export", "fortran"],
            vec!["python or matlab is needed"],
        ),
        (
            vec!["--compare", "/nowhere/model.toml"],
            vec!["/nowhere/model.toml"],
        ),
    ] {
        let mut arguments = vec!["design", model.as_str()];
        arguments.extend(more);
        refused(arguments, &parts);
    }
}
