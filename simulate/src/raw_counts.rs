//! The loop as the firmware closes it: raw counts of the sensors in, duty of the drive out.
//!
//! Nothing between is idealised: the accelerometer feels the body's own acceleration where it
//! sits, every reading has noise, a bias and the steps of its converter, the attitude is found by
//! the emitted filter, and the current is what the duty says.

use crate::SimulateError;
use crate::closed_loop::{Actuator, Answer, ClosedLoop, Instant, Trace, at_rest};
use crate::error::check_positive;
use crate::interpreted::words_of;
use crate::law::{LawFailure, Measured};
use crate::motion::Motion;
use crate::push::Push;
use crate::recovery::{Recovery, bisect, decided_after_s};
use crate::scenario::Scale;
use crate::sensors::from_upright_rad;
use attitude::{AttitudeSpec, STANDARD_GRAVITY, SensorLine};
use checker::program::Program;
use checker::{Machine, Module};
use generated::{Controller, Sample};
use nalgebra::{Matrix3, Vector3};
use plant::{Plant, State};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// An emitted controller: one step from raw counts to the duty.
pub trait RawController {
    /// Back to the state after power-up: not aligned, not armed.
    fn reset(&mut self);

    /// From the next step on, the motor is driven.
    ///
    /// # Errors
    /// [`LawFailure`] where the controller cannot be run.
    fn arm(&mut self) -> Result<(), LawFailure>;

    /// One step; the duty in counts.
    ///
    /// # Errors
    /// [`LawFailure`] where the emitted code would panic.
    fn step(&mut self, sample: &Sample) -> Result<u16, LawFailure>;

    /// The angle from upright that the attitude filter believes, rad.
    ///
    /// # Errors
    /// [`LawFailure`] where the emitted code would panic.
    fn angle_rad(&self) -> Result<f64, LawFailure>;
}

/// The emitted controller of the thesis bench, as compiled into this program.
impl RawController for Controller {
    fn reset(&mut self) {
        *self = Controller::new();
    }

    fn arm(&mut self) -> Result<(), LawFailure> {
        Controller::arm(self);
        Ok(())
    }

    fn step(&mut self, sample: &Sample) -> Result<u16, LawFailure> {
        Ok(Controller::step(self, sample).0)
    }

    fn angle_rad(&self) -> Result<f64, LawFailure> {
        Ok(self.attitude().angle().to_num())
    }
}

/// The controller of any emitted crate, run bit for bit from its source.
#[derive(Clone, Debug)]
pub struct InterpretedController {
    step: Program,
    angle: Program,
    /// For each word of the attitude, its place among those of the controller.
    attitude: Vec<usize>,
    armed: usize,
    angle_unit: f64,
    start: Vec<i128>,
    words: Vec<i128>,
}

impl InterpretedController {
    /// The controller in `module`.
    ///
    /// # Errors
    /// [`LawFailure`] where the crate has no such controller.
    pub fn new(module: &Module) -> Result<Self, LawFailure> {
        let failure = |message: String| LawFailure { message };
        let find = |name: &str| {
            module
                .function(name)
                .ok_or_else(|| failure(format!("the emitted crate has no function `{name}`")))
        };
        let step = find("Controller::step")?.clone();
        let angle = find("Attitude::angle")?.clone();
        let place = |name: &str| {
            step.inputs
                .iter()
                .position(|input| input == name)
                .ok_or_else(|| failure(format!("`Controller::step` has no `{name}`")))
        };
        let attitude = angle
            .inputs
            .iter()
            .map(|name| place(&name.replacen("self.", "self.attitude.", 1)))
            .collect::<Result<Vec<_>, _>>()?;
        let armed = place("self.is_armed")?;
        let start = Machine::new(find("Controller::new")?)
            .call(&[])
            .map_err(|trap| failure(trap.to_string()))?
            .to_vec();
        let bits = match angle.result_types.as_slice() {
            [checker::program::Type::Fixed(bits)] => *bits,
            _ => return Err(failure("`Attitude::angle` returns no angle".to_owned())),
        };
        Ok(InterpretedController {
            angle,
            attitude,
            armed,
            angle_unit: 2.0_f64.powi(-(bits as i32)),
            words: start.clone(),
            start,
            step,
        })
    }
}

