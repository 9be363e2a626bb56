//! A bench prepared for fits: its records with pushes left out, its known values, and how its logs are windowed.

use std::borrow::Cow;

use bench_files::{Bench, Known};
use parallel::parallel_map;
use plant::{GRAVITY_TORQUE, Kind, Model, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA};

use super::error::IdentifyError;
use super::selection::{nothing_selected, select};
use super::toothed::Toothed;
use crate::fit::{base_values, ratios};
use crate::records::{BALANCE_WINDOW_S, Output, Record, RecordedCurrent, join_early_steps};
use crate::residuals::{PushModel, find_disturbances, leave_out};

/// A bench prepared for fits: its records, and the values that are given.
#[derive(Clone, Debug)]
pub struct FitProblem {
    /// The experiments, in the order of bench.toml.
    pub records: Vec<Record>,
    /// Values of the base parameters (positions 0 to 3) that are given, or set to 1 to fix the scale.
    pub known: [Option<f64>; 4],
    /// Whether torques on the body are known in N m; otherwise they are per unit of Θ.
    pub body_scale_known: bool,
    /// Whether torques on the wheel are known in N m; otherwise they are per unit of j_w.
    pub wheel_scale_known: bool,
    /// Whether an experiment moves body and wheel together, so that they share one scale.
    pub coupled: bool,
    /// Masses and lengths, from which the inertia of the body alone follows.
    pub masses: Known,
    /// What of the logs is not used, and what is taken for granted of them: one sentence each.
    pub notes: Vec<String>,
    /// The teeth of the motor, if dense logs were searched for them.
    pub(super) toothed: Toothed,
}

impl FitProblem {
    /// Prepares a bench that was loaded from disk. Logs that are far denser than their motion are replaced by block
    /// averages ([`Record::averaged`]). Left out are rows of a swing from before its release ([`crate::held_start`]) and
    /// balance logs that do not show every command ([`crate::commands_per_row`]), unless bench.toml accepts them.
    ///
    /// # Errors
    /// [`IdentifyError::NoExperiments`] if no experiment has a usable channel; [`IdentifyError::NothingUsable`] if all logs
    /// are left out.
    pub fn new(bench: &Bench) -> Result<FitProblem, IdentifyError> {
        let controller = bench.controller.as_ref();
        let selected = parallel_map(&bench.experiments, |one| select(one, controller));
        let (mut records, mut notes) = (vec![], vec![]);
        for one in selected {
            records.extend(one.record);
            notes.extend(one.note);
        }
        if records.is_empty() {
            return Err(nothing_selected(notes));
        }
        let mut known = [None; 4];
        known[TOTAL_INERTIA] = bench.known.total_inertia;
        known[WHEEL_INERTIA] = bench.known.wheel_inertia;
        known[GRAVITY_TORQUE] = bench.known.gravity_torque().ok();
        known[TORQUE_CONSTANT] = bench.known.torque_constant;
        let problem = FitProblem::prepared(records, known, bench.known, true)?;
        Ok(FitProblem { notes, ..problem })
    }

    /// Prepares records with the given base parameters.
    ///
    /// # Errors
    /// [`IdentifyError::NoExperiments`] if there is no record.
    pub fn from_records(
        records: Vec<Record>,
        known: [Option<f64>; 4],
        masses: Known,
    ) -> Result<FitProblem, IdentifyError> {
        FitProblem::prepared(records, known, masses, false)
    }

    /// As [`FitProblem::from_records`], with logs that are far denser than their motion treated as [`FitProblem::new`] does.
    ///
    /// # Errors
    /// [`IdentifyError::NoExperiments`] if there is no record.
    pub fn from_dense_records(
        records: Vec<Record>,
        known: [Option<f64>; 4],
        masses: Known,
    ) -> Result<FitProblem, IdentifyError> {
        FitProblem::prepared(records, known, masses, true)
    }

