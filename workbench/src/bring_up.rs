//! Bring-up: sign and axis of every sensor, and sign of the motor, from four recordings; and the entries of bench.toml
//! that contradict the recordings.

use ::calibrate::{
    Doubt, MotorSigns, Recording, TiltShows, WheelWord, encoder_sign, motor_signs, tilt,
};
use bench_files::{
    AngleSensor, BringUpRecordings, Hardware, InertialSensor, RawRecording, WheelSpeedSensor,
};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::numbers::significant;

/// A stated and a found axis count as different if the angle between them exceeds this, rad: 20°. The reading of an
/// uncalibrated accelerometer is up to 6° off, that of a sensor that is soldered at an angle somewhat more.
const APART_RAD: f64 = 20.0 * std::f64::consts::PI / 180.0;

/// Smallest and largest allowed reading of gravity, m/s², as for an emitted controller.
const GRAVITY_READS: [f64; 2] = [8.0, 11.5];

/// Two scales whose ratio exceeds this belong to different parts or settings.
const DIFFER: f64 = 1.2;

/// The result of [`bring_up`]: signs and axes by the recordings of `[bring_up]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BringUpReport {
    /// Signs; null where the recordings do not show one.
    pub signs: BringUpSigns,
    /// Axes as bench.toml names them; null where the recordings do not show them, or they are not along the
    /// body's.
    pub axes: BringUpAxes,
    /// Rotation from the accelerometer's axes to the body's, row by row. It is the value of the key `rotation` for a
    /// sensor that is not aligned with the body's axes.
    pub rotation: Option<[[f64; 3]; 3]>,
    /// Angle between the accelerometer's axes and the named ones, rad.
    pub off_axes_rad: Option<f64>,
    /// Angle from hanging to tilted, rad.
    pub tilt_rad: Option<f64>,
    /// Recordings that do not show what they should, and entries of bench.toml that contradict them.
    pub contradictions: Vec<BringUpContradiction>,
}

/// The signs of sensors and motor, each 1 or −1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BringUpSigns {
    /// Sign of the gyroscope's axis along the pivot, when the body turns towards positive α.
    pub gyroscope: Option<i8>,
    /// Sign of the accelerometer's axis along the body's x (from the pivot to the centre of mass).
    pub accelerometer: Option<i8>,
    /// Sign of the counts of an encoder on the pivot over α.
    pub angle: Option<i8>,
    /// Sign of the word of the wheel's sensor over the wheel's speed (of an encoder: over the wheel's angle).
    pub wheel_speed: Option<i8>,
    /// Sign of the current over the duty, which is that of amperes_per_count.
    pub drive: Option<i8>,
}

/// The body axis that each sensor axis shows.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BringUpAxes {
    /// Axes of the accelerometer.
    pub accelerometer: Option<[String; 3]>,
    /// Axes of the gyroscope. A tilt shows only its pivot axis; the others are those of the accelerometer, or the
    /// stated ones.
    pub gyroscope: Option<[String; 3]>,
}

/// A recording that does not show the motion of its key, or an entry of bench.toml that contradicts a recording.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BringUpContradiction {
    /// The recording that shows the contradiction, by its key under `[bring_up]`.
    pub recording: String,
    /// The key of bench.toml to correct.
    pub key: String,
    /// The value to write there, if it is known.
    pub value: Option<String>,
    /// One or two sentences.
    pub sentence: String,
}

