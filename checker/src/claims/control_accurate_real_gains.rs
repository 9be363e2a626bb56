//! Claim `control-accurate-real-gains`: the command lies within the stated bound of the law with the
//! real gains, saturated at the real limit.

use num_rational::BigRational;

use crate::certificate::reader::{Certificate, vector};
use crate::claims::control_law::ControlLaw;
use crate::claims::outcome::Outcome;
use crate::exact::rational::rounded_up;

/// The derived bound against the stated one.
pub fn by_exact_arithmetic(certificate: &Certificate, law: &ControlLaw) -> Outcome {
    let (bound, _) = derived(certificate, law);
    if bound <= certificate.bounds.real_gains.value {
        Outcome::Proved(format!("{} A", rounded_up(&bound, 4)))
    } else {
        Outcome::Failed(format!(
            "{} A, stated are {}",
            rounded_up(&bound, 4),
            certificate.bounds.real_gains
        ))
    }
}

/// The bound against the real gains, and that of rounding a state.
pub fn derived(certificate: &Certificate, law: &ControlLaw) -> (BigRational, BigRational) {
    let k = vector(&certificate.gains);
    let ranges = [0, 1, 2].map(|i| certificate.inputs[i].range.value.clone());
    let limit = &certificate.constants[3].real.value;
    (
        law.real_gains_bound(&k, limit, &ranges),
        law.state_rounding(&k),
    )
}
