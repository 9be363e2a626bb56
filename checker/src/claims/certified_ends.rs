//! Where drive and wheel sensor end, as the certificate states it, against the source and against each other.

use num_traits::Signed;

use crate::certificate::reader::{Certificate, CertifiedDrive, CertifiedVoltage};
use crate::claims::comparison::{Check, equal, holds};
use crate::claims::held_loop::check_back_emf;
use crate::exact::rational::integer;
use crate::language::module::Module;

/// The speeds at the ends of the wheel's sensor lie within the range of the words: a larger speed would be shown as the
/// largest word, and not as unknown.
///
/// # Errors
/// A sentence that names the end.
pub(crate) fn check_wheel_range(certificate: &Certificate) -> Check {
    let wheel = &certificate.hardware.wheel_speed;
    let range = &certificate.inputs[2].range;
    for counts in [wheel.low_counts, wheel.high_counts] {
        let speed =
            &wheel.rad_s_per_count.value * integer(counts.into()) + &wheel.rad_s_at_zero.value;
        holds(speed.abs() <= range.value, || {
            format!(
                "{counts} counts of the wheel's sensor are more than the range of {range} rad/s"
            )
        })?;
    }
    Ok(())
}

/// The duties, the range and the words of the drive belong together.
///
/// # Errors
/// A sentence that names the number.
pub(crate) fn check_drive(certificate: &Certificate, module: &Module) -> Check {
    let drive = &certificate.drive;
    holds(
        drive.duty_low < drive.duty_zero
            && drive.duty_zero < drive.duty_high
            && u64::from(drive.duty_high) < 1u64.checked_shl(drive.bits).unwrap_or(0),
        || "duty_zero is not between duty_low and duty_high of the timer".to_owned(),
    )?;
    let counts = (drive.duty_high - drive.duty_zero).min(drive.duty_zero - drive.duty_low);
    let range = drive.amperes_per_count.value.abs() * integer(counts.into());
    let off = (&range - &drive.current_range_a.value).abs();
    holds(
        off <= range * crate::exact::rational::power(10, -15),
        || {
            format!(
                "current_range_A is stated as {}, the duties make it {counts} counts of {} A",
                drive.current_range_a, drive.amperes_per_count
            )
        },
    )?;
    let zero = match module.constant("constants", "ZERO_CURRENT") {
        Some([word]) => *word,
        _ => return Err("src/constants.rs has no ZERO_CURRENT".to_owned()),
    };
    equal("duty_zero", i128::from(drive.duty_zero), zero)?;
    let name = match &drive.voltage {
        None => "DUTY_LINE",
        Some(voltage) => {
            check_voltage(drive, voltage)?;
            check_back_emf(certificate)?;
            "DUTY_PLANE"
        }
    };
    let words = module
        .constant_words("constants", name)
        .ok_or_else(|| format!("src/constants.rs has no {name}"))?;
    for (end, stated) in [("low", drive.duty_low), ("high", drive.duty_high)] {
        let word = words
            .iter()
            .find(|(name, _)| {
                name.strip_suffix(end)
                    .is_some_and(|rest| rest.ends_with('.'))
            })
            .ok_or_else(|| format!("{name} has no `{end}`"))?;
        equal(&format!("duty_{end}"), i128::from(stated), word.1)?;
    }
    Ok(())
}

/// The numbers of a voltage drive belong together, and no duty asks for more than the supply.
fn check_voltage(drive: &CertifiedDrive, voltage: &CertifiedVoltage) -> Check {
    for (what, stated) in [
        ("supply_V", &voltage.supply_v),
        ("winding_Ohm", &voltage.winding_ohm),
        ("back_emf_V_s", &voltage.back_emf_v_s),
    ] {
        holds(stated.value.is_positive(), || {
            format!("{what} is {stated}; it is more than zero")
        })?;
    }
    let per_count = &voltage.volts_per_count.value;
    let at_rest = per_count / &voltage.winding_ohm.value;
    let off = (&at_rest - &drive.amperes_per_count.value).abs();
    holds(
        off <= at_rest.abs() * crate::exact::rational::power(10, -14),
        || "amperes_per_count is not that of the winding at standstill".to_owned(),
    )?;
    let reach = (drive.duty_high - drive.duty_zero).max(drive.duty_zero - drive.duty_low);
    let most = per_count.abs() * integer(reach.into());
    let allowed = &voltage.supply_v.value * (integer(1) + crate::exact::rational::power(10, -9));
    holds(most <= allowed, || {
        format!(
            "the ends of the duty ask for more than the supply's {} V",
            voltage.supply_v
        )
    })
}
