//! Claim `physical-signs`: sensors, drive and law together push the body back upright.
//!
//! All words may be rounded correctly, and the motor may still be driven the wrong way: by a mirrored
//! sensor, a scale in g instead of m/s², a drive that is reversed in one place only. The following
//! conditions hold for every such bench:
//!
//! 1. All three sensors have the same handedness. No orientation of a chip is a mirror image, so the
//!    determinants of their matrices are positive.
//! 2. Gravity is 8 to 11.5 m/s² through the accelerometer's matrix (9.78 to 9.83 on Earth, with 15 %
//!    for an uncalibrated scale), at the counts that the part's own scale gives for one g. If
//!    no part is stated, the 16-bit word covers 1.2 to 40 g, as for all such sensors. The count at which an axis is said
//!    to clip is at least 1.2 g too, and gravity itself is stated as that of the Earth.
//! 3. A motor pushes forward, τ > 0: the plant's body accelerates backwards and its wheel forward.
//! 4. A body that leans or falls forward is pushed back: the raw counts of a lean of 1°, 3° and
//!    10° (rates of 0.2 and 1 rad/s), through attitude filter, law and drive, give a current that
//!    turns the body back.
//!    With an encoder on the pivot, its counts take the place of these, and 1, 2 and 5 do not apply.
//! 5. A sensor on the body is not far outside it: the lever arm is at most three times
//!    Θ g/G, the length of the simple pendulum with the same period (the end of a rod is at 1.5 times that).

use std::f64::consts::TAU;

use crate::certificate::hardware::{
    CertifiedBody, CertifiedBodyEncoder, CertifiedInertial, CertifiedSensor,
};
use crate::certificate::reader::Certificate;
use crate::claims::functions::Functions;
use crate::exact::rational::integer;
use crate::language::module::Module;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

type Check = Result<(), String>;

/// Standard gravity, m/s².
const G: f64 = 9.80665;
/// Allowed range of gravity as measured, m/s².
const GRAVITY_READS: [f64; 2] = [8.0, 11.5];
/// Allowed range of gravity as stated, m/s²: 9.76 to 9.84 on Earth, and 5 % for what a bench measures (judgement).
const GRAVITY_STATED: [f64; 2] = [9.3, 10.3];
/// Allowed range of the value of the largest 16-bit count, in g.
const REACH_G: [f64; 2] = [1.2, 40.0];
/// Largest lever arm, relative to the length of the simple pendulum with the same period.
const LEVER_ARM_MAX: f64 = 3.0;
/// Tested leans, rad.
const LEANS_RAD: [f64; 3] = [0.017_453, 0.052_36, 0.174_53];
/// Tested rates, rad/s.
const RATES_RAD_S: [f64; 2] = [0.2, 1.0];

/// A sensor as the certificate states it.
struct Sensor {
    bias: [f64; 3],
    matrix: [[f64; 3]; 3],
}

/// Checks all conditions.
///
/// # Errors
/// A sentence that names the contradiction.
pub fn check(certificate: &Certificate, module: &Module) -> Check {
    let inertial = match &certificate.hardware.body {
        CertifiedBody::Inertial(inertial) => inertial,
        CertifiedBody::Encoder(encoder) => {
            motor(certificate)?;
            return of_encoder(certificate, module, encoder);
        }
    };
    let gyro = Sensor::of(&inertial.gyroscope)?;
    let accel = Sensor::of(&inertial.accelerometer)?;
    let mag = Sensor::of(&inertial.magnetometer)?;
    for (name, sensor) in [
        ("gyroscope", &gyro),
        ("accelerometer", &accel),
        ("magnetometer", &mag),
    ] {
        let determinant = sensor.determinant();
        if determinant.is_nan() || determinant <= 0.0 {
            return Err(format!(
                "the {name}'s matrix is left-handed (determinant {determinant:.3e}): no turn of a \
                 sensor gives a mirror image"
            ));
        }
    }
    let scale = certificate
        .accelerometer_m_s2_per_count
        .as_ref()
        .map(|stated| real(&stated.value))
        .transpose()?;
    gravity(&accel, scale)?;
    let stated = real(&inertial.gravity_m_s2.value)?;
    if !(GRAVITY_STATED[0]..=GRAVITY_STATED[1]).contains(&stated) {
        return Err(format!(
            "gravity_m_s2 is {stated}: not that of any place on Earth"
        ));
    }
    clips(&accel, &inertial.accelerometer)?;
    motor(certificate)?;
    lever_arm(certificate, inertial)?;
    restoring(certificate, module, inertial, &gyro, &accel)
}

