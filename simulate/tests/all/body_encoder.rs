//! The emitted controller of a bench with an encoder on the pivot: it balances for long, and no fault of its sensors
//! keeps the motor at full current for longer than is stated.

use checker::Module;
use codegen::hardware::{BodyEncoder, BodySensor, EncoderSpec, HardwareSpec, RateNeeds};
use codegen::spec::{ModuleSpec, PhysicalRanges, PwmDrive};
use design::{Design, Settings, Weights};
use nalgebra::Vector3;
use plant::{Model, Plant, linearise};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use simulate::scenario::Scale;
use simulate::{
    EncoderOutput, Fault, Faulty, InterpretedController, RawController, RawLoop, RawSample,
    RawSensors, Scenario,
};

use crate::bench::{BASE, bench};

const RUNNING: u8 = 2;
const LIMIT_A: f64 = 2.0;
const ZERO: u16 = 3000;
/// Steps for which a hand holds the body before the release.
const HELD_STEPS: usize = 400;

/// A bench whose AS5600 shows the body.
struct PivotBench {
    module: Module,
    encoder: EncoderSpec,
    /// N = −K of the emitted law, and B of the model: body and wheel.
    gains: [f64; 3],
    push: [f64; 2],
    /// A₂₁ of the model (1/s²).
    fall: f64,
}

impl PivotBench {
    fn new() -> PivotBench {
        let linear = linearise(&Model::base(), &BASE, std::f64::consts::PI, None).unwrap();
        let settings = Settings {
            sample_time_s: 1e-3,
            weights: Weights {
                state: Vector3::new(25.0, 0.5, 5e-4),
                current: 1.0,
            },
            current_limit_a: LIMIT_A,
            friction_extremes: None,
        };
        let design = Design::new(&linear, &settings).unwrap();
        let mut encoder = EncoderSpec {
            counts_per_turn: 4096.0,
            bits: 12,
            window: 1,
        };
        let needs = RateNeeds {
            sample_time_s: 1e-3,
            rate_gain: design.gains[1],
            current_limit_a: LIMIT_A,
            delay_margin_s: design.margins.delay_margin_s,
        };
        encoder.window = needs.window(encoder.rad_per_count());
        let hardware = HardwareSpec {
            body: BodySensor::Encoder(BodyEncoder {
                encoder,
                zero: ZERO.into(),
                largest_rate_rad_s: 35.0,
            }),
            gyro_rate_hz: None,
            accelerometer_m_s2_per_count: None,
            ..HardwareSpec::thesis_bench()
        };
        let row = |row: usize| [0, 1, 2].map(|column| linear.state[(row, column)]);
        let sampled = |row: usize| [0, 1, 2].map(|column| design.discrete.state[(row, column)]);
        let spec = ModuleSpec {
            model_name: "encoder on the pivot".to_owned(),
            gains: design.gains.into(),
            current_limit_a: LIMIT_A,
            sample_time_s: 1e-3,
            ranges: PhysicalRanges::of(&hardware),
            drive: PwmDrive::THESIS_BENCH,
            hardware,
            assumed: Vec::new(),
            parameters: vec![],
            correlation: None,
            state_weights: [25.0, 0.5, 5e-4],
            current_weight: 1.0,
            a: [row(0), row(1), row(2)],
            b: linear.input.into(),
            ad: [sampled(0), sampled(1), sampled(2)],
            bd: [0, 1, 2].map(|row| design.discrete.input[row]),
            closed_loop: None,
        };
        let emitted = codegen::generate(&spec).unwrap();
        let sources: Vec<(&str, &str)> = emitted.sources().collect();
        PivotBench {
            module: Module::parse(&sources).unwrap(),
            encoder,
            gains: [0, 1, 2].map(|i| -design.gains[i]),
            push: [spec.b[1].abs(), spec.b[1] + spec.b[2]],
            fall: spec.a[1][0],
        }
    }

    /// Current in A that holds the body at this angle against gravity.
    fn held_a(&self, angle_rad: f64) -> f64 {
        self.fall / self.push[0] * angle_rad
    }