    fn prepared(
        records: Vec<Record>,
        known: [Option<f64>; 4],
        masses: Known,
        average: bool,
    ) -> Result<FitProblem, IdentifyError> {
        if records.is_empty() {
            return Err(IdentifyError::NoExperiments);
        }
        let mut records = records;
        join_early_steps(&mut records);
        let coupled = records.iter().any(|record| {
            matches!(record.kind, Kind::Balance | Kind::Driven)
                && !matches!(record.current, RecordedCurrent::Unknown)
        });
        let body = known[TOTAL_INERTIA].is_some() || known[GRAVITY_TORQUE].is_some();
        let of_wheel = |record: &&Record| record.kind != Kind::FreeSwing;
        let nobody_wrote = |record: &Record| matches!(record.current, RecordedCurrent::Unknown);
        // A torque constant says how large a torque is only where a current flowed: in a coast-down none does.
        let driven = records.iter().filter(of_wheel).any(|record| {
            !nobody_wrote(record) && record.current_a.iter().any(|current| *current != 0.0)
        });
        let wheel = known[WHEEL_INERTIA].is_some() || (known[TORQUE_CONSTANT].is_some() && driven);
        let (body, wheel) = if coupled {
            (body || wheel, body || wheel)
        } else {
            (body, wheel)
        };
        let mut known = known;
        if !body {
            known[TOTAL_INERTIA] = Some(1.0);
        }
        if !wheel && !coupled {
            known[WHEEL_INERTIA] = Some(1.0);
            // Per unit of inertia the torque constant is another number than the stated one.
            if !records.iter().filter(of_wheel).any(nobody_wrote) {
                known[TORQUE_CONSTANT] = None;
            }
        }
        let mut problem = FitProblem {
            records,
            known,
            body_scale_known: body,
            wheel_scale_known: wheel,
            coupled,
            masses,
            notes: vec![],
            toothed: Toothed::NotSought,
        };
        if average {
            problem.average_dense_logs();
        }
        let (known, mut records) = (problem.known, std::mem::take(&mut problem.records));
        // The guess of the parameters decides what is a push, and pushes distort the guess. Two rounds are enough: a
        // push exceeds its threshold by a factor, while the guess is off by some percent.
        for _ in 0..2 {
            let all: Vec<&Record> = records.iter().collect();
            let (base, body_friction, wheel_friction) = base_values(&ratios(&all), &known);
            let model = PushModel {
                base,
                body_friction,
                wheel_friction,
            };
            for record in &mut records {
                let pushes = find_disturbances(record, &model);
                leave_out(record, &pushes, BALANCE_WINDOW_S);
            }
        }
        problem.records = records;
        problem.estimate_coarse_noise();
        Ok(problem)
    }

    /// All records, in the order of the bench.
    pub fn all_records(&self) -> Vec<&Record> {
        self.records.iter().collect()
    }

    /// The same bench with pushes left out that only the fitted model reveals, in addition to those that the first guess
    /// revealed; `None` if there are no more.
    pub fn with_more_pushes(&self, model: &Model, values: &[f64]) -> Option<FitProblem> {
        let push_model = PushModel::of(model, values);
        let mut again = self.clone();
        let mut changed = false;
        for record in &mut again.records {
            let before = record.weight.clone();
            let pushes = find_disturbances(record, &push_model);
            leave_out(record, &pushes, BALANCE_WINDOW_S);
            for (weight, before) in record.weight.iter_mut().zip(before) {
                changed |= *weight < before;
                *weight = weight.min(before);
            }
        }
        changed.then_some(again)
    }

    /// The same bench with driven logs in windows of [`BALANCE_WINDOW_S`]; `None` if no log would change.
    ///
    /// With cogging, a long run of the wheel depends on every standstill: at the crest of a tooth, the wheel turns back
    /// or passes depending on differences that no sensor shows. A free-running simulation of the whole log then says
    /// nothing about the model. The same holds for a balance log.
    ///
    /// Where dense logs showed teeth ([`FitProblem::shows_teeth`]), all logs with a wheel are read in windows in which the
    /// teeth can be counted, at angles that the teeth themselves tell.
    pub fn in_windows(&self) -> Option<FitProblem> {
        match &self.toothed {
            Toothed::Shown(records) => return Some(self.read_by_teeth(records)),
            Toothed::Read => return None,
            Toothed::NotSought | Toothed::Absent => {}
        }
        let mut cut = self.clone();
        let mut changed = false;
        for record in &mut cut.records {
            let is_cut = record.kind == Kind::Driven
                && record.channel(Output::WheelSpeed).is_some()
                && record.window_s > BALANCE_WINDOW_S;
            if is_cut {
                record.window_s = BALANCE_WINDOW_S;
                changed = true;
            }
        }
        changed.then_some(cut)
    }

