//! The current follows its command with a lag.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, Role, Timing};
use crate::hiding::Hiding;
use crate::physical::PhysicalRange;
use crate::{Kind, Scalar};

/// T di/dt = u − i
#[derive(Clone, Copy, Debug)]
pub struct MotorLag;

impl Effect for MotorLag {
    const INFO: EffectInfo = EffectInfo {
        name: "motor-lag",
        equation: "T di/dt = u − i",
        meaning: "winding inductance and the bandwidth of the current drive",
        source: "Franklin, Powell & Emami-Naeini, Feedback Control of Dynamic Systems, ch. 2, armature circuit of a motor",
        fingerprint: "after a step of the command the acceleration rises gradually; while balancing, the loop rings",
        prior: Prior { commonness: Commonness::Occasional, reason: "a current loop that is slow beside the samples" },
        role: Role::Motor,
        parameters: &[ParameterInfo {
            name: "motor_lag",
            unit: "s",
            meaning: "time constant",
            plausible: (2e-4, 0.1),
            bounds: (0.0, 10.0),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        // The firmware of widespread drives ramps a command over 0.3 to 0.4 s as it is shipped (VESC, ramp times in
        // appconf_default.h).
        physical: &[PhysicalRange {
            parameter: 0,
            over: None,
            range: (0.0, 0.5),
            reason: "L/R of a small motor is 0.1 to 5 ms, its current loop is faster, and a drive that smooths its \
             command takes a few tenths of a second",
        }],
        starts: &[&[1e-3], &[2e-2]],
        absent: Some(&[0.0]),
        confused_with: &["input-delay", "wheel-speed-lag"],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        timing: Some(Timing::Lag),
        is_electrical: true,
        hiding: Some(Hiding { parameters: |s, _| vec![s], first_guess: 5e-3, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn lag_s<S: Scalar>(p: &[S]) -> Option<S> {
        Some(p[0])
    }
}
