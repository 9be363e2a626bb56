//! Figures with bars and steps, and the files of figures.

use crate::svg::{parse, series_of, stretches, texts};
use figures::*;

#[test]
fn every_kind_survives_having_nothing_to_draw() {
    let figures = [
        overlay(&Overlay::default()).unwrap(),
        series(&Series::default()).unwrap(),
        staircase(&Staircase::default()).unwrap(),
        breakdown(&Breakdown::default()),
        decay(&Decay::default()).unwrap(),
        suspects(&Suspects::default()),
        poles(&Poles::default()),
        reliability(&Reliability::default()),
        confusion(&Confusion::default()).unwrap(),
        sphere(&Sphere::default()),
    ];
    for figure in figures {
        parse(&figure);
    }
}

/// Of sixty series the worst eight have names, and the others lie in one band.
#[test]
fn a_staircase_of_many_names_the_worst() {
    let values: Vec<[f64; 2]> = (0..60)
        .map(|i| [2.0 + f64::from(i), 1.0 + 0.01 * f64::from(i)])
        .collect();
    let names: Vec<String> = (0..60).map(|i| format!("run {i}/angle")).collect();
    let traces: Vec<StaircaseTrace> = values
        .iter()
        .zip(&names)
        .map(|(values, name)| StaircaseTrace {
            name,
            held_out: false,
            rmse_over_floor: values,
        })
        .collect();
    let svg = staircase(&Staircase {
        title: "t",
        steps: &["base model", "+ a"],
        traces: &traces,
        ..Staircase::default()
    })
    .unwrap();
    let document = parse(&svg);
    assert_eq!(series_of(&document, "fit").len(), 8);
    assert_eq!(series_of(&document, "others").len(), 1);
    let texts = texts(&document);
    for (index, name) in names.iter().enumerate() {
        assert_eq!(texts.contains(name), index >= 52, "{name}");
    }
}

#[test]
fn the_staircase_shows_every_experiment_and_its_last_error() {
    let values: Vec<[f64; 3]> = (0..12)
        .map(|i| [50.0 + f64::from(i), f64::NAN, 1.5 + 0.25 * f64::from(i)])
        .collect();
    let names: Vec<String> = (0..12).map(|i| format!("run {i}/angle")).collect();
    let traces: Vec<StaircaseTrace> = values
        .iter()
        .zip(&names)
        .enumerate()
        .map(|(i, (values, name))| StaircaseTrace {
            name,
            held_out: i % 2 == 1,
            rmse_over_floor: values,
        })
        .collect();
    let svg = staircase(&Staircase {
        title: "t",
        steps: &["base model", "+ a", "+ b"],
        traces: &traces,
        ..Staircase::default()
    })
    .unwrap();
    let document = parse(&svg);
    assert_eq!(series_of(&document, "fit").len(), 6);
    assert_eq!(series_of(&document, "held-out").len(), 6);
    let texts = texts(&document);
    for (name, values) in names.iter().zip(&values) {
        assert!(texts.contains(name), "{name}");
        // The first error and the last.
        let ratio = format!("{:.1}× → {:.2}×", values[0], values[2]);
        assert!(texts.contains(&ratio), "{ratio} in {texts:?}");
    }
    // A missing step leaves two single points; no line crosses the gap.
    let first = stretches(&series_of(&document, "fit")[0]);
    assert!(
        first
            .iter()
            .all(|part| part.iter().all(|p| p.0 == part[0].0))
    );
}

#[test]
fn bars_are_as_long_as_their_probability() {
    let suspect = |name, probability| SuspectBar {
        name,
        probability,
        evidence: "",
    };
    let svg = suspects(&Suspects {
        title: "t",
        suspects: &[suspect("a", 0.8), suspect("b", 0.2), suspect("c", 0.0)],
        ..Suspects::default()
    });
    let document = parse(&svg);
    let widths: Vec<f64> = series_of(&document, "suspect")
        .iter()
        .map(|g| {
            let bar = g.descendants().find(|n| n.has_tag_name("rect")).unwrap();
            bar.attribute("width").unwrap().parse().unwrap()
        })
        .collect();
    assert!((widths[0] / widths[1] - 4.0).abs() < 0.01, "{widths:?}");
    assert_eq!(widths[2], 0.0);
}
