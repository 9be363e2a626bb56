//! The line of a converter.

use crate::common::{ChiSquared, Noise};
use calibrate::{Counts, fit_line, fit_line_within_range};

/// The converter's line of the thesis: rpm = 8.53108 count − 6594.5.
#[test]
fn line_of_the_converter() {
    let (slope, offset) = (8.53108, -6594.5);
    let mut z = ChiSquared::default();
    let seeds = 500;
    for seed in 0..seeds {
        let mut noise = Noise::new(6000 + seed);
        let points: Vec<_> = (0..40)
            .map(|k| {
                let count = 100.0 + f64::from(k) * 35.0;
                (count, slope * count + offset + 20.0 * noise.one())
            })
            .collect();
        let found = fit_line(&points).expect("forty points");
        z.add(found.slope - slope, found.slope_std);
        z.add(found.offset - offset, found.offset_std);
        assert!((found.at(100.0) - (100.0 * found.slope + found.offset)).abs() < 1e-9);
        assert!(found.correlation < -0.8, "{}", found.correlation);
    }
    z.assert_one("line", seeds as f64, 38.0 / 36.0);
    assert!(fit_line(&[(1.0, 2.0), (1.0, 3.0), (1.0, 4.0)]).is_err());
    assert!(fit_line(&[(1.0, 2.0), (2.0, f64::NAN), (3.0, 4.0)]).is_err());
}

/// The count of a converter stays constant at both ends of its range. The points there are left out, and the line is
/// fitted to the other points.
#[test]
fn the_ends_of_a_converter_are_left_out() {
    let (slope, offset) = (0.9_f64, -552.0);
    let points: Vec<_> = (-14..=14)
        .map(|step| {
            let speed = 50.0 * f64::from(step);
            let count = ((speed - offset) / slope).round().clamp(0.0, 1390.0);
            (count, speed)
        })
        .collect();
    let outside = points
        .iter()
        .filter(|(count, speed)| (slope * count + offset - speed).abs() > 2.0)
        .count();
    assert!(outside >= 3, "{outside} points are clipped");
    let found = fit_line_within_range(&points, Counts::X).expect("points in between");
    assert_eq!(found.left_out.len(), outside);
    assert!((found.slope / slope - 1.0).abs() < 1e-3, "{}", found.slope);
    assert!((found.offset - offset).abs() < 0.5, "{}", found.offset);
    // A line through all points has an error ten times as large.
    let bent = fit_line(&points).expect("a line");
    assert!((bent.slope / slope - 1.0).abs() > 1e-2, "{}", bent.slope);
}

/// If the points of a line have only noise, hardly any is left out.
#[test]
fn noise_is_not_left_out() {
    let (mut left_out, seeds) = (0, 200);
    for seed in 0..seeds {
        let mut noise = Noise::new(7000 + seed);
        let points: Vec<_> = (0..30)
            .map(|k| {
                let current = f64::from(k) * 0.1 - 1.5;
                (current, 32_768.0 + 11_915.0 * current + 15.0 * noise.one())
            })
            .collect();
        let found = fit_line_within_range(&points, Counts::Y).expect("thirty points");
        left_out += found.left_out.len();
    }
    assert!(left_out <= 3, "{left_out} of {} points", 30 * seeds);
}
