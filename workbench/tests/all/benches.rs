//! Benches with common sensors and drives: each controller is emitted, proved, and balances in the simulation.

use std::path::Path;

use bench_files::ModelFile;
use workbench::{ControlDesign, GeneratedController, ProofSettings, SimulationSettings};

use crate::bench::silent;

/// Gyroscope and accelerometer in one housing.
pub(crate) const INERTIAL: &str = "[hardware.gyroscope]\npart = \"MPU-6050\"\naxes = [\"x\", \"y\", \"z\"]\n\
     [hardware.accelerometer]\npart = \"MPU-6050\"\naxes = [\"x\", \"y\", \"z\"]\n";
pub(crate) const CONVERTER: &str = "[hardware.wheel_speed]\nkind = \"converter\"\nslope = 0.4\noffset = -819.2\nlow = 0\n\
     high = 4095\n";
const DRIVER: &str =
    "[hardware.wheel_speed]\nkind = \"driver\"\nscale = 0.1047198\nlargest = 700.0\n";
pub(crate) const WHEEL_ENCODER: &str =
    "[hardware.wheel_speed]\nkind = \"encoder\"\npart = \"AS5600\"\nwindow = 8\n";
/// An encoder on the wheel that counts backwards.
const REVERSED_ENCODER: &str = "[hardware.wheel_speed]\nkind = \"encoder\"\npart = \"AS5600\"\n\
     counts_per_turn = -4096\nwindow = 5\nlargest = 600.0\n";
pub(crate) const CURRENT: &str =
    "[hardware.drive]\npart = \"ESCON 24/2\"\namperes_per_count = 8.39246e-5\n";
pub(crate) const VOLTAGE: &str = "[hardware.drive]\npart = \"SimpleFOC voltage\"\nsupply_voltage = 24.0\n\
     winding_resistance = 2.3\n";

/// An encoder on the pivot, in place of gyroscope and accelerometer.
pub(crate) const PIVOT_ENCODER: &str =
    "[hardware.angle]\nkind = \"encoder\"\npart = \"AS5600\"\nzero = 2048\n";
/// An encoder on the pivot that counts backwards; the count upright is near the end of its range.
const REVERSED_PIVOT: &str = "[hardware.angle]\nkind = \"encoder\"\ncounts_per_turn = -16384\nbits = 14\n\
     zero = 16380\n";

/// Gyroscope and accelerometer, each a part of its own; the accelerometer's words are left-justified.
const TWO_PARTS: &str = "[hardware.gyroscope]\npart = \"FXAS21002\"\naxes = [\"x\", \"y\", \"z\"]\n\
     [hardware.accelerometer]\npart = \"FXOS8700\"\naxes = [\"x\", \"y\", \"z\"]\n";
const ICM_20948: &str = "[hardware.gyroscope]\npart = \"ICM-20948\"\naxes = [\"x\", \"y\", \"z\"]\n\
     [hardware.accelerometer]\npart = \"ICM-20948\"\naxes = [\"x\", \"y\", \"z\"]\n";
const LSM6DS3: &str = "[hardware.gyroscope]\npart = \"LSM6DS3\"\naxes = [\"x\", \"y\", \"z\"]\n\
     [hardware.accelerometer]\npart = \"LSM6DS3\"\naxes = [\"x\", \"y\", \"z\"]\n";

/// The bodies and weights of the thesis with this hardware.
pub(crate) fn designed(hardware: &[&str]) -> ControlDesign {
    let parameters = [
        ("total_inertia", "2.30344e-3", "kg m2"),
        ("wheel_inertia", "1.36125e-4", "kg m2"),
        ("gravity_torque", "0.245158", "N m"),
        ("torque_constant", "0.0335", "N m/A"),
        ("body_viscous_friction", "5.31781e-3", "N m s/rad"),
        ("wheel_viscous_friction", "1.75204e-5", "N m s/rad"),
    ];
    let parameters = parameters.map(|(name, value, unit)| {
        format!("[parameters.{name}]\nvalue = {value}\nunit = \"{unit}\"\n")
    });
    let text = format!(
        "{}{}[effects]\npresent = [\"body-viscous-friction\", \"wheel-viscous-friction\"]\n\
         [design]\nsample_time = 0.001\nstate_weights = [25.0, 0.5, 5e-4]\ncurrent_weight = 1.0\n\
         current_limit = 2.0\n",
        parameters.concat(),
        hardware.concat()
    );
    let file = ModelFile::parse(&text, Path::new("model.toml")).expect("a model");
    ControlDesign::of(file).expect("a design")
}

fn text<'a>(controller: &'a GeneratedController, path: &str) -> &'a str {
    let mut files = controller.files();
    let found = files.find(|(found, _)| *found == path);
    found.map_or("", |(_, text)| text)
}

