//! How an effect can be hidden in a bench for the exam, with parameters of a visible size.

/// How the exam hides an effect.
#[derive(Clone, Copy, Debug)]
pub struct Hiding {
    /// The parameters (SI, in the order of the effect's description) for an amplitude. The amplitude is a
    /// dimensionless number: the term grows with it, and at 1 it is about as large as its reference quantity.
    pub parameters: fn(f64, &HidingPlace) -> Vec<f64>,
    /// An amplitude to begin with in the search for the required one.
    pub first_guess: f64,
    /// Whether the parameters scale with the bench and may lie outside their plausible range.
    pub beyond_plausible: bool,
}

/// The bench in which an effect is hidden, and random numbers for the effect's shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HidingPlace {
    /// Θ in kg m².
    pub total_inertia: f64,
    /// j_w in kg m².
    pub wheel_inertia: f64,
    /// G in N m.
    pub gravity_torque: f64,
    /// τ in N m/A.
    pub torque_constant: f64,
    /// From the pivot to the axis of the wheel, m.
    pub pivot_to_wheel_m: f64,
    /// Largest current of a spin-up, A.
    pub top_current_a: f64,
    /// Wheel speed at the end of that spin-up, rad/s.
    pub top_wheel_speed_rad_s: f64,
    /// Drawn sign: 1 or −1.
    pub side: f64,
    /// Drawn number from 0 to 1, 1 excluded.
    pub shape: f64,
    /// Drawn number from −1 to 1, 1 excluded.
    pub second: f64,
}

impl HidingPlace {
    /// A value between two limits, log-uniform in the drawn shape.
    pub fn between(&self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.shape)
    }

    /// The motor's torque at the largest current, N m.
    pub fn top_torque(&self) -> f64 {
        self.torque_constant * self.top_current_a
    }
}
