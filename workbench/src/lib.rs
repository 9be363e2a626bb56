//! The library for programs: from the logs of a bench to a proved controller. Identify, compare, diagnose,
//! simulate, design, generate, prove. Begin with [`Session`].
//!
//! ```
//! use workbench::{FilesInMemory, Progress, ProofSettings, Session, SimulationSettings};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // The demonstration's bench; `Session::open` takes a folder instead.
//! let files: FilesInMemory = demo::FILES.into_iter().collect();
//! let mut session = Session::from_files(&files)?;
//! // Long work says what it is doing, and ends soon after `cancelled` answers true.
//! let progress = Progress {
//!     say: &|what| println!("{what} …"),
//!     cancelled: &|| false,
//! };
//!
//! // The base model has viscous friction alone. Where does it fail, and what does it lack?
//! let base = session.identify(&progress)?;
//! println!("{} fails first at {:?}", base.bench, base.places.first());
//! let diagnosis = session.diagnose(&progress)?;
//! println!("{}", diagnosis.sentence);
//! assert_eq!(diagnosis.steps[1].effect.as_deref(), Some("body-coulomb-friction"));
//! session.apply(&diagnosis);
//!
//! // Sliders: the same experiments with another value of a parameter.
//! let curves = session.predictor(&progress)?.curves(&[("body_coulomb_torque", 8e-4)])?;
//! assert_eq!(curves.len(), base.experiments.len());
//!
//! // The controller for other weights than the usual ones, and its closed loop.
//! let mut wishes = session.usual_design();
//! wishes.current_weight = 2.0;
//! let design = session.design_for(wishes)?;
//! let closed_loop = design.simulate(&SimulationSettings::default(), &progress)?;
//! assert!(closed_loop.runs.iter().all(|run| !run.fell));
//!
//! // In fixed point, with a certificate that is checked from the emitted files alone.
//! let controller = design.generate(None)?;
//! println!("{} files", controller.files().count()); // or controller.write(folder)
//! let settings = ProofSettings { cases: 1000, smt: false, compiled: false, ..Default::default() };
//! assert!(controller.prove(&settings, &progress)?.passed());
//! # Ok(())
//! # }
//! ```
//!
//! # Overview
//! | from | to |
//! |---|---|
//! | [`Session`] | [`ComparisonReport`], [`EffectChange`], [`DiagnosisReport`], [`BenchCheck`], [`Predictor`] |
//! | [`Session::design`], [`ControlDesign::read`] | [`ControlDesign`] |
//! | [`check_data`] | [`DataReport`]: the findings for the data of a bench |
//! | [`ControlDesign`] | [`DesignReport`], [`SimulationReport`], [`GeneratedController`] |
//! | [`prove()`], [`mutate()`] | [`Proof`], [`MutationReport`] of an emitted crate's folder |
//! | [`record()`] | [`RecordReport`]: logs of a bench from the firmware's serial line |
//! | [`calibrate()`] | [`SensorCalibrationReport`] of recordings of raw counts |
//! | [`bring_up()`] | [`BringUpReport`]: which way is positive |
//!
//! Results are plain data in SI units that can be serialised (`serde`); the option `--json` of the commands writes
//! these data. Curves are left out of the JSON, because they are long. They are part of the same result, and
//! `drawings()` or `files()` make figures and tables from them, as text.
//!
//! Nothing here prints, reads arguments or ends the program. Files are written only by
//! [`Session::save_model`], [`GeneratedController::write`], [`new_bench`] and [`record()`]. Every failure is an [`Error`];
//! an error in a file has file, line and column.

mod bench_hardware;
mod bring_up;
mod calibration;
mod change;
mod closed_loop;
mod comparison;
mod control_design;
mod controller;
mod data_check;
mod design_change;
mod design_report;
mod design_sweep;
mod diagnosis;
mod drawings;
mod effect_confusion;
mod effect_library;
mod effect_portrait;
mod error;
mod fingerprint;
mod identification;
mod late_loop;
mod learned;
mod loop_expectations;
mod loop_responses;
mod measured_linearity;
mod missing_torque;
mod model_effects;
mod model_export;
mod module_spec;
mod named;
mod output_file;
mod own_effects;
mod per_series;
mod predictor;
mod proof;
mod recording;
mod refusal;
mod remains;
mod sensor_noise;
mod session;
mod shading;
mod simulated_drive;
mod simulated_sensors;
mod swing_decay;
pub mod words;

