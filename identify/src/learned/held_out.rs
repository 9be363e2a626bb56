//! The strength of a penalty, by cross-validation: the factor with which the fit best predicts data that it has not
//! seen (Stone, J. R. Stat. Soc. B 36 (1974)).
//!
//! Everything is quadratic here: a part of the data (an experiment, a stretch of one) costs
//! s − 2 g·x + xᵀ N x at the unknowns x, and the penalty adds (x + x₀)ᵀ P (x + x₀).

use nalgebra::{Cholesky, DMatrix, DVector};

/// A part of the data.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// N.
    pub information: DMatrix<f64>,
    /// g.
    pub gradient: DVector<f64>,
    /// s.
    pub square: f64,
}

impl Part {
    pub(super) fn empty(count: usize) -> Part {
        Part {
            information: DMatrix::zeros(count, count),
            gradient: DVector::zeros(count),
            square: 0.0,
        }
    }

    pub(super) fn cost(&self, x: &DVector<f64>) -> f64 {
        self.square - 2.0 * self.gradient.dot(x) + x.dot(&(&self.information * x))
    }

    pub(super) fn add(&mut self, other: &Part) {
        self.information += &other.information;
        self.gradient += &other.gradient;
        self.square += other.square;
    }
}

/// A part is held out only if the others carry at least this share of its information about each unknown.
const LEAST_INFORMATION: f64 = 0.01;
/// Range of the powers of ten over which the penalty is tried, relative to the information of the data.
const POWERS: (f64, f64) = (-9.0, 5.0);
/// Steps in a power of ten.
const STEPS: f64 = 2.0;

/// All parts together.
pub(super) fn sum(parts: &[Part]) -> Part {
    let count = parts.first().map_or(0, |part| part.gradient.len());
    let mut all = Part::empty(count);
    for part in parts {
        all.add(part);
    }
    all
}

/// The parts that can be held out: the other parts determine every unknown.
pub(super) fn that_can_be_held_out(parts: &[Part]) -> Vec<usize> {
    let all = sum(parts);
    let is_told = |part: &Part| {
        (0..all.gradient.len()).all(|at| {
            let own = part.information[(at, at)];
            own <= 0.0
                || all.information[(at, at)] - own > LEAST_INFORMATION * all.information[(at, at)]
        })
    };
    (0..parts.len())
        .filter(|&index| is_told(&parts[index]))
        .collect()
}

/// The unknowns at which the cost of a part with a penalty is smallest; `None` if the problem is singular.
pub(super) fn solved(
    part: &Part,
    penalty: &DMatrix<f64>,
    from: &DVector<f64>,
) -> Option<DVector<f64>> {
    let matrix = &part.information + penalty;
    let right = &part.gradient - penalty * from;
    let count = right.len();
    let scale = DVector::from_fn(count, |at, _| {
        let diagonal = matrix[(at, at)];
        if diagonal > 0.0 {
            1.0 / diagonal.sqrt()
        } else {
            0.0
        }
    });
    let scaled = DMatrix::from_fn(count, count, |row, column| {
        let entry = matrix[(row, column)] * scale[row] * scale[column];
        if row == column {
            if scale[row] > 0.0 { 1.0 + 1e-10 } else { 1.0 }
        } else {
            entry
        }
    });
    let solution = Cholesky::new(scaled)?.solve(&right.component_mul(&scale));
    Some(solution.component_mul(&scale))
}

/// The cost of the held-out parts, each predicted by all others.
pub(super) fn held_out_cost(
    parts: &[Part],
    held: &[usize],
    penalty: &DMatrix<f64>,
    from: &DVector<f64>,
) -> Option<f64> {
    let all = sum(parts);
    let mut cost = 0.0;
    for &index in held {
        let own = &parts[index];
        let others = Part {
            information: &all.information - &own.information,
            gradient: &all.gradient - &own.gradient,
            square: all.square - own.square,
        };
        cost += own.cost(&solved(&others, penalty, from)?);
    }
    cost.is_finite().then_some(cost)
}