/// Signs and axes from the recordings.
pub fn bring_up(recordings: &BringUpRecordings) -> BringUpReport {
    let mut report = BringUpReport::default();
    let hardware = recordings.hardware.as_ref();
    let (hanging, tilted) = (view(&recordings.hanging), view(&recordings.tilted));
    match hardware.and_then(|stated| stated.angle.as_ref()) {
        Some(&AngleSensor::Encoder {
            counts_per_turn,
            bits,
            ..
        }) => {
            let turn = 2_f64.powi(bits as i32);
            match encoder_sign(&recordings.tilted.body, turn, counts_per_turn) {
                Ok(sign) => report.encoder(sign, counts_per_turn),
                Err(doubt) => report.doubt(doubt),
            }
        }
        _ => {
            let (shows, doubts) = tilt(&hanging, &tilted);
            doubts.into_iter().for_each(|doubt| report.doubt(doubt));
            report.inertial(&shows, hardware);
        }
    }
    let wheel = hardware.and_then(|stated| stated.wheel_speed.as_ref());
    let word = match wheel {
        Some(WheelSpeedSensor::Encoder { bits, .. }) => WheelWord::Angle(2_f64.powi(*bits as i32)),
        _ => WheelWord::Speed,
    };
    let spun = view(&recordings.wheel_spun);
    let step = recordings.current_step.as_ref().map(view);
    let (signs, doubts) = motor_signs(word, &hanging, &spun, step.as_ref());
    doubts.into_iter().for_each(|doubt| report.doubt(doubt));
    report.motor(&signs, wheel, hardware);
    if step.is_none() {
        report.contradiction(
            "current_step",
            "[bring_up] current_step",
            None,
            "it is not recorded yet, so that the sign of the drive is open; the controller arms for it only if its axes are \
             right: mend what stands above, generate and flash again, then record it"
                .to_owned(),
        );
    }
    report
}

fn view(recording: &RawRecording) -> Recording<'_> {
    Recording {
        time_s: &recording.time_s,
        gyro: &recording.gyro,
        accel: &recording.accel,
        wheel: &recording.wheel,
        duty: &recording.duty,
    }
}

fn sign(value: f64) -> i8 {
    if value < 0.0 { -1 } else { 1 }
}

impl BringUpReport {
    /// Whether there is no contradiction.
    pub fn is_sound(&self) -> bool {
        self.contradictions.is_empty()
    }

    fn contradiction(
        &mut self,
        recording: &str,
        key: &str,
        value: Option<String>,
        sentence: String,
    ) {
        self.contradictions.push(BringUpContradiction {
            recording: recording.to_owned(),
            key: key.to_owned(),
            value,
            sentence,
        });
    }

    fn doubt(&mut self, doubt: Doubt) {
        let degrees = |rad: f64| format!("{}°", significant(rad.to_degrees(), 2));
        let (recording, sentence) = match doubt {
            Doubt::Moved { recording, by_rad } => (
                recording,
                format!(
                    "the body turns by {} in this recording, in which it should be still; check that the key names the right file",
                    degrees(by_rad)
                ),
            ),
            Doubt::NotTilted { by_rad } => (
                "tilted",
                format!(
                    "the body turns by {} from hanging; turn it by hand by 20° to 120° towards positive α, and \
                     hold it there",
                    degrees(by_rad)
                ),
            ),
            Doubt::BeginsTilted => (
                "tilted",
                "the recording begins with the body tilted, so that the gyroscope sees no turn; begin it \
                 while the body hangs"
                    .to_owned(),
            ),
            Doubt::NoGravity => (
                "hanging",
                "the accelerometer reads zero on every axis: it is not connected, or not switched on"
                    .to_owned(),
            ),
            Doubt::GyroscopeStill => (
                "tilted",
                "the accelerometer shows a turn, but the gyroscope shows none: the gyroscope is not connected, or not \
                 switched on"
                    .to_owned(),
            ),
            Doubt::WheelStill { recording } => (
                recording,
                "the wheel's word does not change beyond its noise: the wheel did not turn, or its sensor \
                 is not connected"
                    .to_owned(),
            ),
            Doubt::DutyChanges { recording } => (
                recording,
                "the duty changes, although no current should flow in this recording; check that the key names the right file".to_owned(),
            ),
            Doubt::DutyStill => (
                "current_step",
                "the duty does not change, although this recording should contain a step of the current; check that the key names the right file"
                    .to_owned(),
            ),
            Doubt::Backwards => (
                "current_step",
                "the step of the current turns the wheel opposite to wheel_spun, but a positive current must drive \
                 the wheel forward. Either the current was negative, or the wheel was spun backwards; record the \
                 wrong one again"
                    .to_owned(),
            ),
        };
        let key = format!("[bring_up] {recording}");
        self.contradiction(recording, &key, None, sentence);
    }

