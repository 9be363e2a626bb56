//! The claims as the checker knows them: identifier, statement, domain, and the claims they depend on.
//!
//! They are written down here a second time on purpose: a certificate that states something else is
//! rejected.

use crate::claims::outcome::{COMPILED, EXACT, INTERVALS, RANDOM, READER};

/// The statement of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClaimStatement {
    /// Identifier.
    pub id: &'static str,
    /// One sentence.
    pub statement: &'static str,
    /// The inputs for which the claim holds.
    pub domain: &'static str,
    /// The assumptions; empty if there are none.
    pub assumptions: &'static str,
    /// The engine that decides the claim on every machine; other engines may decide it, too.
    pub engine: &'static str,
    /// Whether certificates list the claim.
    pub is_in_certificate: bool,
}

/// Every claim, in the order in which they are shown.
pub const CLAIMS: [ClaimStatement; 27] = [
    ClaimStatement {
        id: "source-understood",
        statement: "The emitted source keeps to the documented language: no float, no heap, no loop, no panic but in constants, nothing but `fixed`.",
        domain: "every emitted file",
        assumptions: "",
        engine: READER,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "texts-audited",
        statement: "Every emitted file is, but for the numbers of the bench, token by token a text that was audited.",
        domain: "every token of every emitted file but words, gains, limits and formats",
        assumptions: "SHA-256 gives two texts one digest never.",
        engine: READER,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "compiled-agrees",
        statement: "The crate as rustc compiles it gives the words that the reader of the source gives.",
        domain: "every public function at random words, at the ends of ranges and on both sides of each branch that was found; runs of the controller near upright",
        assumptions: "The compiler and the crate `fixed` are those of this machine; a processor without them may have others.",
        engine: COMPILED,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "certificate-consistent",
        statement: "Every number and name of the certificate is the one of the source, or follows from it; the gains are optimal for model and weights.",
        domain: "every field of certificate.json",
        assumptions: "",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "model-matches",
        statement: "Parameters, wishes of the design, sensors and drive are those of the user's model.",
        domain: "every number of the model.toml that was given",
        assumptions: "Sensors and drive are compared with what the generator makes of that file.",
        engine: READER,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "hardware-words",
        statement: "The words of sensors, mounting, converter and drive are the stated real numbers, rounded.",
        domain: "every constant of src/constants.rs",
        assumptions: "",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "physical-signs",
        statement: "Sensors, law and drive push a leaning body back: one handedness, a gravity of 8 to 11.5 m/s2, a motor that pushes forward, a lever arm on the body, and a restoring current from raw counts.",
        domain: "leans of 1 to 10 degrees and rates of 0.2 and 1 rad/s, both ways",
        assumptions: "The stated sensors and drive are those of the bench; a recording shows that (`flywheel bring-up`).",
        engine: RANDOM,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "control-total",
        statement: "`control` neither overflows nor panics, and its command lies within ±CURRENT_LIMIT.",
        domain: "every bit pattern of the three inputs",
        assumptions: "",
        engine: INTERVALS,
        is_in_certificate: true,
    },
    ClaimStatement {
        id: "control-accurate",
        statement: "The command lies within half a unit of its format of the saturated law with the quantised gains.",
        domain: "every bit pattern of the three inputs",
        assumptions: "",
        engine: INTERVALS,
        is_in_certificate: true,
    },
    ClaimStatement {
        id: "control-accurate-real-gains",
        statement: "The command lies within the stated bound of the law -K x with the real gains, saturated at the real limit.",
        domain: "every representable state within the physical ranges",
        assumptions: "",
        engine: EXACT,
        is_in_certificate: true,
    },
    ClaimStatement {
        id: "control-monotone",
        statement: "The command never falls when a state with a positive gain rises, nor rises when one with a negative gain does.",
        domain: "every bit pattern of the three inputs",
        assumptions: "",
        engine: INTERVALS,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "primitives",
        statement: "Each primitive of the filter keeps the contract of ranges that stands at it.",
        domain: "every argument that the contract allows",
        assumptions: "Contracts that are no ranges are checked where the primitive is called, with the words of this bench.",
        engine: INTERVALS,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "filter-total",
        statement: "No step of the attitude filter overflows, and each keeps its components and rates within the stated ranges.",
        domain: "every sensor reading and every state within the invariant, which holds at the start",
        assumptions: "",
        engine: INTERVALS,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "filter-length",
        statement: "The squared length of the attitude's quaternion lies within 1 ± 2^-11 at the start and after every step and alignment.",
        domain: "every sensor reading and every state within the invariant, which holds at the start",
        assumptions: "No step overflows or leaves its ranges (`filter-total`).",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "step-total",
        statement: "Raw counts give a duty within the drive's limits, and the duty of zero current unless the controller runs.",
        domain: "every sample and every state within the invariant",
        assumptions: "",
        engine: INTERVALS,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "supervisor",
        statement: "The motor is driven only after arming with a known attitude near upright and at rest; an angle beyond its limit at once, a frozen or clipped sensor, an unknown wheel speed, a lost vertical or a current at its limit each within its stated time end that.",
        domain: "random sequences of samples with faults; each condition alone; every word of LIMITS",
        assumptions: "Attitude, law and observer are those of the source, of which other claims speak.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "filter-accurate",
        statement: "A step of the filter follows Madgwick's equations in double precision to within 2e-7 and what its normalisation leaves (5/16 of the sixth power of the step's angle) in each component, the pivot angle to within 1e-6 rad.",
        domain: "random attitudes and readings",
        assumptions: "The reference is written from the paper, in floating point.",
        engine: RANDOM,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "filter-exact",
        statement: "Every function of the filter gives, bit for bit, the words of the checker's own statement of it in exact integers.",
        domain: "random words, ends of ranges, and words where pieces meet; functions of one word on every input when the text was audited",
        assumptions: "",
        engine: RANDOM,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "encoder-exact",
        statement: "The counts of an encoder become the turn over its window exactly, wrap included, and a count that no motion of its axis gives is noticed in the same step.",
        domain: "every difference of two counts; axes that turn at random; every word of the encoders",
        assumptions: "An axis turns by less than half a wrap in a step.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "closed-loop-stable",
        statement: "All eigenvalues of Ad - Bd K with the quantised gains lie inside the unit circle.",
        domain: "the linear model sampled at the stated time",
        assumptions: "",
        engine: EXACT,
        is_in_certificate: true,
    },
    ClaimStatement {
        id: "bias-observer-stable",
        statement: "Plant, regulator and the emitted observer of the angle's bias are stable together, and leave less than a hundredth of a constant bias at rest.",
        domain: "the linear model sampled at the stated time",
        assumptions: "No saturation; a module without observer claims nothing here.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "encoder-loop-stable",
        statement: "The sampled linear loop with speeds that are an encoder's turn over its window, and with a voltage in place of the current where the drive sets one, is stable.",
        domain: "the linear model sampled at the stated time",
        assumptions: "No saturation, and no end of the supply; a module without encoder and voltage drive claims nothing here.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "closed-loop-for-all-time",
        statement: "From any start in the stated ellipsoid the loop with the emitted law never saturates and stays within the stated bounds of the loop in real numbers, at every step.",
        domain: "all time; every start in the ellipsoid; every perturbation by words or sensor counts",
        assumptions: "The plant is the stated linear model; the sensors return the nearest count, the angle directly and not through the filter; the other loop computes in real numbers.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "region-of-attraction",
        statement: "From any start in the stated share of the ellipsoid the loop with the emitted law never saturates, and comes into the stated smaller share and stays there.",
        domain: "all time; every start in that share; every perturbation by words or sensor counts",
        assumptions: "The plant is the stated linear model with gravity as G sin(angle); the sensors return the nearest count, the angle directly and not through the filter.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "loop-as-shipped",
        statement: "Armed at rest at any angle up to the stated one, the pendulum under the emitted step, from raw counts through filter and law to the duty, stays within the stated bounds, and no command reaches the limit.",
        domain: "all time; every start up to that angle; gravity as G sin(angle); dry friction of any course up to its torque; every delay of up to one sample between measurement and current, the same to an eighth of a sample; every rounding; sensors off by up to half a step and one step of noise",
        assumptions: "Parameters are the stated ones; the pivot is level; the gyroscope's drift is left within a twentieth of 2 beta, and a reading is as old as its stated rate says; a step of the filter turns as `filter-accurate` says; no sensor fails.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "motion-kept-up",
        statement: "What words, counts, duty and dry friction keep up comes down to the stated bounds about upright.",
        domain: "every motion that starts as `loop-as-shipped` says; sensors off by half a step, no drift",
        assumptions: "As of `loop-as-shipped`.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "stable-for-parameters",
        statement: "The loop with the emitted gains is stable for every parameter vector that identification allows.",
        domain: "the box around the 95 % ellipsoid of the stated standard errors",
        assumptions: "The plant is the linear model; a parameter without a standard error is taken as exact; an observer of the angle's bias is left out.",
        engine: EXACT,
        is_in_certificate: false,
    },
];

/// A claim by its identifier.
pub fn claim(id: &str) -> Option<&'static ClaimStatement> {
    CLAIMS.iter().find(|claim| claim.id == id)
}
