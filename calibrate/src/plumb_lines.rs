//! Centre of mass from plumb lines (thesis 3.4).
//!
//! The body hangs from a point; the plumb line through it passes through the centre of mass. Two
//! lines, drawn on the body from two points of suspension, cross there. With the line through the
//! marks p and q and its unit normal n, nᵀ c = nᵀ p; more than two lines are solved by weighted
//! least squares.
//!
//! An error e of each mark (standard deviation σ per coordinate) moves the line at the centre
//! of mass, which lies at the fraction s of the way from p to q, by (1 − s) e_p + s e_q. Its
//! standard deviation there is σ √((1 − s)² + s²). A centre far beyond the marks is therefore
//! poorly determined, and so is one from nearly parallel lines.

use crate::error::CalibrationError;
use crate::error::{at_least, positive};
use nalgebra::{Matrix2, Vector2};

/// A plumb line, given by two marks on the body, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlumbLine {
    /// One mark, such as the point of suspension, m.
    pub first: Vector2<f64>,
    /// Another mark, far from the first, m.
    pub second: Vector2<f64>,
}

/// The centre of mass.
#[derive(Clone, Debug, PartialEq)]
pub struct CentreOfMass {
    /// Position in the frame of the marks, m.
    pub position_m: Vector2<f64>,
    /// Covariance of the position, m².
    pub covariance_m2: Matrix2<f64>,
    /// Distance from the pivot, m: l in the thesis.
    pub pivot_to_com_m: f64,
    /// Its standard error, m.
    pub pivot_to_com_std_m: f64,
    /// Distance of the centre from each line, m; zero for two lines.
    pub residuals_m: Vec<f64>,
    /// Angle between the most different of the lines, rad in (0, π/2].
    pub crossing_angle_rad: f64,
}

/// Smallest crossing angle, rad; below it, σ is enlarged more than sixfold.
const CROSSING_MIN_RAD: f64 = 0.17;

/// The crossing of at least two lines. `pivot` is assumed as accurate as a mark; `mark_std_m` is the
/// standard deviation of each coordinate of a mark.
///
/// # Errors
/// Fewer than two lines, marks that coincide, lines that are nearly parallel (10°).
pub fn centre_of_mass(
    lines: &[PlumbLine],
    pivot: Vector2<f64>,
    mark_std_m: f64,
) -> Result<CentreOfMass, CalibrationError> {
    let mark_std = positive("the standard deviation of a mark", mark_std_m)?;
    at_least("plumb lines", lines.len(), 2)?;
    let mut directions = Vec::with_capacity(lines.len());
    for line in lines {
        let along = line.second - line.first;
        let length = positive("the distance between two marks", along.norm())?;
        directions.push(along / length);
    }
    let mut crossing_angle_rad = 0.0_f64;
    for (index, one) in directions.iter().enumerate() {
        for other in &directions[..index] {
            crossing_angle_rad = crossing_angle_rad.max(one.perp(other).abs().min(1.0).asin());
        }
    }
    if crossing_angle_rad < CROSSING_MIN_RAD {
        return Err(CalibrationError::NotDetermined {
            what: "the centre of mass",
            why: "the plumb lines are nearly parallel",
            cure: "hang the body from points whose lines cross at a large angle",
        });
    }
    // The weights depend on the position of the centre on each line; the first ones are equal.
    let mut weights = vec![1.0; lines.len()];
    let mut position = Vector2::zeros();
    let mut normal_matrix = Matrix2::zeros();
    for _ in 0..10 {
        normal_matrix = Matrix2::zeros();
        let mut right = Vector2::zeros();
        for ((line, along), weight) in lines.iter().zip(&directions).zip(&weights) {
            let normal = Vector2::new(-along.y, along.x);
            normal_matrix += normal * normal.transpose() * *weight;
            right += normal * (normal.dot(&line.first) * weight);
        }
        position = normal_matrix
            .try_inverse()
            .ok_or(CalibrationError::BadNumber {
                what: "a mark",
                value: f64::NAN,
            })?
            * right;
        for (line, weight) in lines.iter().zip(&mut weights) {
            let along = line.second - line.first;
            let share = (position - line.first).dot(&along) / along.norm_squared();
            let variance = mark_std * mark_std * ((1.0 - share).powi(2) + share * share);
            *weight = 1.0 / variance;
        }
    }
    let residuals_m: Vec<f64> = lines
        .iter()
        .zip(&directions)
        .map(|(line, along)| along.perp(&(position - line.first)))
        .collect();
    let chi_squared: f64 = residuals_m
        .iter()
        .zip(&weights)
        .map(|(residual, weight)| residual * residual * weight)
        .sum();
    let freedom = lines.len() - 2;
    let enlargement = if freedom == 0 {
        1.0
    } else {
        (chi_squared / freedom as f64).max(1.0)
    };
    let covariance_m2 = normal_matrix
        .try_inverse()
        .ok_or(CalibrationError::BadNumber {
            what: "a mark",
            value: f64::NAN,
        })?
        * enlargement;
    let arm = position - pivot;
    let distance = arm.norm();
    let radial = if distance > 0.0 {
        arm / distance
    } else {
        Vector2::x()
    };
    let variance = (covariance_m2 * radial).dot(&radial) + mark_std * mark_std;
    Ok(CentreOfMass {
        position_m: position,
        covariance_m2,
        pivot_to_com_m: distance,
        pivot_to_com_std_m: variance.sqrt(),
        residuals_m,
        crossing_angle_rad,
    })
}
