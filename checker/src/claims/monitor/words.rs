//! The words of `MOTION_LIMITS`, from the certificate's plant, parameters, sensors and drive.
//!
//! The monitor keeps two sums: one for the wheel's own speed (body rate plus wheel speed), one for the body's rate. In
//! each step the residual r (rad/s) is the measured change of the speed minus the change that the sampled model
//! predicts, and the sum becomes s⁺ = (1 − 2⁻ᵐ) s + r, where m is `MOTION_LIMITS.leak`. A constant r adds up to 2ᵐ r.
//!
//! A sound bench stays within the limits, because they are the sum of these bounds:
//!
//! - **Sensor errors.** An error n enters the measured change as n⁺ − n, which adds up to at most 2 max |n|. It also
//!   enters the prediction, with the entry a of the model's row, by at most |a n| per step: 2ᵐ |a| max |n|.
//! - **Torques of bounded size** (friction, cogging, dead zone, offset of the current) change the speed by at most a
//!   constant amount per step, which adds up to 2ᵐ times this amount.
//! - **A late current.** A current that acts up to two steps late (`LATE_STEPS`) adds at most two steps of the largest
//!   current to the sum. The remembered part of the current's effect is off by the share (1 − 2⁻ᵐ)⁻² − 1, which the
//!   width includes.
//! - **Errors of the model's numbers.** An entry of a row with the relative error e is off by e times its product with
//!   state or current. The width adds up these amounts with the same leak.
//! - **One push** changes the body's rate once.
//! - **An encoder on the wheel** shows the mean speed over its window. This speed is off by at most half the window
//!   times the wheel's largest acceleration, and by the rounding of two counts. The largest acceleration is that of
//!   the model with all widths and torques at the ends of angle, rate, wheel speed and drive. The encoder shows a push
//!   only after the window, so that the wheel's sum contains the push once.
//!
//! This file derives all numbers independently of the generator.

use num_traits::ToPrimitive;

use crate::certificate::reader::{Certificate, StatedDecimal};
use crate::claims::control_law::EmittedLaw;
use crate::claims::held_loop::HeldLoop;
use crate::language::module::Module;

/// The memory 2ᵐ T of the sums (s), where T is the sample time. The emitted one may differ by a factor of √2, because
/// m is a whole number.
const MEMORY_S: f64 = 0.1;
/// Largest noise of a sensor, in standard deviations.
const NOISE_STDS: f64 = 8.0;
/// Largest error of the attitude filter's angle, in addition to its noise (rad).
const ANGLE_ERROR_RAD: f64 = 0.02;
/// Relative error of a parameter whose standard error is not stated.
const UNSTATED_SHARE: f64 = 0.1;
/// Relative error of an entry of a row by sampling and rounding. Each limit has the same number as an allowance in
/// rad/s.
const ROW_SHARE: f64 = 0.01;
/// Largest number of steps by which the current acts later than the model predicts.
const LATE_STEPS: f64 = 2.0;
/// Fraction bits of a sum.
const SUM_BITS: i32 = 16;
/// Relative tolerance for the rounding of this file's own double precision.
const TOLERANCE: f64 = 1e-6;

/// The parameters that a module with a monitor may have: those of the linear model, and those of torques of bounded
/// size.
const KNOWN: [&str; 17] = [
    "total_inertia",
    "wheel_inertia",
    "body_inertia",
    "gravity_torque",
    "torque_constant",
    "body_viscous_friction",
    "wheel_viscous_friction",
    "body_coulomb_torque",
    "body_breakaway_torque",
    "body_stribeck_speed",
    "body_presliding_stiffness",
    "wheel_coulomb_torque",
    "cogging_torque",
    "cogging_order",
    "cogging_phase",
    "current_offset",
    "dead_zone",
];

