//! Tests with models that state the hardware, leave parts of it out, or contradict themselves.

use attitude::AttitudeSpec;

use super::*;
use attitude::STANDARD_GRAVITY;
use codegen::hardware::RateNeeds;
use std::path::Path;

/// A model of the thesis with other sections of hardware and calibration.
fn file(more: &str) -> ModelFile {
    let text = format!(
        "[parameters.total_inertia]\nvalue = 2.3e-3\n\n[effects]\npresent = [\"body-viscous-friction\"]\n{more}"
    );
    ModelFile::parse(&text, Path::new("model.toml")).expect("a model")
}

fn of(more: &str, preset: bool) -> Result<BenchHardware, HardwareError> {
    bench_hardware(&file(more), NEEDS, preset.then_some(Preset::ThesisBench))
}

/// The numbers of the loop of the thesis.
const NEEDS: RateNeeds = RateNeeds {
    sample_time_s: 1e-3,
    rate_gain: -2.13,
    current_limit_a: 2.0,
    delay_margin_s: 0.045,
};

/// The attitude of a bench with inertial sensors.
fn attitude(found: &BenchHardware) -> &AttitudeSpec {
    found.sensors.attitude().expect("inertial sensors")
}

fn body_encoder(more: &str) -> Result<BenchHardware, HardwareError> {
    of(
        &format!("[hardware.angle]\nkind = \"encoder\"\n{more}\n"),
        true,
    )
}

/// The window is the shortest one with which a count of the rate changes the current by at most an eighth of its limit.
/// At 1 kHz, 2.13 δ/(N T) = 0.25 A gives N = 13.1 for the AS5600 and 3.3 for the AS5048. The delay of the window stays
/// below a quarter of the delay margin.
#[test]
fn the_window_of_an_encoder_weighs_its_count_against_its_delay() {
    let window = |more: &str| {
        let found = body_encoder(more).expect("an encoder on the pivot");
        let body = found.sensors.body_encoder().expect("an encoder");
        assert!(found.sensors.attitude().is_none());
        body.encoder.window
    };
    assert_eq!(window("part = \"AS5600\"\nzero = 2048"), 14);
    assert_eq!(window("counts_per_turn = 16384\nbits = 14\nzero = 0"), 4);
    assert_eq!(window("counts_per_turn = -65536\nbits = 16\nzero = 9"), 1);
    assert_eq!(window("counts_per_turn = 1024\nbits = 10\nzero = 0"), 16);
    let hurried = RateNeeds {
        delay_margin_s: 0.01,
        ..NEEDS
    };
    assert_eq!(hurried.window(std::f64::consts::TAU / 4096.0), 5);
    let slow = RateNeeds {
        sample_time_s: 0.02,
        ..NEEDS
    };
    assert_eq!(slow.window(std::f64::consts::TAU / 4096.0), 1);
}

#[test]
fn a_count_that_stands_for_several_angles_is_refused() {
    assert!(matches!(
        body_encoder("counts_per_turn = 4096\nbits = 11\nzero = 0"),
        Err(HardwareError::Contradiction(message)) if message.contains("several angles")
    ));
    let warned = |more: &str, part: &str| {
        let found = body_encoder(more).expect("an encoder");
        found.warnings.iter().any(|text| text.contains(part))
    };
    // A counter of 16 bits behind lines of an incremental encoder.
    assert!(warned(
        "counts_per_turn = 2400\nbits = 16\nzero = 1200",
        "not a whole number"
    ));
    assert!(!warned(
        "counts_per_turn = 8192\nbits = 16\nzero = 1200",
        "not a whole number"
    ));
    assert!(warned(
        "counts_per_turn = 256\nbits = 8\nzero = 0",
        "rattle"
    ));
    assert!(!warned("part = \"AS5600\"\nzero = 0", "rattle"));
}

