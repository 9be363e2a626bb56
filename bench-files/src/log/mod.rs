//! Logs: CSV with a header line, one sample per line, increasing times.

mod cleaning;
mod columns;
mod long_log;
mod note;
mod reading;
mod samples;

pub(crate) use columns::ColumnUse;
pub use note::{LoadReport, Note, Stated, UnstatedUnit};
pub use reading::MIN_SAMPLES;
pub(crate) use reading::{SamplesOfLog, Window, read};
pub use samples::Log;
