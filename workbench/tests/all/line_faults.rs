//! Records from a line with faults: the other end of a pseudo-terminal plays the frames of a firmware, and what the line
//! does to them. What is lost, damaged or repeated must be counted as it was, and nothing else.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use identify::Progress;
use serial_frame::Telemetry;
use serialport::{SerialPort, TTYPort};
use workbench::{RecordEnd, RecordReport, RecordSettings, RecordedExperiment, record};

const BENCH: &str = r#"
[bench]
name = "line"

[hardware.gyroscope]
part = "FXAS21002"
axes = ["x", "y", "z"]

[hardware.accelerometer]
part = "FXOS8700"
axes = ["x", "y", "z"]

[hardware.wheel_speed]
kind = "converter"
slope = 0.9
offset = -695.0
low = 0
high = 1546

[hardware.angle]
kind = "inertial"

[hardware.drive]
part = "ESCON 24/2"
kind = "current"
amperes_per_count = 8.4e-5
"#;

const READY: u8 = 1;
const RUNNING: u8 = 2;

/// A step of a firmware: the wheel stands still, and the readings differ from step to step, as noise does.
fn step(number: u32) -> Telemetry {
    Telemetry {
        status: RUNNING,
        sequence: number as u16,
        time_us: 1_000 * number,
        gyro: [
            (number % 7) as i16,
            (number % 5) as i16,
            (number % 3) as i16,
        ],
        accel: [-4096, 0, 0],
        wheel: 772,
        duty: 32_768,
        ..Telemetry::default()
    }
}

/// The bytes of a step's frame.
fn bytes(number: u32) -> Vec<u8> {
    step(number).frame().bytes().to_vec()
}

/// Waits for the program's first command, then plays these chunks, one every millisecond, and hangs up.
fn play(
    mut master: TTYPort,
    chunks: impl Iterator<Item = Vec<u8>> + Send + 'static,
) -> JoinHandle<()> {
    thread::spawn(move || {
        let mut any = [0; 64];
        while master.bytes_to_read().unwrap_or(0) == 0 {
            thread::sleep(Duration::from_millis(1));
        }
        let mut next = Instant::now();
        for chunk in chunks {
            // The program's commands are taken off the line. Where it has ended, so does the firmware.
            if master.bytes_to_read().unwrap_or(0) > 0
                && matches!(master.read(&mut any), Err(error) if error.kind() != ErrorKind::TimedOut)
                || master.write_all(&chunk).is_err()
            {
                return;
            }
            next += Duration::from_millis(1);
            thread::sleep(next.saturating_duration_since(Instant::now()));
        }
    })
}

struct Recorded {
    report: RecordReport,
    /// The rows of each log.
    texts: Vec<String>,
}

/// What the program records of these chunks.
fn recorded(
    experiment: RecordedExperiment,
    currents_a: &[f64],
    seconds: f64,
    chunks: impl Iterator<Item = Vec<u8>> + Send + 'static,
) -> Result<Recorded, String> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("bench.toml"), BENCH).expect("written");
    let (master, slave) = TTYPort::pair().expect("a pseudo-terminal");
    let port = slave.name().expect("its name");
    let settings = settings(Path::new(&port), experiment, currents_a, seconds);
    let board = play(master, chunks);
    let report = record(folder.path(), &settings, &Progress::silent(), &mut |_| {});
    let report = report.map_err(|error| error.to_string());
    let texts = report.iter().flat_map(|report| &report.logs);
    let texts = texts.map(|log| std::fs::read_to_string(&log.file).expect("the log"));
    let texts = texts.collect();
    // A line that nobody has any more ends the board.
    drop(slave);
    board.join().expect("the board ends well");
    Ok(Recorded {
        report: report?,
        texts,
    })
}

fn settings(
    port: &Path,
    experiment: RecordedExperiment,
    currents_a: &[f64],
    seconds: f64,
) -> RecordSettings {
    RecordSettings {
        port: port.to_path_buf(),
        baud: 921_600,
        experiment,
        currents_a: currents_a.to_vec(),
        seconds: Some(seconds),
        name: None,
        every: 1,
        module: None,
        preset: None,
    }
}

fn hanging(chunks: impl Iterator<Item = Vec<u8>> + Send + 'static) -> Recorded {
    recorded(RecordedExperiment::Hanging, &[], 0.5, chunks).expect("a log")
}

/// The last four frames again, after every hundredth: each step is one row, and none is lost.
#[test]
fn frames_that_come_again_after_others_give_one_row_each() {
    let got = hanging((100..).map(|number| {
        let again = if number % 100 == 0 && number > 110 {
            3
        } else {
            0
        };
        let mut chunk = bytes(number);
        chunk.extend((number - again..=number).flat_map(bytes));
        chunk
    }));
    let log = &got.report.logs[0];
    assert_eq!(log.end, RecordEnd::Complete);
    assert_eq!((log.rows, log.lost_frames, log.damaged_frames), (501, 0, 0));
    let times: Vec<&str> = got.texts[0]
        .lines()
        .skip(1)
        .filter_map(|row| row.split(',').nth(8))
        .collect();
    assert!(times.is_sorted_by(|a, b| a < b), "each time once");
}

