//! The closed loop in tables.

use workbench::numbers::{degrees, percent, significant, with_prefix};
use workbench::{
    EffectOnTransient, LinearRangeReport, LoopOverlay, LoopRun, MeasuredSwings, SimulationReport,
    SpinUpLinearity,
};

use crate::report::table::{Align, Table};

/// The text without the list of files.
pub fn text(report: &SimulationReport) -> String {
    let mut text = format!(
        "{}: the emitted law, executed from its source, on the nonlinear bench\n",
        report.model
    );
    if !report.assumed.is_empty() {
        text.push_str(
            "Assumed, from the bench of the thesis, because the model does not state it:\n",
        );
        for sentence in &report.assumed {
            text.push_str(&format!("  {sentence}\n"));
        }
    }
    text.push_str(&runs(&report.runs));
    text.push_str(&raw_counts(report));
    text.push_str(&recovery(report));
    text.push_str(&attraction(report));
    text.push_str("\nMethods for the angle, RMS error over a free swing from 60°\n");
    for filter in &report.attitude_filters {
        text.push_str(&format!(
            "  {}: {}\n",
            filter.filter,
            degrees(filter.error_rad)
        ));
    }
    text.push_str(&effects(&report.effects));
    text.push_str(&linear_model(&report.linear_model));
    if let Some(swings) = &report.measured_swings {
        text.push_str(&measured_swings(swings));
    }
    if !report.measured_spin_ups.is_empty() {
        text.push_str(&measured_spin_ups(&report.measured_spin_ups));
    }
    for overlay in &report.overlays {
        text.push_str(&overlaid(overlay));
    }
    text
}

fn runs(runs: &[LoopRun]) -> String {
    let mut table = Table::new(&[
        ("run", Align::Left),
        ("largest angle", Align::Right),
        ("wheel", Align::Right),
        ("current", Align::Right),
        ("settles after", Align::Right),
        ("emitted − exact", Align::Right),
        ("", Align::Left),
    ]);
    for run in runs {
        table.row([
            run.scenario.clone(),
            degrees(run.largest_angle_rad),
            format!("{} rad/s", significant(run.largest_wheel_speed_rad_s, 3)),
            format!("{} A", significant(run.largest_current_a, 3)),
            format!("{} s", significant(run.settling_s, 3)),
            with_prefix(run.difference_angle_rad, "rad"),
            if run.fell { "FELL" } else { "" }.to_owned(),
        ]);
    }
    format!("\nRuns of the emitted law\n{}", table.text())
}

fn raw_counts(report: &SimulationReport) -> String {
    let run = &report.raw_counts;
    format!(
        "\nThe half minute from raw counts to duty, through the emitted controller\n  {}, at most {}, wheel \
         {} rad/s, {} A; the measured angle is off by {} RMS\n",
        if run.fell { "FELL" } else { "stays up" },
        degrees(run.largest_angle_rad),
        significant(run.largest_wheel_speed_rad_s, 3),
        significant(run.largest_current_a, 3),
        degrees(run.angle_error_rad),
    )
}

fn recovery(report: &SimulationReport) -> String {
    let found = &report.recovery;
    format!(
        "\nLargest angle recovered from rest, without sensor noise\n  emitted law {}, law in floating point {}, asin(τ \
         u_max/G) = {}\n",
        degrees(found.emitted_law_rad),
        degrees(found.exact_law_rad),
        degrees(found.limit_rad),
    )
}

fn attraction(report: &SimulationReport) -> String {
    let Some(found) = &report.attraction else {
        return String::new();
    };
    let [angle, rate, speed] = found.extents;
    let lost = found.lost;
    format!(
        "\nRegion of attraction, {} starts all over the boundary, with the sensors' noise\n  all return at \
         {:.2} times the certificate's ellipsoid (up to {:.1}°, {} rad/s, wheel {} rad/s)\n  a start is lost \
         at {:.2} times the ellipsoid: {:.1}°, {} rad/s, wheel {} rad/s\n",
        found.starts,
        found.size,
        angle.to_degrees(),
        significant(rate, 3),
        significant(speed, 3),
        found.lost_size,
        lost[0].to_degrees(),
        significant(lost[1], 3),
        significant(lost[2], 3),
    )
}

