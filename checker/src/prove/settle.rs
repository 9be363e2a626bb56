//! The claims, in the order in which they are shown, each by its engines.

use std::time::Instant;

use crate::certificate::reader::Certificate;
use crate::claims::control_law::EmittedLaw;
use crate::claims::outcome::{
    COMPILED, ClaimOutcome, EXACT, INTERVALS, PYTHON, RANDOM, READER, SMT,
};
use crate::claims::{
    bias_observer_stable, certificate_consistent, closed_loop_agreement, closed_loop_for_all_time,
    closed_loop_second, closed_loop_stable, compiled_agrees, control_accurate,
    control_accurate_real_gains, control_monotone, control_total, encoder_exact,
    encoder_loop_stable, filter_accurate, filter_exact, filter_length, filter_total,
    hardware_words, loop_as_shipped, loop_from_rest, model_matches, monitor, physical_signs,
    primitives, region_of_attraction, source_understood, stable_for_parameters, step_total,
    supervisor, texts_audited,
};
use crate::domains::smt::{self, SolverAnswer};
use crate::language::emitted::Emitted;
use crate::language::module::Module;
use crate::prove::results::{ClaimResult, Table, complete};
use crate::prove::settings::ProofSettings;

/// Why the claims about the attitude filter do not apply.
const NO_FILTER: &str = "an encoder on the pivot shows the body: the module has no attitude filter";

/// Largest number of random words per function for the compiled crate; more show nothing new.
const MOST_COMPILED: usize = 2_000;

/// Decides every claim, by every engine except Kani. Every claim gets a row.
pub fn settle(
    emitted: &Emitted,
    certificate: &Certificate,
    settings: &ProofSettings,
) -> Vec<ClaimResult> {
    settle_saying(emitted, certificate, None, settings, &|_| ())
}

/// As [`settle`], compared with the text of the user's model.toml if one is given; `say` receives
/// progress messages.
pub fn settle_saying(
    emitted: &Emitted,
    certificate: &Certificate,
    model: Option<&str>,
    settings: &ProofSettings,
    say: &dyn Fn(&str),
) -> Vec<ClaimResult> {
    settle_telling(emitted, certificate, model, settings, say, &|_| ())
}

