//! The errors of a design, each with its remedy.

use bench_files::numbers::{complex_number, number};

/// The reason why no controller could be designed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DesignError {
    /// A matrix or a number is NaN or infinite.
    #[error("{what} is not finite; every entry must be a finite number")]
    NotFinite {
        /// The quantity, in words.
        what: &'static str,
    },
    /// Matrices whose sizes do not fit together.
    #[error("{what} is {rows}x{columns}; it must be {expected_rows}x{expected_columns}")]
    WrongShape {
        /// The matrix, in words.
        what: &'static str,
        /// Rows that it has.
        rows: usize,
        /// Columns that it has.
        columns: usize,
        /// Rows that it must have.
        expected_rows: usize,
        /// Columns that it must have.
        expected_columns: usize,
    },
    /// A quantity that must be positive is not.
    #[error("{what} is {value}; it must be greater than zero")]
    NotPositive {
        /// The quantity, in words, with its unit.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The cost has no minimum, or a current costs nothing.
    #[error(
        "the weights are indefinite ({what}, smallest eigenvalue {smallest_eigenvalue:.3e}); \
         use state weights of zero or more and a current weight greater than zero"
    )]
    IndefiniteWeights {
        /// The weight, and the condition that it must fulfil.
        what: &'static str,
        /// Its smallest eigenvalue.
        smallest_eigenvalue: f64,
    },
    /// The input cannot reach an unstable mode.
    #[error(
        "the motor cannot stabilise this model: it does not reach the mode at {} \
         (relative reach {reach:.1e}); check the torque constant and the inertias",
        complex_number(*re, *im)
    )]
    NotStabilisable {
        /// Real part of the mode's eigenvalue.
        re: f64,
        /// Imaginary part.
        im: f64,
        /// Smallest singular value of [A − λI, B] over the norm of A.
        reach: f64,
    },
    /// An unstable mode does not enter the cost, so the minimum leaves the mode uncontrolled.
    #[error(
        "the gains that minimise this cost leave the loop unstable (largest pole modulus {}): a \
         state weight of zero hides an unstable mode; give every state a weight greater than zero",
        modulus(*spectral_radius)
    )]
    WeightsHideUnstableMode {
        /// Largest modulus of the closed-loop poles.
        spectral_radius: f64,
    },
    /// A mode that does not decay by itself does not enter the cost, or so weakly that the loop would take
    /// forever.
    #[error(
        "the cost does not depend on the {state}: {how}; give it a larger state weight (the thesis has \
         25, 0.5 and 5e-4 for angle, rate and wheel speed)"
    )]
    CostBlind {
        /// The state that dominates the mode.
        state: &'static str,
        /// The reason, in words: why the cost does not control the mode.
        how: String,
    },
    /// Double and extended precision give different gains.
    #[error(
        "the gains cannot be computed reliably (double and extended precision differ by a share of \
         {difference:.1e}); bring the weights, or the parameters of the model, closer together: they span too many \
         orders of magnitude"
    )]
    GainsUncertain {
        /// Norm of the difference, divided by that of the gains.
        difference: f64,
    },
    /// An iteration did not converge.
    #[error(
        "{method} did not converge after {iterations} steps (last change {change:.1e}); {cure}"
    )]
    NoConvergence {
        /// The algorithm.
        method: &'static str,
        /// Number of steps made.
        iterations: usize,
        /// Relative size of the last change.
        change: f64,
        /// What to do about it.
        cure: &'static str,
    },
    /// A Riccati equation was solved, but not accurately enough.
    #[error(
        "the {equation} is solved only to a relative residual of {residual:.1e} (allowed \
         {allowed:.1e}); bring the weights, or the parameters of the model, closer together: they span too many orders \
         of magnitude"
    )]
    InaccurateSolution {
        /// The equation, in words.
        equation: &'static str,
        /// Its residual, divided by the size of its terms.
        residual: f64,
        /// The largest residual that is accepted.
        allowed: f64,
    },
    /// A matrix that must be inverted is singular.
    #[error("{what} is singular; {cure}")]
    Singular {
        /// The matrix, in words.
        what: &'static str,
        /// What to do about it.
        cure: &'static str,
    },
    /// A loop that must be stable is unstable.
    #[error(
        "the loop {loop_name} is unstable (largest pole modulus {}); {cure}",
        modulus(*spectral_radius)
    )]
    UnstableLoop {
        /// The loop, in words.
        loop_name: &'static str,
        /// Largest modulus of its poles.
        spectral_radius: f64,
        /// What to do about it.
        cure: &'static str,
    },
    /// The loop has less delay margin than sampling at this rate requires.
    #[error(
        "a sample time of {sample_time_s} s is too long: the loop tolerates {delay_margin_s:.2e} s \
         of delay, less than the one sample that the computation may take; {}",
        shorter_or_slower(*longest_s, *current_weight, *larger_weight)
    )]
    SampleTimeTooLong {
        /// The required sample time, s.
        sample_time_s: f64,
        /// The delay margin of the design at that sample time, in s.
        delay_margin_s: f64,
        /// A sample time of two digits that works, in s.
        longest_s: f64,
        /// The weight of the current in this design, in 1/s per A².
        current_weight: f64,
        /// A larger weight of two digits that works at the required sample time; `None` if none is known.
        larger_weight: Option<f64>,
    },
    /// The model is not an inverted pendulum, so the requested quantity has no meaning.
    #[error("{what} needs an upright pendulum: {why}")]
    NotAPendulum {
        /// The quantity, in words.
        what: &'static str,
        /// What is missing.
        why: &'static str,
    },
    /// The parameters give no linear model.
    #[error("the model cannot be linearised with these parameters: {message}")]
    Model {
        /// The message of the model.
        message: String,
    },
}

