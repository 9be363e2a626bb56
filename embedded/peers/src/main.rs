//! Instructions of a step of attitude filters on the readings of a body that balances, counted one call at a time
//! on a 32-bit core without FPU: the emitted one, its algorithm in floating point, and the filters of other crates.
//!
//! Every call starts at raw counts. Prints a row of a table a filter: six axes, then nine, each the median and the
//! most. The count does not depend on time: equal images give equal numbers.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

mod madgwick;

use core::hint::black_box;
use core::time::Duration;

use ahrs::Ahrs as _;
use generated::Attitude;
use nalgebra_of_ahrs::Vector3 as VectorOfAhrs;
use nalgebra_of_uf_ahrs::Vector3 as VectorOfUfAhrs;
use riscv::register::minstret;
use riscv_rt::entry;
use semihosting::{print, println, process::exit};
use uf_ahrs::Ahrs as _;

/// Calls of each filter.
const CALLS: usize = 2001;
/// Between two steps, s.
const SAMPLE_TIME_S: f32 = 1e-3;
/// Madgwick's gain, rad/s.
const BETA_RAD_S: f32 = 0.033;
/// rad/s, m/s² and µT per count, as of the thesis' sensors.
const UNITS: [f32; 3] = [1.090_830_8e-3, 2.394_201_7e-3, 0.1];
/// What `fusion-ahrs` takes: degrees and g.
const DEGREES: f32 = 57.295_78;
const G: f32 = 9.806_65;

/// Marsaglia's xorshift; the seed is fixed, so that the readings are.
struct Random(u32);

impl Random {
    /// Within ± 2^(15 − `shift`).
    fn axes(&mut self, shift: u32) -> [i16; 3] {
        [0; 3].map(|_| {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 17;
            self.0 ^= self.0 << 5;
            self.0 as i16 >> shift
        })
    }
}

/// Raw counts of a body that stands upright, nearly at rest, in the earth's field.
#[derive(Clone, Copy)]
struct Reading {
    gyro: [i16; 3],
    accel: [i16; 3],
    mag: [i16; 3],
}

fn reading(random: &mut Random) -> Reading {
    let (noise, field) = (random.axes(10), random.axes(12));
    Reading {
        gyro: random.axes(11),
        accel: [4096 + noise[0], noise[1], noise[2]],
        mag: [-420 + field[0], 180 + field[1], field[2]],
    }
}

fn in_si(raw: [i16; 3], unit: f32) -> [f32; 3] {
    raw.map(|count| f32::from(count) * unit)
}

/// Median and most of the instructions of `call`.
fn count(mut call: impl FnMut(&Reading)) -> [u32; 2] {
    let mut random = Random(0x9e37_79b9);
    let mut spent = [0; CALLS];
    for one in &mut spent {
        let given = black_box(reading(&mut random));
        let before = minstret::read() as u32;
        call(&given);
        // Less the reading of the counter itself.
        *one = (minstret::read() as u32)
            .wrapping_sub(before)
            .wrapping_sub(1);
    }
    spent.sort_unstable();
    [spent[CALLS / 2], spent[CALLS - 1]]
}

fn row(name: &str, six_axes: impl FnMut(&Reading), nine_axes: impl FnMut(&Reading)) {
    print!("| {name} |");
    for [median, most] in [count(six_axes), count(nine_axes)] {
        print!(" {median} | {most} |");
    }
    println!();
}

/// The reading in single precision.
fn single(of: &Reading) -> [[f32; 3]; 3] {
    let [gyro, accel, mag] = UNITS;
    [
        in_si(of.gyro, gyro),
        in_si(of.accel, accel),
        in_si(of.mag, mag),
    ]
}

/// The reading in double precision.
fn double(of: &Reading) -> [[f64; 3]; 3] {
    let [gyro, accel, mag] = UNITS.map(f64::from);
    let in_si = |raw: [i16; 3], unit: f64| raw.map(|count| f64::from(count) * unit);
    [
        in_si(of.gyro, gyro),
        in_si(of.accel, accel),
        in_si(of.mag, mag),
    ]
}

