//! The C, damaged in one place: the answers, the numbers or the compiler notice it.

use std::fs::{self, File};
use std::io::{BufReader, Read};
use std::num::NonZero;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::{Mutex, OnceLock};
use std::thread;

use codegen::{EmittedCrate, c99};

use super::harnesses::{WARNINGS, compile, rust_harness, written};
use super::mutants::{Damage, mutants};
use super::numbers::Expected;
use super::{ANSWER_BYTES, Answer, Calls, answer, answers, mounted_at, with_everything};

/// Every number of the C is changed in its last digit, one at a time: the comparison of the numbers notices each.
#[test]
fn any_damaged_number_is_noticed() {
    let emitted = with_everything();
    let c = c99::emit(&emitted).expect("a translation");
    let file = |path| c.file(path).expect("a file");
    let (header, source) = (file("src/flywheel.h"), file("src/flywheel.c"));
    let expected = Expected::of(&emitted);
    let damaged = mutants(source, Damage::Numbers);
    assert!(damaged.len() > 300, "{}", damaged.len());
    let unnoticed: Vec<&String> = damaged
        .iter()
        .filter(|(_, text)| expected.difference(header, text).is_none())
        .map(|(line, _)| line)
        .collect();
    // An index beyond its array or to another element is no number of the Rust: the compiler and the answers see it.
    let others: Vec<&&String> = unnoticed
        .iter()
        .filter(|line| !line.contains('['))
        .collect();
    assert!(others.is_empty(), "{others:#?}");
}

/// Damages an operator of the C, one at a time; the comparison or the compiler must notice. Every 12th place.
#[test]
#[cfg_attr(not(have_gcc), ignore = "needs gcc")]
fn damaged_operators_are_noticed() {
    damage(12, 5, &[Damage::Operators]);
}

/// As above, every place, every cast, and every number changed in its last digit; of a number the comparison of the numbers
/// may notice it. It takes some minutes.
#[test]
#[ignore = "run apart: some minutes"]
fn any_damage_is_noticed() {
    damage(1, 0, &[Damage::Operators, Damage::Casts, Damage::Numbers]);
}

/// A bench whose C is damaged.
struct Subject {
    /// Holds the harness in Rust and the calls that it was asked.
    folder: tempfile::TempDir,
    emitted: EmittedCrate,
    translated: EmittedCrate,
    few: OnceLock<Asked>,
    many: OnceLock<Asked>,
}

/// Calls in a file, as the harness reads them, and what the Rust answers.
struct Asked {
    calls: PathBuf,
    rust: Vec<Answer>,
}

impl Subject {
    fn new(emitted: EmittedCrate) -> Subject {
        let folder = tempfile::tempdir().expect("a folder");
        let translated = written(&emitted, folder.path());
        Subject {
            folder,
            emitted,
            translated,
            few: OnceLock::new(),
            many: OnceLock::new(),
        }
    }

    fn source(&self) -> &str {
        self.translated.file("src/flywheel.c").expect("the source")
    }

    fn mutants(&self, kinds: &[Damage]) -> Vec<(String, String)> {
        let of_kind = |kind: &Damage| mutants(self.source(), *kind);
        kinds.iter().flat_map(of_kind).collect()
    }

    /// Calls that notice nearly every damage.
    fn few(&self) -> &Asked {
        self.few.get_or_init(|| self.ask(11, 60_000))
    }

    /// For those that few calls do not notice: a bias that is rounded otherwise changes one duty in a thousand.
    fn many(&self) -> &Asked {
        self.many.get_or_init(|| self.ask(12, 1_500_000))
    }

    fn ask(&self, seed: u64, count: usize) -> Asked {
        let calls = self.folder.path().join(format!("calls-{seed}"));
        let mut source = Calls::new(seed);
        let bytes: Vec<u8> = (0..count).flat_map(|_| source.next().bytes()).collect();
        fs::write(&calls, bytes).expect("written");
        // One target folder serves every harness in Rust: another subject must not build its own in between.
        static BUILDS: Mutex<()> = Mutex::new(());
        let _alone = BUILDS.lock().expect("no other has failed");
        let mut harness = rust_harness(&self.emitted, self.folder.path());
        let rust = answers(&mut harness, seed, count);
        assert_eq!(rust.len(), count, "the harness in Rust has ended");
        Asked { calls, rust }
    }
}

/// A folder in which one thread compiles damaged texts of a subject.
struct Bench<'a> {
    subject: &'a Subject,
    folder: tempfile::TempDir,
}

