//! The exam: benches with a hidden effect, and marks for the verdicts of the diagnosis on them.
//!
//! The diagnosis has no influence on the draw: the bench of a seed follows from the exam's own simulator and
//! from fits of the base model, never from a fit of the diagnosis.
//!
//! | file | job |
//! |---|---|
//! | `truth` | the hidden terms of a bench; the terms that are not in the library |
//! | `true_motion` | the true motion, simulated more exactly than in any fit |
//! | `bench_plan` | the experiments of a bench and their logs |
//! | `draw/` | the bench that belongs to a seed |
//! | `answer` | the true answer for a bench |
//! | `rivals` | other explanations that the logs allow, found by refitting |
//! | `marking` | the mark of one verdict |
//! | `marks` | the marks of many benches together |
//! | `sitting` | an exam over seeds or over a folder of benches |
//! | `report` | the marks as JSON data |
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
mod true_sensors;
mod truth;

pub use answer::{Answer, UnknownEffect};
pub use bench_plan::{ChannelNoise, DriveProgram, ExamLog, ExperimentPlan, record};
pub use draw::{
    ExamBench, LEFT_BY_SUSPECTS, Question, ROUND, SENSOR_SEEDS, SIZES, WHEEL_SEEDS, draw,
    draw_stated, effects, effects_of, question,
};
pub use marking::{Interval, Mark, MarkError, PLAIN, Paper, mark};
pub use marks::{Entry, Marks, Rate, ReliabilityShare};
pub use report::{BenchReport, CalibrationReport, ExamReport};
pub use rivals::{CLOSE, EQUAL, fitted};
pub use sitting::{SitError, Sitting, benches_in, sit, sit_folder, sit_seeds};
pub use tables::{benches_csv, intervals_csv};
pub use true_motion::{HiddenPush, TrueMotion};
pub use truth::{Hidden, Outsider, StatedTorque, TrueInstant, Truth};
