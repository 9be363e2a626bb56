//! Properties of a loop, designs side by side, and sweeps, as tables.

use workbench::numbers::{degrees, significant, with_prefix};
use workbench::{
    DesignSweep, LateLoop, LatePoint, LoopExpectations, NamedLoop, SampleTimeRow, TorqueAnswer,
};

use crate::report::table::{Align, Table};

/// The properties of the loop.
pub fn expectations(found: &LoopExpectations) -> String {
    let mut table = Table::without_head(&[Align::Left, Align::Left]);
    let allowed = &found.excursions;
    table.row([
        "values that cost as much as each other (Bryson)".to_owned(),
        format!(
            "{} rad, {} rad/s, wheel {} rad/s, {} A",
            significant(allowed.angle_rad, 3),
            significant(allowed.rate_rad_s, 3),
            significant(allowed.wheel_speed_rad_s, 3),
            significant(allowed.current_a, 3)
        ),
    ]);
    table.row([
        "delay of the current".to_owned(),
        if found.delay_s > 0.0 {
            with_prefix(found.delay_s, "s")
        } else {
            "none".to_owned()
        },
    ]);
    let Some(margins) = &found.margins else {
        table.row([
            "with that delay".to_owned(),
            "unstable: it falls".to_owned(),
        ]);
        return format!("\nWhat the loop does\n{}", table.text());
    };
    if found.delay_s > 0.0 {
        table.row([
            "with that delay".to_owned(),
            format!(
                "phase margin {}, {} of further delay, modulus margin {}",
                degrees(margins.phase_margin_rad),
                with_prefix(margins.delay_margin_s, "s"),
                significant(margins.modulus_margin, 3)
            ),
        ]);
    }
    if let Some(angle_rad) = found.recoverable_angle_rad {
        table.row([
            "largest angle that it recovers from".to_owned(),
            format!("{}, nonlinear, from rest", degrees(angle_rad)),
        ]);
    }
    for (name, answer) in [("a constant torque", &found.step), ("a push", &found.push)] {
        if let Some(answer) = answer {
            table.row([
                format!("{name}: {}", with_prefix(answer.size, &answer.unit)),
                answered(answer),
            ]);
        }
    }
    if let Some(noise) = &found.noise {
        let units = ["rad", "rad/s", "rad/s"];
        let names = ["angle", "rate", "wheel"];
        let sensors: Vec<String> = (0..3)
            .map(|k| {
                format!(
                    "{} {} ({})",
                    names[k],
                    with_prefix(noise.sensors[k], units[k]),
                    noise.sources[k]
                )
            })
            .collect();
        table.row(["noise of the sensors".to_owned(), sensors.join("; ")]);
        table.row([
            "motion by this noise (standard deviation)".to_owned(),
            format!(
                "angle ±{}, wheel ±{}, current ±{}",
                with_prefix(noise.angle_rad, "rad"),
                with_prefix(noise.wheel_speed_rad_s, "rad/s"),
                with_prefix(noise.current_a, "A")
            ),
        ]);
    }
    format!("\nWhat the loop does\n{}", table.text())
}

fn answered(answer: &TorqueAnswer) -> String {
    let band = answer
        .largest_angle_band_rad
        .map_or(String::new(), |[low, high]| {
            let ends = [low, high].map(|end| significant(end.to_degrees(), 3));
            format!(
                " ({} to {} for 95 % of the parameter sets)",
                ends[0], ends[1]
            )
        });
    format!(
        "angle up to {}{band}, wheel up to {}, current up to {}",
        degrees(answer.largest_angle_rad),
        with_prefix(answer.largest_wheel_speed_rad_s, "rad/s"),
        with_prefix(answer.largest_current_a, "A")
    )
}

/// The loop with all delays and filters of the bench, and the loops with other sample times.
pub fn late(found: &LateLoop) -> String {
    let mut table = Table::without_head(&[Align::Left, Align::Left]);
    for part in &found.parts {
        table.row([
            part.what.clone(),
            format!("{} late: {}", with_prefix(part.late_s, "s"), part.why),
        ]);
    }
    let ahead = with_prefix(found.ahead_s, "s");
    let predicting = format!("u = −K x̂, x̂ predicted {ahead} ahead");
    for (name, point) in [
        ("u = −K x", &found.law),
        (predicting.as_str(), &found.predicting),
    ] {
        table.row([name.to_owned(), point_in_words(point)]);
    }
    let mut times = Table::new(&[
        ("sample time", Align::Right),
        ("modulus margin", Align::Right),
        ("further delay", Align::Right),
        ("angle by noise", Align::Right),
        ("current by noise", Align::Right),
        ("with prediction", Align::Right),
        ("", Align::Left),
    ]);
    for row in &found.sample_times {
        times.row(sample_time(row));
    }
    format!(
        "\nThe loop with all its delays and lags\n{}\nOther sample times, with the same delays and lags\n{}",
        table.text(),
        times.text()
    )
}

