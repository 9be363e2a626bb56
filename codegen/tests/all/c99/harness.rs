//! Reads steps from standard input and writes what the emitted Rust answers; the language is that of `harness.c`.

use std::fmt::{self, Write as _};
use std::io::{BufReader, BufWriter, Read, Write};

use generated::{Angle, Controller, Current, Rate, Sample, WheelSpeed, control, wheel_speed};

// BEGIN DIGEST
/// Joins the numbers of a text: those that a state shows of itself, in the order of its declaration.
#[derive(Default)]
struct Digest {
    digest: u32,
    number: Option<u32>,
    is_negative: bool,
}

impl Digest {
    fn end(&mut self) {
        if let Some(number) = self.number.take() {
            let word = if self.is_negative { number.wrapping_neg() } else { number };
            self.digest = (self.digest ^ word).wrapping_mul(16_777_619);
        }
    }
}

impl fmt::Write for Digest {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            if byte.is_ascii_digit() {
                let before = self.number.unwrap_or_default().wrapping_mul(10);
                self.number = Some(before.wrapping_add(u32::from(byte - b'0')));
            } else {
                self.end();
                self.is_negative = byte == b'-';
            }
        }
        Ok(())
    }
}

fn digest(controller: &Controller) -> i32 {
    let mut digest = Digest::default();
    write!(digest, "{controller:?} ").expect("it takes everything");
    digest.digest as i32
}
// END

fn main() {
    let mut input = BufReader::new(std::io::stdin().lock());
    let mut output = BufWriter::new(std::io::stdout().lock());
    let mut controller = Controller::new();
    let mut bytes = [0u8; 27];
    while input.read_exact(&mut bytes).is_ok() {
        let word = |at: usize| i16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let long = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
        let sample = Sample {
            gyro: [word(1), word(3), word(5)],
            accel: [word(7), word(9), word(11)],
            mag: None,
            wheel_adc: word(13) as u16,
        };
        let words = [long(15), long(19), long(23)];
        let [a, b, c] = words;
        #[allow(unused_mut)]
        let mut direct: Option<[i32; 4]> = None;
        let first = match bytes[0] {
            0 => {
                controller = Controller::new();
                0
            }
            1 => i32::from(controller.arm()),
            2 => {
                controller.disarm();
                0
            }
            3 => {
                controller.fault();
                0
            }
            4 => i32::from(controller.step(&sample).0),
            5 => i32::from(controller.step_with_current(&sample, Current::from_bits(a)).0),
            7 => wheel_speed(sample.wheel_adc).to_bits(),
// BEGIN DIRECT
            8 => {
                let gradient = [0, 1, 2, 3].map(|i: usize| {
                    let wide = match i {
                        3 => i32::from(sample.gyro[1]) * 4096,
                        _ => words[i] >> 4,
                    };
                    let is_wide = (sample.accel[2] >> i) & 1 == 1;
                    if is_wide { wide } else { i32::from(sample.gyro[i % 3] >> 8) }
                });
                let beta = generated::constants::FILTER.beta;
                let correction = generated::madgwick::scaled_correction(gradient, 0x100, beta);
                direct = Some(correction.direction);
                correction.gain
            }
            9 => {
                let [gyro, accel] = [sample.gyro, sample.accel].map(|axes| axes.map(i32::from));
                let state = generated::filter::FilterState {
                    quaternion: [a, b, c, gyro[0] * 16384],
                    rate: accel[0],
                    slow_rate: accel[1],
                };
                let wheel = word(13) as u16;
                let mut up = match wheel & 3 {
                    0 => accel,
                    3 => gyro.map(|axis| axis * 8192),
                    _ => [gyro[0], gyro[1], gyro[2] - 0x1000_0000],
                };
                if wheel & 3 == 2 {
                    up[usize::from(wheel >> 2 & 1)] = accel[1] * 1024;
                }
                let filter = &generated::constants::FILTER;
                let aligned = generated::filter::align_to(&state, up, filter);
                direct = Some(aligned.quaternion);
                aligned.rate ^ aligned.slow_rate.wrapping_mul(65536)
            }
// END
            _ => {
                let (angle, rate) = (Angle::from_bits(a), Rate::from_bits(b));
                control(angle, rate, WheelSpeed::from_bits(c)).to_bits()
            }
        };
        let attitude = controller.attitude();
        let [w, x, y, z] = attitude.quaternion().map(|part| part.to_bits());
        let (angle, rate) = (attitude.angle().to_bits(), attitude.rate().to_bits());
        let [w, x, y, z] = direct.unwrap_or([w, x, y, z]);
        let status = controller.status() as i32;
        for answer in [first, status, angle, rate, w, x, y, z, digest(&controller)] {
            output.write_all(&answer.to_le_bytes()).expect("standard output");
        }
    }
}
