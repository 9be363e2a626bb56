//! The part of a hidden term's trace that no small combination of suspects can explain.
//!
//! The base model is refitted to the logs without noise; its residual is the trace of the hidden term.
//! Every suspect (in several shapes), every free parameter of the base model and every start of a window
//! has a trace of its own: the difference of two motions in the exam's own simulator.
//! For every set of four suspects, as many as a diagnosis adds at most, linear least squares gives the part of the
//! hidden term's trace that is orthogonal to all of theirs. No combination of the four that is small enough to be
//! linear can explain that part. The set that explains the most decides. A suspect enters with all its
//! shapes at once, which is more than a fit can do; this makes the rule strict towards outsiders. Sets that contain
//! the three powers of the angle with which any torque over the angle can be fitted are no explanation
//! and are skipped. The fits of the diagnosis are not used, so its failures cannot influence its questions.

use std::ops::Range;

use identify::{FitProblem, Nuisance, Record};
use nalgebra::{DMatrix, DVector};
use parallel::parallel_map;
use plant::{EffectId, HidingPlace, Model, Output};

use super::size::BaseFit;
use crate::bench_plan::replay;
use crate::true_motion::Beginning;
use crate::truth::{Hidden, Truth};

/// Shapes of every suspect (see [`HidingPlace::shape`] and [`HidingPlace::second`]). Shapes that are equal for an
/// effect are counted once.
const SHAPES: [f64; 4] = [0.05, 0.35, 0.65, 0.95];
/// Values of the second shape number (see [`SHAPES`]). As phases, they are a quarter turn apart.
const SECONDS: [f64; 2] = [0.0, 0.5];
/// Relative change of a base parameter, and change of a start in units of noise, for the computation of their traces.
const STEP: f64 = 1e-3;
/// Approximate size of a suspect's trace in its computation, in units of noise: the size of the hidden term.
const SIZE: f64 = 3.0;
/// Regularisation, added to the squares of traces of unit length: traces that differ by rounding only are used
/// once.
const RIDGE: f64 = 1e-9;
/// Number of suspects in a set.
const TOGETHER: usize = 4;
/// Powers of the angle whose terms together fit any torque over the angle.
const POWER_SERIES: [u32; 3] = [0, 1, 3];

/// A part of a log with its own start.
struct Segment<'a> {
    record: &'a Record,
    samples: Range<usize>,
    from: Beginning,
    /// Index of the record's first series.
    first_series: usize,
}

/// The samples of a segment that count in the fit.
struct Rows {
    /// Channel and sample of each row.
    places: Vec<(usize, usize)>,
    /// The trace at each row, in units of noise.
    values: DVector<f64>,
}

impl Segment<'_> {
    /// The motion with these true parameters and hidden terms.
    fn motion(&self, truth: &Truth, from: &Beginning) -> Vec<[f64; 3]> {
        let log = (
            self.record.time_s.as_slice(),
            self.record.current_a.as_slice(),
        );
        replay(truth, self.record.kind, log, self.samples.clone(), from)
    }

    /// The difference of two motions in units of noise, at the samples that count.
    fn difference(&self, rows: &Rows, one: &[[f64; 3]], other: &[[f64; 3]]) -> DVector<f64> {
        let at = rows.places.iter().map(|&(channel, sample)| {
            let channel = &self.record.channels[channel];
            let (k, output) = (sample - self.samples.start, channel.output as usize);
            (one[k][output] - other[k][output]) / channel.noise_std
        });
        DVector::from_iterator(rows.places.len(), at)
    }
}

/// The segments of all logs, with starts from the base fit.
fn segments<'a>(records: &[&'a Record], fit: &BaseFit) -> Vec<Segment<'a>> {
    let mut segments = vec![];
    let mut first_series = 0;
    for (&record, windows) in records.iter().zip(&fit.minimum.windows) {
        let nuisances = Nuisance::of(record);
        for window in windows {
            let first = window.samples.start;
            let local = |wanted: Nuisance| {
                let at = nuisances.iter().position(|&local| local == wanted);
                at.and_then(|at| window.nuisances.get(at).copied())
            };
            segments.push(Segment {
                record,
                samples: window.samples.clone(),
                from: Beginning {
                    time_s: record.time_s[first],
                    angle_rad: local(Nuisance::Angle).unwrap_or(0.0),
                    rate_rad_s: local(Nuisance::Rate).unwrap_or(0.0),
                    wheel_angle_rad: record.wheel_angle_before(first),
                    wheel_speed_rad_s: local(Nuisance::WheelSpeed).unwrap_or(0.0),
                    current_a: match first {
                        0 => 0.0,
                        _ => record.current_a[first - 1],
                    },
                },
                first_series,
            });
        }
        first_series += record.channels.len();
    }
    segments
}

