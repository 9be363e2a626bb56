//! Progress on standard error for long work, and its cancellation by the user (Ctrl-C).

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use workbench::Progress;

/// Exit code of a cancelled command: 128 plus the number of the signal, as in shells.
pub const CALLED_OFF: u8 = 130;

/// Whether the user has cancelled the command.
static IS_CALLED_OFF: AtomicBool = AtomicBool::new(false);
/// Whether the running work checks for cancellation. Such work ends by itself before anything is written.
static IS_ASKED_FOR: AtomicBool = AtomicBool::new(false);

/// Without a terminal for the spinner, the first line comes after this time, and the next ones at intervals of at least
/// [`LINE_PAUSE`].
const FIRST_LINE: Duration = Duration::from_millis(800);
const LINE_PAUSE: Duration = Duration::from_secs(2);

/// Lets Ctrl-C cancel the running work: nothing is written then, and the exit code is [`CALLED_OFF`].
/// If the work does not check for cancellation, or at the second Ctrl-C, the program ends at once.
pub fn heed_interrupts() {
    // Without the handler, Ctrl-C ends the program as usual.
    let _ = ctrlc::set_handler(|| {
        let is_again = IS_CALLED_OFF.swap(true, Ordering::SeqCst);
        if is_again || !IS_ASKED_FOR.load(Ordering::SeqCst) {
            std::process::exit(i32::from(CALLED_OFF));
        }
    });
}

/// Runs `work` and shows its progress messages: with a spinner on a terminal, which disappears at the end, otherwise
/// with a line from time to time. Ctrl-C cancels the work.
pub fn with_progress<T>(work: impl FnOnce(&Progress) -> T) -> T {
    IS_ASKED_FOR.store(true, Ordering::SeqCst);
    let cancelled = || IS_CALLED_OFF.load(Ordering::SeqCst);
    let result = if std::io::stderr().is_terminal() {
        under_spinner(work, &cancelled)
    } else {
        with_lines(work, &cancelled)
    };
    IS_ASKED_FOR.store(false, Ordering::SeqCst);
    result
}

fn under_spinner<T>(work: impl FnOnce(&Progress) -> T, cancelled: &(dyn Fn() -> bool + Sync)) -> T {
    let spinner = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
        spinner.set_style(style);
    }
    spinner.enable_steady_tick(Duration::from_millis(100));
    let say = |what: &str| spinner.set_message(what.to_owned());
    let result = work(&Progress {
        say: &say,
        cancelled,
    });
    spinner.finish_and_clear();
    result
}

/// Prints a line on standard error whenever the message has changed, if the work takes longer than [`FIRST_LINE`].
fn with_lines<T>(work: impl FnOnce(&Progress) -> T, cancelled: &(dyn Fn() -> bool + Sync)) -> T {
    let doing = Mutex::new(String::new());
    let (done, is_done) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let is_done = is_done;
            let began = Instant::now();
            let mut pause = FIRST_LINE;
            let mut last = String::new();
            while is_done.recv_timeout(pause) == Err(RecvTimeoutError::Timeout) {
                pause = LINE_PAUSE;
                let now = doing.lock().unwrap_or_else(PoisonError::into_inner).clone();
                if now != last {
                    eprintln!("{now} ({:.0} s)", began.elapsed().as_secs_f64());
                    last = now;
                }
            }
        });
        let say = |what: &str| {
            what.clone_into(&mut doing.lock().unwrap_or_else(PoisonError::into_inner));
        };
        let result = work(&Progress {
            say: &say,
            cancelled,
        });
        // The receiver may have ended already; then the message is not needed.
        let _ = done.send(());
        result
    })
}
