//! The facts about a design for the page, as JSON.

use serde::Deserialize;
use serde_json::{Value, json};
use workbench::numbers::{significant, with_prefix};
use workbench::{
    DesignReport, DesignSection, ExpectationSettings, LoopExpectations, LoopResponse, TorqueAnswer,
    weights_of_excursions,
};

use crate::desk::{OpenBench, said};
use crate::picture::{View, thinned};

/// Width for which the responses of a design are drawn.
const RESPONSE_PIXELS: usize = 500;

/// The settings for a design, as the page sends them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    /// Weights, sample time, limit.
    wishes: DesignSection,
    /// Allowed excursions in place of the weights: rad, rad/s, rad/s, A.
    #[serde(default)]
    excursions: Option<[f64; 4]>,
    /// Delay from the command to the current in the motor, s.
    #[serde(default)]
    delay_s: f64,
}

/// The controller for these weights, with margins and responses of its loop.
///
/// # Errors
/// A sentence, where these weights give no controller.
pub fn design(bench: &OpenBench, asked: Asked) -> Result<Value, String> {
    let mut wishes = asked.wishes;
    if let Some(excursions) = asked.excursions {
        let [angle, rate, wheel_speed, current] = weights_of_excursions(excursions)?;
        wishes.state_weights = [angle, rate, wheel_speed];
        wishes.current_weight = current;
    }
    let designed = bench.session.design_for(wishes).map_err(said)?;
    let report = designed.report().map_err(said)?;
    let settings = ExpectationSettings {
        delay_s: asked.delay_s,
        noise: bench.session.sensor_noise(),
    };
    let found = designed.expectations(&settings).map_err(said)?;
    let responses = designed.responses().map_err(said)?;
    Ok(json!({
        "wishes": wishes,
        "report": report,
        "expectations": found,
        "numbers": numbers(&report, &found),
        "frequencies": frequencies(&found),
        "step": found.step.as_ref().map(answer),
        "push": found.push.as_ref().map(answer),
        "responses": responses.iter().map(response).collect::<Vec<_>>(),
    }))
}

fn degrees(rad: f64) -> String {
    format!("{}°", significant(rad.to_degrees(), 3))
}

/// The lines about the design, each with name and value.
pub(crate) fn numbers(
    report: &DesignReport,
    found: &LoopExpectations,
) -> Vec<(&'static str, String)> {
    let or_without_limit = |value: f64, text: String| match value.is_finite() {
        true => text,
        false => "without limit".to_owned(),
    };
    let mut lines = vec![
        (
            "Gains K (A/rad, A s/rad, A s/rad)",
            report.gains.map(|gain| significant(gain, 6)).join(", "),
        ),
        (
            "Largest angle at rest that the current limit can hold",
            degrees(report.recovery_angle_rad),
        ),
    ];
    if !report.upright.is_empty() {
        lines.push((
            "Curves and own effects in the linear model",
            report.upright.join("; "),
        ));
    }
    if let Some(angle_rad) = found.recoverable_angle_rad {
        lines.push((
            "Largest angle at rest from which this law recovers (nonlinear)",
            degrees(angle_rad),
        ));
    }
    match &found.margins {
        None => lines.push(("With this delay", "unstable: it falls".to_owned())),
        Some(margins) => lines.extend([
            (
                "Gain margin (factor)",
                format!(
                    "{} to {}",
                    significant(margins.least_gain_factor, 3),
                    or_without_limit(
                        margins.largest_gain_factor,
                        significant(margins.largest_gain_factor, 3)
                    )
                ),
            ),
            (
                "Phase margin",
                or_without_limit(margins.phase_margin_rad, degrees(margins.phase_margin_rad)),
            ),
            (
                "Delay margin",
                or_without_limit(
                    margins.delay_margin_s,
                    with_prefix(margins.delay_margin_s, "s"),
                ),
            ),
            (
                "Smallest distance of the open loop from −1",
                significant(margins.modulus_margin, 3),
            ),
        ]),
    }
    if let Some(errors) = &report.pole_uncertainty {
        lines.push((
            "Stable for",
            format!(
                "{} of {} parameter sets within their errors",
                errors.stable(),
                errors.drawn
            ),
        ));
    }
    if let Some(noise) = &found.noise {
        lines.extend([
            ("Noise in the angle", with_prefix(noise.angle_rad, "rad")),
            ("Noise in the current", with_prefix(noise.current_a, "A")),
            (
                "Noise of the sensors (angle, rate, wheel speed)",
                noise
                    .sensors
                    .iter()
                    .zip(["rad", "rad/s", "rad/s"])
                    .zip(&noise.sources)
                    .map(|((std, unit), source)| format!("{} ({source})", with_prefix(*std, unit)))
                    .collect::<Vec<_>>()
                    .join(", "),
            ),
        ]);
    }
    lines.push((
        "Steady wheel speed if the angle is measured 1° too large",
        format!(
            "{} rad/s",
            significant(report.wheel_speed_per_angle_bias * 1_f64.to_radians(), 3)
        ),
    ));
    lines
}

fn frequencies(found: &LoopExpectations) -> Value {
    let all = found.frequencies.iter();
    json!({
        "frequency_rad_s": all.clone().map(|at| at.frequency_rad_s).collect::<Vec<_>>(),
        "size": all.clone().map(|at| at.value.norm()).collect::<Vec<_>>(),
        "phase_deg": all.clone().map(|at| at.phase_rad.to_degrees()).collect::<Vec<_>>(),
        "re": all.clone().map(|at| at.value.re).collect::<Vec<_>>(),
        "im": all.map(|at| at.value.im).collect::<Vec<_>>(),
    })
}

fn answer(found: &TorqueAnswer) -> Value {
    let curves = &found.curves;
    let curve =
        |y: &[f64], band: &workbench::Band| json!({"y": y, "low": band.low, "high": band.high});
    json!({
        "about": format!("{} on the body from time zero on", with_prefix(found.size, &found.unit)),
        "time_s": curves.nominal.time_s,
        "angle_rad": curve(&curves.nominal.angle_rad, &curves.angle_band),
        "wheel_speed_rad_s": curve(&curves.nominal.wheel_speed_rad_s, &curves.wheel_speed_band),
        "current_a": curve(&curves.nominal.current_a, &curves.current_band),
    })
}

fn response(run: &LoopResponse) -> Value {
    let view = View {
        from_s: 0.0,
        to_s: run.time_s.last().copied().unwrap_or_default(),
        pixels: RESPONSE_PIXELS,
    };
    let curve = |value: &[f64]| {
        let thin = thinned(&run.time_s, value, &view);
        json!([thin.time_s, thin.value])
    };
    json!({
        "scenario": run.scenario,
        "about": run.about,
        "fell": run.fell,
        "angle_rad": curve(&run.angle_rad),
        "wheel_speed_rad_s": curve(&run.wheel_speed_rad_s),
        "current_a": curve(&run.current_a),
    })
}
