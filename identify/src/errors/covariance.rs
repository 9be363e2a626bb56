//! Standard errors that account for correlated residuals.
//!
//! The textbook covariance H⁻¹ holds if the residuals are white with the stated noise. The residuals of
//! an incomplete model are correlated over hundreds of samples. With s the sensitivities of
//! one observation (the windows' starts eliminated) and R the autocovariance of the residuals,
//!
//!   cov θ = H⁻¹ ( Σᵢⱼ sᵢ R(i−j) sⱼᵀ ) H⁻¹
//!
//! (Morelli & Klein, J. Aircraft 34 (1997), eq. 21). The double sum is evaluated in the frequency
//! domain: ∫ S(f) s(f) s(f)ᴴ df, with S a smoothed periodogram of the residual.
//!
//! The recorded current has noise of its own. The wheel integrates it to a random walk, which also swings
//! the body. The fit takes this motion for real, so that it hardly appears in the residual; the covariance has a second
//! term for it. An error δi of the current over one interval changes the state at the next sample by ∂x/∂i δi. The
//! motion carries this change to every later sample, and so into the gradient. Both derivatives are exact derivatives
//! of the model's own steps, with all its effects, the motor and the sensors included ([`crate::fit`]). A delay shifts
//! all errors by the same time, which matters only at the ends of a window. In a balance log no such term is added:
//! there the current responds to the noise of the sensors, this part of the current really flows, and the noise of the
//! current's own measurement cannot be separated from it.
//!
//! A real joint sticks, while the model's dry friction passes through zero over the speed v₀. The resulting
//! change of the outputs counts as one standard error, common to all logs: v₀ is a "considered" parameter, one
//! that is uncertain but not estimated (Schmidt 1966; Bierman 1977, chapter VIII).

use nalgebra::{Cholesky, DMatrix, DVector, Matrix6xX};
use parallel::parallel_map;
use plant::{Kind, Model, Smoothing};

use super::spectral::correlated_sum;
use crate::fit::{
    Observation, Unknowns, Window, counts, normal_observed, relevant, simulate_smoothed,
    transitions_backwards,
};
use crate::records::{Record, input_noise_std};

/// Covariance of the free parameters in the fit's coordinates (a logarithmic parameter as its
/// logarithm), from the final windows of a fit; `None` if the information matrix is singular.
///
/// `held` marks unknowns that lie on a bound. They have no standard error of their own (their rows are zero), but those
/// of the others cover that the true value may lie inside: a wheel with a little friction, fitted with none, has an
/// inertia that is wrong by more than the error of a fit in which the friction is known to be zero. The fit within the
/// bounds is, in the metric of the information, the point nearest to the fit without them. Since the truth lies within the
/// bounds, it is at least as near to the truth as that fit, whose covariance therefore covers it. A logarithmic unknown is
/// treated as given: its bounds lie where it no longer has any influence.
pub fn covariance(
    records: &[&Record],
    windows: &[Vec<Window>],
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    information: &DMatrix<f64>,
    held: &[bool],
) -> Option<DMatrix<f64>> {
    let count = unknowns.free.len();
    let nowhere = DVector::zeros(count);
    let mut middle = DMatrix::zeros(count, count);
    let mut stick = DVector::zeros(count);
    let errors: Vec<GradientError> =
        parallel_map(records.iter().zip(windows), |(record, windows)| {
            gradient_error(record, windows, model, values, unknowns, &nowhere)
        });
    for error in errors {
        middle += error.noise;
        stick += error.stick;
    }
    middle += &stick * stick.transpose();
    // The penalty on roughness biases a learned curve. Averaged over the range of the curve, the squared bias is
    // accounted for by the matrix of the penalty (Nychka, J. Am. Stat. Assoc. 83 (1988)).
    if let Some(penalty) = crate::learned::penalty_of(model, unknowns) {
        middle += penalty;
    }
    let bounds = held.iter().zip(&unknowns.logarithmic);
    let given: Vec<bool> = bounds.map(|(held, log)| *held && *log).collect();
    let inverse =
        pseudo_inverse(information, &given).or_else(|| pseudo_inverse(information, held))?;
    let mut covariance = &inverse * middle * &inverse;
    for (index, _) in held.iter().enumerate().filter(|(_, held)| **held) {
        covariance.row_mut(index).fill(0.0);
        covariance.column_mut(index).fill(0.0);
    }
    Some(covariance)
}

/// H⁻¹ over the unknowns that are not held and have some information; zero rows for the others.
pub fn pseudo_inverse(information: &DMatrix<f64>, held: &[bool]) -> Option<DMatrix<f64>> {
    let count = information.nrows();
    let kept: Vec<usize> = (0..count)
        .filter(|&index| !held[index] && information[(index, index)] > 0.0)
        .collect();
    let scale: Vec<f64> = kept
        .iter()
        .map(|&index| 1.0 / information[(index, index)].sqrt())
        .collect();
    let scaled = DMatrix::from_fn(kept.len(), kept.len(), |row, column| {
        information[(kept[row], kept[column])] * scale[row] * scale[column]
    });
    let inverse = Cholesky::new(scaled)?.inverse();
    let mut full = DMatrix::zeros(count, count);
    for (row, &to_row) in kept.iter().enumerate() {
        for (column, &to_column) in kept.iter().enumerate() {
            full[(to_row, to_column)] = inverse[(row, column)] * scale[row] * scale[column];
        }
    }
    Some(full)
}

