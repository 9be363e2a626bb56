//! Madgwick's gradient-descent orientation filter, six and nine axes.
//!
//! Source: S. O. H. Madgwick, "An efficient orientation filter for inertial and
//! inertial/magnetic sensor arrays", report, University of Bristol, 2010. Equation numbers are
//! the report's.
//!
//! # Gyroscope
//! The quaternion's derivative at the rate ω = (ω_x, ω_y, ω_z) is q̇_ω = ½ q ⊗ (0, ω) (eq. 11–12).
//!
//! # Measured directions
//! A field d known in the earth frame and measured as s in the sensor frame gives the error
//! f = q* ⊗ d ⊗ q − s (eq. 15). With the rows of the rotation matrix of q
//!
//! - e = (2(½ − q₃² − q₄²), 2(q₂q₃ − q₁q₄), 2(q₁q₃ + q₂q₄)), the earth's x axis in S,
//! - v = (2(q₂q₄ − q₁q₃), 2(q₁q₂ + q₃q₄), 2(½ − q₂² − q₃²)), the earth's z axis in S,
//!
//! gravity, d = (0, 0, 1), gives f_g = v − a (eq. 25) and a magnetic field d = (b_x, 0, b_z)
//! gives f_b = b_x e + b_z v − m (eq. 29). All measured vectors are normalised first.
//!
//! The gradient of ½‖f‖² is Jᵀf (eq. 20). With the Jacobians of eq. 26 and 30 it can be written
//! with two vectors, w = f_g + b_z f_b (the factor of v) and u = b_x f_b (the factor of e):
//!
//! - ½∇₁ = −q₃w₁ + q₂w₂ + q₃u₃ − q₄u₂
//! - ½∇₂ = q₄w₁ + q₁w₂ − 2q₂w₃ + q₃u₂ + q₄u₃
//! - ½∇₃ = −q₁w₁ + q₄w₂ − 2q₃w₃ − 2q₃u₁ + q₂u₂ + q₁u₃
//! - ½∇₄ = q₂w₁ + q₃w₂ − 2q₄u₁ − q₁u₂ + q₂u₃
//!
//! (for six axes w = f_g and u = 0).
//!
//! # Step
//! q ← q + T (q̇_ω − β ∇/‖∇‖), then normalised (eq. 42–44). The correction is left out where
//! all components of ½∇ are below [`GRADIENT_MIN`]: there the estimate agrees with the measurement.
//!
//! # Magnetic reference
//! h = q ⊗ m ⊗ q* is the measured field in the estimated earth frame (eq. 45), and
//! b = (√(h_x² + h_y²), 0, h_z) (eq. 46), so that the heading's error does not tilt the vertical.
//! The widely copied C code computes 2b and uses it as b; here, b is a part of a unit vector.
//! Copies of that code that return early at zero rate skip the correction of a resting sensor; here, a zero
//! rate is not a special case.
//!
//! # The magnetometer for the heading alone
//! In [`Madgwick::step_marg`] a magnetic disturbance, such as the field of a motor, tilts the estimate. Madgwick's
//! thesis (S. O. H. Madgwick, "AHRS algorithms and calibration solutions to facilitate new applications using low-cost
//! MEMS", PhD thesis, University of Bristol, 2014) uses the magnetometer for the heading alone.
//! [`Madgwick::turn_to_north`] does that after a six-axis step: with the measured field of length 1 in the estimated
//! earth frame, h = q ⊗ m ⊗ q*, the estimate is turned about the vertical by −h_y, or by the largest turn where north
//! lies behind (h_x ≤ 0). The largest turn is 2 β T. The emitted filter does the same.

use crate::pivot_angle::up_in_sensor;
use nalgebra::{Quaternion, Vector3, Vector4};

/// Where all components of the half gradient ½∇ are below this, no correction is made: about 4 µrad of tilt, far
/// below the noise of any accelerometer and well above the resolution of the fixed-point filter.
pub const GRADIENT_MIN: f64 = 1.0 / 262_144.0;

/// Horizontal share of the magnetic field below which it shows no heading (at 4° from a pole).
pub const HORIZONTAL_FIELD_MIN: f64 = 1.0 / 16.0;

/// The filter's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Madgwick {
    q: Quaternion<f64>,
    beta_rad_s: f64,
    sample_time_s: f64,
}

