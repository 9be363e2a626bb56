//! What must hold of every figure: well-formed XML, every series there, no
//! value that is not a number, small files, labels intact.

use figures::*;
use proptest::prelude::*;
use roxmltree::{Document, Node};

/// Parses, and checks what must hold of every figure.
fn parse(svg: &str) -> Document<'_> {
    let document = Document::parse(svg).expect("well-formed XML");
    let size = |name| -> f64 {
        let value = document.root_element().attribute(name).expect(name);
        value.parse().expect(name)
    };
    let (width, height) = (size("width"), size("height"));
    assert!(width > 0.0 && height > 0.0);
    for node in document.descendants().filter(Node::is_element) {
        for attribute in node.attributes() {
            let value = attribute.value();
            if attribute.name() != "data-series" {
                assert!(!value.contains("NaN") && !value.contains("inf"), "{value}");
            }
        }
        // Every text begins or ends on the page.
        if node.has_tag_name("text") {
            let at = |name| node.attribute(name).unwrap().parse::<f64>().unwrap();
            assert!((0.0..=width).contains(&at("x")), "{:?}", node.text());
            assert!((0.0..=height).contains(&at("y")), "{:?}", node.text());
        }
        if node.has_tag_name("path") {
            let data = node.attribute("d").unwrap();
            assert!(data.starts_with('M') && data.len() > 3, "{data}");
        }
    }
    document
}

fn texts(document: &Document) -> Vec<String> {
    let nodes = document.descendants().filter(|n| n.has_tag_name("text"));
    nodes.filter_map(|n| n.text().map(str::to_owned)).collect()
}

fn series_of<'a>(document: &'a Document, class: &str) -> Vec<Node<'a, 'a>> {
    let groups = document.descendants();
    groups
        .filter(|n| n.has_tag_name("g") && n.attribute("class") == Some(class))
        .collect()
}

/// The points of all paths below `node`, one list for each stretch.
fn stretches(node: &Node) -> Vec<Vec<(f64, f64)>> {
    let mut all: Vec<Vec<(f64, f64)>> = Vec::new();
    for path in node.descendants().filter(|n| n.has_tag_name("path")) {
        let mut at = (0.0, 0.0);
        let data = path.attribute("d").unwrap();
        let mut rest = data;
        while let Some(command) = rest.chars().next() {
            let end = rest[1..]
                .find(|c: char| c.is_ascii_alphabetic())
                .map_or(rest.len(), |i| i + 1);
            let numbers = numbers(&rest[1..end]);
            rest = &rest[end..];
            match (command, numbers.as_slice()) {
                ('M', [x, y]) => at = (*x, *y),
                ('m' | 'l', [x, y]) => at = (at.0 + x, at.1 + y),
                ('h', [x]) => at.0 += x,
                ('z', []) => continue,
                other => panic!("unexpected path command {other:?}"),
            }
            if command == 'M' || command == 'm' {
                all.push(Vec::new());
            }
            all.last_mut().expect("paths begin with a move").push(at);
        }
    }
    all
}

fn numbers(text: &str) -> Vec<f64> {
    let spaced = text.replace('-', " -");
    spaced
        .split_whitespace()
        .map(|n| n.parse().expect("a number"))
        .collect()
}

const ANGLE: Quantity = Quantity {
    name: "angle",
    unit: "rad",
};

fn one_channel<'a>(time_s: &'a [f64], channels: &'a [Channel<'a>], title: &'a str) -> Overlay<'a> {
    Overlay {
        title,
        time_s,
        channels,
        ..Overlay::default()
    }
}

