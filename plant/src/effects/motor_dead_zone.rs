//! Small currents give no torque.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, ParameterInfo, Role};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// torque = τ sign(i) max(|i| − d, 0)
#[derive(Clone, Copy, Debug)]
pub struct MotorDeadZone;

impl Effect for MotorDeadZone {
    const INFO: EffectInfo = EffectInfo {
        name: "motor-dead-zone",
        equation: "torque = τ sign(i) max(|i| − d, 0)",
        meaning: "dead band of the drive",
        source: "Khalil, Nonlinear Systems (3rd ed. 2002), ch. 1, common nonlinearities: dead zone",
        fingerprint: "the acceleration is short by the same amount at every current, and a coasting wheel \
         is not affected",
        prior: Prior { commonness: Commonness::Rare, reason: "a drive whose current loop is closed has none" },
        role: Role::Motor,
        parameters: &[ParameterInfo {
            name: "dead_zone",
            unit: "A",
            meaning: "half-width",
            plausible: (1e-3, 0.5),
            bounds: (0.0, 100.0),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[0.0]],
        absent: Some(&[0.0]),
        confused_with: &["wheel-coulomb-friction"],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        hiding: Some(Hiding { parameters: |s, bench| vec![bench.top_current_a * s], first_guess: 1e-2, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn current<S: Scalar>(
        p: &[S],
        current_a: S,
        _at: &Instant<S>,
        _torque_constant: S,
    ) -> S {
        let excess = current_a.abs() - p[0];
        if excess.value() < 0.0 {
            S::zero()
        } else if current_a.value() < 0.0 {
            -excess
        } else if current_a.value() > 0.0 {
            excess
        } else {
            S::zero()
        }
    }
}
