//! The diagnosis: which physical effects a model lacks.

mod report;
mod sentence;
mod work;

pub use report::{
    AppliedDiagnosis, DiagnosisReport, DiagnosisStep, FinalModel, HeldOutBy, ParameterWithoutValue,
    SuspectEffect,
};
