//! The line of a converter.

use crate::common::{ChiSquared, Noise};
use calibrate::fit_line;

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
