//! The largest angle from which the loop recovers, by bisection, compared with the largest angle from which
//! any law could: asin(τ u_max/G).

use crate::closed_loop::{ClosedLoop, at_rest};
use crate::error::{SimulateError, check_positive};
use crate::law::Law;
use crate::scenario::Scale;

/// The result of the bisection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recovery {
    /// Largest angle, from rest with the wheel still, from which the loop recovered, in rad.
    pub recovered_rad: f64,
    /// Smallest angle from which it did not, in rad.
    pub lost_rad: f64,
    /// asin(τ u_max/G) in rad.
    pub limit_rad: f64,
}

/// Length of a run, in times in which a fall grows by a factor e. A body that is still
/// undecided after that would be balanced within e⁻¹⁰⁰, which no double can represent.
const FALL_TIMES: f64 = 100.0;

/// The largest angle from which `law` brings the body back on the bench `on`, with the error
/// `resolution_rad`. The pushes of `on` act.
///
/// # Errors
/// Times or a resolution that are not positive; a law that fails; a motion that is no longer finite.
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

/// The length of a run in s after which it is certain whether the body falls.
pub(crate) fn decided_after_s(scale: &Scale) -> f64 {
    FALL_TIMES * (scale.carried_inertia / scale.gravity_torque).sqrt()
}

/// The largest angle for which `recovers` returns `true`, with the error `resolution_rad`.
pub(crate) fn bisect(
    scale: &Scale,
    resolution_rad: f64,
    mut recovers: impl FnMut(f64) -> Result<bool, SimulateError>,
) -> Result<Recovery, SimulateError> {
    check_positive("the resolution of the angle in rad", resolution_rad)?;
    let limit_rad = scale.holding_angle_rad();
    // Beyond the limit, no law recovers; an angle slightly beyond it bounds the search.
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