/// As [`settle_saying`]; `tell` is told every row as soon as it is settled.
pub fn settle_telling(
    emitted: &Emitted,
    certificate: &Certificate,
    model: Option<&str>,
    settings: &ProofSettings,
    say: &dyn Fn(&str),
    tell: &dyn Fn(&ClaimResult),
) -> Vec<ClaimResult> {
    let mut table = Table(Vec::new(), Some(tell));
    table.add("model-matches", READER, || match model {
        Some(text) => model_matches::by_reading(certificate, text),
        None => ClaimOutcome::NotApplicable(
            "no model was given: the numbers are those that the certificate states".to_owned(),
        ),
    });
    let start = Instant::now();
    let module = match emitted.module() {
        Ok(module) => module,
        Err(error) => {
            let outcome = ClaimOutcome::Failed(error.to_string());
            let seconds = start.elapsed().as_secs_f64();
            table.row("source-understood", READER, outcome, seconds);
            return complete(table.0, "the source is not understood");
        }
    };
    let understood = source_understood::by_reading(emitted, &module);
    let is_understood = matches!(understood, ClaimOutcome::Proved(_));
    let seconds = start.elapsed().as_secs_f64();
    table.row("source-understood", READER, understood, seconds);
    table.add("texts-audited", READER, || {
        if settings.audited_texts {
            texts_audited::by_digest(emitted)
        } else {
            ClaimOutcome::NotRun("switched off".to_owned())
        }
    });
    table.add("compiled-agrees", COMPILED, || {
        if !settings.compiled {
            return ClaimOutcome::NotRun("switched off".to_owned());
        }
        if !is_understood {
            return ClaimOutcome::NotRun("nothing is run that is not understood".to_owned());
        }
        say("compiling the crate, and running it beside the reader");
        let cases = (settings.cases / 10).clamp(1, MOST_COMPILED);
        compiled_agrees::by_running(emitted, &module, cases, settings.seed)
    });
    if !is_understood {
        // If the reader misunderstands the source, a proof says nothing about the program.
        return complete(table.0, "the source is not understood");
    }

    let start = Instant::now();
    let law = EmittedLaw::read(&module);
    let seconds = start.elapsed().as_secs_f64();
    let total = control_total::by_intervals(&law);
    table.row("control-total", INTERVALS, total, seconds);
    if settings.filter_ranges {
        say("ranges of the attitude filter");
        range_claims(&mut table, &module, certificate, settings);
    }
    say("random runs");
    random_runs(&mut table, emitted, &module, certificate, settings);
    let law = match law {
        Ok(law) => law,
        Err(_) => return complete(table.0, "it needs the control law, see control-total"),
    };
    control_claims(&mut table, &module, certificate, &law, settings);
    table.add("certificate-consistent", EXACT, || {
        let files = emitted.files();
        let checked = certificate_consistent::check(certificate, &module, &law, &files);
        ClaimOutcome::proved(checked.map(|()| "every field".to_owned()))
    });
    table.add("hardware-words", EXACT, || {
        let checked = hardware_words::check(certificate, &module, &law);
        ClaimOutcome::proved(checked.map(|()| "every word".to_owned()))
    });
    table.add("supervisor", EXACT, || {
        let checked = supervisor::check_words(certificate, &module, &law);
        ClaimOutcome::proved(checked.map(|()| "every word of LIMITS".to_owned()))
    });
    table.add("supervisor", RANDOM, || {
        let cases = (settings.cases / 3).max(1);
        ClaimOutcome::tested(supervisor::in_runs(&module, cases, settings.seed))
    });
    encoder_claims(&mut table, &module, certificate, settings);
    table.add("physical-signs", RANDOM, || {
        let checked = physical_signs::check(certificate, &module);
        // Six leans and four rates.
        ClaimOutcome::tested(checked.map(|()| 10))
    });
    monitor_claims(&mut table, &module, certificate, &law, settings);
    say("the closed loop");
    loop_claims(&mut table, emitted, &module, certificate, &law, settings);
    complete(table.0, "switched off")
}

fn control_claims(
    table: &mut Table,
    module: &Module,
    certificate: &Certificate,
    law: &EmittedLaw,
    settings: &ProofSettings,
) {
    table.add("control-accurate", INTERVALS, || {
        control_accurate::by_intervals(certificate, law)
    });
    table.add("control-accurate-real-gains", EXACT, || {
        control_accurate_real_gains::by_exact_arithmetic(certificate, law)
    });
    table.add("control-monotone", INTERVALS, || {
        control_monotone::by_directions(module, certificate)
    });
    table.add("control-accurate", RANDOM, || {
        let (cases, seed) = (settings.cases, settings.seed);
        let runs = control_accurate::by_random_runs(module, certificate, cases, seed);
        ClaimOutcome::tested(runs)
    });

    let Some(program) = module.function("control") else {
        return;
    };
    let is_available = settings.smt && smt::is_available();
    let mut ask = |id: &str, question: &dyn Fn() -> SolverAnswer| {
        table.add(id, SMT, || {
            if !is_available {
                let why = if settings.smt {
                    "z3 is not installed"
                } else {
                    "switched off"
                };
                return ClaimOutcome::NotRun(why.to_owned());
            }
            match question() {
                SolverAnswer::Proved => ClaimOutcome::Proved("no counterexample".to_owned()),
                SolverAnswer::Refuted(model) => {
                    ClaimOutcome::Failed(format!("counterexample: {model}"))
                }
                SolverAnswer::Unknown(why) => ClaimOutcome::NotRun(why),
            }
        });
    };
    let limit = match module.constant("control", "CURRENT_LIMIT") {
        Some([word]) => *word,
        _ => 0,
    };
    ask("control-total", &|| control_total::by_smt(program, limit));
    ask("control-accurate", &|| {
        control_accurate::by_smt(program, certificate)
    });
    ask("control-monotone", &|| {
        control_monotone::by_smt(program, certificate)
    });
}