/// The factor of the roughness that predicts best, and the held-out cost at this factor. `fixed` is the rest of the
/// penalty. Both matrices have the size of the parts.
pub(super) fn best_factor(
    parts: &[Part],
    held: &[usize],
    roughness: &DMatrix<f64>,
    fixed: &DMatrix<f64>,
    from: &DVector<f64>,
) -> Option<(f64, f64)> {
    let all = sum(parts);
    let rough = |at: &usize| roughness[(*at, *at)] > 0.0;
    let of_data: f64 = (0..roughness.nrows())
        .filter(rough)
        .map(|at| all.information[(at, at)])
        .sum();
    let unit = of_data / roughness.trace();
    let steps = ((POWERS.1 - POWERS.0) * STEPS) as usize;
    let mut best: Option<(f64, f64)> = None;
    for step in 0..=steps {
        let factor = unit * 10f64.powf(POWERS.0 + step as f64 / STEPS);
        let penalty = roughness * factor + fixed;
        if let Some(cost) = held_out_cost(parts, held, &penalty, from)
            && best.is_none_or(|(_, least)| cost < least)
        {
            best = Some((factor, cost));
        }
    }
    best.filter(|(factor, _)| factor.is_finite() && *factor > 0.0)
}

/// Correlation time of a series in samples: 1 + 2 Σ ρ, summed until ρ is no longer positive.
pub(super) fn correlation_time(series: &[f64]) -> f64 {
    let n = series.len();
    let mean = series.iter().sum::<f64>() / n.max(1) as f64;
    let product = |lag: usize| -> f64 {
        series
            .iter()
            .zip(&series[lag..])
            .map(|(a, b)| (a - mean) * (b - mean))
            .sum()
    };
    let own = product(0);
    if own <= 0.0 {
        return 1.0;
    }
    let mut time = 1.0;
    for lag in 1..n / 4 {
        let rho = product(lag) / own;
        if rho <= 0.0 {
            break;
        }
        time += 2.0 * rho;
    }
    time
}

/// Number of correlation times in a block that is held out of one log.
const BLOCK_TIMES: f64 = 10.0;
/// Fewest and most blocks of a log.
const BLOCKS: (usize, usize) = (4, 40);

/// The length of the blocks into which a series is cut.
pub(super) fn block_length(series: &[f64]) -> usize {
    let wanted = (BLOCK_TIMES * correlation_time(series)).ceil() as usize;
    let n = series.len().max(1);
    wanted
        .clamp(n.div_ceil(BLOCKS.1), n.div_ceil(BLOCKS.0))
        .max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One unknown, measured as 1 in one part and as 3 in the other. Each part is predicted by the mean of the other.
    #[test]
    fn a_part_is_predicted_by_the_others() {
        let part = |mean: f64| Part {
            information: DMatrix::from_element(1, 1, 10.0),
            gradient: DVector::from_element(1, 10.0 * mean),
            square: 10.0 * mean * mean,
        };
        let parts = [part(1.0), part(3.0)];
        let nothing = DMatrix::zeros(1, 1);
        let cost = held_out_cost(&parts, &[0, 1], &nothing, &DVector::zeros(1)).expect("regular");
        assert!((cost - 2.0 * 10.0 * 4.0).abs() < 1e-6);
    }

    #[test]
    fn white_noise_remembers_nothing_and_a_slow_series_much() {
        let alternating: Vec<f64> = (0..400).map(|k| [1.0, -1.0][k % 2]).collect();
        assert_eq!(correlation_time(&alternating), 1.0);
        let slow: Vec<f64> = (0..4000).map(|k| (0.01 * k as f64).sin()).collect();
        let time = correlation_time(&slow);
        // 1 + 2 ∫ cos over a quarter of a period of 628 samples.
        assert!((150.0..250.0).contains(&time), "{time}");
    }
}
