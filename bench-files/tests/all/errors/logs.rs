//! Errors of logs.

use bench_files::{Bench, ModelFile};

use super::{assert_says, bench_error};
use crate::common::{Folder, csv, one};

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
            &["log.csv:3", "1 cell,", "header has 2"],
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
                "upright at pi",
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
                "hanging at 0",
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
    // Degrees that are stated are not asked about.
    let stated = one("balance", "units = { angle = \"deg\" }\n");
    let log = rows("time_s,angle_rad,current_A", "T,24.2,0.1").into_bytes();
    let error = bench_error("degrees of another zero", &stated, &log).to_string();
    assert!(
        error.contains("offset = {") && !error.contains("degrees"),
        "{error}"
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
