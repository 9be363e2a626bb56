//! The emitted monitor on the nonlinear bench: it is silent while the pendulum moves as the model allows, and notices a
//! motor that does not follow its command within 0.3 s.

use crate::bench::{BASE, COULOMB_TORQUE, SAMPLE_TIME_S, bench, model};
use checker::program::Type;
use checker::{Machine, Module};
use codegen::hardware::HardwareSpec;
use codegen::spec::{ModelParameter, PhysicalRanges, PwmDrive};
use codegen::{EmissionOptions, ModuleSpec, MonitorSpec};
use design::{Design, Settings, Weights};
use generated::{Controller, Sample, Status, ZERO_CURRENT, wheel_speed};
use nalgebra::Vector3;
use plant::{EffectId, Kind, Plant, linearise};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use simulate::{
    LawFailure, LoopTrace, Push, RawController, RawLoop, RawSample, RawSensors, Sensors,
};
use std::f64::consts::PI;

/// Steps during which the body is held before the controller is armed.
const HELD_STEPS: usize = 500;

/// 0.2 A in counts of the duty. The time of the monitor counts from the first command of this size, because a dead
/// motor does not show while no current is commanded.
const ASKED_COUNTS: u16 = 2_383;

/// Steps after the first such current in which a fault of the motor must be noticed: 0.3 s.
const NOTICED_STEPS: usize = 300;

/// Largest angle of the body until then, degrees: less than a tenth of the angle that trips.
const LEAN_DEG: f64 = 3.0;

/// The emitted source of the thesis bench with a monitor.
fn emitted() -> Module {
    let (model, values) = model(true);
    let linear = linearise(&model, &values, PI, Some(0.0846768)).unwrap();
    let settings = Settings {
        sample_time_s: SAMPLE_TIME_S,
        weights: Weights {
            state: Vector3::new(25.0, 0.5, 5e-4),
            current: 1.0,
        },
        current_limit_a: 2.0,
        friction_extremes: None,
    };
    let design = Design::new(&linear, &settings).unwrap();
    let names = [
        "total_inertia",
        "wheel_inertia",
        "gravity_torque",
        "torque_constant",
        "body_viscous_friction",
        "wheel_viscous_friction",
        "body_coulomb_torque",
    ];
    let values = BASE.into_iter().chain([COULOMB_TORQUE]);
    let parameter = |(name, value): (&str, f64)| ModelParameter {
        name: name.to_owned(),
        value,
        std: None,
        unit: String::new(),
    };
    let spec = ModuleSpec {
        model_name: "thesis".to_owned(),
        gains: design.gains.into(),
        current_limit_a: 2.0,
        sample_time_s: SAMPLE_TIME_S,
        ranges: PhysicalRanges::of(&HardwareSpec::thesis_bench()),
        drive: PwmDrive::THESIS_BENCH,
        hardware: HardwareSpec::thesis_bench(),
        assumed: Vec::new(),
        parameters: names.into_iter().zip(values).map(parameter).collect(),
        correlation: None,
        state_weights: settings.weights.state.into(),
        current_weight: 1.0,
        a: [0, 1, 2].map(|row| [0, 1, 2].map(|column| linear.state[(row, column)])),
        b: linear.input.into(),
        ad: [0, 1, 2].map(|row| [0, 1, 2].map(|column| design.discrete.state[(row, column)])),
        bd: [0, 1, 2].map(|row| design.discrete.input[row]),
        closed_loop: None,
    };
    let sensors = Sensors::of_the_thesis();
    let noise_std = [
        sensors.angle.noise_std,
        sensors.rate.noise_std,
        sensors.wheel_speed.noise_std,
    ];
    let emitted = codegen::generate_with(
        &spec,
        &EmissionOptions {
            monitor: Some(MonitorSpec { noise_std }),
            ..EmissionOptions::default()
        },
    )
    .unwrap();
    let sources: Vec<_> = emitted.sources().collect();
    Module::parse(&sources).unwrap()
}

/// The fault of a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MotorFault {
    /// The motor follows its command.
    None,
    /// A wire is off: no torque.
    Dead,
    /// Two wires are exchanged.
    Reversed,
}

/// The compiled controller, beside the monitor from its source.
struct Watched<'a> {
    controller: Controller,
    monitor: Machine<'a>,
    words: Vec<i128>,
    fault: MotorFault,
    /// The step at which the fault begins.
    from_step: usize,
    steps: usize,
    /// The first step from the fault on that asked for [`ASKED_COUNTS`].
    asked: Option<usize>,
    /// The first step that was not allowed.
    noticed: Option<usize>,
}

