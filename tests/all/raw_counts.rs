//! From model.toml through the emitted source to the closed loop of raw counts: what the file says
//! of sensors and observer is what the module does.

use crate::emitted;

use std::fs;
use std::path::Path;
use std::process::Command;

use attitude::{AttitudeSpec, SensorLine};
use checker::prove::ProofVerdict;
use nalgebra::Rotation3;
use plant::{Kind, Plant};
use simulate::{InterpretedController, LoopTrace, RawLoop, RawSensors};

/// What `flywheel generate` writes for `model`: the controller, and `src/constants.rs`.
fn controller_of(model: &str) -> (InterpretedController, String) {
    let (_folder, out) = emitted::generated(model);
    // Whatever the file says of the sensors, what is emitted stands up to its certificate.
    let rows = emitted::quick_proof(&out, None);
    let verdict = checker::prove::verdict(&rows);
    assert!(!matches!(verdict, ProofVerdict::Fails(_)), "{verdict:?}");
    let module = checker::Module::read(&out).expect("emitted source");
    let constants = fs::read_to_string(out.join("src/constants.rs")).expect("constants");
    (
        InterpretedController::new(&module).expect("a controller"),
        constants,
    )
}

/// The nonlinear bench of the model, without dry friction, whose stick hides small biases.
fn plant() -> Plant<f64> {
    let values = [
        2.30344e-3, 1.36125e-4, 0.245158, 0.0335, 5.31781e-3, 1.75204e-5,
    ];
    Plant::new(&plant::Model::base(), &values, Kind::Balance)
}

/// The thesis' sensors without the bias that a calibration leaves.
fn sensors() -> RawSensors {
    let mut sensors = RawSensors::of_the_thesis().expect("sensors");
    for sensor in [&mut sensors.gyro, &mut sensors.accel] {
        sensor.bias_counts = nalgebra::Vector3::zeros();
    }
    sensors
}

fn run(sensors: RawSensors, start_rad: f64, controller: &mut InterpretedController) -> LoopTrace {
    let plant = plant();
    RawLoop::new(&plant, sensors, 5)
        .run(start_rad, 20.0, controller, true)
        .expect("a run")
}

/// Mean over the last 5 s.
fn settled(values: &[f64]) -> f64 {
    let last = &values[values.len() - 5_000..];
    last.iter().sum::<f64>() / 5_000.0
}

#[test]
fn the_committed_crate_is_what_generate_writes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(env!("CARGO_BIN_EXE_flywheel"))
        .arg("generate")
        .arg(root.join("models/thesis-4.4.toml"))
        .arg("--out")
        .arg(root.join("generated"))
        .arg("--check")
        .output()
        .expect("the program starts");
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{text}");
}

/// Thesis 5.1: one degree of angle bias costs −19.2 rad/s of wheel speed; `bias_time_constant`
/// takes it away.
#[test]
fn the_observer_of_the_model_stops_the_wheel() {
    let mut biased = sensors();
    biased.mounting_angle_rad = 1_f64.to_radians();
    let (mut plain, constants) = controller_of(&emitted::model_with(""));
    assert!(constants.contains("No observer of the angle's bias"));
    let trace = run(biased, 0.0, &mut plain);
    assert_eq!(trace.fell_at_s, None);
    let without = settled(&trace.wheel_speed_rad_s);

    let (mut observing, constants) =
        controller_of(&emitted::model_with("bias_time_constant = 1.0\n"));
    assert!(constants.contains("Observer of the angle's bias with decay 0.999"));
    let trace = run(biased, 0.0, &mut observing);
    assert_eq!(trace.fell_at_s, None);
    let with = settled(&trace.wheel_speed_rad_s);
    println!("wheel at rest: {without:.2} rad/s without the observer, {with:.3} rad/s with it");
    assert!((without + 19.2).abs() < 0.5, "{without}");
    assert!(with.abs() < 0.5, "{with}");
}