/// The residual of the base fit in a segment.
fn left(segment: &Segment, traces: &[identify::PredictedSeries]) -> Rows {
    let record = segment.record;
    let mut places = vec![];
    let mut values = vec![];
    for (index, (channel, trace)) in record.channels.iter().zip(traces).enumerate() {
        for sample in segment.samples.clone() {
            let left = (channel.samples[sample] - trace.predicted[sample]) / channel.noise_std;
            if left.is_finite() && record.weight[sample] > 0.0 {
                places.push((index, sample));
                values.push(left);
            }
        }
    }
    Rows {
        places,
        values: DVector::from_vec(values),
    }
}

/// Every suspect in each of its different shapes.
fn terms(suspects: &[EffectId], place: &HidingPlace) -> Vec<(EffectId, HidingPlace)> {
    let mut terms = vec![];
    for &effect in suspects {
        let info = effect.info();
        let mut seen: Vec<Vec<f64>> = vec![];
        for shape in SHAPES {
            for second in SECONDS {
                let place = HidingPlace {
                    shape,
                    second,
                    ..*place
                };
                let parameters = info.hidden(info.first_guess(), &place);
                if !seen.contains(&parameters) {
                    seen.push(parameters);
                    terms.push((effect, place));
                }
            }
        }
    }
    terms
}

/// All sets of `count` members.
fn sets(members: &[EffectId], count: usize) -> Vec<Vec<EffectId>> {
    match members.split_first() {
        _ if count == 0 => vec![vec![]],
        None => vec![],
        Some((first, rest)) => {
            let mut with = sets(rest, count - 1);
            for set in &mut with {
                set.push(*first);
            }
            with.extend(sets(rest, count));
            with
        }
    }
}

/// Whether a set can fit any torque over the angle.
fn fits_any_curve(set: &[EffectId]) -> bool {
    let has = |power: &u32| {
        let mut powers = set.iter().map(|effect| effect.info().angle_power);
        powers.any(|own| own == Some(*power))
    };
    POWER_SERIES.iter().all(has)
}

/// The least-squares coefficients of the traces at these positions, and the squares that they explain.
fn least_squares(
    normal: &DMatrix<f64>,
    right: &DVector<f64>,
    at: &[usize],
) -> Option<(DVector<f64>, f64)> {
    let count = at.len();
    let own = DMatrix::from_fn(count, count, |i, j| {
        normal[(at[i], at[j])] + if i == j { RIDGE } else { 0.0 }
    });
    let right = DVector::from_fn(count, |i, _| right[at[i]]);
    let shares = own.cholesky()?.solve(&right);
    let taken = shares.dot(&right);
    Some((shares, taken))
}

