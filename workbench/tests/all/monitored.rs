//! A controller with a monitor: it is emitted, audited and proved, and damage to it is detected.

use std::path::Path;

use checker::certificate::reader::Certificate;
use checker::prove::{ClaimResult, Emitted, settle};
use checker::{ClaimOutcome, Machine, ProofSettings};
use workbench::{ControlDesign, ControllerOptions};

use crate::benches::{CONVERTER, INERTIAL, VOLTAGE, designed};

fn emitted() -> Emitted {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/thesis-4.4.toml");
    of_design(&ControlDesign::read(&path).expect("the model of the thesis"))
}

fn of_design(design: &ControlDesign) -> Emitted {
    let controller = design
        .generate_with(&ControllerOptions {
            has_monitor: true,
            ..ControllerOptions::default()
        })
        .expect("emitted");
    let folder = tempfile::tempdir().expect("a folder");
    controller.write(folder.path()).expect("written");
    Emitted::read(folder.path()).expect("a crate")
}

fn settled(emitted: &Emitted, compiled: bool) -> Vec<ClaimResult> {
    let certificate = Certificate::parse(&emitted.certificate).expect("a certificate");
    let settings = ProofSettings {
        cases: 3_000,
        compiled,
        smt: false,
        kani: false,
        python: false,
        closed_loop: false,
        filter_length: false,
        ..ProofSettings::default()
    };
    settle(emitted, &certificate, &settings)
}

/// The outcomes of a claim, engine by engine.
fn of<'a>(rows: &'a [ClaimResult], id: &str) -> Vec<&'a ClaimOutcome> {
    let rows = rows.iter().filter(|row| row.id == id);
    rows.map(|row| &row.outcome).collect()
}

#[test]
fn a_monitor_is_proved() {
    let rows = settled(&emitted(), true);
    let failed: Vec<_> = rows
        .iter()
        .filter(|row| matches!(row.outcome, ClaimOutcome::Failed(_)))
        .map(|row| format!("{}: {}", row.id, row.outcome.why()))
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(matches!(
        of(&rows, "texts-audited")[..],
        [ClaimOutcome::Proved(_)]
    ));
    assert!(matches!(
        of(&rows, "compiled-agrees")[..],
        [ClaimOutcome::Tested(..)]
    ));
    assert!(matches!(
        of(&rows, "monitor-total")[..],
        [ClaimOutcome::Proved(_)]
    ));
    assert!(matches!(
        of(&rows, "monitor-silent")[..],
        [ClaimOutcome::Proved(_), ClaimOutcome::Tested(..)]
    ));
}

/// Words of the monitor that are too large or too small, and contradictions between certificate and source, are
/// detected.
#[test]
fn a_damaged_monitor_is_noticed() {
    let whole = emitted();
    let words = "src/monitor_words.rs";
    let (_, text) = whole
        .sources
        .iter()
        .find(|(path, _)| path == words)
        .expect("its words");
    let value = |field: &str| {
        let at = text.rfind(&format!("{field}: ")).expect("a field") + field.len() + 2;
        let end = text[at..].find(',').expect("its end") + at;
        text[at..end].to_owned()
    };
    for field in ["leak", "shift", "wheel_limit", "body_limit"] {
        let old = value(field);
        let number: i64 = old.replace('_', "").parse().expect("a number");
        for new in [number + 3, number - 3] {
            let mut damaged = whole.clone();
            for (path, text) in &mut damaged.sources {
                if path == words {
                    let (from, to) = (format!("{field}: {old},"), format!("{field}: {new},"));
                    assert!(text.contains(&from), "{from}");
                    *text = text.replace(&from, &to);
                }
            }
            let rows = settled(&damaged, false);
            assert!(
                of(&rows, "monitor-silent")
                    .iter()
                    .any(|outcome| matches!(outcome, ClaimOutcome::Failed(_))),
                "{field}: {new}"
            );
        }
    }
    // The certificate has no section monitor.
    let mut silent = whole.clone();
    let mut json: serde_json::Value =
        serde_json::from_str(&silent.certificate).expect("a certificate");
    json.as_object_mut().expect("an object").remove("monitor");
    silent.certificate = json.to_string();
    let rows = settled(&silent, false);
    assert!(matches!(
        of(&rows, "monitor-total")[..],
        [ClaimOutcome::Failed(_)]
    ));
}