/// A sensor that is biased, out of scale and tilted on the body: with its calibration in the model
/// the emitted module balances as the ideal one does; without, it does not.
#[test]
fn the_calibration_of_the_model_reaches_the_emitted_module() {
    let ideal = AttitudeSpec::thesis();
    let axis = Rotation3::from_euler_angles(0.06, -0.04, 0.0) * nalgebra::Vector3::z();
    let angle_rad = 0.4;
    let line = |line: &SensorLine, bias: [f64; 3], scale: f64| SensorLine {
        bias_counts: bias.into(),
        matrix: line.matrix * scale,
    };
    let accel = line(&ideal.accel, [210.0, -150.0, 90.0], 1.04);
    let gyro = line(&ideal.gyro, [-35.0, 20.0, 48.0], 0.97);
    let table = |name: &str, line: &SensorLine| {
        let b = line.bias_counts;
        let m = line.matrix;
        let rows: Vec<String> = (0..3)
            .map(|row| format!("[{:e}, {:e}, {:e}]", m[(row, 0)], m[(row, 1)], m[(row, 2)]))
            .collect();
        let zeros = "[[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]";
        format!(
            "[calibration.{name}]\nbias_counts = [{:?}, {:?}, {:?}]\nbias_std = [0.1, 0.1, 0.1]\n\
             matrix = [{}]\nmatrix_std = {zeros}\n",
            b[0],
            b[1],
            b[2],
            rows.join(", ")
        )
    };
    let calibration = format!(
        "{}{}{}[calibration.mounting]\naxis = [{:?}, {:?}, {:?}]\naxis_std_rad = 1e-4\n\
         angle = {angle_rad:?}\nangle_std = 1e-4\n",
        table("accelerometer", &accel),
        table("gyroscope", &gyro),
        table("magnetometer", &line(&ideal.mag, [-210.0, 77.0, 13.0], 1.0)),
        axis[0],
        axis[1],
        axis[2]
    );
    let alignment = calibrate::alignment(&axis);
    let aligned = |line: &SensorLine| SensorLine {
        matrix: alignment.matrix() * line.matrix,
        ..*line
    };
    let truth = AttitudeSpec {
        accel: aligned(&accel),
        gyro: aligned(&gyro),
        mounting_angle_rad: angle_rad,
        ..ideal
    };
    let crooked = RawSensors::calibrated_by(&truth).expect("sensors");

    let (mut plain, plain_constants) = controller_of(&emitted::model_with(""));
    let (mut calibrated, constants) = controller_of(&emitted::model_with(&calibration));
    let word = |text: &str, from: &str| {
        let (_, rest) = text.split_once(from).expect("the constant");
        rest.lines().next().expect("a line").to_owned()
    };
    for constant in [
        "accel: SensorLine {\n        bias:",
        "MOUNTING_ANGLE: i32 =",
    ] {
        assert_ne!(word(&constants, constant), word(&plain_constants, constant));
    }
    // 210 counts in Q15; 0.4 rad in Q28.
    assert!(word(&constants, "accel: SensorLine {\n        bias:").contains("6_881_280"));
    assert!(word(&constants, "MOUNTING_ANGLE: i32 =").contains("107_374_182"));

    let start_rad = 5_f64.to_radians();
    let trace = run(crooked, start_rad, &mut calibrated);
    assert_eq!(trace.fell_at_s, None);
    // A milli-g, 0.06°, is all that the calibration leaves of the angle.
    let lean = settled(&trace.measured_angle_rad) - settled(&trace.angle_rad);
    assert!(lean.to_degrees().abs() < 0.15, "{}°", lean.to_degrees());
    assert!(run(crooked, start_rad, &mut plain).fell_at_s.is_some());
    // And the calibrated module on the ideal sensor falls: the constants matter both ways.
    assert!(
        run(sensors(), start_rad, &mut calibrated)
            .fell_at_s
            .is_some()
    );
}

/// The sensor of the thesis sits 50 mm from the pivot. While the body falls and is caught, its own
/// acceleration leans the apparent vertical; with the lever arm in the model the emitted filter
/// takes that out.
#[test]
fn the_lever_arm_of_the_model_reaches_the_emitted_module() {
    let (mut plain, _) = controller_of(&emitted::model_with(""));
    let arm = "[calibration.lever_arm]\nposition = [0.05, 0.0]\nposition_std = [1e-4, 1e-4]\n";
    let (mut corrected, constants) = controller_of(&emitted::model_with(arm));
    assert!(constants.contains("lever arm (0.05, 0) m"), "{constants}");
    // Without dry friction and bias: what is left is the lever arm, and noise.
    let start_rad = 12_f64.to_radians();
    let worst = |trace: &LoopTrace| {
        let errors = trace.angle_rad.iter().zip(&trace.measured_angle_rad);
        errors.fold(0.0_f64, |worst, (truth, told)| {
            worst.max((truth - told).abs())
        })
    };
    let with = run(sensors(), start_rad, &mut corrected);
    let without = run(sensors(), start_rad, &mut plain);
    assert_eq!(with.fell_at_s, None);
    let (with, without) = (worst(&with), worst(&without));
    println!(
        "angle off by at most {:.3}° without the lever arm, {:.3}° with it",
        without.to_degrees(),
        with.to_degrees()
    );
    assert!(with < 0.5 * without, "{with} {without}");
    assert!(with < 5e-3, "{with}");

    // From 15°, near the 15.86° at which the current can just hold the body.
    let trace = run(sensors(), 15_f64.to_radians(), &mut corrected);
    assert_eq!(trace.fell_at_s, None);
    let largest = trace.current_a.iter().fold(0.0_f64, |l, i| l.max(i.abs()));
    assert!(largest <= 2.0 + 1e-3, "{largest} A");
    println!("recovers from 15° with at most {largest:.3} A");
}

#[test]
fn a_time_constant_that_is_none_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("model.toml");
    fs::write(&file, emitted::model_with("bias_time_constant = 0.0\n")).expect("written");
    let output = Command::new(env!("CARGO_BIN_EXE_flywheel"))
        .arg("generate")
        .arg(&file)
        .arg("--out")
        .arg(folder.path().join("out"))
        .output()
        .expect("the program starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("bias_time_constant"), "{message}");
    assert!(message.contains("model.toml"), "{message}");
}
