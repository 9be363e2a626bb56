//! The pendulum of a seed, with its sensors and experiments.

use std::f64::consts::{PI, TAU};

use bench_files::Known;
use design::{Weights, discrete_regulator};
use nalgebra::Vector3;
use plant::{Kind, Model, linearise};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::dice::{log_uniform, sign};
use crate::bench_plan::{ChannelNoise, DriveProgram, ExperimentPlan};
use crate::true_motion::HiddenPush;
use crate::truth::Truth;

/// Base parameters of a bench of this family: a body of 0.4 to 2 times the thesis' inertia that
/// swings at 1 to 2.2 Hz.
pub fn draw_truth(rng: &mut ChaCha8Rng) -> Truth {
    let total = log_uniform(rng, 1e-3, 5e-3);
    let wheel = total * log_uniform(rng, 0.04, 0.12);
    let omega = TAU * rng.random_range(1.0..2.2);
    Truth {
        base: [
            total,
            wheel,
            total * omega * omega,
            rng.random_range(0.02..0.06),
        ],
        body_viscous: total * log_uniform(rng, 5e-3, 0.1),
        wheel_viscous: wheel * log_uniform(rng, 0.03, 0.3),
        hidden: vec![],
    }
}

/// The noise of a seed's sensors.
pub fn draw_noise(rng: &mut ChaCha8Rng) -> ChannelNoise {
    ChannelNoise {
        std: [
            log_uniform(rng, 3e-4, 3e-3),
            log_uniform(rng, 1e-3, 1e-2),
            log_uniform(rng, 0.1, 1.0),
        ],
    }
}

/// The equipment that is needed for a hidden term to be visible.
#[derive(Clone, Copy, Debug)]
pub struct ExperimentNeeds {
    /// A rate sensor.
    pub rate: bool,
    /// Experiments with the motor.
    pub motor: bool,
}

/// The drawn experiments.
pub struct Choice {
    /// The experiments.
    pub plans: Vec<ExperimentPlan>,
    /// Whether the rate is measured.
    pub has_rate: bool,
    /// The known values of Θ (kg m²), j_w (kg m²), G (N m) and τ (N m/A); `None` for an unknown one.
    pub known: [Option<f64>; 4],
    /// The lengths that were measured with a ruler: from the second list of the exam on, the distance from the pivot to
    /// the wheel.
    pub measured: Known,
    /// Largest current of a spin-up (A), and the wheel speed that it reaches (rad/s).
    pub top: (f64, f64),
}

/// The experiments of a seed.
pub fn draw_experiments(rng: &mut ChaCha8Rng, truth: &Truth, needs: ExperimentNeeds) -> Choice {
    let [_, wheel, gravity, torque] = truth.base;
    let sample_s = [0.004, 0.005, 0.008][rng.random_range(0..3)];
    let mut plans = vec![];
    let small = rng.random_range(0.2..0.45);
    let large = rng.random_range(0.6..1.1);
    let swing = |angle_rad: f64| ExperimentPlan {
        name: format!("free swing {:.0} deg", angle_rad.to_degrees()),
        kind: Kind::FreeSwing,
        angle_rad,
        wheel_speed_rad_s: 0.0,
        driving: DriveProgram::None,
        duration_s: 16.0,
        sample_s,
    };
    plans.push(swing(large));
    if rng.random_bool(0.75) {
        plans.push(swing(small));
    }
    // One bench in eight has no motor.
    let swings_only = rng.random_bool(0.125) && !needs.motor;
    let speed = rng.random_range(300.0..700.0);
    let duration_s = 3.0;
    let decay = truth.wheel_viscous / wheel;
    let top_a = speed * truth.wheel_viscous / torque / (1.0 - (-decay * duration_s).exp());
    if !swings_only {
        let shares: &[f64] = match rng.random_range(0..4) {
            0 => &[0.3, 0.6, 1.0],
            _ => &[0.25, 0.5, 1.0, -0.7],
        };
        for &share in shares {
            plans.push(ExperimentPlan {
                name: format!("spin-up {:.3} A", share * top_a),
                kind: Kind::SpinUp,
                angle_rad: 0.0,
                wheel_speed_rad_s: 0.0,
                driving: DriveProgram::Step(share * top_a),
                duration_s,
                sample_s,
            });
        }
        if rng.random_bool(0.6) {
            plans.push(ExperimentPlan {
                name: "coast-down".to_owned(),
                kind: Kind::SpinUp,
                angle_rad: 0.0,
                wheel_speed_rad_s: 0.5 * speed,
                driving: DriveProgram::None,
                duration_s: 10.0,
                sample_s,
            });
        }
        let limit_a = gravity * rng.random_range(0.2..0.35) / torque;
        if rng.random_bool(0.7)
            && let Some(gains) = gains(truth, 0.004, limit_a)
        {
            let count = rng.random_range(0..=2);
            let pushes = (0..count)
                .map(|index| HiddenPush {
                    time_s: 2.0 + 3.0 * index as f64 + rng.random_range(0.0..1.0),
                    peak_nm: sign(rng) * gravity * rng.random_range(0.05..0.15),
                    width_s: 0.05,
                })
                .collect();
            plans.push(ExperimentPlan {
                name: "balance".to_owned(),
                kind: Kind::Balance,
                angle_rad: PI + rng.random_range(-0.06..0.06),
                wheel_speed_rad_s: 0.0,
                driving: DriveProgram::Balanced {
                    gains,
                    limit_a,
                    pushes,
                },
                duration_s: 8.0,
                sample_s: 0.004,
            });
        }
        if rng.random_bool(0.25) {
            plans.push(ExperimentPlan {
                name: "driven".to_owned(),
                kind: Kind::Driven,
                angle_rad: 0.0,
                wheel_speed_rad_s: 0.0,
                driving: DriveProgram::Square(0.3 * gravity / torque * 0.5),
                duration_s: 10.0,
                sample_s,
            });
        }
    }
    let mut known = [None; 4];
    match rng.random_range(0..5) {
        0 => known[plant::GRAVITY_TORQUE] = Some(gravity),
        _ => {
            known[plant::GRAVITY_TORQUE] = Some(gravity);
            known[plant::TORQUE_CONSTANT] = Some(torque);
        }
    }
    Choice {
        plans,
        has_rate: needs.rate || rng.random_bool(0.7),
        known,
        measured: Known::default(),
        top: (top_a, speed),
    }
}

/// Gains from the weights of the thesis, scaled to the current of this bench; `None` if there is no design.
fn gains(truth: &Truth, sample_s: f64, limit_a: f64) -> Option<[f64; 3]> {
    let values = [
        truth.base[0],
        truth.base[1],
        truth.base[2],
        truth.base[3],
        truth.body_viscous,
        truth.wheel_viscous,
    ];
    let model = linearise(&Model::base(), &values, PI, None).ok()?;
    // The thesis' bench is limited to 2 A.
    let scale = (limit_a / 2.0).powi(2);
    let weights = Weights {
        state: Vector3::new(25.0, 0.5, 5e-4) * scale,
        current: 1.0,
    };
    let regulator = discrete_regulator(&model, &weights, sample_s).ok()?;
    Some([regulator.gains[0], regulator.gains[1], regulator.gains[2]])
}