fn point_in_words(point: &Option<LatePoint>) -> String {
    let Some(point) = point else {
        return "unstable: it falls".to_owned();
    };
    let poles = point.poles_per_s.iter().map(|[re, im]| {
        let re_text = significant(*re, 3);
        match *im == 0.0 {
            true => re_text,
            false => format!(
                "{re_text} {} {}j",
                if *im < 0.0 { "−" } else { "+" },
                significant(im.abs(), 3)
            ),
        }
    });
    format!(
        "poles {} 1/s; modulus margin {}, {} of further delay; noise: angle ±{}, current ±{}",
        poles.collect::<Vec<_>>().join(", "),
        significant(point.margins.modulus_margin, 3),
        with_prefix(point.margins.delay_margin_s, "s"),
        with_prefix(point.noise_angle_rad, "rad"),
        with_prefix(point.noise_current_a, "A")
    )
}

fn sample_time(row: &SampleTimeRow) -> [String; 7] {
    let of = |text: &dyn Fn(&LatePoint) -> String| row.law.as_ref().map_or("–".to_owned(), text);
    let predicting = row.predicting.as_ref().map_or("–".to_owned(), |point| {
        format!(
            "{}, {}",
            significant(point.margins.modulus_margin, 3),
            with_prefix(point.noise_angle_rad, "rad")
        )
    });
    [
        with_prefix(row.sample_time_s, "s"),
        of(&|point| significant(point.margins.modulus_margin, 3)),
        of(&|point| with_prefix(point.margins.delay_margin_s, "s")),
        of(&|point| with_prefix(point.noise_angle_rad, "rad")),
        of(&|point| with_prefix(point.noise_current_a, "A")),
        predicting,
        if row.sensible {
            "suitable".to_owned()
        } else {
            row.why.clone()
        },
    ]
}

/// A table with one column for each design.
pub fn side_by_side(all: &[NamedLoop]) -> String {
    let mut heads = vec![("", Align::Left)];
    heads.extend(all.iter().map(|one| (one.name, Align::Right)));
    let mut table = Table::new(&heads);
    let mut row = |name: &str, cell: &dyn Fn(&NamedLoop) -> String| {
        let mut cells = vec![name.to_owned()];
        cells.extend(all.iter().map(cell));
        table.row(cells);
    };
    let weights = ["weight of the angle", "of the rate", "of the wheel speed"];
    for (index, name) in weights.iter().enumerate() {
        row(name, &|one| significant(one.report.state_weights[index], 4));
    }
    row("of the current", &|one| {
        significant(one.report.current_weight, 4)
    });
    row("sample time", &|one| {
        with_prefix(one.report.sample_time_s, "s")
    });
    for (index, name) in [
        "gain of the angle, A/rad",
        "of the rate, A s/rad",
        "of the wheel speed, A s/rad",
    ]
    .iter()
    .enumerate()
    {
        row(name, &|one| significant(one.report.gains[index], 5));
    }
    row("slowest pole, 1/s", &|one| {
        let poles = one.report.closed_loop_poles_per_s.iter();
        significant(
            poles.map(|pole| pole[0]).fold(f64::NEG_INFINITY, f64::max),
            4,
        )
    });
    let margin = |one: &NamedLoop, text: &dyn Fn(&workbench::LoopMargins) -> String| {
        one.expectations
            .margins
            .as_ref()
            .map_or_else(|| "unstable".to_owned(), text)
    };
    row("phase margin", &|one| {
        margin(one, &|m| degrees(m.phase_margin_rad))
    });
    row("further delay", &|one| {
        margin(one, &|m| with_prefix(m.delay_margin_s, "s"))
    });
    row("modulus margin", &|one| {
        margin(one, &|m| significant(m.modulus_margin, 3))
    });
    let or_none = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    row("recovers from", &|one| {
        or_none(one.expectations.recoverable_angle_rad.map(degrees))
    });
    row("angle under the torque", &|one| {
        or_none(
            one.expectations
                .step
                .as_ref()
                .map(|found| degrees(found.largest_angle_rad)),
        )
    });
    row("angle under the push", &|one| {
        or_none(
            one.expectations
                .push
                .as_ref()
                .map(|found| degrees(found.largest_angle_rad)),
        )
    });
    row("noise in the angle", &|one| {
        or_none(
            one.expectations
                .noise
                .as_ref()
                .map(|found| with_prefix(found.angle_rad, "rad")),
        )
    });
    row("noise in the current", &|one| {
        or_none(
            one.expectations
                .noise
                .as_ref()
                .map(|found| with_prefix(found.current_a, "A")),
        )
    });
    format!("\nSide by side\n{}", table.text())
}

/// A sweep as a table.
pub fn sweep(sweep: &DesignSweep) -> String {
    let value = format!("{} ({})", sweep.swept.spoken(), sweep.swept.unit());
    let mut table = Table::new(&[
        (value.as_str(), Align::Right),
        ("gains", Align::Right),
        ("slowest pole", Align::Right),
        ("phase margin", Align::Right),
        ("further delay", Align::Right),
        ("noise in the current", Align::Right),
    ]);
    for row in &sweep.rows {
        let value = significant(row.value, 4);
        match &row.point {
            Some(point) => table.row([
                value,
                point.gains.map(|gain| significant(gain, 4)).join(", "),
                format!("{} 1/s", significant(point.slowest_pole_per_s, 3)),
                degrees(point.phase_margin_rad),
                with_prefix(point.delay_margin_s, "s"),
                with_prefix(point.noise_current_a, "A"),
            ]),
            None => table.row([value, "no stable loop".to_owned()]),
        }
    }
    format!("\nOver the {}\n{}", sweep.swept.spoken(), table.text())
}