impl Madgwick {
    /// Starts with the sensor frame on the earth frame, q = (1, 0, 0, 0).
    pub fn new(beta_rad_s: f64, sample_time_s: f64) -> Self {
        Madgwick {
            q: Quaternion::identity(),
            beta_rad_s,
            sample_time_s,
        }
    }

    /// The attitude, a unit quaternion.
    pub fn quaternion(&self) -> Quaternion<f64> {
        self.q
    }

    /// Sets the attitude to the shortest turn from the earth frame that agrees with `accel`
    /// (any unit): q ∝ (1 + v_z, v_y, −v_x, 0), or (0, 1, 0, 0) where v points straight down.
    /// The zero vector changes nothing.
    pub fn align(&mut self, accel: &Vector3<f64>) {
        let Some(up) = accel.try_normalize(0.0) else {
            return;
        };
        let turn = Quaternion::new(1.0 + up.z, up.y, -up.x, 0.0);
        self.q = if turn.as_vector().amax() < 1.0 / 1024.0 {
            Quaternion::new(0.0, 1.0, 0.0, 0.0)
        } else {
            turn.normalize()
        };
    }

    /// One step by the gyroscope alone (`rate` in rad/s).
    pub fn step_gyro(&mut self, rate: &Vector3<f64>) {
        self.integrate(rate, &Vector4::zeros());
    }

    /// One six-axis step. `rate` in rad/s, `accel` in any unit; a zero `accel` is not used.
    pub fn step_imu(&mut self, rate: &Vector3<f64>, accel: &Vector3<f64>) {
        let Some(measured_up) = accel.try_normalize(0.0) else {
            return self.step_gyro(rate);
        };
        let w = up_in_sensor(&self.q) - measured_up;
        let half_gradient = self.half_gradient(&w, &Vector3::zeros());
        self.integrate(rate, &half_gradient);
    }

    /// One six-axis step like [`Madgwick::step_imu`]. Returns vec(q* ⊗ ∇/‖∇‖) before the step, which is half of
    /// Madgwick's ω_ε (eq. 47) and zero if no correction is made.
    pub fn step_imu_with_error(
        &mut self,
        rate: &Vector3<f64>,
        accel: &Vector3<f64>,
    ) -> Vector3<f64> {
        let Some(measured_up) = accel.try_normalize(0.0) else {
            self.step_gyro(rate);
            return Vector3::zeros();
        };
        let w = up_in_sensor(&self.q) - measured_up;
        let half_gradient = self.half_gradient(&w, &Vector3::zeros());
        let error = if half_gradient.amax() >= GRADIENT_MIN {
            let unit = half_gradient.normalize();
            let unit = Quaternion::new(unit[0], unit[1], unit[2], unit[3]);
            (self.q.conjugate() * unit).imag()
        } else {
            Vector3::zeros()
        };
        self.integrate(rate, &half_gradient);
        error
    }

    /// One nine-axis step. `rate` in rad/s, `accel` and `mag` in any units. Without a usable
    /// field (zero, or nearly vertical) it is the six-axis step; if `accel` is zero, the gyroscope alone is used.
    pub fn step_marg(&mut self, rate: &Vector3<f64>, accel: &Vector3<f64>, mag: &Vector3<f64>) {
        let (Some(measured_up), Some(field)) = (accel.try_normalize(0.0), mag.try_normalize(0.0))
        else {
            return self.step_imu(rate, accel);
        };
        let q = &self.q;
        let up = up_in_sensor(q);
        let x_axis = Vector3::new(
            2.0 * (0.5 - q.j * q.j - q.k * q.k),
            2.0 * (q.i * q.j - q.w * q.k),
            2.0 * (q.w * q.j + q.i * q.k),
        );
        let y_axis = Vector3::new(
            2.0 * (q.i * q.j + q.w * q.k),
            2.0 * (0.5 - q.i * q.i - q.k * q.k),
            2.0 * (q.j * q.k - q.w * q.i),
        );
        let horizontal = x_axis.dot(&field).hypot(y_axis.dot(&field));
        let vertical = up.dot(&field);
        if horizontal < HORIZONTAL_FIELD_MIN {
            return self.step_imu(rate, accel);
        }
        let field_error = horizontal * x_axis + vertical * up - field;
        let w = up - measured_up + vertical * field_error;
        let u = horizontal * field_error;
        let half_gradient = self.half_gradient(&w, &u);
        self.integrate(rate, &half_gradient);
    }