/// The current after a lean or a rate of the body: its counts pass through every word.
fn of_encoder(certificate: &Certificate, module: &Module, encoder: &CertifiedBodyEncoder) -> Check {
    let f = Functions(module);
    let per_rad = real(&encoder.counts_per_turn.value)? / TAU;
    let wrap = 2f64.powi(encoder.bits as i32);
    let current = Current::new(certificate, &f)?;
    let command = |angle: i128, rate: i128| current.of(angle, rate);
    let upright = f.call("body_angle", &[encoder.zero.into()])?[0];
    let at_rest = f.call("body_rate", &[0])?[0];
    let count = |lean: f64| {
        let counts = (lean * per_rad).round();
        (f64::from(encoder.zero) + counts).rem_euclid(wrap) as i128
    };
    for lean in LEANS_RAD.into_iter().flat_map(|lean| [lean, -lean]) {
        let angle = f.call("body_angle", &[count(lean)])?[0];
        // A lean below half a count is none.
        if (lean * per_rad).round() != 0.0 {
            pushes_back(lean, command(angle, at_rest)?)?;
        }
    }
    let window_s = f64::from(encoder.window) * real(&certificate.sample_time_s.value)?;
    for rate in RATES_RAD_S.into_iter().flat_map(|rate| [rate, -rate]) {
        let turned = (rate * window_s * per_rad).round();
        if turned != 0.0 {
            let word = f.call("body_rate", &[turned as i128])?[0];
            slows_down(rate, command(upright, word)?)?;
        }
    }
    Ok(())
}

/// The command of the law at a wheel that stands still, as a current of the drive.
struct Current<'a> {
    certificate: &'a Certificate,
    f: &'a Functions<'a>,
    speed: i128,
}

impl<'a> Current<'a> {
    fn new(certificate: &'a Certificate, f: &'a Functions<'a>) -> Result<Current<'a>, String> {
        let wheel = &certificate.hardware.wheel_speed;
        if wheel.rad_s_per_count.value.is_zero() {
            return Err("a count of the wheel's speed is no speed".to_owned());
        }
        let at_rest = -&wheel.rad_s_at_zero.value / &wheel.rad_s_per_count.value;
        let at_rest = at_rest.round().to_integer().to_i128();
        let at_rest = at_rest.unwrap_or(0).clamp(0, 65_535);
        if certificate.drive.voltage.is_some() {
            back_emf(certificate, f)?;
        }
        Ok(Current {
            certificate,
            f,
            speed: f.call("wheel_speed", &[at_rest])?[0],
        })
    }

    /// The current in A for the words of angle and rate. At rest, the duty of a voltage drive acts on the resistance of
    /// the winding alone.
    fn of(&self, angle: i128, rate: i128) -> Result<f64, String> {
        let drive = &self.certificate.drive;
        let zero = integer(drive.duty_zero.into());
        let command = self.f.call("control", &[angle, rate, self.speed])?;
        let duty = duty(self.certificate, self.f, command[0], self.speed)?;
        real(&((integer(duty) - &zero) * &drive.amperes_per_count.value))
    }
}

fn pushes_back(lean: f64, current: f64) -> Check {
    if current * lean <= 0.0 {
        return Err(format!(
            "a lean of {:.0}° gives a current of {current:.4} A, which pushes the body on: the \
             sign of an axis, of the drive or of a gain is wrong",
            lean.to_degrees()
        ));
    }
    Ok(())
}

fn slows_down(rate: f64, current: f64) -> Check {
    if current * rate <= 0.0 {
        return Err(format!(
            "a rate of {rate} rad/s gives a current of {current:.4} A, which speeds the body up: \
             the sign of the body's rate, of the drive or of a gain is wrong"
        ));
    }
    Ok(())
}

fn real(value: &BigRational) -> Result<f64, String> {
    let value = value.to_f64().filter(|value| value.is_finite());
    value.ok_or_else(|| "a number of the certificate does not fit a double".to_owned())
}

impl Sensor {
    fn of(stated: &CertifiedSensor) -> Result<Sensor, String> {
        let mut sensor = Sensor {
            bias: [0.0; 3],
            matrix: [[0.0; 3]; 3],
        };
        for axis in 0..3 {
            sensor.bias[axis] = real(&stated.bias_counts[axis].value)?;
            for column in 0..3 {
                sensor.matrix[axis][column] = real(&stated.matrix[axis][column].value)?;
            }
        }
        Ok(sensor)
    }

