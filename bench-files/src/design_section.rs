//! The section `[design]` of a model: what the controller is designed for.

use serde::{Deserialize, Serialize};
use toml_edit::{Array, TableLike, Value};

use crate::error::{Error, Problem};
use crate::keys;
use crate::toml_section::Section;
use crate::toml_writing::{number, set};

/// The requirements for the design of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignSection {
    /// Time between two commands, s.
    pub sample_time_s: f64,
    /// Diagonal of Q: weights of angle (1/rad²), rate (s²/rad²) and wheel speed (s²/rad²).
    pub state_weights: [f64; 3],
    /// R: weight of the current, 1/A².
    pub current_weight: f64,
    /// Largest current in either direction, A.
    pub current_limit_a: f64,
    /// ι in rad/s: Coulomb friction of the body enters the linear model as μ/ι; `None` to leave it out.
    pub friction_linearisation_speed_rad_s: Option<f64>,
    /// Time constant in s of an observer of a constant bias of the measured angle; such a bias
    /// would keep the wheel turning (thesis 5.1). Key `bias_time_constant`; `None` for no observer.
    pub bias_time_constant_s: Option<f64>,
}

impl DesignSection {
    /// Reads the section.
    pub(crate) fn read(section: &Section) -> Result<DesignSection, Error> {
        section.allow_only(&keys::names(keys::MODEL, "design"))?;
        let weights =
            section.required_three_numbers("state_weights", "state_weights = [25.0, 0.5, 5e-4]")?;
        if let Some(negative) = weights.value.iter().find(|weight| **weight < 0.0) {
            return Err(section.error_at(
                "state_weights",
                Problem::OutOfRange {
                    key: "state_weights".to_string(),
                    value: *negative,
                    must_be: "zero or positive".to_string(),
                },
            ));
        }
        Ok(DesignSection {
            sample_time_s: section
                .required_positive_number("sample_time", "sample_time = 0.001 (s)")?,
            state_weights: weights.value,
            current_weight: section
                .required_positive_number("current_weight", "current_weight = 1.0")?,
            current_limit_a: section
                .required_positive_number("current_limit", "current_limit = 2.0 (A)")?,
            friction_linearisation_speed_rad_s: section
                .positive_number("friction_linearisation_speed")?
                .map(|speed| speed.value),
            bias_time_constant_s: section
                .positive_number("bias_time_constant")?
                .map(|time| time.value),
        })
    }

    /// Writes the section.
    pub(crate) fn write(&self, section: &mut dyn TableLike) {
        set(section, "sample_time", number(self.sample_time_s));
        let weights: Array = self.state_weights.iter().map(|w| number(*w)).collect();
        set(section, "state_weights", Value::Array(weights));
        set(section, "current_weight", number(self.current_weight));
        set(section, "current_limit", number(self.current_limit_a));
        let optional = [
            (
                "friction_linearisation_speed",
                self.friction_linearisation_speed_rad_s,
            ),
            ("bias_time_constant", self.bias_time_constant_s),
        ];
        for (key, value) in optional {
            match value {
                Some(value) => set(section, key, number(value)),
                None => {
                    section.remove(key);
                }
            }
        }
    }
}
