//! A current that stands at its largest value while the wheel shows that more flowed: its sensor, or the column, ends
//! there.

use bench_files::Channel;
use identify::bumps;

use crate::finding::{Finding, FindingId};
use crate::regression::least_squares;
use crate::slips::short;
use crate::thresholds::fit::{EXPLAINED, STANDARD_ERRORS};
use crate::thresholds::wheel::{BESIDE_PLATEAU, EXCESS, PLATEAU};
use crate::view::{View, largest};

/// Checks the wheel's acceleration per ampere on the plateau of a current against that beside it. A motor can only give
/// less there: saturation and back-EMF take from its torque.
pub(crate) fn check(view: &View, out: &mut Vec<Finding>) {
    let (Some(current), Some(speed)) = (
        view.samples(Channel::Current),
        view.samples(Channel::WheelSpeed),
    ) else {
        return;
    };
    let limit = largest(current);
    let is_at_limit = |k: usize| current[k].abs() == limit;
    let count = (0..current.len()).filter(|k| is_at_limit(*k)).count();
    if limit == 0.0 || (count as f64) < PLATEAU * current.len() as f64 {
        return;
    }
    // Bumps in which the current is large: on the plateau, or on its way there.
    let is_large = |k: usize| f64::from(current[k].abs() >= BESIDE_PLATEAU * limit);
    let on_plateau = |k: usize| {
        if is_at_limit(k) {
            current[k].signum()
        } else {
            0.0
        }
    };
    let Some(length_s) = view.bump_lengths_s().next() else {
        return;
    };
    let (mut rows, mut beside) = (vec![], 0);
    bumps(&view.record, length_s, |bump| {
        let area = bump.area();
        if bump.integral_of(is_large, 0) < 0.99 * area {
            return;
        }
        let plateau = bump.integral_of(on_plateau, 0) / area;
        beside += usize::from(plateau.abs() < 0.5);
        let row = [
            bump.integral(current, 0) / area,
            limit * plateau,
            -bump.integral(speed, 0) / area,
        ];
        rows.push((row, -bump.integral(speed, 1) / area));
    });
    if beside < crate::thresholds::fit::FEWEST_ROWS {
        return;
    }
    let Some(fit) = least_squares(&rows, 2.0) else {
        return;
    };
    let excess = fit.coefficients[1] / fit.coefficients[0];
    let shows = fit.coefficients[1] > STANDARD_ERRORS * fit.std[1]
        && fit.coefficients[0] > STANDARD_ERRORS * fit.std[0];
    if fit.explained < EXPLAINED || !shows || excess < EXCESS {
        return;
    }
    out.push(
        Finding::warning(
            FindingId::Clipped,
            format!(
                "the current stands at {} A in {count} samples, but the wheel accelerates {} times as much there as that \
                 current gives beside it: the current's sensor ends there",
                short(limit),
                short(1.0 + excess)
            ),
        )
        .in_experiment(view.name())
        .with_channel("current")
        .with_fix("exclude those parts with from and until, or log the current that was asked for"),
    );
}