fn emitted() {
    let (mut six, mut nine) = (Attitude::new(), Attitude::new());
    row(
        "emitted: fixed point, with the gyroscope's drift and the angle",
        |of| {
            six.update_imu(of.gyro, of.accel);
            black_box(six.angle());
        },
        |of| {
            nine.update_marg(of.gyro, of.accel, of.mag);
            black_box(nine.angle());
        },
    );
}

fn same_algorithm() {
    let new = || madgwick::single::Madgwick::new(BETA_RAD_S, SAMPLE_TIME_S);
    let (mut six, mut nine) = (new(), new());
    row(
        "the same algorithm in f32, with the angle",
        |of| {
            let [rate, accel, _] = single(of);
            six.step(rate, accel, None);
            black_box(six.angle());
        },
        |of| {
            let [rate, accel, mag] = single(of);
            nine.step(rate, accel, Some(mag));
            black_box(nine.angle());
        },
    );
    let new = || madgwick::double::Madgwick::new(BETA_RAD_S.into(), SAMPLE_TIME_S.into());
    let (mut six, mut nine) = (new(), new());
    row(
        "the same algorithm in f64, with the angle",
        |of| {
            let [rate, accel, _] = double(of);
            six.step(rate, accel, None);
            black_box(six.angle());
        },
        |of| {
            let [rate, accel, mag] = double(of);
            nine.step(rate, accel, Some(mag));
            black_box(nine.angle());
        },
    );
}

fn of_ahrs() {
    let new = || ahrs::Madgwick::new(SAMPLE_TIME_S, BETA_RAD_S);
    let (mut six, mut nine) = (new(), new());
    row(
        "ahrs, Madgwick, f32",
        |of| {
            let [rate, accel, _] = single(of).map(VectorOfAhrs::from);
            black_box(six.update_imu(&rate, &accel).is_ok());
        },
        |of| {
            let [rate, accel, mag] = single(of).map(VectorOfAhrs::from);
            black_box(nine.update(&rate, &accel, &mag).is_ok());
        },
    );
}

fn of_uf_ahrs() {
    let beta = uf_ahrs::MadgwickParams { beta: BETA_RAD_S };
    let new = || uf_ahrs::Madgwick::new(Duration::from_millis(1), beta);
    let (mut six, mut nine) = (new(), new());
    row(
        "uf-ahrs, Madgwick, f32",
        |of| {
            let [rate, accel, _] = single(of).map(VectorOfUfAhrs::from);
            black_box(six.update_imu(rate, accel));
        },
        |of| {
            let [rate, accel, mag] = single(of).map(VectorOfUfAhrs::from);
            black_box(nine.update(rate, accel, mag));
        },
    );
}

fn of_fusion_ahrs() {
    let new = || {
        let mut filter = fusion_ahrs::Ahrs::new();
        filter.set_sample_period(SAMPLE_TIME_S);
        // Its first seconds cost otherwise.
        filter.skip_startup();
        filter
    };
    let (mut six, mut nine) = (new(), new());
    let vector = |[x, y, z]: [f32; 3]| fusion_ahrs::Vector::new(x, y, z);
    let [gyro, accel, mag] = UNITS;
    let (gyro, accel) = (DEGREES * gyro, accel / G);
    row(
        "fusion-ahrs, f32",
        |of| {
            let (rate, up) = (in_si(of.gyro, gyro), in_si(of.accel, accel));
            six.update_no_magnetometer(vector(rate), vector(up));
            black_box(six.quaternion());
        },
        |of| {
            let (rate, up) = (in_si(of.gyro, gyro), in_si(of.accel, accel));
            nine.update(vector(rate), vector(up), vector(in_si(of.mag, mag)));
            black_box(nine.quaternion());
        },
    );
}

#[entry]
fn main() -> ! {
    println!(
        "| instructions a step, from raw counts | six axes, median | most | nine axes, median | most |"
    );
    println!("|---|---|---|---|---|");
    emitted();
    same_algorithm();
    of_ahrs();
    of_uf_ahrs();
    of_fusion_ahrs();
    exit(0)
}