#[test]
fn without_a_word_everything_is_missing_or_assumed() {
    let Err(HardwareError::Missing { missing }) = of("", false) else {
        panic!("nothing is stated");
    };
    let text = missing.join("\n");
    for part in [
        "gyroscope",
        "accelerometer",
        "place on the body",
        "wheel_speed",
        "drive",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let filled = of("", true).expect("the bench of the thesis");
    assert_eq!(filled.drive, PwmDrive::THESIS_BENCH);
    assert_eq!(filled.assumed.len(), 5, "{:?}", filled.assumed);
    assert_eq!(attitude(&filled), &AttitudeSpec::thesis());
}

/// A calibrated line keeps the preset's timer where its zero fits, whatever its slope; a line
/// about another zero is another timer's.
#[test]
fn a_preset_fills_a_timer_and_no_other() {
    for range_a in [0.3, 2.2, 3.2, 3.99, 7.0, 30.0] {
        let slope = 26_214.0 / range_a;
        let more = format!(
            "[calibration.current]\nslope = {slope:?}\nslope_std = 1.0\noffset = 32768.0\noffset_std = 1.0\n"
        );
        let drive = of(&more, true).expect("its timer").drive;
        assert!((drive.current_range_a() / range_a - 1.0).abs() < 1e-12);
    }
    let other = "[calibration.current]\nslope = 745.0\nslope_std = 0.3\noffset = 2048.0\noffset_std = 0.4\n";
    assert!(matches!(
        of(other, true),
        Err(HardwareError::Contradiction(message)) if message.contains("the timer is another one")
    ));
    // A stated timer is used as stated.
    let stated = format!(
        "{other}[hardware.drive]\nkind = \"current\"\nbits = 12\nduty_zero = 2048\nduty_low = 410\nduty_high = 3686\n"
    );
    let drive = of(&stated, true).expect("a timer of 12 bits").drive;
    assert_eq!(
        (drive.duty_low, drive.duty_zero, drive.duty_high),
        (410, 2048, 3686)
    );
    assert!((drive.current_range_a() - 1638.0 / 745.0).abs() < 1e-12);
}

#[test]
fn signs_that_contradict_are_refused() {
    let line = |slope: f64| {
        format!(
            "[calibration.wheel_speed]\nslope = {slope:?}\nslope_std = 1e-4\noffset = 0.0\noffset_std = 1.0\n"
        )
    };
    assert!(matches!(
        of(&line(-0.89), true),
        Err(HardwareError::Contradiction(_))
    ));
    let stated = "[hardware.wheel_speed]\nkind = \"converter\"\nslope = -0.9\noffset = 690.0\nlow = 0\nhigh = 1546\n";
    let found = of(&format!("{}{stated}", line(-0.89)), true).expect("stated so");
    assert_eq!(found.sensors.wheel_speed_per_count, -0.89);
    let drive = "[calibration.current]\nslope = -7489.0\nslope_std = 5.0\noffset = 32768.0\noffset_std = 6.0\n\
         [hardware.drive]\nkind = \"current\"\namperes_per_count = 1.3e-4\nduty_zero = 32768\nduty_low = 6554\nduty_high = 58982\n";
    assert!(matches!(
        of(drive, true),
        Err(HardwareError::Contradiction(message)) if message.contains("sign")
    ));
}

#[test]
fn a_one_way_converter_is_warned_of() {
    let one_way = "[calibration.wheel_speed]\nslope = 0.14652\nslope_std = 1e-5\noffset = 0.01\noffset_std = 0.1\n";
    let found = of(one_way, true).expect("with a warning");
    assert!(
        found
            .warnings
            .iter()
            .any(|text| text.contains("cannot show a negative speed")),
        "{:?}",
        found.warnings
    );
    assert!(of("", true).expect("two ways").warnings.is_empty());
}

/// Half a turn about the sensor's x axis reverses y and z, stated either way.
#[test]
fn an_upside_down_sensor_is_turned() {
    let mounted = "[calibration.mounting]\naxis = [0.0, 0.0, -1.0]\naxis_std_rad = 1e-4\nangle = 0.0\nangle_std = 1e-3\n";
    let axes = "[hardware.gyroscope]\npart = \"FXAS21002\"\naxes = [\"x\", \"-y\", \"-z\"]\n\
         [hardware.accelerometer]\npart = \"FXOS8700\"\naxes = [\"x\", \"-y\", \"-z\"]\n";
    for more in [mounted, axes] {
        let found = of(more, true).expect("turned");
        let found = attitude(&found);
        for line in [found.gyro, found.accel] {
            let reversed = line.matrix.diagonal().map(f64::signum);
            assert_eq!(reversed, nalgebra::Vector3::new(1.0, -1.0, -1.0), "{more}");
            assert!(line.matrix.determinant() > 0.0);
        }
        assert_eq!(found.mounting_angle_rad, 0.0);
    }
}

/// 4096 counts at rest are one g, through every part's scale.
#[test]
fn the_scale_of_a_part_is_used() {
    let more = "[hardware.accelerometer]\npart = \"LSM6DS3\"\naxes = [\"y\", \"-x\", \"z\"]\n\
         [hardware.gyroscope]\npart = \"LSM6DS3\"\naxes = [\"y\", \"-x\", \"z\"]\n";
    let found = of(more, true).expect("known parts");
    let found = attitude(&found);
    let one_g = (1.0 / 0.244e-3_f64).round() as i16;
    let read = found.accel.apply([one_g, 0, 0]);
    assert!((read.y - STANDARD_GRAVITY).abs() < 2e-3, "{read:?}");
    assert!(read.x.abs() < 1e-12 && read.z.abs() < 1e-12);
}