/// The claims about the monitor, where the module has one.
fn monitor_claims(
    table: &mut Table,
    module: &Module,
    certificate: &Certificate,
    law: &EmittedLaw,
    settings: &ProofSettings,
) {
    let absent = || monitor::absent(module, certificate);
    table.add("monitor-total", INTERVALS, || {
        absent().unwrap_or_else(|| monitor::total_by_intervals(module))
    });
    table.add("monitor-silent", EXACT, || {
        absent().unwrap_or_else(|| monitor::silent_by_words(module, certificate, law))
    });
    table.add("monitor-silent", RANDOM, || {
        absent().unwrap_or_else(|| {
            let (cases, seed) = (settings.cases, settings.seed);
            ClaimOutcome::tested(monitor::runs::run(module, cases, seed))
        })
    });
}

/// Claim `encoder-exact`, where there is an encoder.
fn encoder_claims(
    table: &mut Table,
    module: &Module,
    certificate: &Certificate,
    settings: &ProofSettings,
) {
    if encoder_exact::words::encoders(certificate).next().is_none() {
        table.add("encoder-exact", EXACT, || {
            ClaimOutcome::NotApplicable("the module has no encoder".to_owned())
        });
        return;
    }
    table.add("encoder-exact", EXACT, || {
        let checked = encoder_exact::words::check(certificate, module);
        ClaimOutcome::proved(checked.map(|()| "every word".to_owned()))
    });
    table.add("encoder-exact", RANDOM, || {
        let (cases, seed) = (settings.cases, settings.seed);
        ClaimOutcome::tested(encoder_exact::runs::run(certificate, module, cases, seed))
    });
}

/// The claims about the filter that hold for every word.
fn range_claims(
    table: &mut Table,
    module: &Module,
    certificate: &Certificate,
    settings: &ProofSettings,
) {
    let start = Instant::now();
    let found = primitives::primitives(module);
    let contracts = primitives::proved(&found);
    let outcome = primitives::by_intervals(&found);
    let seconds = start.elapsed().as_secs_f64();
    table.row("primitives", INTERVALS, outcome, seconds);
    if certificate.hardware.body_encoder().is_some() {
        let without = || ClaimOutcome::NotApplicable(NO_FILTER.to_owned());
        table.add("filter-total", INTERVALS, without);
        table.add("filter-length", EXACT, without);
        table.add("step-total", INTERVALS, || {
            step_total::ranges::by_intervals(module, certificate, &contracts)
        });
        return;
    }
    table.add("filter-total", INTERVALS, || {
        let checked = filter_total::check(module, &contracts);
        ClaimOutcome::proved(checked.map(|()| "the invariant is kept".to_owned()))
    });
    if settings.filter_length {
        table.add("filter-length", EXACT, || {
            filter_length::check::by_exact_arithmetic(module, &contracts)
        });
    }
    table.add("step-total", INTERVALS, || {
        step_total::ranges::by_intervals(module, certificate, &contracts)
    });
}

fn random_runs(
    table: &mut Table,
    emitted: &Emitted,
    module: &Module,
    certificate: &Certificate,
    settings: &ProofSettings,
) {
    let (cases, seed) = ((settings.cases / 10).max(1), settings.seed);
    let has_filter = certificate.hardware.inertial().is_some();
    let without = || ClaimOutcome::NotApplicable(NO_FILTER.to_owned());
    table.add("filter-accurate", RANDOM, || {
        if !has_filter {
            return without();
        }
        ClaimOutcome::tested(filter_accurate::runs::run(module, cases, seed))
    });
    table.add("filter-exact", RANDOM, || {
        if !has_filter {
            return without();
        }
        match filter_exact::runs::run(module, cases, seed) {
            Ok(cases) => ClaimOutcome::Tested(cases, texts_audited::audit_of(emitted)),
            Err(why) => ClaimOutcome::Failed(why),
        }
    });
    table.add("step-total", RANDOM, || {
        let runs = step_total::step_in_runs(module, certificate, cases, seed);
        ClaimOutcome::tested(runs.and_then(|runs| {
            if !has_filter {
                return Ok(runs);
            }
            let more = step_total::runs::bias_observer(module, cases, seed)?;
            let parts = step_total::composition::composition(module, cases, seed)?;
            Ok(runs + more + parts)
        }))
    });
    table.add("primitives", RANDOM, || {
        ClaimOutcome::tested(primitives::by_random_runs(module, cases, seed))
    });
}

