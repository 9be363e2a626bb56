//! The open bench, and the notification of pages about its changes.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::broadcast;
use workbench::{
    ComparisonReport, DiagnosisReport, EffectFingerprint, Error, GeneratedController, ModelFile,
    PerSeries, Predictor, Progress, Proof, Session,
};

use crate::dropped::Dropped;
use crate::outside::KnownFiles;
use crate::running::Running;

/// Number of events by which a slow page may lag before it misses some.
const EVENTS: usize = 256;
/// Largest number of changes that can be undone.
const MOST_UNDONE: usize = 100;

/// The state of the server.
pub struct Desk {
    state: Mutex<DeskState>,
    dropped: Mutex<Dropped>,
    events: broadcast::Sender<String>,
}

/// The part of the state that changes while the server runs.
#[derive(Default)]
pub struct DeskState {
    /// The bench, as the last task left it.
    pub bench: Option<Arc<OpenBench>>,
    /// The task that is running.
    pub running: Option<Running>,
    /// The reason why the last task failed.
    pub failure: Option<String>,
    /// Number of tasks started so far.
    pub count: u64,
}

impl Desk {
    /// The state without an open bench.
    pub fn new() -> Desk {
        Desk {
            state: Mutex::default(),
            dropped: Mutex::default(),
            events: broadcast::Sender::new(EVENTS),
        }
    }

    /// The present state.
    pub fn state(&self) -> MutexGuard<'_, DeskState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The files that were dropped on the page.
    pub fn dropped(&self) -> MutexGuard<'_, Dropped> {
        self.dropped.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The open bench.
    pub fn bench(&self) -> Option<Arc<OpenBench>> {
        self.state().bench.clone()
    }

    /// The names of the files of the open bench that another program has changed. While work is under way there are
    /// none: it may be the work that writes.
    pub fn changed_outside(&self) -> Vec<String> {
        let bench = {
            let state = self.state();
            state.bench.clone().filter(|_| state.running.is_none())
        };
        bench.map_or_else(Vec::new, |bench| bench.changed_outside())
    }

    /// Sends an event to every page.
    pub fn tell(&self, event: &serde_json::Value) {
        // Without a listening page, the event is dropped.
        let _ = self.events.send(event.to_string());
    }

    /// Receives the events sent from now on.
    pub fn listen(&self) -> broadcast::Receiver<String> {
        self.events.subscribe()
    }
}

/// A bench, its model compared with the measurements, and the results since it was opened.
#[derive(Clone)]
pub struct OpenBench {
    /// A number that differs each time a folder is read.
    pub opened: u32,
    /// The bench's folder, without symlinks.
    pub folder: PathBuf,
    /// The session.
    pub session: Session,
    /// The model compared with the measurements.
    pub comparison: ComparisonReport,
    /// The experiments for sliders.
    pub predictor: Predictor,
    /// The last diagnosis, as long as it concerns the present model or made it.
    pub diagnosis: Option<Arc<Diagnosed>>,
    /// The fingerprints of effects beside the present model that the page has asked for so far.
    pub fingerprints: Vec<Arc<EffectFingerprint>>,
    /// The error after each change.
    pub staircase: Vec<Stair>,
    /// The earlier states for undo.
    pub undo: Vec<Before>,
    /// The controller that was generated last.
    pub generated: Option<GeneratedController>,
    /// The result of its proof.
    pub proof: Option<Proof>,
    /// The reason why the model could not be written, if so.
    pub unsaved: Option<String>,
    /// Its files when they were last read or written.
    known: KnownFiles,
}

/// A diagnosis, with the comparison of the model from which it started.
pub struct Diagnosed {
    /// The verdict with its evidence.
    pub report: DiagnosisReport,
    /// The comparison of the diagnosed model.
    pub first: ComparisonReport,
    /// Whether its last step is the present model.
    pub applied: bool,
}

/// The error after a change of the model.
#[derive(Clone, serde::Serialize)]
pub struct Stair {
    /// The change, such as "+ body-coulomb-friction".
    pub label: String,
    /// Root mean square errors, SI units.
    pub rmse: PerSeries,
}

/// An earlier state, to which a change can be undone.
#[derive(Clone)]
pub struct Before {
    model: Option<ModelFile>,
    stairs: usize,
    diagnosis: Option<Arc<Diagnosed>>,
}

