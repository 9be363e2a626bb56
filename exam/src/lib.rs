//! The exam: benches with a hidden effect, and how the verdicts of the diagnosis on them are marked.
//!
//! The draw never asks the examinee: which bench a seed stands for follows from the exam's own simulator and
//! from fits of the base model, never from a fit of the diagnosis.
//!
//! | file | job |
//! |---|---|
//! | `truth` | what hides in a bench; the terms that no library knows |
//! | `true_motion` | the true motion, simulated more faithfully than any fit does it |
//! | `bench_plan` | the experiments of a bench and their logs |
//! | `draw/` | which bench a seed stands for |
//! | `answer` | what is true of a bench |
//! | `rivals` | what else its logs allow, by refitting |
//! | `marking` | how one verdict is marked |
//! | `marks` | the marks of many benches together |
//! | `sitting` | an exam over seeds or over a folder of benches |
//! | `report` | the marks as they are handed out |
//! | `tables`, `drawings` | the marks as CSV and as figures |

mod answer;
mod bench_plan;
mod draw;
mod drawings;
mod marking;
mod marks;
mod report;
mod rivals;
mod sitting;
mod tables;
mod true_motion;
mod truth;

pub use answer::{Answer, UnknownEffect};
pub use bench_plan::{DriveProgram, ExamLog, ExperimentPlan, SensorNoise, record};
pub use draw::{
    ExamBench, LEFT_BY_SUSPECTS, Question, ROUND, SIZES, draw, draw_stated, effects, question,
};
pub use marking::{Interval, Mark, MarkError, PLAIN, Paper, mark};
pub use marks::{Entry, Marks, Rate, ReliabilityShare};
pub use report::{BenchReport, CalibrationReport, ExamReport};
pub use rivals::{CLOSE, EQUAL, fitted};
pub use sitting::{SitError, Sitting, benches_in, sit, sit_folder, sit_seeds};
pub use tables::{benches_csv, intervals_csv};
pub use true_motion::{HiddenPush, TrueMotion};
pub use truth::{Hidden, Outsider, StatedTorque, TrueInstant, Truth};
