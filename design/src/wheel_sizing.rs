//! The required size of the wheel: energy, momentum, and the two limits of the drive.
//!
//! A body at rest at the angle θ from upright lacks the energy E = G (1 − cos θ). The motor can supply
//! it only while its torque T = τ u_max exceeds that of gravity, θ < asin(T/G) (*current limit*), and only
//! until the wheel reaches its top speed (*speed limit*).
//!
//! The smallest wheel speed that any control needs is that of a full push followed by coasting, since
//! gravity adds momentum during every further moment. With D = Θ − j_w, δ the angle from upright and no
//! friction, D δ̈ = G sin δ − T during the push. It may end at
//!
//! ```text
//! δ_s = θ − G (1 − cos θ)/T        (T (θ − δ_s) = E: the work of the push is the missing energy)
//! ```
//!
//! and takes t = ∫ dδ/√((2/D)(G (cos θ − cos δ) + T (θ − δ))) from δ_s to θ. The wheel's speed
//! relative to the body has then changed by T t/j_w from the torque and by |δ̇_s| from the body's
//! own rotation, D δ̇_s²/2 = G (1 − cos δ_s). No law with feedback reaches this bound: it is the
//! minimum that the hardware must allow. Figure 2.2 of the thesis shows energy over inertia and
//! speed; [`chart`] gives that and the angle.

use crate::error::DesignError;
use crate::matrix::check_positive;

/// The data of a bench for the sizing; SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizing {
    /// Θ, total moment of inertia about the pivot with the wheel, in kg m².
    pub total_inertia: f64,
    /// j_w, moment of inertia of the wheel, in kg m².
    pub wheel_inertia: f64,
    /// G, in N m.
    pub gravity_torque: f64,
    /// T = τ u_max, in N m.
    pub largest_torque: f64,
}

/// The smallest push that brings the body up from rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizingPush {
    /// Energy that the body lacks, in J.
    pub energy_j: f64,
    /// Duration of the push, s.
    pub duration_s: f64,
    /// Angle from upright at the end of the push, rad.
    pub release_angle_rad: f64,
    /// Body rate towards upright at the end of the push, rad/s.
    pub release_rate_rad_s: f64,
    /// Change of the wheel's speed relative to the body, in rad/s.
    pub wheel_speed_rad_s: f64,
}

/// One wheel at one top speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartPoint {
    /// j_w in kg m².
    pub wheel_inertia: f64,
    /// Top speed in rad/s.
    pub wheel_speed_rad_s: f64,
    /// Energy in the wheel at top speed, in J.
    pub wheel_energy_j: f64,
    /// Largest angle from which the body can recover within both limits, rad.
    pub recoverable_angle_rad: f64,
    /// Energy that the body lacks at that angle, in J.
    pub recovered_energy_j: f64,
}

impl Sizing {
    fn check(&self) -> Result<(), DesignError> {
        check_positive("the wheel inertia in kg m2", self.wheel_inertia)?;
        check_positive(
            "the inertia of the bench without the spin of its wheel in kg m2",
            self.total_inertia - self.wheel_inertia,
        )?;
        check_positive("the gravity torque in N m", self.gravity_torque)?;
        check_positive("the largest motor torque in N m", self.largest_torque)
    }

    /// D = Θ − j_w.
    fn carried_inertia(&self) -> f64 {
        self.total_inertia - self.wheel_inertia
    }

    /// Energy in J that the body lacks at rest at `angle_rad` from upright.
    pub fn energy_to_recover_j(&self, angle_rad: f64) -> f64 {
        // 1 − cos θ = 2 sin²(θ/2) keeps its accuracy at small angles.
        2.0 * self.gravity_torque * (0.5 * angle_rad).sin().powi(2)
    }

    /// The angle in rad at which the motor just balances gravity.
    ///
    /// # Errors
    /// Quantities that are not positive.
    pub fn angle_at_current_limit_rad(&self) -> Result<f64, DesignError> {
        self.check()?;
        Ok((self.largest_torque / self.gravity_torque).min(1.0).asin())
    }

