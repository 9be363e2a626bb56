//! A fit from a first guess to the minimum.
//!
//! Over a hundred periods, the cost of a free-running simulation has a local minimum for every period by which
//! the phase may slip. The fit therefore begins with windows of two periods, each with its own start
//! (multiple shooting; Bock 1983), whose cost is nearly quadratic. It then lengthens the windows
//! until one window spans the log.

use parallel::parallel_map;
use plant::{EffectId, Kind, Model, Timing, period_s};

use super::cogging::settled;
use super::early::Early;
use super::effort::{Effort, Outcome};
use super::score_test::score_test;
use super::solver::{Minimum, minimise};
use super::unknowns::{Unknowns, Window};
use super::windows::{final_windows, windows};
use crate::records::{BALANCE_WINDOW_S, Record, RecordedCurrent};

/// Factor by which windows grow from one stage to the next.
const WINDOW_GROWTH: f64 = 4.0;
/// Periods in the first windows.
const FIRST_PERIODS: f64 = 2.0;

/// How the windows grow.
struct Growth {
    /// Length of the first ones, s.
    first_s: f64,
    factor: f64,
    /// Whether spin-ups are cut, too. They need it only where they are far from linear.
    cuts_spin_ups: bool,
}

impl Growth {
    /// The growth that a model asks for.
    ///
    /// A torque of any shape over the wheel's angle (a learned curve, an effect of the user's own) asks for more stages:
    /// a wheel that is wrong by a share of a turn feels another torque, which takes it further, and over a whole log
    /// the cost has a minimum for every turn that is lost. In windows of [`BALANCE_WINDOW_S`] the wheel's angle is the
    /// measured one. Cogging has starts of its own ([`super::cogging`]).
    fn for_model(model: &Model, values: &[f64]) -> Growth {
        let by_turns = model.ranges().any(|(effect, _)| {
            matches!(effect, EffectId::External(_)) && effect.info().uses_wheel_angle
        });
        if by_turns {
            Growth {
                first_s: BALANCE_WINDOW_S,
                factor: 2.0,
                cuts_spin_ups: true,
            }
        } else {
            Growth {
                first_s: FIRST_PERIODS * period_s(values),
                factor: WINDOW_GROWTH,
                cuts_spin_ups: false,
            }
        }
    }
}

/// Fits from a first guess, by the schedule of growing windows. `effort` is that of the last stage; if it is cancelled,
/// the schedule ends.
pub fn fit_from_scratch(
    records: &[&Record],
    model: &Model,
    values: Vec<f64>,
    free: &[usize],
    effort: Effort,
) -> Minimum {
    let mut nothing = |_: &[&Record], _: &Minimum| {};
    fit_in_stages(records, model, values, free, effort, &mut nothing)
}

/// As [`fit_from_scratch`]. `first` receives the minimum over the first windows, whose cost is nearly quadratic, with
/// the records that it belongs to.
pub(crate) fn fit_in_stages(
    records: &[&Record],
    model: &Model,
    values: Vec<f64>,
    free: &[usize],
    effort: Effort,
    first: &mut dyn FnMut(&[&Record], &Minimum),
) -> Minimum {
    let unknowns = Unknowns::new(model, free);
    let growth = Growth::for_model(model, &values);
    let longest_s = records
        .iter()
        .map(|record| match record.kind {
            // A spin-up is nearly linear in everything and needs no schedule.
            Kind::SpinUp if !growth.cuts_spin_ups => 0.0,
            Kind::Balance => 0.0,
            Kind::SpinUp | Kind::FreeSwing | Kind::Driven => {
                let span_s =
                    record.time_s.last().unwrap_or(&0.0) - record.time_s.first().unwrap_or(&0.0);
                span_s.min(record.window_s)
            }
        })
        .fold(0.0, f64::max);
    let mut window_s = growth.first_s;
    let early: Vec<Option<Early>> =
        parallel_map(records, |record| Early::of(record, model, &values));
    // Where a log is dense, all stages come before the last one.
    let mut is_early = early.iter().any(Option::is_some);
    let mut values = values;
    let mut current: Vec<Vec<Window>> = vec![vec![]; records.len()];
    let mut is_first = true;
    loop {
        let is_longest = window_s >= longest_s;
        let last = is_longest && !is_early;
        let length_s = if is_longest { f64::INFINITY } else { window_s };
        let in_stage: Vec<&Record> = records
            .iter()
            .zip(&early)
            .map(|(&record, early)| match early {
                Some(early) if is_early => &early.record,
                _ => record,
            })
            .collect();
        current = in_stage
            .iter()
            .zip(&current)
            .map(|(record, before)| match record.kind {
                Kind::SpinUp if !growth.cuts_spin_ups => {
                    windows(record, &values, f64::INFINITY, before)
                }
                _ => windows(record, &values, length_s, before),
            })
            .collect();
        let stage = if last {
            effort
        } else {
            Effort::ROUGH.until(effort.cancelled)
        };
        let minimum = minimise(&in_stage, model, values, current, &unknowns, stage);
        if is_first {
            first(&in_stage, &minimum);
            is_first = false;
        }
        if last {
            return over_samples(records, model, minimum, &unknowns, effort);
        }
        if minimum.outcome == Outcome::Cancelled {
            return minimum;
        }
        values = minimum.values;
        current = minimum.windows;
        if is_longest {
            current = current
                .into_iter()
                .zip(records.iter().zip(&early))
                .map(|(windows, (record, early))| match early {
                    Some(early) => early.whole(windows, record.len()),
                    None => windows,
                })
                .collect();
            is_early = false;
        } else {
            window_s *= growth.factor;
        }
    }
}

