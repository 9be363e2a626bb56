//! Largest difference between the speed that an encoder shows over its window and the wheel's present speed.
//!
//! The shown speed is the mean of φ̇ over the last N steps. If |φ̈| ≤ Φ in that time, the difference is at most ∫ (age)
//! Φ/(N T) = Φ N T/2, plus the rounding of the two counts. Φ is bounded in the invariant set: at a sample φ̈ = (A₃ + B₃
//! N) x + B₃ v, and until the next sample the states change by no more than the model's rows allow. The stated Φ enters
//! the perturbation v. The acceleration that follows must not exceed the stated Φ; then no step can be the first to
//! exceed it. Gravity counts as a sine, so that the bound serves `region-of-attraction` too. The window before the
//! start must have been a motion within the set.

use num_rational::BigRational;
use num_traits::Signed;

use crate::certificate::reader::{Certificate, CertifiedLoop};
use crate::claims::held_loop::HeldLoop;
use crate::exact::matrices::Vector;
use crate::exact::rational::{half, integer, power, rounded_up};

/// Rounds in which the bounds between samples are enlarged.
const ROUNDS: usize = 40;

/// The stated bound of the wheel's acceleration, with the window that it is for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WindowLag {
    /// Largest deviation of the shown speed from the true one, without counts (rad/s); zero without an encoder.
    pub speed: BigRational,
    /// How many readings a shown speed is made of.
    pub readings: i128,
    acceleration: Option<BigRational>,
}

impl WindowLag {
    /// That of a certificate.
    ///
    /// # Errors
    /// A sentence, where the bound of the acceleration is stated without an encoder on the wheel, or the reverse.
    pub fn of(certificate: &Certificate, stated: &CertifiedLoop) -> Result<WindowLag, String> {
        match (
            &certificate.hardware.wheel_speed.encoder,
            &stated.wheel_acceleration,
        ) {
            (None, None) => Ok(WindowLag {
                speed: integer(0),
                readings: 1,
                acceleration: None,
            }),
            (Some(encoder), Some(acceleration)) => {
                let window = integer(encoder.window.into()) * &certificate.sample_time_s.value;
                Ok(WindowLag {
                    speed: window * half() * acceleration.value.abs(),
                    readings: 2,
                    acceleration: Some(acceleration.value.clone()),
                })
            }
            _ => Err(
                "wheel_acceleration_rad_s2 is to be stated with an encoder on the wheel, and with no other sensor"
                    .to_owned(),
            ),
        }
    }

    /// Shows that no acceleration passes the stated one, for perturbations of at most `noise`. `of_row` is the largest
    /// |r x| in the set, `extents` those of the states, `gains` those of what the drive holds.
    ///
    /// # Errors
    /// A sentence.
    pub fn check(
        &self,
        certificate: &Certificate,
        held: &HeldLoop,
        extents: &Vector,
        gains: &Vector,
        noise: &BigRational,
        of_row: &dyn Fn(&Vector) -> Result<BigRational, &'static str>,
    ) -> Result<(), String> {
        let Some(stated) = &self.acceleration else {
            return Ok(());
        };
        let t = &certificate.sample_time_s.value;
        let current = of_row(gains)? + noise;
        let gravity = held.a[1][0].abs();
        let sine = |angle: &BigRational| &gravity * angle * angle * angle / integer(6);
        let mut b = extents.clone();
        for _ in 0..ROUNDS {
            let reached: Vector = [0, 1, 2].map(|i| {
                let mut rate = held.b[i].abs() * &current;
                for (entry, bound) in held.a[i].iter().zip(&b) {
                    rate += entry.abs() * bound;
                }
                if i > 0 {
                    rate += sine(&b[0]);
                }
                &extents[i] + t * rate
            });
            if reached.iter().zip(&b).all(|(new, old)| new < old) {
                let [_, _, wheel] = &held.a;
                let at_sample: Vector = [0, 1, 2].map(|j| &wheel[j] + &held.b[2] * &gains[j]);
                let mut found = of_row(&at_sample)? + held.b[2].abs() * noise + sine(&b[0]);
                for j in 0..3 {
                    found += wheel[j].abs() * (&b[j] - &extents[j]);
                }
                return if found <= *stated {
                    Ok(())
                } else {
                    Err(format!(
                        "the wheel may accelerate with {} rad/s2 in the invariant set, {} is stated",
                        rounded_up(&found, 6),
                        rounded_up(stated, 6)
                    ))
                };
            }
            // A little more than the value that was reached, in few digits.
            b = reached.map(|value| {
                let scaled = value * power(10, 12) * (integer(1) + power(10, -9));
                scaled.ceil() / power(10, 12)
            });
        }
        Err("the motion between two samples does not settle".to_owned())
    }
}
