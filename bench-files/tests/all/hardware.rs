//! The section `[hardware]`: presets, overrides, and what is refused with its place.

use std::path::Path;

use bench_files::{
    AngleSensor, DriveKind, Error, FilesInMemory, ModelFile, Problem, WheelSpeedSensor,
};

const HEAD: &str = "[parameters.total_inertia]\nvalue = 2.3e-3\n\n[effects]\npresent = [\"body-viscous-friction\"]\n";

fn read(section: &str) -> Result<ModelFile, Error> {
    ModelFile::parse(&format!("{HEAD}{section}"), Path::new("model.toml"))
}

#[test]
fn presets_are_filled_in_and_overridden() {
    let file = read(
        "[hardware.gyroscope]\npart = \"mpu6050\"\nscale = 1.3323124e-4\naxes = [\"y\", \"-x\", \"z\"]\n\
         [hardware.accelerometer]\npart = \"FXOS8700\"\naxes = [\"x\", \"-y\", \"-z\"]\nlever_arm = [0.05, 0.01]\n\
         [hardware.magnetometer]\npart = \"MPU-9250\"\n\
         [hardware.wheel_speed]\nkind = \"encoder\"\npart = \"AS5600\"\nwindow = 8\n\
         [hardware.angle]\nkind = \"inertial\"\n\
         [hardware.drive]\npart = \"ESCON 24/2\"\namperes_per_count = -8.4e-5\n",
    )
    .expect("all of it is known");
    let hardware = file.hardware.expect("the section");
    let gyroscope = hardware.gyroscope.expect("stated");
    assert_eq!(gyroscope.part.map(|part| part.name), Some("MPU-6050"));
    // The scale of ±250 °/s goes before that of the preset's ±2000 °/s.
    assert_eq!(gyroscope.scale, Some(1.3323124e-4));
    assert_eq!(gyroscope.clip, [32_767; 3]);
    assert_eq!(gyroscope.rate_hz, Some(1000.0));
    // The sensor's x shows the body's y, its y the body's −x.
    let turn = gyroscope.rotation.expect("axes");
    assert_eq!(turn, [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    let accelerometer = hardware.accelerometer.expect("stated");
    assert_eq!(accelerometer.clip, [32_764; 3]);
    assert!((accelerometer.scale.expect("of the part") * 4096.0 - 9.80665).abs() < 1e-12);
    assert_eq!(accelerometer.lever_arm_m, Some([0.05, 0.01]));
    // The compass of an MPU-9250 shows y, x and −z of the housing.
    let compass = hardware
        .magnetometer
        .expect("stated")
        .rotation
        .expect("of the part");
    assert_eq!(
        compass,
        [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]
    );
    let encoder = WheelSpeedSensor::Encoder {
        counts_per_turn: 4096.0,
        bits: 12,
        window: 8,
        largest_rad_s: None,
    };
    assert_eq!(hardware.wheel_speed, Some(encoder));
    assert_eq!(hardware.angle, Some(AngleSensor::Inertial));
    let drive = hardware.drive.expect("stated");
    assert_eq!(drive.kind, DriveKind::Current);
    assert_eq!(
        (drive.duty_low, drive.duty_zero, drive.duty_high),
        (Some(6_554), Some(32_768), Some(58_982))
    );
    assert_eq!(drive.amperes_per_count, Some(-8.4e-5));
}

/// How a housing sits on the body is the bench's: a part does not state it.
#[test]
fn a_part_does_not_say_how_it_is_mounted() {
    let file = read("[hardware.gyroscope]\npart = \"MPU-6050\"\n").expect("known");
    let gyroscope = file.hardware.and_then(|hardware| hardware.gyroscope);
    assert_eq!(gyroscope.expect("stated").rotation, None);
}

#[test]
fn a_word_of_fewer_bits_clips_at_its_end() {
    for (justified, clip) in [("right", 8_191), ("left", 32_764)] {
        let file = read(&format!(
            "[hardware.accelerometer]\nscale = 2.4e-3\nbits = 14\njustified = \"{justified}\"\n"
        ))
        .expect("known");
        let sensor = file.hardware.and_then(|hardware| hardware.accelerometer);
        assert_eq!(sensor.expect("stated").clip, [clip; 3]);
    }
}

/// What is wrong is said with its line and what would be right.
#[test]
fn slips_are_refused_with_their_place() {
    let cases = [
        ("[hardware.gyro]\nscale = 1e-3\n", "gyroscope"),
        ("[hardware.gyroscope]\nscal = 1e-3\n", "scale"),
        ("[hardware.gyroscope]\npart = \"MPU-6051\"\n", "MPU-6050"),
        ("[hardware.gyroscope]\nscale = -1e-3\n", "positive"),
        ("[hardware.gyroscope]\nclip = [0, 1, 2]\n", "1 to 32767"),
        (
            "[hardware.gyroscope]\naxes = [\"x\", \"y\", \"-z\"]\n",
            "left-handed",
        ),
        (
            "[hardware.gyroscope]\naxes = [\"x\", \"x\", \"z\"]\n",
            "once",
        ),
        (
            "[hardware.gyroscope]\nrotation = [[1, 0, 0], [0, 2, 0], [0, 0, 1]]\n",
            "not a rotation",
        ),
        (
            "[hardware.gyroscope]\nrotation = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\n",
            "left-handed",
        ),
        (
            "[hardware.gyroscope]\nlever_arm = [0.0, 0.0]\n",
            "unknown key",
        ),
        (
            "[hardware.wheel_speed]\nkind = \"convertor\"\n",
            "converter",
        ),
        (
            "[hardware.wheel_speed]\nkind = \"converter\"\nslope = 0.9\nlow = 5\nhigh = 5\n",
            "greater than low",
        ),
        (
            "[hardware.wheel_speed]\nkind = \"converter\"\nslope = 0.9\n",
            "low",
        ),
        (
            "[hardware.angle]\nkind = \"encoder\"\ncounts_per_turn = 4096\nbits = 12\nzero = 5000\n",
            "0 to 4095",
        ),
        (
            "[hardware.drive]\nkind = \"current\"\nbits = 12\nduty_zero = 32768\n",
            "0 to 4095",
        ),
        (
            "[hardware.drive]\nkind = \"current\"\nduty_zero = 10\nduty_low = 20\nduty_high = 30\n",
            "between",
        ),
        ("[hardware.drive]\nkind = \"voltage\"\n", "supply_voltage"),
        (
            "[hardware.drive]\nkind = \"current\"\nsupply_voltage = 12\n",
            "belongs to kind = \"voltage\"",
        ),
        ("[hardwear]\n", "hardware"),
    ];
    for (section, wanted) in cases {
        let error = read(section).expect_err(section);
        let text = error.to_string();
        assert!(text.contains(wanted), "{section}: {text}");
        let line = error.place().line.expect("a line");
        assert!(line > HEAD.lines().count(), "{section}: {text}");
    }
}

/// The section of bench.toml is that of the bench, comments and all; sections of other programs are
/// let be, others not.
#[test]
fn the_section_of_a_bench_reaches_the_model_as_it_is_written() {
    let bench = "[bench]\nname = \"mine\"\n\n# Beside the wheel.\n[hardware.gyroscope]\npart = \"MPU-6050\"   # at ±2000 °/s\n\n\
         [tool.mine]\nkept = true\n\n[[experiment]]\nname = \"swing\"\nkind = \"free-swing\"\nfile = \"swing.csv\"\n";
    let log: String = (0..200)
        .map(|k| format!("{},{}\n", 0.01 * f64::from(k), (0.1 * f64::from(k)).sin()))
        .collect();
    let files: FilesInMemory = [
        ("bench.toml", bench.to_owned()),
        ("swing.csv", format!("time_s,angle_rad\n{log}")),
    ]
    .into_iter()
    .collect();
    let read_bench = bench_files::Bench::from_files(&files).expect("a bench");
    let mut model = read("").expect("a model");
    model.hardware = read_bench.hardware;
    let text = model.to_toml();
    assert!(
        text.contains("# Beside the wheel.\n[hardware.gyroscope]\n"),
        "{text}"
    );
    assert!(
        text.contains("part = \"MPU-6050\"   # at ±2000 °/s"),
        "{text}"
    );
    let again = ModelFile::parse(&text, Path::new("model.toml")).expect("its own text");
    assert_eq!(again, model);
    assert_eq!(again.to_toml(), text);

    let mut other = files;
    other.insert("bench.toml", bench.replace("[tool.mine]", "[mine]"));
    let error = bench_files::Bench::from_files(&other).expect_err("an unknown section");
    assert!(matches!(error.problem(), Problem::UnknownKey { key, .. } if key == "mine"));
}

/// What `calibrate` leaves where nothing was identified yet is a file that every command reads.
#[test]
fn a_model_without_parameters_is_read() {
    let text = ModelFile::new().to_toml();
    let read = ModelFile::parse(&text, Path::new("model.toml")).expect("its own text");
    assert!(read.parameters.is_empty());
    let error = read.parameter_vector().expect_err("no parameters");
    assert!(matches!(error.problem(), Problem::MissingParameter { .. }));
}

/// A key of another kind is no unknown key, and a part without data needs no preset.
#[test]
fn keys_of_other_kinds_and_unknown_parts_say_what_to_do() {
    for (text, parts) in [
        (
            "[hardware.drive]\nkind = \"current\"\nsupply_voltage = 12.0\n",
            &["belongs to kind = \"voltage\"", "kind = \"current\""][..],
        ),
        (
            "[hardware.wheel_speed]\nkind = \"encoder\"\ncounts_per_turn = 4096\nwindow = 8\nslope = 0.4\n",
            &["belongs to kind = \"converter\""],
        ),
        (
            "[hardware.angle]\nkind = \"inertial\"\nzero = 5\n",
            &["belongs to kind = \"encoder\""],
        ),
        (
            "[hardware.angle]\nkind = \"encoder\"\npart = \"AS5048A\"\nzero = 5\n",
            &[
                "no data for the part \"AS5048A\"",
                "leave part out and give counts_per_turn and bits",
                "AS5600",
            ],
        ),
        (
            "[hardware.drive]\npart = \"ODrive\"\n",
            &["leave part out and give kind, bits"],
        ),
        (
            "[hardware.drive]\nkind = \"current\"\nnonsense = 1\n",
            &["unknown key \"nonsense\""],
        ),
    ] {
        let message = read(text).expect_err("a wrong entry").to_string();
        for part in parts {
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}

/// The bench's sensors replace those that the model had: a changed axis must not be lost.
#[test]
fn the_hardware_of_a_model_is_replaced() {
    let gyroscope = |axes: &str| {
        let section = format!("[hardware.gyroscope]\npart = \"FXAS21002\"\naxes = {axes}\n");
        read(&section).expect("a model")
    };
    let mut model = gyroscope("[\"x\", \"y\", \"z\"]");
    let of_bench = gyroscope("[\"-y\", \"x\", \"z\"]");
    model.hardware = of_bench.hardware.clone();
    let again = ModelFile::parse(&model.to_toml(), Path::new("model.toml")).expect("a model");
    assert_eq!(again.hardware, of_bench.hardware);
    // Another kind of sensor replaces the whole section.
    let encoder = "[hardware.angle]\nkind = \"encoder\"\npart = \"AS5600\"\nzero = 2048\n";
    let encoder = read(encoder).expect("a model");
    model.hardware = encoder.hardware.clone();
    let again = ModelFile::parse(&model.to_toml(), Path::new("model.toml")).expect("a model");
    assert_eq!(again.hardware, encoder.hardware);
}
