//! The law of decay of the amplitude, dA/dt = −(C + V A + Q A²), with any of its terms.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::point::{AtAmplitude, Estimate};

/// A law dA/dt = −(C + V A + Q A²), fitted with some of its terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecayLaw {
    /// Which of C, V and Q the law has.
    pub has: [bool; 3],
    /// C in rad/s, V in 1/s, Q in 1/(rad s); 0 for terms that the law does not have.
    pub coefficients: [Estimate; 3],
    /// Root mean square residual of the amplitudes, rad.
    pub rms_rad: f64,
    /// The same, relative to the amplitude.
    pub relative_rms: f64,
    /// Bayesian information criterion n ln(rms²) + p ln n over the half cycles: lower is better.
    pub criterion: f64,
}

/// The amplitudes that the law predicts at these times from the first amplitude.
fn predict(times: &[f64], start: f64, law: &[f64; 3]) -> Vec<f64> {
    let slope = |a: f64| {
        let a = a.max(0.0);
        -(law[0] + law[1] * a + law[2] * a * a)
    };
    let mut out = vec![start];
    let mut a = start;
    for pair in times.windows(2) {
        let h = pair[1] - pair[0];
        let k1 = slope(a);
        let k2 = slope(a + 0.5 * h * k1);
        let k3 = slope(a + 0.5 * h * k2);
        let k4 = slope(a + h * k3);
        a = (a + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)).max(0.0);
        out.push(a);
    }
    out
}

/// All laws, the best first.
pub(super) fn laws(amplitudes: &[AtAmplitude]) -> Vec<DecayLaw> {
    let mut laws: Vec<DecayLaw> = (1..8u32)
        .filter_map(|mask| {
            let has = [mask & 1 != 0, mask & 2 != 0, mask & 4 != 0];
            fit_law(amplitudes, has)
        })
        .filter(|law| {
            let allowed = |e: &Estimate| e.value >= -2.0 * e.std;
            law.coefficients.iter().all(allowed)
        })
        .collect();
    laws.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
    laws
}

/// Gauss–Newton with step halving, over the first amplitude and the terms of the law. The weight of each half cycle
/// follows from its own error and from a share of its amplitude; the share allows for deviations that no law of this
/// form can follow.
fn fit_law(amplitudes: &[AtAmplitude], has: [bool; 3]) -> Option<DecayLaw> {
    let times: Vec<f64> = amplitudes.iter().map(|point| point.time_s).collect();
    let n = times.len();
    let free: Vec<usize> = (0..3).filter(|&term| has[term]).collect();
    let p = free.len() + 1;
    if n <= p + 2 {
        return None;
    }
    let largest = amplitudes[0].value;
    let mean_amplitude = amplitudes.iter().map(|point| point.value).sum::<f64>() / n as f64;
    let rate = (largest - amplitudes[n - 1].value) / (times[n - 1] - times[0]) / mean_amplitude;
    let typical = [mean_amplitude, 1.0, 1.0 / mean_amplitude].map(|unit| unit * rate.abs());
    // Unknowns: the first amplitude, then the terms in units of their typical size.
    let unpack = |x: &DVector<f64>| -> (f64, [f64; 3]) {
        let mut law = [0.0; 3];
        for (index, &term) in free.iter().enumerate() {
            law[term] = x[index + 1] * typical[term];
        }
        (x[0] * largest, law)
    };
    let residual = |x: &DVector<f64>| -> DVector<f64> {
        let (start, law) = unpack(x);
        let predicted = predict(&times, start, &law);
        DVector::from_iterator(
            n,
            amplitudes
                .iter()
                .zip(predicted)
                .map(|(point, predicted)| (point.value - predicted) / largest),
        )
    };
    let mut x = DVector::from_element(p, 1.0 / free.len() as f64);
    x[0] = 1.0;
    let mut left = residual(&x);
    let mut inverse = DMatrix::zeros(p, p);
    for _ in 0..60 {
        let mut jacobian = DMatrix::zeros(n, p);
        for column in 0..p {
            let mut moved = x.clone();
            moved[column] += 1e-5;
            jacobian.set_column(column, &((residual(&moved) - &left) / 1e-5));
        }
        let square = jacobian.transpose() * &jacobian;
        let mut damped = square.clone();
        for k in 0..p {
            damped[(k, k)] += 1e-12 * (1.0 + square[(k, k)]);
        }
        let cholesky = Cholesky::new(damped)?;
        inverse = cholesky.inverse();
        let step = cholesky.solve(&(jacobian.transpose() * &left));
        let mut length = 1.0;
        let mut better = None;
        while length > 1e-4 {
            let next = &x - length * &step;
            let there = residual(&next);
            if there.norm() <= left.norm() {
                better = Some((next, there));
                break;
            }
            length *= 0.5;
        }
        let Some((next, there)) = better else {
            break;
        };
        let gain = left.norm_squared() - there.norm_squared();
        x = next;
        left = there;
        if gain <= 1e-10 * left.norm_squared() {
            break;
        }
    }
    let variance = left.norm_squared() / (n - p) as f64;
    let (_, law) = unpack(&x);
    let mut coefficients = [Estimate::default(); 3];
    for (index, &term) in free.iter().enumerate() {
        coefficients[term] = Estimate {
            value: law[term],
            std: (variance * inverse[(index + 1, index + 1)]).sqrt() * typical[term],
        };
    }
    let mean_square = left.norm_squared() / n as f64;
    let relative = left
        .iter()
        .zip(amplitudes)
        .map(|(left, point)| (left * largest / point.value).powi(2))
        .sum::<f64>()
        / n as f64;
    Some(DecayLaw {
        has,
        coefficients,
        rms_rad: mean_square.sqrt() * largest,
        relative_rms: relative.sqrt(),
        criterion: n as f64 * mean_square.max(1e-300).ln() + p as f64 * (n as f64).ln(),
    })
}
