//! Progress on standard error for work that takes a while.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use workbench::Progress;

/// Runs `work` under a spinner that says what the work says. It shows only on a terminal and is gone
/// when the work is done. Nothing is called off: whoever wants that ends the program.
pub fn with_progress<T>(work: impl FnOnce(&Progress) -> T) -> T {
    let spinner = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
        spinner.set_style(style);
    }
    spinner.enable_steady_tick(Duration::from_millis(100));
    let say = |what: &str| spinner.set_message(what.to_owned());
    let result = work(&Progress::saying(&say));
    spinner.finish_and_clear();
    result
}
