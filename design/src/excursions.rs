//! Weights from allowed excursions, and back: Bryson's rule.
//!
//! A state that may leave its rest by x has the weight 1/x², a current that may be u has 1/u²: at its allowed
//! excursion every quantity costs the same (Bryson and Ho, "Applied Optimal Control", 1975, section 5.2).

use nalgebra::Vector3;

use crate::error::DesignError;
use crate::lqr::Weights;
use crate::matrix::check_positive;

/// How far each quantity may leave its value at rest. A state whose excursion is infinite has no weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excursions {
    /// Angle from upright, rad.
    pub angle_rad: f64,
    /// Rate, rad/s.
    pub rate_rad_s: f64,
    /// Wheel speed, rad/s.
    pub wheel_speed_rad_s: f64,
    /// Current, A.
    pub current_a: f64,
}

impl Excursions {
    /// The weights with which each of these excursions costs the same: 1 per second.
    ///
    /// # Errors
    /// [`DesignError::NotPositive`] or [`DesignError::NotFinite`] for an excursion that is not a positive number; that
    /// of a state may be infinite.
    pub fn weights(&self) -> Result<Weights, DesignError> {
        let of_state = |what, excursion: f64| {
            if excursion == f64::INFINITY {
                return Ok(0.0);
            }
            check_positive(what, excursion)?;
            Ok::<f64, DesignError>(excursion.powi(-2))
        };
        check_positive("the allowed current in A", self.current_a)?;
        Ok(Weights {
            state: Vector3::new(
                of_state("the allowed angle in rad", self.angle_rad)?,
                of_state("the allowed rate in rad/s", self.rate_rad_s)?,
                of_state("the allowed wheel speed in rad/s", self.wheel_speed_rad_s)?,
            ),
            current: self.current_a.powi(-2),
        })
    }

    /// The excursions that these weights allow at equal cost.
    pub fn of(weights: &Weights) -> Excursions {
        let excursion = |weight: f64| weight.sqrt().recip();
        Excursions {
            angle_rad: excursion(weights.state[0]),
            rate_rad_s: excursion(weights.state[1]),
            wheel_speed_rad_s: excursion(weights.state[2]),
            current_a: excursion(weights.current),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lqr::discrete_regulator;
    use crate::thesis;

    #[test]
    fn every_allowed_excursion_costs_the_same() {
        let allowed = Excursions {
            angle_rad: 0.2,
            rate_rad_s: 1.5,
            wheel_speed_rad_s: 40.0,
            current_a: 0.8,
        };
        let weights = allowed.weights().unwrap();
        let costs = [
            weights.state[0] * 0.2_f64.powi(2),
            weights.state[1] * 1.5_f64.powi(2),
            weights.state[2] * 40.0_f64.powi(2),
            weights.current * 0.8_f64.powi(2),
        ];
        for cost in costs {
            assert!((cost - 1.0).abs() < 1e-14, "{cost}");
        }
        let back = Excursions::of(&weights);
        assert!((back.wheel_speed_rad_s - 40.0).abs() < 1e-12);
    }

    /// Twice every excursion gives a quarter of every weight, and a common factor of the weights does not change the
    /// gains.
    #[test]
    fn only_the_ratios_count() {
        let once = Excursions::of(&thesis::weights());
        let twice = Excursions {
            angle_rad: 2.0 * once.angle_rad,
            rate_rad_s: 2.0 * once.rate_rad_s,
            wheel_speed_rad_s: 2.0 * once.wheel_speed_rad_s,
            current_a: 2.0 * once.current_a,
        };
        let gains = |excursions: &Excursions| {
            let weights = excursions.weights().unwrap();
            discrete_regulator(&thesis::model(), &weights, 1e-3)
                .unwrap()
                .gains
        };
        assert!((gains(&once) - gains(&twice)).norm() < 1e-9 * gains(&once).norm());
        let golden = thesis::golden_gains();
        assert!((gains(&once) - golden).norm() < 1e-8 * golden.norm());
    }

    #[test]
    fn what_may_go_anywhere_costs_nothing_and_nonsense_is_named() {
        let mut allowed = Excursions::of(&thesis::weights());
        allowed.rate_rad_s = f64::INFINITY;
        assert_eq!(allowed.weights().unwrap().state[1], 0.0);
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let none = Excursions {
                current_a: wrong,
                ..allowed
            };
            assert!(none.weights().is_err(), "{wrong}");
        }
        let none = Excursions {
            angle_rad: 0.0,
            ..allowed
        };
        assert!(none.weights().is_err());
    }
}