/// Emits the controller of a bench (also into the folder that `FLYWHEEL_WRITE_BENCHES` names, if it is set), proves
/// it, and lets it balance for half a minute with pushes. No claim may fail, and exactly the claims in `not_run` are
/// not run.
fn holds(name: &str, hardware: &[&str], not_run: &[&str]) -> GeneratedController {
    holds_with(name, hardware, not_run, true)
}

/// Does the same as [`holds`]. The bounds of the closed loop, which take long, are proved only if `closed_loop` is set.
fn holds_with(
    name: &str,
    hardware: &[&str],
    not_run: &[&str],
    closed_loop: bool,
) -> GeneratedController {
    proved(name, &designed(hardware), not_run, closed_loop)
}

/// The same for a design.
fn proved(
    name: &str,
    design: &ControlDesign,
    not_run: &[&str],
    closed_loop: bool,
) -> GeneratedController {
    let controller = design.generate(None).expect("emitted");
    assert_eq!(controller.assumed, Vec::<String>::new(), "{name}");
    if let Ok(folder) = std::env::var("FLYWHEEL_WRITE_BENCHES") {
        let folder = Path::new(&folder).join(name.replace(' ', "-"));
        controller.write(&folder).expect("written");
    }
    let settings = ProofSettings {
        cases: 3_000,
        seed: 7,
        // The audit checks the texts that this test writes.
        audited_texts: false,
        compiled: false,
        smt: false,
        kani: false,
        python: false,
        closed_loop,
        // The filter does not depend on the wheel's sensor and the drive: its claim is proved for one of these benches.
        filter_length: name == "hobby",
        ..ProofSettings::default()
    };
    let proof = controller.prove(&settings, &silent()).expect("a proof");
    let mut left: Vec<&str> = Vec::new();
    for claim in &proof.claims {
        let (word, why) = (claim.outcome.word(), claim.outcome.detail());
        assert_ne!(
            word, "failed",
            "{name}: {} by {}: {why}",
            claim.id, claim.engine
        );
        let is_settled = || {
            let mut rows = proof.claims.iter();
            rows.any(|row| row.id == claim.id && row.outcome.word() != "not run")
        };
        if !why.contains("switched off") && !is_settled() && !left.contains(&claim.id.as_str()) {
            println!("{name}: {} is not run: {why}", claim.id);
            left.push(&claim.id);
        }
        let is_of_loop = ["loop-as-shipped", "stable-for-parameters"].contains(&&*claim.id);
        if claim.id.starts_with("encoder") || is_of_loop {
            println!("{name}: {} {word}: {why}", claim.id);
        }
    }
    assert_eq!(left, not_run, "{name}");
    let seconds: f64 = proof.claims.iter().map(|claim| claim.seconds).sum();
    println!("{name}: proved in {seconds:.1} s");
    let report = design
        .simulate(&SimulationSettings::default(), &silent())
        .expect("a simulation");
    let run = &report.raw_counts;
    println!(
        "{name}: within {:.2}°, {:.0} rad/s, {:.2} A; the angle off by {:.3}° RMS",
        run.largest_angle_rad.to_degrees(),
        run.largest_wheel_speed_rad_s,
        run.largest_current_a,
        run.angle_error_rad.to_degrees()
    );
    assert!(!run.fell, "{name}");
    controller
}

#[test]
fn a_speed_from_the_driver() {
    let controller = holds("driver", &[INERTIAL, DRIVER, CURRENT], &[]);
    let source = text(&controller, "src/controller.rs");
    assert!(source.contains("pub wheel_speed: i16,"));
    // 105 % of 700 rad/s, in tenths of a revolution a minute.
    let constants = text(&controller, "src/constants.rs");
    let end = (1.05_f64 * 700.0 / 0.1047198).floor();
    assert!(constants.contains(&format!("wheel_high: 7_{:03},", end as i32 - 7000)));
}

#[test]
fn a_voltage_drive() {
    let controller = holds("voltage", &[INERTIAL, CONVERTER, VOLTAGE], &[]);
    let source = text(&controller, "src/controller.rs");
    assert!(source.contains("pub fn duty(current: Current, wheel_speed: WheelSpeed) -> Duty {"));
    assert!(!text(&controller, "src/constants.rs").contains("DUTY_LINE"));
}

#[test]
fn an_encoder_on_the_wheel() {
    let controller = holds("encoder", &[INERTIAL, WHEEL_ENCODER, CURRENT], &[]);
    assert!(text(&controller, "src/controller.rs").contains("pub wheel_count: u16,"));
    holds(
        "reversed encoder",
        &[INERTIAL, REVERSED_ENCODER, CURRENT],
        &[],
    );
}

