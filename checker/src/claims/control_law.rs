//! The emitted control law, from its source alone: the function that it computes, and the distance of that from
//! −K x.
//!
//! The source is read as a saturated linear form of the three words
//! ([`crate::domains::linear_forms`]). Gains, rounding and limit therefore come from the code, not
//! from the certificate. With the coefficients cᵢ (command units per unit of word i) and the error interval
//! [l, h] of the form:
//!
//! - the quantised gains are N̂ᵢ = cᵢ 2^(fᵢ − f), in A per unit of state i;
//! - the command differs from the saturated law with these gains by at most max(|l|, |h|) units;
//! - and from the saturated law with the real gains and limit by at most
//!   max(that + Σ |N̂ᵢ + Kᵢ| rᵢ, |L̂ − L|) for |xᵢ| ≤ rᵢ: saturation does not increase the distance of two
//!   numbers, and two limits change a saturated number by at most their difference.

use num_rational::BigRational;
use num_traits::Signed;

use crate::claims::emitted_observer::EmittedObserver;
use crate::domains::intervals::{Finding, every_bit_pattern, ranges};
use crate::domains::linear_forms::forms;
use crate::exact::rational::{exponent, half, power_of_two};
use crate::language::module::Module;
use crate::program::types::Type;

/// The law that the source implements, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct EmittedLaw {
    /// Fraction bits of the three states.
    pub state_bits: [u32; 3],
    /// Fraction bits of the command.
    pub current_bits: u32,
    /// Gains of the emitted law u = N x (A per unit of state): −K, quantised.
    pub gains: [BigRational; 3],
    /// Largest command (A).
    pub limit: BigRational,
    /// Largest distance from the saturated law with these gains (A).
    pub rounding: BigRational,
    /// The observer of the angle's bias before the law, where the source has one.
    pub observer: Option<EmittedObserver>,
}

/// The reason why the law could not be read from the source.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LawError {
    /// There is no function `control` of three fixed-point words.
    #[error("the crate has no `pub fn control` that takes three fixed-point words and gives one")]
    Missing,
    /// Something may overflow.
    #[error("{0}")]
    Finding(#[from] Finding),
    /// The result is not a saturated linear form.
    #[error(
        "the command is not a linear form of the states that is clamped to plus and minus one limit"
    )]
    NotLinear,
    /// There is no limit, or it is not positive.
    #[error("src/control.rs has no positive constant CURRENT_LIMIT")]
    NoLimit,
    /// The command may exceed its limit.
    #[error("the command may reach {0}, the limit is {1} (words)")]
    BeyondLimit(i128, i128),
}

impl EmittedLaw {
    /// Reads the law and proves that it is total: nothing overflows for any bit pattern, and the
    /// command is within `CURRENT_LIMIT`.
    ///
    /// # Errors
    /// [`LawError`].
    pub fn read(module: &Module) -> Result<EmittedLaw, LawError> {
        let program = module.function("control").ok_or(LawError::Missing)?;
        let bits: Vec<_> = program
            .argument_types
            .iter()
            .chain(&program.result_types)
            .map(|type_| match type_ {
                Type::Fixed(bits) => Some(*bits),
                _ => None,
            })
            .collect();
        let [Some(a), Some(b), Some(c), Some(current_bits)] = bits[..] else {
            return Err(LawError::Missing);
        };
        let state_bits = [a, b, c];

        let range = ranges(program, &every_bit_pattern(program))?[0];
        let limit_word = match module.constant("control", "CURRENT_LIMIT") {
            Some([word]) if *word > 0 => *word,
            _ => return Err(LawError::NoLimit),
        };
        if range.high > limit_word || range.low < -limit_word {
            let worst = if range.high > limit_word {
                range.high
            } else {
                range.low
            };
            return Err(LawError::BeyondLimit(worst, limit_word));
        }

        let form = forms(program).pop().flatten().ok_or(LawError::NotLinear)?;
        let limit_units = BigRational::from(num_bigint::BigInt::from(limit_word));
        let (low, high) = form.clamped.clone().ok_or(LawError::NotLinear)?;
        if high != limit_units || low != -limit_units.clone() {
            return Err(LawError::NotLinear);
        }
        let unit = power_of_two(-exponent(current_bits));
        let gains = [0, 1, 2].map(|index| {
            form.coefficients.get(&index).cloned().unwrap_or_default()
                * power_of_two(exponent(state_bits[index]))
                * &unit
        });
        let rounding = form.low.abs().max(form.high.abs()) * &unit;
        // Words that make no observer are the matter of `hardware-words` and `bias-observer-stable`.
        let observer = EmittedObserver::read(module, state_bits, current_bits);
        Ok(EmittedLaw {
            observer: observer.ok().flatten(),
            state_bits,
            current_bits,
            gains,
            limit: limit_units * unit,
            rounding,
        })
    }

    /// What a reading of each state does to the command at once (A per unit of state): the gains, less what the observer of the
    /// angle's bias makes of the reading.
    pub fn of_readings(&self) -> [BigRational; 3] {
        match &self.observer {
            Some(observer) => observer.of_readings(&self.gains),
            None => self.gains.clone(),
        }
    }

    /// One unit of the command (A).
    pub fn unit(&self) -> BigRational {
        power_of_two(-exponent(self.current_bits))
    }

    /// Half a unit of each state.
    pub fn half_words(&self) -> [BigRational; 3] {
        self.state_bits
            .map(|bits| power_of_two(-exponent(bits)) * half())
    }

    /// Distance from the saturated law −K x with real gains `k` and `limit`, for |xᵢ| ≤ `ranges`.
    pub fn real_gains_bound(
        &self,
        k: &[BigRational; 3],
        limit: &BigRational,
        ranges: &[BigRational; 3],
    ) -> BigRational {
        let mut bound = self.rounding.clone();
        for index in 0..3 {
            bound += (&self.gains[index] + &k[index]).abs() * &ranges[index];
        }
        bound.max((&self.limit - limit).abs())
    }

    /// The additional error from rounding a real state to the nearest word, with real gains `k`.
    pub fn state_rounding(&self, k: &[BigRational; 3]) -> BigRational {
        self.half_words()
            .iter()
            .zip(k)
            .map(|(half, gain)| half * gain.abs())
            .sum()
    }
}
