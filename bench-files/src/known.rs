//! The values in `[known]`, which were measured directly.

use crate::error::{Error, Problem};
use crate::keys;
use crate::toml_section::Section;

/// Values of a bench that were measured with ruler and balance, or come from a data sheet. All in SI; each
/// may be missing.
///
/// `total_inertia`, `wheel_inertia` and `body_inertia` go beyond the contract: an inertia that is
/// known from a drawing or another experiment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// Gravity g, m/s².
    pub gravity: Option<f64>,
    /// Torque constant τ of the motor, N m/A.
    pub torque_constant: Option<f64>,
    /// Mass m_b of the body without the wheel, kg.
    pub body_mass: Option<f64>,
    /// Mass m_w of the wheel (with what turns with it), kg.
    pub wheel_mass: Option<f64>,
    /// Distance k from the pivot to the wheel's axis, m.
    pub pivot_to_wheel: Option<f64>,
    /// Distance l from the pivot to the body's centre of mass, m.
    pub pivot_to_com: Option<f64>,
    /// Gravity torque G = g (k m_w + l m_b) as one number, N m, measured directly.
    pub gravity_torque: Option<f64>,
    /// Total moment of inertia Θ about the pivot, kg m².
    pub total_inertia: Option<f64>,
    /// Moment of inertia j_w of the wheel about its axis, kg m².
    pub wheel_inertia: Option<f64>,
    /// Moment of inertia j_b of the body about its own centre of mass, kg m².
    pub body_inertia: Option<f64>,
}

/// The error that the known values do not give the gravity torque.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the gravity torque is not known: [known] lacks {}; these keys, or gravity_torque, would give it",
    .missing.join(", ")
)]
pub struct MissingKnowns {
    /// The keys of `[known]` that are missing.
    pub missing: Vec<&'static str>,
}

/// Relative difference up to which two values of the gravity torque count as the same number,
/// rounded: the example in the contract states 0.2451, while its masses and lengths give 0.24516.
const ROUNDING: f64 = 1e-3;
/// Relative difference above which one of two values of the gravity torque is a mistake (a unit,
/// a digit) and not a measurement error: kitchen scale and ruler are good to a few percent.
const SLIP: f64 = 0.1;

impl Known {
    /// Gravity torque G in N m: `gravity_torque` if it is given, otherwise g (k m_w + l m_b).
    ///
    /// # Errors
    /// [`MissingKnowns`] lists every missing key. Gravity is one of them: it is not assumed.
    pub fn gravity_torque(&self) -> Result<f64, MissingKnowns> {
        match self.gravity_torque {
            Some(torque) => Ok(torque),
            None => self.gravity_torque_of_masses(),
        }
    }

    /// g (k m_w + l m_b) in N m, independent of `gravity_torque`.
    fn gravity_torque_of_masses(&self) -> Result<f64, MissingKnowns> {
        let parts = [
            ("gravity", self.gravity),
            ("body_mass", self.body_mass),
            ("wheel_mass", self.wheel_mass),
            ("pivot_to_wheel", self.pivot_to_wheel),
            ("pivot_to_com", self.pivot_to_com),
        ];
        if let (Some(g), Some(m_b), Some(m_w), Some(k), Some(l)) = (
            self.gravity,
            self.body_mass,
            self.wheel_mass,
            self.pivot_to_wheel,
            self.pivot_to_com,
        ) {
            return Ok(g * (k * m_w + l * m_b));
        }
        Err(MissingKnowns {
            missing: parts
                .iter()
                .filter(|(_, value)| value.is_none())
                .map(|(key, _)| *key)
                .collect(),
        })
    }

    /// Reads `[known]`. The second value is the gravity torque from masses and lengths, if
    /// it differs from the stated `gravity_torque` by more than rounding.
    pub(crate) fn read(section: Option<&Section>) -> Result<(Known, Option<f64>), Error> {
        let mut known = Known::default();
        let Some(section) = section else {
            return Ok((known, None));
        };
        section.allow_only(&keys::names(keys::BENCH, "known"))?;
        let positive = |key| -> Result<Option<f64>, Error> {
            Ok(section.positive_number(key)?.map(|located| located.value))
        };
        known.gravity = positive("gravity")?;
        known.torque_constant = positive("torque_constant")?;
        known.body_mass = positive("body_mass")?;
        known.wheel_mass = positive("wheel_mass")?;
        known.pivot_to_wheel = positive("pivot_to_wheel")?;
        // A counterweight can put the body's own centre of mass above the pivot.
        known.pivot_to_com = section.number("pivot_to_com")?.map(|located| located.value);
        known.total_inertia = positive("total_inertia")?;
        known.wheel_inertia = positive("wheel_inertia")?;
        known.body_inertia = positive("body_inertia")?;

        let stated = section.positive_number("gravity_torque")?;
        known.gravity_torque = stated.as_ref().map(|located| located.value);
        let computed = known.gravity_torque_of_masses().ok();
        if stated.is_none()
            && let Some(torque) = computed
            && torque <= 0.0
        {
            return Err(section.error_at(
                "pivot_to_com",
                Problem::HangsUpsideDown { torque_n_m: torque },
            ));
        }
        if let (Some(stated), Some(computed)) = (stated, computed) {
            let difference = (stated.value / computed - 1.0).abs();
            if difference > SLIP || computed <= 0.0 {
                return Err(section.error_at(
                    "gravity_torque",
                    Problem::GravityTorqueContradiction {
                        stated_n_m: stated.value,
                        computed_n_m: computed,
                    },
                ));
            }
            if difference > ROUNDING {
                return Ok((known, Some(computed)));
            }
        }
        Ok((known, None))
    }
}
