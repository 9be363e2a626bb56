//! The numbers of the monitor: the model's prediction of the motion in one step, and the largest deviation of a sound
//! bench from it.
//!
//! The sampled linear model predicts the motion. The monitor sums the differences between measured and predicted
//! motion, and multiplies the sum by λ = 1 − 2^−leak in each step. A difference d that every step repeats therefore
//! adds up to at most d 2^leak. A sensor's error enters as the difference of its values in two steps, and adds up to
//! at most twice its largest value. The limits of the sums cover
//!
//! - twice the largest errors of the sensors, and the effect of state errors on the prediction;
//! - a current that acts up to [`LATE_STEPS`] later than predicted;
//! - torques of friction, cogging, dead zone and offset, of any course up to their size;
//! - for the body: one push, of the size from which the pendulum can just come back.
//!
//! **Encoder on the wheel.** It shows the mean speed over its window of N steps. While the wheel accelerates by at most
//! Φ, the error of this speed is Φ N T/2; it is treated like other errors of the sensor, in addition to the rounding of
//! two counts. Φ is the largest acceleration that the model, with its errors, allows at the ends of angle, rate, wheel
//! speed and drive. A push changes the wheel's speed relative to the body at once, and the shown speed within the
//! window; during this time the sum contains the push. If these allowances would hide a wheel that does not respond to
//! the largest current, a monitor would notice nothing and is refused.
//!
//! With a voltage drive the model is that of the held voltage ([`crate::held_voltage`]), and the duty is the voltage
//! over the winding's resistance. The resistance changes with its temperature; its relative error is taken to be
//! [`UNSTATED_SHARE`].
//!
//! The widths grow with the states and the current by the shares by which the model's numbers may be off: three
//! standard errors, or [`UNSTATED_SHARE`] where none is stated.

use attitude::AttitudeSpec;

use crate::hardware::WheelSensor;
use crate::held_voltage::HeldInput;
use crate::helpers::motion::{MotionLimits, MotionRow};
use crate::ir::IntegerLaw;
use crate::refusal::Refusal;
use crate::spec::ModuleSpec;

/// Approximate time over which differences add up (s). A body that falls with a time constant of a tenth of a second
/// shows in this time which torque drives it, and noise has little time to add up.
const MEMORY_S: f64 = 0.1;

/// Largest error of a sensor by its noise, in standard deviations. One reading in 10¹⁵ of normal noise lies beyond
/// eight.
const NOISE_STDS: f64 = 8.0;

/// Largest error of the attitude filter's angle apart from noise (rad): from a bias of the accelerometer of 20 mg, or
/// from the filter's start.
const ANGLE_ERROR_RAD: f64 = 0.02;

/// Assumed relative error of a parameter without a standard error.
const UNSTATED_SHARE: f64 = 0.1;

/// Relative error of each entry of a row by sampling and rounding. Each limit has the same number as an allowance in
/// rad/s.
const ROW_SHARE: f64 = 0.01;

/// Number of steps by which the current, or the reading of a sensor, may be later than in the model.
const LATE_STEPS: i32 = 2;

/// Fraction bits of a sum.
const SUM_BITS: i32 = 16;

/// The specification of the monitor, in addition to that of the module.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MonitorSpec {
    /// Standard deviations of the measured angle (rad), rate and wheel speed (rad/s).
    pub noise_std: [f64; 3],
}

/// The monitor's numbers, in SI units and as words.
#[derive(Debug, Clone, PartialEq)]
pub struct MonitorNumbers {
    /// Largest errors of angle (rad), rate and wheel speed (rad/s).
    pub errors: [f64; 3],
    /// Change of the body's rate by a push (rad/s).
    pub push_rad_s: f64,
    /// Limit of the wheel's sum (rad/s).
    pub wheel_limit_rad_s: f64,
    /// Limit of the body's sum (rad/s).
    pub body_limit_rad_s: f64,
    /// These limits as words, with the rows of the model and their widths.
    pub words: MotionLimits,
}

/// A row of the model in SI units: change of a speed (rad/s) in one step, per rad, per rad/s (body), per rad/s (wheel)
/// and per A.
type Row = [f64; 4];

