//! Bring-up on recordings of simulated benches whose mountings are known.

use std::fmt::Write as _;

use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use workbench::{BringUpRecordings, BringUpReport, FilesInMemory, bring_up};

const G: f64 = 9.80665;
const GYRO: f64 = 0.0625 * std::f64::consts::PI / 180.0;
const ACCEL: f64 = G / 4096.0;

/// The true properties of a simulated bench.
#[derive(Clone, Copy)]
struct Truth {
    /// The rotation from the axes of gyroscope and accelerometer to those of the body.
    gyro: Matrix3<f64>,
    accel: Matrix3<f64>,
    wheel_per_count: f64,
    amperes_per_count: f64,
    /// Standard deviation of the noise, counts of gyroscope and accelerometer.
    noise: f64,
}

const SOUND: Truth = Truth {
    gyro: IDENTITY,
    accel: IDENTITY,
    wheel_per_count: 0.9,
    amperes_per_count: 8.4e-5,
    noise: 8.0,
};
const IDENTITY: Matrix3<f64> = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);

/// One recording of 2 s: angle and rate of the body, wheel speed, current over time.
fn recording(
    truth: &Truth,
    random: &mut ChaCha8Rng,
    motion: impl Fn(f64) -> (f64, f64, f64, f64),
) -> String {
    let mut text = "gx,gy,gz,ax,ay,az,wheel,duty,time_s\n".to_owned();
    for step in 0..400 {
        let time_s = f64::from(step) * 0.005;
        let (angle, rate, speed, current) = motion(time_s);
        // Upright is π; hanging the reading points against x.
        let up = Vector3::new(-angle.cos(), angle.sin(), 0.0) * G;
        let gyro = truth.gyro.transpose() * Vector3::new(0.0, 0.0, rate) / GYRO;
        let accel = truth.accel.transpose() * up / ACCEL;
        let mut counts = |value: f64, noise: f64| {
            // Uniform noise of this standard deviation.
            let width = noise * 3_f64.sqrt();
            (value + random.random_range(-1.0..1.0) * width).round()
        };
        for value in gyro.iter().chain(accel.iter()) {
            write!(text, "{},", counts(*value, truth.noise)).unwrap();
        }
        let wheel = counts(773.0 + speed / truth.wheel_per_count, 1.0);
        let duty = (32_768.0 + current / truth.amperes_per_count).round();
        writeln!(text, "{wheel},{duty},{time_s}").unwrap();
    }
    text
}