/// Checks every word of `MOTION_LIMITS`, and returns the limits of the wheel's and the body's sum in rad/s.
///
/// # Errors
/// A sentence that names the wrong word and the right value.
pub fn check(
    certificate: &Certificate,
    module: &Module,
    law: &EmittedLaw,
) -> Result<[f64; 2], String> {
    let stated = certificate.monitor.as_ref();
    let stated = stated.ok_or("the certificate has no section monitor")?;
    let words = module
        .constant_words("monitor_words", "MOTION_LIMITS")
        .ok_or("src/monitor_words.rs has no MOTION_LIMITS")?;
    let word = |name: &str| -> Result<f64, String> {
        let name = format!("MOTION_LIMITS.{name}");
        let found = words.iter().find(|(known, _)| *known == name);
        // Words of 32 bits are exact in double precision.
        found
            .map(|(_, word)| *word as f64)
            .ok_or_else(|| format!("src/monitor_words.rs has no {name}"))
    };
    let real = |number: &StatedDecimal| number.value.to_f64().unwrap_or(f64::NAN);
    let wanted = Wanted::of(certificate, stated.noise_std.each_ref().map(real))?;

    let period = real(&certificate.sample_time_s);
    let leak = word("leak")?;
    let memory_s = leak.exp2() * period;
    let is_clamped = leak == 1.0 && memory_s > MEMORY_S || leak == 12.0 && memory_s < MEMORY_S;
    let ratio = (memory_s / MEMORY_S).log2().abs();
    if !(1.0..=12.0).contains(&leak) || (ratio > 0.5 + TOLERANCE && !is_clamped) {
        return Err(format!(
            "MOTION_LIMITS.leak is {leak}, which is a memory of {memory_s} s; it must be a whole number from 1 to 12, \
             for a memory of {MEMORY_S} s within a factor of √2"
        ));
    }
    let shift = word("shift")?;
    if !(1.0..=62.0).contains(&shift) {
        return Err(format!(
            "MOTION_LIMITS.shift is {shift}; it must be 1 to 62"
        ));
    }
    let scale = shift + f64::from(SUM_BITS);
    let unit = |bits: u32| (scale - f64::from(bits)).exp2();
    let units = [
        ("angle", unit(law.state_bits[0])),
        ("rate", unit(law.state_bits[1])),
        ("wheel_speed", unit(law.state_bits[2])),
        (
            "duty",
            scale.exp2() * real(&certificate.drive.amperes_per_count),
        ),
    ];
    let is = |name: &str, low: f64, high: f64| -> Result<(), String> {
        let found = word(name)?;
        let more = TOLERANCE * low.abs().max(high.abs());
        if low - more <= found && found <= high + more {
            Ok(())
        } else {
            Err(format!(
                "MOTION_LIMITS.{name} is {found}; by the certificate it must be {low:.2} to {high:.2}"
            ))
        }
    };
    is("rate", units[1].1, units[1].1)?;
    is("wheel_speed", units[2].1, units[2].1)?;
    let found = wanted.rows(leak)?;
    for (name, row) in [("wheel", &found.wheel), ("body", &found.body)] {
        for (value, (column, unit)) in row.iter().zip(units) {
            let exact = value * unit;
            is(&format!("{name}.{column}"), exact - 0.5, exact + 0.5)?;
        }
    }
    let widths = [
        ("wheel_width", &found.wheel_width),
        ("body_width", &found.body_width),
    ];
    for (name, row) in widths {
        for (value, (column, unit)) in row.iter().zip(units) {
            let exact = value * unit.abs();
            is(&format!("{name}.{column}"), exact + 1.0, exact + 2.0)?;
        }
    }
    let sum_unit = f64::from(SUM_BITS).exp2();
    let rest = 2.0 * leak.exp2();
    let limits = [
        ("wheel_limit", found.limits[0], &stated.wheel_limit_rad_s),
        ("body_limit", found.limits[1], &stated.body_limit_rad_s),
    ];
    for (name, value, said) in limits {
        let exact = value * sum_unit;
        is(name, exact + rest, exact + rest + 1.0)?;
        if (real(said) - value).abs() > TOLERANCE * value {
            return Err(format!(
                "the certificate states {name}_rad_s = {said}; by its other numbers it must be {value}"
            ));
        }
    }
    if (real(&stated.push_rad_s) - wanted.push_rad_s).abs() > TOLERANCE * wanted.push_rad_s {
        return Err(format!(
            "the certificate states push_rad_s = {}; by its other numbers it must be {}",
            stated.push_rad_s, wanted.push_rad_s
        ));
    }
    Ok(found.limits)
}

/// The numbers behind the words, derived from the certificate, in SI units.
struct Wanted {
    /// Change of the body's rate (rad/s) in a step: per rad, per rad/s (body), per rad/s (wheel), per A.
    body: [f64; 4],
    /// Change of the wheel's own speed (rad/s) in a step, per the same units.
    wheel: [f64; 4],
    /// Largest errors of angle (rad), rate and wheel speed (rad/s).
    errors: [f64; 3],
    /// Relative errors of gravity, motor and wheel friction in the body's row.
    on_body: [f64; 3],
    /// Relative errors of motor and friction in the wheel's row.
    on_wheel: [f64; 2],
    /// Bounds of the torques that the linear model lacks, as accelerations of wheel and body (rad/s²).
    torques: [f64; 2],
    /// Largest relative difference between gravity's torque and its linear form, at the largest angle.
    sine: f64,
    /// Change of the body's rate by one push (rad/s).
    push_rad_s: f64,
    /// With an encoder on the wheel: half its window (s), and the largest angle (rad), rate and wheel speed (rad/s).
    window: Option<(f64, [f64; 3])>,
    /// Largest held input (A): the current limit, or the supply voltage over the winding's resistance.
    most_a: f64,
    /// Sample time (s).
    period_s: f64,
}