/// The numbers for `spec`.
///
/// # Errors
/// [`Refusal::Monitor`] with the parameter or the number for which no bound is known.
pub fn derive(
    spec: &ModuleSpec,
    law: &IntegerLaw,
    monitor: &MonitorSpec,
) -> Result<MonitorNumbers, Refusal> {
    let refuse = |reason: String| Refusal::Monitor { reason };
    let Some(attitude) = spec.hardware.attitude() else {
        return Err(refuse(
            "the monitor needs the body's rate without delay, and the rate of an encoder on the pivot is half its \
             window late"
                .to_owned(),
        ));
    };
    let torques = Torques::read(spec)?;
    let shares = Shares::read(spec)?;
    let leak = (MEMORY_S / spec.sample_time_s)
        .log2()
        .round()
        .clamp(1.0, 12.0) as u32;
    let memory = f64::from(1_u32 << leak);

    let row = |pick: &dyn Fn(usize, usize) -> f64, input: f64| -> Row {
        [pick(1, 0), pick(1, 1), pick(1, 2), input]
    };
    let held = HeldInput::of(spec);
    let change = |i: usize, j: usize| held.ad[i][j] - f64::from(u8::from(i == j));
    let body = row(&change, held.bd[1]);
    let wheel = row(
        &|i, j| change(i, j) + change(i + 1, j),
        held.bd[1] + held.bd[2],
    );

    // The current acts up to LATE_STEPS later than predicted. By then the leak has multiplied the predicted part of the
    // sum by λ^LATE_STEPS, so that the measured part is larger by the share λ^−LATE_STEPS − 1.
    let late = (1.0 - 1.0 / memory).powi(-LATE_STEPS) - 1.0;
    // The held current is at most the limit, or the supply voltage over the resistance.
    let most_a = match spec.drive.voltage {
        None => spec.current_limit_a,
        Some(_) => held.reach_a,
    };
    let late_a = f64::from(LATE_STEPS) * most_a;
    let angle_trip = crate::supervisor::numbers(spec).angle_trip_rad;
    let sine = angle_trip * angle_trip / 6.0;
    let wheel_width = [
        wheel[0].abs(),
        wheel[1].abs(),
        wheel[2].abs() * (shares.quotient(shares.wheel_friction, shares.wheel) + ROW_SHARE),
        wheel[3].abs() * (shares.quotient(shares.torque, shares.wheel) + ROW_SHARE + late),
    ];
    let body_width = [
        body[0].abs() * (shares.quotient(shares.gravity, shares.body) + ROW_SHARE + sine),
        2.0 * body[1].abs(),
        body[2].abs() * (shares.quotient(shares.wheel_friction, shares.body) + ROW_SHARE),
        body[3].abs() * (shares.quotient(shares.torque, shares.body) + ROW_SHARE + late),
    ];

    let (fall, push) = (spec.a[1][0], spec.b[1].abs() * spec.current_limit_a);
    if fall.is_nan() || fall <= 0.0 {
        return Err(refuse(
            "the body does not fall in the linear model".to_owned(),
        ));
    }
    let push_rad_s = push / fall.sqrt();
    let mut errors = errors(spec, attitude, monitor);
    let mut pushed_rad_s = 0.0;
    if let WheelSensor::Encoder(encoder) = &spec.hardware.wheel {
        // The wheel's speed relative to the body is its own speed minus the body's rate.
        let ends = [
            angle_trip,
            spec.ranges.rate_rad_s,
            spec.ranges.wheel_speed_rad_s,
            most_a,
        ];
        let in_a_step: f64 = (0..4)
            .map(|i| ((wheel[i] - body[i]).abs() + wheel_width[i] + body_width[i]) * ends[i])
            .sum();
        let acceleration =
            in_a_step / spec.sample_time_s + torques.wheel_rad_s2 + torques.body_rad_s2;
        let half_window_s = 0.5 * f64::from(encoder.window) * spec.sample_time_s;
        errors[2] += acceleration * half_window_s;
        pushed_rad_s = push_rad_s;
    }
    let of_errors = |row: &Row| -> f64 {
        let pushed = row[2].abs() * pushed_rad_s;
        ((0..3).map(|i| row[i].abs() * errors[i]).sum::<f64>() + pushed) * memory
    };
    let steps_s = memory * spec.sample_time_s;
    let wheel_limit_rad_s = 2.0 * (errors[1] + errors[2])
        + of_errors(&wheel)
        + wheel[3].abs() * late_a
        + torques.wheel_rad_s2 * steps_s
        + pushed_rad_s
        + ROW_SHARE;
    // The effect of the law's largest current on the wheel within the memory, and the width that grows with this
    // current.
    let answer = (wheel[3].abs() - wheel_width[3]) * memory * spec.current_limit_a;
    if pushed_rad_s > 0.0 && wheel_limit_rad_s >= answer {
        return Err(refuse(format!(
            "the speed over the window of the wheel's encoder may be wrong by {:.1} rad/s, and a wheel that \
             does not respond would not be noticed; use a shorter window",
            errors[2]
        )));
    }
    let body_limit_rad_s = 2.0 * errors[1]
        + of_errors(&body)
        + body[3].abs() * late_a
        + torques.body_rad_s2 * steps_s
        + push_rad_s
        + ROW_SHARE;

    let bits = law
        .terms
        .each_ref()
        .map(|term| term.input.format.fraction_bits as i32);
    let mut scale = bits[1].min(bits[2]) + 25;
    let units = |scale: i32| -> [f64; 4] {
        let unit = |bits: i32| 2f64.powi(scale - bits);
        [
            unit(bits[0]),
            unit(bits[1]),
            unit(bits[2]),
            2f64.powi(scale) * spec.drive.amperes_per_count,
        ]
    };
    // Whether every weight stays below 2³⁰, which leaves one bit of its word free.
    let fits = |scale: i32| {
        let units = units(scale);
        let rows = [&wheel, &body, &wheel_width, &body_width];
        let weights = rows
            .into_iter()
            .flat_map(|row| (0..4).map(|i| row[i] * units[i]));
        weights
            .chain([units[1], units[2]])
            .all(|weight| weight.abs() < 2f64.powi(30))
    };
    while scale > SUM_BITS + 1 && !fits(scale) {
        scale -= 1;
    }
    let units = units(scale);
    if !fits(scale) || units[1] < 1.0 || units[2] < 1.0 {
        return Err(refuse(
            "the motion changes in one step by more than a word can hold".to_owned(),
        ));
    }
    let nearest = |row: &Row| motion_row([0, 1, 2, 3].map(|i| (row[i] * units[i]).round()));
    // The additional unit of a width covers the rounding of the row to which the width belongs.
    let outward =
        |row: &Row| motion_row([0, 1, 2, 3].map(|i| (row[i] * units[i]).abs().ceil() + 1.0));
    // The additional units cover the rounding of the products and of the leak in each remembered step.
    let limit = |value: f64| (value * 2f64.powi(SUM_BITS)).ceil() + 2.0 * memory;
    let limits = [wheel_limit_rad_s, body_limit_rad_s].map(limit);
    if limits.iter().any(|limit| *limit > 2f64.powi(28)) {
        return Err(refuse(
            "a limit of the monitor exceeds 4096 rad/s, the largest that its words hold".to_owned(),
        ));
    }
    Ok(MonitorNumbers {
        errors,
        push_rad_s,
        wheel_limit_rad_s,
        body_limit_rad_s,
        words: MotionLimits {
            leak,
            shift: (scale - SUM_BITS) as u32,
            rate: units[1] as i32,
            wheel_speed: units[2] as i32,
            wheel: nearest(&wheel),
            body: nearest(&body),
            wheel_width: outward(&wheel_width),
            body_width: outward(&body_width),
            wheel_limit: limits[0] as i32,
            body_limit: limits[1] as i32,
        },
    })
}