/// The four recordings: hanging, tilted by 40°, wheel spun to 50 rad/s, half an ampere from 0.5 s on.
fn recordings(truth: &Truth, seed: u64) -> [String; 4] {
    println!("seed {seed}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let hanging = recording(truth, &mut random, |_| (0.0, 0.0, 0.0, 0.0));
    // Turned between 0.6 s and 1.2 s.
    let tilted = recording(truth, &mut random, |time| {
        let share = ((time - 0.6) / 0.6).clamp(0.0, 1.0);
        let rate = if (0.6..1.2).contains(&time) {
            0.7 / 0.6
        } else {
            0.0
        };
        (0.7 * share, rate, 0.0, 0.0)
    });
    let spun = recording(truth, &mut random, |time| {
        let speed = if time > 0.5 {
            50.0 * (-(time - 0.5)).exp()
        } else {
            0.0
        };
        (0.0, 0.0, speed, 0.0)
    });
    let step = recording(truth, &mut random, |time| {
        let since = (time - 0.5).max(0.0);
        (0.0, 0.0, 120.0 * since, if time > 0.5 { 0.5 } else { 0.0 })
    });
    [hanging, tilted, spun, step]
}

fn report(bench: &str, recordings: [String; 4]) -> BringUpReport {
    report_of(bench, recordings, "current_step = \"c.csv\"\n")
}

/// The report of recordings of which the last may not be named in bench.toml.
fn report_of(bench: &str, [hanging, tilted, spun, step]: [String; 4], last: &str) -> BringUpReport {
    let text = format!(
        "{bench}[bring_up]\nhanging = \"h.csv\"\ntilted = \"t.csv\"\nwheel_spun = \"w.csv\"\n{last}"
    );
    let files: FilesInMemory = [
        ("bench.toml", text),
        ("h.csv", hanging),
        ("t.csv", tilted),
        ("w.csv", spun),
        ("c.csv", step),
    ]
    .into_iter()
    .map(|(name, text)| (name.to_owned(), text.into_bytes()))
    .collect();
    bring_up(&BringUpRecordings::from_files(&files).expect("recordings"))
}

const STATED: &str = "[hardware.gyroscope]\npart = \"FXAS21002\"\naxes = [\"x\", \"y\", \"z\"]\n\
     [hardware.accelerometer]\npart = \"FXOS8700\"\naxes = [\"x\", \"y\", \"z\"]\n\
     [hardware.wheel_speed]\nkind = \"converter\"\nslope = 0.9\noffset = -690.0\nlow = 0\nhigh = 1546\n\
     [hardware.drive]\npart = \"ESCON 24/2\"\namperes_per_count = 8.4e-5\n";

/// All 24 ways to put a chip on the body along its axes.
fn mountings() -> Vec<Matrix3<f64>> {
    let mut found = Vec::new();
    for order in [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [0, 2, 1],
        [2, 1, 0],
        [1, 0, 2],
    ] {
        for signs in 0..8_u32 {
            let mut matrix = Matrix3::zeros();
            for (column, row) in order.into_iter().enumerate() {
                matrix[(row, column)] = if signs >> column & 1 == 0 { 1.0 } else { -1.0 };
            }
            if matrix.determinant() > 0.0 {
                found.push(matrix);
            }
        }
    }
    found
}

fn names(matrix: &Matrix3<f64>) -> [String; 3] {
    [0, 1, 2].map(|column| {
        let row = (0..3).find(|row| matrix[(*row, column)] != 0.0).unwrap();
        let sign = if matrix[(row, column)] < 0.0 { "-" } else { "" };
        format!("{sign}{}", ["x", "y", "z"][row])
    })
}

#[test]
fn every_mounting_is_found() {
    let all = mountings();
    assert_eq!(all.len(), 24);
    for (seed, mounting) in all.into_iter().enumerate() {
        let truth = Truth {
            gyro: mounting,
            accel: mounting,
            ..SOUND
        };
        let files = recordings(&truth, seed as u64 + 1);
        let found = report("", files.clone());
        let wanted = names(&mounting);
        assert_eq!(found.axes.accelerometer.as_ref(), Some(&wanted));
        assert_eq!(found.axes.gyroscope.as_ref(), Some(&wanted));
        assert!(found.is_sound(), "{:?}", found.contradictions);
        // Against the stated axes it is a contradiction, unless they are these.
        let found = report(STATED, files);
        assert_eq!(
            found.is_sound(),
            mounting == IDENTITY,
            "{:?}",
            found.contradictions
        );
        if mounting != IDENTITY {
            let list = format!("[\"{}\"]", wanted.join("\", \""));
            let key = "[hardware.accelerometer] axes";
            let named = found.contradictions.iter().find(|one| one.key == key);
            assert_eq!(named.and_then(|one| one.value.clone()), Some(list));
        }
    }
}

#[test]
fn every_sign_of_wheel_and_drive_is_found() {
    for (seed, wheel, drive) in [
        (31, 1.0, 1.0),
        (32, -1.0, 1.0),
        (33, 1.0, -1.0),
        (34, -1.0, -1.0),
    ] {
        let truth = Truth {
            wheel_per_count: 0.9 * wheel,
            amperes_per_count: 8.4e-5 * drive,
            ..SOUND
        };
        let found = report(STATED, recordings(&truth, seed));
        assert_eq!(found.signs.wheel_speed, Some(wheel as i8));
        assert_eq!(found.signs.drive, Some(drive as i8));
        let keys: Vec<_> = found
            .contradictions
            .iter()
            .map(|one| one.key.as_str())
            .collect();
        let mut wanted = Vec::new();
        if wheel < 0.0 {
            wanted.push("[hardware.wheel_speed] slope");
        }
        if drive < 0.0 {
            wanted.push("[hardware.drive] amperes_per_count");
        }
        assert_eq!(keys, wanted);
    }
}

/// A mirrored axis, a scale of another range, both named by the key that mends them.
#[test]
fn a_reversed_gyroscope_and_a_wrong_scale_are_named() {
    let mirrored = Truth {
        gyro: Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)),
        ..SOUND
    };
    for bench in ["", STATED] {
        let found = report(bench, recordings(&mirrored, 41));
        assert_eq!(found.signs.gyroscope, Some(-1));
        let keys: Vec<_> = found
            .contradictions
            .iter()
            .map(|one| one.key.as_str())
            .collect();
        assert_eq!(keys, ["[hardware.gyroscope] axes"]);
    }
    let other = STATED.replace(
        "part = \"FXAS21002\"",
        "part = \"FXAS21002\"\nscale = 2.7e-4",
    );
    let found = report(&other, recordings(&SOUND, 42));
    assert_eq!(found.contradictions[0].key, "[hardware.gyroscope] scale");
    let other = STATED.replace(
        "part = \"FXOS8700\"",
        "part = \"FXOS8700\"\nscale = 2.44e-4",
    );
    let found = report(&other, recordings(&SOUND, 43));
    assert_eq!(
        found.contradictions[0].key,
        "[hardware.accelerometer] scale"
    );
}

