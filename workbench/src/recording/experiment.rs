//! The experiments that can be recorded: for each, the tasks of the firmware, and when the record begins and ends.

use std::fmt;
use std::str::FromStr;

use plant::Kind;
use serde::{Deserialize, Serialize};
use serial_frame::Task;

use super::RecordSettings;
use super::words::Words;

/// An experiment that can be recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RecordedExperiment {
    /// The wheel is locked to the body, which is deflected by hand and let go.
    FreeSwing,
    /// The body is clamped upright, the wheel is driven with a constant current.
    SpinUp,
    /// The body is clamped upright, the wheel is driven, then it coasts.
    CoastDown,
    /// The controller balances the body.
    Balance,
    /// Bring-up: the body hangs at rest.
    Hanging,
    /// Bring-up: the body is held tilted towards positive angles.
    Tilted,
    /// Bring-up: the wheel is spun by hand in the sense of positive speeds.
    WheelSpun,
    /// Bring-up: the body is held upright, a positive current flows.
    CurrentStep,
}

impl RecordedExperiment {
    /// All experiments.
    pub const ALL: &[RecordedExperiment] = &[
        RecordedExperiment::FreeSwing,
        RecordedExperiment::SpinUp,
        RecordedExperiment::CoastDown,
        RecordedExperiment::Balance,
        RecordedExperiment::Hanging,
        RecordedExperiment::Tilted,
        RecordedExperiment::WheelSpun,
        RecordedExperiment::CurrentStep,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            RecordedExperiment::FreeSwing => "free-swing",
            RecordedExperiment::SpinUp => "spin-up",
            RecordedExperiment::CoastDown => "coast-down",
            RecordedExperiment::Balance => "balance",
            RecordedExperiment::Hanging => "hanging",
            RecordedExperiment::Tilted => "tilted",
            RecordedExperiment::WheelSpun => "wheel-spun",
            RecordedExperiment::CurrentStep => "current-step",
        }
    }

    /// The instruction to the person at the bench.
    pub fn instruction(self) -> &'static str {
        match self {
            RecordedExperiment::FreeSwing => {
                "lock the wheel to the body, let it hang still, then deflect it by hand and let go"
            }
            RecordedExperiment::SpinUp | RecordedExperiment::CoastDown => {
                "clamp the body upright; the wheel is driven"
            }
            RecordedExperiment::Balance => {
                "hold the body upright and still until it balances, then let go"
            }
            RecordedExperiment::Hanging => "let the body hang still",
            RecordedExperiment::Tilted => "hold the body still, tilted towards positive angles",
            RecordedExperiment::WheelSpun => "spin the wheel by hand towards positive speeds",
            RecordedExperiment::CurrentStep => "clamp the body upright; a positive current flows",
        }
    }

    /// Usual length of a log in s: the time in which a free swing dies out, or a wheel reaches its largest speed.
    pub fn usual_seconds(self) -> f64 {
        match self {
            RecordedExperiment::FreeSwing => 40.0,
            RecordedExperiment::SpinUp => 8.0,
            RecordedExperiment::CoastDown => 30.0,
            RecordedExperiment::Balance => 20.0,
            RecordedExperiment::Hanging
            | RecordedExperiment::Tilted
            | RecordedExperiment::WheelSpun => 3.0,
            RecordedExperiment::CurrentStep => 1.0,
        }
    }

    /// Usual currents, as shares of the current limit. Both signs are driven, because they tell friction from an offset
    /// of the drive.
    fn usual_shares(self) -> &'static [f64] {
        match self {
            RecordedExperiment::SpinUp => &[0.1, 0.2, -0.2],
            RecordedExperiment::CoastDown => &[0.2],
            RecordedExperiment::CurrentStep => &[0.1],
            _ => &[],
        }
    }

    /// Whether the motor is driven with a stated current.
    pub fn takes_current(self) -> bool {
        !self.usual_shares().is_empty()
    }

    fn bring_up_key(self) -> Option<&'static str> {
        match self {
            RecordedExperiment::Hanging => Some("hanging"),
            RecordedExperiment::Tilted => Some("tilted"),
            RecordedExperiment::WheelSpun => Some("wheel_spun"),
            RecordedExperiment::CurrentStep => Some("current_step"),
            _ => None,
        }
    }

    fn kind(self) -> Kind {
        match self {
            RecordedExperiment::SpinUp | RecordedExperiment::CoastDown => Kind::SpinUp,
            RecordedExperiment::Balance => Kind::Balance,
            _ => Kind::FreeSwing,
        }
    }

    /// The tasks of the firmware, one after another. `current_a` is the current in A of experiments that drive the
    /// motor.
    fn stretches(self, current_a: f64, seconds: f64) -> Vec<Stretch> {
        let stretch = |task: Task, seconds: f64| Stretch { task, seconds };
        match self {
            RecordedExperiment::SpinUp => vec![stretch(drive(current_a), seconds)],
            // A step needs something before it.
            RecordedExperiment::CurrentStep => vec![
                stretch(drive(0.0), WITHOUT_CURRENT_BEFORE_STEP_S),
                stretch(drive(current_a), seconds),
            ],
            RecordedExperiment::CoastDown => vec![
                stretch(drive(current_a), DRIVEN_BEFORE_COASTING_S),
                stretch(drive(0.0), seconds),
            ],
            RecordedExperiment::Balance => vec![stretch(Task::Balance, seconds)],
            _ => vec![stretch(Task::Watch, seconds)],
        }
    }

    /// The default name of a log.
    fn log_name(self, current_a: f64) -> String {
        match self {
            RecordedExperiment::SpinUp | RecordedExperiment::CurrentStep => {
                format!("{self} {current_a} A")
            }
            RecordedExperiment::CoastDown => self.to_string(),
            _ => self.to_string().replace('-', " "),
        }
    }
}

