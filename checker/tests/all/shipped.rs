//! The loop as shipped: what is proved of it, against a pendulum that knows nothing of the proof.
//!
//! The pendulum here is nonlinear, integrated in double precision in short steps; its friction, delay and sensors are
//! chosen against the loop. The controller is a relay filter and the law, written again.

use std::path::Path;
use std::sync::OnceLock;

use checker::certificate::reader::Certificate;
use checker::claims::closed_loop_second;
use checker::claims::control_law::EmittedLaw;
use checker::claims::loop_as_shipped::inertial::InertialErrors;
use checker::claims::loop_as_shipped::{self, NoBounds, ShippedLoop};
use checker::prove::Emitted;
use checker::{ClaimOutcome, Module};
use num_rational::BigRational;
use num_traits::ToPrimitive;

use crate::observer::Observer;

fn emitted() -> (Certificate, EmittedLaw) {
    let folder = Path::new("../generated");
    let module = Module::read(folder).unwrap();
    let certificate = Certificate::read(folder).unwrap();
    let law = EmittedLaw::read(&module).unwrap();
    (certificate, law)
}

fn shown() -> &'static ShippedLoop {
    static SHOWN: OnceLock<ShippedLoop> = OnceLock::new();
    SHOWN.get_or_init(|| {
        let (certificate, law) = emitted();
        loop_as_shipped::check(&certificate, &law).unwrap()
    })
}

pub(crate) fn real(value: &BigRational) -> f64 {
    value.to_f64().unwrap()
}

fn parameter(certificate: &Certificate, name: &str) -> f64 {
    let found = certificate.parameters.iter().find(|p| p.name == name);
    real(&found.unwrap().value.value)
}

/// How the sensors err.
#[derive(Clone, Copy)]
pub(crate) enum Sensors {
    /// Each sensor reads its nearest count.
    Round,
    /// Anywhere within what the claim allows, drawn anew at each sample.
    Draw,
    /// At the end that pushes the body away from upright.
    Push,
    /// At one end for ever: a constant bias of all that is shown.
    Bias,
}

/// Numbers of 0 to 1 (SplitMix64).
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

pub(crate) struct Pendulum {
    d: f64,
    wheel: f64,
    gravity: f64,
    torque: f64,
    body: f64,
    spin: f64,
    dry: f64,
    t: f64,
    gains: [f64; 3],
    limit: f64,
    turn: f64,
    errors: [f64; 4],
    age: f64,
    wheel_count: f64,
    gyro_count: f64,
    duty_count: f64,
    /// k_e/R of a voltage drive, whose held input is V/R; zero for a current drive.
    back_emf: f64,
    /// Largest held input.
    reach: f64,
    /// Steps of an encoder on the wheel.
    window: Option<usize>,
    /// Steps of an encoder on the pivot, the error of a reading (rad) and its count (rad).
    pivot: Option<(usize, f64, f64)>,
    observer: Option<Observer>,
}

/// Largest |angle|, |rate|, |wheel speed| and |command| of a run, and of its last quarter; the largest |estimated bias|.
pub(crate) struct Seen {
    pub(crate) estimate: f64,
    pub(crate) whole: [f64; 4],
    pub(crate) late: [f64; 4],
}

impl Pendulum {
    /// What stays of readings that only round, after this number of steps: within what is proved of it, and not nothing.
    pub(crate) fn keeps_up_no_more_than_is_proved(&self, shown: &ShippedLoop, steps: usize) {
        for delay in [0.0, 1.0] {
            let seen = self.run(0.9 * real(&shown.start), delay, Sensors::Round, steps, 1);
            let kept = shown.kept_up.states.iter().chain([&shown.kept_up.command]);
            for (index, bound) in kept.enumerate() {
                println!("{index}: {:.3e} of {:.3e}", seen.late[index], real(bound));
                assert!(seen.late[index] <= real(bound), "quantity {index}");
            }
            assert!(seen.late[0] > 1e-6);
        }
    }

    fn new() -> Pendulum {
        let (certificate, law) = emitted();
        Pendulum::of(&certificate, &law, shown())
    }

