//! Bring-up: signs and axes of sensors and motor from four short recordings of raw counts.
//!
//! Three facts of physics, which hold for any scale of the sensors, decide:
//! - a body that hangs still reads one g upwards, against its x axis (x points from the pivot to the centre of
//!   mass): x = −a/‖a‖ in the sensor's frame;
//! - turned by α > 0 about z, upwards turns by −α in the body's frame, so that z points along −(a × a′), and the
//!   gyroscope's turn is along z;
//! - a positive current drives the wheel forward, so that its word tells which duty is positive.

use nalgebra::{Matrix3, Vector3};

/// Raw counts over time.
#[derive(Clone, Copy, Debug)]
pub struct Recording<'a> {
    /// Time of each sample, s.
    pub time_s: &'a [f64],
    /// Gyroscope x, y, z, counts.
    pub gyro: &'a [[f64; 3]],
    /// Accelerometer x, y, z, counts.
    pub accel: &'a [[f64; 3]],
    /// Word of the wheel's sensor.
    pub wheel: &'a [f64],
    /// Duty, counts.
    pub duty: &'a [f64],
}

/// A fact that a recording does not show, or that contradicts another one. A recording is named by its key under
/// `[bring_up]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// The body turns in a recording in which it should rest (rad).
    Moved {
        /// The recording.
        recording: &'static str,
        /// Angle between the body's mean directions in the first and in the last quarter.
        by_rad: f64,
    },
    /// The body turns too little, or too far, from hanging (rad).
    NotTilted {
        /// Its turn from hanging.
        by_rad: f64,
    },
    /// The recording of the tilt begins with the body tilted, so that the gyroscope sees no turn.
    BeginsTilted,
    /// The accelerometer shows nothing: its counts are all zero.
    NoGravity,
    /// The gyroscope does not notice the tilt.
    GyroscopeStill,
    /// The wheel's word does not change beyond its noise.
    WheelStill {
        /// The recording.
        recording: &'static str,
    },
    /// The duty changes where no current should flow.
    DutyChanges {
        /// The recording.
        recording: &'static str,
    },
    /// The duty does not change where a current should be stepped.
    DutyStill,
    /// The step of a current that is called positive turns the wheel backwards.
    Backwards,
}

/// Smallest tilt of the body, rad: 10°. For a larger tilt, a calibration error of the accelerometer of 0.1 g turns no
/// axis by more than a third of a right angle, and noise does not matter.
pub const TILT_MIN_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Largest tilt of the body, rad. Near half a turn, both directions look alike.
const TILT_MAX_RAD: f64 = 150.0 * std::f64::consts::PI / 180.0;
/// Largest turn of a body that counts as being at rest, rad: 5°.
const STILL_MAX_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// A change counts if it exceeds this many standard deviations of the noise; noise alone does so once in 10⁹ cases.
const SIGMAS: f64 = 6.0;

/// The result of the recordings `hanging` and `tilted`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiltShows {
    /// Length of gravity, counts.
    pub gravity_counts: f64,
    /// Angle from hanging to tilted according to the accelerometer, rad.
    pub tilt_rad: f64,
    /// The rotation from the accelerometer's axes to the body's; its rows are the body's axes in the sensor's frame.
    pub body_from_accelerometer: Option<Matrix3<f64>>,
    /// The turn from hanging to tilted according to the gyroscope.
    pub gyroscope: Option<Turned>,
}

/// A turn according to the gyroscope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turned {
    /// The pivot axis z in the gyroscope's frame.
    pub axis: Vector3<f64>,
    /// Length of the turn, counts times s.
    pub counts_s: f64,
}

