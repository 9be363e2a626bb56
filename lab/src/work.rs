//! Tasks: long computations, one at a time, in a thread beside the server.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use serde::Deserialize;
use serde_json::json;
use workbench::{DesignSection, Preset, Progress, ProofSettings};

use crate::desk::{Desk, Diagnosed, OpenBench, said};
use crate::folder;
use crate::running::Running;

/// The tasks that can be requested.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "task", rename_all = "kebab-case", deny_unknown_fields)]
pub enum LabTask {
    /// Opens a bench by its folder.
    Open {
        /// The folder, or its bench.toml.
        path: PathBuf,
        /// Fits the model again instead of comparing it as it is.
        #[serde(default)]
        refit: bool,
    },
    /// Opens the demonstration bench.
    OpenDemonstration {},
    /// Creates a bench folder from the files that were dropped on the page, and opens it.
    Create {
        /// The folder; it must not be a bench.
        folder: PathBuf,
        /// The text of bench.toml.
        text: String,
    },
    /// Adds the files that were dropped on the page to the bench that is open, and reads it anew.
    AddLogs {
        /// A bench.toml with the experiments of these files.
        text: String,
    },
    /// Fits the model to all experiments, from these values of its parameters.
    Fit {
        /// Parameters by name.
        start: Vec<(String, f64)>,
    },
    /// Sets the model's parameters to these values.
    Keep {
        /// Parameters by name.
        values: Vec<(String, f64)>,
    },
    /// Diagnoses the model.
    Diagnose {},
    /// Applies the diagnosis to the model.
    Apply {},
    /// Adds an effect to the model.
    Add {
        /// Its name.
        effect: String,
    },
    /// Puts the torque that the model lacks into it as a learned curve.
    AddLearned {
        /// angle, rate, wheel_speed or wheel_angle.
        coordinate: String,
    },
    /// Writes an effect of the user into the bench folder, and puts it into the model.
    WriteEffect {
        /// Its name, without "own:".
        name: String,
        /// The text of effects/NAME.toml.
        text: String,
    },
    /// Removes an effect from the model.
    Remove {
        /// Its name.
        effect: String,
    },
    /// Draws what an effect looks like: the model without and with it.
    Fingerprint {
        /// Its name.
        effect: String,
    },
    /// Goes back by one change.
    Undo {},
    /// Writes the requirements of the controller into the model.
    KeepDesign {
        /// Weights, sample time, limit.
        wishes: DesignSection,
    },
    /// Emits the controller.
    Generate {
        /// Weights, sample time, limit.
        wishes: DesignSection,
        /// The preset for properties of sensors and drive that are not stated; with `None`, they are an error.
        #[serde(default)]
        preset: Option<Preset>,
    },
    /// Writes the emitted controller into the bench folder.
    WriteController {},
    /// Proves the claims of the emitted controller.
    Prove {},
}

impl LabTask {
    fn name(&self) -> &'static str {
        match self {
            LabTask::Open { .. } | LabTask::OpenDemonstration {} => "Opening the bench",
            LabTask::Create { .. } => "Making the bench",
            LabTask::AddLogs { .. } => "Adding the logs",
            LabTask::Fit { .. } => "Fitting",
            LabTask::Keep { .. } => "Keeping the values",
            LabTask::Diagnose {} => "Diagnosing",
            LabTask::Apply {} => "Adding what was found",
            LabTask::Add { .. } => "Adding the effect",
            LabTask::AddLearned { .. } => "Learning the curve",
            LabTask::WriteEffect { .. } => "Adding your effect",
            LabTask::Remove { .. } => "Removing the effect",
            LabTask::Fingerprint { .. } => "Drawing the fingerprint",
            LabTask::Undo {} => "Going back",
            LabTask::KeepDesign { .. } => "Keeping the design",
            LabTask::Generate { .. } => "Generating the controller",
            LabTask::WriteController {} => "Writing the controller",
            LabTask::Prove {} => "Proving",
        }
    }
}

/// Opens a bench.
///
/// # Errors
/// As for [`start`].
pub fn open(desk: &Arc<Desk>, path: PathBuf) -> Result<u64, String> {
    start(desk, LabTask::Open { path, refit: false })
}