/// The modulus of a pole as text. Its distance from 1 decides stability, and four digits of the modulus of a slow mode
/// do not show it; a modulus within 0.01 of 1 is therefore written as 1 plus or minus the distance.
fn modulus(modulus: f64) -> String {
    let beyond = modulus - 1.0;
    if beyond != 0.0 && beyond.abs() < 0.01 {
        let sign = if beyond < 0.0 { '−' } else { '+' };
        format!("1 {sign} {}", number(beyond.abs()))
    } else {
        number(modulus)
    }
}

/// The shortest sample time that is advised, in s. It is the time of 2,400 instructions at 120 MHz: the longest path
/// through one emitted step (docs/guide/cost.md).
const SHORTEST_ADVISED_S: f64 = 20e-6;

/// The advice against a sample time that is too long: a shorter sample time, unless it is below [`SHORTEST_ADVISED_S`],
/// or a slower loop.
fn shorter_or_slower(longest_s: f64, current_weight: f64, larger_weight: Option<f64>) -> String {
    let slower = match larger_weight {
        Some(weight) => format!(
            "a current weight of at least {weight} (now {current_weight}), which makes the loop slower"
        ),
        None => "other weights: a larger current weight makes the loop slower".to_owned(),
    };
    if longest_s < SHORTEST_ADVISED_S {
        format!("use {slower}")
    } else {
        format!(
            "use a sample time of at most {longest_s} s (a shorter one leaves more margin), or {slower}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_have_at_most_four_digits_and_keep_their_distance_from_one() {
        let unreached = DesignError::NotStabilisable {
            re: 9.475_773_72,
            im: 0.0,
            reach: 1e-12,
        };
        assert!(unreached.to_string().contains("the mode at 9.476 ("));
        let radius = |spectral_radius| {
            DesignError::UnstableLoop {
                loop_name: "with friction",
                spectral_radius,
                cure: "…",
            }
            .to_string()
        };
        assert!(radius(1.094_123_4).contains("modulus 1.094)"));
        assert!(radius(1.000_012_345_6).contains("modulus 1 + 1.235e-5)"));
        assert!(radius(1.0).contains("modulus 1)"));
    }
}