/// Fits with windows of `window_s` seconds (where the kind of experiment allows a choice), each with its own start. The
/// cost is then nearly quadratic, even if the model lacks an effect.
pub fn fit_windowed(
    records: &[&Record],
    model: &Model,
    values: Vec<f64>,
    free: &[usize],
    window_s: f64,
    effort: Effort,
) -> Minimum {
    let windows = records
        .iter()
        .map(|record| match record.kind {
            Kind::SpinUp => final_windows(record, &values),
            _ => windows(record, &values, window_s, &[]),
        })
        .collect();
    refit(records, model, values, windows, free, effort)
}

/// Fits again from a good start: the parameters and windows of a neighbouring fit.
pub fn refit(
    records: &[&Record],
    model: &Model,
    values: Vec<f64>,
    windows: Vec<Vec<Window>>,
    free: &[usize],
    effort: Effort,
) -> Minimum {
    let windows = settled(records, model, &values, windows);
    let unknowns = Unknowns::new(model, free);
    let minimum = minimise(records, model, values, windows, &unknowns, effort);
    over_samples(records, model, minimum, &unknowns, effort)
}

/// Gain in χ² that the score test must promise for a delay of one sample more or less, before a fit is started there.
const WORTH_A_SAMPLE: f64 = 1.0;
/// Evaluations of that fit, which show whether it keeps the promise. From the middle of a sampling interval the cost
/// is nearly quadratic.
const LOOK_AT_A_SAMPLE: usize = 3;

/// Moves a delay by whole samples of the command as long as that lowers the cost.
///
/// With a held command, a delay by a fraction of a sample predicts a weighted mean of two neighbouring commands. The
/// mean contains less of the noise in the command (a controller passes the sensors' noise on). The cost can
/// therefore have a local minimum between any two samples, where a descent gets stuck.
fn over_samples(
    records: &[&Record],
    model: &Model,
    found: Minimum,
    unknowns: &Unknowns,
    effort: Effort,
) -> Minimum {
    if found.outcome == Outcome::Cancelled {
        return found;
    }
    let delay = model.find(|info| info.timing == Some(Timing::Delay));
    let (Some((effect, at)), Some(sample_s)) = (
        delay.filter(|(_, at)| unknowns.free.contains(at)),
        shortest_sample_s(records),
    ) else {
        return found;
    };
    let all = vec![true; unknowns.free.len()];
    let look = Effort {
        evaluations: LOOK_AT_A_SAMPLE,
        ..Effort::ROUGH.until(effort.cancelled)
    };
    let mut best = found;
    let mut has_moved = false;
    for direction in [1.0, -1.0] {
        loop {
            let middle = (best.values[at] / sample_s).floor() + 0.5;
            let next_s = (middle + direction) * sample_s;
            let (low, high) = effect.info().parameters[0].bounds;
            if next_s < low || next_s > high || !best.cost.is_finite() {
                break;
            }
            let mut values = best.values.clone();
            values[at] = next_s;
            let score_test = score_test(records, model, &values, &best.windows, unknowns, None);
            let goal = best.cost - WORTH_A_SAMPLE;
            if score_test.step(&values, unknowns, &all).cost > goal {
                break;
            }
            let windows = best.windows.clone();
            let next = minimise(records, model, values, windows, unknowns, look);
            if next.cost > goal || next.outcome == Outcome::Cancelled {
                break;
            }
            best = next;
            has_moved = true;
        }
        // After a move in one direction, the other direction leads back to higher costs.
        if has_moved {
            break;
        }
    }
    if has_moved {
        best = minimise(records, model, best.values, best.windows, unknowns, effort);
    }
    best
}

/// The shortest time for which a recorded command is held, in s; `None` if no record has a held command.
fn shortest_sample_s(records: &[&Record]) -> Option<f64> {
    let held = records.iter().filter_map(|record| match &record.current {
        RecordedCurrent::Known(input) if record.kind != Kind::FreeSwing => input.held_s(),
        _ => None,
    });
    held.min_by(f64::total_cmp)
}
