//! The phase of teeth of one order, followed from piece to piece as a hidden Markov chain.

use std::f64::consts::TAU;

use super::piece::{Piece, Projected};

/// Number of phases that the chain distinguishes.
const PHASES: usize = 32;
/// The gains in log likelihood that the amplitudes of the grid promise: this one, and each four times the one before.
const LEAST_EXPECTED: f64 = 25.0;
/// Number of amplitudes in the grid.
const AMPLITUDES: usize = 8;
/// An amplitude that promises this many times what all pieces gain, each with a phase of its own, is not tried.
const FAR_BEYOND: f64 = 4.0;
/// Rounds in which the amplitude is improved, and the relative change at which that ends.
const ROUNDS: usize = 12;
const SETTLED: f64 = 1e-3;
/// Variance of a walk, rad², after which nothing is known of the phase (e⁻¹⁵ of it is left).
const FORGOTTEN: f64 = 30.0;
/// Relative change of a walk for which its kernel is computed anew.
const SAME_WALK: f64 = 1e-3;
/// Term of a kernel's Fourier series that no longer matters.
const LAST_TERM: f64 = 1e-9;

/// Probabilities of the phases, or logarithms of likelihoods.
pub(super) type Belief = [f64; PHASES];

const NOTHING_KNOWN: Belief = [1.0 / PHASES as f64; PHASES];

/// The chain over the pieces of all logs in which teeth of one order can be counted.
pub(super) struct Chain {
    pub(super) windows: Vec<Projected>,
    /// Sine and cosine of every phase.
    pub(super) phases: Vec<(f64, f64)>,
}

/// The walk of the phase between two pieces.
struct Walk {
    variance: f64,
    kernel: Belief,
}

impl Walk {
    /// A walk of this variance in rad²: the wrapped normal distribution, from its Fourier series.
    fn of(variance: f64) -> Walk {
        let mut kernel = NOTHING_KNOWN;
        for m in 1..=PHASES / 2 {
            let twice = if m == PHASES / 2 { 1.0 } else { 2.0 };
            let factor = (-0.5 * variance * (m * m) as f64).exp() * twice / PHASES as f64;
            if factor < LAST_TERM {
                break;
            }
            for (j, value) in kernel.iter_mut().enumerate() {
                *value += factor * (TAU * (m * j % PHASES) as f64 / PHASES as f64).cos();
            }
        }
        // The series of a walk shorter than a phase's width rings below zero.
        kernel.iter_mut().for_each(|value| *value = value.max(0.0));
        normalise(&mut kernel);
        Walk { variance, kernel }
    }

    fn spread(&self, belief: &Belief) -> Belief {
        let mut after = [0.0; PHASES];
        for (from, &weight) in belief.iter().enumerate() {
            for (to, value) in after.iter_mut().enumerate() {
                *value += weight * self.kernel[(to + PHASES - from) % PHASES];
            }
        }
        after
    }
}

impl Chain {
    pub(super) fn new(pieces: &[Piece], order: f64, alone: bool) -> Chain {
        let phase = |m: usize| (TAU * m as f64 / PHASES as f64).sin_cos();
        let windows = pieces.iter();
        Chain {
            windows: windows
                .filter_map(|piece| piece.projected(order, alone))
                .collect(),
            phases: (0..PHASES).map(phase).collect(),
        }
    }

    /// Log likelihood of amplitude `a` at each phase in one piece, against no teeth.
    fn likelihoods(&self, window: &Projected, a: f64) -> Belief {
        let ([cc, cs, ss], [ce, se]) = (window.information, window.towards);
        let mut all = [0.0; PHASES];
        for (value, (sin, cos)) in all.iter_mut().zip(&self.phases) {
            let (x, y) = (-a * sin, -a * cos);
            *value = ce * x + se * y - 0.5 * (cc * x * x + 2.0 * cs * x * y + ss * y * y);
        }
        all
    }

    /// Variance of the walk to this piece from the one before, rad²; infinite between logs.
    fn walk_to(&self, next: usize) -> f64 {
        let (one, two) = (&self.windows[next - 1], &self.windows[next]);
        if one.log == two.log {
            two.walk * (two.centre_s - one.centre_s)
        } else {
            f64::INFINITY
        }
    }