    fn minor(&self, row: usize, column: usize) -> f64 {
        let m = &self.matrix;
        let (a, b) = ((row + 1) % 3, (row + 2) % 3);
        let (c, d) = ((column + 1) % 3, (column + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    }

    fn determinant(&self) -> f64 {
        (0..3)
            .map(|column| self.matrix[0][column] * self.minor(0, column))
            .sum()
    }

    /// The counts for `value`.
    fn counts(&self, value: [f64; 3]) -> [i128; 3] {
        let determinant = self.determinant();
        [0, 1, 2].map(|axis| {
            let sum: f64 = (0..3).map(|row| self.minor(row, axis) * value[row]).sum();
            let count = (sum / determinant + self.bias[axis]).round();
            count.clamp(-32_768.0, 32_767.0) as i128
        })
    }

    /// Length of the vector that one count of an axis represents.
    fn per_count(&self, axis: usize) -> f64 {
        self.matrix
            .iter()
            .map(|row| row[axis] * row[axis])
            .sum::<f64>()
            .sqrt()
    }
}

fn gravity(accel: &Sensor, scale: Option<f64>) -> Check {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let per_count = accel.per_count(axis);
        if let Some(scale) = scale {
            let reads = G / scale * per_count;
            if !(GRAVITY_READS[0]..=GRAVITY_READS[1]).contains(&reads) {
                return Err(format!(
                    "along the accelerometer's {name} axis gravity would read {reads:.2} m/s2: the \
                     matrix is not that of a sensor with {scale} m/s2 per count"
                ));
            }
        }
        let reach = 32_768.0 * per_count / G;
        if !(REACH_G[0]..=REACH_G[1]).contains(&reach) {
            return Err(format!(
                "the accelerometer's {name} axis would reach {reach:.3} g: no such sensor does; its \
                 scale is to be in m/s2 per count"
            ));
        }
    }
    Ok(())
}

/// An accelerometer shows gravity and a fifth more before it clips.
fn clips(accel: &Sensor, stated: &CertifiedSensor) -> Check {
    for (axis, clip) in stated.clip_counts.iter().enumerate() {
        let reach = f64::from(*clip) * accel.per_count(axis) / G;
        if reach < REACH_G[0] {
            return Err(format!(
                "the accelerometer would clip at {clip} counts, {reach:.3} g: it could not show gravity and a motion"
            ));
        }
    }
    Ok(())
}

fn motor(certificate: &Certificate) -> Check {
    let torque = certificate
        .parameters
        .iter()
        .find(|parameter| parameter.name == "torque_constant");
    if let Some(torque) = torque
        && !torque.value.value.is_positive()
    {
        return Err(format!(
            "torque_constant is {}: a motor pushes forward with a positive current",
            torque.value
        ));
    }
    let b = &certificate.plant.b;
    if !(b[1].value.is_negative() && b[2].value.is_positive()) {
        return Err(
            "a positive current does not push the body back and the wheel forward".to_owned(),
        );
    }
    Ok(())
}

fn lever_arm(certificate: &Certificate, hardware: &CertifiedInertial) -> Check {
    let parameter = |name: &str| {
        let mut found = certificate.parameters.iter();
        let found = found.find(|parameter| parameter.name == name)?;
        // If values are per unit of inertia, the lengths are unknown.
        (!found.unit.contains("per kg")).then(|| real(&found.value.value).ok())?
    };
    let (Some(inertia), Some(torque)) = (parameter("total_inertia"), parameter("gravity_torque"))
    else {
        return Ok(());
    };
    let length = inertia * real(&hardware.gravity_m_s2.value)? / torque;
    let [x, y] = &hardware.lever_arm_m;
    let arm = real(&x.value)?.hypot(real(&y.value)?);
    if arm > LEVER_ARM_MAX * length {
        return Err(format!(
            "the accelerometer would sit {arm:.3} m from the pivot, on a body that swings like a \
             simple pendulum of {length:.3} m"
        ));
    }
    Ok(())
}

/// The duty of a command.
fn duty(
    certificate: &Certificate,
    f: &Functions,
    command: i128,
    speed: i128,
) -> Result<i128, String> {
    let words = match certificate.drive.voltage {
        Some(_) => f.call("duty", &[command, speed])?,
        None => f.call("duty", &[command])?,
    };
    Ok(words[0])
}

/// At a wheel that turns, a voltage drive holds against the back-EMF: the voltage without a current has the sign of the
/// speed. With the wrong sign, the voltage would add to the back-EMF instead of cancelling it, and the current would be
/// twice that of the back-EMF alone.
fn back_emf(certificate: &Certificate, f: &Functions) -> Check {
    let wheel = &certificate.hardware.wheel_speed;
    let zero = integer(certificate.drive.duty_zero.into());
    for end in [wheel.low_counts, wheel.high_counts] {
        let counts = integer(end.into());
        let true_speed = &wheel.rad_s_per_count.value * counts + &wheel.rad_s_at_zero.value;
        let speed = f.call("wheel_speed", &[end.into()])?;
        let duty = duty(certificate, f, 0, speed[0])?;
        let volts = (integer(duty) - &zero) * &certificate.drive.amperes_per_count.value;
        if !(volts * true_speed).is_positive() {
            return Err(
                "a voltage drive would drive with the motor's back-EMF, not against it: the sign of the wheel's speed \
                 or of the drive is wrong"
                    .to_owned(),
            );
        }
    }
    Ok(())
}

/// Raw counts of a body that leans or falls, through every word, to the current.
fn restoring(
    certificate: &Certificate,
    module: &Module,
    hardware: &CertifiedInertial,
    gyro: &Sensor,
    accel: &Sensor,
) -> Check {
    let f = Functions(module);
    let mounting = real(&hardware.mounting_angle_rad.value)?;
    let drive = Current::new(certificate, &f)?;
    let current = |attitude: &[i128]| -> Result<f64, String> {
        let angle = f.call("Attitude::angle", attitude)?;
        let rate = f.call("Attitude::rate", attitude)?;
        drive.of(angle[0], rate[0])
    };
    let up = |lean: f64| {
        let (sin, cos) = (lean + mounting).sin_cos();
        [G * cos, -G * sin, 0.0]
    };
    let new = f.call("Attitude::new", &[])?;
    for lean in LEANS_RAD.into_iter().flat_map(|lean| [lean, -lean]) {
        let reading = accel.counts(up(lean));
        let aligned = f.call("Attitude::align", &[&new[..], &reading].concat())?;
        let attitude = &aligned[1..];
        let still = [attitude, &gyro.counts([0.0; 3]), &reading].concat();
        let attitude = f.call("Attitude::update_imu", &still)?;
        pushes_back(lean, current(&attitude)?)?;
    }
    for rate in RATES_RAD_S.into_iter().flat_map(|rate| [rate, -rate]) {
        let reading = accel.counts(up(0.0));
        let aligned = f.call("Attitude::align", &[&new[..], &reading].concat())?;
        let falling = [&aligned[1..], &gyro.counts([0.0, 0.0, rate]), &reading].concat();
        let attitude = f.call("Attitude::update_imu", &falling)?;
        slows_down(rate, current(&attitude)?)?;
    }
    Ok(())
}
