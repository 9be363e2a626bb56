//! Overlays and panels over time.

use crate::svg::{ANGLE, one_channel, parse, series_of, stretches, texts};
use figures::*;

#[test]
fn a_long_overlay_is_small_and_keeps_its_peak() {
    let samples = 60_000;
    let time: Vec<f64> = (0..samples).map(|i| f64::from(i) * 1e-3).collect();
    let mut measured: Vec<f64> = time.iter().map(|t| (40.0 * t).sin()).collect();
    // One sample out of 60,000 stands out: it must be seen.
    measured[31_234] = 5.0;
    let model: Vec<f64> = time.iter().map(|t| (40.0 * t + 0.1).sin()).collect();
    let channel = OverlayChannel {
        quantity: ANGLE,
        measurement: &measured,
        model: &model,
        sensor_std: 0.01,
        note: "",
    };
    let channels = [channel; 4];
    let svg = overlay(&one_channel(&time, &channels, "long")).unwrap();
    assert!(svg.len() < 400_000, "{} bytes", svg.len());
    let document = parse(&svg);
    for class in ["measurement", "model", "residual"] {
        assert_eq!(series_of(&document, class).len(), 4, "{class}");
    }
    let points: Vec<(f64, f64)> = stretches(&series_of(&document, "measurement")[0]).concat();
    let top = points.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let sine_top: Vec<f64> = stretches(&series_of(&document, "model")[0])
        .concat()
        .iter()
        .map(|p| p.1)
        .collect();
    let bottom = sine_top.iter().copied().fold(0.0, f64::max);
    let sine_top = sine_top.into_iter().fold(f64::INFINITY, f64::min);
    // The peak is 5 and the sine ±1, so the peak is four half heights above.
    let half = (bottom - sine_top) / 2.0;
    assert!(((sine_top - top) / half - 4.0).abs() < 0.05);
    assert!(
        texts(&document)
            .iter()
            .any(|t| t.contains("no peak is lost"))
    );
}

#[test]
fn the_worst_noise_in_four_channels_with_a_zoom_stays_small() {
    let samples = 60_000;
    let time: Vec<f64> = (0..samples).map(|i| f64::from(i) * 1e-3).collect();
    // Steps through all residues of a prime: neighbours have nothing in common.
    let noise = |step: i32| -> Vec<f64> {
        let residue = |i| f64::from(i % 1009 * step % 1009) / 1009.0;
        (0..samples).map(residue).collect()
    };
    let (measured, model) = (noise(619), noise(271));
    let channel = OverlayChannel {
        quantity: ANGLE,
        measurement: &measured,
        model: &model,
        sensor_std: 0.1,
        note: "",
    };
    let channels = [channel; 4];
    let figure = Overlay {
        zoom_s: Some((10.0, 20.0)),
        ..one_channel(&time, &channels, "noise")
    };
    let svg = overlay(&figure).unwrap();
    parse(&svg);
    assert!(svg.len() < 400_000, "{} bytes", svg.len());
}

#[test]
fn a_line_that_crosses_the_zoom_without_a_point_in_it_is_drawn() {
    let line = Line {
        name: "line",
        role: LineRole::Model,
        x: &[0.0, 10.0],
        y: &[0.0, 10.0],
    };
    let svg = series(&Series {
        title: "t",
        panels: &[Panel {
            lines: &[line],
            ..Panel::default()
        }],
        zoom: Some((4.0, 5.0)),
        ..Series::default()
    })
    .unwrap();
    let document = parse(&svg);
    let groups = series_of(&document, "model");
    assert_eq!(groups.len(), 2);
    assert_eq!(stretches(&groups[1]).concat().len(), 2);
}

#[test]
fn gaps_stay_gaps() {
    let time: Vec<f64> = (0..1000).map(f64::from).collect();
    let mut measured: Vec<f64> = time.iter().map(|t| (t / 50.0).sin()).collect();
    measured[300..400].fill(f64::NAN);
    measured[700] = f64::INFINITY;
    let model = vec![0.0; 1000];
    let channels = [OverlayChannel {
        quantity: ANGLE,
        measurement: &measured,
        model: &model,
        sensor_std: f64::NAN,
        note: "",
    }];
    let svg = overlay(&one_channel(&time, &channels, "gaps")).unwrap();
    let document = parse(&svg);
    for (class, parts) in [("measurement", 3), ("residual", 3), ("model", 1)] {
        let found = stretches(&series_of(&document, class)[0]);
        assert_eq!(found.len(), parts, "{class}");
    }
    let measured = stretches(&series_of(&document, "measurement")[0]);
    let end = measured[0].last().unwrap().0;
    let begin = measured[1][0].0;
    let whole = measured[2].last().unwrap().0 - measured[0][0].0;
    // 100 lost samples are 101 steps of 999.
    assert!(((begin - end) / whole - 101.0 / 999.0).abs() < 1e-3);
}

#[test]
fn stacked_panels_share_their_time_axis() {
    let time: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.01).collect();
    let small: Vec<f64> = time.iter().map(|t| 1e-7 * t).collect();
    let large: Vec<f64> = time.iter().map(|t| 12_345.0 - t).collect();
    let channel = |values| OverlayChannel {
        quantity: ANGLE,
        measurement: values,
        model: values,
        sensor_std: 0.0,
        note: "",
    };
    let channels = [channel(&small), channel(&large)];
    let svg = overlay(&one_channel(&time, &channels, "axes")).unwrap();
    let document = parse(&svg);
    let ends: Vec<(f64, f64)> = series_of(&document, "model")
        .iter()
        .map(|g| {
            let points = stretches(g).concat();
            (points[0].0, points[points.len() - 1].0)
        })
        .collect();
    assert_eq!(ends.len(), 2);
    assert_eq!(ends[0], ends[1]);
}

#[test]
fn lengths_that_do_not_fit_are_refused_by_name() {
    let time = [0.0, 1.0];
    let channels = [OverlayChannel {
        quantity: ANGLE,
        measurement: &[1.0, 2.0],
        model: &[1.0],
        sensor_std: 0.0,
        note: "",
    }];
    let error = overlay(&one_channel(&time, &channels, "swing")).unwrap_err();
    assert_eq!(
        error.to_string(),
        "figure \"swing\": the model of angle has 1 values where 2 are needed"
    );
    let wrong = StaircaseTrace {
        name: "a/angle",
        held_out: false,
        rmse_over_floor: &[1.0],
    };
    let result = staircase(&Staircase {
        steps: &["base", "+ x"],
        traces: &[wrong],
        ..Staircase::default()
    });
    assert!(matches!(result, Err(FigureError::Length { found: 1, .. })));
    let result = confusion(&Confusion {
        truths: &["a"],
        answers: &["a", "b"],
        counts: &[1],
        ..Confusion::default()
    });
    assert!(matches!(
        result,
        Err(FigureError::Length { expected: 2, .. })
    ));
}