/// A firmware that restarts is still noticed: its times begin again, and no row has its frames.
#[test]
fn a_restart_in_the_middle_ends_the_log_at_its_last_row() {
    let got = hanging((50_000..50_300).chain(3..).map(bytes));
    let log = &got.report.logs[0];
    assert_eq!(log.end, RecordEnd::Restarted);
    assert_eq!(log.lost_frames, 0);
    assert!((250..300).contains(&log.rows), "{}", log.rows);
}

/// The command that asks for every step takes effect late: the frames of the pace before are no lost ones.
#[test]
fn the_pace_of_an_earlier_record_loses_nothing() {
    let late = (100..1_500).step_by(20).chain(1_500..);
    let got = hanging(late.map(bytes));
    let log = &got.report.logs[0];
    assert_eq!((log.rows, log.lost_frames), (501, 0));
}

/// A line that shows no two neighbours, because it loses every second frame, is recorded all the same.
#[test]
fn a_line_that_loses_every_second_frame_is_recorded() {
    let got = hanging((100..).step_by(2).map(bytes));
    let log = &got.report.logs[0];
    assert_eq!((log.rows, log.lost_frames), (251, 250));
}

/// Text of a boot loader and half a frame come before the first row and are none of its damage; seven frames within the
/// record are.
#[test]
fn damage_is_counted_from_the_first_row_on() {
    let got = hanging((0..).map(|number| match number {
        0 => b"rst:0x1 (POWERON_RESET)\r\n\0ets Jul 29\0\0".to_vec(),
        1 => bytes(1)[20..].to_vec(),
        2..100 => bytes(number),
        _ if number % 50 == 0 && number <= 400 => {
            let mut damaged = bytes(number);
            damaged[9] ^= if damaged[9] == 1 { 2 } else { 1 };
            damaged
        }
        _ => bytes(number),
    }));
    let log = &got.report.logs[0];
    assert_eq!((log.lost_frames, log.damaged_frames), (7, 7));
    assert_eq!(log.rows, 501 - 7);
}

/// The controller runs no more after the first of three spin-ups, and then the plug is pulled: the first log is kept, and
/// the report says what is missing, and why.
#[test]
fn logs_that_are_missing_are_named() {
    let frame = |number: u32| {
        let status = if number < 206 { RUNNING } else { READY };
        let step = Telemetry {
            status,
            ..step(number)
        };
        step.frame().bytes().to_vec()
    };
    let got = recorded(
        RecordedExperiment::SpinUp,
        &[0.1, -0.1, 0.2],
        0.1,
        (100..400).map(frame),
    )
    .expect("a log");
    let [log] = &got.report.logs[..] else {
        panic!("{:?}", got.report.logs);
    };
    assert_eq!(log.end, RecordEnd::Complete);
    let note = log.notes.last().expect("a note");
    assert!(
        note.starts_with("not recorded: spin-up -0.1 A, spin-up 0.2 A (/dev/"),
        "{note}"
    );
}

/// Before the first row, a pulled plug is an error that names the cable, not the system's word for it.
#[test]
fn a_plug_that_is_pulled_at_once_is_one_sentence() {
    let refused = recorded(RecordedExperiment::Hanging, &[], 0.5, (100..101).map(bytes));
    let message = refused.err().expect("an error");
    assert!(
        message.ends_with("the device has disappeared; check its cable"),
        "{message}"
    );
}

/// What is no port, and a port that another program has: one sentence each that says what to do.
#[test]
fn a_port_that_cannot_be_had_says_why() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("bench.toml"), BENCH).expect("written");
    let (_master, slave) = TTYPort::pair().expect("a pseudo-terminal");
    let taken = slave.name().expect("its name");
    let opened = serialport::new(&taken, 921_600)
        .open_native()
        .expect("the line of another program");
    let missing = folder.path().join("no-port");
    let file = folder.path().join("bench.toml");
    for (port, words) in [
        (Path::new(&taken), "another program has it"),
        (&missing, "is the cable plugged in"),
        (&file, "this is no serial device"),
        (folder.path(), "this is no serial device"),
    ] {
        let settings = settings(port, RecordedExperiment::Hanging, &[], 0.5);
        let refused = record(folder.path(), &settings, &Progress::silent(), &mut |_| {});
        let message = refused.expect_err("no line").to_string();
        assert!(message.contains(words), "{message}");
    }
    drop(opened);
}
