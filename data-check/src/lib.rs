//! Checks of the data of a bench, before anything is fitted: columns are compared with each
//! other, with the kind of their experiment, and with what pendulums, wheels and motors can do.
//!
//! ```
//! let files: bench_files::FilesInMemory = demo::FILES.into_iter().collect();
//! let bench = bench_files::Bench::from_files(&files).expect("a good bench");
//! assert_eq!(data_check::check(&bench), []);
//! ```
//!
//! | module | what it compares |
//! |---|---|
//! | `kinematics` | the rate with the derivative of the angle; columns with each other |
//! | `swing`, `by_itself` | a free swing with a pendulum: period, amplitude; standstill, energy |
//! | `wheel` | the wheel with its current, with other logs, with what motors can do |
//! | `spin_ups` | the spin-ups with each other, and all of them with what a bench can be |
//! | `momentum`, `body` | a body that is free with gravity, wheel and current |
//! | `spin_up_measure` | a free wheel with the wheel of the spin-ups |
//! | `standstill`, `jumps` | a channel that stands still beside one that moves; jumps that no motion makes |
//! | `current_sensor` | a current that ends at its sensor's limit |
//! | `sawtooth` | a channel that starts again from the other end of its range |
//! | `units` | units that nothing states |
//! | `law` | the current of a balance log with the stated gains |
//! | `held` | joints that the experiment holds still |
//! | `propose` | (for files without a bench.toml) proposes columns, units, signs, kinds and windows |
//! | `constant` | channels that never change |
//! | `channels`, `copies`, `known` | each channel and the time stamps; logs with each other; `[known]` |
//! | `signs` | one cause for several contradictions of signs in one log |
//! | `lost` | samples that are missing between even times |
//! | `coast` | a wheel that gains speed without a current |
//! | `stated` | cures with what bench.toml says already |
//! | `thresholds` | every number that decides a finding, with its derivation |
//!
//! A finding refuses the data only if they would give a wrong model and have no other explanation: a factor
//! that is the known ratio of two units, or a sign. `accept` at the experiment turns a refusal into a warning, and
//! removes a warning.

#![warn(missing_docs)]

mod body;
mod by_itself;
mod channels;
mod coast;
mod constant;
mod copies;
mod current_sensor;
mod finding;
mod held;
mod jumps;
mod kinematics;
mod known;
mod law;
mod lost;
mod momentum;
mod propose;
mod regression;
mod sawtooth;
mod signs;
mod slips;
mod spin_up_measure;
mod spin_ups;
mod standstill;
mod stated;
mod swing;
mod thresholds;
mod units;
mod view;
mod wheel;

use bench_files::Bench;
use parallel::parallel_map;
use plant::Kind;

pub use finding::{Finding, FindingId, Severity};
pub use propose::{
    Choices, ColumnChoice, Corrections, Proposal, ProposedExperiment, propose, propose_with,
    units_of,
};

use units::Settled;
use view::{Facts, View};