    /// The wheel's speed (rad/s) beyond which an encoder that is stuck at this angle leads to a current that exceeds
    /// the current against gravity by more than half of the largest current.
    ///
    /// After its window a stuck encoder shows a constant angle c and no rate, so that the command is N₁ c + N₃ φ̇. At
    /// most the holding current of the angle c balances gravity.
    fn noticed_at_rad_s(&self, angle_rad: f64) -> f64 {
        let of_angle = (self.gains[0] * angle_rad - self.held_a(angle_rad)).abs();
        (0.5 * LIMIT_A + of_angle) / self.gains[2].abs()
    }

    fn limit(&self, name: &str) -> usize {
        let words = self.module.constant_words("constants", "LIMITS").unwrap();
        let found = words.iter().find(|(known, _)| known.ends_with(name));
        found.unwrap().1 as usize
    }

    fn controller(&self) -> InterpretedController {
        InterpretedController::new(&self.module).unwrap()
    }

    fn on<'a>(&self, plant: &'a Plant<f64>, seed: u64) -> RawLoop<'a> {
        let sensors = RawSensors {
            body: Some(EncoderOutput {
                counts_per_turn: self.encoder.counts_per_turn,
                bits: self.encoder.bits,
                zero_count: ZERO.into(),
            }),
            ..RawSensors::of_the_thesis().unwrap()
        };
        RawLoop {
            held_s: HELD_STEPS as f64 * 1e-3,
            ..RawLoop::new(plant, sensors, seed)
        }
    }
}

/// Half a minute with the pushes of the scenario, with and without dry friction in the pivot, with and without noise of
/// the encoder: a count that stands still because the body is at rest causes no trip.
#[test]
fn it_balances_for_half_a_minute_with_pushes() {
    let own = PivotBench::new();
    let scale = Scale::new(&BASE, LIMIT_A).unwrap();
    for (seed, with_coulomb, noise_counts) in [
        (1, false, 0.5),
        (2, true, 0.5),
        (3, true, 0.0),
        (4, false, 0.0),
    ] {
        let plant: Plant<f64> = bench(with_coulomb);
        let scenario = Scenario::half_minute(&scale);
        let mut on = own.on(&plant, seed);
        on.sensors.encoder_noise_counts = noise_counts;
        on.pushes = scenario.pushes;
        let mut controller = own.controller();
        let trace = on.run(0.0, 30.0, &mut controller, false).unwrap();
        let angle = trace
            .angle_rad
            .iter()
            .fold(0.0_f64, |most, x| most.max(x.abs()));
        println!(
            "seed {seed}: within {:.2}°, window {}",
            angle.to_degrees(),
            own.encoder.window
        );
        assert_eq!(trace.fell_at_s, None, "seed {seed}");
        assert_eq!(controller.status().unwrap(), RUNNING, "seed {seed}");
    }
}

/// The promise for a fault: the largest number of consecutive steps at full current, and whether the fault must trip.
fn promised(own: &PivotBench, fault: Fault) -> (usize, bool) {
    match fault {
        Fault::BodyJump | Fault::MissedTick => (0, true),
        Fault::WheelLow | Fault::WheelHigh => (own.limit("wheel_steps"), true),
        // The body leans further and further until its angle trips; the sign of the angle does not matter for this.
        Fault::BodyReversed => (own.limit("saturated_steps"), true),
        // The count zero is not that of the upright body, so that the encoder jumps. If the count happens to be near
        // zero, the wheel's sensor at its end trips.
        Fault::BusDead => (own.limit("wheel_steps"), true),
        _ => (own.limit("saturated_steps"), false),
    }
}