fn loop_claims(
    table: &mut Table,
    emitted: &Emitted,
    module: &Module,
    certificate: &Certificate,
    law: &EmittedLaw,
    settings: &ProofSettings,
) {
    table.add("closed-loop-stable", EXACT, || {
        let checked = closed_loop_stable::check_stable(certificate, law);
        ClaimOutcome::proved(
            checked
                .map(|()| "Hurwitz' criterion after a bilinear map of the unit circle".to_owned()),
        )
    });
    table.add("bias-observer-stable", EXACT, || {
        bias_observer_stable::by_exact_arithmetic(certificate, module, law)
    });
    table.add("encoder-loop-stable", EXACT, || {
        encoder_loop_stable::by_exact_arithmetic(certificate, law)
    });
    let mut bounds = None;
    let mut from_rest = None;
    table.add("closed-loop-for-all-time", EXACT, || {
        if !settings.closed_loop {
            return ClaimOutcome::NotRun("switched off".to_owned());
        }
        if loop_from_rest::applies(certificate) {
            let (for_all_time, region) = loop_from_rest::by_exact_arithmetic(certificate, law);
            from_rest = Some(region);
            return for_all_time;
        }
        let (outcome, found) = closed_loop_for_all_time::by_exact_arithmetic(certificate, law);
        bounds = found;
        outcome
    });
    let mut second_region = None;
    table.add("closed-loop-for-all-time", PYTHON, || {
        let from_rest = loop_from_rest::applies(certificate);
        if certificate.closed_loop.is_none() && !from_rest {
            ClaimOutcome::NotRun("the certificate states no bounds".to_owned())
        } else if !settings.python {
            ClaimOutcome::NotRun("switched off".to_owned())
        } else if from_rest {
            let (for_all_time, region) = closed_loop_second::from_rest_by_python(emitted);
            second_region = Some(region);
            for_all_time
        } else {
            closed_loop_second::by_python(emitted)
        }
    });
    table.add("closed-loop-agreement", EXACT, || {
        closed_loop_agreement::by_exact_arithmetic(certificate, emitted, module, law)
    });
    // From rest, one computation settles both.
    table.add("region-of-attraction", EXACT, || {
        if let Some(region) = from_rest {
            return region;
        }
        let found = region_of_attraction::by_exact_arithmetic(certificate, bounds.as_ref(), law);
        let has_window = certificate.hardware.wheel_speed.encoder.is_some();
        match found {
            ClaimOutcome::NotRun(_) if has_window && bounds.is_some() => {
                loop_from_rest::region(certificate, law)
            }
            found => found,
        }
    });
    table.add("region-of-attraction", PYTHON, || {
        second_region.unwrap_or_else(|| {
            let why = if settings.python {
                "it speaks of starts at rest, where an encoder has a window or an observer corrects the angle"
            } else {
                "switched off"
            };
            ClaimOutcome::NotRun(why.to_owned())
        })
    });
    let start = Instant::now();
    let (shipped, kept_up) = if settings.closed_loop {
        loop_as_shipped::by_exact_arithmetic(certificate, law)
    } else {
        let off = || ClaimOutcome::NotRun("switched off".to_owned());
        (off(), off())
    };
    let seconds = start.elapsed().as_secs_f64();
    table.row("loop-as-shipped", EXACT, shipped, seconds);
    let start = Instant::now();
    let second = if settings.python {
        closed_loop_second::as_shipped_by_python(emitted)
    } else {
        ClaimOutcome::NotRun("switched off".to_owned())
    };
    let seconds = start.elapsed().as_secs_f64();
    table.row("loop-as-shipped", PYTHON, second.clone(), seconds);
    // Both claims come out of one computation.
    table.row("motion-kept-up", EXACT, kept_up, 0.0);
    table.row("motion-kept-up", PYTHON, second, 0.0);
    table.add("stable-for-parameters", EXACT, || {
        stable_for_parameters::by_exact_arithmetic(certificate, law)
    });
}