/// All findings for the data of a bench: refusals first, then in the order of its experiments.
pub fn check(bench: &Bench) -> Vec<Finding> {
    // The experiments are checked side by side; the findings keep the order of the experiments.
    let views: Vec<View> = parallel_map(&bench.experiments, View::new);
    let mut found = vec![];
    known::check(bench, &mut found);
    // What is out of scale is no measure for anything else.
    let mut facts = match found.iter().any(is_refusal) {
        true => Facts::default(),
        false => Facts::of(bench, &views),
    };
    found.extend(
        parallel_map(&views, |view| {
            let mut of_view = vec![];
            if !constant::check(view, &mut of_view) {
                channels::check(view, &mut of_view);
                standstill::check(view, &mut of_view);
                jumps::check(view, &mut of_view);
                lost::check(view, &mut of_view);
                current_sensor::check(view, &mut of_view);
                coast::check(view, &mut of_view);
            }
            held::check(view, &mut of_view);
            of_view
        })
        .into_iter()
        .flatten(),
    );
    let is_wrapped = |view: &View| {
        let mut of_view = found.iter().filter(|finding| is_about(finding, view));
        of_view.any(|finding| finding.finding == FindingId::Wrapped && is_refusal(finding))
    };
    let sound: Vec<&View> = views.iter().filter(|view| !is_wrapped(view)).collect();
    let answers = wheel::answers(&sound);
    let mut of_wheel = vec![];
    wheel::check(bench, &sound, &answers, &facts, &mut of_wheel);
    if of_wheel.is_empty() {
        facts.wheel_share = spin_up_measure::wheel_share(bench, &answers, &facts);
        spin_up_measure::current(&answers, &facts, &mut of_wheel);
        spin_up_measure::free_wheel(bench, &views, &answers, &facts, &mut of_wheel);
    }
    let mut settled = Settled::default();
    if of_wheel.is_empty() && bench.known.wheel_inertia.is_some() {
        spin_up_measure::settle(&answers, &facts, &mut settled);
    }
    // What is settled is settled for one experiment, so that the order of the experiments does not matter.
    let of_motion: Vec<(Vec<Finding>, Settled)> = parallel_map(&views, |view| {
        let (mut of_view, mut settled) = (vec![], settled.clone());
        if !kinematics::columns(view, &mut of_view) {
            swing::check(view, &mut settled, &mut of_view);
            if view.kind() == Kind::FreeSwing {
                by_itself::check(view, &mut of_view);
            }
            momentum::check(view, &facts, &mut settled, &mut of_view);
            kinematics::check(view, &mut settled, &mut of_view);
            law::check(bench, view, &mut settled, &mut of_view);
        }
        (of_view, settled)
    });
    for (of_view, of_settled) in of_motion {
        found.extend(of_view);
        settled.join(of_settled);
    }
    found.append(&mut of_wheel);
    for view in &views {
        signs::one_cause(bench, view, &answers, &mut found);
    }
    for view in &views {
        units::check(view, &settled, &mut found);
    }
    copies::check(&views, &mut found);
    stated::mend(&views, &mut found);
    let mut found = accepted(bench, found);
    let place = |finding: &Finding| views.iter().position(|view| is_about(finding, view));
    found.sort_by_key(|finding| (finding.severity, place(finding)));
    found
}

fn is_refusal(finding: &Finding) -> bool {
    finding.severity == Severity::Refuse
}

fn is_about(finding: &Finding, view: &View) -> bool {
    finding.experiment.as_deref() == Some(view.name())
}

/// The findings that remain after those that the experiments accept. A finding that concerns the whole bench is
/// accepted if any experiment accepts it.
fn accepted(bench: &Bench, found: Vec<Finding>) -> Vec<Finding> {
    let names = FindingId::ALL.map(FindingId::name);
    let mut left: Vec<Finding> = found
        .into_iter()
        .filter_map(|finding| {
            let accepts = bench.experiments.iter().any(|experiment| {
                let concerned = match &finding.experiment {
                    Some(name) => *name == experiment.name,
                    None => true,
                };
                let mut accepted = experiment.accept.iter();
                concerned && accepted.any(|name| name == finding.finding.name())
            });
            match (accepts, finding.severity) {
                (false, _) => Some(finding),
                (true, Severity::Warn) => None,
                (true, Severity::Refuse) => Some(Finding {
                    severity: Severity::Warn,
                    sentence: format!("{} (accepted)", finding.sentence),
                    ..finding
                }),
            }
        })
        .collect();
    for experiment in &bench.experiments {
        for name in &experiment.accept {
            if names.contains(&name.as_str()) {
                continue;
            }
            let nearest = names
                .iter()
                .min_by_key(|known| strsim::damerau_levenshtein(known, name));
            let advice = nearest.map_or(String::new(), |known| format!("accept = [\"{known}\"]"));
            left.push(
                Finding::refusal(
                    FindingId::UnknownFinding,
                    format!(
                        "accept contains \"{name}\", which is not a finding; the findings are {}",
                        names.join(", ")
                    ),
                )
                .in_experiment(&experiment.name)
                .with_fix(advice),
            );
        }
    }
    left
}