/// The uncertainty of one record's gradient, against a perfect measurement and a perfect model.
#[derive(Clone, Debug)]
pub struct GradientError {
    /// Covariance from the noise of the sensors and of the recorded current.
    pub noise: DMatrix<f64>,
    /// Change of the gradient if the joint sticks.
    pub stick: DVector<f64>,
}

impl GradientError {
    /// Covariance from both causes, for this record alone.
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.noise + &self.stick * self.stick.transpose()
    }
}

/// One record's share of the middle sum Σᵢⱼ sᵢ R(i−j) sⱼᵀ. R is the autocovariance of the residual after the free
/// parameters have made `step` (in the fit's coordinates; to first order). A record that is compared with others takes
/// its own step; otherwise its disagreement with the others would count as noise.
pub fn gradient_error(
    record: &Record,
    windows: &[Window],
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    step: &DVector<f64>,
) -> GradientError {
    let count = unknowns.free.len();
    let mut middle = DMatrix::zeros(count, count);
    let mut stick = DVector::zeros(count);
    let globals = relevant(record, model, unknowns);
    let n = record.len();
    let p = globals.len();
    if p == 0 {
        return GradientError {
            noise: middle,
            stick,
        };
    }
    let own_step = DVector::from_fn(p, |row, _| step[globals[row]]);
    let channels = record.channels.len();
    let mut residuals = vec![vec![0.0; n]; channels];
    let mut sensitivities = vec![vec![vec![0.0; n]; p]; channels];
    let mut observations = vec![0usize; channels];
    let mut locals_total = 0;
    let projected: Vec<Projected> = parallel_map(windows, |window| {
        project(record, window, model, values, unknowns, &globals)
    });
    // A window of which nothing counts has no sensitivities, and its start is not fitted.
    let counting = || windows.iter().filter(|window| counts(record, window));
    for (window, projected) in windows.iter().zip(projected) {
        if counts(record, window) {
            locals_total += window.nuisances.len();
        }
        let rows = projected.sensitivities.chunks_exact(projected.width);
        for (one, sensitivity) in projected.observed.iter().zip(rows) {
            observations[one.channel] += 1;
            let mut residual = one.residual;
            for (index, series) in sensitivities[one.channel].iter_mut().enumerate() {
                series[one.sample] = sensitivity[index];
                residual -= sensitivity[index] * own_step[index];
            }
            residuals[one.channel][one.sample] = residual;
        }
    }
    let input_noise_a = match record.kind {
        Kind::SpinUp | Kind::Driven => input_noise_std(&record.current_a),
        Kind::FreeSwing | Kind::Balance => 0.0,
    };
    if input_noise_a > 0.0 {
        let walks = parallel_map(counting(), |window| {
            let carried = (window, &sensitivities[..], input_noise_a);
            input_walk(record, model, values, carried)
        });
        for walk in walks {
            for (row, &to_row) in globals.iter().enumerate() {
                for (column, &to_column) in globals.iter().enumerate() {
                    middle[(to_row, to_column)] += walk[(row, column)];
                }
            }
        }
    }
    if globals
        .iter()
        .any(|&global| is_dry_friction(model, unknowns.free[global]))
    {
        let changes = stuck(record, windows, model, values);
        for (row, &to_row) in globals.iter().enumerate() {
            for (changes, sensitivities) in changes.iter().zip(&sensitivities) {
                let both = changes.iter().zip(&sensitivities[row]);
                stick[to_row] += both.map(|(change, s)| change * s).sum::<f64>();
            }
        }
    }
    let total: usize = observations.iter().sum();
    // Unbiased variance: the fitted unknowns used up degrees of freedom.
    let freedom = total as f64 / total.saturating_sub(p + locals_total).max(1) as f64;
    // Windows that count are joined over those that do not. Each has a start of its own, so that its residual says next to
    // nothing of the next one's.
    let joined = |series: &Vec<f64>| -> Vec<f64> {
        let parts = counting().map(|window| &series[window.samples.clone()]);
        parts.flatten().copied().collect()
    };
    for channel in 0..channels {
        if observations[channel] > 0 {
            let own: Vec<Vec<f64>> = sensitivities[channel].iter().map(joined).collect();
            let left = joined(&residuals[channel]);
            let spectra = correlated_sum(&left, &own, observations[channel]);
            for (row, &to_row) in globals.iter().enumerate() {
                for (column, &to_column) in globals.iter().enumerate() {
                    middle[(to_row, to_column)] += spectra[(row, column)] * freedom;
                }
            }
        }
    }
    GradientError {
        noise: middle,
        stick,
    }
}

