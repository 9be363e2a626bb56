//! Which logs of a bench, and which rows of them, a fit can use.
//!
//! A balance log is used only if its rows say which commands acted. The controller passes the noise of its sensors on and
//! answers to the motion: the commands between two rows are others than the one that a row shows. If that one is taken as
//! held, the unknown part is not noise, but follows the motion. With the gains K_α and K_ω of angle and rate, commands that
//! are old by δ on average look like an inertia that is larger by τ |K_ω| δ and a friction that is larger by τ |K_α| δ: many
//! times the standard errors, while the fit follows the log as well as before.

use bench_files::{Controller, CurrentMeaning, Experiment};
use plant::Kind;

use super::error::IdentifyError;
use crate::model_free::held_start;
use crate::records::{Record, median};

/// The name in `accept` with which rows before a release are used all the same.
pub const HELD_START: &str = "held-start";
/// The name in `accept` with which a balance log with commands between its rows is used all the same.
pub const SPARSE_COMMANDS: &str = "sparse-commands";

/// Commands of the controller per row from which some stand in no row: nearer to two than to one.
const SEVERAL: f64 = 1.5;

/// The number of commands that the controller gave per row of a balance log, if that is more than one and the log does not
/// show those between the rows; `None` else. A current that was measured is no command.
pub fn commands_per_row(experiment: &Experiment, controller: Option<&Controller>) -> Option<f64> {
    if !is_commanded(experiment) {
        return None;
    }
    let steps = experiment.log.time_s.windows(2);
    let row_s = median(steps.map(|pair| pair[1] - pair[0]))?;
    let commands = row_s / controller?.sample_time_s;
    (commands > SEVERAL).then_some(commands)
}

/// A log of the bench as a fit uses it, if it can.
pub(super) struct Selected {
    pub(super) record: Option<Record>,
    /// What is not used and why, or what is taken for granted: a sentence.
    pub(super) note: Option<String>,
}

/// Selects from one experiment what a fit can use.
pub(super) fn select(experiment: &Experiment, controller: Option<&Controller>) -> Selected {
    let accepts = |name: &str| experiment.accept.iter().any(|accepted| accepted == name);
    let name = &experiment.name;
    if let Some(commands) = commands_per_row(experiment, controller)
        && !accepts(SPARSE_COMMANDS)
    {
        return Selected {
            record: None,
            note: Some(format!(
                "{name}: the controller gave about {commands:.0} commands per row, and the log shows one of them; what acted \
                 between the rows is unknown, and the log is not used. Log every command, or the current that flowed \
                 (current_meaning = \"measured\")"
            )),
        };
    }
    let record = Record::from_experiment(experiment);
    if record.channels.is_empty() || record.is_empty() {
        return Selected {
            record: None,
            note: None,
        };
    }
    match held_start(&record).filter(|_| !accepts(HELD_START)) {
        Some(held) => Selected {
            note: Some(format!(
                "{name}: the body stands still for {:.2} s before it swings (it was held); the {} rows before its release \
                 are not used",
                held.held_s, held.rows
            )),
            record: Some(record.slice(held.rows..record.len())),
        },
        None => Selected {
            note: (controller.is_none() && is_commanded(experiment)).then(|| {
                format!(
                    "{name}: bench.toml states no [controller], so that the command of each row is taken as held until the \
                     next; if the controller gave others between the rows, what comes from this log is wrong by many \
                     standard errors. The sample_time under [controller] would tell"
                )
            }),
            record: Some(record),
        },
    }
}

/// Whether this is a balance log with the commands of its controller.
fn is_commanded(experiment: &Experiment) -> bool {
    experiment.kind == Kind::Balance
        && experiment.current_meaning == CurrentMeaning::Command
        && experiment.log.current_a.is_some()
}

/// The error of a bench of which no log can be used.
pub(super) fn nothing_selected(notes: Vec<String>) -> IdentifyError {
    if notes.is_empty() {
        IdentifyError::NoExperiments
    } else {
        IdentifyError::NothingUsable { notes }
    }
}