fn motion_row(weights: [f64; 4]) -> MotionRow {
    let [angle, rate, wheel_speed, duty] = weights.map(|weight| weight as i32);
    MotionRow {
        angle,
        rate,
        wheel_speed,
        duty,
    }
}

/// Largest errors of the measured states: noise, half a count (a whole one for an encoder, whose turn is the difference
/// of two counts), and the error of the filter. The lateness of a window is not included.
fn errors(spec: &ModuleSpec, attitude: &AttitudeSpec, monitor: &MonitorSpec) -> [f64; 3] {
    let gyro = &attitude.gyro.matrix;
    let count = gyro.row(2).iter().map(|entry| entry.abs()).sum::<f64>();
    let noise = monitor.noise_std.map(|std| NOISE_STDS * std);
    let counts = match spec.hardware.wheel {
        WheelSensor::Encoder(_) => 1.0,
        _ => 0.5,
    };
    [
        noise[0] + ANGLE_ERROR_RAD,
        noise[1] + 0.5 * count,
        noise[2] + counts * spec.hardware.wheel_speed_per_count.abs(),
    ]
}

fn parameter<'a>(spec: &'a ModuleSpec, name: &str) -> Option<&'a crate::spec::ModelParameter> {
    spec.parameters
        .iter()
        .find(|parameter| parameter.name == name)
}