/// The rows and their widths, as in [`Wanted::body`], and the limits of the wheel's and the body's sum (rad/s).
struct Rows {
    body: [f64; 4],
    wheel: [f64; 4],
    body_width: [f64; 4],
    wheel_width: [f64; 4],
    limits: [f64; 2],
}

impl Wanted {
    fn of(certificate: &Certificate, noise_std: [f64; 3]) -> Result<Wanted, String> {
        let real = |number: &StatedDecimal| number.value.to_f64().unwrap_or(f64::NAN);
        let parameters = &certificate.parameters;
        if let Some(other) = parameters
            .iter()
            .find(|p| !KNOWN.contains(&p.name.as_str()))
        {
            return Err(format!(
                "no bound is known for the motion that the parameter `{}` describes, so that the module may have no \
                 monitor",
                other.name
            ));
        }
        let find = |name: &str| parameters.iter().find(|parameter| parameter.name == name);
        let value = |name: &str| find(name).map_or(0.0, |found| real(&found.value));
        let share = |name: &str| -> f64 {
            let stated = find(name).and_then(|found| Some((found.std.as_ref()?, &found.value)));
            match stated {
                Some((std, value)) if real(value) != 0.0 => 3.0 * real(std) / real(value).abs(),
                _ => UNSTATED_SHARE,
            }
        };
        let (whole, wheel_inertia) = (value("total_inertia"), value("wheel_inertia"));
        let body_inertia = whole - wheel_inertia;
        let body_share = (share("total_inertia") * whole + share("wheel_inertia") * wheel_inertia)
            / body_inertia;
        let over = |above: f64, below: f64| (1.0 + above) / (1.0 - below) - 1.0;
        let is_known = |share: f64| (0.0..0.5).contains(&share);
        let wheel_share = share("wheel_inertia");
        let are_known = wheel_inertia > 0.0
            && body_inertia > 0.0
            && is_known(body_share)
            && is_known(wheel_share);
        if !are_known {
            return Err(
                "the inertias of wheel and body must be positive, and three standard errors of each must be less \
                 than half of it"
                    .to_owned(),
            );
        }
        let (mut torque, mut friction) =
            (share("torque_constant"), share("wheel_viscous_friction"));
        if certificate.drive.voltage.is_some() {
            // The winding's resistance R changes with its temperature: it is known to UNSTATED_SHARE. The back-EMF
            // brakes the wheel like a viscous friction τ²/R.
            let hot = over(0.0, UNSTATED_SHARE);
            friction = friction.max((1.0 + torque) * (1.0 + torque) * (1.0 + hot) - 1.0);
            torque = over(torque, UNSTATED_SHARE);
        }
        let motor = value("torque_constant").abs()
            * (value("dead_zone").abs() + value("current_offset").abs());
        let on_wheel = value("wheel_coulomb_torque").abs() + value("cogging_torque").abs() + motor;
        let on_body = value("body_coulomb_torque")
            .abs()
            .max(value("body_breakaway_torque").abs());

        let plant = &certificate.plant;
        let held = HeldLoop::of(certificate);
        let step = |row: usize, column: usize| {
            let entry = held.ad[row][column].to_f64().unwrap_or(f64::NAN);
            entry - f64::from(u8::from(row == column))
        };
        let number = |entry: &num_rational::BigRational| entry.to_f64().unwrap_or(f64::NAN);
        let input = held.bd.each_ref().map(number);
        let limit = certificate.constant("CURRENT_LIMIT");
        let limit_a = real(&limit.ok_or("the certificate has no CURRENT_LIMIT")?.real);
        let (fall, push) = (real(&plant.a[1][0]), real(&plant.b[1]).abs() * limit_a);
        if fall.is_nan() || fall <= 0.0 {
            return Err(
                "the body does not fall in the certificate's model: row 2, column 1 of A must be positive".to_owned(),
            );
        }
        // The angle at which the supervisor trips: twice the angle at which the current holds the body, at most 60°.
        let most = core::f64::consts::FRAC_PI_3.min(real(&certificate.inputs[0].range));
        let holds = (push / fall).min(0.99).asin();
        let holds = if holds > 0.0 { holds } else { most };
        let angle = (2.0 * holds).min(most);
        let inertial = certificate.hardware.inertial();
        let inertial = inertial.ok_or("a monitor needs gyroscope and accelerometer")?;
        let gyro = inertial.gyroscope.matrix[2].each_ref().map(real);
        let converter = real(&certificate.hardware.wheel_speed.rad_s_per_count).abs();
        let count = gyro.iter().map(|entry| entry.abs()).sum::<f64>();
        let period_s = real(&certificate.sample_time_s);
        let encoder = certificate.hardware.wheel_speed.encoder.as_ref();
        let range = |index: usize| real(&certificate.inputs[index].range);
        let window = encoder.map(|encoder| {
            let half_s = f64::from(encoder.window) * period_s / 2.0;
            (half_s, [angle, range(1), range(2)])
        });
        // A converter's speed is one reading; an encoder's speed is the difference of two. Each is off by half a count.
        let readings = if window.is_some() { 2.0 } else { 1.0 };
        Ok(Wanted {
            body: [step(1, 0), step(1, 1), step(1, 2), input[1]],
            wheel: [
                step(1, 0) + step(2, 0),
                step(1, 1) + step(2, 1),
                step(1, 2) + step(2, 2),
                input[1] + input[2],
            ],
            errors: [
                NOISE_STDS * noise_std[0] + ANGLE_ERROR_RAD,
                NOISE_STDS * noise_std[1] + count / 2.0,
                NOISE_STDS * noise_std[2] + readings * converter / 2.0,
            ],
            on_body: [
                over(share("gravity_torque"), body_share) + ROW_SHARE,
                over(torque, body_share) + ROW_SHARE,
                over(friction, body_share) + ROW_SHARE,
            ],
            on_wheel: [
                over(torque, wheel_share) + ROW_SHARE,
                over(friction, wheel_share) + ROW_SHARE,
            ],
            // The true inertias may be as small as half of the stated ones.
            torques: [
                2.0 * on_wheel / wheel_inertia,
                2.0 * (on_wheel + on_body) / body_inertia,
            ],
            sine: angle * angle / 6.0,
            push_rad_s: push / fall.sqrt(),
            most_a: held.reach.as_ref().map_or(limit_a, number),
            period_s,
            window,
        })
    }

