//! The bench as one HTML file that needs neither a server nor a network: first the conclusion in words, then its
//! evidence.

use workbench::numbers::{fit_percent, significant, with_prefix, with_uncertainty};
use workbench::{
    ComparisonReport, DiagnosisReport, Error, ExpectationSettings, NamedLoop, Progress, Proof,
    ProofSettings, Session, loop_drawings, words,
};

use crate::html::{escaped, figures, list, paragraph, put, section, table};
use crate::report_conclusion;
use crate::report_findings::ReportFindings;

/// Figures of the model beside the measurements, at most.
const MOST_FIGURES: usize = 12;

/// The report of a bench; diagnosis, design and proof are computed for it. If the bench has no model,
/// the base model is fitted and becomes the session's model.
///
/// # Errors
/// Those of [`Session::compare`] and [`Session::diagnose`].
pub fn report_of(session: &mut Session, progress: &Progress) -> Result<String, Error> {
    let comparison = match session.model() {
        Some(_) => session.compare(progress)?,
        None => session.identify_base(progress)?,
    };
    let diagnosis = session.diagnose(progress)?;
    let controller = session
        .design()
        .and_then(|designed| designed.generate(None));
    let settings = ProofSettings {
        // Kani takes minutes, which is too long for a report.
        kani: false,
        ..Default::default()
    };
    let proof = match controller {
        Ok(controller) => Ok(controller.prove(&settings, progress)?),
        Err(error) => Err(format!("no controller is emitted: {error}")),
    };
    report(&ReportFindings {
        session,
        comparison: &comparison,
        diagnosis: Some(&diagnosis),
        proof: proof.as_ref().map_err(String::as_str),
    })
}

/// The report from existing results.
///
/// # Errors
/// [`Error::Figure`] if a figure cannot be drawn.
pub fn report(findings: &ReportFindings) -> Result<String, Error> {
    let found = findings.comparison;
    let mut page = String::new();
    head(&mut page, &found.bench);
    report_conclusion::conclusion(&mut page, findings);
    parameters(&mut page, found);
    wrong_with_data(&mut page, findings);
    data(&mut page, found);
    errors(&mut page, findings);
    diagnosis(&mut page, findings.diagnosis)?;
    section(&mut page, "Where the model fails");
    places(&mut page, found);
    figures(&mut page, found.drawings()?.iter().take(MOST_FIGURES));
    design(&mut page, findings.session)?;
    proof(&mut page, findings.proof);
    page.push_str("</main></body></html>\n");
    Ok(page)
}

const STYLE: &str = "\
:root{color-scheme:light}body{font:16px/1.5 system-ui,sans-serif;color:#1b2230;background:#fff;margin:0}\
main{max-width:980px;margin:0 auto;padding:1rem}h1{font-size:1.5rem}h2{font-size:1.15rem;margin-top:2rem;\
border-bottom:1px solid #d5d9e0}table{border-collapse:collapse;font-size:.9rem;display:block;overflow-x:auto}\
th,td{padding:.2rem .6rem;border-bottom:1px solid #d5d9e0;text-align:right}th:first-child,td:first-child,.l{\
text-align:left}.c{font-size:1.1rem;border-left:4px solid #1f5fbf;padding-left:.7rem}img{max-width:100%;height:auto}\
@media print{h2{break-after:avoid}img,table{break-inside:avoid}}";