    fn encoder(&mut self, found: f64, counts_per_turn: f64) {
        self.signs.angle = Some(sign(found));
        if found * counts_per_turn < 0.0 {
            self.contradiction(
                "tilted",
                "[hardware.angle] counts_per_turn",
                Some(significant(-counts_per_turn, 9)),
                format!(
                    "the encoder's counts {} while the body turns towards positive α, against the stated sign",
                    if found < 0.0 { "fall" } else { "rise" }
                ),
            );
        }
    }

    fn inertial(&mut self, shows: &TiltShows, hardware: Option<&Hardware>) {
        let sensor = |pick: fn(&Hardware) -> Option<&InertialSensor>| hardware.and_then(pick);
        let accelerometer = sensor(|stated| stated.accelerometer.as_ref());
        let gyroscope = sensor(|stated| stated.gyroscope.as_ref());
        let matrix = |sensor: Option<&InertialSensor>| {
            let rotation = sensor.and_then(|sensor| sensor.rotation)?;
            Some(Matrix3::from_fn(|row, column| rotation[row][column]))
        };
        if let Some(scale) = accelerometer.and_then(|sensor| sensor.scale) {
            let reads = scale * shows.gravity_counts;
            if shows.gravity_counts >= 1.0
                && !(GRAVITY_READS[0]..=GRAVITY_READS[1]).contains(&reads)
            {
                self.contradiction(
                    "hanging",
                    "[hardware.accelerometer] scale",
                    Some(significant(9.81 / shows.gravity_counts, 5)),
                    format!(
                        "gravity reads {} m/s2 instead of about 9.8: the scale belongs to another range, or is not in \
                         m/s2 per count",
                        significant(reads, 3)
                    ),
                );
            }
        }
        let Some(found) = shows.body_from_accelerometer else {
            return;
        };
        self.tilt_rad = Some(shows.tilt_rad);
        let (named, off) = nearest(&found, |_| true);
        self.rotation = Some([0, 1, 2].map(|row| [0, 1, 2].map(|column| found[(row, column)])));
        self.off_axes_rad = Some(off);
        self.axes.accelerometer = (off <= APART_RAD).then(|| names(&named));
        let along_x = found.row(0).transpose();
        self.signs.accelerometer = Some(sign(along_x[along_x.iamax()]));
        if let Some(stated) = matrix(accelerometer)
            && apart(&stated, &found) > APART_RAD
        {
            let value = self.axes.accelerometer.as_ref().map(listed);
            self.contradiction(
                "tilted",
                "[hardware.accelerometer] axes",
                value,
                format!(
                    "the accelerometer's axes are {} away from the stated ones. By the axes' definition, its reading \
                     points along the body's -x while the body hangs, and a tilt towards positive α is a turn about z",
                    format_args!("{}°", significant(apart(&stated, &found).to_degrees(), 3))
                ),
            );
        }
        let Some(turned) = shows.gyroscope else {
            return;
        };
        self.signs.gyroscope = Some(sign(turned.axis[turned.axis.iamax()]));
        let reference = matrix(gyroscope).unwrap_or(found);
        let up = Vector3::z();
        let (named, _) = nearest(&reference, |candidate| {
            (candidate * turned.axis).angle(&up) < std::f64::consts::FRAC_PI_4
        });
        if (named * turned.axis).angle(&up) <= APART_RAD {
            self.axes.gyroscope = Some(names(&named));
        }
        if (reference * turned.axis).angle(&up) > APART_RAD {
            let value = self.axes.gyroscope.as_ref().map(listed);
            let sentence = if matrix(gyroscope).is_some() {
                "by the gyroscope's stated axes, the tilt towards positive α is no turn about the body's z"
            } else {
                "gyroscope and accelerometer disagree about the pivot axis: if both are on one chip, an axis of \
                 one of them is reversed; if they are two chips, state the axes of each"
            };
            self.contradiction(
                "tilted",
                "[hardware.gyroscope] axes",
                value,
                sentence.to_owned(),
            );
        }
        if let Some(scale) = gyroscope.and_then(|sensor| sensor.scale) {
            let ratio = scale * turned.counts_s / shows.tilt_rad;
            if !(1.0 / DIFFER..=DIFFER).contains(&ratio) {
                self.contradiction(
                    "tilted",
                    "[hardware.gyroscope] scale",
                    Some(significant(shows.tilt_rad / turned.counts_s, 5)),
                    format!(
                        "the gyroscope shows {} times the turn that the accelerometer shows: the gyroscope's scale \
                         belongs to another range, or is not in rad/s per count",
                        significant(ratio, 3)
                    ),
                );
            }
        }
    }

