//! Progress on standard error for work that takes a while.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// Runs `work` under a spinner that says what is going on. It shows only on a terminal and is gone
/// when the work is done.
pub fn while_doing<T>(what: &str, work: impl FnOnce() -> T) -> T {
    while_saying(|say| {
        say(what);
        work()
    })
}

/// As [`while_doing`], for work that says itself what it is about to do.
pub fn while_saying<T>(work: impl FnOnce(&dyn Fn(&str)) -> T) -> T {
    let spinner = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
        spinner.set_style(style);
    }
    spinner.enable_steady_tick(Duration::from_millis(100));
    let result = work(&|what| spinner.set_message(what.to_owned()));
    spinner.finish_and_clear();
    result
}
