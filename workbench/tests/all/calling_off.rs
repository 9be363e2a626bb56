//! Long work ends soon after its caller cancels it.

use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};

use workbench::{Error, Progress, Session};

use crate::bench::{files, silent};

#[test]
fn a_diagnosis_that_is_called_off_leaves_everything_as_it_was() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files() {
        fs::write(folder.path().join(name), text).expect("written");
    }
    let mut session = Session::open(folder.path()).expect("a bench");
    session.identify(&silent()).expect("a fit");
    session.save_model().expect("written");
    let listed = || -> Vec<(String, Vec<u8>)> {
        let entries = fs::read_dir(folder.path()).expect("a folder");
        let mut all: Vec<_> = entries
            .map(|entry| {
                let path = entry.expect("an entry").path();
                let name = path.file_name().expect("a name").to_string_lossy();
                (name.into_owned(), fs::read(&path).expect("a file"))
            })
            .collect();
        all.sort();
        all
    };
    let (before, model) = (listed(), session.model().cloned());

    // Cancelled before the work begins, and after it has begun.
    for allowed in [0, 3] {
        let asked = AtomicUsize::new(0);
        let cancelled = || asked.fetch_add(1, Ordering::Relaxed) >= allowed;
        let progress = Progress {
            say: &|_| {},
            cancelled: &cancelled,
        };
        let result = session.diagnose(&progress);
        assert!(matches!(result, Err(Error::Cancelled(_))), "{allowed}");
        assert_eq!(listed(), before);
        assert_eq!(session.model().cloned(), model);
    }
    let result = session.add_effect(
        "body-coulomb-friction",
        &Progress {
            say: &|_| {},
            cancelled: &|| true,
        },
    );
    assert!(matches!(result, Err(Error::Cancelled(_))));
    assert_eq!(session.model().cloned(), model);
}