/// The part of the hidden term's trace, in logs without noise, that no small combination of four suspects, of base
/// parameters and of starts explains: root mean square of the worst series, in units of its noise.
/// `None` if the motion does not stay finite.
pub fn left_by_combinations(
    clean: &FitProblem,
    fit: &BaseFit,
    suspects: &[EffectId],
    place: &HidingPlace,
) -> Option<f64> {
    let records = clean.all_records();
    let model = Model::base();
    let values = &fit.minimum.values;
    let truth_of = |values: &[f64]| Truth {
        base: [values[0], values[1], values[2], values[3]],
        body_viscous: values[4],
        wheel_viscous: values[5],
        hidden: vec![],
    };
    let truth = truth_of(values);
    let segments = segments(&records, fit);
    let all_traces: Vec<&[identify::PredictedSeries]> = records
        .iter()
        .zip(&fit.minimum.windows)
        .zip(&fit.traces)
        .flat_map(|((_, windows), traces)| windows.iter().map(move |_| traces.as_slice()))
        .collect();
    let mut rows: Vec<Rows> = segments
        .iter()
        .zip(all_traces)
        .map(|(segment, traces)| left(segment, traces))
        .collect();
    let plain: Vec<Vec<[f64; 3]>> =
        parallel_map(&segments, |segment| segment.motion(&truth, &segment.from));
    // The trace of changed parameters or terms, segment by segment.
    let trace = |truth: &Truth| -> Vec<DVector<f64>> {
        segments
            .iter()
            .zip(&rows)
            .zip(&plain)
            .map(|((segment, rows), plain)| {
                let motion = segment.motion(truth, &segment.from);
                segment.difference(rows, &motion, plain)
            })
            .collect()
    };
    let mut varied: Vec<(Option<EffectId>, Vec<DVector<f64>>)> =
        parallel_map(clean.free(&model), |position| {
            let mut values = values.clone();
            values[position] *= 1.0 + STEP;
            (None, trace(&truth_of(&values)))
        });
    varied.extend(parallel_map(terms(suspects, place), |(effect, place)| {
        let with = |amplitude: f64| {
            let parameters = effect.info().hidden(amplitude, &place);
            trace(&truth.with(vec![Hidden::Library(effect, parameters)]))
        };
        let guess = effect.info().first_guess();
        let first = with(guess);
        let size = worst(&segments, &rows, &first);
        let trace = if size > 0.0 && size.is_finite() {
            with(guess * (SIZE / size).clamp(1e-3, 1e3))
        } else {
            first
        };
        (Some(effect), trace)
    }));
    // A trace that is not finite is left out.
    varied.retain(|(_, trace)| {
        let sum: f64 = trace.iter().map(DVector::norm_squared).sum();
        sum > 0.0 && sum.is_finite()
    });
    // Every start is free: its directions are projected out of all traces of its segment.
    for (index, segment) in segments.iter().enumerate() {
        let starts: Vec<DVector<f64>> = start_steps(segment)
            .into_iter()
            .map(|from| {
                let motion = segment.motion(&truth, &from);
                segment.difference(&rows[index], &motion, &plain[index])
            })
            .collect();
        let Some(basis) = orthonormal(&starts) else {
            continue;
        };
        let without = |trace: &mut DVector<f64>| *trace -= &basis * (basis.transpose() * &*trace);
        without(&mut rows[index].values);
        for (_, trace) in &mut varied {
            without(&mut trace[index]);
        }
    }
    // Linear least squares over all segments, from the normal equations of traces of unit length.
    for (_, trace) in &mut varied {
        let norm = trace.iter().map(DVector::norm_squared).sum::<f64>().sqrt();
        for part in trace.iter_mut() {
            *part /= norm.max(f64::MIN_POSITIVE);
        }
    }
    let dot = |a: &[DVector<f64>], b: &[DVector<f64>]| -> f64 {
        a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
    };
    let hidden: Vec<DVector<f64>> = rows.iter().map(|rows| rows.values.clone()).collect();
    let count = varied.len();
    let normal = DMatrix::from_fn(count, count, |i, j| dot(&varied[i].1, &varied[j].1));
    let right = DVector::from_iterator(count, varied.iter().map(|(_, trace)| dot(trace, &hidden)));
    let together = TOGETHER.min(suspects.len());
    let sets = sets(suspects, together);
    let fitted = sets.into_iter().filter(|set| !fits_any_curve(set));
    let fitted = parallel_map(fitted, |set| {
        let is_in = |owner: Option<EffectId>| owner.is_none_or(|owner| set.contains(&owner));
        let at: Vec<usize> = (0..count).filter(|&at| is_in(varied[at].0)).collect();
        let (shares, taken) = least_squares(&normal, &right, &at)?;
        taken.is_finite().then_some((at, shares, taken))
    });
    let (at, shares, _) = fitted
        .into_iter()
        .flatten()
        .max_by(|(_, _, a), (_, _, b)| a.total_cmp(b))?;
    let left: Vec<DVector<f64>> = hidden
        .iter()
        .enumerate()
        .map(|(index, hidden)| {
            let mut left = hidden.clone();
            for (&at, share) in at.iter().zip(shares.iter()) {
                left -= &varied[at].1[index] * *share;
            }
            left
        })
        .collect();
    Some(worst(&segments, &rows, &left))
}

/// The starts of a segment, each with one unknown changed.
fn start_steps(segment: &Segment) -> Vec<Beginning> {
    let noise = |output: Output| {
        let channel = segment.record.channel(output);
        STEP * channel.map_or(1.0, |channel| channel.noise_std)
    };
    let from = segment.from;
    Nuisance::of(segment.record)
        .into_iter()
        .filter_map(|local| match local {
            Nuisance::Angle => Some(Beginning {
                angle_rad: from.angle_rad + noise(Output::Angle),
                ..from
            }),
            Nuisance::Rate => Some(Beginning {
                rate_rad_s: from.rate_rad_s + noise(Output::Rate),
                ..from
            }),
            Nuisance::WheelSpeed => Some(Beginning {
                wheel_speed_rad_s: from.wheel_speed_rad_s + noise(Output::WheelSpeed),
                ..from
            }),
            // The exam's logs have a recorded current and no quantised angle; the other unknowns act with certain
            // effects only.
            _ => None,
        })
        .collect()
}

