//! What an effect says of how it can be hidden in a bench: parameters of a size that the bench can show.

/// How the exam hides an effect.
#[derive(Clone, Copy, Debug)]
pub struct Hiding {
    /// The parameters (SI, in the order of the effect's description) for an amplitude, which is a pure
    /// number: the term grows with it, and at 1 it is about as large as what it is measured by.
    pub parameters: fn(f64, &HidingPlace) -> Vec<f64>,
    /// An amplitude from which the one that is wanted is looked for.
    pub first_guess: f64,
    /// The parameters go with the bench, and may lie outside of their plausible range.
    pub beyond_plausible: bool,
}

/// The bench in which an effect is hidden, and what was drawn for the effect's shape.
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
    /// Wheel speed that it reaches, rad/s.
    pub top_wheel_speed_rad_s: f64,
    /// 1 or −1.
    pub side: f64,
    /// A number from 0 to 1, 1 excluded.
    pub shape: f64,
    /// A number from −1 to 1, 1 excluded.
    pub second: f64,
}

impl HidingPlace {
    /// The drawn shape, log-uniform between two values.
    pub fn between(&self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.shape)
    }

    /// The motor's torque at the largest current, N m.
    pub fn top_torque(&self) -> f64 {
        self.torque_constant * self.top_current_a
    }
}
