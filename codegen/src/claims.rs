//! The claims of an emitted module: the identifiers by which generator, certificate and checker refer to them.

use serde::Serialize;

/// Identifier of a claim, as in `certificate.json`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClaimId {
    /// No overflow, no panic, and the command within the current limit.
    ControlTotal,
    /// The command lies within half a unit of the saturated law with the quantised gains.
    ControlAccurate,
    /// The command lies within the stated bound of the saturated law with the real gains.
    ControlAccurateRealGains,
    /// The sampled linear loop with the quantised gains is asymptotically stable.
    ClosedLoopStable,
}

impl ClaimId {
    /// Every claim, in the order of the certificate.
    pub const ALL: [Self; 4] = [
        Self::ControlTotal,
        Self::ControlAccurate,
        Self::ControlAccurateRealGains,
        Self::ClosedLoopStable,
    ];

    /// The identifier as text.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::ControlTotal => "control-total",
            Self::ControlAccurate => "control-accurate",
            Self::ControlAccurateRealGains => "control-accurate-real-gains",
            Self::ClosedLoopStable => "closed-loop-stable",
        }
    }

    /// The claim as one sentence.
    pub fn statement(self) -> &'static str {
        match self {
            Self::ControlTotal => {
                "`control` neither overflows nor panics, and its command lies within ±CURRENT_LIMIT."
            }
            Self::ControlAccurate => {
                "The command lies within half a unit of its format of the saturated law with the quantised gains."
            }
            Self::ControlAccurateRealGains => {
                "The command lies within the stated bound of the law -K x with the real gains, saturated at the real limit."
            }
            Self::ClosedLoopStable => {
                "All eigenvalues of Ad - Bd K with the quantised gains lie inside the unit circle."
            }
        }
    }

    /// The inputs for which the claim holds.
    pub fn domain(self) -> &'static str {
        match self {
            Self::ControlTotal | Self::ControlAccurate => "every bit pattern of the three inputs",
            Self::ControlAccurateRealGains => {
                "every representable state within the physical ranges"
            }
            Self::ClosedLoopStable => "the linear model sampled at the stated time",
        }
    }
}

impl std::fmt::Display for ClaimId {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.as_str())
    }
}