    pub(crate) fn of(certificate: &Certificate, law: &EmittedLaw, shown: &ShippedLoop) -> Pendulum {
        let p = |name: &str| parameter(certificate, name);
        let (theta, wheel) = (p("total_inertia"), p("wheel_inertia"));
        let t = real(&certificate.sample_time_s.value);
        let errors = &shown.errors;
        let body = errors.inertial();
        let filter = certificate.hardware.inertial();
        let of_body = |pick: fn(&InertialErrors) -> &BigRational| {
            body.map_or(0.0, |errors| real(pick(errors)))
        };
        let pivot = certificate.hardware.body_encoder();
        let voltage = certificate.drive.voltage.as_ref();
        let encoder = certificate.hardware.wheel_speed.encoder.as_ref();
        Pendulum {
            d: theta - wheel,
            wheel,
            gravity: p("gravity_torque"),
            torque: p("torque_constant"),
            body: p("body_viscous_friction"),
            spin: p("wheel_viscous_friction"),
            dry: p("body_coulomb_torque"),
            t,
            gains: law.gains.each_ref().map(real),
            limit: real(&law.limit),
            turn: 2.0 * t * filter.map_or(0.0, |filter| real(&filter.beta_rad_s.value)),
            errors: [
                of_body(|errors| &errors.accel) / 9.80665,
                of_body(|errors| &errors.gyro_axis),
                real(&errors.wheel_speed),
                of_body(|errors| &errors.drift),
            ],
            age: of_body(|errors| &errors.age),
            pivot: pivot.map(|encoder| {
                let count = std::f64::consts::TAU / real(&encoder.counts_per_turn.value).abs();
                (encoder.window as usize, real(&errors.reading), count)
            }),
            wheel_count: real(&certificate.hardware.wheel_speed.rad_s_per_count.value),
            gyro_count: filter.map_or(1.0, |filter| real(&filter.gyroscope.matrix[2][2].value)),
            duty_count: real(&certificate.drive.amperes_per_count.value),
            back_emf: voltage.map_or(0.0, |drive| {
                real(&drive.back_emf_v_s.value) / real(&drive.winding_ohm.value)
            }),
            reach: voltage.map_or(f64::INFINITY, |_| {
                real(&certificate.drive.current_range_a.value)
            }),
            window: encoder.map(|encoder| encoder.window as usize),
            observer: law.observer.as_ref().map(|own| Observer::of(own, true)),
        }
    }

    fn accelerations(&self, [angle, rate, speed]: [f64; 3], held: f64) -> [f64; 2] {
        let current = held - self.back_emf * speed;
        let dry = self.dry * (rate / 1e-3).tanh();
        let torque = self.torque * current - self.spin * speed;
        let lean = self.gravity * angle.sin();
        let body = (lean - self.body * rate - dry - torque) / self.d;
        [body, torque / self.wheel - body]
    }

    /// From rest at `start`, with a current that is late by the share `delay` of a sample.
    pub(crate) fn run(
        &self,
        start: f64,
        delay: f64,
        sensors: Sensors,
        steps: usize,
        seed: u64,
    ) -> Seen {
        const PARTS: usize = 20;
        let mut random = Draws(seed);
        let mut x = [start, 0.0, 0.0];
        let mut believed = start;
        let mut flowing = 0.0;
        let mut turned = 0.0;
        let mut turns = std::collections::VecDeque::from(vec![0.0; self.window.unwrap_or(0) + 1]);
        let mut rates = std::collections::VecDeque::from(vec![0.0; 200]);
        let mut shown =
            std::collections::VecDeque::from(vec![start; self.pivot.map_or(0, |p| p.0)]);
        let mut observer = self.observer;
        let mut seen = Seen {
            estimate: 0.0,
            whole: [0.0; 4],
            late: [0.0; 4],
        };
        let [direction, gyro, wheel, drift] = self.errors;
        for step in 0..steps {
            // A reading of the gyroscope as old as it may be, or fresh.
            let old = match sensors {
                Sensors::Round => 0.0,
                Sensors::Draw => random.next(),
                Sensors::Push | Sensors::Bias => 1.0,
            };
            let back = (old * self.age / self.t * PARTS as f64).round() as usize;
            let rate = rates[rates.len() - 1 - back.min(rates.len() - 1)];
            let away = if x[0] >= 0.0 { -1.0 } else { 1.0 };
            let mut error = |size: f64| match sensors {
                Sensors::Round => 0.0,
                Sensors::Draw => (2.0 * random.next() - 1.0) * size,
                Sensors::Push => away * size,
                Sensors::Bias => size,
            };
            let seen_direction = x[0] + error(direction);
            let mut seen_rate = rate + error(gyro) + error(drift);
            // An encoder's speed is the turn over its window.
            turns.pop_front();
            turns.push_back(turned);
            let true_speed = match self.window {
                Some(window) => (turned - turns[0]) / (window as f64 * self.t),
                None => x[2],
            };
            let mut seen_speed = true_speed + error(wheel);
            if matches!(sensors, Sensors::Round) {
                seen_rate = (seen_rate / self.gyro_count).round() * self.gyro_count;
                seen_speed = (seen_speed / self.wheel_count).round() * self.wheel_count;
            }
            believed += self.t * seen_rate;
            believed -= self.turn * (believed - seen_direction).signum();
            if let Some((window, most, count)) = self.pivot {
                believed = match sensors {
                    Sensors::Round => (x[0] / count).round() * count,
                    // The loop's worst readings change sides as slowly as the loop, which `error` does.
                    Sensors::Draw | Sensors::Push | Sensors::Bias => x[0] + error(most),
                };
                let before = shown.pop_front().unwrap_or(believed);
                shown.push_back(believed);
                seen_rate = (believed - before) / (window as f64 * self.t);
            }
            let [n1, n2, n3] = self.gains;
            let shown_states = [believed, seen_rate, seen_speed];
            let mut bias = 0.0;
            if let Some(observer) = &mut observer {
                if step == 0 {
                    observer.waits([start, 0.0, 0.0]);
                }
                bias = observer.estimate(shown_states);
                seen.estimate = seen.estimate.max(bias.abs());
            }
            let wished = n1 * (believed - bias) + n2 * seen_rate + n3 * seen_speed;
            let command = wished.clamp(-self.limit, self.limit);
            if let Some(observer) = &mut observer {
                observer.advance(shown_states, command);
            }
            let held = (command + self.back_emf * seen_speed).clamp(-self.reach, self.reach);
            let sent = (held / self.duty_count).round() * self.duty_count;
            let quantities = [x[0], x[1], x[2], wished];
            for (index, value) in quantities.into_iter().enumerate() {
                seen.whole[index] = seen.whole[index].max(value.abs());
                if step >= steps * 3 / 4 {
                    seen.late[index] = seen.late[index].max(value.abs());
                }
            }
            if x[0].abs() > 1.0 {
                seen.late[0] = x[0].abs();
                break;
            }
            for part in 0..PARTS {
                let h = self.t / PARTS as f64;
                let is_late = (part as f64) < delay * PARTS as f64;
                let current = if is_late { flowing } else { sent };
                let [a, b] = self.accelerations(x, current);
                let middle = [
                    x[0] + h / 2.0 * x[1],
                    x[1] + h / 2.0 * a,
                    x[2] + h / 2.0 * b,
                ];
                let [a, b] = self.accelerations(middle, current);
                turned += h * middle[2];
                x = [x[0] + h * middle[1], x[1] + h * a, x[2] + h * b];
                rates.pop_front();
                rates.push_back(x[1]);
            }
            flowing = sent;
        }
        seen
    }
}