#[test]
fn recordings_that_are_swapped_or_in_which_nothing_moves_are_named() {
    let sound = recordings(&SOUND, 51);
    let swapped = |a: usize, b: usize| {
        let mut files = sound.clone();
        files.swap(a, b);
        report(STATED, files)
    };
    let says =
        |found: &BringUpReport, key: &str| found.contradictions.iter().any(|one| one.key == key);
    assert!(says(&swapped(0, 1), "[bring_up] hanging"));
    assert!(says(&swapped(1, 2), "[bring_up] tilted"));
    assert!(says(&swapped(2, 3), "[bring_up] wheel_spun"));
    assert!(says(&swapped(2, 3), "[bring_up] current_step"));
    let still = sound[0].clone();
    let nothing = report(STATED, [still.clone(), still.clone(), still.clone(), still]);
    for key in ["tilted", "wheel_spun", "current_step"] {
        assert!(says(&nothing, &format!("[bring_up] {key}")), "{key}");
    }
    assert_eq!(nothing.signs, workbench::BringUpSigns::default());
}

/// A controller with a wrong axis does not arm, so that no current can be recorded: the wrong axis is named without it.
#[test]
fn axes_are_named_before_a_current_flows() {
    let mirrored = Truth {
        gyro: Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)),
        ..SOUND
    };
    let found = report_of(STATED, recordings(&mirrored, 44), "");
    let keys = found.contradictions.iter().map(|one| one.key.as_str());
    assert_eq!(
        keys.collect::<Vec<_>>(),
        ["[hardware.gyroscope] axes", "[bring_up] current_step"]
    );
    assert_eq!(
        (found.signs.wheel_speed, found.signs.drive),
        (Some(1), None)
    );
}

/// Ten times the noise of a cheap sensor changes no result, and the axes of a chip that is tilted by 10° are still
/// named.
#[test]
fn noise_and_an_aslant_chip_are_borne() {
    let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), 10_f64.to_radians());
    let aslant = turn.into_inner();
    let truth = Truth {
        gyro: aslant,
        accel: aslant,
        noise: 80.0,
        ..SOUND
    };
    for seed in 61..70 {
        let found = report(STATED, recordings(&truth, seed));
        assert!(found.is_sound(), "{:?}", found.contradictions);
        let off = found.off_axes_rad.expect("an angle").to_degrees();
        assert!((off - 10.0).abs() < 1.0, "{off}");
    }
}