    /// Whether dense logs showed, without a model, that their motor has teeth.
    pub fn shows_teeth(&self) -> bool {
        matches!(self.toothed, Toothed::Shown(_))
    }

    /// Whether dense logs were searched for teeth and showed none, or are read by them already.
    pub fn needs_no_windows(&self) -> bool {
        matches!(self.toothed, Toothed::Absent | Toothed::Read)
    }

    /// The same bench with these records in place of its own. What is left out of its own (pushes) is left out of them.
    fn read_by_teeth(&self, records: &[Option<Record>]) -> FitProblem {
        let mut cut = self.clone();
        for (own, by_teeth) in cut.records.iter_mut().zip(records) {
            let Some(by_teeth) = by_teeth else {
                continue;
            };
            let mut record = by_teeth.clone();
            for (weight, time_s) in record.weight.iter_mut().zip(&record.time_s) {
                let next = own.time_s.partition_point(|time| time < time_s);
                let near = next.min(own.len().saturating_sub(1));
                *weight = weight.min(own.weight[near]);
            }
            *own = record;
        }
        cut.toothed = Toothed::Read;
        cut
    }

    /// The bench with the windows that suit a model: [`FitProblem::in_windows`] for a model with cogging.
    pub fn suited_to(&self, model: &Model) -> Cow<'_, FitProblem> {
        let cut = if model.find(|info| info.ripple.is_some()).is_some() {
            self.in_windows()
        } else {
            None
        };
        cut.map_or(Cow::Borrowed(self), Cow::Owned)
    }

    /// The same bench with thinned logs, and the thinning step of each record. About `per_period` samples remain per period
    /// of the pendulum, twice as many where a current acts. A swing with a thousand samples per period says no more about
    /// the shape of a missing effect than one with a hundred. The current keeps all its samples.
    ///
    /// The period is taken from the samples, since an incomplete model may have a wrong one.
    pub fn thinned(&self, per_period: f64) -> (FitProblem, Vec<usize>) {
        let period_s = plant::period_s(&self.start_values(&Model::base()));
        let mut thin = self.clone();
        let steps: Vec<usize> = self
            .records
            .iter()
            .map(|record| {
                let (Some(first), Some(last)) = (record.time_s.first(), record.time_s.last())
                else {
                    return 1;
                };
                if record.teeth.is_some() {
                    // Its samples are as far apart as its teeth allow, and few of them count.
                    return 1;
                }
                let interval_s = (last - first) / record.len().max(2) as f64;
                let wanted_s = match record.kind {
                    Kind::FreeSwing => period_s / per_period,
                    _ => 0.5 * period_s / per_period,
                };
                ((wanted_s / interval_s).floor() as usize).max(1)
            })
            .collect();
        for (record, &step) in thin.records.iter_mut().zip(&steps) {
            if step > 1 {
                *record = record.thinned(step);
            }
        }
        (thin, steps)
    }

    /// Whether any experiment moves the body, and whether any moves the wheel, in this order.
    pub fn moved(&self) -> (bool, bool) {
        let body = self.records.iter().any(|record| {
            record.kind != Kind::SpinUp
                && (record.channel(Output::Angle).is_some()
                    || record.channel(Output::Rate).is_some())
        });
        let wheel = self.records.iter().any(|record| {
            record.kind == Kind::SpinUp
                || (record.kind != Kind::FreeSwing
                    && (record.channel(Output::WheelSpeed).is_some() || body))
        });
        (body, wheel)
    }

    /// Whether no log of a moving body shows how a wheel answers to a current: the wheel is only dragged, or its speed was
    /// not measured. Its inertia then shows only by the little torque with which its friction moves the body.
    pub fn hides_wheel_inertia(&self) -> bool {
        let answers = |record: &Record| {
            let flows = |current: &f64| *current != 0.0;
            record.channel(Output::WheelSpeed).is_some() && record.current_a.iter().any(flows)
        };
        self.coupled && !self.records.iter().any(answers)
    }
}