impl<'a> Watched<'a> {
    fn new(module: &'a Module, fault: MotorFault, from_step: usize) -> Watched<'a> {
        let program = module.function("Monitor::allows").unwrap();
        // The monitor was emitted for the formats of the committed crate.
        let formats = [
            generated::Angle::FRAC_NBITS,
            generated::Rate::FRAC_NBITS,
            generated::WheelSpeed::FRAC_NBITS,
        ];
        let inputs = program.inputs.len();
        assert_eq!(
            program.argument_types[inputs - 4..inputs - 1],
            formats.map(Type::Fixed)
        );
        Watched {
            controller: Controller::new(),
            monitor: Machine::new(program),
            words: vec![0; inputs - 5],
            fault,
            from_step,
            steps: 0,
            asked: None,
            noticed: None,
        }
    }
}

impl RawController for Watched<'_> {
    fn reset(&mut self) {
        self.controller = Controller::new();
    }

    fn arm(&mut self) -> Result<bool, LawFailure> {
        Ok(self.controller.arm())
    }

    fn fault(&mut self) -> Result<(), LawFailure> {
        self.controller.fault();
        Ok(())
    }

    fn status(&self) -> Result<u8, LawFailure> {
        Ok(self.controller.status() as u8)
    }

    fn step(&mut self, sample: &RawSample) -> Result<u16, LawFailure> {
        let duty = self.controller.step(&Sample {
            gyro: sample.gyro,
            accel: sample.accel,
            mag: sample.mag,
            wheel_adc: wheel_counts(sample),
        });
        let attitude = self.controller.attitude();
        let mut arguments = self.words.clone();
        arguments.extend([
            i128::from(self.controller.status() == Status::Running),
            attitude.angle().to_bits().into(),
            attitude.rate().to_bits().into(),
            wheel_speed(wheel_counts(sample)).to_bits().into(),
            duty.0.into(),
        ]);
        let found = self.monitor.call(&arguments).expect("total");
        if found[0] == 0 && self.noticed.is_none() {
            self.noticed = Some(self.steps);
        }
        self.words = found[1..].to_vec();
        let is_faulty = self.steps >= self.from_step;
        if is_faulty && duty.0.abs_diff(ZERO_CURRENT) >= ASKED_COUNTS && self.asked.is_none() {
            self.asked = Some(self.steps);
        }
        self.steps += 1;
        Ok(match self.fault {
            MotorFault::Dead if is_faulty => ZERO_CURRENT,
            // The duty at the same distance on the other side of zero current.
            MotorFault::Reversed if is_faulty => {
                ZERO_CURRENT.wrapping_add(ZERO_CURRENT.wrapping_sub(duty.0))
            }
            _ => duty.0,
        })
    }

    fn angle_rad(&self) -> Result<f64, LawFailure> {
        Ok(self.controller.attitude().angle().to_num())
    }
}

fn on_bench(plant: &Plant<f64>, seed: u64) -> RawLoop<'_> {
    RawLoop {
        held_s: HELD_STEPS as f64 * SAMPLE_TIME_S,
        ..RawLoop::new(plant, RawSensors::of_the_thesis().unwrap(), seed)
    }
}

/// Balances for `duration_s` with a push of random size every four seconds.
fn pushed(seed: u64, duration_s: f64) -> (Option<usize>, LoopTrace) {
    let plant: Plant<f64> = bench(true);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let count = (duration_s / 4.0) as usize - 1;
    let pushes = (1..count)
        .map(|index| {
            let impulse = random.random_range(-3e-3..3e-3_f64);
            Push::of_impulse(4.0 * index as f64, impulse, 0.05_f64.copysign(impulse))
        })
        .collect();
    let on = RawLoop {
        pushes,
        ..on_bench(&plant, seed)
    };
    let module = emitted();
    let mut controller = Watched::new(&module, MotorFault::None, 0);
    let trace = on.run(0.02, duration_s, &mut controller, false).unwrap();
    assert_eq!(controller.controller.status(), Status::Running);
    (controller.noticed, trace)
}

#[test]
fn a_minute_with_noise_and_pushes_is_allowed() {
    for seed in [51, 52] {
        let (noticed, trace) = pushed(seed, 60.0);
        assert_eq!(noticed, None, "seed {seed}");
        let pushes = trace.push.iter().filter(|torque| **torque != 0.0).count();
        assert!(pushes > 100, "the pushes came");
    }
}

