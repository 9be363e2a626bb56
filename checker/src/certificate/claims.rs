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
pub const CLAIMS: &[ClaimStatement] = &[
    ClaimStatement {
        id: "source-understood",
        statement: "The emitted source keeps to the documented language: no float, no heap, no loop, no panic outside of constants, no dependency but `fixed`.",
        domain: "every emitted file",
        assumptions: "",
        engine: READER,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "texts-audited",
        statement: "Apart from the numbers of the bench, every emitted file equals, token by token, a reference text that is known by its digest; every engine has run on the reference texts.",
        domain: "every token of every emitted file, except words, gains, limits and formats",
        assumptions: "No two texts have the same SHA-256 digest.",
        engine: READER,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "compiled-agrees",
        statement: "The crate, compiled by rustc, computes the same words as the checker's reader of its source.",
        domain: "every public function at random words, at the ends of ranges, and on both sides of each branch that was reached; runs of the controller near upright",
        assumptions: "The compiler and the crate `fixed` are those of this machine; the firmware may be built with others.",
        engine: COMPILED,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "certificate-consistent",
        statement: "Every number and name in the certificate equals the one in the source, or follows from it; the gains are those of the Riccati equation of the stated model and weights to 1e-5 of each gain.",
        domain: "every field of certificate.json",
        assumptions: "The gains are compared in double precision, everything else in exact arithmetic.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "model-matches",
        statement: "Parameters, design settings, sensors and drive are those of the user's model.toml.",
        domain: "every number of the model.toml that was given",
        assumptions: "Sensors and drive are compared with those that the generator would emit for that file.",
        engine: READER,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "hardware-words",
        statement: "The words of sensors, mounting, converter and drive are the stated real numbers, rounded to their formats.",
        domain: "every constant of src/constants.rs",
        assumptions: "",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "physical-signs",
        statement: "Sensors, law and drive push a leaning body back upright: no sensor is mirrored, the accelerometer shows a gravity of 8 to 11.5 m/s2, a positive current turns the wheel forward and the body back, the lever arm does not reach far beyond the body, and the raw counts of a leaning body give a current that restores it.",
        domain: "leans of 1 to 10 degrees and rates of 0.2 and 1 rad/s, both ways",
        assumptions: "The stated sensors and drive are those of the bench; `flywheel bring-up` compares them with recordings.",
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
        statement: "Each primitive of the filter keeps the contract of ranges that is stated at it.",
        domain: "every argument that the contract allows",
        assumptions: "A contract other than a range is checked at each call of the primitive, with the words of this bench.",
        engine: INTERVALS,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "filter-total",
        statement: "No step of the attitude filter overflows, and every step keeps the components of the quaternion and the rates within the stated ranges.",
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
        statement: "A step turns any raw counts into a duty within the drive's limits; unless the controller is running, this is the duty of zero current.",
        domain: "every sample and every state within the invariant",
        assumptions: "",
        engine: INTERVALS,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "supervisor",
        statement: "The motor is driven only after arming, with a known attitude near upright and at rest. Driving ends at once when the angle passes its limit, and within a stated time when a sensor is frozen or clipped, the wheel speed is unknown, the vertical is lost, or the current stays at its limit.",
        domain: "every word of LIMITS, by exact arithmetic; the behaviour in random sequences of samples with faults, and with each condition alone",
        assumptions: "Attitude, law and observer are taken from the source; other claims are about them.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "filter-accurate",
        statement: "After one step of the filter, each component of the quaternion agrees with Madgwick's equations in double precision to 2e-7 plus the error of its normalisation (5/16 of the sixth power of the angle turned in the step, in rad); the pivot angle agrees to 1e-6 rad.",
        domain: "random attitudes and readings",
        assumptions: "The reference is implemented from the paper, in floating point.",
        engine: RANDOM,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "filter-exact",
        statement: "Every function of the filter gives, bit for bit, the words of the checker's own implementation in exact integers.",
        domain: "random words, ends of ranges, and words where pieces of a function meet; when the text was audited, every input of each function of one word",
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
        id: "monitor-total",
        statement: "The monitor neither overflows nor panics.",
        domain: "every bit pattern of its words and of its arguments",
        assumptions: "",
        engine: INTERVALS,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "monitor-silent",
        statement: "The monitor allows every motion of the linear model, with gravity as G sin(angle), whose parameters, sensors and torques are off by no more than stated, with one push on the body of the stated size within its memory.",
        domain: "sensors off by 8 standard deviations of the stated noise and half a count (an encoder on the wheel by a whole one, and by what its window is late), the angle by 0.02 rad more; parameters, and the winding resistance of a voltage drive, by 3 standard errors, or 10 % where none is stated; friction, cogging, dead zone and offset up to their torques; a current, or voltage, that acts up to two steps late; angles within the supervisor's limit, and with an encoder on the wheel rates and speeds within those that are shown",
        assumptions: "The drive delivers the current, or the voltage, that the duty asks for; it is not at the end of its supply. No sensor fails.",
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
        statement: "Plant, regulator and the emitted observer of the angle's bias are stable together; at rest, less than a hundredth of a constant bias remains uncorrected.",
        domain: "the linear model sampled at the stated time",
        assumptions: "The current does not saturate. The claim does not apply to a module without observer.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "encoder-loop-stable",
        statement: "The sampled linear loop with a body rate and a wheel speed that are an encoder's turn over its window, with a voltage in place of the current where the drive sets one, and with the observer of the angle's bias, is stable.",
        domain: "the linear model sampled at the stated time",
        assumptions: "No saturation, and no end of the supply; a module without encoder and voltage drive claims nothing here.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "closed-loop-for-all-time",
        statement: "From any start in the stated ellipsoid, the loop with the emitted law never saturates, no voltage reaches the end of the supply, and at every step its state differs by at most the stated bounds from that of the same loop in real numbers and with exact speeds. (With an encoder on the pivot, an observer of the angle's bias, or an encoder on the wheel and no stated ellipsoid: from any start at rest up to the angle in the result, and from the loop in real numbers with the same windows and an observer in real numbers.)",
        domain: "all time; every start in the ellipsoid, or at rest up to the angle in the result; every perturbation by words or sensor steps",
        assumptions: "The plant is the stated linear model. The sensors return the nearest step of their words, without noise. The angle is measured directly, not by the filter. Of a voltage drive: winding resistance and back-EMF are the stated ones, and the winding's inductance is neglected. Of an encoder on the wheel: the motion in its window before the start lay in the ellipsoid too.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "closed-loop-agreement",
        statement: "Each mode of the difference between the loop with the emitted law and the loop with the same gains in real numbers stays within its stated interval at every step.",
        domain: "all time, from equal starts; every state at which the law does not saturate, rounded to its words",
        assumptions: "The plant is the linear model; the command is within half a unit of the law (`control-accurate`); an observer of the angle's bias is left out (`closed-loop-for-all-time` holds it).",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "region-of-attraction",
        statement: "From any start in the stated share of the ellipsoid, the loop with the emitted law never saturates, and its state enters the stated smaller share and stays there. (With an encoder on the pivot, an observer of the angle's bias, or an encoder on the wheel and no such share: from any start at rest up to the angle in the result, into the bounds in the result.)",
        domain: "all time; every start in that share, or at rest up to the angle in the result; every perturbation by words or sensor steps",
        assumptions: "The plant is the stated linear model with gravity as G sin(angle). The sensors return the nearest step of their words, without noise. The angle is measured directly, not by the filter. Of a voltage drive: winding resistance and back-EMF are the stated ones, and the winding's inductance is neglected. Of an encoder on the wheel: the motion in its window before the start lay in the ellipsoid too.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "loop-as-shipped",
        statement: "If the pendulum is armed at rest at any angle up to the one in the result, it stays within the stated bounds, no command reaches the limit, and no voltage the end of the supply. The loop is the emitted step as a whole: from raw counts through filter (or an encoder on the pivot and its window), observer of the angle's bias and law to the duty.",
        domain: "all time; every start at rest up to the angle in the result; gravity as G sin(angle); any torque of dry friction up to the stated one; every delay of up to one sample between measurement and current (or voltage) that lies in one quarter of the sample and stays in it (each of the four quarters is shown); every rounding; sensor errors of half a resolution step, and noise of one resolution step",
        assumptions: "The parameters are the stated ones. Of a voltage drive: so are winding resistance and back-EMF, and the winding's inductance is neglected. The pivot is level, or the count of its encoder upright the stated one, and while the body is at rest before it is armed, that encoder is off by half a count at most. The drift of the gyroscope that remains is at most a tenth of the filter's beta (rad/s), and a reading is at most as old as the stated rate implies. A step of the filter is as accurate as `filter-accurate` states. No sensor fails.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "motion-kept-up",
        statement: "The motion that remains, kept up by dry friction and by the rounding of words, counts and duty, lies within the stated bounds about upright.",
        domain: "every motion that starts as in `loop-as-shipped`; sensor errors of half a resolution step, no drift",
        assumptions: "Those of `loop-as-shipped`.",
        engine: EXACT,
        is_in_certificate: false,
    },
    ClaimStatement {
        id: "stable-for-parameters",
        statement: "The loop with the emitted gains is stable for every parameter vector in the 95 % region of the identified parameters.",
        domain: "the 95 % ellipsoid of the stated standard errors and correlations, or, where no correlations are stated, the box around it",
        assumptions: "The plant is the linear model; a parameter without a standard error is taken as exact, and so is the winding resistance of a voltage drive, whose back-EMF constant is taken equal to the torque constant; any delay between measurement and current is left out. Windows of encoders and an observer of the angle's bias are in it.",
        engine: EXACT,
        is_in_certificate: false,
    },
];

/// A claim by its identifier.
pub fn claim(id: &str) -> Option<&'static ClaimStatement> {
    CLAIMS.iter().find(|claim| claim.id == id)
}
