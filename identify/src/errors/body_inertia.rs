//! The inertia of the body alone, computed from masses and lengths, and whether its value is physically possible.

use bench_files::numbers::{number, significant, with_uncertainty};
use plant::{BASE_PARAMETERS, TOTAL_INERTIA, WHEEL_INERTIA};

use super::contradiction::sigmas_for;
use super::estimate::Fit;
use crate::bench::FitProblem;

/// The inertia of the body about its own centre of mass, j_b = Θ − j_w − k² m_w − l² m_b in kg m²,
/// with its standard error from those of Θ and j_w; masses and lengths count as exact. `None` unless
/// all of them are known and both inertias are in kg m².
pub fn body_inertia(problem: &FitProblem, fit: &Fit) -> Option<(f64, Option<f64>)> {
    let masses = &problem.masses;
    let (body, wheel) = problem.moved();
    let is_told = |position: usize, moved: bool| problem.known[position].is_some() || moved;
    if !problem.body_scale_known
        || !(problem.wheel_scale_known || problem.coupled)
        || !is_told(TOTAL_INERTIA, body)
        || !is_told(WHEEL_INERTIA, wheel)
    {
        return None;
    }
    let steiner = masses.pivot_to_wheel?.powi(2) * masses.wheel_mass?
        + masses.pivot_to_com?.powi(2) * masses.body_mass?;
    let value = fit.values[TOTAL_INERTIA] - fit.values[WHEEL_INERTIA] - steiner;
    let at = |position| fit.unknowns.free.iter().position(|&free| free == position);
    let entry = |row: Option<usize>, column: Option<usize>| match (&fit.covariance, row, column) {
        (Some(covariance), Some(row), Some(column)) => covariance[(row, column)],
        _ => 0.0,
    };
    let (total, wheel) = (at(TOTAL_INERTIA), at(WHEEL_INERTIA));
    let variance = entry(total, total) + entry(wheel, wheel) - 2.0 * entry(total, wheel);
    Some((value, (variance > 0.0).then(|| variance.sqrt())))
}

/// One sentence if masses and lengths contradict the identified inertia; `None` if they agree or are not all known.
pub fn body_inertia_contradiction(problem: &FitProblem, fit: &Fit) -> Option<String> {
    let (value, std) = body_inertia(problem, fit)?;
    let spread = std.unwrap_or(0.0);
    let name = BASE_PARAMETERS[TOTAL_INERTIA].name;
    if value + sigmas_for(1) * spread <= 0.0 {
        return Some(format!(
            "contradiction: masses and lengths of [known] alone give more inertia than {name} = \
             {} kg m2: body_inertia would be {} kg m2, and an inertia cannot be negative",
            number(fit.values[TOTAL_INERTIA]),
            with_uncertainty(value, std)
        ));
    }
    let given = problem.masses.body_inertia?;
    let sigmas = (given - value).abs() / std?;
    (sigmas > sigmas_for(1)).then(|| {
        format!(
            "contradiction: [known] says body_inertia = {} kg m2, but the logs with masses and \
             lengths give {} ({} standard errors)",
            number(given),
            with_uncertainty(value, std),
            significant(sigmas, 3)
        )
    })
}