fn head(page: &mut String, bench: &str) {
    let bench = escaped(bench);
    page.push_str("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">");
    page.push_str("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">");
    put(
        page,
        &format!(
            "<title>{bench}</title><style>{STYLE}</style></head>\n<body><main><h1>{bench}</h1>\n"
        ),
    );
}

fn parameters(page: &mut String, found: &ComparisonReport) {
    section(page, "Parameters");
    paragraph(
        page,
        &format!("The model has {}.", found.effects.join(", ")),
    );
    let rows = found.parameters.iter().map(|parameter| {
        vec![
            parameter.name.clone(),
            with_uncertainty(parameter.value, parameter.std),
            parameter.unit.clone(),
            parameter.source.clone(),
        ]
    });
    table(
        page,
        &["parameter", "value ± standard error", "unit", "from"],
        rows,
    );
}

fn wrong_with_data(page: &mut String, findings: &ReportFindings) {
    section(page, "What was wrong with the data");
    let found = findings.session.findings();
    if found.is_empty() {
        paragraph(page, "Nothing that the check of the data looks for.");
    }
    list(
        page,
        found.iter().map(|one| {
            let experiment = one.experiment.as_ref();
            let place = experiment.map_or(String::new(), |name| format!("{name}: "));
            format!("{place}{} {}", one.sentence, one.fix)
        }),
    );
}

fn data(page: &mut String, found: &ComparisonReport) {
    section(page, "Measurements");
    let rows = found.experiments.iter().map(|one| {
        vec![
            one.name.clone(),
            one.kind.clone(),
            one.samples.to_string(),
            format!("{} s", significant(one.duration_s, 3)),
            one.channels.join(", "),
        ]
    });
    table(
        page,
        &["experiment", "kind", "samples", "duration", "channels"],
        rows,
    );
    let notes = found.notes.iter().map(|note| match &note.experiment {
        Some(experiment) => format!("{experiment}: {}", note.note),
        None => note.note.clone(),
    });
    list(page, notes.chain(found.statements.iter().cloned()));
}

/// The errors: of the base model, of this model, and the sensor's noise.
fn errors(page: &mut String, findings: &ReportFindings) {
    section(page, "Model against measurement");
    let found = findings.comparison;
    let mut session = findings.session.clone();
    let base = session.identify_base(&Progress::silent()).ok();
    let base = base.filter(|base| base.effects != found.effects);
    let mut heads = vec!["experiment", "channel"];
    heads.extend(base.iter().map(|_| "RMSE of the base model"));
    heads.extend(["RMSE", "sensor noise", "fit"]);
    let rows = found.rmse.iter().map(|(series, rmse)| {
        let unit = series.channel.unit();
        let size =
            |value: Option<f64>| value.map_or("–".to_owned(), |value| with_prefix(value, unit));
        let mut row = vec![
            series.experiment.clone(),
            words::spoken(series.channel.name()).to_owned(),
        ];
        row.extend(base.iter().map(|base| size(base.rmse.of(series))));
        row.push(size(Some(*rmse)));
        row.push(size(found.sensor_noise.of(series)));
        row.push(fit_percent(
            found.fit_percent.of(series).unwrap_or(f64::NAN),
        ));
        row
    });
    table(page, &heads, rows);
}

fn diagnosis(page: &mut String, diagnosis: Option<&DiagnosisReport>) -> Result<(), Error> {
    let Some(report) = diagnosis else {
        return Ok(());
    };
    section(page, "What could be missing");
    let rows = report.suspects.iter().take(8).map(|suspect| {
        vec![
            suspect.effect.clone(),
            format!("{:.0} %", 100.0 * suspect.probability),
            suspect.fingerprint.clone(),
        ]
    });
    table(page, &["effect", "probability", "what speaks for it"], rows);
    figures(
        page,
        report
            .drawings()?
            .iter()
            .filter(|file| !file.name.starts_with("compare-")),
    );
    Ok(())
}

fn places(page: &mut String, found: &ComparisonReport) {
    let places = found
        .places
        .iter()
        .filter(|place| place.significant)
        .take(8);
    let rows: Vec<Vec<String>> = places
        .map(|place| {
            vec![
                place.experiment.clone(),
                place.channel.clone(),
                words::residual(place.residual).to_owned(),
                words::place(place),
                format!("{} %", significant(100.0 * place.share_of_error, 2)),
            ]
        })
        .collect();
    if rows.is_empty() {
        paragraph(page, "Nowhere beyond noise.");
    } else {
        table(
            page,
            &[
                "experiment",
                "channel",
                "seen in",
                "where",
                "share of the error",
            ],
            rows.into_iter(),
        );
    }
}

fn design(page: &mut String, session: &Session) -> Result<(), Error> {
    section(page, "Controller");
    let designed = match session.design() {
        Ok(designed) => designed,
        Err(error) => {
            paragraph(
                page,
                &format!("No controller can be designed from this model: {error}"),
            );
            return Ok(());
        }
    };
    let report = designed.report()?;
    paragraph(
        page,
        &format!(
            "u = −K x every {} s, K = ({}) A/rad, A s/rad, A s/rad, at most ±{} A; that current can hold the body at rest up to {}° from upright.",
            significant(report.sample_time_s, 4),
            report.gains.map(|gain| significant(gain, 6)).join(", "),
            significant(report.current_limit_a, 4),
            significant(report.recovery_angle_rad.to_degrees(), 3)
        ),
    );
    let settings = ExpectationSettings {
        noise: session.sensor_noise(),
        ..Default::default()
    };
    let found = designed.expectations(&settings)?;
    let lines = crate::design_facts::numbers(&report, &found).into_iter();
    table(
        page,
        &["of the loop", "value"],
        lines.map(|(name, value)| vec![name.to_owned(), value]),
    );
    figures(page, report.drawings()?.iter());
    let own = NamedLoop {
        name: designed.name(),
        report: &report,
        expectations: &found,
    };
    figures(page, loop_drawings("", &[own])?.iter());
    Ok(())
}

fn proof(page: &mut String, proof: Result<&Proof, &str>) {
    section(page, "What is proved of the emitted controller");
    let proof = match proof {
        Ok(proof) => proof,
        Err(reason) => {
            paragraph(page, &format!("Nothing: {reason}"));
            return;
        }
    };
    paragraph(
        page,
        "Each row is a promise of the certificate that comes with the emitted source, for all inputs of its second \
         column. \"Proved\" means that no input breaks it; \"tested\" that none of the runs did.",
    );
    paragraph(
        page,
        if proof.passed() {
            "No claim fails."
        } else {
            "A claim fails: this controller must not be used."
        },
    );
    let rows = proof.claims.iter().map(|claim| {
        vec![
            claim.statement.clone(),
            claim.domain.clone(),
            claim.engine.to_owned(),
            claim.outcome.word().to_owned(),
        ]
    });
    table(page, &["claim", "for which inputs", "by", "result"], rows);
}