/// Steps of the motor behind a voltage drive with this winding and torque constant, of which `torque` of the current's
/// torque acts from half a second on: the step at which the monitor first says no.
fn watched(emitted: &Emitted, winding_ohm: f64, motor: f64, torque: f64) -> Option<usize> {
    let module = emitted.module().expect("understood");
    let certificate = Certificate::parse(&emitted.certificate).expect("a certificate");
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let mut monitor = Machine::new(module.function("Monitor::allows").expect("a monitor"));
    let mut law = Machine::new(module.function("control").expect("a law"));
    let start = Machine::new(module.function("Monitor::new").expect("a monitor"))
        .call(&[])
        .expect("total")
        .to_vec();
    let parameter = |name: &str| {
        let found = certificate.parameters.iter().find(|p| p.name == name);
        number(&found.expect("a parameter").value.text)
    };
    let (wheel, friction) = (
        parameter("wheel_inertia"),
        parameter("wheel_viscous_friction"),
    );
    let carried = parameter("total_inertia") - wheel;
    let voltage = certificate.drive.voltage.as_ref().expect("a voltage drive");
    let (volts, ohm, emf) = (
        number(&voltage.volts_per_count.text),
        number(&voltage.winding_ohm.text),
        number(&voltage.back_emf_v_s.text),
    );
    let noise = &certificate.monitor.as_ref().expect("a monitor").noise_std;
    let noise = noise.each_ref().map(|std| number(&std.text));
    let bits = [0, 1, 2].map(|i| certificate.inputs[i].fraction_bits as i32);
    let current_unit = 2f64.powi(-(certificate.output.fraction_bits as i32));
    let mut words = start;
    let mut x = [0.05, 0.0, 0.0];
    // Kronecker's sequence: noise of up to two standard deviations, the same in every run.
    let shake = |step: usize, i: usize| {
        4.0 * ((step as f64 * [0.618034, 0.414214, 0.732051][i]).fract() - 0.5)
    };
    for step in 0..3_000 {
        let measured = [0, 1, 2].map(|i| x[i] + noise[i] * shake(step, i));
        let inputs = [0, 1, 2].map(|i| (measured[i] * 2f64.powi(bits[i])).round() as i128);
        let current = law.call(&inputs).expect("total")[0] as f64 * current_unit;
        let wished = (ohm * current + emf * measured[2]) / volts;
        let duty = f64::from(certificate.drive.duty_zero) + wished.round();
        let arguments = [&words[..], &[1], &inputs, &[duty as i128]].concat();
        let found = monitor.call(&arguments).expect("total").to_vec();
        if found[0] == 0 {
            return Some(step);
        }
        words = found[1..].to_vec();
        let held = volts * (duty - f64::from(certificate.drive.duty_zero));
        let share = if step < 500 { 1.0 } else { torque };
        for _ in 0..10 {
            let driven = share * motor * (held - motor * x[2]) / winding_ohm - friction * x[2];
            let lean = parameter("gravity_torque") * f64::sin(x[0]);
            let body = (lean - parameter("body_viscous_friction") * x[1] - driven) / carried;
            let speeds = [x[1], body, driven / wheel - body];
            x = [0, 1, 2].map(|i| x[i] + 1e-4 * speeds[i]);
        }
    }
    assert!(x[0].abs() < 0.05, "it balances");
    None
}

/// Behind a voltage drive the monitor takes into account that the current depends on the wheel's speed. It is silent
/// for motors within their uncertainty, also with a warm winding, and notices a motor without torque or with reversed
/// torque.
#[test]
fn a_monitor_behind_a_voltage_drive() {
    let emitted = of_design(&designed(&[INERTIAL, CONVERTER, VOLTAGE]));
    // The row texts-audited depends on the list of audited texts, not on this module, and is left out.
    let rows = settled(&emitted, false);
    for row in rows.iter().filter(|row| row.id != "texts-audited") {
        let why = row.outcome.why();
        assert!(
            !matches!(row.outcome, ClaimOutcome::Failed(_)),
            "{}: {why}",
            row.id
        );
    }
    for (ohm, motor) in [
        (2.3, 0.0335),
        (2.5, 0.0335),
        (2.1, 0.0335),
        (2.3, 0.036),
        (2.45, 0.031),
    ] {
        assert_eq!(
            watched(&emitted, ohm, motor, 1.0),
            None,
            "{ohm} Ohm, {motor} N m/A"
        );
    }
    for torque in [0.0, -1.0] {
        let noticed = watched(&emitted, 2.3, 0.0335, torque);
        println!("a motor with {torque} of its torque: noticed at {noticed:?}");
        assert!(
            noticed.is_some_and(|step| (500..1_200).contains(&step)),
            "{noticed:?}"
        );
    }
}