impl RawController for InterpretedController {
    fn reset(&mut self) {
        self.words.clone_from(&self.start);
    }

    fn arm(&mut self) -> Result<(), LawFailure> {
        self.words[self.armed] = 1;
        Ok(())
    }

    fn step(&mut self, sample: &Sample) -> Result<u16, LawFailure> {
        let mut arguments = self.words.clone();
        arguments.extend(sample.gyro.map(i128::from));
        arguments.extend(sample.accel.map(i128::from));
        arguments.push(sample.mag.is_some().into());
        arguments.extend(sample.mag.unwrap_or_default().map(i128::from));
        arguments.push(sample.wheel_adc.into());
        let results = words_of(&self.step, &arguments)?;
        let (duty, state) = results.split_at(1);
        self.words.clear();
        self.words.extend_from_slice(state);
        u16::try_from(duty[0]).map_err(|_| LawFailure {
            message: format!("the duty {} is no 16-bit word", duty[0]),
        })
    }

    fn angle_rad(&self) -> Result<f64, LawFailure> {
        let words: Vec<i128> = self
            .attitude
            .iter()
            .map(|place| self.words[*place])
            .collect();
        let results = words_of(&self.angle, &words)?;
        Ok(results[0] as f64 * self.angle_unit)
    }
}

/// A three-axis sensor from SI units to counts: counts = `per_unit` · value + `bias_counts`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CountsLine {
    /// Counts per SI unit.
    pub per_unit: Matrix3<f64>,
    /// Reading at zero input, counts.
    pub bias_counts: Vector3<f64>,
}

impl CountsLine {
    /// The sensor that `line` calibrates perfectly, but for `left_counts` of bias on each axis.
    ///
    /// # Errors
    /// A matrix without inverse.
    pub fn calibrated_by(
        line: &SensorLine,
        left_counts: Vector3<f64>,
    ) -> Result<Self, SimulateError> {
        let determinant = line.matrix.determinant().abs();
        check_positive("the determinant of a sensor's matrix", determinant)?;
        Ok(CountsLine {
            per_unit: line.matrix.try_inverse().unwrap_or_default(),
            bias_counts: line.bias_counts + left_counts,
        })
    }

    /// The counts of `value`, which end at those of a 16-bit word.
    fn read(&self, value: Vector3<f64>) -> [i16; 3] {
        let counts = self.per_unit * value + self.bias_counts;
        // A cast saturates, as the converter does.
        [0, 1, 2].map(|axis| counts[axis].round() as i16)
    }
}

/// The sensors in counts and the drive's line, as they truly are: what the controller believes of
/// them is in its own constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawSensors {
    /// Gyroscope, 16 bit.
    pub gyro: CountsLine,
    /// Standard deviation of its noise, rad/s a sample.
    pub gyro_noise_rad_s: f64,
    /// Accelerometer, 16 bit.
    pub accel: CountsLine,
    /// Standard deviation of its noise, m/s² a sample.
    pub accel_noise_m_s2: f64,
    /// Gravity, m/s².
    pub gravity_m_s2: f64,
    /// Place of the accelerometer from the pivot axis, in the aligned sensor's x and y, m.
    pub lever_arm_m: [f64; 2],
    /// Angle about the pivot axis from the body's axis to the sensor's x axis, rad.
    pub mounting_angle_rad: f64,
    /// Wheel speed per count of the converter, rad/s.
    pub wheel_speed_per_count: f64,
    /// Wheel speed at zero counts, rad/s.
    pub wheel_speed_at_zero: f64,
    /// Standard deviation of its noise, rad/s a sample.
    pub wheel_noise_rad_s: f64,
    /// Largest count of the converter.
    pub wheel_adc_max: u16,
    /// Duty at zero current, counts.
    pub duty_zero: u16,
    /// Current per count of duty, A.
    pub current_per_count_a: f64,
}