/// An orthonormal basis of the space that the columns span; `None` if it is empty.
fn orthonormal(columns: &[DVector<f64>]) -> Option<DMatrix<f64>> {
    let columns: Vec<DVector<f64>> = columns
        .iter()
        .filter(|column| column.norm() > 0.0 && column.norm().is_finite())
        .map(|column| column / column.norm())
        .collect();
    if columns.is_empty() {
        return None;
    }
    Some(DMatrix::from_columns(&columns).qr().q())
}

/// The largest root mean square of a trace over all series.
fn worst(segments: &[Segment], rows: &[Rows], trace: &[DVector<f64>]) -> f64 {
    let series = segments
        .iter()
        .map(|segment| segment.first_series + segment.record.channels.len())
        .max();
    let mut sums = vec![(0.0, 0usize); series.unwrap_or(0)];
    for ((segment, rows), trace) in segments.iter().zip(rows).zip(trace) {
        for (&(channel, _), value) in rows.places.iter().zip(trace.iter()) {
            let sum = &mut sums[segment.first_series + channel];
            *sum = (sum.0 + value * value, sum.1 + 1);
        }
    }
    sums.into_iter()
        .filter(|(_, count)| *count > 0)
        .map(|(sum, count)| (sum / count as f64).sqrt())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::super::experiments::Choice;
    use super::super::question::effects;
    use super::super::shape::place;
    use super::super::size::{base_fit, make, worst};
    use super::*;
    use crate::bench_plan::{ChannelNoise, DriveProgram, ExperimentPlan};
    use crate::truth::Outsider;
    use plant::Kind;

    /// For a bench with two free swings: the misfit of the base model, and the misfit that remains beside these
    /// suspects.
    fn left(hidden: Hidden, suspects: &[EffectId]) -> (f64, f64) {
        let truth = Truth {
            base: [2.30344e-3, 1.36125e-4, 0.245158, 0.0335],
            body_viscous: 2.12e-5,
            wheel_viscous: 1.75204e-5,
            hidden: vec![hidden],
        };
        let swing = |angle_rad: f64| ExperimentPlan {
            name: format!("free swing {angle_rad} rad"),
            kind: Kind::FreeSwing,
            angle_rad,
            wheel_speed_rad_s: 0.0,
            driving: DriveProgram::None,
            duration_s: 12.0,
            sample_s: 0.005,
        };
        let choice = Choice {
            plans: vec![swing(0.9), swing(0.3)],
            has_rate: true,
            known: [None, None, Some(truth.base[2]), None],
            measured: bench_files::Known::default(),
            top: (1.0, 500.0),
        };
        let noise = ChannelNoise {
            std: [1e-3, 5e-3, 0.5],
        };
        let made = make(&truth, &choice, &noise, 1).expect("logs");
        let fit = base_fit(&made.clean, &truth).expect("a fit");
        let size = worst(&made.clean.all_records(), &fit.traces);
        let place = place(&truth, choice.top);
        let left = left_by_combinations(&made.clean, &fit, suspects, &place).expect("finite");
        (size, left)
    }

    #[test]
    fn a_suspect_takes_its_own_trace() {
        let drag = EffectId::BodyQuadraticDrag;
        let hidden = || Hidden::Library(drag, vec![5e-6]);
        let (size, with) = left(hidden(), &[drag]);
        assert!(size > 3.0, "{size}");
        // Only the part of the trace that is not linear in the amplitude remains.
        assert!(with < 0.1 * size, "{with} of {size}");
        // An unrelated suspect explains hardly any of the trace.
        let (_, beside) = left(hidden(), &[EffectId::GyroBias]);
        assert!(beside > 0.9 * size, "{beside} of {size}");
    }

    #[test]
    fn more_suspects_leave_less() {
        let magnet = || Hidden::Outsider(Outsider::MagnetNearAnAngle, [8e-3, 0.15, 0.05]);
        let (size, none) = left(magnet(), &[]);
        assert!((none - size).abs() < 0.05 * size, "{none} of {size}");
        let (_, all) = left(magnet(), &effects());
        assert!(all < none && all > 0.02 * size, "{all} of {size}");
    }
}
