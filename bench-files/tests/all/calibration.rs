//! Recordings and results of the calibration.

use std::path::Path;

use bench_files::{
    Bench, Calibration, CalibrationRecordings, LeverArmCalibration, LineCalibration, ModelFile,
    MountingCalibration, StoredSensorCalibration,
};

use crate::common::Folder;

pub const TOML: &str = r#"
[known]
gravity = 9.81
[calibration]
accelerometer = ["up.csv", "down.csv"]
gyroscope = "still.csv"
magnetometer = "round.csv"
swing = "swing.csv"
hanging = "up.csv"
wheel_speed = "converter.csv"
current = "drive.csv"
gyroscope_scale = 1.09e-3
sample_time = 0.001
field = 48.9
columns = { ax = "acc_x", adc_count = "adc" }
[calibration.plumb_lines]
pivot = [0.0, 1]
std = 0.0005
lines = [[[0.1, 0.0], [0.02, -0.13]], [[-0.1, 0.0], [-0.01, -0.13]]]
"#;

pub fn folder(toml: &str) -> Folder {
    let folder = Folder::new();
    folder.write("bench.toml", toml.as_bytes());
    folder.write("up.csv", b"acc_x,ay,az\n1,-2,4096\n3,4,-32768\n");
    folder.write("down.csv", b"az,acc_x,ay\n-4096,0,0\n");
    folder.write("still.csv", b"gx,gy,gz\n1,2,3\n");
    folder.write("swing.csv", b"gx,gy,gz\n7,8,32767\n");
    folder.write("round.csv", b"mx,my,mz\n4,5,6\n");
    folder.write(
        "converter.csv",
        b"adc,wheel_speed_rad_s\n0,-690.5\n1000,203.5\n",
    );
    folder.write("drive.csv", b"duty,current_A\n32768,0\n40000,0.6\n");
    folder
}

