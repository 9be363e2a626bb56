//! Reads steps from standard input and writes what the emitted Rust answers; the language is that of `harness.c`.

use std::io::{BufReader, BufWriter, Read, Write};

use generated::{Angle, Controller, Current, Rate, Sample, WheelSpeed, control, wheel_speed};

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
        let [a, b, c] = [long(15), long(19), long(23)];
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
            _ => {
                let (angle, rate) = (Angle::from_bits(a), Rate::from_bits(b));
                control(angle, rate, WheelSpeed::from_bits(c)).to_bits()
            }
        };
        let attitude = controller.attitude();
        let [w, x, y, z] = attitude.quaternion().map(|part| part.to_bits());
        let (angle, rate) = (attitude.angle().to_bits(), attitude.rate().to_bits());
        for answer in [first, controller.status() as i32, angle, rate, w, x, y, z] {
            output.write_all(&answer.to_le_bytes()).expect("standard output");
        }
    }
}