impl RawSensors {
    /// Sensors that `spec` calibrates and mounts rightly, on converter and drive of the thesis:
    /// 12 bit with rpm = 8.53108 count − 6594.5; 10 % to 90 % of a 16-bit duty for ∓2.2 A.
    ///
    /// Assumed, since the thesis states neither: noise densities of the data sheets over 500 Hz
    /// (0.025 °/s/√Hz and 126 µg/√Hz), 0.6 rad/s on the wheel; what a calibration leaves, 0.1 °/s
    /// and 1 mg on each axis (1.6 and 4.1 counts of the thesis' sensors).
    ///
    /// # Errors
    /// A sensor's matrix without inverse.
    pub fn calibrated_by(spec: &AttitudeSpec) -> Result<RawSensors, SimulateError> {
        let rpm = TAU / 60.0;
        let root_bandwidth = 500.0_f64.sqrt();
        let left = Vector3::new(1.0, -1.0, 1.0);
        Ok(RawSensors {
            gyro: CountsLine::calibrated_by(&spec.gyro, left * 1.6)?,
            gyro_noise_rad_s: 0.025_f64.to_radians() * root_bandwidth,
            accel: CountsLine::calibrated_by(&spec.accel, left * 4.1)?,
            accel_noise_m_s2: 126e-6 * STANDARD_GRAVITY * root_bandwidth,
            gravity_m_s2: spec.gravity_m_s2,
            lever_arm_m: spec.lever_arm_m,
            mounting_angle_rad: spec.mounting_angle_rad,
            wheel_speed_per_count: 8.53108 * rpm,
            wheel_speed_at_zero: -6594.5 * rpm,
            wheel_noise_rad_s: 0.6,
            wheel_adc_max: 4095,
            duty_zero: 32_768,
            current_per_count_a: 2.2 / 26_214.0,
        })
    }

    /// The hardware of the thesis: gyroscope FXAS21002 at ±2000 °/s (62.5 m°/s per count),
    /// accelerometer FXOS8700 at 4096 counts/g, the rest as in [`RawSensors::calibrated_by`]. The
    /// sensor sits 50 mm from the pivot towards the wheel, of which the filter knows nothing.
    ///
    /// # Errors
    /// None in fact: the matrices are diagonal.
    pub fn of_the_thesis() -> Result<RawSensors, SimulateError> {
        Ok(RawSensors {
            lever_arm_m: [0.05, 0.0],
            ..RawSensors::calibrated_by(&AttitudeSpec::thesis())?
        })
    }

    /// The counts at `state`, whose body accelerates by `acceleration_rad_s2`.
    ///
    /// The accelerometer reads the reaction to gravity and the acceleration of its own place r,
    /// α̈ (−r_y, r_x) − α̇² r (see crate `attitude`, lever arm); upwards is
    /// (cos(θ + m), −sin(θ + m)) at the angle θ from upright.
    pub fn sample(
        &self,
        state: &State<f64>,
        acceleration_rad_s2: f64,
        random: &mut ChaCha8Rng,
    ) -> Sample {
        let mut noise = || -> f64 { StandardNormal.sample(random) };
        let mut noises = |std: f64| Vector3::from_fn(|_, _| std * noise());
        let rate = Vector3::new(0.0, 0.0, state.rate_rad_s) + noises(self.gyro_noise_rad_s);
        let (sin, cos) = (from_upright_rad(state.angle_rad) + self.mounting_angle_rad).sin_cos();
        let [x, y] = self.lever_arm_m;
        let squared = state.rate_rad_s * state.rate_rad_s;
        let force = Vector3::new(
            self.gravity_m_s2 * cos - acceleration_rad_s2 * y - squared * x,
            -self.gravity_m_s2 * sin + acceleration_rad_s2 * x - squared * y,
            0.0,
        ) + noises(self.accel_noise_m_s2);
        let speed = state.wheel_speed_rad_s + self.wheel_noise_rad_s * noise();
        let adc = (speed - self.wheel_speed_at_zero) / self.wheel_speed_per_count;
        Sample {
            gyro: self.gyro.read(rate),
            accel: self.accel.read(force),
            mag: None,
            wheel_adc: adc.round().clamp(0.0, f64::from(self.wheel_adc_max)) as u16,
        }
    }

