//! The thesis bench for the tests: the parameters behind matrix 4.4, friction of section 3.5.3.

use design::{Weights, discrete_regulator};
use nalgebra::{RowVector3, Vector3};
use plant::{EffectId, Kind, Model, Plant, linearise};
use simulate::{Actuator, ClosedLoop, ExactLaw, Motion, Sensors};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Θ, j_w, G, τ, r_b, r_w.
pub const BASE: [f64; 6] = [
    2.30344e-3, 1.36125e-4, 0.245158, 0.0335, 2.12e-5, 1.75204e-5,
];

/// μ of the pivot in N m.
pub const COULOMB_TORQUE: f64 = 4.485e-4;

pub const SAMPLE_TIME_S: f64 = 1e-3;

/// The gains that the emitted law was rounded from: those of the design for the parameters above
/// (2e-6 off those of the printed matrix 4.4, whose six digits the parameters reproduce).
pub fn gains() -> RowVector3<f64> {
    static GAINS: LazyLock<RowVector3<f64>> = LazyLock::new(|| {
        let (model, values) = model(true);
        let smoothing_rad_s = 0.0846768;
        let linear = linearise(&model, &values, PI, Some(smoothing_rad_s)).unwrap();
        let weights = Weights {
            state: Vector3::new(25.0, 0.5, 5e-4),
            current: 1.0,
        };
        discrete_regulator(&linear, &weights, SAMPLE_TIME_S)
            .unwrap()
            .gains
    });
    *GAINS
}

pub fn exact_law() -> ExactLaw {
    ExactLaw {
        gains: gains(),
        limit_a: 2.0,
    }
}

/// The base model, with Coulomb friction of the pivot if asked for, in a balance experiment.
pub fn bench(with_coulomb: bool) -> Plant<f64> {
    let (model, values) = model(with_coulomb);
    Plant::new(&model, &values, Kind::Balance)
}

pub fn model(with_coulomb: bool) -> (Model, Vec<f64>) {
    let mut values = BASE.to_vec();
    let mut model = Model::base();
    if with_coulomb {
        model = model.with(EffectId::BodyCoulombFriction);
        values.push(COULOMB_TORQUE);
    }
    (model, values)
}

/// A drive that only clips.
pub const PLAIN_DRIVE: Actuator = Actuator {
    limit_a: 2.2,
    step_a: 0.0,
};

/// A loop with perfect sensors and a plain drive.
pub fn plain_loop(motion: Motion<'_>) -> ClosedLoop<'_> {
    ClosedLoop {
        motion,
        sensors: Sensors::PERFECT,
        actuator: PLAIN_DRIVE,
        sample_time_s: SAMPLE_TIME_S,
        computation_s: 0.0,
        pushes: vec![],
        seed: 1,
    }
}
