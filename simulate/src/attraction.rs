//! The region of attraction of the saturated loop: an ellipsoid xᵀ P x ≤ s², enlarged until the loop does not
//! return from a start on its boundary.
//!
//! The checker proves in exact arithmetic what can be proved: return from s ≤ 1, where no
//! command saturates. Beyond that, simulation gives evidence: starts are distributed over the boundary, and each is
//! run until it is well inside the proved set, or the body has fallen.

use crate::closed_loop::ClosedLoop;
use crate::error::{SimulateError, check_positive};
use crate::law::Law;
use crate::recovery::decided_after_s;
use crate::scenario::Scale;
use nalgebra::{Cholesky, Matrix3, Vector3};
use plant::State;
use std::f64::consts::PI;

/// A start counts as brought back once its size is below this; from there, the linear loop returns.
const INSIDE: f64 = 0.25;
/// The set is enlarged by this factor until a start is lost.
const GROWTH: f64 = 1.1;
/// Largest size that is tried.
const LARGEST: f64 = 10.0;

/// The result of the enlargement.
#[derive(Clone, Debug, PartialEq)]
pub struct Attraction {
    /// s: the largest size with return from every start; 0 if the smallest size already had a start without return.
    pub size: f64,
    /// The smallest size with a start without return.
    pub lost_size: f64,
    /// The start of this size that did not return: angle from upright (rad), rate and wheel speed (rad/s).
    pub lost: [f64; 3],
    /// Largest angle (rad), rate and wheel speed (rad/s) of the set of size s.
    pub extents: [f64; 3],
    /// Starts on each boundary.
    pub starts: usize,
}

/// Enlarges the ellipsoid of `shape` (P, in rad and rad/s) in the loop `on` under `law`, with `starts`
/// starts on every boundary, until a start does not return. The size is then refined to `resolution`.
///
/// # Errors
/// If the shape is not positive definite, there is no start, or the resolution is not positive; those of
/// [`ClosedLoop::run`]; [`SimulateError::NotPositive`] if every start returns at ten times the shape.
pub fn region_of_attraction(
    on: &ClosedLoop<'_>,
    scale: &Scale,
    law: &mut dyn Law,
    shape: &Matrix3<f64>,
    starts: usize,
    resolution: f64,
) -> Result<Attraction, SimulateError> {
    check_positive("the resolution of the size", resolution)?;
    check_positive("the number of starts", starts as f64)?;
    let not_an_ellipsoid = || SimulateError::NotPositive {
        what: "the least eigenvalue of the ellipsoid's matrix",
        value: shape.symmetric_eigenvalues().min(),
    };
    // x = L⁻ᵀ u maps the unit sphere to the boundary of size 1.
    let root = Cholesky::new(*shape).ok_or_else(not_an_ellipsoid)?;
    let to_boundary = root.l().transpose().try_inverse();
    let to_boundary = to_boundary.ok_or_else(not_an_ellipsoid)?;
    let directions: Vec<Vector3<f64>> = sphere(starts).map(|u| to_boundary * u).collect();
    let duration_s = decided_after_s(scale);
    let mut lost_at = |size: f64| -> Result<Option<[f64; 3]>, SimulateError> {
        for direction in &directions {
            let start = direction * size;
            if !comes_back(on, law, shape, &start, duration_s)? {
                return Ok(Some(start.into()));
            }
        }
        Ok(None)
    };
    let mut size = 0.0;
    let mut tried = 1.0;
    let (mut lost_size, mut lost) = loop {
        match lost_at(tried)? {
            Some(start) => break (tried, start),
            None if tried >= LARGEST => {
                return Err(SimulateError::NotPositive {
                    what: "the number of starts that are lost at ten times the ellipsoid",
                    value: 0.0,
                });
            }
            None => {
                size = tried;
                tried *= GROWTH;
            }
        }
    };
    while lost_size - size > resolution {
        let middle = 0.5 * (size + lost_size);
        match lost_at(middle)? {
            Some(start) => (lost_size, lost) = (middle, start),
            None => size = middle,
        }
    }
    let inverse = root.inverse();
    Ok(Attraction {
        size,
        lost_size,
        lost,
        extents: [0, 1, 2].map(|i| size * inverse[(i, i)].sqrt()),
        starts,
    })
}

/// Whether a run from `start` gets well into the ellipsoid before the body falls.
fn comes_back(
    on: &ClosedLoop<'_>,
    law: &mut dyn Law,
    shape: &Matrix3<f64>,
    start: &Vector3<f64>,
    duration_s: f64,
) -> Result<bool, SimulateError> {
    let state = State {
        angle_rad: PI + start[0],
        rate_rad_s: start[1],
        wheel_speed_rad_s: start[2],
        ..State::rest()
    };
    let is_inside = |angle: f64, rate: f64, speed: f64| {
        let x = Vector3::new(angle, rate, speed);
        x.dot(&(shape * x)) <= INSIDE * INSIDE
    };
    let (trace, _) = on.run_until(&state, duration_s, law, |trace| {
        let last = trace.len() - 1;
        trace.fell_at_s.is_some()
            || is_inside(
                trace.angle_rad[last],
                trace.rate_rad_s[last],
                trace.wheel_speed_rad_s[last],
            )
    })?;
    Ok(trace.fell_at_s.is_none() && trace.time_s.last().is_some_and(|end| *end < duration_s))
}

/// Points distributed evenly over the unit sphere (Fibonacci spiral).
fn sphere(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    let golden = PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |index| {
        let z = 1.0 - (2 * index + 1) as f64 / count as f64;
        let width = (1.0 - z * z).sqrt();
        let (sine, cosine) = (golden * index as f64).sin_cos();
        Vector3::new(width * cosine, width * sine, z)
    })
}
