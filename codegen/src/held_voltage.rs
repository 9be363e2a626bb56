//! The linear model with a voltage held over a step, for a voltage drive.
//!
//! The current that flows is w − κ φ̇ with w = V/R and κ = k_e/R, so that ẋ = (A − κ B e₃ᵀ) x + B w. The checker's
//! `held_loop` names what this model neglects, and checks the sampled numbers with its own series.

use nalgebra::Matrix4;

use crate::spec::ModuleSpec;

/// The held input of a module.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldInput {
    /// State matrix Ad of the sampled model, row by row; states in rad, rad/s, rad/s.
    pub ad: [[f64; 3]; 3],
    /// Input matrix Bd of the sampled model, change of each state per A.
    pub bd: [f64; 3],
    /// κ = k_e/R (A s/rad); zero for a current drive.
    pub back_emf: f64,
    /// Largest |w| of the duty, V_max/R (A); infinite for a current drive, whose current only the law limits.
    pub reach_a: f64,
}

impl HeldInput {
    /// The held input of the module `spec`.
    pub fn of(spec: &ModuleSpec) -> HeldInput {
        let Some(voltage) = &spec.drive.voltage else {
            return HeldInput {
                ad: spec.ad,
                bd: spec.bd,
                back_emf: 0.0,
                reach_a: f64::INFINITY,
            };
        };
        let back_emf = voltage.back_emf_v_s / voltage.winding_ohm;
        // exp of (A' B; 0 0) T holds both in its upper rows.
        let mut m = Matrix4::zeros();
        for i in 0..3 {
            for j in 0..3 {
                m[(i, j)] = spec.a[i][j];
            }
            m[(i, 2)] -= spec.b[i] * back_emf;
            m[(i, 3)] = spec.b[i];
        }
        let sampled = (m * spec.sample_time_s).exp();
        HeldInput {
            ad: [0, 1, 2].map(|i| [0, 1, 2].map(|j| sampled[(i, j)])),
            bd: [0, 1, 2].map(|i| sampled[(i, 3)]),
            back_emf,
            reach_a: spec
                .drive
                .current_range_a()
                .min(voltage.supply_v / voltage.winding_ohm),
        }
    }
}
