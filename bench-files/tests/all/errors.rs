//! Every kind of bad input gets one message that names file, line and column and what would be
//! right.

use std::path::Path;

use crate::common::{Folder, csv, one};
use bench_files::{Bench, Error, ModelFile};

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
            &["bench.toml:7:18", "0.5 N m", "0.245158 N m", "correct one"],
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
            &["bench.toml:5:23", "\"angle\" cannot be held", "current = 0.6"],
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

/// Name of the case, kind, further entries of the experiment, bytes of the log, what the message
/// says.
type LogCase = (
    &'static str,
    &'static str,
    &'static str,
    Vec<u8>,
    &'static [&'static str],
);

/// Logs under a healthy bench.toml.
#[test]
fn logs() {
    let rows = |header: &str, row: &str| csv(header, 8, |i| row.replace('T', &format!("0.0{i}")));
    let huge_line = format!("time_s,angle_rad\n0,{}\n", "1".repeat(2 << 20));
    let unclosed = format!("time_s,angle_rad\n0,\"1\n{}", "1,1\n".repeat(1 << 20));
    let cases: Vec<LogCase> = vec![
        (
            "empty file",
            "free-swing",
            "",
            b"".to_vec(),
            &["log.csv", "empty", "header"],
        ),
        (
            "blank lines",
            "free-swing",
            "",
            b"\n\n\r\n".to_vec(),
            &["log.csv", "empty"],
        ),
        (
            "header only",
            "free-swing",
            "",
            b"time_s,angle_rad\n".to_vec(),
            &["log.csv", "only 0 samples", "header line"],
        ),
        (
            "no header",
            "free-swing",
            "",
            b"0.0,0.1\n0.1,0.1\n".to_vec(),
            &["log.csv:1", "\"1\", \"2\"", "no header line", "time_s"],
        ),
        (
            "no time",
            "free-swing",
            "",
            rows("t_s,angle_rad", "T,0.1").into_bytes(),
            &[
                "log.csv:1",
                "\"one\" (free-swing) needs the time",
                "\"t_s\", \"angle_rad\"",
                "time_s",
                "columns = { time = \"t_s\" }",
            ],
        ),
        (
            "no angle",
            "free-swing",
            "",
            rows("time_s,pend_deg", "T,0.1").into_bytes(),
            &[
                "log.csv:1",
                "angle or its rate",
                "angle_rad or rate_rad_s",
                "columns = { angle = \"pend_deg\" }",
            ],
        ),
        (
            "no wheel speed",
            "spin-up",
            "",
            rows("time_s,omega,current_A", "T,0.1,1").into_bytes(),
            &[
                "log.csv:1",
                "wheel's speed",
                "wheel_speed_rad_s",
                "columns = { wheel_speed = \"omega\" }",
            ],
        ),
        (
            "balance without current",
            "balance",
            "",
            rows("time_s,angle_rad,amps", "T,3.14,1").into_bytes(),
            &[
                "log.csv:1",
                "motor current",
                "current_A",
                "columns = { current = \"amps\" }",
                "constants",
            ],
        ),
        (
            "driven without motion",
            "driven",
            "",
            rows("time_s,rate_rad_s,current_A", "T,0.1,1").into_bytes(),
            &[
                "log.csv:1",
                "angle or the wheel's speed",
                "angle_rad or wheel_speed_rad_s",
            ],
        ),
        (
            "held current beside a column",
            "spin-up",
            "constants = { current = 0.6 }",
            rows("time_s,wheel_speed_rad_s,current_A", "T,0.1,1").into_bytes(),
            &["bench.toml:5:25", "0.6 A", "\"current_A\"", "keep one"],
        ),
        (
            "a column twice",
            "free-swing",
            "",
            rows("time_s,angle_rad,angle_rad", "T,0.1,0.2").into_bytes(),
            &["log.csv:1", "column \"angle_rad\"", "2 times"],
        ),
        (
            "NaN",
            "free-swing",
            "",
            b"time_s,angle_rad\n0,0.1\n0.1,NaN\n0.2,0.1\n".to_vec(),
            &[
                "log.csv:3",
                "column \"angle_rad\"",
                "\"NaN\" is not a finite number",
                "leave the line out",
            ],
        ),
        (
            "infinite time",
            "free-swing",
            "",
            b"time_s,angle_rad\n0,0.1\ninf,0.1\n".to_vec(),
            &["log.csv:3", "column \"time_s\"", "not a finite number"],
        ),
        (
            "overflow",
            "free-swing",
            "",
            b"time_s,angle_rad\n0,0.1\n0.1,1e999\n".to_vec(),
            &["log.csv:3", "column \"angle_rad\"", "not a finite number"],
        ),
        (
            "empty cell",
            "free-swing",
            "",
            b"time_s,angle_rad\n0,0.1\n0.1,\n".to_vec(),
            &[
                "log.csv:3",
                "column \"angle_rad\"",
                "empty",
                "leave the line out",
            ],
        ),
        (
            "no number",
            "free-swing",
            "",
            b"time_s,angle_rad\n0,0.1\n0.1,abc\n".to_vec(),
            &[
                "log.csv:3",
                "column \"angle_rad\"",
                "\"abc\" is not a number",
            ],
        ),
        (
            "decimal comma",
            "free-swing",
            "",
            b"time_s;angle_rad\n0;0.1\n0.1;0,5\n".to_vec(),
            &[
                "log.csv:3",
                "column \"angle_rad\"",
                "\"0,5\"",
                "a point, not a comma",
            ],
        ),
        (
            "time backwards",
            "free-swing",
            "",
            b"time_s,angle_rad\n0,0.1\n0.2,0.1\n0.1,0.1\n".to_vec(),
            &[
                "log.csv:4",
                "column \"time_s\"",
                "backwards",
                "from 0.2 s to 0.1 s",
            ],
        ),
        (
            "time backwards outside of the window",
            "free-swing",
            "from = 0.5",
            b"time_s,angle_rad\n0,0.1\n0.2,0.1\n0.1,0.1\n".to_vec(),
            &["log.csv:4", "backwards"],
        ),
        (
            "time stands still",
            "free-swing",
            "",
            csv("time_s,angle_rad", 40, |i| format!("{},0.1", i / 8)).into_bytes(),
            &["log.csv:1", "column \"time_s\"", "35 of 40", "more digits"],
        ),
        (
            "a short row",
            "free-swing",
            "",
            b"time_s,angle_rad\n0,0.1\n0.1\n".to_vec(),
            &["log.csv:3", "1 cells", "header has 2"],
        ),
        (
            "a long row after CRLF, blank and comment lines",
            "free-swing",
            "",
            b"# recorded by hand\r\ntime_s,angle_rad\r\n\r\n0,0.1\r\n# pause\r\n0.1,0.1,7\r\n"
                .to_vec(),
            &["log.csv:6", "3 cells", "header has 2"],
        ),
        (
            "too few samples",
            "free-swing",
            "from = 10.0\nuntil = 20.0",
            rows("time_s,angle_rad", "T,0.1").into_bytes(),
            &[
                "log.csv",
                "only 0 samples",
                "at least 5",
                "covers 0 s to 0.07 s",
            ],
        ),
        (
            "not UTF-8 in the header",
            "free-swing",
            "",
            b"time_s,angle_\xb0\x01\n0,0.1\n".to_vec(),
            &["log.csv:1", "not UTF-8", "save it with that encoding"],
        ),
        (
            "not UTF-8 below",
            "free-swing",
            "",
            b"time_s,angle_rad\n0,0.1\n0.1,\xff\x01\n".to_vec(),
            &["log.csv:3", "not UTF-8"],
        ),
        (
            "a line without end",
            "free-swing",
            "",
            huge_line.into_bytes(),
            &["log.csv:2", "longer than"],
        ),
        (
            "an open quotation mark",
            "free-swing",
            "",
            unclosed.into_bytes(),
            &["log.csv:2", "longer than", "quotation mark"],
        ),
        (
            "balance about zero",
            "balance",
            "",
            rows("time_s,angle_rad,current_A", "T,0.01,1").into_bytes(),
            &[
                "bench.toml:4:8",
                "upright is pi",
                "offset = { angle = 3.14159265 }",
            ],
        ),
        (
            "swing about upright",
            "free-swing",
            "",
            rows("time_s,angle_rad", "T,3.1").into_bytes(),
            &[
                "bench.toml:4:8",
                "hanging is 0",
                "offset = { angle = -3.14159265 }",
            ],
        ),
        (
            "degrees",
            "balance",
            "",
            rows("time_s,angle_rad,current_A", "T,180.0,0.1").into_bytes(),
            &["bench.toml:4:8", "units = { angle = \"deg\" }"],
        ),
    ];
    for (case, kind, more, log, parts) in cases {
        assert_says(case, &bench_error(case, &one(kind, more), &log), parts);
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

/// Sparse files: gigabytes that take no room.
#[test]
fn files_far_too_large() {
    let folder = Folder::bench(&one("free-swing", ""), "");
    let huge = |name: &str, bytes: u64| {
        let file = std::fs::File::create(folder.path().join(name)).expect("create");
        file.set_len(bytes).expect("a sparse file");
    };
    huge("log.csv", 100 << 30);
    let error = Bench::load(folder.path()).expect_err("too large");
    assert_says(
        "log",
        &error,
        &[
            "log.csv",
            "107374182400 bytes",
            "limit is 1073741824",
            "cut the log",
        ],
    );

    huge("bench.toml", 1 << 30);
    let error = Bench::load(folder.path()).expect_err("too large");
    assert_says(
        "bench",
        &error,
        &["bench.toml", "1073741824 bytes", "limit"],
    );

    let error = ModelFile::read(&folder.path().join("bench.toml")).expect_err("too large");
    assert_says(
        "model",
        &error,
        &["bench.toml", "1073741824 bytes", "limit"],
    );
}

#[test]
fn more_rows_than_memory_should_hold() {
    // Three bytes a line: within the limit of bytes, over the limit of lines.
    let mut log = b"time_s,angle_rad\n".to_vec();
    log.extend(b"0,0\n".repeat(bench_files::MAX_LOG_ROWS + 1));
    let error = bench_error("rows", &one("free-swing", ""), &log);
    assert_says(
        "rows",
        &error,
        &["log.csv", "more than 10000000 samples", "lower rate"],
    );
}

const PARAMETERS: &str = "[parameters.total_inertia]\nvalue = 2.3e-3\n";
const EFFECTS: &str = "[effects]\npresent = [\"body-viscous-friction\"]\n";

#[test]
fn model_toml() {
    let cases: Vec<(&str, String, &[&str])> = vec![
        (
            "empty",
            String::new(),
            &[
                "model.toml:1:1",
                "lacks \"effects\"",
                "body-viscous-friction",
            ],
        ),
        (
            "no effects",
            PARAMETERS.into(),
            &["model.toml", "lacks \"effects\"", "body-viscous-friction"],
        ),
        (
            "no list of effects",
            format!("{PARAMETERS}[effects]\n"),
            &["model.toml:3:1", "lacks \"present\""],
        ),
        (
            "unknown effect",
            format!("{PARAMETERS}[effects]\npresent = [\"body-coulomb\"]\n"),
            &[
                "model.toml:4:12",
                "unknown effect \"body-coulomb\"",
                "did you mean \"body-coulomb-friction\"",
            ],
        ),
        (
            "an effect twice",
            format!("{PARAMETERS}[effects]\npresent = [\"angle-offset\", \"angle-offset\"]\n"),
            &[
                "model.toml:4:28",
                "\"angle-offset\" cannot be used together with",
                "already",
            ],
        ),
        (
            "an effect and one that contains it",
            format!(
                "{PARAMETERS}[effects]\npresent = [\"body-stribeck-friction\", \"body-coulomb-friction\"]\n"
            ),
            &[
                "model.toml:4:38",
                "\"body-coulomb-friction\" cannot be used together with \"body-stribeck-friction\"",
                "contains the other",
            ],
        ),
        (
            "unknown parameter",
            format!("[parameters.total_inertai]\nvalue = 1.0\n{EFFECTS}"),
            &[
                "model.toml:1:13",
                "unknown parameter \"total_inertai\"",
                "did you mean \"total_inertia\"",
            ],
        ),
        (
            "no value",
            format!("[parameters.total_inertia]\nstd = 1.0\n{EFFECTS}"),
            &[
                "model.toml:1:1",
                "[parameters.total_inertia] lacks \"value\"",
            ],
        ),
        (
            "text for value",
            format!("[parameters.total_inertia]\nvalue = \"1.0\"\n{EFFECTS}"),
            &["model.toml:2:9", "must be a number"],
        ),
        (
            "negative inertia",
            format!("[parameters.total_inertia]\nvalue = -1.0\n{EFFECTS}"),
            &["model.toml:2:9", "\"total_inertia\" is -1", "between"],
        ),
        (
            "negative standard error",
            format!("[parameters.total_inertia]\nvalue = 1e-3\nstd = -1e-6\n{EFFECTS}"),
            &["model.toml:3:7", "\"std\" is -0.000001", "zero or positive"],
        ),
        (
            "another unit",
            format!("[parameters.total_inertia]\nvalue = 23.0\nunit = \"kg cm2\"\n{EFFECTS}"),
            &["model.toml:3:8", "\"kg m2\"", "\"kg cm2\"", "convert"],
        ),
        (
            "a slip in a section's name",
            format!("{PARAMETERS}{EFFECTS}[desing]\nsample_time = 0.001\n"),
            &["model.toml:5:2", "\"desing\"", "did you mean \"design\""],
        ),
        (
            "a slip in the design",
            format!("{PARAMETERS}{EFFECTS}[design]\nsampletime = 0.001\n"),
            &[
                "model.toml:6:1",
                "\"sampletime\" in [design]",
                "did you mean \"sample_time\"",
            ],
        ),
        (
            "design without weights",
            format!("{PARAMETERS}{EFFECTS}[design]\nsample_time = 0.001\n"),
            &[
                "model.toml:5:1",
                "[design] lacks \"state_weights\"",
                "[25.0, 0.5, 5e-4]",
            ],
        ),
        (
            "a negative weight",
            format!(
                "{PARAMETERS}{EFFECTS}[design]\nsample_time = 0.001\nstate_weights = [1, -1, 1]\ncurrent_weight = 1\ncurrent_limit = 2\n"
            ),
            &[
                "model.toml:7:17",
                "\"state_weights\" is -1",
                "zero or positive",
            ],
        ),
        (
            "sample time below zero",
            format!(
                "{PARAMETERS}{EFFECTS}[design]\nsample_time = -1\nstate_weights = [1, 1, 1]\ncurrent_weight = 1\ncurrent_limit = 2\n"
            ),
            &["model.toml:6:15", "\"sample_time\" is -1", "positive"],
        ),
    ];
    for (case, toml, parts) in cases {
        match ModelFile::parse(&toml, Path::new("model.toml")) {
            Ok(_) => panic!("{case}: parsed"),
            Err(error) => assert_says(case, &error, parts),
        }
    }
}

#[test]
fn correlations_that_no_errors_can_have() {
    let section = |parameters: &str, matrix: &str| {
        let mut toml = String::new();
        for name in ["total_inertia", "gravity_torque", "wheel_inertia"] {
            toml.push_str(&format!("[parameters.{name}]\nvalue = 0.1\nstd = 1e-3\n"));
        }
        format!(
            "{toml}[parameters.torque_constant]\nvalue = 0.0335\n{EFFECTS}[correlation]\n\
             parameters = {parameters}\nmatrix = {matrix}\n"
        )
    };
    let two = r#"["total_inertia", "gravity_torque"]"#;
    let three = r#"["total_inertia", "gravity_torque", "wheel_inertia"]"#;
    let cases: [(&str, String, &[&str]); 13] = [
        (
            "unknown name",
            section(r#"["total_inertia", "gravty_torque"]"#, "[[1, 0], [0, 1]]"),
            &[
                "model.toml:15:32",
                "\"gravty_torque\"",
                "did you mean \"gravity_torque\"",
            ],
        ),
        (
            "no standard error",
            section(
                r#"["total_inertia", "torque_constant"]"#,
                "[[1, 0], [0, 1]]",
            ),
            &[
                "model.toml:15:32",
                "unknown parameter with a std \"torque_constant\"",
            ],
        ),
        (
            "a name twice",
            section(r#"["total_inertia", "total_inertia"]"#, "[[1, 0], [0, 1]]"),
            &[
                "model.toml:15:32",
                "\"total_inertia\" is already in this list",
            ],
        ),
        (
            "no names",
            section("[]", "[]"),
            &["model.toml:15:14", "[correlation] lacks \"parameters\""],
        ),
        (
            "no matrix",
            section(two, "[[1, 0], [0, 1]]").replace("matrix = [[1, 0], [0, 1]]\n", ""),
            &["model.toml:14:1", "[correlation] lacks \"matrix\""],
        ),
        (
            "a row too short",
            section(two, "[[1, 0], [1]]"),
            &[
                "model.toml:16:10",
                "2 rows of 2 numbers",
                "a list of 2 values",
            ],
        ),
        (
            "a row too few",
            section(three, "[[1, 0, 0], [0, 1, 0]]"),
            &["model.toml:16:10", "3 rows of 3 numbers"],
        ),
        (
            "not finite",
            section(two, "[[1, nan], [nan, 1]]"),
            &["model.toml:16:10", "finite"],
        ),
        (
            "covariances instead",
            section(two, "[[1e-6, 1e-7], [1e-7, 1e-6]]"),
            &[
                "model.toml:16:12",
                "\"total_inertia with total_inertia\" is 0.000001",
                "must be 1",
            ],
        ),
        (
            "beyond one",
            section(two, "[[1, 1.2], [1.2, 1]]"),
            &[
                "model.toml:16:15",
                "\"total_inertia with gravity_torque\" is 1.2",
                "between -1 and 1",
            ],
        ),
        (
            "not symmetric",
            section(two, "[[1, 0.9], [0.8, 1]]"),
            &[
                "model.toml:16:22",
                "\"gravity_torque with total_inertia\" is 0.8",
                "0.9",
                "symmetric",
            ],
        ),
        (
            // Eigenvalues 1.9, 1.9 and −0.8.
            "each pair possible, not all three",
            section(three, "[[1, 0.9, 0.9], [0.9, 1, -0.9], [0.9, -0.9, 1]]"),
            &[
                "model.toml:16:10",
                "smallest eigenvalue",
                "-0.8",
                "zero or positive",
            ],
        ),
        (
            "a slip in the name",
            section(two, "[[1, 0], [0, 1]]").replace("[correlation]", "[correlations]"),
            &["model.toml:14:2", "did you mean \"correlation\""],
        ),
    ];
    for (case, toml, parts) in cases {
        match ModelFile::parse(&toml, Path::new("model.toml")) {
            Ok(_) => panic!("{case}: parsed"),
            Err(error) => assert_says(case, &error, parts),
        }
    }
    // One of rank one is possible: two parameters that move as one.
    let one = section(two, "[[1, -1], [-1, 1]]");
    assert!(ModelFile::parse(&one, Path::new("model.toml")).is_ok());
}

#[test]
fn a_model_that_lacks_a_parameter_or_the_design() {
    let toml = format!("{PARAMETERS}{EFFECTS}");
    let file = ModelFile::parse(&toml, Path::new("m.toml")).expect("parses");
    let error = file.parameter_vector().expect_err("no wheel inertia");
    assert_says(
        "base",
        &error,
        &[
            "m.toml",
            "[parameters.wheel_inertia]",
            "every model",
            "kg m2",
        ],
    );
    let error = file.require_design().expect_err("no design");
    assert_says(
        "design",
        &error,
        &["m.toml", "lacks \"design\"", "sample_time = 0.001"],
    );

    let mut full = file.clone();
    for name in ["wheel_inertia", "gravity_torque", "torque_constant"] {
        full.set_parameter(bench_files::Parameter {
            name: name.to_string(),
            value: 1e-3,
            std: None,
            unit: String::new(),
            source: String::new(),
        });
    }
    let error = full.parameter_vector().expect_err("no friction");
    assert_says(
        "effect",
        &error,
        &[
            "[parameters.body_viscous_friction]",
            "effect \"body-viscous-friction\"",
            "N m s/rad",
        ],
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