fn effects(effects: &[EffectOnTransient]) -> String {
    let mut table = Table::new(&[
        ("beyond viscous friction", Align::Left),
        ("swings", Align::Right),
        ("overshoot", Align::Right),
        ("settles after", Align::Right),
        ("what stays (RMS)", Align::Right),
    ]);
    for part in effects {
        table.row([
            if part.effects.is_empty() {
                "nothing".to_owned()
            } else {
                part.effects.join(", ")
            },
            part.swings.to_string(),
            degrees(part.overshoot_rad),
            format!("{} s", significant(part.settling_s, 3)),
            with_prefix(part.residual_rad, "rad"),
        ]);
    }
    format!(
        "\nThe transient with the effects of the model\n{}",
        table.text()
    )
}

fn linear_model(linear: &LinearRangeReport) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let spin_up = match linear.spin_up_good_up_to_rad_s {
        Some(speed) => format!("up to {} rad/s", significant(speed, 3)),
        None => "at every speed of the run".to_owned(),
    };
    let swings: Vec<String> = linear
        .free_swing_error
        .iter()
        .map(|[amplitude, error]| {
            format!("{} from {:.0}°", percent(*error), amplitude.to_degrees())
        })
        .collect();
    format!(
        "\nThe linear model\n  ten periods of a free swing within {} of the nonlinear one up to {:.1}° \
         (same terms)\n  error over the first period: {}\n  spin-up with {} A within {}: {spin_up}\n",
        percent(linear.share),
        linear.good_up_to_amplitude_rad.to_degrees(),
        swings.join(", "),
        significant(linear.spin_up_current_a, 3),
        percent(linear.share),
    )
}

fn measured_swings(found: &MeasuredSwings) -> String {
    let mut table = Table::new(&[
        ("free swing", Align::Left),
        ("amplitude", Align::Right),
        ("nonlinear", Align::Right),
        ("linear", Align::Right),
    ]);
    for swing in &found.swings {
        table.row([
            swing.experiment.clone(),
            degrees(swing.amplitude_rad),
            percent(swing.nonlinear_error),
            percent(swing.linear_error),
        ]);
    }
    format!(
        "\nMeasured free swings against both models: RMS error over ten periods, of the amplitude\n{}  {}\n",
        table.text(),
        found.range_sentence()
    )
}

fn measured_spin_ups(found: &[SpinUpLinearity]) -> String {
    let mut table = Table::new(&[
        ("spin-up", Align::Left),
        ("largest speed", Align::Right),
        ("nonlinear", Align::Right),
        ("linear", Align::Right),
    ]);
    for spin_up in found {
        table.row([
            spin_up.experiment.clone(),
            format!(
                "{} rad/s",
                significant(spin_up.largest_wheel_speed_rad_s, 3)
            ),
            percent(spin_up.nonlinear_error),
            percent(spin_up.linear_error),
        ]);
    }
    format!(
        "\nMeasured spin-ups against both models: RMS error, of the largest speed\n{}",
        table.text()
    )
}

fn overlaid(overlay: &LoopOverlay) -> String {
    let mut table = Table::new(&[
        ("channel", Align::Left),
        ("RMS of the difference", Align::Right),
        ("measured σ", Align::Right),
        ("simulated σ", Align::Right),
    ]);
    for channel in &overlay.channels {
        table.row([
            channel.channel.clone(),
            significant(channel.rms_difference, 3),
            significant(channel.measured_std, 3),
            significant(channel.simulated_std, 3),
        ]);
    }
    format!(
        "\nSimulated over measured: {} ({} found in the log; SI units)\n{}",
        overlay.experiment,
        match overlay.pushes {
            1 => "1 push".to_owned(),
            pushes => format!("{pushes} pushes"),
        },
        table.text()
    )
}
