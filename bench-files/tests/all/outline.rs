//! A bench.toml whose logs are still being recorded: entries are added, and nothing else changes.

use std::fs;

use bench_files::{Bench, BenchOutline, NewExperiment, file_name};
use plant::Kind;
use tempfile::TempDir;

const TEXT: &str = "# mine\n[bench]\nname = \"b\" # kept\n\n[known]\ngravity = 9.81\n";
const LOG: &str = "time_s,angle_rad\n0,0.3\n0.01,0.29\n0.02,0.27\n0.03,0.24\n0.04,0.2\n0.05,0.15\n";

fn bench(text: &str) -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("bench.toml"), text).expect("written");
    folder
}

fn swing(outline: &BenchOutline) -> NewExperiment {
    let name = outline.free_name("free swing");
    NewExperiment {
        file: file_name(&name),
        name,
        kind: Kind::FreeSwing,
        from_s: Some(0.01),
        comment: "first line\nsecond line".to_owned(),
    }
}

#[test]
fn added_experiments_are_read_and_the_rest_of_the_file_stays() {
    let folder = bench(TEXT);
    let mut outline = BenchOutline::read(folder.path()).expect("an outline without logs");
    for _ in 0..2 {
        let new = swing(&outline);
        fs::write(folder.path().join(&new.file), LOG).expect("written");
        outline.add_experiment(&new).expect("added");
    }
    let text = fs::read_to_string(folder.path().join("bench.toml")).expect("text");
    assert!(text.starts_with(TEXT), "{text}");
    assert!(
        text.contains("# first line\n# second line\n[[experiment]]"),
        "{text}"
    );
    let bench = Bench::load(folder.path()).expect("a bench");
    let names: Vec<&str> = bench
        .experiments
        .iter()
        .map(|one| one.name.as_str())
        .collect();
    assert_eq!(names, ["free swing", "free swing 2"]);
    // From 0.01 s on.
    assert_eq!(bench.experiments[0].log.len(), 5);
    // Entries come after those that are there, also when the file is read again.
    let again = BenchOutline::read(&folder.path().join("bench.toml")).expect("an outline");
    assert_eq!(again.experiments, names);
    assert_eq!(again.free_name("free swing"), "free swing 3");
}

/// Entries of another bench.toml come behind the own ones, with their comments; nothing else of it comes along.
#[test]
fn experiments_of_another_bench_follow_the_own_ones() {
    let folder = bench(TEXT);
    let mut outline = BenchOutline::read(folder.path()).expect("an outline");
    let new = swing(&outline);
    outline.add_experiment(&new).expect("added");
    let other = "[bench]\nname = \"other\"\n[known]\ngravity = 1.0\n\n# why\n[[experiment]]\n\
                 name = \"second\" # so called\nkind = \"free-swing\"\nfile = \"2.csv\"\n\n[hardware]\n";
    let whole = outline.with_experiments_of(other).expect("a text");
    assert!(whole.starts_with(TEXT), "{whole}");
    let (first, second) = (
        whole.find("free swing"),
        whole.find("# why\n[[experiment]]"),
    );
    assert!(first.is_some() && first < second, "{whole}");
    assert!(whole.contains("\"second\" # so called"), "{whole}");
    assert!(
        !whole.contains("gravity = 1.0") && !whole.contains("[hardware]"),
        "{whole}"
    );
    // Nothing is written.
    let kept = fs::read_to_string(folder.path().join("bench.toml")).expect("text");
    assert!(!kept.contains("so called"), "{kept}");
    assert!(outline.with_experiments_of("[[experiment").is_err());
}

#[test]
fn a_name_is_not_taken_twice_by_experiment_or_file() {
    let folder = bench(TEXT);
    fs::write(folder.path().join("free-swing.csv"), "mine").expect("written");
    let outline = BenchOutline::read(folder.path()).expect("an outline");
    assert_eq!(outline.free_name("free swing"), "free swing 2");
    assert_eq!(outline.free_name("other"), "other");
}

#[test]
fn an_inline_list_of_experiments_stays_one() {
    let text = "experiment = [{ name = \"a\", kind = \"free-swing\", file = \"a.csv\" }]\n";
    let folder = bench(text);
    let mut outline = BenchOutline::read(folder.path()).expect("an outline");
    let new = swing(&outline);
    for file in ["a.csv", &new.file] {
        fs::write(folder.path().join(file), LOG).expect("written");
    }
    outline.add_experiment(&new).expect("added");
    let bench = Bench::load(folder.path()).expect("a bench");
    assert_eq!(bench.experiments.len(), 2);
}

#[test]
fn bring_up_recordings_have_one_key_each() {
    let folder = bench(&format!(
        "{TEXT}\n[bring_up]  # by hand\nhanging = \"old.csv\" # first\n"
    ));
    let mut outline = BenchOutline::read(folder.path()).expect("an outline");
    outline.set_bring_up("hanging", "hanging.csv").expect("set");
    outline.set_bring_up("tilted", "tilted.csv").expect("set");
    let text = fs::read_to_string(folder.path().join("bench.toml")).expect("text");
    let end = "[bring_up]  # by hand\nhanging = \"hanging.csv\" # first\ntilted = \"tilted.csv\"\n";
    assert!(text.ends_with(end), "{text}");
}

#[test]
fn names_become_files_that_stay_in_the_folder() {
    for (name, file) in [
        ("spin-up -0.4 A", "spin-up--0.4-A.csv"),
        ("../../etc/passwd", "-..-etc-passwd.csv"),
        ("a/b\\c:d", "a-b-c-d.csv"),
        ("Schwung groß", "Schwung-groß.csv"),
    ] {
        assert_eq!(file_name(name), file);
    }
}

#[test]
fn a_slip_in_the_file_is_named_before_anything_is_recorded() {
    let folder = bench("[bench]\nname = \"b\"\n[hardware.gyroscope]\npart = \"FXAS21003\"\n");
    let error = BenchOutline::read(folder.path()).expect_err("no such part");
    let place = error.place();
    assert_eq!((place.line, place.position), (Some(4), Some(8)), "{error}");
    let missing = folder.path().join("nowhere");
    assert!(BenchOutline::read(&missing).is_err());
}
