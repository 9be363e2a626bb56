//! A bench's own sensors and drive, from the model to the motor.

use std::path::Path;

use attitude::{AttitudeSpec, SensorLine};
use bench_files::ModelFile;
use nalgebra::Matrix3;
use plant::{Kind, Plant};
use simulate::{InterpretedController, RawLoop, RawSensors};
use workbench::{ControlDesign, Error, GeneratedController, HardwareError, Preset, ProofSettings};

use crate::bench::silent;

/// The parameters of the thesis' bench, with this current limit and these sections.
fn designed(limit_a: f64, more: &str) -> ControlDesign {
    let text = format!(
        "[parameters.total_inertia]\nvalue = 2.30344e-3\n\
         [parameters.wheel_inertia]\nvalue = 1.36125e-4\n\
         [parameters.gravity_torque]\nvalue = 0.245158\n\
         [parameters.torque_constant]\nvalue = 0.0335\n\
         [parameters.body_viscous_friction]\nvalue = 5.31781e-3\n\
         [parameters.wheel_viscous_friction]\nvalue = 1.75204e-5\n\
         [effects]\npresent = [\"body-viscous-friction\", \"wheel-viscous-friction\"]\n\
         [design]\nsample_time = 0.001\nstate_weights = [25.0, 0.5, 5e-4]\ncurrent_weight = 1.0\n\
         current_limit = {limit_a:?}\n{more}"
    );
    let file = ModelFile::parse(&text, Path::new("model.toml")).expect("a model");
    ControlDesign::of(file).expect("a design")
}

/// Proves the controller by the quick engines; `compiled` compiles it too and runs the second checker, which takes
/// longer than all of them.
fn proved(controller: &GeneratedController, compiled: bool) {
    let settings = ProofSettings {
        cases: 100,
        compiled,
        python: compiled,
        smt: false,
        kani: false,
        closed_loop: false,
        filter_ranges: false,
        filter_length: false,
        ..ProofSettings::default()
    };
    let proof = controller.prove(&settings, &silent()).expect("a proof");
    let failed: Vec<_> = proof
        .claims
        .iter()
        .filter(|claim| claim.outcome.word() == "failed")
        .collect();
    assert!(failed.is_empty(), "{failed:?}");
    // It is compared with the model that it was emitted from.
    let compared = proof.claims.iter().find(|row| row.id == "model-matches");
    assert_eq!(compared.map(|row| row.outcome.word()), Some("proved"));
}

fn drive(bits: u32, range_a: f64, is_inverted: bool) -> String {
    let full = f64::from((1_u32 << bits) - 1);
    let (low, zero, high) = (
        (0.1 * full).round(),
        (0.5 * full).round(),
        (0.9 * full).round(),
    );
    let slope = range_a / (zero - low).min(high - zero) * if is_inverted { -1.0 } else { 1.0 };
    format!(
        "[hardware.drive]\nkind = \"current\"\nbits = {bits}\nduty_low = {low}\nduty_zero = {zero}\n\
         duty_high = {high}\namperes_per_count = {slope:?}\n"
    )
}

/// A module is emitted for every range of a drive of 16 bits, and for some of 12 bits with an inverted duty. The
/// modules of the smallest and the largest range, of one just below a power of two, and of the inverted ones are
/// proved.
#[test]
fn every_drive_emits() {
    let ranges = [0.4, 2.2, 3.2, 3.5, 3.99, 6.5, 7.9, 13.0, 15.9, 30.0];
    let inverted = [0.4, 3.99, 30.0];
    let drives = ranges.map(|range_a| (range_a, 16, false)).into_iter();
    for (range_a, bits, is_inverted) in drives.chain(inverted.map(|range_a| (range_a, 12, true))) {
        let design = designed(0.9 * range_a, &drive(bits, range_a, is_inverted));
        let controller = design.generate(Some(Preset::ThesisBench));
        let controller = controller.unwrap_or_else(|error| {
            panic!("{range_a} A, {bits} bits, inverted {is_inverted}: {error}")
        });
        if is_inverted || [0.4, 3.99, 30.0].contains(&range_a) {
            proved(&controller, range_a == 30.0 && is_inverted);
        }
    }
}

/// With a narrow range of the duty, the slope has fewer bits; the module is emitted and proved nevertheless.
#[test]
fn a_narrow_range_of_the_duty_emits() {
    let narrow = "[hardware.drive]\nkind = \"current\"\nbits = 16\nduty_low = 31000\nduty_zero = 32768\n\
         duty_high = 34536\namperes_per_count = 1.2e-3\n";
    let controller = designed(2.0, narrow).generate(Some(Preset::ThesisBench));
    proved(&controller.expect("emitted"), false);
}

