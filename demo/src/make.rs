//! What made the files in `bench/`.

use std::error::Error;
use std::f64::consts::PI;

use nalgebra::RowVector3;
use plant::{Current, EffectId, Hold, Input, Kind, Model, Plant, Smoothing, State};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use simulate::{Actuator, ClosedLoop, ExactLaw, Motion, Push, Sensor, Sensors};

use crate::File;

/// The dry friction of the pivot, N m: what the base model lacks.
pub const COULOMB_TORQUE_NM: f64 = 4.0e-4;

const GRAVITY: f64 = 9.81;
const TORQUE_CONSTANT: f64 = 0.033;
const BODY_MASS: f64 = 0.18;
const WHEEL_MASS: f64 = 0.12;
const PIVOT_TO_WHEEL: f64 = 0.09;
const PIVOT_TO_COM: f64 = 0.075;
const TOTAL_INERTIA: f64 = 2.25e-3;
const WHEEL_INERTIA: f64 = 1.15e-4;
const BODY_VISCOUS: f64 = 3.0e-5;
const WHEEL_VISCOUS: f64 = 1.6e-5;

const CURRENT_LIMIT_A: f64 = 2.0;
const SAMPLE_TIME_S: f64 = 0.004;

/// Noise of the sensors, 1 σ: rad, rad/s, rad/s.
const ANGLE_NOISE: f64 = 1.0e-3;
const RATE_NOISE: f64 = 5.0e-3;
const WHEEL_NOISE: f64 = 0.5;

/// Inner step of the simulation in s, and the speed below which dry friction is smooth: both finer
/// than those of the fit, so that the demonstration does not fit its own integration rule.
const INNER_STEP_S: f64 = 5e-4;
const SMOOTHING: Smoothing = Smoothing {
    body_rad_s: 2e-3,
    wheel_rad_s: 1.0,
};

const SEED: u64 = 20_260_101;

fn values(model: &Model) -> Vec<f64> {
    model
        .parameters()
        .iter()
        .map(|info| match info.name {
            "total_inertia" => TOTAL_INERTIA,
            "wheel_inertia" => WHEEL_INERTIA,
            "gravity_torque" => GRAVITY * (PIVOT_TO_WHEEL * WHEEL_MASS + PIVOT_TO_COM * BODY_MASS),
            "torque_constant" => TORQUE_CONSTANT,
            "body_viscous_friction" => BODY_VISCOUS,
            "wheel_viscous_friction" => WHEEL_VISCOUS,
            "body_coulomb_torque" => COULOMB_TORQUE_NM,
            other => unreachable!("the bench has no {other}"),
        })
        .collect()
}

fn plant(kind: Kind) -> Plant<f64> {
    let model = Model::base().with(EffectId::BodyCoulombFriction);
    let values = values(&model);
    Plant::smoothed(&model, &values, kind, SMOOTHING)
}

/// Gains of the controller that balanced the body: designed without the dry friction, and printed
/// with four decimals as a person would.
fn gains() -> Result<[f64; 3], Box<dyn Error>> {
    let model = Model::base();
    let linear = plant::linearise(&model, &values(&model), PI, None)?;
    let settings = design::Settings {
        sample_time_s: SAMPLE_TIME_S,
        weights: design::Weights {
            state: [25.0, 0.5, 5e-4].into(),
            current: 1.0,
        },
        current_limit_a: CURRENT_LIMIT_A,
        friction_extremes: None,
    };
    let gains = design::Design::new(&linear, &settings)?.gains;
    Ok([0, 1, 2].map(|index| (1e4 * gains[index]).round() / 1e4))
}

/// States every `step_s` seconds under a constant current.
fn states(
    kind: Kind,
    start: State<f64>,
    current_a: f64,
    step_s: f64,
    count: usize,
) -> Vec<State<f64>> {
    let inner = (step_s / INNER_STEP_S).round() as usize;
    let time_s: Vec<f64> = (0..count * inner)
        .map(|k| k as f64 * INNER_STEP_S)
        .collect();
    let input = Input::new(&time_s, &vec![current_a; time_s.len()], Hold::Zero);
    let mut states = Vec::new();
    plant(kind).run(
        start,
        &time_s,
        0..time_s.len(),
        Current::Recorded(&input),
        None,
        |index, _, state| {
            if index % inner == 0 {
                states.push(*state);
            }
        },
    );
    states
}

struct Noise(ChaCha8Rng);

impl Noise {
    fn of(&mut self, std: f64) -> f64 {
        let normal: f64 = StandardNormal.sample(&mut self.0);
        std * normal
    }
}

fn spin_up(
    name: &'static str,
    start_rad_s: f64,
    current_a: f64,
    duration_s: f64,
    noise: &mut Noise,
) -> File {
    let step_s = 0.01;
    let start = State {
        wheel_speed_rad_s: start_rad_s,
        ..State::rest()
    };
    let count = (duration_s / step_s).round() as usize + 1;
    let mut text = "time_s,wheel_speed_rad_s,current_A\n".to_owned();
    for (index, state) in states(Kind::SpinUp, start, current_a, step_s, count)
        .iter()
        .enumerate()
    {
        text.push_str(&format!(
            "{:.2},{:.2},{current_a}\n",
            index as f64 * step_s,
            state.wheel_speed_rad_s + noise.of(WHEEL_NOISE),
        ));
    }
    File { name, text }
}