impl<'a> Bench<'a> {
    fn new(subject: &'a Subject) -> Bench<'a> {
        let folder = tempfile::tempdir().expect("a folder");
        written(&subject.emitted, folder.path());
        Bench { subject, folder }
    }

    /// Puts this text in the place of the source; whether it compiles.
    fn compiles(&self, text: &str) -> bool {
        fs::write(self.folder.path().join("src/flywheel.c"), text).expect("written");
        compile(self.folder.path(), "-O1").is_ok()
    }

    /// Whether a compiler that optimises makes the same program of this text, or warns of it: then no call can tell them
    /// apart, or none has to. Two elements of a table that are equal, say, are one.
    fn is_same_program(&self, text: &str) -> Result<bool, String> {
        let object = |text: &str| {
            let source = self.folder.path().join("src");
            fs::write(source.join("flywheel.c"), text).expect("written");
            let result = Command::new("gcc")
                .current_dir(&source)
                .args(WARNINGS)
                .args(["-O1", "-c", "flywheel.c", "-o", "it.o"])
                .output()
                .expect("gcc runs");
            match result.status.success() {
                true => Ok(fs::read(source.join("it.o")).expect("an object")),
                false => Err(String::from_utf8_lossy(&result.stderr).into_owned()),
            }
        };
        let own = object(self.subject.source()).expect("no warning");
        Ok(object(text)? == own)
    }

    /// Whether what was compiled last answers otherwise than the Rust. The first difference ends the program.
    fn differs(&self, asked: impl Fn(&Subject) -> &Asked) -> bool {
        let asked = asked(self.subject);
        let mut child = Command::new(self.folder.path().join("harness"))
            .stdin(File::open(&asked.calls).expect("the calls"))
            .stdout(Stdio::piped())
            .spawn()
            .expect("the harness runs");
        let mut output = BufReader::new(child.stdout.take().expect("standard output"));
        let differs = asked.rust.iter().any(|rust| {
            let mut bytes = [0; ANSWER_BYTES];
            output.read_exact(&mut bytes).is_err() || answer(&bytes) != *rust
        });
        drop(output);
        let _ = child.kill();
        let _ = child.wait();
        differs
    }
}

/// Damages every place of these kinds, or one in so many from the first that is named, on every core.
/// `FLYWHEEL_DAMAGE=TEXT` damages only lines that contain the text.
fn damage(every: usize, first: usize, kinds: &[Damage]) {
    let subject = Subject::new(with_everything());
    // Its angles wrap the other way.
    let other = Subject::new(mounted_at(-0.05));
    let header = subject.translated.file("src/flywheel.h");
    let header = header.expect("the header");
    let expected = Expected::of(&subject.emitted);
    let mutants = subject.mutants(kinds);
    let of_other = other.mutants(kinds);
    assert!(mutants.len() > 300, "{}", mutants.len());
    assert_eq!(mutants.len(), of_other.len());
    let only = std::env::var("FLYWHEEL_DAMAGE").unwrap_or_default();
    let both = mutants.iter().zip(&of_other).skip(first).step_by(every);
    let places = Mutex::new(both.filter(|((line, _), _)| line.contains(&only)));
    let unnoticed = Mutex::new(vec![]);
    let equal = Mutex::new(0_usize);
    let work = || {
        let (bench, bench_of_other) = (Bench::new(&subject), Bench::new(&other));
        let next = || places.lock().expect("no thread has failed").next();
        while let Some(((line, text), (_, text_of_other))) = next() {
            let is_noticed = || {
                !bench.compiles(text)
                    || bench.differs(Subject::many)
                    || !bench_of_other.compiles(text_of_other)
                    || bench_of_other.differs(Subject::few)
            };
            if expected.difference(header, text).is_some()
                || !bench.compiles(text)
                || bench.differs(Subject::few)
            {
                continue;
            }
            match bench.is_same_program(text) {
                Ok(true) => *equal.lock().expect("no thread has failed") += 1,
                Err(_) => {}
                Ok(false) if is_noticed() => {}
                Ok(false) => {
                    // A run that is broken off has said what it found.
                    println!("unnoticed: {line}");
                    let mut unnoticed = unnoticed.lock().expect("no thread has failed");
                    unnoticed.push(line.clone());
                }
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, NonZero::get) {
            scope.spawn(work);
        }
    });
    let unnoticed = unnoticed.into_inner().expect("no thread has failed");
    let equal = equal.into_inner().expect("no thread has failed");
    println!(
        "{} damages, {equal} of them the same program",
        mutants.len()
    );
    let count = unnoticed.len();
    assert!(
        count == 0,
        "{count} of {} unnoticed:\n{}",
        mutants.len(),
        unnoticed.join("\n")
    );
}