#[test]
fn without_hardware_a_simulation_assumes_and_a_controller_does_not() {
    let design = designed(2.0, "");
    match design.generate(None) {
        Err(Error::Hardware {
            source: HardwareError::Missing { missing },
            ..
        }) => assert!(missing.len() >= 4, "{missing:?}"),
        other => panic!("{other:?}"),
    }
    let controller = design.generate(Some(Preset::ThesisBench)).expect("assumed");
    assert_eq!(controller.assumed.len(), 5);
    for (path, text) in controller.files() {
        if path == "src/lib.rs" || path == "certificate.json" {
            assert!(
                text.contains("FXAS21002"),
                "{path} does not say what is assumed"
            );
        }
    }
}

/// A sensor is mounted upside down, turned by half a turn about its x axis. If its axes are stated so, the pendulum
/// balances; if they are not stated, it falls, and the emitted module does not arm.
#[test]
fn an_upside_down_sensor_balances() {
    let half_turn = Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, -1.0, -1.0));
    let turned = |line: SensorLine| SensorLine {
        matrix: half_turn * line.matrix,
        ..line
    };
    let thesis = AttitudeSpec::thesis();
    let truth = AttitudeSpec {
        gyro: turned(thesis.gyro),
        accel: turned(thesis.accel),
        ..thesis
    };
    let sensors = RawSensors::calibrated_by(&truth).expect("sensors");
    let mounted = "[calibration.mounting]\naxis = [0.0, 0.0, -1.0]\naxis_std_rad = 1e-4\nangle = 0.0\n\
         angle_std = 1e-3\n";
    let axes = "[hardware.gyroscope]\npart = \"FXAS21002\"\naxes = [\"x\", \"-y\", \"-z\"]\n\
         [hardware.accelerometer]\npart = \"FXOS8700\"\naxes = [\"x\", \"-y\", \"-z\"]\n";
    for (more, stands) in [(mounted, true), (axes, true), ("", false)] {
        let design = designed(2.0, more);
        let controller = design.generate(Some(Preset::ThesisBench)).expect("emitted");
        let sources: Vec<_> = controller.sources().collect();
        let module = checker::Module::parse(&sources).expect("its own source");
        let mut running = InterpretedController::new(&module).expect("a controller");
        let plant = Plant::new(design.model(), design.values(), Kind::Balance);
        let trace = RawLoop::new(&plant, sensors, 3)
            .run(0.05, 4.0, &mut running, true)
            .expect("a run");
        assert_eq!(trace.fell_at_s.is_none(), stands, "{more}");
    }
}

/// Calibrations that no sensor can have are refused before anything is written.
#[test]
fn damaged_calibrations_are_refused() {
    let matrix = |x: f64, y: f64, z: f64| {
        format!(
            "bias_counts = [0.0, 0.0, 0.0]\nbias_std = [0.1, 0.1, 0.1]\n\
             matrix = [[{x:e}, 0.0, 0.0], [0.0, {y:e}, 0.0], [0.0, 0.0, {z:e}]]\n\
             matrix_std = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]\n"
        )
    };
    let (g, w) = (2.394e-3, 1.0908e-3);
    let accel = "[hardware.accelerometer]\npart = \"FXOS8700\"\n";
    let cases = [
        // A mirrored gyroscope, a mirrored accelerometer, g instead of m/s², a range of ±2 g.
        (
            format!("[calibration.gyroscope]\n{}", matrix(w, w, -w)),
            "own axes",
        ),
        (
            format!("[calibration.accelerometer]\n{}", matrix(g, -g, g)),
            "own axes",
        ),
        (
            format!(
                "{accel}[calibration.accelerometer]\n{}",
                matrix(g / 9.81, g / 9.81, g / 9.81)
            ),
            "m/s2",
        ),
        (
            format!(
                "{accel}[calibration.accelerometer]\n{}",
                matrix(g / 4.0, g / 4.0, g / 4.0)
            ),
            "gravity would read",
        ),
        // Half a turn of one sensor only: right-handed, and the rate against the angle.
        (
            format!("[calibration.gyroscope]\n{}", matrix(w, -w, -w)),
            "own axes",
        ),
        (
            format!("[calibration.accelerometer]\n{}", matrix(g, -g, -g)),
            "own axes",
        ),
        (
            "[calibration.lever_arm]\nposition = [2.0, 0.0]\nposition_std = [1e-3, 1e-3]\n"
                .to_owned(),
            "from the pivot",
        ),
    ];
    for (more, wanted) in cases {
        let error = designed(2.0, &more).generate(Some(Preset::ThesisBench));
        let message = error.expect_err(&more).to_string();
        assert!(message.contains(wanted), "{more}: {message}");
    }
}
