//! Experiments, or values of `[known]`, that contradict each other.
//!
//! A common fit averages over logs that disagree. Therefore each record is asked which parameter value it would prefer
//! on its own, and each known value is compared with the value that the logs would prefer.
//!
//! Let Hᵣ and gᵣ be the information and the gradient of record r at the common parameters (the
//! windows' starts eliminated), H and g their sums. Two kinds of extra unknown δ are tested: a value
//! θⱼ + δ of parameter j for record r alone, and a known parameter j that becomes free by δ:
//! ```text
//! h = Hᵣ eⱼ (or H eⱼ),   S = hⱼ − hᵀH⁻¹h,   δ = (gᵣⱼ − hᵀH⁻¹g)/S
//! ```
//!
//! Here h and g run over the unknowns that are free anyway, and δ is one Newton step from the common fit. δ
//! is a sum over the records' gradients, δ = Σₛ wₛᵀgₛ, with the variance Σₛ wₛᵀMₛwₛ. Mₛ is the
//! covariance of a gradient under correlated residuals ([`super::covariance`]). It is computed from the residual
//! of record s at its own best parameters; at the common parameters, a contradiction would enlarge the
//! residual, and so hide itself. Without a contradiction, δ/σ is standard normal (a Wald test of
//! homogeneity; Morelli & Klein, J. Aircraft 34 (1997), for σ).
//!
//! The largest significant contradiction is reported and then resolved: the record is left out, or the known
//! value is made free. The test is then repeated with the rest. One wrong record is therefore reported once, not
//! for every parameter and every record that disagrees with it.

use bench_files::numbers::{number, significant, with_uncertainty};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use parallel::parallel_map;
use plant::{Model, TOTAL_INERTIA, WHEEL_INERTIA};
use statrs::distribution::{ContinuousCDF, Normal};

use super::covariance::{gradient_error, pseudo_inverse};
use crate::bench::FitProblem;
use crate::fit::{RecordScore, Unknowns, Window, score_test};
use crate::records::Record;

/// Probability of a false report on a bench without any contradiction, over all its tests.
const FALSE_ALARM: f64 = 1e-3;
/// Smallest share of an unknown's information that must remain after the other unknowns have adapted. A smaller share
/// is rounding error: nothing else determines the unknown, so nothing can contradict it.
const DETERMINED: f64 = 1e-8;
/// Largest number of contradictions reported for one bench: one wrong log and one wrong known value. More of them
/// point to an effect that the model lacks; every sentence names that as the other possible cause.
const MOST: usize = 2;

/// One of the two sides of a contradiction.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// The source, such as `experiment "coast-down"` or `[known]`.
    pub who: String,
    /// The value of the parameter according to this side.
    pub value: f64,
    /// Its standard error; `None` for a stated value.
    pub std: Option<f64>,
}

/// Two sides that disagree about a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// The parameter's name.
    pub parameter: &'static str,
    /// Its unit on this bench.
    pub unit: String,
    /// The side that stands alone: one experiment, or `[known]`.
    pub one: Side,
    /// The other side: the remaining experiments, or the logs.
    pub other: Side,
    /// Difference of the two values, in standard errors of the difference.
    pub sigmas: f64,
    /// Other values of `[known]` whose change would resolve the contradiction as well: name, stated value, value that the
    /// logs prefer, its standard error.
    pub instead: Vec<(&'static str, f64, f64, f64)>,
}

impl Contradiction {
    /// The contradiction in one sentence.
    pub fn sentence(&self) -> String {
        let side = |side: &Side| with_uncertainty(side.value, side.std);
        let head = format!(
            "contradiction: {} says {} = {} {}, {} {} ({} standard errors, {} % apart)",
            self.one.who,
            self.parameter,
            side(&self.one),
            self.unit,
            self.other.who,
            side(&self.other),
            significant(self.sigmas, 3),
            significant(100.0 * (self.one.value / self.other.value - 1.0).abs(), 3)
        );
        if self.one.std.is_some() {
            return format!(
                "{head}; one of the two is wrong, or the model lacks an effect that acts \
                 differently in them; the fitted value lies in between and must not be trusted"
            );
        }
        let instead: String = self
            .instead
            .iter()
            .map(|(name, given, wanted, std)| {
                format!(
                    "; or {name} is wrong: given as {}, but the logs give {}",
                    number(*given),
                    with_uncertainty(*wanted, Some(*std))
                )
            })
            .collect();
        format!(
            "{head}{instead}; the fit kept the values of [known]; the model may also lack an effect"
        )
    }
}

