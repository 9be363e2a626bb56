//! What a firmware does, by lot.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// One thing that a firmware does.
#[derive(Clone, Copy)]
pub struct Call {
    pub what: u8,
    pub gyro: [i16; 3],
    pub accel: [i16; 3],
    pub wheel_adc: u16,
    pub words: [i32; 3],
}

impl Call {
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![self.what];
        for word in self.gyro.into_iter().chain(self.accel) {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(self.wheel_adc.to_le_bytes());
        for word in self.words {
            bytes.extend(word.to_le_bytes());
        }
        bytes
    }
}

/// A body that sways about upright with noise, so that the controller aligns, arms, runs and trips; words at their
/// ends; and any words at all. Each for some hundreds of steps.
pub struct Calls {
    random: ChaCha8Rng,
    mode: u8,
    left: u32,
    lean_rad: f64,
    rate_rad_s: f64,
    falls: bool,
    is_weightless: bool,
    /// Which sensor alone is at the end of its range in the last steps.
    clips: Option<Clipped>,
    /// Whether the gyroscope's reading stands still in the last steps, and its reading before.
    sticks: bool,
    gyro: [i16; 3],
    /// By how much the accelerometer's other axes are off, counts: within what may be gravity.
    sideways: [i16; 2],
    /// About which of the sensor's axes the body is turned by hand, too fast for a window.
    turned: Option<usize>,
    /// What every call of these steps is, where it is one and the same.
    calls: Option<u8>,
}

/// A sensor at the end of its range.
#[derive(Clone, Copy)]
enum Clipped {
    Gyro,
    Accel,
}

impl Calls {
    pub fn new(seed: u64) -> Calls {
        Calls {
            random: ChaCha8Rng::seed_from_u64(seed),
            mode: 0,
            left: 0,
            lean_rad: 0.0,
            rate_rad_s: 0.0,
            falls: false,
            is_weightless: false,
            clips: None,
            sticks: false,
            gyro: [0; 3],
            sideways: [0; 2],
            turned: None,
            calls: None,
        }
    }

    fn any<const N: usize>(&mut self) -> [i16; N] {
        let ends = [i16::MIN, i16::MIN + 1, -1, 0, 1, i16::MAX - 1, i16::MAX];
        std::array::from_fn(|_| match self.mode {
            1 => ends[self.random.random_range(0..ends.len())],
            _ => self.random.random(),
        })
    }

    pub fn next(&mut self) -> Call {
        if self.left == 0 {
            self.mode = [0, 0, 0, 1, 2][self.random.random_range(0..5)];
            self.left = self.random.random_range(200..3000);
            self.lean_rad = self.random.random_range(-0.05..0.05);
            self.rate_rad_s = self.random.random_range(-0.02..0.02);
            self.falls = self.random.random_range(0..3) == 0;
            self.is_weightless = !self.falls && self.random.random_range(0..4) == 0;
            self.calls = [None, None, Some(4), Some(5)][self.random.random_range(0..4)];
            // Seldom, since a controller that trips here does not run in what comes next.
            self.clips = match self.left % 16 {
                0 => Some(Clipped::Gyro),
                1 => Some(Clipped::Accel),
                _ => None,
            };
            self.sticks = self.left % 16 == 2;
            self.turned = match self.left % 16 {
                axis @ 3..6 => Some(axis as usize - 3),
                _ => None,
            };
            self.sideways = match self.left % 2 {
                0 => [0; 2],
                _ if self.is_weightless => [0; 2],
                _ => std::array::from_fn(|_| self.random.random_range(-350..350)),
            };
        }
        self.left -= 1;
        let any = match self.random.random_range(0..1000) {
            0 => 0,
            1..40 => 1,
            40 => 2,
            41 => 3,
            42..80 => 5,
            80..108 => 6,
            108..110 => 7,
            110..115 => 8,
            115..120 => 9,
            _ => 4,
        };
        let what = self.calls.unwrap_or(any);
        let (gyro, accel, wheel_adc) = if self.mode == 0 {
            let mut noise = |size: f64| self.random.random_range(-size..size);
            let gyro = [noise(3.0), noise(3.0), 916.7 * self.rate_rad_s + noise(3.0)];
            let (sin, cos) = self.lean_rad.sin_cos();
            let gravity = if self.is_weightless { 100.0 } else { 4096.0 };
            let accel = [gravity * cos, -gravity * sin, 0.0].map(|part| part + noise(8.0));
            // An encoder's count may change by that much, and from step to step.
            let wheel = 773.0 + noise(14.0);
            // It sways, or falls.
            let stiffness = if self.falls { -20.0 } else { 9.0 };
            self.rate_rad_s += 0.001 * (noise(1.0) - stiffness * self.lean_rad);
            self.lean_rad += 0.001 * self.rate_rad_s;
            let mut gyro = gyro.map(|part| part.round() as i16);
            let mut accel = accel.map(|part| part.round() as i16);
            accel[1] += self.sideways[0];
            accel[2] += self.sideways[1];
            if let Some(axis) = self.turned {
                gyro[axis] = gyro[axis].saturating_add(500);
            }
            if self.sticks && self.left < 100 {
                gyro = self.gyro;
            }
            self.gyro = gyro;
            // Longer than a controller that runs bears it.
            if self.left < 100 {
                match self.clips {
                    Some(Clipped::Gyro) => gyro[0] = i16::MAX,
                    Some(Clipped::Accel) => accel[1] = i16::MIN,
                    None => {}
                }
            }
            (gyro, accel, wheel as u16)
        } else {
            (self.any(), self.any(), self.random.random())
        };
        let words = match self.mode {
            1 => [i32::MIN, i32::MAX, 0]
                .map(|end: i32| end.wrapping_add(self.random.random_range(-1..2))),
            // The largest current, step after step.
            _ if self.calls == Some(5) => [i32::MAX; 3],
            _ => self.random.random(),
        };
        Call {
            what,
            gyro,
            accel,
            wheel_adc,
            words,
        }
    }
}