impl OpenBench {
    /// Opens a bench and compares its model. If it has no model, the base model is fitted.
    pub fn open(path: &Path, refit: bool, progress: &Progress) -> Result<OpenBench, String> {
        let folder = crate::folder::of_bench(path)?;
        (progress.say)("reading the files");
        let mut session = Session::open(&folder).map_err(said)?;
        crate::folder::holds_its_files(&folder, session.bench())?;
        let logs = session.bench().experiments.iter();
        let logs = logs.map(|experiment| folder.join(&experiment.file));
        let known = KnownFiles::now(&folder, session.model_path(), logs);
        let (comparison, label) = match session.model() {
            Some(_) if refit => (session.identify(progress), "refitted"),
            Some(_) => (session.compare(progress), "as it was"),
            None => (session.identify_base(progress), "base model"),
        };
        let comparison = comparison.map_err(|error| match error {
            Error::ParameterMissing { .. } | Error::ParameterUnit { .. } => {
                format!("{error}; open it again with \"fit its model anew\"")
            }
            error => error.to_string(),
        })?;
        let predictor = session.predictor(progress).map_err(said)?;
        let staircase = vec![Stair {
            label: label.to_owned(),
            rmse: comparison.rmse.clone(),
        }];
        let mut bench = OpenBench {
            opened: rand::random(),
            folder,
            session,
            comparison,
            predictor,
            diagnosis: None,
            fingerprints: Vec::new(),
            staircase,
            undo: Vec::new(),
            generated: None,
            proof: None,
            unsaved: None,
            known,
        };
        if label != "as it was" {
            bench.save();
        }
        Ok(bench)
    }

    /// The names of the files that another program has changed since. A model that could not be written differs from
    /// its file in any case.
    pub fn changed_outside(&self) -> Vec<String> {
        self.known.changed(self.unsaved.is_none())
    }

    /// Stores the present model for undo.
    pub fn remember(&mut self) {
        self.undo.push(Before {
            model: self.session.model().cloned(),
            stairs: self.staircase.len(),
            diagnosis: self.diagnosis.clone(),
        });
        if self.undo.len() > MOST_UNDONE {
            self.undo.remove(0);
        }
    }

    /// Updates everything that depends on the session's model after it has changed, and writes the model.
    pub fn changed(
        &mut self,
        comparison: ComparisonReport,
        label: String,
        progress: &Progress,
    ) -> Result<(), String> {
        self.predictor = self.session.predictor(progress).map_err(said)?;
        self.staircase.push(Stair {
            label,
            rmse: comparison.rmse.clone(),
        });
        self.comparison = comparison;
        self.controller_is_old();
        self.save();
        Ok(())
    }

    /// Draws what an effect looks like beside the model as it is.
    pub fn draw_fingerprint(&mut self, effect: &str, progress: &Progress) -> Result<(), String> {
        let found = self.session.fingerprint(effect, progress).map_err(said)?;
        self.fingerprints.retain(|one| one.effect != effect);
        self.fingerprints.push(Arc::new(found));
        Ok(())
    }

    /// Goes back by one change.
    pub fn undo(&mut self, progress: &Progress) -> Result<(), String> {
        let before = self.undo.pop().ok_or("there is nothing to undo")?;
        self.session.set_model(before.model.unwrap_or_default());
        self.comparison = self.session.compare(progress).map_err(said)?;
        self.predictor = self.session.predictor(progress).map_err(said)?;
        self.staircase.truncate(before.stairs.max(1));
        self.diagnosis = before.diagnosis;
        self.controller_is_old();
        self.save();
        Ok(())
    }

    /// Writes the model. If that fails, the page shows the reason and goes on.
    pub fn save(&mut self) {
        let path = self.session.model_path().to_path_buf();
        let written = crate::folder::within(&self.folder, &path)
            .and_then(|()| self.session.save_model().map_err(said));
        self.unsaved = written.err();
        self.known.model_written();
    }

    /// Discards the controller, which belongs to an earlier model.
    pub fn controller_is_old(&mut self) {
        // Those of a model that was applied from a diagnosis still show why.
        self.fingerprints.retain(|one| {
            one.with.effects == self.comparison.effects
                || one.without.effects == self.comparison.effects
        });
        self.generated = None;
        self.proof = None;
    }
}

/// An error as a sentence for the page.
pub fn said(error: Error) -> String {
    error.to_string()
}
