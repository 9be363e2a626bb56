//! The largest angle from which the loop recovers, by bisection, beside the largest angle at which
//! any law could: asin(τ u_max/G).

use crate::closed_loop::{ClosedLoop, at_rest};
use crate::error::{SimulateError, check_positive};
use crate::law::Law;
use crate::scenario::Scale;

/// What the bisection found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recovery {
    /// Largest angle from rest, with the wheel still, that was recovered from, in rad.
    pub recovered_rad: f64,
    /// Smallest angle that was not, in rad.
    pub lost_rad: f64,
    /// asin(τ u_max/G) in rad.
    pub limit_rad: f64,
}

/// Runs are this many times as long as the fall takes to grow by a factor e. A body that is still
/// undecided then has been held against gravity to within e⁻¹⁰⁰ of balance, which no double can.
const FALL_TIMES: f64 = 100.0;

/// The largest angle from which `law` brings the body back on the bench `on`, found to within
/// `resolution_rad`. Pushes of `on` act.
///
/// # Errors
/// Those of [`ClosedLoop::run`]; a resolution that is not positive.
pub fn largest_recoverable_angle(
    on: &ClosedLoop<'_>,
    scale: &Scale,
    law: &mut dyn Law,
    resolution_rad: f64,
) -> Result<Recovery, SimulateError> {
    let duration_s = decided_after_s(scale);
    let recovers = |angle_rad: f64| {
        on.run(&at_rest(angle_rad), duration_s, law, true)
            .map(|trace| trace.fell_at_s.is_none())
    };
    bisect(scale, resolution_rad, recovers)
}

/// The length of a run after which it is decided whether the body falls, in s.
pub(crate) fn decided_after_s(scale: &Scale) -> f64 {
    FALL_TIMES * (scale.carried_inertia / scale.gravity_torque).sqrt()
}

/// The largest angle for which `recovers` says so, found to within `resolution_rad`.
pub(crate) fn bisect(
    scale: &Scale,
    resolution_rad: f64,
    mut recovers: impl FnMut(f64) -> Result<bool, SimulateError>,
) -> Result<Recovery, SimulateError> {
    check_positive("the resolution of the angle in rad", resolution_rad)?;
    let limit_rad = scale.holding_angle_rad();
    // Beyond the limit nothing recovers; a little beyond it bounds the search.
    let (mut recovered_rad, mut lost_rad) = (0.0, limit_rad * 1.01);
    while lost_rad - recovered_rad > resolution_rad {
        let middle = 0.5 * (recovered_rad + lost_rad);
        if recovers(middle)? {
            recovered_rad = middle;
        } else {
            lost_rad = middle;
        }
    }
    Ok(Recovery {
        recovered_rad,
        lost_rad,
        limit_rad,
    })
}
