//! How strongly the measurements speak for one model against another.
//!
//! For a series of n independent Gaussian errors with unknown variance, the logarithm of the maximum
//! likelihood is −(n/2) ln(rms²) plus a constant. The errors of an incomplete model are correlated
//! over hundreds of samples. Therefore n is the effective sample size, taken from the residual of the
//! best candidate: that residual comes closest to the errors that no model explains.
//!
//! Each free parameter costs (1/2) ln n with the same n (Schwarz, Ann. Stat. 6 (1978)). A set of k effects is one of
//! C(p, k) sets that p suspects offer. Every size k has the same prior probability, which costs a set ln C(p, k)
//! (the extended criterion of Chen & Chen, Biometrika 95 (2008)). Without this term, the best of many pairs
//! would beat the one true effect by luck.

use identify::{Record, effective_samples};
use plant::{Kind, period_s};

use crate::applicable::applicable;
use crate::bench::SearchBench;
use crate::candidate::Candidate;
use crate::physical::Unphysical;
use crate::remainder::{noise, residual};

/// The effective sample size of every series, in the order of [`Candidate::rmse`]: from the autocorrelation of
/// the residual of the best candidate, with a lower limit from the number of periods (see
/// [`crate::Thresholds::periods_per_value`]).
fn effective(records: &[&Record], best: &Candidate, periods_per_value: f64) -> Vec<f64> {
    let period_s = period_s(&best.minimum.values);
    records
        .iter()
        .zip(&best.traces)
        .flat_map(|(record, traces)| {
            let least = match (record.kind, record.time_s.first(), record.time_s.last()) {
                (Kind::FreeSwing | Kind::Driven, Some(first), Some(last)) => {
                    (last - first) / (periods_per_value * period_s)
                }
                _ => 1.0,
            };
            let least = least.min(record.len() as f64);
            record
                .channels
                .iter()
                .zip(traces)
                .map(move |(channel, trace)| {
                    let left = residual(&channel.samples, &trace.predicted);
                    effective_samples(&left, &record.weight).max(least)
                })
        })
        .collect()
}

/// Logarithm of the evidence for a candidate, up to a constant that is the same for all candidates of the same
/// records. `noise` is the noise's standard deviation in every series: an error below half of it gains
/// nothing. `suspects` is the number of effects from which the candidate's were chosen.
fn log_evidence(candidate: &Candidate, effective: &[f64], noise: &[f64], suspects: usize) -> f64 {
    let rmse = candidate.rmse();
    log_evidence_of(&rmse, candidate, effective, noise, suspects)
}

/// As [`log_evidence`], with corrected errors. In every series, `rmse` replaces the candidate's own error where it
/// is smaller: it excludes misfit that is known not to come from the candidate's effects. No series is taken
/// below the error of `best`, however.
fn log_evidence_beyond(
    candidate: &Candidate,
    rmse: &[f64],
    best: &Candidate,
    effective: &[f64],
    noise: &[f64],
    suspects: usize,
) -> f64 {
    let rmse: Vec<f64> = candidate
        .rmse()
        .into_iter()
        .zip(best.rmse())
        .zip(rmse)
        .map(|((own, best), &without)| without.max(best).min(own))
        .collect();
    log_evidence_of(&rmse, candidate, effective, noise, suspects)
}

fn log_evidence_of(
    rmse: &[f64],
    candidate: &Candidate,
    effective: &[f64],
    noise: &[f64],
    suspects: usize,
) -> f64 {
    let likelihood: f64 = rmse
        .iter()
        .zip(effective)
        .zip(noise)
        .map(|((rmse, n), noise)| {
            // Also a noise-free log needs a lower limit of the error: half of the noise estimate.
            -0.5 * n * rmse.max(0.5 * noise).powi(2).ln()
        })
        .sum();
    let total: f64 = effective.iter().sum();
    likelihood
        - 0.5 * candidate.parameters as f64 * total.max(2.0).ln()
        - log_choices(suspects, candidate.added.len())
}

/// ln C(p, k): logarithm of the number of ways to choose k of p suspects.
fn log_choices(suspects: usize, chosen: usize) -> f64 {
    (0..chosen.min(suspects))
        .map(|index| ((suspects - index) as f64 / (index + 1) as f64).ln())
        .sum()
}

/// The log evidence of every candidate, with effective sample sizes from the candidate of lowest cost.
pub fn evidences(bench: &SearchBench, pool: &[Candidate]) -> Vec<f64> {
    evidences_beyond(bench, pool, &|_| None)
}

/// As [`evidences`]. Where `excused` returns errors for a candidate, they replace its own where they are smaller.
///
/// A candidate with a value that its cause cannot have has no evidence, however well it fits.
pub fn evidences_beyond(
    bench: &SearchBench,
    pool: &[Candidate],
    excused: &dyn Fn(&Candidate) -> Option<Vec<f64>>,
) -> Vec<f64> {
    let fits = fits_beyond(bench, pool, excused);
    let candidates = pool.iter().zip(fits);
    candidates
        .map(|(candidate, fits)| {
            if candidate.is_unphysical(bench.thresholds.unphysical) {
                f64::NEG_INFINITY
            } else {
                fits
            }
        })
        .collect()
}

/// The value that no cause can have in the candidate that would have been chosen without it: the evidence of its fit
/// alone beats that of candidate `best` by more than a tie. `None` if there is no such candidate.
pub fn imitation<'a>(
    bench: &SearchBench,
    pool: &'a [Candidate],
    best: usize,
) -> Option<&'a Unphysical> {
    let sigmas = bench.thresholds.unphysical;
    let fits = fits_beyond(bench, pool, &|_| None);
    let without = (0..pool.len()).filter(|&index| pool[index].is_unphysical(sigmas));
    let index = without.max_by(|&a, &b| fits[a].total_cmp(&fits[b]))?;
    let beats = fits[index] - fits[best] > bench.thresholds.tie;
    let mut values = pool[index].unphysical.iter();
    values.find(|one| beats && one.sigmas() > sigmas)
}

/// How strongly the fits of all candidates speak for them, whatever values they have.
fn fits_beyond(
    bench: &SearchBench,
    pool: &[Candidate],
    excused: &dyn Fn(&Candidate) -> Option<Vec<f64>>,
) -> Vec<f64> {
    let best = pool
        .iter()
        .min_by(|a, b| a.minimum.cost.total_cmp(&b.minimum.cost));
    let Some(best) = best else { return vec![] };
    let effective = effective(&bench.records, best, bench.thresholds.periods_per_value);
    let noise = noise(&bench.records);
    let suspects = bench
        .suspects
        .iter()
        .filter(|&&effect| applicable(bench.problem, effect))
        .count();
    pool.iter()
        .map(|candidate| match excused(candidate) {
            Some(excused) => {
                log_evidence_beyond(candidate, &excused, best, &effective, &noise, suspects)
            }
            None => log_evidence(candidate, &effective, &noise, suspects),
        })
        .collect()
}