/// Axes of accelerometer and gyroscope from the hanging and the tilted body.
pub fn tilt(hanging: &Recording, tilted: &Recording) -> (TiltShows, Vec<Doubt>) {
    let mut doubts = Vec::new();
    let up = mean(hanging.accel);
    let (first, last) = (quarter(tilted.accel, true), quarter(tilted.accel, false));
    let mut shows = TiltShows {
        gravity_counts: up.norm(),
        tilt_rad: up.angle(&last),
        body_from_accelerometer: None,
        gyroscope: None,
    };
    if up.norm() < 1.0 || last.norm() < 1.0 {
        doubts.push(Doubt::NoGravity);
        return (shows, doubts);
    }
    let moved = quarter(hanging.accel, true).angle(&quarter(hanging.accel, false));
    if moved > STILL_MAX_RAD {
        doubts.push(Doubt::Moved {
            recording: "hanging",
            by_rad: moved,
        });
    }
    if !(TILT_MIN_RAD..=TILT_MAX_RAD).contains(&shows.tilt_rad) {
        doubts.push(Doubt::NotTilted {
            by_rad: shows.tilt_rad,
        });
        return (shows, doubts);
    }
    let x = -up.normalize();
    let z = -up.cross(&last).normalize();
    let y = z.cross(&x);
    shows.body_from_accelerometer = Some(Matrix3::from_rows(&[
        x.transpose(),
        y.transpose(),
        z.transpose(),
    ]));
    // The first quarter must lie near hanging. It need not lie there exactly, because the body may already turn in it.
    if up.angle(&first) > 0.5 * shows.tilt_rad {
        doubts.push(Doubt::BeginsTilted);
        return (shows, doubts);
    }
    let (turn, noise) = turn(hanging, tilted);
    if turn.norm() > SIGMAS * noise && turn.norm() > 0.0 {
        shows.gyroscope = Some(Turned {
            axis: turn.normalize(),
            counts_s: turn.norm(),
        });
    } else {
        doubts.push(Doubt::GyroscopeStill);
    }
    (shows, doubts)
}

/// The sum over time of the gyroscope's counts minus those at rest, and the standard deviation of this sum.
fn turn(rest: &Recording, moving: &Recording) -> (Vector3<f64>, f64) {
    let bias = mean(rest.gyro);
    let spread: f64 = rest
        .gyro
        .iter()
        .map(|sample| (Vector3::from(*sample) - bias).norm_squared())
        .sum();
    let variance = spread / rest.gyro.len() as f64 + 1.0 / 4.0;
    let mut sum = Vector3::zeros();
    for (step, pair) in moving.time_s.windows(2).enumerate() {
        let both = Vector3::from(moving.gyro[step]) + Vector3::from(moving.gyro[step + 1]);
        sum += (0.5 * both - bias) * (pair[1] - pair[0]);
    }
    let duration = moving.time_s.last().unwrap_or(&0.0) - moving.time_s[0];
    // The variance has two parts: the noise of the summed samples, and the error of the bias that every sample has in
    // common.
    let samples = moving.time_s.len() as f64;
    let noise = variance * (1.0 / samples + 1.0 / rest.gyro.len() as f64);
    (sum, duration * noise.sqrt())
}

/// The meaning of the word of the wheel's sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WheelWord {
    /// A speed.
    Speed,
    /// Counts of an angle, which start again at zero after this number.
    Angle(f64),
}

impl WheelWord {
    /// The word as a speed in words per sample (per s for an angle); one value for each sample but the first.
    fn speeds(self, recording: &Recording) -> Vec<f64> {
        match self {
            WheelWord::Speed => recording.wheel[1..].to_vec(),
            WheelWord::Angle(turn) => recording
                .wheel
                .windows(2)
                .zip(recording.time_s.windows(2))
                .map(|(counts, times)| wrapped(counts[1] - counts[0], turn) / (times[1] - times[0]))
                .collect(),
        }
    }
}

/// A difference of counts that start again at zero after `turn`.
fn wrapped(difference: f64, turn: f64) -> f64 {
    difference - turn * (difference / turn).round()
}

/// The sign of the change of an encoder's counts while the body is tilted towards positive α. `turn` is the number of
/// counts after which the count starts again at zero.
///
/// # Errors
/// [`Doubt::NotTilted`] if the body is tilted by less than [`TILT_MIN_RAD`].
pub fn encoder_sign(tilted: &[f64], turn: f64, counts_per_turn: f64) -> Result<f64, Doubt> {
    let counts: f64 = tilted
        .windows(2)
        .map(|pair| wrapped(pair[1] - pair[0], turn))
        .sum();
    let by_rad = (counts / counts_per_turn * std::f64::consts::TAU).abs();
    if by_rad < TILT_MIN_RAD {
        return Err(Doubt::NotTilted { by_rad });
    }
    Ok(counts.signum())
}

/// The signs of wheel and motor according to the recordings, each 1 or −1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorSigns {
    /// The sign of the wheel's word over its speed.
    pub wheel: Option<f64>,
    /// The sign of the change of the duty in the step of the current.
    pub duty_step: Option<f64>,
    /// The sign of the current over the duty: a positive current drives the wheel forward.
    pub drive: Option<f64>,
}