impl fmt::Display for RecordedExperiment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for RecordedExperiment {
    type Err = String;

    fn from_str(text: &str) -> Result<RecordedExperiment, String> {
        RecordedExperiment::ALL
            .iter()
            .copied()
            .find(|one| one.name() == text)
            .ok_or_else(|| {
                let names: Vec<&str> = RecordedExperiment::ALL
                    .iter()
                    .map(|one| one.name())
                    .collect();
                format!(
                    "there is no experiment \"{text}\" to record; there are {}",
                    names.join(", ")
                )
            })
    }
}

/// A stretch in which the firmware has one task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub task: Task,
    pub seconds: f64,
}

/// One log.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    /// The name that was asked for, or the default name.
    pub name: String,
    pub kind: Kind,
    /// The key under `[bring_up]` of a recording of raw counts; `None` for a log.
    pub bring_up: Option<&'static str>,
    pub experiment: RecordedExperiment,
    /// The tasks, one after another.
    pub stretches: Vec<Stretch>,
    /// Whether the record begins when the controller runs, and ends when it stops running.
    pub needs_running: bool,
    /// Whether the record begins only when the attitude is known.
    pub needs_attitude: bool,
    /// Whether the record begins only when the wheel is nearly at rest.
    pub from_rest: bool,
    pub notes: Vec<String>,
}

/// Time for which the wheel is driven before it coasts, s.
const DRIVEN_BEFORE_COASTING_S: f64 = 3.0;

/// Time without current before the step of `current-step`, s: long enough for the noise of the wheel's word.
const WITHOUT_CURRENT_BEFORE_STEP_S: f64 = 0.5;

/// The logs of an experiment. If the settings do not fit, the error is a sentence.
pub(super) fn parts(settings: &RecordSettings, words: &Words) -> Result<Vec<Part>, String> {
    let experiment = settings.experiment;
    let seconds = settings.seconds.unwrap_or(experiment.usual_seconds());
    if !(seconds.is_finite() && seconds > 0.0) {
        return Err(format!(
            "a record cannot last {seconds} s; state a length in s greater than zero"
        ));
    }
    let limit_a = words.current_limit_a;
    let mut currents_a = settings.currents_a.clone();
    if !experiment.takes_current() && !currents_a.is_empty() {
        return Err(format!(
            "{experiment} takes no current, because its motor is not driven with a stated current; leave the current out"
        ));
    }
    if currents_a.is_empty() {
        let usual = experiment.usual_shares().iter();
        // Two digits, as a person would state it.
        currents_a.extend(usual.map(|share| (100.0 * share * limit_a).round() / 100.0));
    }
    if experiment != RecordedExperiment::SpinUp {
        currents_a.truncate(1);
    }
    for current_a in &currents_a {
        if !current_a.is_finite() || current_a.abs() > limit_a || *current_a == 0.0 {
            return Err(format!(
                "a current of {current_a} A cannot be driven; state a current within ±{limit_a} A, the current \
                 limit, and not zero"
            ));
        }
    }
    let part = |name: String, stretches: Vec<Stretch>| Part {
        name: settings.name.clone().unwrap_or(name),
        kind: experiment.kind(),
        bring_up: experiment.bring_up_key(),
        experiment,
        needs_running: stretches.iter().any(|one| one.task != Task::Watch),
        needs_attitude: experiment == RecordedExperiment::FreeSwing,
        from_rest: experiment == RecordedExperiment::SpinUp,
        stretches,
        notes: Vec::new(),
    };
    // An experiment without a current is one log.
    if currents_a.is_empty() {
        currents_a.push(0.0);
    }
    Ok(currents_a
        .iter()
        .map(|&current_a| {
            part(
                experiment.log_name(current_a),
                experiment.stretches(current_a, seconds),
            )
        })
        .collect())
}

pub(super) fn drive(current_a: f64) -> Task {
    Task::Drive {
        // The limit of the drive is far below 2 147 A.
        current_ua: (1e6 * current_a).round() as i32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheel_that_coasts_was_driven_before() {
        let stretches = RecordedExperiment::CoastDown.stretches(0.2, 30.0);
        let tasks: Vec<Task> = stretches.iter().map(|stretch| stretch.task).collect();
        assert_eq!(tasks, [drive(0.2), drive(0.0)]);
        assert_eq!(stretches[1].seconds, 30.0);
    }
}
