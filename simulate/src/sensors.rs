//! The measurement that the controller receives: the plant's reading with noise, quantisation and limits.
//!
//! Offsets and scale errors are effects of the model, and already in the plant's reading. This file adds
//! noise and the quantisation of the converter.

use crate::law::Measured;
use plant::Reading;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{PI, TAU};

/// The noise, quantisation and limit of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Standard deviation of the noise in the channel's unit, Gaussian and independent from sample to sample.
    pub noise_std: f64,
    /// Step of the converter in the channel's unit; zero for none.
    pub step: f64,
    /// Largest magnitude of a reading in the channel's unit.
    pub range: f64,
}

impl Sensor {
    /// A channel without noise, quantisation or limit.
    pub const PERFECT: Sensor = Sensor {
        noise_std: 0.0,
        step: 0.0,
        range: f64::INFINITY,
    };

    fn read(&self, truth: f64, random: &mut ChaCha8Rng) -> f64 {
        // A number is drawn even if the noise is zero, so that every law receives the same noise.
        let normal: f64 = StandardNormal.sample(random);
        let noisy = truth + self.noise_std * normal;
        let stepped = if self.step > 0.0 {
            (noisy / self.step).round() * self.step
        } else {
            noisy
        };
        stepped.clamp(-self.range, self.range)
    }
}

/// The three channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    /// Body angle from upright, rad.
    pub angle: Sensor,
    /// Body rate, rad/s.
    pub rate: Sensor,
    /// Wheel speed, rad/s.
    pub wheel_speed: Sensor,
}

impl Sensors {
    /// Three channels without noise, quantisation or limit.
    pub const PERFECT: Sensors = Sensors {
        angle: Sensor::PERFECT,
        rate: Sensor::PERFECT,
        wheel_speed: Sensor::PERFECT,
    };

    /// The hardware of the thesis. Steps and ranges are those of the parts: gyroscope
    /// 62.5 mdps/count, ±2000 °/s; 12-bit converter for the wheel, 8.53108 rpm/count, ±700 rad/s.
    /// The angle comes from the attitude filter and is not quantised. The noise is assumed, with values
    /// typical for rigs of this kind: 1 mrad after the filter, 4 mrad/s, 0.6 rad/s.
    pub fn of_the_thesis() -> Sensors {
        Sensors {
            angle: Sensor {
                noise_std: 1e-3,
                step: 0.0,
                range: PI,
            },
            rate: Sensor {
                noise_std: 4e-3,
                step: 62.5e-3_f64.to_radians(),
                range: 2000.0_f64.to_radians(),
            },
            wheel_speed: Sensor {
                noise_std: 0.6,
                step: 8.53108 * TAU / 60.0,
                range: 700.0,
            },
        }
    }

    /// One sample. The angle is taken from upright, within ±π.
    pub fn read(&self, reading: &Reading<f64>, random: &mut ChaCha8Rng) -> Measured {
        let from_upright = from_upright_rad(reading.angle_rad);
        Measured {
            angle_rad: self.angle.read(from_upright, random),
            rate_rad_s: self.rate.read(reading.rate_rad_s, random),
            wheel_speed_rad_s: self.wheel_speed.read(reading.wheel_speed_rad_s, random),
        }
    }
}

/// α − π in rad, within ±π: an accelerometer does not count turns.
pub fn from_upright_rad(angle_rad: f64) -> f64 {
    (angle_rad - PI + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn steps_and_range() {
        let sensor = Sensor {
            noise_std: 0.0,
            step: 0.25,
            range: 1.0,
        };
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for (truth, said) in [(0.1, 0.0), (0.13, 0.25), (-0.4, -0.5), (7.0, 1.0)] {
            assert_eq!(sensor.read(truth, &mut random), said);
        }
    }

    #[test]
    fn noise_has_the_stated_size_and_no_mean() {
        let sensor = Sensor {
            noise_std: 0.3,
            ..Sensor::PERFECT
        };
        let seed = 5;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let count = 20_000;
        let values: Vec<f64> = (0..count).map(|_| sensor.read(2.0, &mut random)).collect();
        let n = f64::from(count);
        let mean = values.iter().sum::<f64>() / n;
        let variance = values
            .iter()
            .map(|value| (value - mean).powi(2))
            .sum::<f64>()
            / n;
        // Four standard errors each.
        assert!((mean - 2.0).abs() < 4.0 * 0.3 / n.sqrt(), "seed {seed}");
        assert!(
            (variance.sqrt() / 0.3 - 1.0).abs() < 4.0 / (2.0 * n).sqrt(),
            "seed {seed}"
        );
    }

    #[test]
    fn angles_are_counted_from_upright() {
        for (angle, expected) in [
            (PI, 0.0),
            (PI + 0.1, 0.1),
            (0.1, -PI + 0.1),
            (3.0 * PI - 0.2, -0.2),
        ] {
            assert!((from_upright_rad(angle) - expected).abs() < 1e-12);
        }
    }
}
