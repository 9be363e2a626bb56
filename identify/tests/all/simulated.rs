//! Logs of a bench with any physics: the equations of motion written once more, integrated in steps
//! eight times finer than the log, with the sensors, the controller and the pushes of the reference
//! benches. Nothing of it comes from the crates under test but the types of a record.

use identify::{FitProblem, Record};
use plant::Kind;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Θ, j_w, G, τ, r_b, r_w of the reference benches.
pub const VALUES: [f64; 6] = [
    2.30344e-3, 1.36125e-4, 0.245158, 0.0335, 2.12e-5, 1.75204e-5,
];
/// Noise of angle (rad), rate (rad/s), wheel speed (rad/s) and current (A).
pub const NOISE: [f64; 4] = [1.2e-3, 4e-3, 0.6, 2e-3];
/// Gains of the balance controller.
const GAINS: [f64; 3] = [-24.267242, -2.129739, -0.02258758];
/// The pushes of the balance log: N m, s; f = A exp(−((t − tᵢ)/0.05)²).
pub const PUSHES: [(f64, f64); 4] = [(0.02, 4.0), (-0.03, 8.0), (0.035, 12.0), (-0.02, 16.0)];

/// What a torque may depend on.
#[derive(Clone, Copy, Debug)]
pub struct Now {
    pub time_s: f64,
    pub angle: f64,
    pub rate: f64,
    pub wheel_angle: f64,
    pub wheel_speed: f64,
}

/// A torque of the truth that the base model does not have, positive along positive speed.
pub type Torque<'a> = &'a (dyn Fn(&Now) -> f64 + Sync);

/// The physics of a bench.
#[derive(Clone, Copy)]
pub struct Physics<'a> {
    pub values: [f64; 6],
    pub on_body: Torque<'a>,
    pub on_wheel: Torque<'a>,
    /// Current that flows for a command.
    pub motor: &'a (dyn Fn(f64) -> f64 + Sync),
    /// Time constant of the current, s.
    pub motor_lag_s: f64,
    /// Age of the command that acts, in whole steps of the log.
    pub delay_steps: usize,
    /// Command before the log began, A; `None`: the first one.
    pub command_before_a: Option<f64>,
    pub noise: [f64; 4],
    /// Step of the angle's encoder in rad; 0 for none.
    pub angle_step: f64,
}

pub fn nothing(_: &Now) -> f64 {
    0.0
}

pub fn ideal(current: f64) -> f64 {
    current
}

impl Physics<'_> {
    /// The base model: viscous friction only.
    pub fn base() -> Physics<'static> {
        Physics {
            values: VALUES,
            on_body: &nothing,
            on_wheel: &nothing,
            motor: &ideal,
            motor_lag_s: 0.0,
            delay_steps: 0,
            command_before_a: None,
            noise: NOISE,
            angle_step: 0.0,
        }
    }
}

/// One experiment to simulate.
#[derive(Clone, Copy)]
pub struct Experiment<'a> {
    pub name: &'a str,
    pub kind: Kind,
    pub length_s: f64,
    pub step_s: f64,
    pub angle: f64,
    pub wheel_speed: f64,
    /// Commanded current in A at a time (ignored while balancing).
    pub current: &'a dyn Fn(f64) -> f64,
    pub pushes: &'a [(f64, f64)],
}

pub fn free_swing(name: &str, angle: f64, length_s: f64) -> Experiment<'_> {
    Experiment {
        name,
        kind: Kind::FreeSwing,
        length_s,
        step_s: 0.004,
        angle,
        wheel_speed: 0.0,
        current: &|_| 0.0,
        pushes: &[],
    }
}

pub fn spin_up<'a>(
    name: &'a str,
    current: &'a dyn Fn(f64) -> f64,
    length_s: f64,
) -> Experiment<'a> {
    Experiment {
        name,
        kind: Kind::SpinUp,
        length_s,
        step_s: 0.004,
        angle: 0.0,
        wheel_speed: 0.0,
        current,
        pushes: &[],
    }
}

pub fn coast_down(name: &str) -> Experiment<'_> {
    Experiment {
        wheel_speed: 150.0,
        ..spin_up(name, &|_| 0.0, 25.0)
    }
}

pub fn balance<'a>(name: &'a str, pushes: &'a [(f64, f64)]) -> Experiment<'a> {
    Experiment {
        name,
        kind: Kind::Balance,
        length_s: 20.0,
        step_s: 0.001,
        angle: std::f64::consts::PI + 0.05,
        wheel_speed: 0.0,
        current: &|_| 0.0,
        pushes,
    }
}

