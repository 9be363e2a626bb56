//! First-order low-pass, and the thesis' first attempt: low-pass the rate, then integrate.
//!
//! The integral of a rate with a bias b drifts by b·t with any low-pass (thesis,
//! figure 3.3); it is included for comparison with the other filters.

/// First-order low-pass with time constant τ, sampled every T: y ← y + (1 − e^(−T/τ))(x − y),
/// the exact response to an input that is held over the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPass {
    share: f64,
    value: f64,
}

impl LowPass {
    /// Starts at zero. Times in s.
    pub fn new(time_constant_s: f64, sample_time_s: f64) -> Self {
        LowPass {
            share: -(-sample_time_s / time_constant_s).exp_m1(),
            value: 0.0,
        }
    }

    /// Takes one sample and returns the filtered value.
    pub fn update(&mut self, sample: f64) -> f64 {
        self.value += self.share * (sample - self.value);
        self.value
    }
}

/// Angle by integrating a low-passed rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPassIntegrator {
    rate: LowPass,
    sample_time_s: f64,
    angle_rad: f64,
}

impl LowPassIntegrator {
    /// Starts at `angle_rad` (rad) at rest. Times in s.
    pub fn new(angle_rad: f64, time_constant_s: f64, sample_time_s: f64) -> Self {
        LowPassIntegrator {
            rate: LowPass::new(time_constant_s, sample_time_s),
            sample_time_s,
            angle_rad,
        }
    }

    /// Takes a rate (rad/s) and returns the angle (rad), not wrapped.
    pub fn update(&mut self, rate_rad_s: f64) -> f64 {
        self.angle_rad += self.rate.update(rate_rad_s) * self.sample_time_s;
        self.angle_rad
    }
}
