//! The reasons why a module is not emitted.

use crate::claims::ClaimId;

/// A module that could not keep one of its claims, or an unusable number.
///
/// Each message says what is wrong, which claim would fail, and what the remedy is.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// A quantity is NaN or infinite.
    #[error("{what} is {value}: a finite number is needed")]
    NotFinite {
        /// The quantity.
        what: String,
        /// Its value.
        value: f64,
    },
    /// A quantity must be greater than zero.
    #[error("{what} is {value}: it must be greater than zero")]
    NotPositive {
        /// The quantity.
        what: String,
        /// Its value.
        value: f64,
    },
    /// All gains are zero.
    #[error(
        "claim `{}` fails: all gains are zero, so nothing holds the pendulum up; design the gains first",
        ClaimId::ClosedLoopStable
    )]
    NoGain,
    /// A range needs more than the 31 bits of a word besides its sign.
    #[error(
        "claim `{}` fails: the {what} {range} does not fit a 32-bit word (largest 2147483647); state a smaller range",
        ClaimId::ControlTotal
    )]
    RangeTooLarge {
        /// The quantity.
        what: &'static str,
        /// Its stated range.
        range: f64,
    },
    /// The current limit is larger than what the drive accepts.
    #[error(
        "claim `{}` fails: the current limit {limit_a} A is above the drive's range of {drive_a} A; lower current_limit to at most {drive_a}",
        ClaimId::ControlTotal
    )]
    LimitAboveDrive {
        /// The stated limit.
        limit_a: f64,
        /// The drive's range.
        drive_a: f64,
    },
    /// The current limit rounds to zero in the format of the current.
    #[error(
        "claim `{}` fails: the current limit {limit_a} A is below the resolution of the command, {resolution_a} A; raise current_limit",
        ClaimId::ControlTotal
    )]
    LimitBelowResolution {
        /// The stated limit.
        limit_a: f64,
        /// One unit of the command's format.
        resolution_a: String,
    },
    /// No common binary point lets the sum of products fit 64 bits.
    #[error(
        "claim `{}` fails: the gains {gains:?} are too large for 64-bit sums over the stated ranges; use smaller gains (a larger current weight) or smaller ranges",
        ClaimId::ControlTotal
    )]
    GainsTooLarge {
        /// The gains K.
        gains: [f64; 3],
    },
    /// The step's error bound is not below one count of the drive's duty.
    #[error(
        "claim `{}` fails: the command may be off by {bound_a} A, more than one count of the drive ({count_a} A); use smaller gains or smaller ranges",
        ClaimId::ControlAccurateRealGains
    )]
    Inaccurate {
        /// The error bound (A).
        bound_a: String,
        /// One count of the drive (A).
        count_a: String,
    },
    /// A monitor was asked for, and the model or the drive has none.
    #[error("no monitor can be emitted: {reason}; generate without --monitor")]
    Monitor {
        /// What is missing.
        reason: String,
    },
    /// Sensors, mounting or converter have numbers that the emitted step cannot hold.
    #[error(transparent)]
    Hardware(#[from] crate::attitude::AttitudeRefusal),
    /// The sampled linear loop with the quantised gains has an eigenvalue outside the unit circle.
    #[error(
        "claim `{}` fails: the sampled loop with these gains is unstable at a sample time of {sample_time_s} s; design the gains for this model and sample time, or shorten the sample time",
        ClaimId::ClosedLoopStable
    )]
    Unstable {
        /// The sample time.
        sample_time_s: f64,
    },
}

impl Refusal {
    /// The claim that would fail; `None` if the input is not a usable number.
    pub fn claim(&self) -> Option<ClaimId> {
        match self {
            Self::NotFinite { .. }
            | Self::NotPositive { .. }
            | Self::Hardware(_)
            | Self::Monitor { .. } => None,
            Self::RangeTooLarge { .. }
            | Self::LimitAboveDrive { .. }
            | Self::LimitBelowResolution { .. }
            | Self::GainsTooLarge { .. } => Some(ClaimId::ControlTotal),
            Self::Inaccurate { .. } => Some(ClaimId::ControlAccurateRealGains),
            Self::NoGain | Self::Unstable { .. } => Some(ClaimId::ClosedLoopStable),
        }
    }
}
