//! The linear loop with what the drive really holds over a step: a current, or a voltage.
//!
//! A current drive holds u. A voltage drive holds V = R u + k_e φ̇ with the wheel speed of the sample, while the current
//! that flows is (V − k_e φ̇)/R with the wheel speed of the moment; the winding's inductance is neglected, and R and k_e
//! are the stated ones. In amperes at standstill, w = V/R, and with κ = k_e/R,
//!
//! ẋ = A x + B (w − κ φ̇) = A' x + B w,   A' = A − κ B e₃ᵀ,   w = N' x,   N' = N + κ e₃ᵀ.
//!
//! So it is a loop of the same form with other numbers, and every argument about a current that is held over a step
//! holds for w. There is one condition more: the supply does not clip, |w| ≤ V_max/R.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::certificate::reader::{Certificate, matrix, vector};
use crate::claims::control_law::EmittedLaw;
use crate::exact::matrices::{Matrix, Vector};
use crate::exact::rational::integer;

/// The numbers of the held input.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldLoop {
    /// A' of ẋ = A' x + B w.
    pub a: Matrix,
    /// B, per ampere.
    pub b: Vector,
    /// A' and B sampled with w held, as stated.
    pub ad: Matrix,
    /// The sampled B.
    pub bd: Vector,
    /// κ = k_e/R (A s/rad); zero for a current drive.
    pub back_emf: BigRational,
    /// Largest |w| that the duty asks for (A); `None` for a current drive, whose limit is that of the law.
    pub reach: Option<BigRational>,
}

impl HeldLoop {
    /// The loop of a certificate.
    pub fn of(certificate: &Certificate) -> HeldLoop {
        let (a, b) = (matrix(&certificate.plant.a), vector(&certificate.plant.b));
        let Some(voltage) = &certificate.drive.voltage else {
            return HeldLoop {
                a,
                b,
                ad: matrix(&certificate.plant.ad),
                bd: vector(&certificate.plant.bd),
                back_emf: BigRational::zero(),
                reach: None,
            };
        };
        HeldLoop {
            a: braked(&a, &b, &back_emf(certificate)),
            b,
            ad: matrix(&voltage.ad),
            bd: vector(&voltage.bd),
            back_emf: back_emf(certificate),
            reach: reach(certificate),
        }
    }

    /// The gains of w for the gains of the current.
    pub fn gains(&self, of_current: &Vector) -> Vector {
        held_gains(of_current, &self.back_emf)
    }

    /// The loop with the real gains −K of the certificate, and the one with the emitted gains.
    pub fn loops(&self, certificate: &Certificate, law: &EmittedLaw) -> (Matrix, Matrix) {
        let with = |gains: &Vector| -> Matrix {
            let gains = self.gains(gains);
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| &self.ad[i][j] + &self.bd[i] * &gains[j]))
        };
        let minus_k = vector(&certificate.gains).map(|gain| -gain);
        (with(&minus_k), with(&law.gains))
    }
}

/// κ = k_e/R (A s/rad); zero for a current drive, and for a winding without resistance, which
/// `certificate-consistent` refuses.
pub(crate) fn back_emf(certificate: &Certificate) -> BigRational {
    match &certificate.drive.voltage {
        Some(voltage) if voltage.winding_ohm.value.is_positive() => {
            &voltage.back_emf_v_s.value / &voltage.winding_ohm.value
        }
        _ => BigRational::zero(),
    }
}

/// Largest |V|/R that the duty asks for both ways (A), at most the supply's; `None` for a current drive.
pub(crate) fn reach(certificate: &Certificate) -> Option<BigRational> {
    let drive = &certificate.drive;
    let voltage = drive.voltage.as_ref()?;
    let above = i128::from(drive.duty_high) - i128::from(drive.duty_zero);
    let below = i128::from(drive.duty_zero) - i128::from(drive.duty_low);
    let of_duty = integer(above.min(below)) * drive.amperes_per_count.value.abs();
    if voltage.winding_ohm.value.is_positive() {
        Some(of_duty.min(&voltage.supply_v.value / &voltage.winding_ohm.value))
    } else {
        Some(of_duty)
    }
}

/// A − κ B e₃ᵀ: the back-EMF brakes the wheel.
pub(crate) fn braked(a: &Matrix, b: &Vector, back_emf: &BigRational) -> Matrix {
    [0, 1, 2].map(|i| {
        let [angle, rate, speed] = a[i].clone();
        [angle, rate, speed - &b[i] * back_emf]
    })
}

/// N + κ e₃ᵀ.
pub(crate) fn held_gains(of_current: &Vector, back_emf: &BigRational) -> Vector {
    let [angle, rate, speed] = of_current.clone();
    [angle, rate, speed + back_emf]
}

/// That the stated back-EMF is that of the motor, k_e = τ in SI units, wherever the parameters state τ.
///
/// # Errors
/// A sentence.
pub(crate) fn check_back_emf(certificate: &Certificate) -> Result<(), String> {
    let mut parameters = certificate.parameters.iter();
    let torque = parameters.find(|parameter| parameter.name == "torque_constant");
    let (Some(voltage), Some(torque)) = (&certificate.drive.voltage, torque) else {
        return Ok(());
    };
    if voltage.back_emf_v_s.value == torque.value.value {
        Ok(())
    } else {
        Err(format!(
            "back_emf_V_s is stated as {}, the motor's torque constant is {}: in SI units they are one number",
            voltage.back_emf_v_s, torque.value
        ))
    }
}