/// Simulates an experiment.
pub fn simulate(physics: &Physics, experiment: &Experiment, rng: &mut ChaCha8Rng) -> Record {
    let [total, wheel, gravity, torque, body_friction, wheel_friction] = physics.values;
    let kind = experiment.kind;
    let push = |t: f64| -> f64 {
        experiment
            .pushes
            .iter()
            .map(|(size, at)| size * (-((t - at) / 0.05f64).powi(2)).exp())
            .sum()
    };
    // State: α, α̇, φ, φ̇, current.
    let derivative = |t: f64, x: &[f64; 5], command: f64| -> [f64; 5] {
        let now = Now {
            time_s: t,
            angle: x[0],
            rate: x[1],
            wheel_angle: x[2],
            wheel_speed: x[3],
        };
        let (current, change) = if physics.motor_lag_s > 0.0 {
            (x[4], (command - x[4]) / physics.motor_lag_s)
        } else {
            (command, 0.0)
        };
        let drive = torque * (physics.motor)(current);
        let on_wheel = drive - wheel_friction * x[3] + (physics.on_wheel)(&now);
        let on_body =
            push(t) - body_friction * x[1] - gravity * x[0].sin() + (physics.on_body)(&now);
        match kind {
            Kind::FreeSwing => [x[1], on_body / total, 0.0, 0.0, 0.0],
            Kind::SpinUp => [0.0, 0.0, x[3], on_wheel / wheel, change],
            _ => {
                let body = (on_body - on_wheel) / (total - wheel);
                [x[1], body, x[3], on_wheel / wheel - body, change]
            }
        }
    };
    let n = (experiment.length_s / experiment.step_s).round() as usize + 1;
    let mut x = [experiment.angle, 0.0, 0.0, experiment.wheel_speed, 0.0];
    let mut noise = |std: f64| -> f64 {
        let e: f64 = StandardNormal.sample(rng);
        std * e
    };
    let mut series: [Vec<f64>; 5] = Default::default();
    let mut commands = vec![];
    for k in 0..n {
        let t = k as f64 * experiment.step_s;
        let mut angle = x[0] + noise(physics.noise[0]);
        if physics.angle_step > 0.0 {
            angle = (angle / physics.angle_step).round() * physics.angle_step;
        }
        let rate = x[1] + noise(physics.noise[1]);
        let speed = x[3] + noise(physics.noise[2]);
        let command = if kind == Kind::Balance {
            let law =
                GAINS[0] * (angle - std::f64::consts::PI) + GAINS[1] * rate + GAINS[2] * speed;
            (-law).clamp(-2.0, 2.0)
        } else {
            (experiment.current)(t)
        };
        for (series, value) in
            series
                .iter_mut()
                .zip([t, angle, rate, speed, command + noise(physics.noise[3])])
        {
            series.push(value);
        }
        commands.push(command);
        let command = match k.checked_sub(physics.delay_steps) {
            Some(then) => commands[then],
            None => physics.command_before_a.unwrap_or(commands[0]),
        };
        let parts = 8;
        let h = experiment.step_s / parts as f64;
        for part in 0..parts {
            let t = t + part as f64 * h;
            let shifted = |x: &[f64; 5], k: &[f64; 5], h: f64| -> [f64; 5] {
                std::array::from_fn(|i| x[i] + h * k[i])
            };
            let k1 = derivative(t, &x, command);
            let k2 = derivative(t + 0.5 * h, &shifted(&x, &k1, 0.5 * h), command);
            let k3 = derivative(t + 0.5 * h, &shifted(&x, &k2, 0.5 * h), command);
            let k4 = derivative(t + h, &shifted(&x, &k3, h), command);
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
    }
    let [time_s, angle, rate, speed, current] = series;
    Record::new(
        experiment.name,
        kind,
        time_s,
        [Some(angle), Some(rate), Some(speed)],
        Some(current),
        false,
    )
}

/// The logs of a reference bench, a little shorter.
pub fn bench(physics: &Physics, seed: u64) -> Vec<Record> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let slow = |_: f64| 0.2;
    let forward = |_: f64| 0.6;
    let fast = |_: f64| 1.0;
    let reversed = |_: f64| -0.6;
    [
        spin_up("spin-up 0.2 A", &slow, 6.0),
        spin_up("spin-up 0.6 A", &forward, 6.0),
        spin_up("spin-up 1.0 A", &fast, 3.5),
        spin_up("spin-up -0.6 A", &reversed, 6.0),
        coast_down("coast-down"),
        free_swing("free swing 20 deg", 20f64.to_radians(), 30.0),
        free_swing("free swing 52 deg", 52f64.to_radians(), 45.0),
        balance("balance", &PUSHES),
    ]
    .iter()
    .map(|experiment| simulate(physics, experiment, &mut rng))
    .collect()
}

/// A bench whose masses, lengths and torque constant were measured.
pub fn problem(records: Vec<Record>) -> FitProblem {
    let known = [None, None, Some(VALUES[2]), Some(VALUES[3])];
    FitProblem::from_records(records, known, Default::default()).expect("records")
}

/// A file of the recordings that are no part of the project; only for tests that need them.
pub fn data(path: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("FLYWHEEL_RECORDINGS")).join(path)
}
