//! Instructions of the emitted controller on a 32-bit core without FPU, counted one call at a
//! time over readings of every kind: plausible ones, random words, limits and zeros.
//!
//! The program prints one line for each function: its name, the largest number of instructions of a call, and the median.
//! The count does not depend on time, so that equal images give equal numbers.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

use core::hint::black_box;

use generated::{Angle, Attitude, Controller, Rate, Sample, Status, WheelSpeed, control};
use riscv::register::minstret;
use riscv_rt::entry;
use semihosting::{process::exit, sys::arm_compat::sys_writec};

/// Calls of each function.
const CALLS: u32 = 200_000;
/// Numbers of instructions that are told apart; a call of this many or more counts as the last.
const TOLD_APART: usize = 4096;

/// Marsaglia's xorshift. The seed is fixed, so that the count is reproducible.
struct Random(u32);

impl Random {
    fn word(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// A reading within ± 2^(15 − `shift`).
    fn axes(&mut self, shift: u32) -> [i16; 3] {
        [0; 3].map(|_| self.word() as i16 >> shift)
    }

    /// A reading of any kind.
    fn reading(&mut self) -> [i16; 3] {
        match self.word() >> 28 {
            0 => [0; 3],
            1 => [i16::MIN; 3],
            2 => [i16::MAX; 3],
            3 => [0; 3].map(|_| {
                if self.word() >> 31 == 0 {
                    -32_767
                } else {
                    32_766
                }
            }),
            4 => [0, 0, 1],
            kind => self.axes(kind - 4),
        }
    }

    /// A sample of a body that balances: upright, nearly at rest, the wheel anywhere.
    fn balancing(&mut self, nine_axes: bool) -> Sample {
        let noise = self.axes(10);
        Sample {
            gyro: self.axes(11),
            accel: [4096 + noise[0], noise[1], noise[2]],
            mag: if nine_axes { Some(self.axes(6)) } else { None },
            wheel_adc: 600 + (self.word() >> 23) as u16,
        }
    }

    fn sample(&mut self, nine_axes: bool) -> Sample {
        Sample {
            gyro: self.reading(),
            accel: self.reading(),
            mag: if nine_axes {
                Some(self.reading())
            } else {
                None
            },
            wheel_adc: self.word() as u16,
        }
    }
}

/// Writes a text to the emulator's console, one byte at a time. `core::fmt` and the slices of `Write` would bring
/// panics into the image, where none is allowed.
fn print(text: &str) {
    for byte in text.bytes() {
        sys_writec(byte);
    }
}

/// Writes a number to the emulator's console.
fn print_number(number: u32) {
    if number >= 10 {
        print_number(number / 10);
    }
    sys_writec(b'0' + (number % 10) as u8);
}

/// Counts the calls of `call` on the inputs of `input` and prints the line.
fn count<I>(name: &str, mut input: impl FnMut() -> I, mut call: impl FnMut(&I)) {
    let mut most = 0;
    let mut calls = [0_u32; TOLD_APART];
    for _ in 0..CALLS {
        let given = black_box(input());
        let before = minstret::read() as u32;
        call(&given);
        // The reading of the counter itself is subtracted. The counter is exact under `-icount shift=0`, and the
        // compiler does not move memory accesses across it.
        let spent = (minstret::read() as u32)
            .wrapping_sub(before)
            .wrapping_sub(1);
        most = if spent > most { spent } else { most };
        if let Some(calls) = calls.get_mut((spent as usize).min(TOLD_APART - 1)) {
            *calls += 1;
        }
    }
    // At least half of the calls take no more.
    let (mut median, mut so_far) = (0, 0);
    for of_one in &calls {
        so_far += of_one;
        if 2 * so_far >= CALLS {
            break;
        }
        median += 1;
    }
    print(name);
    print(" ");
    print_number(most);
    print(" ");
    print_number(median);
    print("\n");
}

#[inline(never)]
fn six_axes(attitude: &mut Attitude, sample: &Sample) -> Angle {
    attitude.update_imu(sample.gyro, sample.accel);
    attitude.angle()
}

#[inline(never)]
fn nine_axes(attitude: &mut Attitude, sample: &Sample) -> Angle {
    match sample.mag {
        Some(mag) => attitude.update_marg(sample.gyro, sample.accel, mag),
        None => attitude.update_imu(sample.gyro, sample.accel),
    }
    attitude.angle()
}

#[inline(never)]
fn step(controller: &mut Controller, sample: &Sample) -> u16 {
    controller.step(sample).0
}

#[inline(never)]
fn law(state: &[i32; 3]) -> i32 {
    let [angle, rate, wheel_speed] = *state;
    control(
        Angle::from_bits(angle),
        Rate::from_bits(rate),
        WheelSpeed::from_bits(wheel_speed),
    )
    .to_bits()
}

#[entry]
fn main() -> ! {
    let mut random = Random(0x9e37_79b9);
    let mut attitude = Attitude::new();
    let mut controller = Controller::new();
    // The controller aligns during a window of quiet samples. Without an attitude it cannot be armed.
    for _ in 0..1000 {
        let sample = random.balancing(false);
        step(&mut controller, &sample);
    }
    controller.arm();
    count(
        "control",
        || [0; 3].map(|_| random.word() as i32),
        |state| {
            black_box(law(state));
        },
    );
    count(
        "attitude-6",
        || random.sample(false),
        |sample| {
            black_box(six_axes(&mut attitude, sample));
        },
    );
    count(
        "attitude-9",
        || random.sample(true),
        |sample| {
            black_box(nine_axes(&mut attitude, sample));
        },
    );
    count(
        "balance-6",
        || random.balancing(false),
        |sample| {
            black_box(step(&mut controller, sample));
        },
    );
    count(
        "balance-9",
        || random.balancing(true),
        |sample| {
            black_box(step(&mut controller, sample));
        },
    );
    // A controller that had tripped would take fewer instructions.
    if controller.status() != Status::Running {
        exit(1)
    }
    count(
        "step-6",
        || random.sample(false),
        |sample| {
            black_box(step(&mut controller, sample));
        },
    );
    count(
        "step-9",
        || random.sample(true),
        |sample| {
            black_box(step(&mut controller, sample));
        },
    );
    exit(0)
}
