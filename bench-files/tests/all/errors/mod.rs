//! Every kind of bad input gets one message that names file, line and column and what would be
//! right.

mod bench_toml;
mod logs;
mod model_toml;

use bench_files::{Bench, Error};

use crate::common::Folder;

/// Fails unless the message holds every part.
fn assert_says(case: &str, error: &Error, parts: &[&str]) {
    let message = error.to_string();
    for part in parts {
        assert!(
            message.contains(part),
            "{case}: the message lacks {part:?}:\n{message}"
        );
    }
    assert!(!message.contains('\n'), "{case}: one line, not {message:?}");
}

fn bench_error(case: &str, toml: &str, log: &[u8]) -> Error {
    let folder = Folder::new();
    folder.write("bench.toml", toml.as_bytes());
    folder.write("log.csv", log);
    match Bench::load(folder.path()) {
        Ok(_) => panic!("{case}: loaded"),
        Err(error) => error,
    }
}
