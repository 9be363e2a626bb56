//! The first lines of a report: the conclusion in plain words.

use workbench::numbers::significant;
use workbench::{ComparisonReport, FAILS_OVER_NOISE, ProofVerdict, Verdict};

use crate::html::{escaped, list, paragraph, put};
use crate::report_findings::ReportFindings;

/// The conclusion: the verdict, then model, data, controller and proof in a line each, and what to do next.
pub fn conclusion(page: &mut String, findings: &ReportFindings) {
    let sentence = findings.diagnosis.map_or(
        "No diagnosis was made: whether the model lacks an effect is not known.",
        |diagnosis| &diagnosis.sentence,
    );
    put(page, &format!("<p class=\"c\">{}</p>\n", escaped(sentence)));
    let lines = [
        model(findings.comparison),
        data(findings),
        controller(findings),
        proof(findings),
    ];
    list(page, lines.into_iter());
    let Some(diagnosis) = findings.diagnosis else {
        return;
    };
    if let Some(remains) = &diagnosis.remains {
        paragraph(page, &remains.sentence());
    }
    if !diagnosis.next_experiment.is_empty() {
        let next = format!("Next experiment: {}", diagnosis.next_experiment);
        paragraph(page, &next);
    }
    if let Some(recipe) = &diagnosis.recipe {
        list(page, recipe.steps.iter().cloned());
    }
    let added = diagnosis.added();
    let is_in = |effect: &String| findings.comparison.effects.contains(effect);
    if diagnosis.verdict != Verdict::NothingMissing && !added.iter().all(is_in) {
        let without = added.join(", ");
        paragraph(
            page,
            &format!("This report is about the model as it is, without {without}."),
        );
    }
}

fn model(found: &ComparisonReport) -> String {
    let over = found.rmse.iter().filter_map(|(series, rmse)| {
        let noise = found.sensor_noise.of(series)?;
        Some((series, rmse / noise))
    });
    let worst = over.max_by(|(_, a), (_, b)| a.total_cmp(b));
    match worst {
        Some((_, over)) if over <= FAILS_OVER_NOISE => format!(
            "Model: with {} effects it follows every log to within {} times the noise of its sensor.",
            found.effects.len(),
            significant(over, 2)
        ),
        Some((series, over)) => format!(
            "Model: with {} effects, its largest error is in {series}: {} times the noise of the sensor.",
            found.effects.len(),
            significant(over, 2)
        ),
        None => "Model: there is nothing to compare it with.".to_owned(),
    }
}

fn data(findings: &ReportFindings) -> String {
    match findings.session.findings().len() {
        0 => "Data: the check finds nothing wrong.".to_owned(),
        1 => "Data: one finding, below.".to_owned(),
        count => format!("Data: {count} findings, below."),
    }
}

fn controller(findings: &ReportFindings) -> String {
    match findings.session.design() {
        Err(error) => format!("Controller: none can be designed: {error}"),
        Ok(designed) => {
            let design = designed.design();
            format!(
                "Controller: its current can hold the body at rest up to {}° from upright, and it tolerates {} ms of delay beyond its sample time.",
                significant(design.recovery_angle_rad.to_degrees(), 3),
                significant(1e3 * design.margins.delay_margin_s, 3)
            )
        }
    }
}

fn proof(findings: &ReportFindings) -> String {
    match findings.proof {
        Err(reason) => format!("Proof: none: {reason}"),
        Ok(proof) => match proof.verdict() {
            ProofVerdict::Holds => {
                "Proof: every claim about the emitted controller is proved or tested.".to_owned()
            }
            ProofVerdict::Unsettled(ids) => {
                format!(
                    "Proof: no claim fails; not settled here: {}.",
                    ids.join(", ")
                )
            }
            ProofVerdict::Fails(ids) => {
                format!(
                    "Proof: the controller must not be used; these claims fail: {}.",
                    ids.join(", ")
                )
            }
        },
    }
}