/// The observations of a window, after its start has adapted.
struct Projected {
    observed: Vec<Observed>,
    /// For each of them a row of `width` numbers, of which the first are s̃ = s_g − Hgl Hll⁻¹ s_l for each parameter
    /// that shows in the record.
    sensitivities: Vec<f64>,
    width: usize,
}

/// The place of an observation, and its residual.
struct Observed {
    sample: usize,
    channel: usize,
    residual: f64,
}

fn project(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    globals: &[usize],
) -> Projected {
    let p = globals.len();
    let most = window.samples.len() * record.channels.len();
    let mut observed: Vec<Observed> = Vec::with_capacity(most);
    let mut sensitivities: Vec<f64> = vec![];
    let mut width = p;
    let keep = &mut |observation: Observation| {
        if observation.residual.is_finite() {
            if observed.is_empty() {
                width = observation.sensitivity.len();
                sensitivities.reserve_exact(width * most);
            }
            sensitivities.extend_from_slice(observation.sensitivity);
            observed.push(Observed {
                sample: observation.sample,
                channel: observation.channel,
                residual: observation.residual,
            });
        }
    };
    let system = normal_observed(record, window, model, values, unknowns, globals, keep);
    let l = system.nuisances.len();
    let mut own = system.hessian.view((p, p), (l, l)).into_owned();
    for index in 0..l {
        own[(index, index)] = own[(index, index)].max(1e-300) * (1.0 + 1e-12);
    }
    let coupling = system.hessian.view((p, 0), (l, p)).into_owned();
    let projection = Cholesky::new(own).map(|cholesky| cholesky.solve(&coupling));
    if let Some(projection) = &projection {
        for row in sensitivities.chunks_exact_mut(width) {
            let (of_globals, of_locals) = row.split_at_mut(p);
            for (index, sensitivity) in of_globals.iter_mut().enumerate() {
                let column = projection.column(index);
                let own = column.iter().zip(of_locals.iter());
                *sensitivity -= own.map(|(a, b)| a * b).sum::<f64>();
            }
        }
    }
    Projected {
        observed,
        sensitivities,
        width,
    }
}

/// Whether a position of the parameter vector belongs to a dry friction whose sign is smoothed.
fn is_dry_friction(model: &Model, position: usize) -> bool {
    model
        .effect_at(position)
        .is_some_and(|effect| effect.info().has_kink)
}

/// Factor on the smoothing speed v₀ at which dry friction stands for a joint that sticks.
const STICKS: f64 = 0.1;

/// The change of every output if the joint of a model with dry friction sticks, sample by sample, in units of the
/// channel's noise; zero in a window of which nothing counts. "Sticks" means the same motion with a sign that is ten
/// times as sharp.
pub fn stuck(record: &Record, windows: &[Window], model: &Model, values: &[f64]) -> Vec<Vec<f64>> {
    let v0 = Smoothing::SIMULATION;
    let sticks = Smoothing {
        body_rad_s: v0.body_rad_s * STICKS,
        wheel_rad_s: v0.wheel_rad_s * STICKS,
    };
    let mut changes = vec![vec![0.0; record.len()]; record.channels.len()];
    for (smoothing, factor) in [(sticks, 1.0), (v0, -1.0)] {
        for window in windows.iter().filter(|window| counts(record, window)) {
            simulate_smoothed(record, window, model, values, smoothing, |k, reading, _| {
                for (series, channel) in changes.iter_mut().zip(&record.channels) {
                    let change = factor * channel.output.of(reading) / channel.noise_std;
                    if change.is_finite() {
                        series[k] += change;
                    }
                }
            });
        }
    }
    changes
}

/// Covariance of the gradient of one window that comes from the noise of the recorded current, `noise_a` in A.
/// `sensitivities` holds, for each channel and parameter, the normalised series over the record.
fn input_walk(
    record: &Record,
    model: &Model,
    values: &[f64],
    (window, sensitivities, noise_a): (&Window, &[Vec<Vec<f64>>], f64),
) -> DMatrix<f64> {
    let p = sensitivities.first().map_or(0, Vec::len);
    let mut walk = DMatrix::zeros(p, p);
    // Sum over all later samples: the sensitivity times the remaining part of a change of the state.
    let mut later = Matrix6xX::<f64>::zeros(p);
    transitions_backwards(record, window, model, values, |k, transition| {
        for (channel, series) in record.channels.iter().zip(sensitivities) {
            let shows = &transition.shown[channel.output as usize];
            for (index, series) in series.iter().enumerate() {
                let weight = series[k + 1] / channel.noise_std;
                later.column_mut(index).axpy(weight, shows, 1.0);
            }
        }
        let moved = later.tr_mul(&transition.input) * noise_a;
        walk += &moved * moved.transpose();
        if transition.state.iter().all(|entry| entry.is_finite()) {
            later = transition.state.tr_mul(&later);
        }
    });
    walk
}