/// Begins a computation and returns its number.
///
/// # Errors
/// A sentence, where another one is under way or the bench has changed.
pub fn start(desk: &Arc<Desk>, task: LabTask) -> Result<u64, String> {
    let name = task.name();
    let called_off = Arc::new(AtomicBool::new(false));
    let (number, bench) = {
        let mut state = desk.state();
        if let Some(running) = &state.running {
            return Err(format!("{} is still under way", running.name));
        }
        let opens = matches!(
            task,
            LabTask::Open { .. } | LabTask::OpenDemonstration {} | LabTask::Create { .. }
        );
        match &state.bench {
            None if !opens => return Err("no bench is open".to_owned()),
            Some(bench) if !opens => {
                let changed = bench.changed_outside();
                if !changed.is_empty() {
                    return Err(format!(
                        "{} changed outside of the lab: read the folder anew first",
                        changed.join(", ")
                    ));
                }
            }
            _ => {}
        }
        state.count += 1;
        state.failure = None;
        state.running = Some(Running {
            number: state.count,
            name,
            says: String::new(),
            called_off: called_off.clone(),
        });
        (state.count, state.bench.clone())
    };
    desk.tell(&json!({"event": "begun", "number": number, "name": name}));
    let own_desk = desk.clone();
    let work = move || {
        let began = Instant::now();
        let say = |what: &str| {
            if let Some(running) = &mut own_desk.state().running {
                what.clone_into(&mut running.says);
            }
            own_desk.tell(&json!({"event": "says", "number": number, "name": name, "says": what}));
        };
        let cancelled = || called_off.load(Ordering::Relaxed);
        let progress = Progress {
            say: &say,
            cancelled: &cancelled,
        };
        let result = catch_unwind(AssertUnwindSafe(|| {
            perform(&own_desk, task, bench.as_deref(), &progress)
        }));
        let result = result.unwrap_or_else(|_| {
            Err("internal error: this is a bug in flywheel, please report it".to_owned())
        });
        let failure = {
            let mut state = own_desk.state();
            state.running = None;
            match result {
                Ok(bench) => {
                    state.bench = Some(Arc::new(bench));
                    None
                }
                Err(message) => {
                    // Who has called the work off knows why it has ended.
                    state.failure = Some(message.clone()).filter(|_| !cancelled());
                    Some(message)
                }
            }
        };
        own_desk.tell(&json!({
            "event": "ended", "number": number, "name": name, "failure": failure,
            "cancelled": cancelled(), "seconds": began.elapsed().as_secs_f64(),
        }));
    };
    if let Err(error) = thread::Builder::new().name(name.to_owned()).spawn(work) {
        desk.state().running = None;
        return Err(format!("no thread can be begun: {error}"));
    }
    Ok(number)
}

/// Asks the computation under way to end.
pub fn call_off(desk: &Desk) {
    if let Some(running) = &desk.state().running {
        running.called_off.store(true, Ordering::Relaxed);
    }
}

fn perform(
    desk: &Desk,
    task: LabTask,
    bench: Option<&OpenBench>,
    progress: &Progress,
) -> Result<OpenBench, String> {
    let (path, refit) = match &task {
        LabTask::Open { path, refit } => (Some(path.clone()), *refit),
        LabTask::OpenDemonstration {} => (Some(folder::demonstration()?), false),
        LabTask::Create { folder, text } => {
            desk.dropped().write(folder, text)?;
            desk.dropped().clear();
            (Some(folder.clone()), false)
        }
        LabTask::AddLogs { text } => {
            let folder = &bench.ok_or("no bench is open")?.folder;
            desk.dropped().add_to(folder, text)?;
            desk.dropped().clear();
            (Some(folder.clone()), false)
        }
        _ => (None, false),
    };
    if let Some(path) = path {
        return OpenBench::open(&path, refit, progress);
    }
    let mut bench = bench.ok_or("no bench is open")?.clone();
    change(desk, task, &mut bench, progress)?;
    Ok(bench)
}