    /// The smallest push that brings the body from rest at `angle_rad` (0 < θ < π/2) to upright; `None` if
    /// the motor is weaker than gravity there.
    ///
    /// # Errors
    /// Quantities that are not positive.
    pub fn least_push(&self, angle_rad: f64) -> Result<Option<SizingPush>, DesignError> {
        check_positive("the angle from upright in rad", angle_rad)?;
        if angle_rad >= self.angle_at_current_limit_rad()? {
            return Ok(None);
        }
        let energy_j = self.energy_to_recover_j(angle_rad);
        let turned = energy_j / self.largest_torque;
        let release_angle_rad = angle_rad - turned;
        let inertia = self.carried_inertia();
        // With δ = θ − s², the slow start is no singularity: dt = 2 s ds/δ̇(s²).
        let end = turned.sqrt();
        let mut duration_s = 0.0;
        const PANELS: usize = 64;
        let half = 0.5 * end / PANELS as f64;
        for panel in 0..PANELS {
            for (node, weight) in [(-0.6_f64.sqrt(), 5.0), (0.0, 8.0), (0.6_f64.sqrt(), 5.0)] {
                let s = half * ((2 * panel + 1) as f64 + node);
                let way = s * s;
                // (cos θ − cos(θ − x))/x, written without a difference of nearly equal numbers.
                let lifted = -2.0 * (angle_rad - 0.5 * way).sin() * (0.5 * way).sin() / way;
                let mean_torque = self.largest_torque + self.gravity_torque * lifted;
                duration_s += half * weight / 9.0 * 2.0 / (2.0 * mean_torque / inertia).sqrt();
            }
        }
        let release_rate_rad_s =
            (2.0 * self.energy_to_recover_j(release_angle_rad) / inertia).sqrt();
        Ok(Some(SizingPush {
            energy_j,
            duration_s,
            release_angle_rad,
            release_rate_rad_s,
            wheel_speed_rad_s: self.largest_torque * duration_s / self.wheel_inertia
                + release_rate_rad_s,
        }))
    }

    /// The largest angle in rad from which a wheel that may change its speed by
    /// `wheel_speed_rad_s` can recover; at most the angle of the current limit.
    ///
    /// # Errors
    /// Quantities that are not positive.
    pub fn recoverable_angle_rad(&self, wheel_speed_rad_s: f64) -> Result<f64, DesignError> {
        check_positive("the top speed of the wheel in rad/s", wheel_speed_rad_s)?;
        let limit = self.angle_at_current_limit_rad()?;
        // The speed grows with the angle, without bound towards the current limit.
        let (mut low, mut high) = (0.0, limit);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            match self.least_push(middle)? {
                Some(push) if push.wheel_speed_rad_s <= wheel_speed_rad_s => low = middle,
                _ => high = middle,
            }
        }
        Ok(low)
    }
}

/// ½ j_w ω² in J of a wheel of `wheel_inertia` kg m² at `wheel_speed_rad_s`.
pub fn wheel_energy_j(wheel_inertia: f64, wheel_speed_rad_s: f64) -> f64 {
    0.5 * wheel_inertia * wheel_speed_rad_s * wheel_speed_rad_s
}

