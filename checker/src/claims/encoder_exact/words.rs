//! The words of the encoders, from the certificate.

use std::f64::consts::TAU;

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};

use crate::certificate::hardware::CertifiedEncoder;
use crate::certificate::reader::Certificate;
use crate::claims::encoder_exact::second::EncoderWords;
use crate::language::module::Module;

/// How many times the largest current's acceleration an encoder may show from step to step.
const PUSHES: f64 = 4.0;
/// Share of a turn by which its count may be off besides.
const OFF: f64 = 1.0 / 64.0;
/// Fewest counts that it may be off.
const FEWEST: f64 = 4.0;

/// The encoders of a module: the constant of each, what is stated of it, and what an ampere accelerates its axis by
/// (rad/s²).
pub(crate) fn encoders(
    certificate: &Certificate,
) -> impl Iterator<Item = (&'static str, CertifiedEncoder, &BigRational)> {
    let b = &certificate.plant.b;
    let wheel = certificate.hardware.wheel_speed.encoder.clone();
    let body = certificate.hardware.body_encoder();
    let body = body.map(|body| ("BODY_ENCODER", body.encoder(), &b[1].value));
    let wheel = wheel.map(|encoder| ("WHEEL_ENCODER", encoder, &b[2].value));
    body.into_iter().chain(wheel)
}

/// Checks every word.
///
/// # Errors
/// A sentence that names the word.
pub fn check(certificate: &Certificate, module: &Module) -> Result<(), String> {
    let real = |value: &BigRational| value.to_f64().unwrap_or(f64::NAN);
    let period = real(&certificate.sample_time_s.value);
    let limit = certificate
        .constant("CURRENT_LIMIT")
        .ok_or("there is no limit")?;
    for (name, stated, acceleration) in encoders(certificate) {
        let words = EncoderWords::read(module, name)?;
        let words = words.ok_or_else(|| format!("src/constants.rs has no {name}"))?;
        if words.wrap != 1 << stated.bits || words.window != i128::from(stated.window) {
            return Err(format!(
                "{name} wraps at {} over {} steps, the certificate says {} bits over {}",
                words.wrap, words.window, stated.bits, stated.window
            ));
        }
        let in_a_step = real(&acceleration.abs()) * real(&limit.real.value) * period * period;
        let per_turn = real(&stated.counts_per_turn.value).abs();
        let wanted = ((PUSHES * in_a_step / TAU + OFF) * per_turn).max(FEWEST);
        // Rounded up to a whole count.
        let off = words.jump as f64 - wanted;
        if !(-1e-6..1.0 + 1e-6).contains(&off) || words.jump >= words.wrap / 2 {
            return Err(format!(
                "{name}.jump is {}, its numbers make it {wanted:.2}",
                words.jump
            ));
        }
    }
    Ok(())
}
