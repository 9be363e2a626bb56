//! The body angle about the pivot axis from the attitude.
//!
//! Let b be the body's axis from the pivot to the centre of mass and d the vertical downwards.
//! Turning by the body angle α about the pivot axis z takes d to b, and the mounting angle m
//! takes b to the sensor's x axis, so x = R_z(α + m) d. Upwards is −d = R_z(π − α − m) x: in the
//! sensor's frame the upward unit vector v has v_x = cos(π − α − m), v_y = sin(π − α − m), hence
//! the angle relative to upright
//!
//! θ = α − π = atan2(−v_y, v_x) − m, wrapped to [−π, π).
//!
//! Only the direction of gravity enters; the heading, which six axes do not observe, does not.

use nalgebra::{Quaternion, Vector3};
use std::f64::consts::{PI, TAU};

/// The upward unit vector in the sensor's frame, third row of the rotation matrix of q
/// (Madgwick 2010, eq. 25 without the measurement).
pub fn up_in_sensor(q: &Quaternion<f64>) -> Vector3<f64> {
    Vector3::new(
        2.0 * (q.i * q.k - q.w * q.j),
        2.0 * (q.w * q.i + q.j * q.k),
        2.0 * (0.5 - q.i * q.i - q.j * q.j),
    )
}

/// The body angle relative to upright, rad in [−π, π), from the attitude.
pub fn pivot_angle(q: &Quaternion<f64>, mounting_angle_rad: f64) -> f64 {
    pivot_angle_of_gravity(&up_in_sensor(q), mounting_angle_rad)
}

/// The body angle relative to upright, rad in [−π, π), from a vector that points upwards in the
/// sensor's frame (of any length, such as a still accelerometer's reading).
pub fn pivot_angle_of_gravity(up: &Vector3<f64>, mounting_angle_rad: f64) -> f64 {
    wrap_angle((-up.y).atan2(up.x) - mounting_angle_rad)
}

/// The angle wrapped to [−π, π), rad.
pub fn wrap_angle(angle_rad: f64) -> f64 {
    let wrapped = (angle_rad + PI).rem_euclid(TAU) - PI;
    // rem_euclid may round up to τ itself.
    if wrapped >= PI { -PI } else { wrapped }
}
