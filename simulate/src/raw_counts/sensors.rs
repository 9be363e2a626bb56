//! The simulated bench's sensors, which read counts, and its drive.

use super::controller::RawSample;
use crate::error::{SimulateError, check_positive};
use crate::sensors::from_upright_rad;
use attitude::{AttitudeSpec, STANDARD_GRAVITY, SensorLine};
use nalgebra::{Matrix3, Vector3};
use plant::State;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// A three-axis sensor from SI units to counts: counts = `per_unit` · value + `bias_counts`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CountsLine {
    /// Counts per SI unit.
    pub per_unit: Matrix3<f64>,
    /// Reading at zero input, counts.
    pub bias_counts: Vector3<f64>,
}

impl CountsLine {
    /// The sensor that `line` calibrates perfectly, except for a bias of `left_counts` on each axis.
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

    /// The counts of `value`, saturated at the ends of a 16-bit word.
    fn read(&self, value: Vector3<f64>) -> [i16; 3] {
        let counts = self.per_unit * value + self.bias_counts;
        // A cast saturates, as the converter does.
        [0, 1, 2].map(|axis| counts[axis].round() as i16)
    }
}

/// The true properties of the sensors in counts and of the drive. The controller's own constants describe
/// what it assumes about them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawSensors {
    /// The encoder on the pivot, where there is one. Its angle zero is upright.
    pub body: Option<EncoderOutput>,
    /// Gyroscope, 16 bit.
    pub gyro: CountsLine,
    /// Standard deviation of the gyroscope's noise in one sample, rad/s.
    pub gyro_noise_rad_s: f64,
    /// Accelerometer, 16 bit.
    pub accel: CountsLine,
    /// Standard deviation of the accelerometer's noise in one sample, m/s².
    pub accel_noise_m_s2: f64,
    /// Gravity, m/s².
    pub gravity_m_s2: f64,
    /// Position of the accelerometer relative to the pivot axis, along the aligned sensor's x and y, m.
    pub lever_arm_m: [f64; 2],
    /// Angle about the pivot axis from the body's axis to the sensor's x axis, rad.
    pub mounting_angle_rad: f64,
    /// The wheel's sensor.
    pub wheel: WheelOutput,
    /// Wheel speed per count of converter or driver, rad/s.
    pub wheel_speed_per_count: f64,
    /// Wheel speed at zero counts, rad/s.
    pub wheel_speed_at_zero: f64,
    /// Standard deviation of the noise of the wheel speed in one sample, rad/s.
    pub wheel_noise_rad_s: f64,
    /// Standard deviation of the noise of encoders in one sample, counts.
    pub encoder_noise_counts: f64,
    /// Duty at zero current, counts.
    pub duty_zero: u16,
    /// Current per count of duty, A.
    pub current_per_count_a: f64,
    /// The drive, where it sets a voltage and not a current.
    pub voltage: Option<VoltageOutput>,
}

/// How the wheel's speed is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WheelOutput {
    /// A converter's counts, from zero to this.
    Converter(u16),
    /// A driver's signed 16-bit word.
    Driver,
    /// An absolute encoder on the wheel.
    Encoder(EncoderOutput),
}

/// An absolute encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderOutput {
    /// Counts per turn; negative if they fall while the angle rises.
    pub counts_per_turn: f64,
    /// The count begins again at zero after 2^`bits`.
    pub bits: u32,
    /// The count at the angle zero.
    pub zero_count: f64,
}

impl EncoderOutput {
    fn count(&self, angle_rad: f64, noise_counts: f64) -> u16 {
        let wrap = f64::from(1_u32 << self.bits);
        let counts = angle_rad / TAU * self.counts_per_turn + self.zero_count + noise_counts;
        // A count that is rounded up to the whole range is the count zero.
        (counts.round().rem_euclid(wrap)) as u16
    }
}

/// A drive that sets the voltage across the winding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoltageOutput {
    /// V per count of duty.
    pub volts_per_count: f64,
    /// Winding resistance, Ω.
    pub winding_ohm: f64,
    /// Back-EMF, V s/rad.
    pub back_emf_v_s: f64,
}

