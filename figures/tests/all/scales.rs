//! Planes and clouds: scales that neither flatten nor enlarge.

use crate::svg::{ANGLE, parse, series_of, stretches, texts};
use figures::*;
use roxmltree::Node;

#[test]
fn a_single_slow_pole_is_not_enlarged() {
    let open = [(-11.9, 0.0), (9.5, 0.0), (-0.13, 0.0)];
    let shown = |closed: &[(f64, f64)]| {
        let set = |name, poles| PoleSet {
            name,
            role: LineRole::Model,
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
    // A single slow pole at −0.13 would not be enlarged; two slow poles are.
    assert!(!shown(&[(-8.0, 1.0), (-8.0, -1.0), (-7.0, 0.0)]));
    assert!(shown(&[(-8.0, 1.0), (-8.0, -1.0), (-0.4, 0.0)]));
}

#[test]
fn a_stable_pole_is_drawn_inside_the_circle() {
    let set = PoleSet {
        name: "loop",
        role: LineRole::Model,
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
        role: LineRole::Float,
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