    /// Turns the estimate about the vertical towards magnetic north, by at most 2 β T. `mag` in any unit; the zero
    /// vector and a field that is nearly vertical change nothing.
    pub fn turn_to_north(&mut self, mag: &Vector3<f64>) {
        let Some(field) = mag.try_normalize(0.0) else {
            return;
        };
        let h = (self.q * Quaternion::from_imag(field) * self.q.conjugate()).imag();
        if h.x.hypot(h.y) < HORIZONTAL_FIELD_MIN {
            return;
        }
        let largest = 2.0 * self.beta_rad_s * self.sample_time_s;
        let turn = if h.x > 0.0 {
            (-h.y).clamp(-largest, largest)
        } else if h.y > 0.0 {
            -largest
        } else {
            largest
        };
        let turn = Quaternion::new(1.0, 0.0, 0.0, 0.5 * turn);
        self.q = (turn * self.q).normalize();
    }

    /// ½∇ from the two error vectors of the module's text.
    fn half_gradient(&self, w: &Vector3<f64>, u: &Vector3<f64>) -> Vector4<f64> {
        let (q1, q2, q3, q4) = (self.q.w, self.q.i, self.q.j, self.q.k);
        Vector4::new(
            q3 * (u.z - w.x) + q2 * w.y - q4 * u.y,
            q4 * (w.x + u.z) + q1 * w.y - 2.0 * q2 * w.z + q3 * u.y,
            q1 * (u.z - w.x) + q4 * w.y - 2.0 * q3 * (w.z + u.x) + q2 * u.y,
            q2 * (w.x + u.z) + q3 * w.y - 2.0 * q4 * u.x - q1 * u.y,
        )
    }

    /// q ← normalised q + T (½ q ⊗ (0, ω) − β ∇/‖∇‖).
    fn integrate(&mut self, rate: &Vector3<f64>, half_gradient: &Vector4<f64>) {
        let half_angle = rate * (0.5 * self.sample_time_s);
        let mut next = self.q + self.q * Quaternion::from_imag(half_angle);
        if half_gradient.amax() >= GRADIENT_MIN {
            let gain = self.beta_rad_s * self.sample_time_s / half_gradient.norm();
            let step = half_gradient * gain;
            next -= Quaternion::new(step[0], step[1], step[2], step[3]);
        }
        self.q = next.normalize();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gradient against central differences of ½‖f‖² with f as eq. 25 and 29 print it.
    #[test]
    fn gradient_is_that_of_the_objective() {
        let accel = Vector3::new(0.3, -0.5, 0.81).normalize();
        let mag = Vector3::new(0.6, 0.2, -0.7).normalize();
        let (bx, bz) = (0.43, -0.9);
        let objective = |q: [f64; 4]| {
            let [q1, q2, q3, q4] = q;
            let v = [
                2.0 * (q2 * q4 - q1 * q3),
                2.0 * (q1 * q2 + q3 * q4),
                2.0 * (0.5 - q2 * q2 - q3 * q3),
            ];
            let e = [
                2.0 * (0.5 - q3 * q3 - q4 * q4),
                2.0 * (q2 * q3 - q1 * q4),
                2.0 * (q1 * q3 + q2 * q4),
            ];
            (0..3)
                .map(|i| (v[i] - accel[i]).powi(2) + (bx * e[i] + bz * v[i] - mag[i]).powi(2))
                .sum::<f64>()
                / 2.0
        };
        let q = Quaternion::new(0.7, -0.2, 0.4, 0.5).normalize();
        let mut filter = Madgwick::new(0.1, 1e-3);
        filter.q = q;
        let x_axis = Vector3::new(
            2.0 * (0.5 - q.j * q.j - q.k * q.k),
            2.0 * (q.i * q.j - q.w * q.k),
            2.0 * (q.w * q.j + q.i * q.k),
        );
        let error = bx * x_axis + bz * up_in_sensor(&q) - mag;
        let half = filter.half_gradient(&(up_in_sensor(&q) - accel + bz * error), &(bx * error));
        let point = [q.w, q.i, q.j, q.k];
        for axis in 0..4 {
            let at = |step: f64| {
                let mut moved = point;
                moved[axis] += step;
                objective(moved)
            };
            let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((slope - 2.0 * half[axis]).abs() < 1e-9, "axis {axis}");
        }
    }
}