/// Does what is asked with a copy of the bench, which takes its place if all goes well.
fn change(
    desk: &Desk,
    task: LabTask,
    bench: &mut OpenBench,
    progress: &Progress,
) -> Result<(), String> {
    match task {
        // These open another bench: see `perform`.
        LabTask::Open { .. }
        | LabTask::OpenDemonstration {}
        | LabTask::Create { .. }
        | LabTask::AddLogs { .. } => {}
        LabTask::Fit { start } => {
            bench.remember();
            let start = borrowed(&start);
            let fitted = bench
                .session
                .identify_from(&start, progress)
                .map_err(said)?;
            bench.changed(fitted, "fitted".to_owned(), progress)?;
        }
        LabTask::Keep { values } => {
            bench.remember();
            let values = borrowed(&values);
            bench
                .session
                .set_parameters(&values, "set by hand in the lab")
                .map_err(said)?;
            let compared = bench.session.compare(progress).map_err(said)?;
            bench.changed(compared, "set by hand".to_owned(), progress)?;
        }
        LabTask::Diagnose {} => {
            let report = bench.session.diagnose(progress).map_err(said)?;
            bench.diagnosis = Some(Arc::new(Diagnosed {
                report,
                first: bench.comparison.clone(),
                applied: false,
            }));
            // The reason for the first suspect is what a person asks next.
            let suspect = bench
                .diagnosis
                .as_ref()
                .and_then(|found| found.report.suspects.first());
            if let Some(effect) = suspect.map(|suspect| suspect.effect.clone()) {
                (progress.say)("drawing the fingerprint of the first suspect");
                // The diagnosis stands without the drawing.
                let _ = bench.draw_fingerprint(&effect, progress);
            }
        }
        LabTask::Fingerprint { effect } => bench.draw_fingerprint(&effect, progress)?,
        LabTask::Apply {} => {
            let found = bench.diagnosis.clone();
            let found = found.ok_or("there is no diagnosis yet: diagnose first")?;
            bench.remember();
            bench.session.apply(&found.report);
            let steps = found.report.steps.iter().skip(1);
            let stairs = steps.map(|step| (step_label(step), step.rmse.clone()));
            let mut stairs: Vec<_> = stairs.collect();
            let last = stairs.pop();
            for (label, rmse) in stairs {
                bench.staircase.push(crate::desk::Stair { label, rmse });
            }
            let label = last.map_or("refitted".to_owned(), |(label, _)| label);
            // A learned curve stays in the model, but not in the last step of the diagnosis.
            let last = match bench.session.learned_coordinates().is_empty() {
                true => found.report.last.clone(),
                false => bench.session.compare(progress).map_err(said)?,
            };
            bench.changed(last, label, progress)?;
            bench.diagnosis = Some(Arc::new(Diagnosed {
                report: found.report.clone(),
                first: found.first.clone(),
                applied: true,
            }));
        }
        LabTask::Add { effect } => {
            bench.remember();
            let change = bench.session.add_effect(&effect, progress).map_err(said)?;
            bench.changed(change.after, format!("+ {effect}"), progress)?;
        }
        LabTask::AddLearned { coordinate } => {
            bench.remember();
            let change = bench.session.add_learned(&coordinate, progress);
            let label = format!("+ learned curve over {}", coordinate.replace('_', " "));
            bench.changed(change.map_err(said)?.after, label, progress)?;
        }
        LabTask::WriteEffect { name, text } => {
            bench.remember();
            folder::write_effect(&bench.folder, &name, &text)?;
            bench.session.reread_own_effects().map_err(said)?;
            let effect = format!("own:{name}");
            let has_it = bench.comparison.effects.contains(&effect);
            let (after, label) = if has_it {
                let refitted = bench.session.identify(progress).map_err(said)?;
                (refitted, format!("{effect} as it reads now"))
            } else {
                let change = bench.session.add_effect(&effect, progress).map_err(said)?;
                (change.after, format!("+ {effect}"))
            };
            bench.changed(after, label, progress)?;
        }
        LabTask::Remove { effect } => {
            bench.remember();
            let change = bench
                .session
                .remove_effect(&effect, progress)
                .map_err(said)?;
            bench.changed(change.after, format!("− {effect}"), progress)?;
        }
        LabTask::Undo {} => bench.undo(progress)?,
        LabTask::KeepDesign { wishes } => {
            bench.remember();
            let designed = bench.session.design_for(wishes).map_err(said)?;
            bench.session.set_model(designed.file().clone());
            bench.save();
        }
        LabTask::Generate { wishes, preset } => {
            (progress.say)("emitting the controller");
            let designed = bench.session.design_for(wishes).map_err(said)?;
            bench.generated = Some(designed.generate(preset).map_err(said)?);
            bench.proof = None;
        }
        LabTask::WriteController {} => {
            let controller = bench.generated.as_ref();
            let controller = controller.ok_or("there is no controller yet: generate it first")?;
            let into = bench.folder.join(CONTROLLER);
            folder::within(&bench.folder, &into)?;
            bench_files::can_write_into(&into).map_err(|error| error.to_string())?;
            controller.write(&into).map_err(said)?;
        }
        LabTask::Prove {} => {
            let controller = bench.generated.as_ref();
            let controller = controller.ok_or("there is no controller yet: generate it first")?;
            let settings = ProofSettings {
                kani: false,
                ..Default::default()
            };
            // The page's table fills as claim after claim is settled.
            let tell = |claim: &_| desk.tell(&json!({"event": "claim", "claim": claim}));
            let proof = controller.prove_telling(&settings, progress, &tell);
            bench.proof = Some(proof.map_err(said)?);
        }
    }
    Ok(())
}

/// The folder in the bench's folder into which the controller is written.
pub const CONTROLLER: &str = "controller";

/// The result of a step of a diagnosis.
fn step_label(step: &workbench::DiagnosisStep) -> String {
    let mut label = match &step.effect {
        Some(effect) => format!("+ {effect}"),
        None => String::new(),
    };
    if !step.replaces.is_empty() {
        label = format!("{label} − {}", step.replaces.join(", "));
    }
    label.trim().to_owned()
}

fn borrowed(values: &[(String, f64)]) -> Vec<(&str, f64)> {
    let pairs = values.iter();
    pairs.map(|(name, value)| (name.as_str(), *value)).collect()
}
