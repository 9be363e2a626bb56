//! A design in tables.

use workbench::numbers::{complex, degrees, significant, with_uncertainty};
use workbench::{DesignReport, FrictionExtreme, LeastPush, LoopMargins, WheelSize};

use crate::report::table::{Align, Table};

/// The text without the list of figures.
pub fn text(report: &DesignReport) -> String {
    let mut text = format!(
        "{}: {}\nSample time {} s, weights of angle, rate, wheel speed ({}), of the current {}, limit {} A\n",
        report.model,
        report.effects.join(", "),
        report.sample_time_s,
        report
            .state_weights
            .map(|weight| significant(weight, 6))
            .join(", "),
        significant(report.current_weight, 6),
        report.current_limit_a,
    );
    text.push_str(&match report.friction_linearisation_speed_rad_s {
        Some(speed) => format!("Coulomb friction of the pivot enters as μ / {speed} rad/s\n"),
        None => "Coulomb friction is not in the linear model\n".to_owned(),
    });
    for caution in &report.cautions {
        text.push_str(&format!("Caution: {caution}\n"));
    }
    text.push_str(&linear_model(report));
    text.push_str(&poles(report));
    text.push_str(&margins(report));
    text.push_str(&friction(report));
    text.push_str(&pushes(&report.least_pushes));
    text.push_str(&sizes(&report.wheel_sizing));
    text
}

fn linear_model(report: &DesignReport) -> String {
    let mut table = Table::without_head(&[
        Align::Left,
        Align::Right,
        Align::Right,
        Align::Right,
        Align::Right,
    ]);
    let states = ["angle", "rate", "wheel speed"];
    for (row, state) in states.iter().enumerate() {
        let mut cells = vec![format!("d/dt {state} =")];
        for (column, state) in states.iter().enumerate() {
            let entry = significant(report.a[row][column], 6);
            cells.push(format!("{entry} {state}"));
        }
        cells.push(format!("{} current", significant(report.b[row], 6)));
        table.row(cells);
    }
    let gains = report.gains.map(|gain| significant(gain, 9));
    let units = ["A/rad", "A s/rad", "A s/rad"];
    let mut law = Table::without_head(&[Align::Left, Align::Right, Align::Left]);
    for ((state, gain), unit) in states.iter().zip(gains).zip(units) {
        law.row([(*state).to_owned(), gain, unit.to_owned()]);
    }
    let notes: String = report
        .upright
        .iter()
        .map(|note| format!("  {note}\n"))
        .collect();
    format!(
        "\nLinear model about upright (SI units)\n{}{notes}\nGains K of u = −K x\n{}",
        table.text(),
        law.text()
    )
}

fn poles(report: &DesignReport) -> String {
    let mut table = Table::new(&[
        ("loop", Align::Left),
        ("pole", Align::Left),
        ("1/s ± standard error", Align::Left),
        ("moved most by", Align::Left),
    ]);
    let with_error = |value: [f64; 2], std: Option<[f64; 2]>| match std {
        None => complex(value[0], value[1]),
        Some([re, _]) if value[1] == 0.0 => with_uncertainty(value[0], Some(re)),
        Some([re, im]) => format!(
            "{}, {}j",
            with_uncertainty(value[0], Some(re)),
            format_args!("({})", with_uncertainty(value[1], Some(im)))
        ),
    };
    let uncertainty = report.pole_uncertainty.as_ref();
    for (index, &value) in report.open_loop_poles.iter().enumerate() {
        let std = uncertainty.and_then(|found| found.open_loop_std.get(index).copied());
        let culprit = uncertainty.and_then(|found| found.open_loop_moved_most_by.get(index));
        table.row([
            "open".to_owned(),
            String::new(),
            with_error(value, std),
            culprit.cloned().unwrap_or_default(),
        ]);
    }
    let closed = report.closed_loop_poles.iter();
    for (index, (pole, &value)) in closed.zip(&report.closed_loop_poles_per_s).enumerate() {
        let std = uncertainty.and_then(|found| found.closed_loop_std_per_s.get(index).copied());
        let culprit = uncertainty.and_then(|found| found.closed_loop_moved_most_by.get(index));
        table.row([
            "closed".to_owned(),
            complex(pole[0], pole[1]),
            with_error(value, std),
            culprit.cloned().unwrap_or_default(),
        ]);
    }
    let mut text = format!(
        "\nPoles (closed loop: of the sampled loop, and converted to 1/s)\n{}",
        table.text()
    );
    if let Some(found) = uncertainty {
        text.push_str(if found.correlated {
            "  the errors of the parameters are correlated as [correlation] says\n"
        } else {
            "  the model has no [correlation]: the errors are treated as independent\n"
        });
        text.push_str(&format!(
            "  {} of {} parameter sets drawn from the distribution of their errors leave the loop stable\n",
            found.stable(),
            found.drawn
        ));
        let exact = report.parameters.iter().filter(|one| one.std.is_none());
        let exact: Vec<&str> = exact.map(|one| one.name.as_str()).collect();
        if !exact.is_empty() {
            text.push_str(&format!(
                "  taken as exact, because the model states no standard error: {}\n",
                exact.join(", ")
            ));
        }
    }
    text
}

