//! Checks of the values in `[known]`.

use bench_files::Bench;

use crate::finding::{Finding, FindingId};
use crate::slips::short;
use crate::thresholds::bench::{GRAVITY, LENGTH_M, MASS_KG, SURELY, TORQUE_CONSTANT};

pub(crate) fn check(bench: &Bench, out: &mut Vec<Finding>) {
    missing(bench, out);
    let known = &bench.known;
    if let Some(gravity) = known.gravity
        && !GRAVITY.contains(&gravity)
    {
        let is_elsewhere = (GRAVITY.start / SURELY..GRAVITY.end * SURELY).contains(&gravity);
        let make = if is_elsewhere {
            Finding::warning
        } else {
            Finding::refusal
        };
        out.push(
            make(
                FindingId::KnownRange,
                format!(
                    "gravity = {} m/s² is not the gravity of Earth's surface",
                    short(gravity)
                ),
            )
            .with_fix("gravity = 9.81"),
        );
    }
    for (key, value, unit, range) in [
        ("body_mass", known.body_mass, "kg", MASS_KG),
        ("wheel_mass", known.wheel_mass, "kg", MASS_KG),
        ("pivot_to_wheel", known.pivot_to_wheel, "m", LENGTH_M),
        (
            "pivot_to_com",
            known.pivot_to_com.map(f64::abs),
            "m",
            LENGTH_M,
        ),
        (
            "torque_constant",
            known.torque_constant,
            "N m/A",
            TORQUE_CONSTANT,
        ),
    ] {
        let Some(value) = value else { continue };
        // The centre of mass may lie at the pivot.
        let too_small = value < range.start && key != "pivot_to_com";
        if !too_small && value < range.end {
            continue;
        }
        let sentence = format!(
            "{key} = {} {unit} is out of scale for a bench; it is given in {unit}",
            short(value)
        );
        let surely = value > SURELY * range.end || value < range.start / SURELY;
        let finding = if surely {
            Finding::refusal(FindingId::KnownRange, sentence)
        } else {
            Finding::warning(FindingId::KnownRange, sentence)
        };
        let thousandth = value / 1e3;
        let (factor, fix) = if range.contains(&thousandth) {
            (Some(1e3), format!("{key} = {}", short(thousandth)))
        } else if range.contains(&(value * 1e3)) {
            (Some(1e-3), format!("{key} = {}", short(value * 1e3)))
        } else {
            (None, format!("{key} in {unit}"))
        };
        out.push(Finding {
            factor,
            ..finding.with_fix(fix)
        });
    }
}

/// Checks for masses and lengths that give no torque because another value is missing.
fn missing(bench: &Bench, out: &mut Vec<Finding>) {
    let known = &bench.known;
    let parts = [
        known.body_mass,
        known.wheel_mass,
        known.pivot_to_wheel,
        known.pivot_to_com,
    ];
    let given = parts.iter().filter(|part| part.is_some()).count();
    let Err(lacking) = known.gravity_torque() else {
        return;
    };
    // One of the four alone may be given for another purpose.
    if given < 2 {
        return;
    }
    let names = lacking.missing.join(", ");
    let fix = if lacking.missing == ["gravity"] {
        "gravity = 9.81".to_owned()
    } else if lacking.missing.contains(&"gravity") {
        format!("{names} under [known] (gravity = 9.81 on Earth)")
    } else {
        format!("{names} under [known]")
    };
    out.push(
        Finding::warning(
            FindingId::KnownMissing,
            format!(
                "masses and lengths give no torque without {names}: torques are identified per unit of inertia only"
            ),
        )
        .with_fix(fix),
    );
}
