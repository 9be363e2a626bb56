//! The loop with a voltage drive, and with an encoder on the wheel.

use std::path::Path;
use std::sync::OnceLock;

use checker::Module;
use checker::certificate::reader::Certificate;
use checker::claims::control_law::EmittedLaw;
use checker::claims::loop_as_shipped::{self, NoBounds, ShippedLoop};
use checker::claims::sampling::check_sampling;
use checker::prove::Emitted;
use serde_json::{Value, json};

use crate::shipped::{Pendulum, Sensors, both_agree, real};

pub const OHM: f64 = 2.3;
const TORQUE: f64 = 0.0335;
pub const WINDOW: u32 = 8;
const PERIOD_S: f64 = 0.001;

fn text(value: f64) -> String {
    format!("{value:e}")
}

/// The committed module with the motor behind this supply, and with an encoder of 4096 counts on its wheel. The
/// sampled model is integrated here, in short steps.
pub fn certificate(supply_v: f64) -> Value {
    let folder = Path::new("../generated");
    let mut found: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("certificate.json")).unwrap())
            .unwrap();
    let number = |value: &Value| -> f64 { value.as_str().unwrap().parse().unwrap() };
    let a = [0, 1, 2].map(|i| [0, 1, 2].map(|j| number(&found["plant"]["A"][i][j])));
    let b = [0, 1, 2].map(|i| number(&found["plant"]["B"][i]));
    let derivative = |x: [f64; 3], held: f64| -> [f64; 3] {
        let current = held - TORQUE / OHM * x[2];
        [0, 1, 2].map(|i| (0..3).map(|j| a[i][j] * x[j]).sum::<f64>() + b[i] * current)
    };
    let moved = |start: [f64; 3], held: f64| {
        let (mut x, h) = (start, PERIOD_S / 64.0);
        for _ in 0..64 {
            let add = |slope: [f64; 3], share: f64| [0, 1, 2].map(|i| x[i] + share * h * slope[i]);
            let k1 = derivative(x, held);
            let k2 = derivative(add(k1, 0.5), held);
            let k3 = derivative(add(k2, 0.5), held);
            let k4 = derivative(add(k3, 1.0), held);
            x = [0, 1, 2].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        x
    };
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|x| moved(x, 0.0));
    let sampled = [0, 1, 2].map(|i| [0, 1, 2].map(|j| text(columns[j][i])));
    let input = moved([0.0; 3], 1.0).map(text);
    let drive = &mut found["drive"];
    let counts = f64::from(26_214);
    drive["amperes_per_count"] = text(supply_v / counts / OHM).into();
    drive["current_range_A"] = text(supply_v / OHM).into();
    drive["voltage"] = json!({
        "volts_per_count": text(supply_v / counts),
        "supply_V": text(supply_v),
        "winding_Ohm": text(OHM),
        "back_emf_V_s": "0.0335",
        "Ad": sampled,
        "Bd": input,
    });
    let per_count = std::f64::consts::TAU / 4096.0 / (f64::from(WINDOW) * PERIOD_S);
    found["hardware"]["wheel_speed"] = json!({
        "kind": "encoder",
        "rad_s_per_count": text(per_count),
        "rad_s_at_zero": "0",
        "low_counts": -16_376,
        "high_counts": 16_376,
        "encoder": { "counts_per_turn": "4096", "bits": 12, "window": WINDOW },
    });
    found
}

fn law() -> EmittedLaw {
    EmittedLaw::read(&Module::read(Path::new("../generated")).unwrap()).unwrap()
}

fn parsed(found: &Value) -> Certificate {
    Certificate::parse(&found.to_string()).unwrap()
}

fn shown() -> &'static ShippedLoop {
    static SHOWN: OnceLock<ShippedLoop> = OnceLock::new();
    SHOWN.get_or_init(|| loop_as_shipped::check(&parsed(&certificate(24.0)), &law()).unwrap())
}

/// The sampled model of a held voltage is that of a motor whose current follows its wheel, integrated.
#[test]
fn the_held_voltage_is_sampled() {
    let mut found = certificate(24.0);
    check_sampling(&parsed(&found)).unwrap();
    // That of a current that is held.
    found["drive"]["voltage"]["Ad"] = found["plant"]["Ad"].clone();
    let why = check_sampling(&parsed(&found)).unwrap_err();
    assert!(why.contains("drive.voltage.Ad["), "{why}");
}

/// No run leaves the bounds, from a motor whose current follows its wheel and a speed that is half a window old.
#[test]
fn no_run_with_voltage_and_encoder_leaves_the_bounds() {
    let (shown, law) = (shown(), law());
    let bench = Pendulum::of(&parsed(&certificate(24.0)), &law, shown);
    let start = real(&shown.start);
    let mut largest = [0.0_f64; 4];
    println!("seed 31");
    for delay in [0.0, 0.5, 1.0] {
        for sensors in [Sensors::Round, Sensors::Draw, Sensors::Push] {
            for share in [-1.0, 0.5, 1.0] {
                let seen = bench.run(share * start, delay, sensors, 1_500, 31);
                for (largest, seen) in largest.iter_mut().zip(seen.whole) {
                    *largest = largest.max(seen);
                }
            }
        }
    }
    let bounds = shown.bounds.states.iter().chain([&shown.bounds.command]);
    for (index, bound) in bounds.enumerate() {
        println!("{index}: {:.3e} of {:.3e}", largest[index], real(bound));
        assert!(largest[index] <= real(bound), "quantity {index}");
        // The bound is of the size of the motion.
        assert!(largest[index] > 0.5 * real(bound), "quantity {index}");
    }
}

/// The second checker finds the same with a voltage drive and an encoder.
#[test]
fn the_second_checker_agrees_on_voltage_and_encoder() {
    let mut emitted = Emitted::read(Path::new("../generated")).unwrap();
    emitted.certificate = certificate(24.0).to_string();
    both_agree(&emitted, shown());
}

/// A supply that hardly holds the motor proves less, one below what the first command asks for nothing more than that,
/// and one that cannot hold the body's own noise nothing at all.
#[test]
fn the_end_of_the_supply_limits_the_start() {
    let start = |supply: f64| {
        loop_as_shipped::check(&parsed(&certificate(supply)), &law())
            .map(|found| real(&found.start))
    };
    let low = start(2.0).unwrap();
    assert!(low < 0.8 * real(&shown().start), "{low}");
    // At rest the first command is N₁ times the angle, and V/R is all that the supply gives.
    let holds = 2.0 / OHM / real(&law().gains[0]).abs();
    assert!(low < holds, "{low} {holds}");
    let none = start(0.02);
    assert!(
        matches!(&none, Err(NoBounds::NotShown(why)) if why.contains("supply")),
        "{none:?}"
    );
}

/// A back-EMF that is not the motor's own is refused.
#[test]
fn a_foreign_back_emf_is_refused() {
    let mut found = certificate(24.0);
    found["drive"]["voltage"]["back_emf_V_s"] = "0.02".into();
    let outcome = loop_as_shipped::check(&parsed(&found), &law());
    assert!(
        matches!(&outcome, Err(NoBounds::Unphysical(why)) if why.contains("back_emf")),
        "{outcome:?}"
    );
}
