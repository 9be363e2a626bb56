//! Any text and any number make a valid figure.

use crate::svg::{ANGLE, parse, series_of};
use figures::*;
use proptest::prelude::*;

/// Any number, also one that is not a number or not finite.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![prop::num::f64::ANY, -10.0..10.0f64]
}

proptest! {
    #[test]
    fn any_label_comes_out_as_it_went_in(name in "[ -~äπ]{1,20}", title in "\\PC{0,200}") {
        let line = Line { name: &name, role: LineRole::Model, x: &[0.0, 1.0], y: &[0.0, 1.0] };
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
            channels: &[OverlayChannel {
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
            name: "p", role: LineRole::Model, poles: &[(v[0], v[1]), (v[2], v[3])], cloud: &[(v[4], v[5])],
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

        let suspect = SuspectBar { name: "s", probability: v[0], evidence: "e" };
        parse(&suspects(&Suspects { suspects: &[suspect], ..Default::default() }));
    }
}