/// Every combination of wheel inertia (kg m²) and top speed (rad/s), on a bench that is otherwise `bench`.
/// The wheel's mass is constant and only its shape changes, so D and G are constant and Θ grows with j_w.
///
/// # Errors
/// Quantities that are not positive.
pub fn chart(
    bench: &Sizing,
    wheel_inertias: &[f64],
    wheel_speeds_rad_s: &[f64],
) -> Result<Vec<ChartPoint>, DesignError> {
    let mut points = Vec::with_capacity(wheel_inertias.len() * wheel_speeds_rad_s.len());
    for &wheel_inertia in wheel_inertias {
        let other = Sizing {
            wheel_inertia,
            total_inertia: bench.carried_inertia() + wheel_inertia,
            ..*bench
        };
        for &wheel_speed_rad_s in wheel_speeds_rad_s {
            let recoverable_angle_rad = other.recoverable_angle_rad(wheel_speed_rad_s)?;
            points.push(ChartPoint {
                wheel_inertia,
                wheel_speed_rad_s,
                wheel_energy_j: wheel_energy_j(wheel_inertia, wheel_speed_rad_s),
                recoverable_angle_rad,
                recovered_energy_j: other.energy_to_recover_j(recoverable_angle_rad),
            });
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BENCH: Sizing = Sizing {
        total_inertia: 2.30344e-3,
        wheel_inertia: 1.36125e-4,
        gravity_torque: 0.245158,
        largest_torque: 2.0 * 0.0335,
    };

    /// The oracle: the nonlinear motion in small steps, pushing until the energy suffices.
    #[test]
    fn the_push_brings_the_body_just_upright() {
        for degrees in [1.0, 5.0, 10.0, 15.0] {
            let push = BENCH.least_push(f64::to_radians(degrees)).unwrap().unwrap();
            let d = BENCH.total_inertia - BENCH.wheel_inertia;
            let steps = 20_000;
            let h = push.duration_s / f64::from(steps);
            let acceleration =
                |angle: f64| (BENCH.gravity_torque * angle.sin() - BENCH.largest_torque) / d;
            let (mut angle, mut rate) = (f64::to_radians(degrees), 0.0);
            for _ in 0..steps {
                // Classical Runge-Kutta.
                let (k1, l1) = (rate, acceleration(angle));
                let (k2, l2) = (rate + 0.5 * h * l1, acceleration(angle + 0.5 * h * k1));
                let (k3, l3) = (rate + 0.5 * h * l2, acceleration(angle + 0.5 * h * k2));
                let (k4, l4) = (rate + h * l3, acceleration(angle + h * k3));
                angle += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                rate += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
            }
            assert!((angle - push.release_angle_rad).abs() < 1e-8, "{degrees}");
            assert!((rate + push.release_rate_rad_s).abs() < 1e-7, "{degrees}");
            // The remaining kinetic energy is the energy that gravity takes on the way to upright.
            let energy = 0.5 * d * rate * rate;
            assert!((energy - BENCH.energy_to_recover_j(angle)).abs() < 1e-8 * push.energy_j);
            // j_w (α̈ + φ̈) = T.
            let wheel = BENCH.largest_torque * push.duration_s / BENCH.wheel_inertia - rate;
            assert!((wheel - push.wheel_speed_rad_s).abs() < 1e-6);
        }
    }

    #[test]
    fn a_strong_motor_needs_only_momentum() {
        // For T → ∞ the push becomes an impulse with Δφ̇ → (Θ/j_w) √(2E/D).
        let strong = Sizing {
            largest_torque: 1e4,
            ..BENCH
        };
        let push = strong.least_push(0.2).unwrap().unwrap();
        let d = BENCH.total_inertia - BENCH.wheel_inertia;
        let blow = BENCH.total_inertia / BENCH.wheel_inertia * (2.0 * push.energy_j / d).sqrt();
        assert!((push.wheel_speed_rad_s / blow - 1.0).abs() < 1e-4);
        // A weaker motor needs a larger change of the wheel's speed.
        assert!(BENCH.least_push(0.2).unwrap().unwrap().wheel_speed_rad_s > blow);
    }

    #[test]
    fn angles_at_both_limits() {
        let current = BENCH.angle_at_current_limit_rad().unwrap();
        assert!((current.to_degrees() - 15.86).abs() < 0.005);
        assert!(BENCH.least_push(current * 1.0001).unwrap().is_none());
        // At 700 rad/s, the bench's top speed, the current is the limit in practice.
        let fast = BENCH.recoverable_angle_rad(700.0).unwrap();
        assert!(fast < current && fast > 0.98 * current);
        // At 50 rad/s the wheel is the limit, and the push then uses all of it.
        let slow = BENCH.recoverable_angle_rad(50.0).unwrap();
        let push = BENCH.least_push(slow).unwrap().unwrap();
        assert!((push.wheel_speed_rad_s - 50.0).abs() < 1e-6);
    }

    #[test]
    fn larger_and_faster_wheels_recover_from_more() {
        let inertias = [0.5e-4, 1e-4, 2e-4];
        let speeds = [20.0, 80.0, 320.0];
        let points = chart(&BENCH, &inertias, &speeds).unwrap();
        let angle = |i: usize, j: usize| points[3 * i + j].recoverable_angle_rad;
        for i in 0..3 {
            for j in 0..3 {
                assert!(i == 0 || angle(i, j) > angle(i - 1, j));
                assert!(j == 0 || angle(i, j) > angle(i, j - 1));
                let point = points[3 * i + j];
                let energy = 0.5 * inertias[i] * speeds[j].powi(2);
                assert!((point.wheel_energy_j - energy).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn impossible_benches_are_named() {
        let wrong = Sizing {
            wheel_inertia: 1.0,
            ..BENCH
        };
        assert!(matches!(
            wrong.least_push(0.1),
            Err(DesignError::NotPositive { .. })
        ));
        assert!(BENCH.recoverable_angle_rad(-1.0).is_err());
        assert!(BENCH.least_push(f64::NAN).is_err());
    }
}