/// With faults at random times of runs with pushes, the motor is never at full current for longer than stated and has
/// no current after a trip. A count that is frozen while the body is balanced trips by itself.
#[test]
fn no_fault_drives_the_motor_for_longer_than_is_stated() {
    let own = PivotBench::new();
    let seed = 20_261_129;
    println!("seed {seed}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let plant: Plant<f64> = bench(true);
    let scale = Scale::new(&BASE, LIMIT_A).unwrap();
    let ends = [
        own.limit("wheel_low") as i32,
        own.limit("wheel_high") as i32,
    ];
    let (mut trips, mut frozen_full, mut frozen_trip) = (0, 0, 0);
    for run in 0..54 {
        let fault = Fault::WITH_BODY_ENCODER[run % Fault::WITH_BODY_ENCODER.len()];
        // While it balances, or before it is armed.
        let from = match run % 4 {
            0 => random.random_range(0..HELD_STEPS),
            _ => HELD_STEPS + random.random_range(1..2500),
        };
        let mut on = own.on(&plant, seed + run as u64);
        on.pushes = Scenario::half_minute(&scale).pushes;
        for push in &mut on.pushes {
            push.time_s *= 0.2;
        }
        let mut faulty = Faulty::new(own.controller(), fault, from, ends);
        faulty.body_counts = [ZERO, 4096];
        let start_rad = random.random_range(-0.1..0.1);
        on.run(start_rad, 5.0, &mut faulty, true).unwrap();
        let full: Vec<bool> = faulty
            .duties()
            .iter()
            .map(|duty| (f64::from(*duty) - 32_768.0).abs() * 2.2 / 26_214.0 > 0.999 * LIMIT_A)
            .collect();
        let longest = full
            .split(|is_full| !is_full)
            .map(<[bool]>::len)
            .max()
            .unwrap_or(0);
        let (most, must_trip) = promised(&own, fault);
        let tripped = faulty
            .statuses()
            .iter()
            .position(|status| *status > RUNNING);
        let driven = faulty.statuses().contains(&RUNNING);
        assert!(
            longest <= most,
            "run {run}, {fault:?}: {longest} steps at full current, {most} stated"
        );
        assert!(
            !must_trip || !driven || tripped.is_some(),
            "run {run}, {fault:?}: no trip"
        );
        for (duty, status) in faulty.duties().iter().zip(faulty.statuses()) {
            assert!(
                *status == RUNNING || *duty == 32_768,
                "run {run}, {fault:?}: {duty} at {status}"
            );
        }
        trips += usize::from(tripped.is_some());
        if matches!(fault, Fault::BodyFrozen | Fault::AllFrozen) && driven {
            frozen_full = frozen_full.max(longest);
            frozen_trip = frozen_trip.max(tripped.unwrap_or(0));
        }
    }
    // A count that is frozen near upright leads to little current at first: the body may fall before the controller
    // trips, but the motor hardly pushes.
    println!(
        "{trips} of 54 tripped; frozen: at full current for {frozen_full} ms at most, trips after {frozen_trip} ms at most"
    );
    assert!(
        frozen_full <= own.limit("frozen_steps"),
        "{frozen_full} ms at full current"
    );
}

/// An encoder that is stuck upright while the body is at rest. The wheel's speed then amplifies itself: u = N₃ φ̇
/// accelerates the wheel by (B₂ + B₃) u, less its friction, so that φ̇ grows with e^(λt), λ = (B₂ + B₃) N₃ − r_w/j_w.
/// After ln(φ*/φ̇₀)/λ it reaches the speed φ* at which the current exceeds the current against gravity by half of the
/// largest current; the controller trips the stated number of steps later. An earlier trip is impossible: under a
/// smaller current, which dry friction can hold, the count of a sound encoder stands still, too.
#[test]
fn a_count_stuck_upright_trips_when_the_wheel_has_spun_itself_up() {
    let own = PivotBench::new();
    // The converter of the thesis: rpm = 8.53108 count - 6594.5.
    let per_count = 8.53108 * std::f64::consts::TAU / 60.0;
    let zero_count = 6594.5 / 8.53108;
    let frozen = own.limit("frozen_steps");
    let friction = BASE[5] / BASE[1];
    let growth = own.push[1] * own.gains[2] - friction;
    for speed in [2.0_f64, -8.0, 30.0] {
        let mut controller = own.controller();
        let mut wheel = 0.0;
        let mut steps = 0;
        let mut tripped = None;
        for _ in 0..4_000 {
            let sample = RawSample {
                body: ZERO,
                gyro: [0; 3],
                accel: [0; 3],
                mag: None,
                wheel: (wheel / per_count + zero_count).round() as i32,
            };
            let duty = controller.step(&sample).unwrap();
            match controller.status().unwrap() {
                RUNNING => steps += 1,
                status if status > RUNNING => {
                    tripped = Some(steps);
                    break;
                }
                // The controller is armed with the wheel at rest; after that, a hand turns the wheel.
                _ => {
                    if controller.arm().unwrap() {
                        wheel = speed;
                    }
                }
            }
            let current = (f64::from(duty) - 32_768.0) * 2.2 / 26_214.0;
            wheel += 1e-3 * (own.push[1] * current - friction * wheel);
        }
        let last = own.noticed_at_rad_s(0.0);
        let wanted = (last / speed.abs()).ln() / growth * 1e3 + frozen as f64;
        let found = tripped.expect("it trips") as f64;
        println!(
            "from {speed} rad/s: trips after {found} ms, derived {wanted:.0} ms, {wheel:.0} rad/s"
        );
        // The converter shows the speed to half a count.
        let off = (1.0 + 0.5 * per_count / speed.abs()).ln() / growth * 1e3 + 10.0;
        assert!((found - wanted).abs() < off, "{found} {wanted}");
    }
}

/// Counts that are stuck while the body balances. The current exceeds the current against gravity at the shown angle
/// by more than half of the largest current only for the stated number of steps. The wheel's speed stays below the
/// bound that follows, far below the end of its sensor's range.
#[test]
fn a_stuck_count_lets_the_motor_do_little() {
    let own = PivotBench::new();
    let plant: Plant<f64> = bench(true);
    let seed = 20_261_130;
    println!("seed {seed}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let frozen = own.limit("frozen_steps");
    let (mut most, mut latest, mut trips) = (0.0_f64, 0, 0);
    for run in 0..16 {
        let from = HELD_STEPS + random.random_range(1..1500);
        let on = own.on(&plant, seed + run);
        let mut faulty = Faulty::new(own.controller(), Fault::BodyFrozen, from, [0, 0]);
        faulty.body_counts = [ZERO, 4096];
        let start_rad = random.random_range(-0.05..0.05);
        // The body may swing through, because no mechanical stop is simulated.
        let trace = on.run(start_rad, 5.0, &mut faulty, false).unwrap();
        // The trace begins at the release, the list of statuses at the fault.
        let released = from - HELD_STEPS;
        let stuck = trace.angle_rad[released];
        // The stuck angle differs from the true one by noise, half a count and the motion of one sample.
        let angle = stuck.abs() + 4.0 * own.encoder.rad_per_count().abs();
        // The wheel's speed relative to the body grows by this in the stated steps, with the body's own acceleration.
        let accelerated = (own.push[1] + own.push[0]) * LIMIT_A + own.fall;
        let bound = own.noticed_at_rad_s(angle) + accelerated * 1e-3 * (frozen + 2) as f64;
        let statuses = faulty.statuses();
        let end = statuses
            .iter()
            .position(|status| *status > RUNNING)
            .unwrap_or(statuses.len());
        let mut left = 0;
        for step in own.encoder.window as usize..end {
            let Some(speed) = trace.wheel_speed_rad_s.get(released + step) else {
                break;
            };
            let speed = speed.abs();
            most = most.max(speed);
            assert!(speed <= bound, "run {run}: {speed} rad/s of {bound}");
            let current = (f64::from(faulty.duties()[step]) - 32_768.0) * 2.2 / 26_214.0;
            let is_more = current.abs() > 0.5 * LIMIT_A + own.held_a(angle);
            left = if is_more { left + 1 } else { 0 };
            assert!(left <= frozen, "run {run}: {left} steps");
        }
        if end < statuses.len() {
            trips += 1;
            latest = latest.max(end);
        }
    }
    println!("{trips} of 16 tripped, after {latest} ms at most; the wheel within {most:.0} rad/s");
    assert!(trips > 8, "{trips}");
}
