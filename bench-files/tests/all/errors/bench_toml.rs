//! Errors of bench.toml.

use std::path::Path;

use bench_files::Bench;

use super::{assert_says, bench_error};
use crate::common::{Folder, one};

const SWING: &str = "time_s,angle_rad\n0.00,0.30\n0.01,0.29\n0.02,0.28\n0.03,0.27\n0.04,0.26\n";

/// bench.toml text around a healthy log.
#[test]
fn bench_toml() {
    let swing = |more: &str| one("free-swing", more);
    let cases: Vec<(&str, String, &[&str])> = vec![
        ("empty file", String::new(), &["bench.toml:1:1", "no experiment", "[[experiment]]"]),
        ("no TOML", "[bench\nname = 1".into(), &["bench.toml:1:", "not TOML"]),
        ("binary", "\u{1}\u{2}".into(), &["bench.toml:1:", "not TOML"]),
        (
            "unknown section",
            "[knwon]\n".to_string() + &swing(""),
            &["bench.toml:1:2", "\"knwon\"", "did you mean \"known\""],
        ),
        (
            "unknown key",
            "[known]\nbody_mas = 1.0\n".to_string() + &swing(""),
            &["bench.toml:2:1", "\"body_mas\" in [known]", "did you mean \"body_mass\""],
        ),
        (
            "unknown key of an experiment",
            swing("colums = { time = \"t\" }"),
            &["bench.toml:5:1", "\"colums\" in [[experiment]]", "did you mean \"columns\""],
        ),
        (
            "wrong type: text for number",
            "[known]\nbody_mass = \"0.2\"\n".to_string() + &swing(""),
            &["bench.toml:2:13", "\"body_mass\" must be a number", "the text \"0.2\""],
        ),
        (
            "wrong type: number for text",
            "[[experiment]]\nname = 7\nkind = \"free-swing\"\nfile = \"log.csv\"".into(),
            &["bench.toml:2:8", "\"name\" must be a text", "the number 7"],
        ),
        (
            "wrong type: text for table",
            swing("units = \"deg\""),
            &["bench.toml:5:9", "\"units\" must be a table"],
        ),
        (
            "wrong type: table for list of tables",
            "[experiment]\nname = \"x\"".into(),
            &["bench.toml:1:1", "\"experiment\" must be a list of tables", "[[experiment]]"],
        ),
        (
            "negative mass",
            "[known]\nbody_mass = -0.2\n".to_string() + &swing(""),
            &["bench.toml:2:13", "\"body_mass\" is -0.2", "positive"],
        ),
        (
            "NaN",
            "[known]\ngravity = nan\n".to_string() + &swing(""),
            &["bench.toml:2:11", "\"gravity\" is NaN", "finite"],
        ),
        (
            "gravity torque against masses",
            "[known]\ngravity = 9.81\nbody_mass = 0.2\nwheel_mass = 0.10604\npivot_to_wheel = 0.085\npivot_to_com = 0.079886\ngravity_torque = 0.5\n".to_string()
                + &swing(""),
            &["bench.toml:7:18", "0.5 N m", "0.2452 N m", "correct one"],
        ),
        (
            "centre of mass far above the pivot",
            "[known]\ngravity = 9.81\nbody_mass = 0.2\nwheel_mass = 0.10604\npivot_to_wheel = 0.085\npivot_to_com = -0.2\n".to_string()
                + &swing(""),
            &["bench.toml:6:16", "would not hang"],
        ),
        (
            "controller without limit",
            "[controller]\ngains = [-24.0, -2.0, -0.02]\nsample_time = 0.001\n".to_string() + &swing(""),
            &["bench.toml:1:1", "[controller] lacks \"current_limit\"", "current_limit = 2.0"],
        ),
        (
            "two gains",
            "[controller]\ngains = [-24.0, -2.0]\ncurrent_limit = 2.0\nsample_time = 0.001\n".to_string()
                + &swing(""),
            &["bench.toml:2:9", "three numbers", "a list of 2 values"],
        ),
        (
            "sample time zero",
            "[controller]\ngains = [-24.0, -2.0, -0.02]\ncurrent_limit = 2.0\nsample_time = 0\n".to_string()
                + &swing(""),
            &["bench.toml:4:15", "\"sample_time\" is 0", "positive"],
        ),
        (
            "no name",
            "[[experiment]]\nkind = \"free-swing\"\nfile = \"log.csv\"".into(),
            &["bench.toml:1:1", "[[experiment]] lacks \"name\""],
        ),
        (
            "no kind",
            "[[experiment]]\nname = \"x\"\nfile = \"log.csv\"".into(),
            &["bench.toml:1:1", "lacks \"kind\"", "spin-up"],
        ),
        (
            "unknown kind",
            one("freeswing", ""),
            &["bench.toml:3:8", "unknown kind of experiment \"freeswing\"", "did you mean \"free-swing\"", "spin-up"],
        ),
        (
            "kind from afar",
            one("identification", ""),
            &["bench.toml:3:8", "known are \"free-swing\", \"spin-up\", \"balance\", \"driven\""],
        ),
        (
            "no file key",
            "[[experiment]]\nname = \"x\"\nkind = \"free-swing\"".into(),
            &["bench.toml:1:1", "lacks \"file\""],
        ),
        (
            "missing log",
            "[[experiment]]\nname = \"x\"\nkind = \"free-swing\"\nfile = \"gone.csv\"".into(),
            &["bench.toml:4:8", "gone.csv", "no such file", "relative to the bench"],
        ),
        (
            "a folder as log",
            "[[experiment]]\nname = \"x\"\nkind = \"free-swing\"\nfile = \".\"".into(),
            &["bench.toml:4:8", "a folder, not a file"],
        ),
        (
            "two experiments with one name",
            swing("") + &swing(""),
            &["bench.toml:7:8", "\"one\"", "line 2", "choose another"],
        ),
        (
            "unknown unit",
            swing("units = { angle = \"grad\" }"),
            &["bench.toml:5:19", "unknown unit of angle \"grad\"", "did you mean \"rad\"", "\"deg\""],
        ),
        (
            "unit of another quantity",
            swing("units = { angle = \"rpm\" }"),
            &["bench.toml:5:19", "unknown unit of angle \"rpm\"", "\"rad\", \"mrad\", \"deg\", \"rev\""],
        ),
        (
            "unknown channel",
            swing("units = { angel = \"deg\" }"),
            &["bench.toml:5:11", "\"angel\" in \"units\"", "did you mean \"angle\""],
        ),
        (
            "sign zero",
            swing("sign = { angle = 0 }"),
            &["bench.toml:5:18", "1 or -1"],
        ),
        (
            "window reversed",
            swing("from = 3.0\nuntil = 2.0"),
            &["bench.toml:6:9", "until = 2", "after from = 3"],
        ),
        (
            "unknown meaning",
            swing("current_meaning = \"meassured\""),
            &["bench.toml:5:19", "did you mean \"measured\""],
        ),
        (
            "mapped column is not there",
            swing("columns = { angle = \"angel_rad\" }"),
            &["bench.toml:5:21", "maps angle to \"angel_rad\"", "log.csv", "did you mean \"angle_rad\""],
        ),
        (
            "unit without column",
            swing("units = { rate = \"deg/s\" }"),
            &["bench.toml:5:18", "\"rate\" is given here, but the log has no column", "\"angle_rad\""],
        ),
        (
            "held angle",
            swing("constants = { angle = 0.1 }"),
            &["bench.toml:5:23", "\"angle\" cannot stand under constants", "current = 0.6"],
        ),
        (
            "held current in a free swing",
            swing("constants = { current = 0.1 }"),
            &["bench.toml:5:25", "free-swing", "no current"],
        ),
    ];
    for (case, toml, parts) in cases {
        assert_says(case, &bench_error(case, &toml, SWING.as_bytes()), parts);
    }
}

#[test]
fn places_that_are_no_bench() {
    let error = Bench::load(Path::new("/no/such/bench")).expect_err("nothing there");
    assert_says(
        "nowhere",
        &error,
        &["/no/such/bench", "no such bench", "bench.toml"],
    );

    let folder = Folder::new();
    let error = Bench::load(folder.path()).expect_err("empty folder");
    assert_says("empty folder", &error, &["bench.toml", "no such file"]);

    folder.write("bench.toml", b"[bench]\nname = \"\xff\"\n");
    let error = Bench::load(folder.path()).expect_err("not UTF-8");
    assert_says(
        "not UTF-8",
        &error,
        &["bench.toml:2", "not UTF-8", "encoding"],
    );
}

/// The spans that terminals show point at the text that is wrong.
#[test]
fn excerpts_point_at_the_value() {
    let toml = one("freeswing", "");
    let error = bench_error("span", &toml, SWING.as_bytes());
    let (text, span) = error.excerpt().expect("a place in a text");
    assert_eq!(&text[span], "\"freeswing\"");
}