    fn motor(
        &mut self,
        signs: &MotorSigns,
        wheel: Option<&WheelSpeedSensor>,
        hardware: Option<&Hardware>,
    ) {
        self.signs.wheel_speed = signs.wheel.map(sign);
        self.signs.drive = signs.drive.map(sign);
        let stated = match wheel {
            Some(WheelSpeedSensor::Converter { slope, .. }) => slope.map(|slope| ("slope", slope)),
            Some(WheelSpeedSensor::Encoder {
                counts_per_turn, ..
            }) => Some(("counts_per_turn", *counts_per_turn)),
            Some(WheelSpeedSensor::Driver { scale, .. }) => Some(("scale", *scale)),
            None => None,
        };
        if let (Some(found), Some((key, stated))) = (signs.wheel, stated)
            && found * stated < 0.0
        {
            self.contradiction(
                "wheel_spun",
                &format!("[hardware.wheel_speed] {key}"),
                Some(significant(-stated, 9)),
                format!(
                    "the word of the wheel's sensor {} while the wheel is spun forward, against the stated sign",
                    if found < 0.0 { "falls" } else { "rises" }
                ),
            );
        }
        let stated = hardware.and_then(|stated| stated.drive.as_ref()?.amperes_per_count);
        if let (Some(found), Some(stated)) = (signs.drive, stated)
            && found * stated < 0.0
        {
            self.contradiction(
                "current_step",
                "[hardware.drive] amperes_per_count",
                Some(significant(-stated, 9)),
                format!(
                    "a {} duty drives the wheel forward and so means a positive current; the stated sign says the opposite",
                    if found < 0.0 { "smaller" } else { "larger" }
                ),
            );
        }
    }
}

/// Angle of the rotation from `a` to `b`, rad.
fn apart(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
    (((a.transpose() * b).trace() - 1.0) / 2.0)
        .clamp(-1.0, 1.0)
        .acos()
}

/// The right-handed assignment of axes that is nearest to a rotation, among the assignments that `allowed` permits, and
/// the angle between the two in rad.
fn nearest(
    rotation: &Matrix3<f64>,
    allowed: impl Fn(&Matrix3<f64>) -> bool,
) -> (Matrix3<f64>, f64) {
    let orders = [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [0, 2, 1],
        [2, 1, 0],
        [1, 0, 2],
    ];
    let mut best = (Matrix3::identity(), f64::INFINITY);
    for order in orders {
        for signs in 0..8_u32 {
            let mut candidate = Matrix3::zeros();
            for (column, row) in order.into_iter().enumerate() {
                candidate[(row, column)] = if signs >> column & 1 == 0 { 1.0 } else { -1.0 };
            }
            let off = apart(&candidate, rotation);
            if candidate.determinant() > 0.0 && off < best.1 && allowed(&candidate) {
                best = (candidate, off);
            }
        }
    }
    best
}

/// The body axis that each sensor axis shows.
fn names(rotation: &Matrix3<f64>) -> [String; 3] {
    [0, 1, 2].map(|column| {
        let shown = rotation.column(column);
        let row = shown.iamax();
        let name = ["x", "y", "z"][row];
        if shown[row] < 0.0 {
            format!("-{name}")
        } else {
            name.to_owned()
        }
    })
}

/// The axes as a value of bench.toml.
fn listed(axes: &[String; 3]) -> String {
    format!("[\"{}\"]", axes.join("\", \""))
}