/// Largest relative error of each quantity of the linear model.
struct Shares {
    torque: f64,
    gravity: f64,
    wheel: f64,
    wheel_friction: f64,
    /// Relative error of the inertia Θ − j_w.
    body: f64,
}

impl Shares {
    fn read(spec: &ModuleSpec) -> Result<Shares, Refusal> {
        let share = |name: &str| match parameter(spec, name) {
            Some(found) => match found.std {
                Some(std) if found.value != 0.0 => 3.0 * std / found.value.abs(),
                _ => UNSTATED_SHARE,
            },
            None => UNSTATED_SHARE,
        };
        let value = |name: &str| parameter(spec, name).map_or(0.0, |found| found.value);
        let (whole, wheel) = (value("total_inertia"), value("wheel_inertia"));
        let off = share("total_inertia") * whole + share("wheel_inertia") * wheel;
        // With a voltage drive, the current at standstill is the voltage over the winding's resistance R, and the
        // back-EMF brakes the wheel like a viscous friction τ²/R. R is taken to be known to UNSTATED_SHARE.
        let (torque, friction) = (share("torque_constant"), share("wheel_viscous_friction"));
        let (torque, wheel_friction) = match spec.drive.voltage {
            None => (torque, friction),
            Some(_) => {
                let less = 1.0 - UNSTATED_SHARE;
                let braking = (1.0 + torque).powi(2) / less - 1.0;
                ((1.0 + torque) / less - 1.0, braking.max(friction))
            }
        };
        let shares = Shares {
            torque,
            gravity: share("gravity_torque"),
            wheel: share("wheel_inertia"),
            wheel_friction,
            body: off / (whole - wheel),
        };
        let divisors = [shares.wheel, shares.body];
        if divisors.iter().all(|share| (0.0..0.5).contains(share)) {
            Ok(shares)
        } else {
            Err(Refusal::Monitor {
                reason: "the inertia of the wheel or of the body may be off by half of its value or more (three \
                         standard errors)"
                    .to_owned(),
            })
        }
    }

    /// Largest relative error of a quotient, from those of its numerator and its denominator.
    fn quotient(&self, above: f64, below: f64) -> f64 {
        (1.0 + above) / (1.0 - below) - 1.0
    }
}

/// Bounds of the torques that the linear model lacks, as accelerations of wheel and body (rad/s²). Their course over
/// time is arbitrary.
struct Torques {
    wheel_rad_s2: f64,
    body_rad_s2: f64,
}

/// Parameters of the linear model, and those of the motions that [`Torques`] bounds.
const KNOWN: [&str; 16] = [
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
];

impl Torques {
    fn read(spec: &ModuleSpec) -> Result<Torques, Refusal> {
        let known = |name: &str| KNOWN.contains(&name) || name == "dead_zone";
        if let Some(other) = spec.parameters.iter().find(|found| !known(&found.name)) {
            return Err(Refusal::Monitor {
                reason: format!(
                    "no bound is known for the motion that `{}` adds",
                    other.name
                ),
            });
        }
        let value = |name: &str| parameter(spec, name).map_or(0.0, |found| found.value.abs());
        let (whole, wheel) = (value("total_inertia"), value("wheel_inertia"));
        if !(wheel > 0.0 && whole > wheel) {
            return Err(Refusal::Monitor {
                reason: "the inertias of body and wheel are not both known".to_owned(),
            });
        }
        let motor = value("torque_constant") * (value("dead_zone") + value("current_offset"));
        let on_wheel = value("wheel_coulomb_torque") + value("cogging_torque") + motor;
        let on_body = value("body_coulomb_torque").max(value("body_breakaway_torque"));
        // The inertias may be half of the assumed values, see `Shares`.
        Ok(Torques {
            wheel_rad_s2: 2.0 * on_wheel / wheel,
            body_rad_s2: 2.0 * (on_wheel + on_body) / (whole - wheel),
        })
    }
}