/// The records' statistics at the common parameters, for the free parameters and the known ones.
struct Statistics<'a> {
    records: Vec<&'a Record>,
    unknowns: Unknowns,
    values: Vec<f64>,
    names: Vec<&'static str>,
    units: Vec<String>,
    /// Whether an unknown belongs to a ripple over the wheel's angle, and is its phase.
    of_ripple: Vec<Option<bool>>,
    /// Information and gradient of each record.
    promised: Vec<RecordScore>,
    /// Covariance of each gradient.
    scatter: Vec<DMatrix<f64>>,
}

/// A tested contradiction.
struct Candidate {
    unknown: usize,
    /// The record that may have its own value; `None` if a known value is made free.
    record: Option<usize>,
    /// δ and its standard error, in the fit's coordinates.
    change: f64,
    std: f64,
    /// For the other records: the step of the shared parameter, and its standard error.
    shared: (f64, f64),
    /// For this record: its own step, and its standard error.
    own: (f64, f64),
}

impl Candidate {
    fn sigmas(&self) -> f64 {
        (self.change / self.std).abs()
    }
}

/// The contradictions of a bench at the parameters `values` of `model`, the largest first. `windows` are those of the
/// fit. `held` lists the positions of parameters that lie on a bound.
pub fn contradictions(
    problem: &FitProblem,
    model: &Model,
    values: &[f64],
    windows: &[Vec<Window>],
    held: &[usize],
) -> Vec<Contradiction> {
    // A learned curve is held: it takes up what contradicts itself.
    let mut free = problem.free(model);
    let is_learned = |position: usize| {
        let effect = model.effect_at(position);
        effect.is_some_and(|effect| effect.info().learned.is_some())
    };
    free.retain(|&position| !is_learned(position));
    let knowns: Vec<usize> = (0..problem.known.len())
        .filter(|&position| problem.known[position].is_some() && is_measured(problem, position))
        .collect();
    let mut positions: Vec<usize> = free
        .iter()
        .chain(&knowns)
        .copied()
        .filter(|position| !held.contains(position))
        .collect();
    positions.sort_unstable();
    let mut active: Vec<bool> = positions
        .iter()
        .map(|position| free.contains(position))
        .collect();
    let statistics = Statistics::new(problem, model, values, windows, &positions);
    let mut kept = vec![true; statistics.records.len()];
    let mut threshold = None;
    let mut found = vec![];
    while found.len() < MOST {
        let candidates = statistics.candidates(&active, &kept);
        // Bonferroni over the tests of the whole bench.
        let threshold = *threshold.get_or_insert_with(|| sigmas_for(candidates.len()));
        let Some(best) = candidates
            .iter()
            .filter(|candidate| candidate.sigmas() > threshold)
            .max_by(|a, b| a.sigmas().total_cmp(&b.sigmas()))
        else {
            break;
        };
        found.push(statistics.contradiction(best, &candidates, threshold, &kept));
        match best.record {
            Some(record) => kept[record] = false,
            None => active[best.unknown] = true,
        }
    }
    found
}

/// Whether a known base parameter was stated by the user, and not set to 1 to fix the scale.
fn is_measured(problem: &FitProblem, position: usize) -> bool {
    match position {
        TOTAL_INERTIA => problem.body_scale_known,
        WHEEL_INERTIA => problem.wheel_scale_known || problem.coupled,
        _ => true,
    }
}

/// Whether a position of the parameter vector is the phase of a ripple; `None` if it belongs to no ripple.
fn of_ripple(model: &Model, position: usize) -> Option<bool> {
    let (effect, own) = model.range_at(position)?;
    let ripple = effect.info().ripple?;
    Some(own.start + ripple.phase == position)
}

/// The number of standard errors that one of `tests` normal variables exceeds with probability
/// [`FALSE_ALARM`].
pub(super) fn sigmas_for(tests: usize) -> f64 {
    let tail = FALSE_ALARM / (2.0 * tests.max(1) as f64);
    -Normal::standard().inverse_cdf(tail)
}