    /// Log evidence of amplitude `a`. `each` receives what every piece and those before it say of its phase.
    fn forward(&self, a: f64, each: &mut dyn FnMut(Belief)) -> f64 {
        let mut belief = NOTHING_KNOWN;
        let mut step = Walk::of(0.0);
        let mut evidence = 0.0;
        for (k, window) in self.windows.iter().enumerate() {
            let variance = if k > 0 {
                self.walk_to(k)
            } else {
                f64::INFINITY
            };
            if variance > FORGOTTEN {
                belief = NOTHING_KNOWN;
            } else {
                if (variance - step.variance).abs() > SAME_WALK * variance {
                    step = Walk::of(variance);
                }
                belief = step.spread(&belief);
            }
            evidence += update(&mut belief, &self.likelihoods(window, a));
            each(belief);
        }
        evidence
    }

    /// What all pieces together say of each one's phase.
    fn smoothed(&self, a: f64) -> Vec<Belief> {
        let mut beliefs = vec![];
        self.forward(a, &mut |belief| beliefs.push(belief));
        let mut later = [1.0; PHASES];
        for k in (0..self.windows.len()).rev() {
            for (value, after) in beliefs[k].iter_mut().zip(&later) {
                *value *= after;
            }
            normalise(&mut beliefs[k]);
            let variance = if k > 0 {
                self.walk_to(k)
            } else {
                f64::INFINITY
            };
            if variance > FORGOTTEN {
                later = [1.0; PHASES];
                continue;
            }
            update(&mut later, &self.likelihoods(&self.windows[k], a));
            later = Walk::of(variance).spread(&later);
            normalise(&mut later);
        }
        beliefs
    }

    /// Log evidence of teeth of this order, averaged over the grid of amplitudes, and the amplitude for which it is largest.
    pub(super) fn evidence(&self) -> (f64, f64) {
        let of_unit: f64 = self.windows.iter().map(Projected::expected).sum();
        if of_unit <= 0.0 {
            return (f64::NEG_INFINITY, 0.0);
        }
        let gained = 0.5 * self.windows.iter().map(|one| one.gain).sum::<f64>();
        let mut tried = vec![];
        let mut best = (f64::NEG_INFINITY, 0.0);
        let mut expected = LEAST_EXPECTED;
        for _ in 0..AMPLITUDES {
            if expected > FAR_BEYOND * (gained + LEAST_EXPECTED) {
                break;
            }
            let a = (expected / of_unit).sqrt();
            let found = self.forward(a, &mut |_| {});
            tried.push(found);
            if found > best.0 {
                best = (found, a);
            }
            expected *= 4.0;
        }
        (log_sum_exp(&tried) - (AMPLITUDES as f64).ln(), best.1)
    }

    /// The amplitude of largest likelihood near `a` (expectation and maximisation; Dempster et al. 1977), with the phases.
    pub(super) fn refined(&self, mut a: f64) -> (f64, Vec<Belief>) {
        let mut beliefs = self.smoothed(a);
        for _ in 0..ROUNDS {
            let (mut along, mut square) = (0.0, 0.0);
            for (window, belief) in self.windows.iter().zip(&beliefs) {
                let ([cc, cs, ss], [ce, se]) = (window.information, window.towards);
                for (weight, (sin, cos)) in belief.iter().zip(&self.phases) {
                    along -= weight * (ce * sin + se * cos);
                    square += weight * (cc * sin * sin + 2.0 * cs * sin * cos + ss * cos * cos);
                }
            }
            let next = along / square;
            if next.is_nan() || next <= 0.0 {
                break;
            }
            let has_settled = (next / a - 1.0).abs() < SETTLED;
            a = next;
            beliefs = self.smoothed(a);
            if has_settled {
                break;
            }
        }
        (a, beliefs)
    }
}

impl Projected {
    /// The gain in log likelihood that teeth of amplitude one promise here, over all phases.
    pub(super) fn expected(&self) -> f64 {
        0.25 * (self.information[0] + self.information[2])
    }
}

/// ln Σ exp.
pub(super) fn log_sum_exp(values: &[f64]) -> f64 {
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return f64::NEG_INFINITY;
    }
    let sum: f64 = values.iter().map(|value| (value - largest).exp()).sum();
    largest + sum.ln()
}

/// Multiplies by the likelihoods and normalises; returns the logarithm of the factor.
fn update(belief: &mut Belief, likelihoods: &Belief) -> f64 {
    let largest = likelihoods
        .iter()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    for (value, likelihood) in belief.iter_mut().zip(likelihoods) {
        *value *= (likelihood - largest).exp();
    }
    largest + normalise(belief).ln()
}

/// Makes the sum one, and returns what it was.
fn normalise(belief: &mut Belief) -> f64 {
    let sum = belief.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    belief.iter_mut().for_each(|value| *value /= sum);
    sum
}