/// No run from within the proved start leaves the proved bounds, whatever sensors and delay do.
#[test]
fn no_run_leaves_the_bounds() {
    let shown = shown();
    let bench = Pendulum::new();
    let start = real(&shown.start);
    let seed: u64 = std::env::var("SEED")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(20);
    println!("seed {seed}");
    for (run, delay) in [0.0, 0.3, 0.5, 0.8, 1.0].into_iter().enumerate() {
        for sensors in [Sensors::Round, Sensors::Draw, Sensors::Push] {
            for share in [-1.0, 0.4, 1.0] {
                let seen = bench.run(share * start, delay, sensors, 1_500, seed + run as u64);
                for (index, bound) in shown
                    .bounds
                    .states
                    .iter()
                    .chain([&shown.bounds.command])
                    .enumerate()
                {
                    assert!(
                        seen.whole[index] <= real(bound),
                        "quantity {index}: {} above {} with delay {delay}, start {share}",
                        seen.whole[index],
                        real(bound)
                    );
                }
            }
        }
    }
}

/// What stays of a motion with sensors that only round is within what is proved of it, and not nothing.
#[test]
fn what_stays_is_within_what_is_proved() {
    let shown = shown();
    let bench = Pendulum::new();
    let mut worst = [0.0_f64; 4];
    for delay in [0.0, 0.5, 1.0] {
        let seen = bench.run(0.9 * real(&shown.start), delay, Sensors::Round, 12_000, 1);
        for (worst, seen) in worst.iter_mut().zip(seen.late) {
            *worst = worst.max(seen);
        }
    }
    println!("kept up in simulation: {worst:?}");
    for (index, bound) in shown
        .kept_up
        .states
        .iter()
        .chain([&shown.kept_up.command])
        .enumerate()
    {
        println!("{index}: {:.3e} of {:.3e}", worst[index], real(bound));
        assert!(worst[index] <= real(bound), "{index}");
    }
    // Dry friction and rounding keep the pendulum moving.
    assert!(worst[0] > 1e-6);
}

/// How much of the truth the proof reaches: the largest start from which a run comes back.
#[test]
fn the_proved_start_is_part_of_the_true_one() {
    let bench = Pendulum::new();
    let proved = real(&shown().start);
    let comes_back = |start: f64| {
        [0.0, 1.0].iter().all(|delay| {
            let seen = bench.run(start, *delay, Sensors::Push, 3_000, 3);
            seen.late[0] < 0.03
        })
    };
    assert!(comes_back(proved));
    let mut largest = proved;
    while comes_back(largest + 0.01) {
        largest += 0.01;
    }
    println!("proved {proved:.4} rad, simulated {largest:.4} rad");
    // No loop returns from beyond the angle that the largest current holds.
    let holds = (bench.torque * bench.limit / bench.gravity).asin();
    assert!(proved < largest && largest < holds, "{largest} {holds}");
}