    fn rows(&self, leak: f64) -> Result<Rows, String> {
        let memory = leak.exp2();
        let late = (1.0 - 1.0 / memory).powf(-LATE_STEPS) - 1.0;
        let magnitude = |row: &[f64; 4]| row.map(f64::abs);
        let (body, wheel) = (magnitude(&self.body), magnitude(&self.wheel));
        let [gravity, motor, friction] = self.on_body;
        let widths_of_body = [
            body[0] * (gravity + self.sine),
            2.0 * body[1],
            body[2] * friction,
            body[3] * (motor + late),
        ];
        let widths_of_wheel = [
            wheel[0],
            wheel[1],
            wheel[2] * self.on_wheel[1],
            wheel[3] * (self.on_wheel[0] + late),
        ];
        let mut errors = self.errors;
        let mut pushed = 0.0;
        if let Some((half_s, ends)) = self.window {
            // A bound of the wheel's acceleration relative to the body (rad/s²): all states and the drive at their
            // ends.
            let mut most = self.torques[0] + self.torques[1];
            let all = [ends[0], ends[1], ends[2], self.most_a];
            for (column, end) in all.into_iter().enumerate() {
                let nominal = (self.wheel[column] - self.body[column]).abs();
                let width = widths_of_wheel[column] + widths_of_body[column];
                most += end * (nominal + width) / self.period_s;
            }
            errors[2] += most * half_s;
            // The encoder shows a push only after its window.
            pushed = self.push_rad_s;
        }
        let of_errors = |row: &[f64; 4]| -> f64 {
            let terms = row.iter().zip(errors);
            let sum = terms.map(|(entry, error)| entry * error).sum::<f64>();
            memory * (sum + row[2] * pushed)
        };
        let of_torque = |torque: f64| torque * memory * self.period_s;
        let late_a = LATE_STEPS * self.most_a;
        let [_, rate, speed] = errors;
        let limits = [
            2.0 * (rate + speed)
                + of_errors(&wheel)
                + wheel[3] * late_a
                + of_torque(self.torques[0])
                + pushed
                + ROW_SHARE,
            2.0 * rate
                + of_errors(&body)
                + body[3] * late_a
                + of_torque(self.torques[1])
                + self.push_rad_s
                + ROW_SHARE,
        ];
        if limits.iter().any(|limit| !limit.is_finite()) {
            return Err("a limit of the monitor is not finite".to_owned());
        }
        Ok(Rows {
            body: self.body,
            wheel: self.wheel,
            body_width: widths_of_body,
            wheel_width: widths_of_wheel,
            limits,
        })
    }
}
