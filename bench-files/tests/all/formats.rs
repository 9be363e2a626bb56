//! Files as people have them: the same samples in every dialect.

use bench_files::{Bench, Experiment, Note};

use crate::common::{Folder, one};

fn load(more: &str, log: &[u8]) -> Result<Experiment, String> {
    let folder = Folder::new();
    folder.write("bench.toml", one("free-swing", more).as_bytes());
    folder.write("log.csv", log);
    let bench = Bench::load(folder.path()).map_err(|error| error.to_string())?;
    Ok(bench.experiments.into_iter().next().expect("one"))
}

const ROWS: usize = 8;

fn value(row: usize) -> (f64, f64) {
    (0.25 * row as f64, 0.125 * row as f64 - 0.5)
}

/// The samples with this header, separator and decimal mark.
fn text(header: &str, separator: char, decimal: char) -> String {
    let mut text = header.to_owned();
    for (time, angle) in (0..ROWS).map(value) {
        let row = format!("{time:.4}{separator}{angle:.4}\n");
        text.push_str(&row.replace('.', &decimal.to_string()));
    }
    text
}

fn assert_samples(case: &str, experiment: &Experiment) {
    for row in 0..ROWS {
        let (time, angle) = value(row);
        assert_eq!(experiment.log.time_s[row], time, "{case}");
        let found = experiment.log.angle_rad.as_ref().expect("an angle")[row];
        assert!((found - angle).abs() < 1e-12, "{case}: {found} {angle}");
    }
}

#[test]
fn every_dialect_gives_the_same_samples() {
    let utf_16 = |text: &str, big: bool, mark: bool| -> Vec<u8> {
        let mark: &[u16] = if mark { &[0xfeff] } else { &[] };
        let units = mark.iter().copied().chain(text.encode_utf16());
        units
            .flat_map(|unit| {
                if big {
                    unit.to_be_bytes()
                } else {
                    unit.to_le_bytes()
                }
            })
            .collect()
    };
    let standard = text("time_s,angle_rad\n", ',', '.');
    let german = text("time_s;angle_rad\n", ';', ',');
    let quoted = standard
        .lines()
        .enumerate()
        .map(|(line, text)| match line {
            0 => format!("{text}\n"),
            _ => format!("\"{}\"\n", text.replace(',', "\",\"").replace('.', ",")),
        })
        .collect::<String>();
    let with_units = standard
        .lines()
        .enumerate()
        .map(|(line, text)| match (line, text.split_once(',')) {
            (1.., Some((time, angle))) => {
                let time_ms = 1e3 * time.parse::<f64>().expect("a time");
                format!("{time_ms} ms,{angle} rad\n")
            }
            _ => format!("{text}\n"),
        })
        .collect::<String>();
    let mapped = "columns = { time = \"Zeit\", angle = \"Winkel °\" }";
    let numbered = "columns = { time = \"1\", angle = \"2\" }";
    let mut windows = text("Zeit;Winkel \u{b0}\n", ';', ',').into_bytes();
    windows.retain(|byte| *byte != 0xc2);
    let cases: Vec<(&str, &str, Vec<u8>)> = vec![
        ("standard", "", standard.clone().into_bytes()),
        (
            "byte order mark",
            "",
            [b"\xef\xbb\xbf", standard.as_bytes()].concat(),
        ),
        (
            "semicolons",
            "",
            text("time_s;angle_rad\n", ';', '.').into_bytes(),
        ),
        ("decimal commas", "", german.clone().into_bytes()),
        (
            "tabs",
            "",
            text("time_s\tangle_rad\n", '\t', '.').into_bytes(),
        ),
        (
            "tabs and commas",
            "",
            text("time_s\tangle_rad\n", '\t', ',').into_bytes(),
        ),
        (
            "sep=",
            "",
            text("sep=;\ntime_s;angle_rad\n", ';', ',').into_bytes(),
        ),
        ("UTF-16 little", "", utf_16(&german, false, true)),
        ("UTF-16 big", "", utf_16(&standard, true, true)),
        ("UTF-16 without a mark", "", utf_16(&standard, false, false)),
        ("Windows-1252", mapped, windows),
        (
            "line ends of Windows",
            "",
            german.replace('\n', "\r\n").into_bytes(),
        ),
        (
            "a title",
            "",
            text("Swing of 3 May\nlogger: 12\n\ntime_s,angle_rad\n", ',', '.').into_bytes(),
        ),
        (
            "units",
            "",
            text("time_s,angle_rad\n[s],[rad]\n", ',', '.').into_bytes(),
        ),
        ("decimal commas in quotation marks", "", quoted.into_bytes()),
        ("units in the cells", "", with_units.into_bytes()),
        (
            "line ends of an old Macintosh",
            "",
            text("A title\ntime_s,angle_rad\n", ',', '.')
                .replace('\n', "\r")
                .into_bytes(),
        ),
        ("no header", numbered, text("", ',', '.').into_bytes()),
        (
            "no header, commas",
            numbered,
            text("", ';', ',').into_bytes(),
        ),
    ];
    for (case, more, log) in cases {
        let experiment = load(more, &log).unwrap_or_else(|error| panic!("{case}: {error}"));
        assert_samples(case, &experiment);
    }
}