#[test]
fn a_long_overlay_is_small_and_keeps_its_peak() {
    let samples = 60_000;
    let time: Vec<f64> = (0..samples).map(|i| f64::from(i) * 1e-3).collect();
    let mut measured: Vec<f64> = time.iter().map(|t| (40.0 * t).sin()).collect();
    // One sample out of 60,000 stands out: it must be seen.
    measured[31_234] = 5.0;
    let model: Vec<f64> = time.iter().map(|t| (40.0 * t + 0.1).sin()).collect();
    let channel = Channel {
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
    let channel = Channel {
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
        role: Role::Model,
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
    let channels = [Channel {
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
    let channel = |values| Channel {
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
    let channels = [Channel {
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
        let ratio = format!("{:.2}×", values[2]);
        assert!(texts.contains(&ratio), "{ratio} in {texts:?}");
    }
    // A missing step leaves two lone points, not a line across it.
    let first = stretches(&series_of(&document, "fit")[0]);
    assert!(
        first
            .iter()
            .all(|part| part.iter().all(|p| p.0 == part[0].0))
    );
}

#[test]
fn bars_are_as_long_as_their_probability() {
    let suspect = |name, probability| Suspect {
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

#[test]
fn a_single_slow_pole_is_not_enlarged() {
    let open = [(-11.9, 0.0), (9.5, 0.0), (-0.13, 0.0)];
    let shown = |closed: &[(f64, f64)]| {
        let set = |name, poles| PoleSet {
            name,
            role: Role::Model,
            poles,
            cloud: &[],
        };
        let svg = poles(&Poles {
            plane: Plane::Continuous,
            sets: &[set("open", &open), set("closed", closed)],
            ..Default::default()
        });
        svg.contains("enlarged")
    };
    // The pole at -0.13 alone would fill the panel; beside another slow one it tells something.
    assert!(!shown(&[(-8.0, 1.0), (-8.0, -1.0), (-7.0, 0.0)]));
    assert!(shown(&[(-8.0, 1.0), (-8.0, -1.0), (-0.4, 0.0)]));
}

#[test]
fn a_stable_pole_is_drawn_inside_the_circle() {
    let set = PoleSet {
        name: "loop",
        role: Role::Model,
        poles: &[(0.999, 0.0), (0.99, 0.02), (0.99, -0.02)],
        cloud: &[],
    };
    let svg = poles(&Poles {
        title: "t",
        plane: Plane::Discrete,
        sets: &[set],
        ..Poles::default()
    });
    let document = parse(&svg);
    // Once with the whole circle and once enlarged.
    let groups = series_of(&document, "model");
    assert_eq!(groups.len(), 2);
    let spread = |g: &Node| {
        let xs: Vec<f64> = stretches(g).concat().iter().map(|p| p.0).collect();
        xs.iter().copied().fold(0.0, f64::max) - xs.iter().copied().fold(1e9, f64::min)
    };
    assert!(spread(&groups[1]) > 3.0 * spread(&groups[0]));
}

#[test]
fn clouds_of_any_size_stay_small() {
    // A plane lattice wound around a sphere: evenly spread points.
    let points: Vec<[f64; 3]> = (0..60_000)
        .map(|i| {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 60_000.0;
            let angle = f64::from(i) * 2.399_963;
            let r = (1.0 - z * z).sqrt();
            [r * angle.cos(), r * angle.sin(), z]
        })
        .collect();
    let svg = sphere(&Sphere {
        title: "t",
        before: &points,
        after: &points,
        radius: 1.0,
        ..Sphere::default()
    });
    parse(&svg);
    assert!(svg.len() < 400_000, "{} bytes", svg.len());
}

#[test]
fn a_far_limit_is_named_and_does_not_flatten_the_data() {
    let x = [0.0, 1.0, 2.0];
    let line = Line {
        name: "float law",
        role: Role::Float,
        x: &x,
        y: &[0.0, 0.01, 0.0],
    };
    let draw = |value| {
        let limits = [Limit {
            value,
            name: "the limit",
        }];
        series(&Series {
            title: "t",
            panels: &[Panel {
                quantity: ANGLE,
                lines: &[line],
                limits: &limits,
                note: "",
            }],
            ..Series::default()
        })
        .unwrap()
    };
    let height = |svg: &str| {
        let document = parse(svg);
        let ys: Vec<f64> = stretches(&series_of(&document, "float")[0])
            .concat()
            .iter()
            .map(|p| p.1)
            .collect();
        ys[0] - ys[1]
    };
    let (near, far) = (draw(0.02), draw(2.0));
    assert!(texts(&parse(&near)).contains(&"the limit".to_owned()));
    assert!(texts(&parse(&far)).contains(&"the limit lies outside".to_owned()));
    assert!(height(&far) > height(&near) && height(&near) > 100.0);
}

/// Any number, also one that is not a number or not finite.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![prop::num::f64::ANY, -10.0..10.0f64]
}

proptest! {
    #[test]
    fn any_label_comes_out_as_it_went_in(name in "[ -~äπ]{1,20}", title in "\\PC{0,200}") {
        let line = Line { name: &name, role: Role::Model, x: &[0.0, 1.0], y: &[0.0, 1.0] };
        let figure = Series {
            title: &title,
            subtitle: &title,
            panels: &[Panel { lines: &[line], ..Panel::default() }],
            ..Series::default()
        };
        let svg = series(&figure).unwrap();
        let document = parse(&svg);
        let group = &series_of(&document, "model")[0];
        prop_assert_eq!(group.attribute("data-series"), Some(name.as_str()));
        // Equal data give equal files.
        prop_assert_eq!(&series(&figure).unwrap(), &svg);
    }

    #[test]
    fn any_numbers_make_a_valid_overlay(
        values in prop::collection::vec((number(), number(), number()), 0..50),
        std in number(),
        zoom in prop::option::of((number(), number())),
        event in (number(), number()),
    ) {
        let time: Vec<f64> = values.iter().map(|v| v.0).collect();
        let measurement: Vec<f64> = values.iter().map(|v| v.1).collect();
        let model: Vec<f64> = values.iter().map(|v| v.2).collect();
        let svg = overlay(&Overlay {
            title: "any",
            time_s: &time,
            channels: &[Channel {
                quantity: ANGLE,
                measurement: &measurement,
                model: &model,
                sensor_std: std,
                note: "",
            }],
            regions: &[Region { from: event.0, until: event.1, label: "region" }],
            markers: &[Marker { at: event.1, label: "push" }],
            zoom_s: zoom,
            ..Overlay::default()
        })
        .unwrap();
        parse(&svg);
    }

    #[test]
    fn any_numbers_make_valid_small_figures(v in prop::collection::vec(number(), 6)) {
        let bin = ResidualBin {
            from: v[0], until: v[1], mean: v[2], mean_std: v[3], share_of_error: v[4],
        };
        let panel = BreakdownPanel { bins: &[bin, bin], sensor_std: v[5], ..Default::default() };
        parse(&breakdown(&Breakdown { panels: &[panel], ..Default::default() }));

        let point = DecayPoint { amplitude: v[0], value: v[1], std: v[2] };
        let panel = DecayPanel {
            points: &[point], model_amplitude: &v, model: &v, ..Default::default()
        };
        parse(&decay(&Decay { panels: &[panel], ..Default::default() }).unwrap());

        let set = PoleSet {
            name: "p", role: Role::Model, poles: &[(v[0], v[1]), (v[2], v[3])], cloud: &[(v[4], v[5])],
        };
        for plane in [Plane::Discrete, Plane::Continuous] {
            parse(&poles(&Poles { plane, sets: &[set], ..Default::default() }));
        }

        let bin = ReliabilityBin { stated: v[0], frequency: v[1], low: v[2], high: v[3], count: 7 };
        parse(&reliability(&Reliability {
            bins: &[bin], tolerance: v[4], ..Default::default()
        }));

        let vector = [v[0], v[1], v[2]];
        parse(&sphere(&Sphere {
            before: &[vector], after: &[vector], radius: v[3], ..Default::default()
        }));

        let trace = StaircaseTrace { name: "s", held_out: true, rmse_over_floor: &v };
        parse(&staircase(&Staircase {
            steps: &["a", "b", "c", "d", "e", "f"], traces: &[trace], ..Default::default()
        }).unwrap());

        let suspect = Suspect { name: "s", probability: v[0], evidence: "e" };
        parse(&suspects(&Suspects { suspects: &[suspect], ..Default::default() }));
    }
}