impl RawSensors {
    /// Sensors that `spec` calibrates and mounts correctly, with converter and drive of the thesis:
    /// 12 bit with rpm = 8.53108 count − 6594.5; 10 % to 90 % of a 16-bit duty for ∓2.2 A.
    ///
    /// Two values are assumed, since the thesis does not state them. The noise: densities of the data sheets over 500
    /// Hz (0.025 °/s/√Hz and 126 µg/√Hz), 0.6 rad/s on the wheel. The remaining bias after calibration: 0.1 °/s and 1
    /// mg on each axis (1.6 and 4.1 counts of the thesis' sensors).
    ///
    /// # Errors
    /// A sensor's matrix without inverse.
    pub fn calibrated_by(spec: &AttitudeSpec) -> Result<RawSensors, SimulateError> {
        let rpm = TAU / 60.0;
        let root_bandwidth = 500.0_f64.sqrt();
        let left = Vector3::new(1.0, -1.0, 1.0);
        Ok(RawSensors {
            body: None,
            gyro: CountsLine::calibrated_by(&spec.gyro, left * 1.6)?,
            gyro_noise_rad_s: 0.025_f64.to_radians() * root_bandwidth,
            accel: CountsLine::calibrated_by(&spec.accel, left * 4.1)?,
            accel_noise_m_s2: 126e-6 * STANDARD_GRAVITY * root_bandwidth,
            gravity_m_s2: spec.gravity_m_s2,
            lever_arm_m: spec.lever_arm_m,
            mounting_angle_rad: spec.mounting_angle_rad,
            wheel: WheelOutput::Converter(4095),
            wheel_speed_per_count: 8.53108 * rpm,
            wheel_speed_at_zero: -6594.5 * rpm,
            wheel_noise_rad_s: 0.6,
            encoder_noise_counts: 0.5,
            duty_zero: 32_768,
            current_per_count_a: 2.2 / 26_214.0,
            voltage: None,
        })
    }

    /// The hardware of the thesis: gyroscope FXAS21002 at ±2000 °/s (62.5 m°/s per count),
    /// accelerometer FXOS8700 at 4096 counts/g, the rest as in [`RawSensors::calibrated_by`]. The
    /// sensor sits 50 mm from the pivot towards the wheel; the filter does not correct for that.
    ///
    /// # Errors
    /// Never: the matrices are diagonal.
    pub fn of_the_thesis() -> Result<RawSensors, SimulateError> {
        Ok(RawSensors {
            lever_arm_m: [0.05, 0.0],
            ..RawSensors::calibrated_by(&AttitudeSpec::thesis())?
        })
    }

    /// The counts in `state`, with the body's angular acceleration `acceleration_rad_s2`.
    ///
    /// The accelerometer measures the reaction to gravity and the acceleration of its own position r,
    /// α̈ (−r_y, r_x) − α̇² r (see crate `attitude`, lever arm). The upward direction is
    /// (cos(θ + m), −sin(θ + m)) at the angle θ from upright.
    pub fn sample(
        &self,
        state: &State<f64>,
        acceleration_rad_s2: f64,
        random: &mut ChaCha8Rng,
    ) -> RawSample {
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
        let counts = (speed - self.wheel_speed_at_zero) / self.wheel_speed_per_count;
        let wheel = match &self.wheel {
            WheelOutput::Converter(most) => counts.round().clamp(0.0, f64::from(*most)) as i32,
            WheelOutput::Driver => i32::from(counts.round() as i16),
            WheelOutput::Encoder(encoder) => {
                let noise = self.encoder_noise_counts * noise();
                i32::from(encoder.count(state.wheel_angle_rad, noise))
            }
        };
        let body = self.body.map_or(0, |encoder| {
            let noise = self.encoder_noise_counts * noise();
            encoder.count(from_upright_rad(state.angle_rad), noise)
        });
        RawSample {
            body,
            gyro: self.gyro.read(rate),
            accel: self.accel.read(force),
            mag: None,
            wheel,
        }
    }

    /// The current in A that a duty commands; for a voltage drive, the current at standstill.
    pub fn current_a(&self, duty: u16) -> f64 {
        (f64::from(duty) - f64::from(self.duty_zero)) * self.current_per_count_a
    }

    /// The mean current in A over a sample of `period_s` that begins with the wheel at `speed_rad_s`. A current drive
    /// delivers the commanded current. With a voltage drive the current falls while the wheel speeds up; `acceleration`
    /// gives the wheel's acceleration as a straight line over the current (rad/s² for A).
    pub(super) fn mean_current_a(
        &self,
        duty: u16,
        speed_rad_s: f64,
        period_s: f64,
        acceleration: impl Fn(f64) -> f64,
    ) -> f64 {
        let Some(drive) = &self.voltage else {
            return self.current_a(duty);
        };
        let counts = f64::from(duty) - f64::from(self.duty_zero);
        let (without, with_one) = (acceleration(0.0), acceleration(1.0));
        let half_s = 0.5 * period_s;
        let left_v =
            counts * drive.volts_per_count - drive.back_emf_v_s * (speed_rad_s + half_s * without);
        left_v / (drive.winding_ohm + drive.back_emf_v_s * half_s * (with_one - without))
    }

    /// The wheel speed that a single sample shows; `None` for an encoder, which needs two counts for a speed.
    pub(super) fn wheel_speed_rad_s(&self, wheel: i32) -> Option<f64> {
        match self.wheel {
            WheelOutput::Encoder(_) => None,
            _ => Some(f64::from(wheel) * self.wheel_speed_per_count + self.wheel_speed_at_zero),
        }
    }
}