#[test]
fn units_of_the_file_are_used_and_said_unless_bench_toml_knows_better() {
    let log = "time_s,angle_rad\nms,°\n0,0\n250,90\n500,0\n750,-90\n1000,0\n1250,90\n";
    let experiment = load("", log.as_bytes()).expect("units");
    assert_eq!(experiment.log.time_s[1], 0.25);
    let angle = experiment.log.angle_rad.expect("an angle");
    assert!((angle[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    let notes = experiment.report.notes;
    assert_eq!(
        notes
            .iter()
            .filter(|note| matches!(note, Note::UnitFromFile { .. }))
            .count(),
        2
    );

    let experiment = load("units = { angle = \"mrad\" }", log.as_bytes()).expect("units");
    assert_eq!(experiment.log.angle_rad.expect("an angle")[1], 0.09);
}

#[test]
fn rows_at_equal_times_need_no_time_column() {
    let log = "angle_rad\n0.1\n0.2\n0.1\n0.0\n-0.1\n-0.2\n";
    let experiment = load(
        "time_step = 0.5\nfrom = 0.5\nscale = { angle = 0.5 }",
        log.as_bytes(),
    );
    let experiment = experiment.expect("a time step");
    assert_eq!(experiment.log.time_s, [0.5, 1.0, 1.5, 2.0, 2.5]);
    assert_eq!(
        experiment.log.angle_rad,
        Some(vec![0.1, 0.05, 0.0, -0.05, -0.1])
    );
    for (more, log, parts) in [
        (
            "time_step = 0.5",
            "time_s,angle_rad\n0,1\n",
            &["bench.toml:5:13", "\"time_s\""][..],
        ),
        ("", log, &["time_step"]),
        ("time_step = 0.0", log, &["time_step"]),
        (
            "scale = { angle = 0 }",
            "time_s,angle_rad\n0,1\n",
            &["bench.toml:5", "angle"],
        ),
        (
            "columns = { angle = \"a\", rate = \"a\" }",
            "time_s,a\n0,1\n",
            &[
                "bench.toml:5:33",
                "rate is mapped to \"a\", and so is angle",
            ],
        ),
        (
            "",
            "time_s;angle_rad\n1,000;1,234\n2,000;1,235\n",
            &["log.csv:2", "1.000", "1000"],
        ),
        (
            "",
            "0,1\n1,2\n2,3\n3,4\n4,5\n5,6\n",
            &["no header line", "\"1\", \"2\""],
        ),
    ] {
        let error = load(more, log.as_bytes()).expect_err(log);
        for part in parts {
            assert!(error.contains(part), "{part} is not in: {error}");
        }
    }
}

#[test]
fn the_angle_of_the_wheel_gives_its_speed() {
    let mut log = "time_s,wheel_angle_rad,current_A\n".to_owned();
    for row in 0..50 {
        let time_s = 0.01 * row as f64;
        // 30 rad/s, within one turn.
        let angle = (30.0 * time_s) % std::f64::consts::TAU;
        log.push_str(&format!("{time_s},{angle},0.2\n"));
    }
    let folder = Folder::bench(&one("spin-up", ""), &log);
    let bench = Bench::load(folder.path()).unwrap_or_else(|error| panic!("{error}"));
    let experiment = &bench.experiments[0];
    let speed = experiment.log.wheel_speed_rad_s.as_ref().expect("a speed");
    assert!(
        speed.iter().all(|speed| (speed - 30.0).abs() < 1e-9),
        "{speed:?}"
    );
    assert!(experiment.report.notes.contains(&Note::SpeedFromAngle));
}

#[test]
fn what_a_kind_holds_still_is_read_beside_it() {
    let mut log = "time_s,angle_rad,wheel_speed_rad_s\n".to_owned();
    for row in 0..20 {
        let wheel = if row == 3 {
            "off".to_owned()
        } else {
            row.to_string()
        };
        log.push_str(&format!("{},0.1,{wheel}\n", 0.1 * row as f64));
    }
    let folder = Folder::bench(&one("free-swing", ""), &log);
    let bench = Bench::load(folder.path()).unwrap_or_else(|error| panic!("{error}"));
    let experiment = &bench.experiments[0];
    assert_eq!(experiment.log.wheel_speed_rad_s, None);
    let beside = experiment
        .beside
        .wheel_speed_rad_s
        .as_ref()
        .expect("beside");
    assert_eq!(beside[2], 2.0);
    assert!(beside[3].is_nan());
}

/// What can be read in two ways, or contradicts what is stated, is refused with its place and the cause.
#[test]
fn cells_that_leave_a_doubt_are_refused() {
    let rows = |cells: &str| format!("time_s,angle_rad\n0,0\n1,0.5\n2,0\n3,{cells}\n4,0\n5,0.5\n");
    for (more, log, parts) in [
        (
            "",
            rows("\"1,234\""),
            &["log.csv:5", "angle_rad", "1.234", "1234"][..],
        ),
        (
            "",
            rows("\"0,123\""),
            &["log.csv:5", "angle_rad", "a point, not a comma"],
        ),
        (
            "",
            rows("3 deg"),
            &["log.csv:5", "angle_rad", "3 deg", "one unit"],
        ),
        ("", rows("12:30:05"), &["log.csv:5", "time of day"]),
        (
            "units = { angle = \"mrad\" }",
            "time_s,angle_rad\n0,0 deg\n1,1 deg\n2,0 deg\n3,1 deg\n4,0 deg\n".to_owned(),
            &["log.csv:2", "0 deg"],
        ),
        (
            "",
            "time_s,angle_rad\n0,0,0,5\n0,5,0,25\n1,0,0,5\n1,5,0,25\n2,0,0,5\n".to_owned(),
            &["log.csv:2", "decimal commas"],
        ),
    ] {
        let error = load(more, log.as_bytes()).expect_err(&log);
        for part in parts {
            assert!(error.contains(part), "{part} is not in: {error}");
        }
    }
}

/// An angle that its sensor wraps is unwrapped even where its noise makes the range larger than a turn.
#[test]
fn a_wrapped_angle_with_noise_is_unwrapped() {
    let mut log = "time_s,angle_rad\n".to_owned();
    let truth = |row: u32| {
        0.4 * f64::from(row).mul_add(0.1, 0.3).sin() + 6.0 * (0.02 * f64::from(row)).sin()
    };
    for row in 0..200 {
        let turn = std::f64::consts::TAU;
        let noise = 0.1 * (f64::from(row * 7 % 5) - 2.0);
        let angle = truth(row).rem_euclid(turn) + noise;
        log.push_str(&format!("{},{angle}\n", 0.01 * f64::from(row)));
    }
    let folder = Folder::bench(&one("driven", "constants = { current = 0.0 }"), &log);
    let bench = Bench::load(folder.path()).unwrap_or_else(|error| panic!("{error}"));
    let angle = bench.experiments[0]
        .log
        .angle_rad
        .as_ref()
        .expect("an angle");
    let steps = angle.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    assert!(steps.fold(0.0, f64::max) < 1.0, "{angle:?}");
}

/// A column of times of day, or of dates, is a time in seconds: with the standard name, with another, and with decimal
/// commas.
#[test]
fn times_of_day_are_seconds() {
    for (header, clock, separator, decimal) in [
        ("time_s,angle_rad\n", "14:30:", ",", "."),
        ("time_s,angle_rad\n", "2024-03-05T14:30:", ",", "."),
        ("time_s;angle_rad\n", "05.03.2024 14:30:", ";", ","),
        ("time_s\tangle_rad\n", "3/5/2024 14:30:", "\t", "."),
    ] {
        let mut log = header.to_owned();
        for (time, angle) in (0..ROWS).map(value) {
            let row = format!("{time:06.3}{separator}{angle:.4}\n");
            log.push_str(clock);
            log.push_str(&row.replace('.', decimal));
        }
        let found = load("", log.as_bytes()).unwrap_or_else(|error| panic!("{log}{error}"));
        let first = found.log.time_s[0];
        for row in 0..ROWS {
            let (time, angle) = value(row);
            assert!((found.log.time_s[row] - first - time).abs() < 1e-6, "{log}");
            let seen = found.log.angle_rad.as_ref().expect("an angle")[row];
            assert!((seen - angle).abs() < 1e-12, "{log}");
        }
    }
}

/// A line that is at fault is shown with what it looks like.
#[test]
fn faulty_lines_are_named_by_their_cause() {
    let header = "time_s,angle_rad\n";
    let rows: String = (0..8).map(|k| format!("{k}.0,0.{k}\n")).collect();
    for (line, parts) in [
        (
            "time_s,angle_rad\n",
            &["log.csv:10", "header line stands here again"][..],
        ),
        (
            "// knocked here\n",
            &["log.csv:10", "only lines that begin with #"],
        ),
        ("\"8.0,0.8\n", &["log.csv:10", "quotation mark", "1 cell,"]),
        ("8.0\n", &["log.csv:10", "1 cell, but the header has 2"]),
        ("8.0,\0\0\0,\n", &["log.csv:10", "zero bytes"]),
        ("8.0,-nan(ind)\n", &["log.csv:10", "not a finite number"]),
        ("8.0,#DIV/0!\n", &["log.csv:10", "not a finite number"]),
        ("8.0,\n", &["log.csv:10", "slower than the others"]),
    ] {
        let log = format!("{header}{rows}{line}9.0,0.9\n");
        let error = load("", log.as_bytes()).expect_err(line);
        for part in parts {
            assert!(error.contains(part), "{part} is not in: {error}");
        }
    }
    // Where two files were joined, the mark of the second stands before a number.
    let joined = format!("{header}{rows}\u{feff}8.0,0.8\n");
    assert!(load("", joined.as_bytes()).is_ok());
}

/// micros() of a board starts again after 71 minutes; the line and what to add are said.
#[test]
fn a_counter_that_starts_again_is_named() {
    let rows: String = (0..8_u64)
        .map(|k| {
            format!(
                "{},0.{k}\n",
                (4_294_967_296 - 20_000 + 5000 * k) % 4_294_967_296
            )
        })
        .collect();
    let more = "columns = { time = \"micros\" }\nunits = { time = \"us\" }";
    let error = load(more, format!("micros,angle_rad\n{rows}").as_bytes()).expect_err("backwards");
    for part in ["log.csv:6", "add 4294967296"] {
        assert!(error.contains(part), "{part} is not in: {error}");
    }
}