fn margins(report: &DesignReport) -> String {
    let margins = &report.margins;
    let degrees = |radians: f64| format!("{}°", significant(radians.to_degrees(), 4));
    let mut table = Table::without_head(&[Align::Left, Align::Left]);
    let states = report.a.len();
    let rank = |rank: usize, condition: f64| {
        format!(
            "rank {rank} of {states}, condition {}",
            significant(condition, 3)
        )
    };
    table.row([
        "controllability",
        &rank(
            report.controllability_rank,
            report.controllability_condition,
        ),
    ]);
    table.row([
        "observability, all sensors",
        &rank(report.observability_rank, report.observability_condition),
    ]);
    let conditions = &report.observability_condition_of_sensor;
    for ((sensor, of_sensor), alone) in report.observability_rank_of_sensor.iter().zip(conditions) {
        table.row([
            format!("observability, {sensor} alone"),
            rank(*of_sensor, alone.condition),
        ]);
    }
    table.row([
        "gain margin".to_owned(),
        format!(
            "factor {} to {}",
            significant(margins.least_gain_factor, 3),
            significant(margins.largest_gain_factor, 3)
        ),
    ]);
    table.row(["phase margin".to_owned(), degrees(margins.phase_margin_rad)]);
    table.row([
        "delay margin".to_owned(),
        format!(
            "{} ms beyond the hold",
            significant(1e3 * margins.delay_margin_s, 3)
        ),
    ]);
    table.row([
        "modulus margin".to_owned(),
        significant(margins.modulus_margin, 3),
    ]);
    table.row([
        "largest angle at the limit".to_owned(),
        degrees(report.recovery_angle_rad),
    ]);
    table.row([
        "angle bias of 1°".to_owned(),
        format!(
            "the wheel settles at {} rad/s",
            significant(report.wheel_speed_per_angle_bias * 1_f64.to_radians(), 3)
        ),
    ]);
    table.row([
        "Riccati equation".to_owned(),
        format!("relative residual {}", significant(report.dare_residual, 2)),
    ]);
    format!("\nThe loop\n{}", table.text())
}

fn friction(report: &DesignReport) -> String {
    let Some([none, all]) = &report.friction_extremes else {
        return String::new();
    };
    let mut table = Table::new(&[
        ("Coulomb friction", Align::Left),
        ("closed-loop poles in 1/s", Align::Left),
        ("", Align::Left),
        ("phase margin", Align::Right),
        ("delay margin", Align::Right),
    ]);
    let row = |name: &str, extreme: &FrictionExtreme| {
        let poles: Vec<String> = extreme
            .closed_loop_poles_per_s
            .iter()
            .map(|[re, im]| complex(*re, *im))
            .collect();
        let verdict = if extreme.stable { "stable" } else { "unstable" };
        let margin = |value: &dyn Fn(&LoopMargins) -> String| {
            extreme.margins.as_ref().map_or("none".to_owned(), value)
        };
        [
            name.to_owned(),
            poles.join(",  "),
            verdict.to_owned(),
            margin(&|m| degrees(m.phase_margin_rad)),
            margin(&|m| format!("{} ms", significant(1e3 * m.delay_margin_s, 3))),
        ]
    };
    table.row(row("none", none));
    table.row(row("all of it, as damping", all));
    let hunting = match &report.hunting {
        None => "  dry friction causes no limit cycle around upright".to_owned(),
        Some(swing) => format!(
            "  dry friction causes a limit cycle of ±{}° at {} Hz around upright (describing function)",
            significant(swing.angle_rad.to_degrees(), 2),
            significant(swing.frequency_rad_s / std::f64::consts::TAU, 2)
        ),
    };
    format!(
        "\nThe same gains at both extremes of Coulomb friction\n{}  dry friction acts like the first row in a large motion, and \
         like the second in a very\n  small one. A second row that is unstable makes the pendulum hunt around upright; it \
         does not fall\n{hunting}\n",
        table.text()
    )
}

/// Largest recoverable angle, by the wheel's inertia (rows) and top speed (columns).
fn sizes(sizes: &[WheelSize]) -> String {
    let wheels: Vec<&[WheelSize]> = sizes
        .chunk_by(|a, b| a.wheel_factor == b.wheel_factor)
        .collect();
    let speeds: Vec<String> = wheels
        .first()
        .map_or(&[][..], |wheel| wheel)
        .iter()
        .map(|size| format!("{} rad/s", size.wheel_speed_rad_s))
        .collect();
    let mut heads = vec![("wheel inertia", Align::Left)];
    heads.extend(speeds.iter().map(|speed| (speed.as_str(), Align::Right)));
    let mut table = Table::new(&heads);
    for wheel in wheels {
        let mut row = vec![format!(
            "{} kg m2 (× {})",
            significant(wheel[0].wheel_inertia, 3),
            wheel[0].wheel_factor
        )];
        row.extend(wheel.iter().map(|size| {
            format!(
                "{}, {} mJ",
                degrees(size.recoverable_angle_rad),
                significant(1e3 * size.recovered_energy_j, 2)
            )
        }));
        table.row(row);
    }
    format!(
        "\nAngle and energy that a wheel recovers, by its top speed\n{}",
        table.text()
    )
}

fn pushes(pushes: &[LeastPush]) -> String {
    let mut table = Table::new(&[
        ("from rest at", Align::Right),
        ("energy", Align::Right),
        ("full current for", Align::Right),
        ("the wheel gains", Align::Right),
    ]);
    for push in pushes {
        table.row([
            degrees(push.angle_rad),
            format!("{} mJ", significant(1e3 * push.energy_j, 3)),
            format!("{} ms", significant(1e3 * push.duration_s, 3)),
            format!("{} rad/s", significant(push.wheel_speed_rad_s, 3)),
        ]);
    }
    if table.is_empty() {
        return String::new();
    }
    format!(
        "\nThe smallest push of the wheel that lifts the body upright\n{}",
        table.text()
    )
}
