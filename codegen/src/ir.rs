//! The module to be emitted, as plain data: all numbers are determined, but no text is written yet.

use num_rational::BigRational;

use crate::exact::ShortestDecimal;
use crate::format::Format;

/// The control law u = −K x in integers.
///
/// With raw words X of the states and N of the negated gains −K, the products N X all have
/// `product_fraction_bits` bits after the point; their sum is exact in 64 bits, and
/// (sum + 2^(shift−1)) >> shift rounds it once, halves upward, to the format of the command.
#[derive(Debug, Clone, PartialEq)]
pub struct IntegerLaw {
    /// One term for each state: angle, rate, wheel speed.
    pub terms: [Term; 3],
    /// Bits after the binary point of every product.
    pub product_fraction_bits: u32,
    /// Bits that the one rounding removes.
    pub shift: u32,
    /// Format of the command (A).
    pub current: Format,
    /// Stated current limit (A).
    pub limit: ShortestDecimal,
    /// The limit in units of `current`, rounded toward zero so that it is never exceeded.
    pub limit_raw: i32,
    /// Error bounds of one step.
    pub bounds: StepBounds,
}

/// One state and its gain.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// The state.
    pub input: StateInput,
    /// The gain that multiplies it.
    pub gain: Gain,
}

/// A state as an argument of the emitted function.
#[derive(Debug, Clone, PartialEq)]
pub struct StateInput {
    /// Name of the emitted type: `Angle`.
    pub type_name: &'static str,
    /// Name of the argument: `angle`.
    pub argument: &'static str,
    /// The meaning of the state, in words.
    pub meaning: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Largest magnitude on the bench, in `unit`.
    pub range: ShortestDecimal,
    /// Format of the word.
    pub format: Format,
}

/// A gain as a named constant: the negated entry of K.
#[derive(Debug, Clone, PartialEq)]
pub struct Gain {
    /// Name of the emitted constant: `ANGLE_GAIN`.
    pub constant: &'static str,
    /// Symbol of the entry of K: `K₁`.
    pub symbol: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// −K, as designed.
    pub real: ShortestDecimal,
    /// −K in units of 2^−`fraction_bits`.
    pub raw: i32,
    /// Bits after the binary point; may exceed 32 for small gains.
    pub fraction_bits: u32,
    /// `raw`·2^−`fraction_bits` − `real`.
    pub error: BigRational,
}

/// Error bounds of one step, exact, in A.
#[derive(Debug, Clone, PartialEq)]
pub struct StepBounds {
    /// Against the saturated law with the quantised gains, for every bit pattern.
    pub rounding: BigRational,
    /// Against the saturated law with the real gains and limit, within the physical ranges.
    pub real_gains: BigRational,
    /// Additional error from rounding a real state to the nearest representable one.
    pub state_rounding: BigRational,
}