#[test]
fn recordings_come_out_as_counts_and_pairs() {
    let folder = folder(TOML);
    let found = CalibrationRecordings::load(folder.path()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(found.known.gravity, Some(9.81));
    let poses: Vec<_> = found
        .accelerometer
        .iter()
        .map(|pose| &pose.counts)
        .collect();
    assert_eq!(
        poses,
        [&vec![[1, -2, 4096], [3, 4, -32768]], &vec![[0, 0, -4096]]]
    );
    assert_eq!(found.swing.expect("swing").counts, [[7, 8, 32767]]);
    assert_eq!(found.hanging.expect("hanging").counts.len(), 2);
    assert_eq!(
        found.wheel_speed,
        Some(vec![(0.0, -690.5), (1000.0, 203.5)])
    );
    assert_eq!(
        found.duty,
        Some(vec![(0.0, 32768.0), (0.6, 40000.0)]),
        "duty over current"
    );
    assert_eq!(found.gyroscope_scale_rad_s, Some(1.09e-3));
    assert_eq!(
        (found.sample_time_s, found.field_ut),
        (Some(0.001), Some(48.9))
    );
    let plumb = found.plumb_lines.expect("plumb lines");
    assert_eq!(plumb.pivot_m, [0.0, 1.0]);
    assert_eq!(plumb.lines[1], [[-0.1, 0.0], [-0.01, -0.13]]);
}

/// The accelerometer's place: by the ruler, and from a swing whose file has the accelerometer too.
#[test]
fn the_lever_arm_is_stated_or_recorded() {
    let plain = folder(TOML);
    let found = CalibrationRecordings::load(plain.path()).expect("loads");
    assert_eq!((found.lever_arm, found.swing_accelerometer), (None, None));

    let stated = "field = 48.9\nlever_arm = [0.05, -0.01]\nlever_arm_std = 0.001\n";
    let full = folder(&TOML.replace("field = 48.9\n", stated));
    full.write("swing.csv", b"gx,gy,gz,acc_x,ay,az\n7,8,9,10,11,-12\n");
    let found = CalibrationRecordings::load(full.path()).expect("loads");
    let arm = found.lever_arm.expect("a lever arm");
    assert_eq!(arm.position_m, [0.05, -0.01]);
    assert_eq!(arm.position_std_m, [0.001; 2]);
    let swing = found.swing_accelerometer.expect("accelerometer");
    assert_eq!(swing.counts, [[10, 11, -12]]);
    assert_eq!(found.swing.expect("gyroscope").counts, [[7, 8, 9]]);

    let refused = |toml: &str, parts: &[&str]| {
        let error = CalibrationRecordings::load(folder(toml).path())
            .expect_err(toml)
            .to_string();
        for part in parts {
            assert!(error.contains(part), "{part:?} is not in {error}");
        }
    };
    let with = |line: &str| TOML.replace("field = 48.9\n", line);
    refused(&with("lever_arm = [0.05, 0.0]\n"), &["lever_arm_std"]);
    refused(
        &with("lever_arm_std = 0.001\n"),
        &["\"lever_arm_std\" needs \"lever_arm\""],
    );
    refused(
        &with("lever_arm = [0.05]\nlever_arm_std = 0.001\n"),
        &["bench.toml:14:13", "two numbers"],
    );
    let model =
        "[parameters]\n[effects]\npresent = []\n[calibration.lever_arm]\nposition = [0.05, 0.0]\n";
    let error = ModelFile::parse(model, Path::new("m.toml"))
        .expect_err("no standard error")
        .to_string();
    assert!(error.contains("position_std"), "{error}");
}

#[test]
fn a_bench_may_have_experiments_and_recordings() {
    let experiment = "[[experiment]]\nname = \"x\"\nkind = \"free-swing\"\nfile = \"log.csv\"\n";
    let folder = folder(&format!("{TOML}{experiment}"));
    folder.write("log.csv", b"time_s,angle_rad\n0,0\n1,0\n2,0\n3,0\n4,0\n");
    assert!(CalibrationRecordings::load(folder.path()).is_ok());
    assert_eq!(
        Bench::load(folder.path()).expect("loads").experiments.len(),
        1
    );
}

#[test]
fn what_is_wrong_is_said() {
    let cases: [(&str, &str, &[&str]); 12] = [
        (
            "[calibration]",
            "[calibrations]",
            &[
                "bench.toml:4:2",
                "\"calibrations\"",
                "did you mean \"calibration\"",
            ],
        ),
        (
            "gyroscope = \"still.csv\"",
            "gyro = \"still.csv\"",
            &["bench.toml:6:1", "\"gyro\"", "did you mean \"gyroscope\""],
        ),
        (
            "\"swing.csv\"",
            "\"gone.csv\"",
            &["bench.toml:8:9", "gone.csv", "no such file"],
        ),
        (
            "ax = \"acc_x\"",
            "ax = \"accx\"",
            &[
                "up.csv:1",
                "no column \"accx\" for ax",
                "did you mean \"acc_x\"",
                "[calibration]",
            ],
        ),
        (
            "adc_count = ",
            "adc = ",
            &["bench.toml:15:27", "\"adc\"", "adc_count"],
        ),
        (
            "gravity = 9.81",
            "",
            &[
                "bench.toml:5:17",
                "\"accelerometer\" needs \"gravity\"",
                "gravity = 9.81",
            ],
        ),
        (
            "sample_time = 0.001",
            "",
            &["bench.toml:6:13", "\"gyroscope\" needs \"sample_time\""],
        ),
        (
            "hanging = \"up.csv\"",
            "",
            &["bench.toml:8:9", "\"swing\" needs \"hanging\""],
        ),
        (
            "field = 48.9",
            "field = -1",
            &["bench.toml:14:9", "\"field\" is -1", "positive"],
        ),
        (
            "std = 0.0005",
            "std = 0",
            &["bench.toml:18:7", "\"std\" is 0", "positive"],
        ),
        (
            "[0.02, -0.13]]",
            "[0.02]]",
            &["bench.toml:19:9", "two marks"],
        ),
        (
            "pivot = [0.0, 1]",
            "pivot = [0.0, nan]",
            &["bench.toml:17:9", "finite"],
        ),
    ];
    for (from, to, parts) in cases {
        assert!(TOML.contains(from), "{from}");
        let folder = folder(&TOML.replace(from, to));
        let error = CalibrationRecordings::load(folder.path())
            .expect_err(to)
            .to_string();
        for part in parts {
            assert!(error.contains(part), "{to}: {part:?} is not in {error}");
        }
    }
    for (text, part) in [
        ("gx,gy,gz\n1,2,3.5\n", "3.5 is not a raw count"),
        ("gx,gy,gz\n1,2,32768\n", "32768 is not a raw count"),
        ("gx,gy,gz\n1,2,-40000\n", "-32768 to 32767"),
    ] {
        let folder = folder(TOML);
        folder.write("still.csv", text.as_bytes());
        let error = CalibrationRecordings::load(folder.path())
            .expect_err(text)
            .to_string();
        assert!(
            error.contains("still.csv:2: column \"gz\"") && error.contains(part),
            "{error}"
        );
    }
}

#[test]
fn results_survive_model_toml() {
    let sensor = StoredSensorCalibration {
        bias_counts: [41.7, -24.2, 9.9],
        bias_std: [0.3, 0.2, 0.1],
        matrix: [
            [2.4e-3, 0.0, 1e-5],
            [0.0, 2.41e-3, 0.0],
            [1e-5, 0.0, 2.39e-3],
        ],
        matrix_std: [[1e-7; 3]; 3],
    };
    let line = LineCalibration {
        slope: 0.893373,
        slope_std: 1e-5,
        offset: -690.574,
        offset_std: 1e-2,
    };
    let full = Calibration {
        accelerometer: Some(sensor),
        gyroscope: Some(sensor),
        beta_rad_s: Some(0.033),
        magnetometer: Some(sensor),
        mounting: Some(MountingCalibration {
            axis: [0.01, -0.02, 0.9997],
            axis_std_rad: 2e-4,
            angle_rad: 2.356,
            angle_std_rad: 1e-3,
        }),
        lever_arm: Some(LeverArmCalibration {
            position_m: [0.05, -0.012],
            position_std_m: [1e-4, 2e-4],
        }),
        wheel_speed: Some(line),
        duty: Some(line),
    };
    let only_lines = Calibration {
        wheel_speed: Some(line),
        ..Calibration::default()
    };
    let mut file = ModelFile::new();
    for calibration in [Some(full), Some(only_lines), None] {
        file.calibration = calibration;
        let text = "[parameters]\n".to_string() + &file.to_toml();
        file = ModelFile::parse(
            &text.replacen("[parameters]\n[parameters", "[parameters", 1),
            Path::new("m.toml"),
        )
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_eq!(file.calibration, calibration, "{text}");
    }
}

/// A fit replaces the parameters of the model and leaves a centre of mass where it is.
#[test]
fn a_fit_keeps_the_centre_of_mass() {
    let parse = |text: &str| ModelFile::parse(text, Path::new("m.toml")).expect("parses");
    let mut file = parse(
        "[parameters.pivot_to_com]\nvalue = 0.0799\nstd = 3e-4\nunit = \"m\"\n\
         [parameters.total_inertia]\nvalue = 1e-3\n[effects]\npresent = []\n",
    );
    let mut other = parse("[parameters.wheel_inertia]\nvalue = 1e-4\n[effects]\npresent = []\n");
    file.replace_model_parameters(std::mem::take(&mut other.parameters), None);
    let names: Vec<&str> = file.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["wheel_inertia", "pivot_to_com"]);
    let again = parse(&file.to_toml());
    assert_eq!(again.parameters.len(), 2);
    for parameter in &file.parameters {
        assert_eq!(again.parameter(&parameter.name), Some(parameter));
    }
}
