//! A designed controller on the nonlinear bench.

mod laws;
mod report;

pub use laws::SimulationSettings;
pub use report::{
    AttractionRegion, EffectOnTransient, FilterError, FilterRun, LinearRangeReport, LoopOverlay,
    LoopRun, OverlayStatistics, RawCountsRun, RecoveryAngles, SimulationReport,
};
