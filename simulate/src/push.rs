//! Pushes on the body, f(t) = a exp(−b (t − tᵢ)²), the disturbance of thesis 4.5.

/// One push.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// tᵢ, the time of its maximum, in s.
    pub time_s: f64,
    /// a, the largest torque, in N m.
    pub torque: f64,
    /// b, in 1/s².
    pub sharpness_per_s2: f64,
}

impl Push {
    /// The push with this largest torque in N m at `time_s`; its torque falls to 1/e
    /// `width_s` seconds before and after.
    pub fn new(time_s: f64, torque: f64, width_s: f64) -> Push {
        Push {
            time_s,
            torque,
            sharpness_per_s2: 1.0 / (width_s * width_s),
        }
    }

    /// The push with this impulse in N m s and this largest torque in N m (with the same sign) at
    /// `time_s`: b = π (a/∫ f dt)².
    pub fn of_impulse(time_s: f64, impulse: f64, torque: f64) -> Push {
        Push {
            time_s,
            torque,
            sharpness_per_s2: std::f64::consts::PI * (torque / impulse).powi(2),
        }
    }

    /// f in N m at `time_s`.
    pub fn torque_at(&self, time_s: f64) -> f64 {
        let since = time_s - self.time_s;
        self.torque * (-self.sharpness_per_s2 * since * since).exp()
    }

    /// ∫ f dt = a √(π/b) in N m s.
    pub fn impulse(&self) -> f64 {
        self.torque * (std::f64::consts::PI / self.sharpness_per_s2).sqrt()
    }
}

/// The torque of all pushes in N m at `time_s`.
pub fn torque_at(pushes: &[Push], time_s: f64) -> f64 {
    pushes.iter().map(|push| push.torque_at(time_s)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_impulse_is_the_integral() {
        let push = Push::new(4.0, 0.02, 0.05);
        let step = 1e-4;
        let sum: f64 = (0..80_000)
            .map(|index| push.torque_at(f64::from(index) * step) * step)
            .sum();
        assert!((sum - push.impulse()).abs() < 1e-12);
        let same = Push::of_impulse(4.0, push.impulse(), 0.02);
        assert!((same.sharpness_per_s2 / push.sharpness_per_s2 - 1.0).abs() < 1e-12);
        assert!((push.torque_at(4.05) - 0.02 / std::f64::consts::E).abs() < 1e-15);
    }
}
