//! The bench of the thesis (matrix 4.4) as a specification, from golden numbers that were computed
//! with SciPy, independently of this program. An example for the tests here: the committed crate
//! is what `flywheel generate` writes for `models/thesis-4.4.toml`.

use codegen::hardware::HardwareSpec;
use codegen::spec::{ModelParameter, ModuleSpec, PhysicalRanges, PwmDrive};

/// The thesis bench sampled at 1 ms, weights diag(25, 0.5, 5e-4) and 1, limit 2 A.
pub fn spec() -> ModuleSpec {
    ModuleSpec {
        model_name: "thesis 4.4".to_owned(),
        gains: [-24.2672423, -2.12973867, -0.0225875821],
        current_limit_a: 2.0,
        sample_time_s: 0.001,
        ranges: PhysicalRanges::of(&HardwareSpec::thesis_bench()),
        drive: PwmDrive::THESIS_BENCH,
        hardware: HardwareSpec::thesis_bench(),
        assumed: Vec::new(),
        parameters: vec![
            parameter("total_inertia", 2.30344e-3, None, "kg m2"),
            parameter("wheel_inertia", 1.36125e-4, None, "kg m2"),
            parameter("gravity_torque", 0.245158, Some(1e-6), "N m"),
            parameter("torque_constant", 0.0335, None, "N m/A"),
            parameter("body_viscous_friction", 2.12e-5, None, "N m s/rad"),
            parameter("wheel_viscous_friction", 1.75204e-5, None, "N m s/rad"),
            parameter("body_coulomb_torque", 4.485e-4, None, "N m"),
        ],
        correlation: None,
        state_weights: [25.0, 0.5, 5e-4],
        current_weight: 1.0,
        a: [
            [0.0, 1.0, 0.0],
            [113.116, -2.45364, 0.00808392],
            [-113.116, 2.45364, -0.136792],
        ],
        b: [0.0, -15.4569, 261.555],
        ad: [
            [
                1.0000565121511045,
                0.0009987930157013504,
                4.038510074499915e-09,
            ],
            [
                0.11297901394396843,
                0.9976058435651088,
                8.073610399618353e-06,
            ],
            [
                -0.1129717406856116,
                0.002394001092951494,
                0.9998632271118966,
            ],
        ],
        bd: [
            -7.721853550980166e-06,
            -0.015437187471891671,
            0.26151845692206843,
        ],
        closed_loop: None,
    }
}

fn parameter(name: &str, value: f64, std: Option<f64>, unit: &str) -> ModelParameter {
    ModelParameter {
        name: name.to_owned(),
        value,
        std,
        unit: unit.to_owned(),
    }
}