pub use ::data_check::{Finding, FindingId, Proposal, ProposedExperiment, Severity};
pub use ::design::linear_response::Band;
pub use bench_files::numbers;
pub use bench_files::{
    Bench, BringUpRecordings, CalibrationRecordings, Correlation, DesignSection, FilesInMemory,
    ModelFile, Parameter,
};
pub use bench_hardware::{HardwareError, Preset};
pub use bring_up::{BringUpAxes, BringUpContradiction, BringUpReport, BringUpSigns, bring_up};
pub use calibration::{
    CalibratedLine, CalibratedSensor, LeverArmOfSwing, LeverArmReport, MagnetometerPoints,
    PlumbedCentre, SensorCalibrationReport, SensorMounting, calibrate,
};
pub use change::EffectChange;
pub use closed_loop::{
    AttractionRegion, EffectOnTransient, FilterError, FilterRun, LinearRangeReport, LoopOverlay,
    LoopRun, OverlayStatistics, RawCountsRun, RecoveryAngles, SimulationReport, SimulationSettings,
};
pub use comparison::{
    BenchNote, ChannelCurves, ComparisonReport, ExperimentCurves, FailurePlace, LoggedExperiment,
    PushInLog,
};
pub use control_design::ControlDesign;
pub use controller::{ControllerOptions, GeneratedController};
pub use data_check::{DataReport, NewBench, check_data, new_bench};
pub use design_change::{DesignChange, DesignSummary};
pub use design_report::{
    DesignReport, FrictionExtreme, HuntingSwing, LeastPush, LoopMargins, PoleErrors,
    SensorCondition, WheelSize,
};
pub use design_sweep::{DesignSweep, SweepPoint, SweepRow, Swept};
pub use diagnose::{Recipe, Verdict};
pub use diagnosis::{
    AppliedDiagnosis, DiagnosisReport, DiagnosisStep, FinalModel, HeldOutBy, ParameterWithoutValue,
    SuspectEffect,
};
pub use drawings::{NamedLoop, loop_drawings};
pub use effect_confusion::{EffectConfusion, effect_confusions};
pub use effect_library::{EffectDescription, EffectParameter, effect_library};
pub use effect_portrait::{EffectPortrait, effect_portrait};
pub use error::Error;
pub use fingerprint::{EffectFingerprint, TorqueFingerprint, TorquePart};
pub use identification::BenchCheck;
pub use identify::{Cancelled, Coordinate, Output, Progress, ResidualKind};
pub use late_loop::{LateLoop, LatePart, LatePoint, SampleTimeRow};
pub use loop_expectations::{
    AllowedExcursions, ExpectationSettings, LoopExpectations, NoiseExpectation, TorqueAnswer,
    weights_of_excursions,
};
pub use loop_responses::LoopResponse;
pub use measured_linearity::{MeasuredSwings, SpinUpLinearity, SwingLinearity};
pub use missing_torque::{MissingTorque, TorquePoint};
pub use model_export::ExportLanguage;
pub use output_file::OutputFile;
pub use own_effects::{OwnEffectError, check_own_effect};
pub use per_series::{PerSeries, SeriesName};
pub use predictor::Predictor;
pub use proof::{
    CLAIMS, ClaimStatement, MutationReport, Proof, ProofSettings, ProofVerdict, mutate, prove,
};
pub use recording::{
    RecordEnd, RecordReport, RecordSettings, RecordedExperiment, RecordedLog, RecordedSample,
    record,
};
pub use remains::{ClosedLoopDeviation, DiscrepancyReport, RemainsReport};
pub use sensor_noise::BenchNoise;
pub use session::Session;
pub use shading::{FAILS_OVER_NOISE, Shading};
pub use swing_decay::{AmplitudeLaw, SwingDecay};