/// The second checker, which shares nothing with the first, finds the same start and the same bounds.
#[test]
fn the_second_checker_agrees() {
    let mut emitted = Emitted::read(Path::new("../generated")).unwrap();
    emitted.certificate = with_derived_parameter();
    both_agree(&emitted, shown());
}

/// Start and bounds of the second checker against those of the first, where Python is.
pub(crate) fn both_agree(emitted: &Emitted, shown: &ShippedLoop) {
    let said = match closed_loop_second::as_shipped_by_python(emitted) {
        ClaimOutcome::Proved(said) => said,
        ClaimOutcome::NotRun(why) => {
            eprintln!("not run: {why}");
            return;
        }
        other => panic!("{other:?}"),
    };
    let numbers: Vec<f64> = said
        .split(|c: char| !(c.is_ascii_digit() || c == '.'))
        .filter_map(|word| word.parse().ok())
        .collect();
    let own = [&shown.start]
        .into_iter()
        .chain(&shown.bounds.states)
        .chain([&shown.bounds.command])
        .chain(&shown.kept_up.states)
        .chain([&shown.kept_up.command]);
    let own: Vec<f64> = own.map(real).collect();
    assert_eq!(numbers.len(), own.len(), "{said}");
    for (own, theirs) in own.iter().zip(numbers) {
        assert!((own - theirs).abs() < 1e-3 * own, "{own} {theirs}: {said}");
    }
}

fn altered(pointer: &str, value: serde_json::Value) -> Result<ShippedLoop, NoBounds> {
    let text = std::fs::read_to_string("../generated/certificate.json").unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    *json.pointer_mut(pointer).unwrap() = value;
    let (_, law) = emitted();
    loop_as_shipped::check(&Certificate::parse(&json.to_string()).unwrap(), &law)
}

/// The committed certificate with the parameter that masses and lengths of a bench give its model, and that no equation of
/// motion has.
fn with_derived_parameter() -> String {
    let text = std::fs::read_to_string("../generated/certificate.json").unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let (name, value, std, unit) = ("body_inertia", "1.5e-4", "1e-8", "kg m2");
    let derived = serde_json::json!({"name": name, "value": value, "std": std, "unit": unit});
    json["parameters"].as_array_mut().unwrap().push(derived);
    json.to_string()
}

#[test]
fn what_follows_from_other_parameters_changes_nothing() {
    let certificate = Certificate::parse(&with_derived_parameter()).unwrap();
    let outcome = loop_as_shipped::check(&certificate, &emitted().1).unwrap();
    assert_eq!(outcome.start, shown().start, "the largest start");
}

/// A module that falls with every other row proved: a fast filter beside an accelerometer that the motion shakes.
#[test]
fn a_fast_filter_on_a_lever_arm_is_not_proved() {
    let text = std::fs::read_to_string("../generated/certificate.json").unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    json["hardware"]["beta_rad_s"] = "3.9".into();
    json["hardware"]["lever_arm_m"] = serde_json::json!(["0.085", "0"]);
    let (_, law) = emitted();
    let outcome = loop_as_shipped::check(&Certificate::parse(&json.to_string()).unwrap(), &law);
    assert!(matches!(outcome, Err(NoBounds::NotShown(_))), "{outcome:?}");
}

#[test]
fn what_the_argument_does_not_hold_is_named() {
    // An effect without a place in the argument.
    let outcome = altered("/parameters/5/name", "motor_lag".into());
    assert!(
        matches!(&outcome, Err(NoBounds::NotShown(why)) if why.contains("motor_lag")),
        "{outcome:?}"
    );
    // A pendulum that no gravity pulls.
    let outcome = altered("/parameters/2/value", "-0.245158".into());
    assert!(
        matches!(outcome, Err(NoBounds::Unphysical(_))),
        "{outcome:?}"
    );
    // Gravity of the sine and of the matrix.
    let outcome = altered("/parameters/2/value", "0.3".into());
    assert!(
        matches!(outcome, Err(NoBounds::Unphysical(_))),
        "{outcome:?}"
    );
}

/// More friction and a coarser sensor make the start smaller, not larger.
#[test]
fn worse_parts_prove_less() {
    let good = real(&shown().start);
    let dry = altered("/parameters/5/value", "0.002".into()).map(|loop_| real(&loop_.start));
    assert!(dry.is_ok_and(|start| start < good));
    let coarse = altered("/hardware/wheel_speed/rad_s_per_count", "3".into());
    assert!(coarse.is_ok_and(|loop_| real(&loop_.start) < good));
}
