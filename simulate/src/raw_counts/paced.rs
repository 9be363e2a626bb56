//! Sensors that are not synchronous with the controller: each gives fresh readings at a rate of its own, behind a
//! filter of its own, and some samples receive late readings.

use super::controller::{RawController, RawSample};
use crate::law::LawFailure;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The pace of gyroscope and accelerometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorPace {
    /// Fresh readings of the gyroscope per second; infinite for one at every sample.
    pub gyro_rate_hz: f64,
    /// Fresh readings of the accelerometer per second; infinite for one at every sample.
    pub accel_rate_hz: f64,
    /// Time constant of the gyroscope's low-pass filter, s; zero for none.
    pub gyro_lag_s: f64,
    /// Time constant of the accelerometer's low-pass filter, s; zero for none.
    pub accel_lag_s: f64,
    /// Share of the samples in which the bus is late: every reading is then that of the sample before.
    pub late_share: f64,
}

impl SensorPace {
    /// A fresh, unfiltered reading at every sample.
    pub const EVERY_SAMPLE: SensorPace = SensorPace {
        gyro_rate_hz: f64::INFINITY,
        accel_rate_hz: f64::INFINITY,
        gyro_lag_s: 0.0,
        accel_lag_s: 0.0,
        late_share: 0.0,
    };
}

/// A controller whose sensors have this pace. A reading that becomes fresh between two samples has the value of the
/// later sample: it is up to one sample younger than on the bench.
#[derive(Clone, Debug)]
pub struct Paced<C> {
    /// The controller.
    pub controller: C,
    pace: SensorPace,
    sample_time_s: f64,
    seed: u64,
    random: ChaCha8Rng,
    steps: u64,
    gyro: Chain,
    accel: Chain,
    shown: Option<RawSample>,
}

/// The path of one sensor from the measured value to its registers: low-pass filter, and update at the sensor's rate.
#[derive(Clone, Copy, Debug, Default)]
struct Chain {
    filtered: Option<[f64; 3]>,
    periods: u64,
    register: [i16; 3],
}

impl Chain {
    /// Receives the unfiltered reading at `time_s` and returns the contents of the registers.
    fn shows(&mut self, counts: [i16; 3], time_s: f64, rate_hz: f64, kept: f64) -> [i16; 3] {
        let before = self.filtered.unwrap_or(counts.map(f64::from));
        let filtered = [0, 1, 2].map(|axis| {
            let element = f64::from(counts[axis]);
            element + kept * (before[axis] - element)
        });
        let is_first = self.filtered.replace(filtered).is_none();
        // The small excess keeps rounding from counting one period too few.
        let periods = (time_s * rate_hz * (1.0 + 1e-12)).floor();
        let is_fresh = !periods.is_finite() || periods as u64 > self.periods;
        if is_first || is_fresh {
            self.periods = if periods.is_finite() {
                periods as u64
            } else {
                0
            };
            self.register = filtered.map(|value| value.round() as i16);
        }
        self.register
    }
}

impl<C: RawController> Paced<C> {
    /// `controller`, which is stepped every `sample_time_s`, behind sensors of this pace; `seed` says which samples are
    /// late.
    pub fn new(controller: C, pace: SensorPace, sample_time_s: f64, seed: u64) -> Paced<C> {
        Paced {
            controller,
            pace,
            sample_time_s,
            seed,
            random: ChaCha8Rng::seed_from_u64(seed),
            steps: 0,
            gyro: Chain::default(),
            accel: Chain::default(),
            shown: None,
        }
    }

    /// Share of a deviation that a filter keeps over a sample.
    fn kept(&self, lag_s: f64) -> f64 {
        if lag_s > 0.0 {
            (-self.sample_time_s / lag_s).exp()
        } else {
            0.0
        }
    }
}

impl<C: RawController> RawController for Paced<C> {
    fn reset(&mut self) {
        self.controller.reset();
        self.random = ChaCha8Rng::seed_from_u64(self.seed);
        self.steps = 0;
        self.gyro = Chain::default();
        self.accel = Chain::default();
        self.shown = None;
    }

    fn arm(&mut self) -> Result<bool, LawFailure> {
        self.controller.arm()
    }

    fn fault(&mut self) -> Result<(), LawFailure> {
        self.controller.fault()
    }

    fn status(&self) -> Result<u8, LawFailure> {
        self.controller.status()
    }

    fn step(&mut self, sample: &RawSample) -> Result<u16, LawFailure> {
        let time_s = self.steps as f64 * self.sample_time_s;
        self.steps += 1;
        let (gyro_kept, accel_kept) = (
            self.kept(self.pace.gyro_lag_s),
            self.kept(self.pace.accel_lag_s),
        );
        let (gyro_hz, accel_hz) = (self.pace.gyro_rate_hz, self.pace.accel_rate_hz);
        let now = RawSample {
            gyro: self.gyro.shows(sample.gyro, time_s, gyro_hz, gyro_kept),
            accel: self.accel.shows(sample.accel, time_s, accel_hz, accel_kept),
            ..*sample
        };
        let is_late = self.random.random_bool(self.pace.late_share);
        let shown = match self.shown {
            Some(before) if is_late => before,
            _ => now,
        };
        self.shown = Some(now);
        self.controller.step(&shown)
    }

    fn angle_rad(&self) -> Result<f64, LawFailure> {
        self.controller.angle_rad()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a loop of 1 kHz, a sensor of 800 Hz gives a fresh reading in four of five samples, one of 400 Hz in two of
    /// five.
    #[test]
    fn registers_are_fresh_at_their_own_rate() {
        for (rate_hz, fresh) in [
            (800.0, 4000),
            (400.0, 2000),
            (1000.0, 5000),
            (f64::INFINITY, 5000),
        ] {
            let mut chain = Chain::default();
            let mut before = [0; 3];
            let mut changes = 0;
            for step in 1..=5000_i16 {
                let shown = chain.shows([step; 3], f64::from(step - 1) * 1e-3, rate_hz, 0.0);
                changes += i32::from(shown != before);
                before = shown;
            }
            assert!((changes - fresh).abs() <= 1, "{rate_hz}: {changes}");
        }
    }

    /// The response of the filter to a step is 1 − e^(−t/T).
    #[test]
    fn a_filter_lags() {
        let mut chain = Chain::default();
        let kept = (-1.0_f64 / 8.0).exp();
        chain.shows([0; 3], 0.0, f64::INFINITY, kept);
        for step in 1..40 {
            let shown = chain.shows([10_000; 3], f64::from(step), f64::INFINITY, kept);
            let wanted = 10_000.0 * (1.0 - (-f64::from(step) / 8.0).exp());
            assert!((f64::from(shown[0]) - wanted).abs() <= 1.0, "{step}");
        }
    }
}