/// Signs of the wheel's sensor and of the drive. Without the recording of a step of the current, the sign of the drive stays
/// open.
pub fn motor_signs(
    word: WheelWord,
    hanging: &Recording,
    wheel_spun: &Recording,
    current_step: Option<&Recording>,
) -> (MotorSigns, Vec<Doubt>) {
    let mut doubts = Vec::new();
    let mut signs = MotorSigns::default();
    // Speed and noise of the wheel's word at rest; the noise is at least half a count.
    let rest = word.speeds(hanging);
    let at_rest = middle(&rest);
    let noise = deviation(&rest).max(0.5 * count_of(word, hanging));
    for (name, recording) in [("hanging", hanging), ("wheel_spun", wheel_spun)] {
        let spread = spread(recording.duty);
        if spread > 0.0 {
            doubts.push(Doubt::DutyChanges { recording: name });
        }
    }
    let spun = word.speeds(wheel_spun);
    let moved = largest_mean(&spun, at_rest);
    if moved.abs() > SIGMAS * noise {
        signs.wheel = Some(moved.signum());
    } else {
        doubts.push(Doubt::WheelStill {
            recording: "wheel_spun",
        });
    }
    let Some(current_step) = current_step else {
        return (signs, doubts);
    };
    let before = current_step.duty[0];
    let Some(stepped) = current_step.duty.iter().position(|duty| *duty != before) else {
        doubts.push(Doubt::DutyStill);
        return (signs, doubts);
    };
    let step = (current_step.duty[stepped] - before).signum();
    signs.duty_step = Some(step);
    // The number of samples for which the changed duty lasts, and the wheel's speeds in this time.
    let lasts = current_step.duty[stepped..]
        .iter()
        .take_while(|duty| (*duty - before) * step > 0.0)
        .count();
    let speeds = word.speeds(current_step);
    let until = (stepped + lasts).min(speeds.len());
    let from = stepped.saturating_sub(1);
    let was = middle(&speeds[..from.max(1)]);
    let driven = &speeds[from.min(until)..until];
    let late = &driven[driven.len() / 2..];
    let response = late.iter().sum::<f64>() / late.len().max(1) as f64 - was;
    if late.is_empty() || response.abs() <= SIGMAS * noise / (late.len() as f64).sqrt().max(1.0) {
        doubts.push(Doubt::WheelStill {
            recording: "current_step",
        });
        return (signs, doubts);
    }
    if let Some(wheel) = signs.wheel {
        let forward = response.signum() * wheel;
        signs.drive = Some(step * forward);
        if forward < 0.0 {
            doubts.push(Doubt::Backwards);
        }
    }
    if !current_step.accel.is_empty() {
        let moved = quarter(current_step.accel, true).angle(&quarter(current_step.accel, false));
        if moved > STILL_MAX_RAD {
            doubts.push(Doubt::Moved {
                recording: "current_step",
                by_rad: moved,
            });
        }
    }
    (signs, doubts)
}

/// One count as a speed in words. For an angle, it is one count in one sample.
fn count_of(word: WheelWord, recording: &Recording) -> f64 {
    match word {
        WheelWord::Speed => 1.0,
        WheelWord::Angle(_) => {
            let steps = recording.time_s.len() - 1;
            let duration = recording.time_s[steps] - recording.time_s[0];
            steps as f64 / duration
        }
    }
}

/// The mean deviation from `rest` of the tenth that deviates most, with its sign.
fn largest_mean(values: &[f64], rest: f64) -> f64 {
    let mut sorted: Vec<f64> = values.iter().map(|value| value - rest).collect();
    sorted.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
    let tenth = &sorted[..sorted.len().div_ceil(10)];
    tenth.iter().sum::<f64>() / tenth.len() as f64
}

fn mean(samples: &[[f64; 3]]) -> Vector3<f64> {
    let sum: Vector3<f64> = samples.iter().map(|sample| Vector3::from(*sample)).sum();
    sum / samples.len().max(1) as f64
}

/// Mean of the first or of the last quarter.
fn quarter(samples: &[[f64; 3]], is_first: bool) -> Vector3<f64> {
    let length = samples.len().div_ceil(4);
    if is_first {
        mean(&samples[..length])
    } else {
        mean(&samples[samples.len() - length..])
    }
}

/// Median.
fn middle(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (squares / values.len().max(1) as f64).sqrt()
}

fn spread(values: &[f64]) -> f64 {
    let (least, most) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), value| {
            (a.min(*value), b.max(*value))
        });
    most - least
}
