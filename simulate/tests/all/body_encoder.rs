//! The emitted controller of a bench with an encoder on the pivot: it balances for long, and no fault of its sensors keeps
//! the motor at full current for longer than is stated.

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
    EncoderOutput, Fault, Faulty, InterpretedController, RawController, RawLoop, RawSensors,
    Scenario,
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
        }
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

/// Half a minute with the pushes of the scenario, with dry friction in the pivot and without, behind an encoder with
/// noise and one without: a count that stands still by itself is no false alarm.
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

/// What is stated of a fault: the longest row of steps at full current, and whether it must trip.
fn promised(own: &PivotBench, fault: Fault) -> (usize, bool) {
    match fault {
        Fault::BodyJump | Fault::MissedTick => (0, true),
        Fault::WheelLow | Fault::WheelHigh => (own.limit("wheel_steps"), true),
        // The body leans further and further, and its angle tells, whatever its sign.
        Fault::BodyReversed => (own.limit("saturated_steps"), true),
        // Zero is no count upright: a jump; where the count is the same by chance, the wheel's.
        Fault::BusDead => (own.limit("wheel_steps"), true),
        _ => (own.limit("saturated_steps"), false),
    }
}

/// Faults at random times of runs with pushes: never more than the stated time at full current, no current after a trip,
/// and a count that is frozen while the body is balanced is noticed by itself.
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
    // A count that is frozen near upright asks for little current at first: the body may fall before anything trips, and
    // the motor hardly pushes.
    println!(
        "{trips} of 54 tripped; frozen: at full current for {frozen_full} ms at most, trips after {frozen_trip} ms at most"
    );
    assert!(
        frozen_full <= own.limit("frozen_steps"),
        "{frozen_full} ms at full current"
    );
}
