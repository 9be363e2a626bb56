//! The probability that an effect is real beside an unknown cause.

use crate::thresholds::Thresholds;

/// The probability that effects are really present which explain the share `s` of the misfit, while a remainder is
/// left that no effect explains.
///
/// There are two hypotheses. Either an unknown cause acts alone; the effects then imitate a part of it, and `s`
/// has a uniform density. Or the effects act beside the unknown cause. Both then leave independent traces a and
/// b, each log-uniform from the noise to [`Thresholds::largest_trace`] times the noise. The logit
/// ln(s/(1 − s)) = 2 (ln a − ln b) has nearly the constant density 1/(2 L) around zero, with
/// L = ln(largest trace), so `s` has the density 1/(2 L s (1 − s)). The prior odds of the first hypothesis are
/// [`Thresholds::alone_to_beside`].
///
/// The posterior probability is finally multiplied by `s`. This factor is caution, not statistics: the second
/// density also rises towards s = 0, but effects that explain next to nothing should not be reported as
/// probable.
pub fn genuine(s: f64, thresholds: &Thresholds) -> f64 {
    let s = s.clamp(1e-9, 1.0 - 1e-9);
    let density = 1.0 / (2.0 * thresholds.largest_trace.ln() * s * (1.0 - s));
    density / (thresholds.alone_to_beside + density) * s
}

#[cfg(test)]
mod tests {
    use super::Thresholds;

    fn genuine(s: f64) -> f64 {
        super::genuine(s, &Thresholds::default())
    }

    #[test]
    fn what_takes_more_of_the_misfit_is_more_probably_there() {
        let shares: Vec<f64> = (0..=1000).map(|k| f64::from(k) / 1000.0).collect();
        let found: Vec<f64> = shares.iter().map(|&share| genuine(share)).collect();
        assert!(found.iter().all(|p| (0.0..=1.0).contains(p)));
        assert!(found.windows(2).all(|pair| pair[1] >= pair[0]), "{found:?}");
        // Half of a misfit says little; all but a hundred thousandth of it says nearly everything.
        assert!(genuine(0.5) < 0.1 && genuine(0.9) < 0.2);
        assert!(genuine(0.999) > 0.8 && genuine(0.99999) > 0.98);
    }

    /// By drawing: of benches with an unknown cause alone, and with an effect beside it, those are
    /// counted in which the effect takes about the given share.
    #[test]
    fn the_probability_is_that_of_the_draw() {
        let mut state = 12345u64;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let (mut alone, mut beside) = ([0.0; 10], [0.0; 10]);
        for _ in 0..400_000 {
            let share = uniform();
            alone[(share * 10.0) as usize] += 1.0;
            let [a, b] = [uniform(), uniform()].map(|u| (u * 1e3f64.ln()).exp().powi(2));
            beside[((a / (a + b) * 10.0) as usize).min(9)] += 1.0;
        }
        // About one half, where the density of the logit is nearly constant.
        for index in [4, 5] {
            let share = (index as f64 + 0.5) / 10.0;
            let drawn = beside[index]
                / (beside[index] + Thresholds::default().alone_to_beside * alone[index]);
            let found = genuine(share) / share;
            assert!((found - drawn).abs() < 0.02, "{share}: {drawn} {found}");
        }
    }
}
