//! Claim `control-accurate-real-gains`: the command lies within the stated bound of the law with the
//! real gains, saturated at the real limit.

use num_rational::BigRational;

use crate::certificate::reader::{Certificate, vector};
use crate::claims::control_law::EmittedLaw;
use crate::claims::outcome::ClaimOutcome;
use crate::exact::rational::rounded_up;

/// The derived bound against the stated one.
pub fn by_exact_arithmetic(certificate: &Certificate, law: &EmittedLaw) -> ClaimOutcome {
    let (bound, _) = derived(certificate, law);
    if bound <= certificate.bounds.real_gains.value {
        ClaimOutcome::Proved(format!("{} A", rounded_up(&bound, 4)))
    } else {
        ClaimOutcome::Failed(format!(
            "{} A, stated are {}",
            rounded_up(&bound, 4),
            certificate.bounds.real_gains
        ))
    }
}

/// The bound against the real gains, and that of rounding a state.
pub fn derived(certificate: &Certificate, law: &EmittedLaw) -> (BigRational, BigRational) {
    let k = vector(&certificate.gains);
    let ranges = [0, 1, 2].map(|i| certificate.inputs[i].range.value.clone());
    let limit = &certificate.constants[3].real.value;
    (
        law.real_gains_bound(&k, limit, &ranges),
        law.state_rounding(&k),
    )
}