#[test]
#[ignore = "minutes: an hour of balancing"]
fn an_hour_with_noise_and_pushes_is_allowed() {
    let (noticed, trace) = pushed(53, 3600.0);
    assert_eq!(noticed, None);
    assert_eq!(trace.fell_at_s, None);
}

/// A bench whose parameters are off by their shares, in all corners of inertia, torque constant and gravity.
#[test]
fn a_bench_within_its_uncertainty_is_allowed() {
    let module = emitted();
    for corner in 0..8 {
        let factor = |bit: u32| if corner >> bit & 1 == 1 { 1.08 } else { 0.92 };
        let (model, mut values) = model(true);
        values[1] *= factor(0);
        values[2] *= factor(1);
        values[3] *= factor(2);
        let plant = Plant::new(&model, &values, Kind::Balance);
        let on = RawLoop {
            pushes: vec![Push::of_impulse(5.0, 2e-3, 0.05)],
            ..on_bench(&plant, 60 + corner)
        };
        let mut controller = Watched::new(&module, MotorFault::None, 0);
        let trace = on.run(0.03, 10.0, &mut controller, true).unwrap();
        assert_eq!(trace.fell_at_s, None, "corner {corner}");
        assert_eq!(controller.noticed, None, "corner {corner}");
    }
}

/// Steps from the first current of [`ASKED_COUNTS`] until the fault was noticed, and the body's lean then (degrees).
fn noticed(controller: &Watched, trace: &LoopTrace, run: &str) -> (usize, f64) {
    let noticed = controller.noticed;
    let noticed = noticed.unwrap_or_else(|| panic!("{run}: not noticed"));
    assert!(noticed >= controller.from_step, "{run}: too early");
    let asked = controller.asked.unwrap_or(noticed);
    let lean = trace.angle_rad[noticed - HELD_STEPS].abs().to_degrees();
    let steps = noticed.saturating_sub(asked);
    assert!(steps <= NOTICED_STEPS, "{run}: {steps} steps");
    assert!(lean < LEAN_DEG, "{run}: {lean} degrees");
    (steps, lean)
}

/// A motor that gives no torque, or the opposite one.
#[test]
fn a_motor_that_does_not_obey_is_noticed() {
    let plant: Plant<f64> = bench(true);
    let module = emitted();
    let mut random = ChaCha8Rng::seed_from_u64(54);
    for fault in [MotorFault::Dead, MotorFault::Reversed] {
        let (mut longest, mut furthest) = (0, 0.0_f64);
        for seed in 0..20 {
            let from_step = HELD_STEPS + random.random_range(100..3000);
            let mut controller = Watched::new(&module, fault, from_step);
            let trace = on_bench(&plant, 100 + seed)
                .run(random.random_range(-0.03..0.03), 7.0, &mut controller, true)
                .unwrap();
            let (steps, lean) = noticed(&controller, &trace, &format!("{fault:?}, seed {seed}"));
            longest = longest.max(steps);
            furthest = furthest.max(lean);
        }
        println!("{fault:?}: within {longest} steps, body at most at {furthest:.2} degrees");
    }
}

/// A wheel that friction holds on the body, from the release on.
#[test]
fn a_locked_wheel_is_noticed() {
    let (with_coulomb, mut values) = model(true);
    let with_lock = with_coulomb.with(EffectId::WheelCoulombFriction);
    // Three times what the motor gives at its limit.
    values.push(0.2);
    let plant = Plant::new(&with_lock, &values, Kind::Balance);
    let module = emitted();
    let mut random = ChaCha8Rng::seed_from_u64(55);
    let (mut longest, mut furthest) = (0, 0.0_f64);
    for seed in 0..20 {
        let start_rad = random.random_range(0.005..0.03_f64);
        let mut controller = Watched::new(&module, MotorFault::None, 0);
        let trace = on_bench(&plant, 200 + seed)
            .run(start_rad, 5.0, &mut controller, true)
            .unwrap();
        let wheel = trace.wheel_speed_rad_s.iter();
        let wheel = wheel.fold(0.0_f64, |most, speed| most.max(speed.abs()));
        assert!(wheel < 2.0, "the wheel is locked: {wheel} rad/s");
        let (steps, lean) = noticed(&controller, &trace, &format!("seed {seed}"));
        longest = longest.max(steps);
        furthest = furthest.max(lean);
    }
    println!("within {longest} steps, body at most at {furthest:.2} degrees");
}

/// The converter's counts in a sample.
fn wheel_counts(sample: &RawSample) -> u16 {
    u16::try_from(sample.wheel).expect("a converter has no negative counts")
}
