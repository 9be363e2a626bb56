//! Logs of the thesis' pendulum with a hidden effect, and their diagnosis.

use diagnose::{Diagnosis, Options, diagnose_with};
use exam::{ChannelNoise, DriveProgram, ExamLog, ExperimentPlan, Hidden, Truth, record};
use identify::{FitProblem, Progress, Record, fit_until};
use plant::{Kind, Model};

/// The pendulum, with this effect or none.
pub fn truth(hidden: Option<Hidden>) -> Truth {
    Truth {
        base: [2.30344e-3, 1.36125e-4, 0.245158, 0.0335],
        body_viscous: 2.12e-5,
        wheel_viscous: 1.75204e-5,
        hidden: hidden.into_iter().collect(),
    }
}

/// An experiment: its name, kind, first angle in rad and currents.
pub type Planned = (&'static str, Kind, f64, DriveProgram);

/// What is measured in these experiments, each `duration_s` long with a sample every `sample_s`.
pub fn measured<'a>(
    truth: &Truth,
    planned: &'a [Planned],
    [duration_s, sample_s]: [f64; 2],
    seed: u64,
) -> Vec<(&'a Planned, ExamLog)> {
    let noise = ChannelNoise {
        std: [1.2e-3, 4e-3, 0.6],
    };
    let numbered = planned.iter().zip(10 * seed..);
    let of = |(planned, seed): (&'a Planned, u64)| {
        let (name, kind, angle_rad, driving) = planned;
        let plan = ExperimentPlan {
            name: (*name).to_owned(),
            kind: *kind,
            angle_rad: *angle_rad,
            wheel_speed_rad_s: 0.0,
            driving: driving.clone(),
            duration_s,
            sample_s,
        };
        (planned, record(truth, &plan, &noise, seed))
    };
    numbered.map(of).collect()
}

/// The logs of these experiments, as [`measured`].
pub fn logs(truth: &Truth, planned: &[Planned], times_s: [f64; 2], seed: u64) -> Vec<Record> {
    let of = |((name, kind, ..), log): (&Planned, ExamLog)| {
        let outputs = log.measured.map(Some);
        let current = Some(log.current_a);
        Record::new(name, *kind, log.time_s, outputs, current, false)
    };
    let measured = measured(truth, planned, times_s, seed);
    measured.into_iter().map(of).collect()
}

/// The diagnosis from the base model.
pub fn diagnosed(problem: &FitProblem) -> Diagnosis {
    let (base, quiet) = (Model::base(), Progress::silent());
    let found = fit_until(problem, &base, None, &quiet).expect("a fit");
    let options = Options::default();
    diagnose_with(problem, &base, found.fit.minimum, &options, &quiet).expect("a verdict")
}