fn free_swing(name: &'static str, degrees: f64, noise: &mut Noise) -> File {
    let step_s = 0.005;
    let start = State {
        angle_rad: degrees.to_radians(),
        ..State::rest()
    };
    let mut text = "time_s,angle_rad,rate_rad_s\n".to_owned();
    for (index, state) in states(Kind::FreeSwing, start, 0.0, step_s, 4001)
        .iter()
        .enumerate()
    {
        text.push_str(&format!(
            "{:.3},{:.4},{:.3}\n",
            index as f64 * step_s,
            state.angle_rad + noise.of(ANGLE_NOISE),
            state.rate_rad_s + noise.of(RATE_NOISE),
        ));
    }
    File { name, text }
}

fn balance(name: &'static str, gains: [f64; 3]) -> Result<File, Box<dyn Error>> {
    let sensor = |noise_std, range| Sensor {
        noise_std,
        step: 0.0,
        range,
    };
    let plant = plant(Kind::Balance);
    let bench = ClosedLoop {
        motion: Motion::Nonlinear(&plant),
        sensors: Sensors {
            angle: sensor(ANGLE_NOISE, PI),
            rate: sensor(RATE_NOISE, 35.0),
            wheel_speed: sensor(WHEEL_NOISE, 700.0),
        },
        actuator: Actuator {
            limit_a: CURRENT_LIMIT_A,
            step_a: 0.0,
        },
        sample_time_s: SAMPLE_TIME_S,
        computation_s: 0.0,
        pushes: vec![Push::new(3.0, 0.02, 0.05), Push::new(6.0, -0.03, 0.05)],
        seed: SEED,
    };
    let mut law = ExactLaw {
        gains: RowVector3::from(gains),
        limit_a: CURRENT_LIMIT_A,
    };
    let start = State {
        angle_rad: PI + 0.02,
        ..State::rest()
    };
    let trace = bench.run(&start, 9.0, &mut law, false)?;
    let mut text = "time_s,angle_rad,rate_rad_s,wheel_speed_rad_s,current_A\n".to_owned();
    for index in 0..trace.len() {
        text.push_str(&format!(
            "{:.3},{:.4},{:.3},{:.2},{:.4}\n",
            trace.time_s[index],
            PI + trace.measured_angle_rad[index],
            trace.measured_rate_rad_s[index],
            trace.measured_wheel_speed_rad_s[index],
            trace.current_a[index],
        ));
    }
    Ok(File { name, text })
}

/// Sensors and drive that the controller of this bench would have.
const HARDWARE: &str = r#"# A bench like that of the thesis, with an MPU-6050 on the body.
[hardware.gyroscope]
part = "MPU-6050"
axes = ["x", "y", "z"]

[hardware.accelerometer]
part = "MPU-6050"
axes = ["x", "y", "z"]

[hardware.wheel_speed]
kind   = "converter"
slope  = 0.4
offset = -819.2
low    = 0
high   = 4095

[hardware.angle]
kind = "inertial"

[hardware.drive]
part = "ESCON 24/2"
kind = "current"
amperes_per_count = 8.4e-5

"#;

fn bench_toml(gains: [f64; 3]) -> File {
    let mut text = format!(
        "# Simulated; see demo/src/make.rs. The pivot has dry friction that the base model lacks.\n\
         [bench]\nname = \"demo\"\n\n[known]\n\
         gravity         = {GRAVITY}\n\
         torque_constant = {TORQUE_CONSTANT}\n\
         body_mass       = {BODY_MASS}\n\
         wheel_mass      = {WHEEL_MASS}\n\
         pivot_to_wheel  = {PIVOT_TO_WHEEL}\n\
         pivot_to_com    = {PIVOT_TO_COM}\n\n{HARDWARE}[controller]\n\
         gains         = [{}, {}, {}]\n\
         current_limit = {CURRENT_LIMIT_A:?}\n\
         sample_time   = {SAMPLE_TIME_S}\n",
        gains[0], gains[1], gains[2],
    );
    for (name, kind, file) in [
        ("spin-up 0.2 A", "spin-up", "spin-up-0.2A.csv"),
        ("spin-up 0.4 A", "spin-up", "spin-up-0.4A.csv"),
        ("spin-up 0.6 A", "spin-up", "spin-up-0.6A.csv"),
        (
            "spin-up 0.4 A reversed",
            "spin-up",
            "spin-up-0.4A-reversed.csv",
        ),
        ("coast-down", "spin-up", "coast-down.csv"),
        ("free swing 20 deg", "free-swing", "free-swing-20deg.csv"),
        ("free swing 50 deg", "free-swing", "free-swing-50deg.csv"),
        ("balance", "balance", "balance.csv"),
    ] {
        text.push_str(&format!(
            "\n[[experiment]]\nname = \"{name}\"\nkind = \"{kind}\"\nfile = \"{file}\"\n"
        ));
    }
    File {
        name: "bench.toml",
        text,
    }
}

/// Makes every file of the bench.
///
/// # Errors
/// If the controller cannot be designed or the balancing cannot be simulated, which these numbers
/// rule out.
pub fn make() -> Result<Vec<File>, Box<dyn Error>> {
    let gains = gains()?;
    let noise = &mut Noise(ChaCha8Rng::seed_from_u64(SEED));
    Ok(vec![
        bench_toml(gains),
        spin_up("spin-up-0.2A.csv", 0.0, 0.2, 5.0, noise),
        spin_up("spin-up-0.4A.csv", 0.0, 0.4, 5.0, noise),
        spin_up("spin-up-0.6A.csv", 0.0, 0.6, 5.0, noise),
        spin_up("spin-up-0.4A-reversed.csv", 0.0, -0.4, 5.0, noise),
        spin_up("coast-down.csv", 300.0, 0.0, 12.0, noise),
        free_swing("free-swing-20deg.csv", 20.0, noise),
        free_swing("free-swing-50deg.csv", 50.0, noise),
        balance("balance.csv", gains)?,
    ])
}
