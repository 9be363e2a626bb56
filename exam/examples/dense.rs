//! A bench of dense logs, as real loggers write them, to time a diagnosis: ten logs of equally many samples from the
//! exam's simulator, with or without the cogging of a motor.
//!
//!     cargo run --release -p exam --example dense -- DIR [cogging|plain] [SAMPLES] [SAMPLE_TIME_S] [SEED] [A,N,PHASE]
//!
//! A, N and PHASE are the torque in N m, the order and the phase in rad of the teeth.
//!
//! The folder gets a bench.toml, a CSV for every log and a truth.json, so that `flywheel exam --folder` marks it.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

use exam::{ChannelNoise, DriveProgram, ExperimentPlan, Hidden, Truth, record};
use plant::{EffectId, Kind};

/// The thesis' pendulum, with gravity torque and torque constant known.
const BASE: [f64; 4] = [2.30344e-3, 1.36125e-4, 0.245158, 0.0335];
/// Its controller, and the largest current.
const GAINS: [f64; 3] = [-24.267242, -2.129739, -0.02258758];
const LIMIT_A: f64 = 2.0;
/// Torque in N m, order and phase in rad of the teeth: about as strong as the dry friction of a small motor.
const COGGING: [f64; 3] = [2e-3, 12.0, 0.7];

fn plans(samples: usize, sample_s: f64) -> Vec<ExperimentPlan> {
    let plan = |name: &str, kind: Kind, driving: DriveProgram| ExperimentPlan {
        name: name.to_owned(),
        kind,
        angle_rad: 0.0,
        wheel_speed_rad_s: 0.0,
        driving,
        duration_s: (samples - 1) as f64 * sample_s + 0.5 * sample_s,
        sample_s,
    };
    let mut plans = vec![];
    for degrees in [20.0f64, 52.0] {
        let name = format!("free swing {degrees} deg");
        plans.push(ExperimentPlan {
            angle_rad: degrees.to_radians(),
            ..plan(&name, Kind::FreeSwing, DriveProgram::None)
        });
    }
    for current_a in [0.08, 0.2, 0.4, 0.6, -0.6] {
        let name = format!("spin-up {current_a} A");
        plans.push(plan(&name, Kind::SpinUp, DriveProgram::Step(current_a)));
    }
    plans.push(ExperimentPlan {
        wheel_speed_rad_s: 60.0,
        ..plan("coast-down", Kind::SpinUp, DriveProgram::None)
    });
    plans.push(plan("driven", Kind::Driven, DriveProgram::Square(0.5)));
    let balanced = DriveProgram::Balanced {
        gains: GAINS,
        limit_a: LIMIT_A,
        pushes: vec![],
    };
    plans.push(ExperimentPlan {
        angle_rad: PI + 0.03,
        ..plan("balance", Kind::Balance, balanced)
    });
    plans
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("which folder?")?;
    let folder = Path::new(&folder);
    let hidden = arguments.next().unwrap_or_else(|| "cogging".to_owned());
    let samples: usize = arguments.next().map_or(Ok(100_000), |text| text.parse())?;
    let sample_s: f64 = arguments.next().map_or(Ok(0.001), |text| text.parse())?;
    let seed: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let cogging: Vec<f64> = match arguments.next() {
        Some(text) => text.split(',').map(str::parse).collect::<Result<_, _>>()?,
        None => COGGING.to_vec(),
    };
    let has_cogging = hidden == "cogging";
    let truth = Truth {
        base: BASE,
        body_viscous: 2.12e-5,
        wheel_viscous: 1.75204e-5,
        hidden: has_cogging
            .then(|| Hidden::Library(EffectId::WheelCogging, cogging.clone()))
            .into_iter()
            .collect(),
    };
    let noise = ChannelNoise {
        std: [1.2e-3, 4e-3, 0.6],
    };
    std::fs::create_dir_all(folder)?;
    let mut toml = format!(
        "[bench]\nname = \"dense, {hidden}\"\n\n[known]\ngravity_torque = {}\ntorque_constant = {}\n\n\
         [controller]\ngains = {GAINS:?}\ncurrent_limit = {LIMIT_A:?}\nsample_time = {sample_s}\n",
        BASE[2], BASE[3]
    );
    for (index, plan) in plans(samples, sample_s).iter().enumerate() {
        let log = record(&truth, plan, &noise, seed.wrapping_mul(64) + index as u64);
        let mut csv = String::from("time_s,angle_rad,rate_rad_s,wheel_speed_rad_s,current_A\n");
        for k in 0..log.time_s.len() {
            let [angle, rate, speed] = [0, 1, 2].map(|at| log.measured[at][k]);
            let (time_s, current_a) = (log.time_s[k], log.current_a[k]);
            writeln!(
                csv,
                "{time_s:.6},{angle:.6},{rate:.6},{speed:.5},{current_a:.6}"
            )?;
        }
        let file = format!("{index}.csv");
        std::fs::write(folder.join(&file), csv)?;
        let kind = plan.kind.name();
        write!(
            toml,
            "\n[[experiment]]\nname = \"{}\"\nkind = \"{kind}\"\nfile = \"{file}\"\n",
            plan.name
        )?;
        println!("{}: {} samples", plan.name, log.time_s.len());
    }
    std::fs::write(folder.join("bench.toml"), toml)?;
    let effects = if has_cogging {
        vec!["wheel-cogging"]
    } else {
        vec![]
    };
    let names = ["cogging_torque", "cogging_order", "cogging_phase"];
    let parameters: serde_json::Map<String, serde_json::Value> = names
        .iter()
        .zip(cogging)
        .filter(|_| has_cogging)
        .map(|(name, value)| ((*name).to_owned(), value.into()))
        .collect();
    let truth = serde_json::json!({ "effects": effects, "parameters": parameters });
    std::fs::write(folder.join("truth.json"), truth.to_string())?;
    Ok(())
}