impl<'a> Statistics<'a> {
    fn new(
        problem: &'a FitProblem,
        model: &Model,
        values: &[f64],
        windows: &[Vec<Window>],
        positions: &[usize],
    ) -> Statistics<'a> {
        let unknowns = Unknowns::new(model, positions);
        let records = problem.all_records();
        let at = score_test(&records, model, values, windows, &unknowns, None).records;
        let infos = model.parameters();
        let each = records.iter().zip(windows).zip(&at);
        let scatter = parallel_map(each, |((record, windows), at)| {
            let own = shortest_solution(&at.information, &at.gradient);
            gradient_error(record, windows, model, values, &unknowns, &own).covariance()
        });
        Statistics {
            records,
            unknowns,
            values: values.to_vec(),
            names: positions.iter().map(|&at| infos[at].name).collect(),
            units: positions
                .iter()
                .map(|&at| problem.unit(model, at))
                .collect(),
            of_ripple: positions.iter().map(|&at| of_ripple(model, at)).collect(),
            promised: at,
            scatter,
        }
    }

    /// All tests that are possible with the records in `kept`.
    fn candidates(&self, active: &[bool], kept: &[bool]) -> Vec<Candidate> {
        let count = active.len();
        let mut information = DMatrix::zeros(count, count);
        let mut gradient = DVector::zeros(count);
        for (record, _) in kept.iter().enumerate().filter(|(_, kept)| **kept) {
            information += &self.promised[record].information;
            gradient += &self.promised[record].gradient;
        }
        let passive: Vec<bool> = active.iter().map(|active| !active).collect();
        let Some(inverse) = pseudo_inverse(&information, &passive) else {
            return vec![];
        };
        let mut candidates = vec![];
        for (unknown, &is_active) in active.iter().enumerate() {
            if !is_active {
                candidates.extend(self.test(
                    unknown,
                    None,
                    &information,
                    &gradient,
                    &inverse,
                    kept,
                ));
                continue;
            }
            let told: Vec<usize> = (0..kept.len())
                .filter(|&record| kept[record] && self.tells(record, unknown))
                .collect();
            if told.len() < 2 {
                continue;
            }
            for record in told {
                let (own, right) = (
                    &self.promised[record].information,
                    &self.promised[record].gradient,
                );
                candidates.extend(self.test(unknown, Some(record), own, right, &inverse, kept));
            }
        }
        candidates
    }

    /// Whether a record tells something of an unknown that others can contradict. Where logs are read by their teeth, their
    /// angles were turned until these lie where those of the others do, up to some tenths of a radian of their phase. A log
    /// of the same bench that does not show its teeth begins at a tooth that nobody knows, and so does any log in which
    /// nobody measured the wheel's angle: its phase belongs to the log, and at the phase of the others its torque says nothing.
    fn tells(&self, record: usize, unknown: usize) -> bool {
        let is_open = match self.of_ripple[unknown] {
            Some(is_phase) => {
                let own = self.records[record];
                let shows_teeth = own.teeth.is_some();
                let is_measured = own.wheel_angle_noise_rad().is_some();
                let by_teeth = self.records.iter().any(|record| record.teeth.is_some());
                if by_teeth {
                    is_phase || !shows_teeth
                } else {
                    !is_measured
                }
            }
            None => false,
        };
        !is_open && self.promised[record].information[(unknown, unknown)] > 0.0
    }

    /// Tests `unknown` with its own value for `record`, or freed for all records if it is a known one. `information` and
    /// `gradient` are those of the records that get the new value; `inverse` is H⁻¹ of the common fit.
    fn test(
        &self,
        unknown: usize,
        record: Option<usize>,
        information: &DMatrix<f64>,
        gradient: &DVector<f64>,
        inverse: &DMatrix<f64>,
        kept: &[bool],
    ) -> Option<Candidate> {
        let count = gradient.len();
        // H⁻¹ has zero rows for parameters that are not free, so whole vectors can be used.
        let solved = inverse * information.column(unknown);
        let whole = information[(unknown, unknown)];
        let left = whole - information.column(unknown).dot(&solved);
        if !left.is_finite() || left <= DETERMINED * whole {
            return None;
        }
        let one = DVector::from_fn(count, |row, _| f64::from(u8::from(row == unknown)));
        let shared_row = inverse * &one;
        let records = || (0..kept.len()).filter(|&other| kept[other]);
        // Weights of each record's gradient in δ, and in the step of the shared parameter.
        let in_change = |other: usize| {
            let direct = record.is_none_or(|record| record == other);
            let direct = if direct { &one * 1.0 } else { &one * 0.0 };
            (direct - &solved) / left
        };
        let in_shared = |other: usize| &shared_row - in_change(other) * solved[unknown];
        let in_own = |other: usize| in_shared(other) + in_change(other);
        let sum = |weights: &dyn Fn(usize) -> DVector<f64>| -> (f64, f64) {
            records().fold((0.0, 0.0), |(value, variance), other| {
                let weights = weights(other);
                (
                    value + weights.dot(&self.promised[other].gradient),
                    variance + weights.dot(&(&self.scatter[other] * &weights)),
                )
            })
        };
        let (change, variance) = sum(&in_change);
        let with_std = |(value, variance): (f64, f64)| (value, variance.max(0.0).sqrt());
        let (shared, own) = (sum(&in_shared), sum(&in_own));
        // If one side has no variance, only rounding error determines it.
        let is_told = record.is_none() || (shared.1 > 0.0 && own.1 > 0.0);
        (is_told && variance > 0.0 && change.is_finite()).then(|| Candidate {
            unknown,
            record,
            change,
            std: variance.sqrt(),
            shared: with_std(shared),
            own: with_std(own),
        })
    }

    /// The parameter's value after a step in the fit's coordinates, with its standard error.
    fn value(&self, unknown: usize, (step, std): (f64, f64)) -> (f64, f64) {
        let value = self.values[self.unknowns.free[unknown]];
        if self.unknowns.logarithmic[unknown] {
            let moved = value * step.exp();
            (moved, std * moved)
        } else {
            (value + step, std)
        }
    }

    fn contradiction(
        &self,
        best: &Candidate,
        candidates: &[Candidate],
        threshold: f64,
        kept: &[bool],
    ) -> Contradiction {
        let unknown = best.unknown;
        let given = |unknown: usize| self.values[self.unknowns.free[unknown]];
        let (one, other, instead) = match best.record {
            Some(record) => {
                let others: Vec<&str> = (0..kept.len())
                    .filter(|&at| at != record && kept[at] && self.tells(at, unknown))
                    .map(|at| self.records[at].name.as_str())
                    .collect();
                let who = match others[..] {
                    [only] => format!("experiment \"{only}\""),
                    [first, second] => format!("experiments \"{first}\" and \"{second}\""),
                    _ => format!("the other {} experiments", others.len()),
                };
                let (own, own_std) = self.value(unknown, best.own);
                let (shared, shared_std) = self.value(unknown, best.shared);
                let one = Side {
                    who: format!("experiment \"{}\"", self.records[record].name),
                    value: own,
                    std: Some(own_std),
                };
                let other = Side {
                    who,
                    value: shared,
                    std: Some(shared_std),
                };
                (one, other, vec![])
            }
            None => {
                let (wanted, std) = self.value(unknown, (best.change, best.std));
                let instead = candidates
                    .iter()
                    .filter(|other| {
                        other.record.is_none()
                            && other.unknown != unknown
                            && other.sigmas() > threshold
                    })
                    .map(|other| {
                        let (wanted, std) = self.value(other.unknown, (other.change, other.std));
                        (self.names[other.unknown], given(other.unknown), wanted, std)
                    })
                    .collect();
                let one = Side {
                    who: "[known]".to_owned(),
                    value: given(unknown),
                    std: None,
                };
                let other = Side {
                    who: "the logs with the rest of [known]".to_owned(),
                    value: wanted,
                    std: Some(std),
                };
                (one, other, instead)
            }
        };
        Contradiction {
            parameter: self.names[unknown],
            unit: self.units[unknown].clone(),
            one,
            other,
            sigmas: best.sigmas(),
            instead,
        }
    }
}

/// The shortest x (each unknown in units of its own information) that minimises |H x − g|. Combinations of
/// parameters that the record does not determine keep their values.
fn shortest_solution(information: &DMatrix<f64>, gradient: &DVector<f64>) -> DVector<f64> {
    let scale = information.diagonal().map(|value| {
        if value > 0.0 {
            value.sqrt().recip()
        } else {
            0.0
        }
    });
    let scaled = DMatrix::from_fn(gradient.len(), gradient.len(), |row, column| {
        information[(row, column)] * scale[row] * scale[column]
    });
    let eigen = SymmetricEigen::new(scaled);
    let right = eigen.eigenvectors.transpose() * gradient.component_mul(&scale);
    let along = DVector::from_fn(right.len(), |row, _| {
        let value = eigen.eigenvalues[row];
        if value > DETERMINED {
            right[row] / value
        } else {
            0.0
        }
    });
    (eigen.eigenvectors * along).component_mul(&scale)
}
