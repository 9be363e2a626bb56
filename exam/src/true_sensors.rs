//! Sensors with a lag or a delay, simulated in the steps of the true motion. A lag is integrated from step to step; a
//! delay reads an earlier value. Before a log began, every measured quantity is assumed to have its value at the first
//! sample.

use std::collections::VecDeque;

use plant::EffectId;

/// The readings of the sensors over time, from the true angle, rate and wheel speed.
#[derive(Clone, Debug)]
pub struct TrueSensors {
    /// Time constants in s, 0 for none.
    lag_s: [f64; 3],
    /// Delays in s, 0 for none.
    delay_s: [f64; 3],
    time_s: f64,
    /// The true values, and the readings before the delay.
    measured: [f64; 3],
    said: [f64; 3],
    /// Earlier readings before the delay, oldest first, as far back as the longest delay reaches.
    past: VecDeque<(f64, [f64; 3])>,
}

impl TrueSensors {
    /// The sensors of a bench in which these effects hide, at the first sample of a log.
    pub fn new<'a>(
        hidden: impl Iterator<Item = (EffectId, &'a [f64])>,
        time_s: f64,
        measured: [f64; 3],
    ) -> TrueSensors {
        let mut sensors = TrueSensors {
            lag_s: [0.0; 3],
            delay_s: [0.0; 3],
            time_s,
            measured,
            said: measured,
            past: VecDeque::from([(time_s, measured)]),
        };
        for (effect, p) in hidden {
            match effect {
                EffectId::RateLag => sensors.lag_s[1] = p[0],
                EffectId::WheelSpeedLag => sensors.lag_s[2] = p[0],
                EffectId::AngleDelay => sensors.delay_s[0] = p[0],
                EffectId::RateDelay => sensors.delay_s[1] = p[0],
                EffectId::WheelSpeedDelay => sensors.delay_s[2] = p[0],
                _ => {}
            }
        }
        sensors
    }

    /// Whether no sensor has a lag or a delay.
    pub fn are_prompt(&self) -> bool {
        self.lag_s.iter().chain(&self.delay_s).all(|&s| s == 0.0)
    }

    /// Advances to `time_s`, at which the true values are `measured`; in between they change linearly.
    pub fn advance(&mut self, time_s: f64, measured: [f64; 3]) {
        let step_s = time_s - self.time_s;
        if step_s <= 0.0 {
            return;
        }
        for (index, &lag_s) in self.lag_s.iter().enumerate() {
            let (before, after) = (self.measured[index], measured[index]);
            self.said[index] = if lag_s > 0.0 {
                // The exact response of T ẏ = v − y to a linear v.
                let behind = lag_s * (after - before) / step_s;
                let left = (-step_s / lag_s).exp();
                after - behind + (self.said[index] - before + behind) * left
            } else {
                after
            };
        }
        (self.time_s, self.measured) = (time_s, measured);
        self.past.push_back((time_s, self.said));
        let longest_s = self.delay_s.iter().copied().fold(0.0, f64::max);
        while self.past.len() > 2 && self.past[1].0 < time_s - longest_s {
            self.past.pop_front();
        }
    }

    /// The present readings.
    pub fn reading(&self) -> [f64; 3] {
        std::array::from_fn(|index| {
            let asked_s = self.time_s - self.delay_s[index];
            let after = self.past.partition_point(|&(time_s, _)| time_s < asked_s);
            let Some(&(to_s, to)) = self.past.get(after) else {
                return self.said[index];
            };
            let Some(&(from_s, from)) = after.checked_sub(1).and_then(|at| self.past.get(at))
            else {
                return to[index];
            };
            let share = (asked_s - from_s) / (to_s - from_s);
            from[index] + share * (to[index] - from[index])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The reading of a ramp a t tends to a (t − T) behind a lag T, and is a (t − δ) behind a delay δ.
    #[test]
    fn a_ramp_is_followed_as_the_equations_say() {
        let hidden = [
            (EffectId::RateLag, [0.05]),
            (EffectId::WheelSpeedDelay, [0.013]),
        ];
        let hidden = hidden.iter().map(|(effect, p)| (*effect, p.as_slice()));
        let mut sensors = TrueSensors::new(hidden, 0.0, [0.0; 3]);
        for k in 1..=500 {
            let time_s = 1e-3 * f64::from(k);
            sensors.advance(time_s, [2.0 * time_s; 3]);
            let [angle, rate, speed] = sensors.reading();
            let behind_lag = 2.0 * (time_s - 0.05 * (1.0 - (-time_s / 0.05).exp()));
            assert!((angle - 2.0 * time_s).abs() < 1e-12);
            assert!((rate - behind_lag).abs() < 1e-12, "{time_s}");
            assert!((speed - 2.0 * (time_s - 0.013).max(0.0)).abs() < 1e-12);
        }
    }
}