    /// The current that a duty asks for, A.
    pub fn current_a(&self, duty: u16) -> f64 {
        (f64::from(duty) - f64::from(self.duty_zero)) * self.current_per_count_a
    }

    fn wheel_speed_rad_s(&self, adc: u16) -> f64 {
        f64::from(adc) * self.wheel_speed_per_count + self.wheel_speed_at_zero
    }
}

/// The bench around an emitted controller.
#[derive(Clone, Debug)]
pub struct RawLoop<'a> {
    /// What moves.
    pub plant: &'a Plant<f64>,
    /// Sensors and drive.
    pub sensors: RawSensors,
    /// Largest current of the drive, A.
    pub drive_limit_a: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// How long the body is held at its start before the controller is armed and the body let go,
    /// s; the filter aligns meanwhile.
    pub held_s: f64,
    /// Pushes on the body; time counts from the release.
    pub pushes: Vec<Push>,
    /// Seed of the sensors' noise.
    pub seed: u64,
}

impl<'a> RawLoop<'a> {
    /// `plant` with these sensors at 1 kHz and the drive of the thesis, held for 1 s.
    pub fn new(plant: &'a Plant<f64>, sensors: RawSensors, seed: u64) -> RawLoop<'a> {
        RawLoop {
            plant,
            sensors,
            drive_limit_a: Actuator::OF_THE_THESIS.limit_a,
            sample_time_s: 1e-3,
            held_s: 1.0,
            pushes: Vec::new(),
            seed,
        }
    }

    /// Holds the body at `angle_rad` from upright while the filter aligns, then arms `controller`
    /// and runs it for `duration_s`, or until the body is horizontal if `until_fall`. The measured
    /// angle of the record is the filter's, the measured wheel speed that of the converter's counts;
    /// the rate is the true one.
    ///
    /// # Errors
    /// Times that are not positive; emitted code that fails; a motion that is no longer finite.
    pub fn run(
        &self,
        angle_rad: f64,
        duration_s: f64,
        controller: &mut dyn RawController,
        until_fall: bool,
    ) -> Result<Trace, SimulateError> {
        let start = at_rest(angle_rad);
        let on = ClosedLoop {
            motion: Motion::Nonlinear(self.plant),
            sensors: crate::Sensors::PERFECT,
            actuator: Actuator {
                limit_a: self.drive_limit_a,
                step_a: 0.0,
            },
            sample_time_s: self.sample_time_s,
            computation_s: 0.0,
            pushes: self.pushes.clone(),
            seed: self.seed,
        };
        controller.reset();
        let held = (self.held_s / self.sample_time_s).round() as usize;
        let mut is_held = true;
        let sample = |instant: &Instant<'_>, random: &mut ChaCha8Rng| {
            if is_held {
                for _ in 0..held {
                    controller.step(&self.sensors.sample(&start, 0.0, random))?;
                }
                controller.arm()?;
                is_held = false;
            }
            let (acceleration, _) =
                self.plant
                    .derivative(instant.state, instant.flowing_a, instant.push);
            let counts = self.sensors.sample(instant.state, acceleration, random);
            let duty = controller.step(&counts)?;
            Ok(Answer {
                measured: Measured {
                    angle_rad: controller.angle_rad()?,
                    rate_rad_s: instant.state.rate_rad_s,
                    wheel_speed_rad_s: self.sensors.wheel_speed_rad_s(counts.wheel_adc),
                },
                command_a: self.sensors.current_a(duty),
            })
        };
        on.run_sampled(&start, duration_s, sample, |trace| {
            until_fall && trace.fell_at_s.is_some()
        })
        .map(|(trace, _)| trace)
    }

    /// The largest angle from which `controller` brings the body back, found to within
    /// `resolution_rad`.
    ///
    /// # Errors
    /// Those of [`RawLoop::run`]; a resolution that is not positive.
    pub fn largest_recoverable_angle(
        &self,
        scale: &Scale,
        controller: &mut dyn RawController,
        resolution_rad: f64,
    ) -> Result<Recovery, SimulateError> {
        bisect(scale, resolution_rad, |angle_rad| {
            self.run(angle_rad, decided_after_s(scale), controller, true)
                .map(|trace| trace.fell_at_s.is_none())
        })
    }
}
