//! The observer of the angle's bias as the source computes it, in real numbers.
//!
//! With y the measured state, N the gains of the law, and d, ℓ, m, f the words of the source,
//!
//! ```text
//! b̂ = s + ℓᵀ y,   u = N (y − b̂ e₁),   s⁺ = d s + mᵀ y + f u.
//! ```
//!
//! Inserted, with N' = N − N₁ ℓᵀ: u = N' y − N₁ s and s⁺ = (d − f N₁) s + (m + f N')ᵀ y. While it waits, s = −ℓᵀ y.
//! b̂ is rounded to a word of the angle, s to 2⁻³⁰ rad, and both are clamped.

use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::certificate::reader::{Certificate, vector};
use crate::claims::named_words::NamedWords;
use crate::exact::matrices::Vector;
use crate::exact::rational::{exponent, half, integer, power_of_two};
use crate::language::module::Module;

/// Fraction bits of the word of z (rad).
pub(crate) const STATE_BITS: i32 = 30;

/// The numbers of an observer.
#[derive(Clone, Debug, PartialEq)]
pub struct EmittedObserver {
    /// d.
    pub decay: BigRational,
    /// ℓ (rad per unit of each state).
    pub direct: Vector,
    /// m (rad per unit of each state).
    pub from_states: Vector,
    /// f (rad/A).
    pub from_current: BigRational,
}

impl EmittedObserver {
    /// The words of `BIAS_OBSERVER`, for states and a current with these fraction bits; `None` where they are those
    /// of no observer.
    ///
    /// # Errors
    /// A sentence that names the word.
    pub fn read(
        module: &Module,
        state_bits: [u32; 3],
        current_bits: u32,
    ) -> Result<Option<EmittedObserver>, String> {
        let words = NamedWords::read(module, "BIAS_OBSERVER")?;
        let word = |field: &str| words.get(&format!("BIAS_OBSERVER.{field}"));
        if word("unit")?.is_zero() {
            return Ok(None);
        }
        let small = |field: &str| words.small(&format!("BIAS_OBSERVER.{field}"));
        // Of s with 2⁻³⁰ rad, of an estimate with the angle's unit.
        let to_estimate = power_of_two(-small("angle_shift")? - exponent(state_bits[0]));
        let to_state = power_of_two(-small("state_shift")? - STATE_BITS);
        let number = |field: &str, bits: i32, unit: &BigRational| {
            Ok::<_, String>(word(field)? * unit * power_of_two(bits))
        };
        if !number("unit", STATE_BITS, &to_estimate)?.is_one() {
            return Err("BIAS_OBSERVER.unit does not bring the observer's state to the scale of the products".to_owned());
        }
        let of_states = |field: &str, unit: &BigRational| -> Result<Vector, String> {
            let mut found = [0, 1, 2].map(|_| BigRational::zero());
            for (i, entry) in found.iter_mut().enumerate() {
                *entry = number(&format!("{field}[{i}]"), exponent(state_bits[i]), unit)?;
            }
            Ok(found)
        };
        Ok(Some(EmittedObserver {
            decay: number("decay", STATE_BITS, &to_state)?,
            direct: of_states("direct", &to_estimate)?,
            from_states: of_states("from_states", &to_state)?,
            from_current: number("from_current", exponent(current_bits), &to_state)?,
        }))
    }

    /// The decimals of the certificate, in real numbers.
    pub fn stated(certificate: &Certificate) -> Option<EmittedObserver> {
        let stated = certificate.bias_observer.as_ref()?;
        Some(EmittedObserver {
            decay: stated.decay.value.clone(),
            direct: vector(&stated.direct),
            from_states: vector(&stated.from_states),
            from_current: stated.from_current.value.clone(),
        })
    }

    /// N' for the gains N.
    pub fn of_readings(&self, gains: &Vector) -> Vector {
        [0, 1, 2].map(|i| &gains[i] - &gains[0] * &self.direct[i])
    }

    /// m + f N'.
    pub fn into_state(&self, gains: &Vector) -> Vector {
        let of_readings = self.of_readings(gains);
        [0, 1, 2].map(|i| &self.from_states[i] + &self.from_current * &of_readings[i])
    }

    /// d − f N₁.
    pub fn own_decay(&self, gains: &Vector) -> BigRational {
        &self.decay - &self.from_current * &gains[0]
    }

    /// Largest rounding of s (rad).
    pub fn state_rounding() -> BigRational {
        half() * power_of_two(-STATE_BITS)
    }

    /// Largest |s| that is not clamped (rad).
    pub fn state_range() -> BigRational {
        integer(2) - power_of_two(-STATE_BITS)
    }
}