/// An MPU-6050, an AS5600 on the wheel and a driver of SimpleFOC in voltage mode.
#[test]
fn everything_that_a_hobby_bench_has() {
    holds("hobby", &[INERTIAL, WHEEL_ENCODER, VOLTAGE], &[]);
}

/// The claim that rests on one that is switched off: with an encoder on the pivot both are about starts at rest, and are shown
/// together.
const FROM_REST: [&str; 1] = ["region-of-attraction"];

/// The encoder of the pivot with every sensor of the wheel and both drives.
const ON_THE_PIVOT: [(&str, [&str; 3]); 6] = [
    ("pivot converter", [PIVOT_ENCODER, CONVERTER, CURRENT]),
    (
        "pivot converter voltage",
        [PIVOT_ENCODER, CONVERTER, VOLTAGE],
    ),
    ("pivot driver", [REVERSED_PIVOT, DRIVER, CURRENT]),
    ("pivot driver voltage", [PIVOT_ENCODER, DRIVER, VOLTAGE]),
    ("pivot encoder", [PIVOT_ENCODER, REVERSED_ENCODER, CURRENT]),
    (
        "pivot encoder voltage",
        [REVERSED_PIVOT, WHEEL_ENCODER, VOLTAGE],
    ),
];

/// Each controller is emitted, proved except for the bounds of its loop, and balances.
#[test]
fn an_encoder_on_the_pivot() {
    for (name, hardware) in ON_THE_PIVOT {
        let controller = holds_with(name, &hardware, &FROM_REST, false);
        let source = text(&controller, "src/controller.rs");
        assert!(source.contains("pub body_count: u16,"), "{name}");
        assert!(!source.contains("gyro"), "{name}");
    }
}

/// Proves the bounds of the loop from counts to duty for each of these benches.
#[test]
#[ignore = "run apart: half a minute and more"]
fn the_loop_with_an_encoder_on_the_pivot_is_bounded() {
    for (name, hardware) in ON_THE_PIVOT {
        holds(name, &hardware, &[]);
    }
}

/// A loop that is stable with a rate without delay, but unstable with a rate that is half a window late, is not
/// emitted. Neither is an observer of the angle's bias, which needs inertial sensors.
#[test]
fn what_an_encoder_on_the_pivot_cannot_do_is_refused() {
    let hardware = [PIVOT_ENCODER, CONVERTER, CURRENT];
    let design = designed(&hardware);
    let mut wishes = *design.wishes();
    wishes.bias_time_constant_s = Some(1.0);
    let with_observer = design.with_wishes(wishes).expect("a design");
    let refused = with_observer.generate(None).expect_err("no observer");
    assert!(
        refused.to_string().contains("bias_time_constant"),
        "{refused}"
    );
}

/// A bench with an observer of the angle's bias of 1 s.
fn observed(hardware: &[&str], sample_time_s: f64) -> ControlDesign {
    let design = designed(hardware);
    let mut wishes = *design.wishes();
    wishes.bias_time_constant_s = Some(1.0);
    wishes.sample_time_s = sample_time_s;
    design.with_wishes(wishes).expect("a design")
}

/// An observer takes no claim from a module: everything that a hobby bench has.
#[test]
fn an_observer_takes_no_claim_away() {
    let design = observed(&[INERTIAL, WHEEL_ENCODER, VOLTAGE], 1e-3);
    proved("hobby observer", &design, &[], true);
}

/// The same with other sensors, drives and sample times.
#[test]
#[ignore = "run apart: minutes"]
fn an_observer_takes_no_claim_from_any_bench() {
    let benches: [(&str, [&str; 3], f64); 8] = [
        ("observer", [INERTIAL, CONVERTER, CURRENT], 1e-3),
        ("observer 2 ms", [INERTIAL, CONVERTER, CURRENT], 2e-3),
        ("observer 5 ms", [INERTIAL, CONVERTER, CURRENT], 5e-3),
        ("observer encoder", [INERTIAL, WHEEL_ENCODER, CURRENT], 1e-3),
        ("observer voltage", [INERTIAL, CONVERTER, VOLTAGE], 1e-3),
        ("observer two parts", [TWO_PARTS, DRIVER, CURRENT], 1e-3),
        ("observer ICM-20948", [ICM_20948, CONVERTER, CURRENT], 1e-3),
        ("observer LSM6DS3", [LSM6DS3, DRIVER, VOLTAGE], 1e-3),
    ];
    for (name, hardware, sample_time_s) in benches {
        proved(name, &observed(&hardware, sample_time_s), &[], true);
    }
}
