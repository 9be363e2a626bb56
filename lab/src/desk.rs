//! The open bench, and who is told what happens to it.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::broadcast;
use workbench::{
    ComparisonReport, DiagnosisReport, EffectFingerprint, Error, GeneratedController, ModelFile,
    PerSeries, Predictor, Progress, Proof, Session,
};

use crate::dropped::Dropped;
use crate::work::Running;

/// Events that a slow page may lag behind before it misses some.
const EVENTS: usize = 256;
/// Changes that can be undone.
const MOST_UNDONE: usize = 100;

/// What the server has at hand.
pub struct Desk {
    state: Mutex<State>,
    dropped: Mutex<Dropped>,
    events: broadcast::Sender<String>,
}

/// What changes while the server runs.
#[derive(Default)]
pub struct State {
    /// The bench, as the last work left it.
    pub bench: Option<Arc<OpenBench>>,
    /// The work that is under way.
    pub running: Option<Running>,
    /// Why the last work failed.
    pub failure: Option<String>,
    /// Works that were begun.
    pub count: u64,
}

impl Desk {
    /// Nothing is open.
    pub fn new() -> Desk {
        Desk {
            state: Mutex::default(),
            dropped: Mutex::default(),
            events: broadcast::Sender::new(EVENTS),
        }
    }

    /// What is at hand now.
    pub fn state(&self) -> MutexGuard<'_, State> {
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

    /// Tells every page.
    pub fn tell(&self, event: &serde_json::Value) {
        // Where no page listens, nobody is told.
        let _ = self.events.send(event.to_string());
    }

    /// What every page is told from now on.
    pub fn listen(&self) -> broadcast::Receiver<String> {
        self.events.subscribe()
    }
}

/// A bench, its model beside the measurements, and what came of it since it was opened.
#[derive(Clone)]
pub struct OpenBench {
    /// The bench's folder, without symlinks.
    pub folder: PathBuf,
    /// The session.
    pub session: Session,
    /// The model beside the measurements.
    pub comparison: ComparisonReport,
    /// The experiments for sliders.
    pub predictor: Predictor,
    /// The last diagnosis, as long as it speaks of the model as it is or as it made it.
    pub diagnosis: Option<Arc<Diagnosed>>,
    /// What effects look like beside the model as it is, as far as that was asked.
    pub fingerprints: Vec<Arc<EffectFingerprint>>,
    /// The error after each change.
    pub staircase: Vec<Stair>,
    /// What can be gone back to.
    pub undo: Vec<Before>,
    /// The controller that was generated last.
    pub generated: Option<GeneratedController>,
    /// What came of its proof.
    pub proof: Option<Proof>,
    /// Why the model could not be written, where that is so.
    pub unsaved: Option<String>,
    /// The text of model.toml when it was last read or written.
    known_text: Option<String>,
}

/// A diagnosis, and the model beside the measurements from which it started.
pub struct Diagnosed {
    /// The verdict and what it rests on.
    pub report: DiagnosisReport,
    /// The model as it was.
    pub first: ComparisonReport,
    /// Whether its last step is the model now.
    pub applied: bool,
}

/// The error after a change of the model.
#[derive(Clone, serde::Serialize)]
pub struct Stair {
    /// What was changed: "+ body-coulomb-friction".
    pub label: String,
    /// Root mean square errors, SI units.
    pub rmse: PerSeries,
}

/// What a change can be undone to.
#[derive(Clone)]
pub struct Before {
    model: Option<ModelFile>,
    stairs: usize,
    diagnosis: Option<Arc<Diagnosed>>,
}

impl OpenBench {
    /// Opens a bench and compares its model; one without a model is fitted with the base model.
    pub fn open(path: &Path, refit: bool, progress: &Progress) -> Result<OpenBench, String> {
        let folder = crate::folder::of_bench(path)?;
        (progress.say)("reading the files");
        let mut session = Session::open(&folder).map_err(said)?;
        crate::folder::holds_logs(&folder, session.bench())?;
        let (comparison, label) = match session.model() {
            Some(_) if refit => (session.identify(progress), "refitted"),
            Some(_) => (session.compare(progress), "as it was"),
            None => (session.identify_base(progress), "base model"),
        };
        let comparison = comparison.map_err(|error| match error {
            Error::ParameterMissing { .. } | Error::ParameterUnit { .. } => {
                format!("{error}; open it again with \"fit anew\"")
            }
            error => error.to_string(),
        })?;
        let predictor = session.predictor(progress).map_err(said)?;
        let staircase = vec![Stair {
            label: label.to_owned(),
            rmse: comparison.rmse.clone(),
        }];
        let mut bench = OpenBench {
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
            known_text: None,
        };
        bench.known_text = bench.text_on_disk();
        if label != "as it was" {
            bench.save();
        }
        Ok(bench)
    }

    /// Whether another program has written the model since.
    pub fn changed_outside(&self) -> bool {
        self.unsaved.is_none() && self.text_on_disk() != self.known_text
    }

    fn text_on_disk(&self) -> Option<String> {
        std::fs::read_to_string(self.session.model_path()).ok()
    }

    /// Remembers what the model is, for undo.
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

    /// The session's model has changed: what follows from it is made anew, and it is written.
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

    /// Writes the model; where that cannot be done, the page says so and goes on.
    pub fn save(&mut self) {
        let path = self.session.model_path().to_path_buf();
        let written = crate::folder::within(&self.folder, &path)
            .and_then(|()| self.session.save_model().map_err(said));
        self.unsaved = written.err();
        self.known_text = self.text_on_disk();
    }

    /// A controller of another model is of no use.
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

/// An error as a sentence.
pub fn said(error: Error) -> String {
    error.to_string()
}
