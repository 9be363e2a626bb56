//! The library of effects in words.

use workbench::{EffectConfusion, EffectDescription};

use crate::report::table::{Align, Table};

/// One line for each effect, grouped by the part on which it acts.
pub fn list(library: &[EffectDescription]) -> String {
    let mut text = String::new();
    for role in ["body", "wheel", "motor", "sensor"] {
        let mut table = Table::without_head(&[Align::Left, Align::Left]);
        for effect in library.iter().filter(|effect| effect.role == role) {
            table.row([effect.name.as_str(), effect.meaning.as_str()]);
        }
        text.push_str(&format!("On the {role}\n{}\n", table.text()));
    }
    text.push_str(
        "Learned from the logs by flywheel add --learned COORDINATE: a smooth torque that follows \
         the\nmissing torque and explains nothing\n  \
         learned-angle, learned-rate              on the body\n  \
         learned-wheel-speed, learned-wheel-angle  on the wheel\n\n",
    );
    text + "flywheel effects NAME explains one; flywheel add NAME --bench BENCH puts it into a model.\n"
}

/// The whole description of one effect.
pub fn whole(effect: &EffectDescription, confusions: &[EffectConfusion]) -> String {
    let mut text = format!(
        "{}: {}\n\nEquation ({})\n  {}\n  from {}\n\nWhat to look for\n  {}\n  experiments that show it: {}\n",
        effect.name,
        effect.meaning,
        acts(&effect.role),
        effect.equation,
        effect.source,
        effect.fingerprint,
        effect.shows_in.join(", "),
    );
    let mut table = Table::new(&[
        ("parameter", Align::Left),
        ("unit", Align::Left),
        ("meaning", Align::Left),
    ]);
    for parameter in &effect.parameters {
        table.row([
            parameter.name.as_str(),
            parameter.unit.as_str(),
            parameter.meaning.as_str(),
        ]);
    }
    if !table.is_empty() {
        text.push_str(&format!("\nParameters\n{}", table.text()));
    }
    if !effect.replaces.is_empty() {
        let contained = effect.replaces.join(", ");
        text.push_str(&format!("\nIt contains and replaces {contained}.\n"));
    }
    if !effect.confused_with.is_empty() {
        text.push_str("\nWhat it is confused with\n");
    }
    for one in confusions {
        let (with, alike, apart) = (&one.with, &one.alike_in, apart(one));
        text.push_str(&format!("  {with}, in {alike};\n    {apart}\n"));
    }
    for name in &effect.confused_with {
        if confusions.iter().all(|one| one.with != *name) {
            text.push_str(&format!("  {name}\n"));
        }
    }
    text
}

/// The experiment that tells an effect from another one.
fn apart(confusion: &EffectConfusion) -> String {
    match &confusion.told_apart_by {
        Some(experiment) => format!("told apart by {experiment}"),
        None => "none of the usual experiments tells the two apart".to_owned(),
    }
}

fn acts(role: &str) -> &'static str {
    match role {
        "body" => "a torque on the body, against its motion",
        "wheel" => "a torque on the wheel, against its motion",
        "motor" => "a stage between command and torque",
        _ => "a property of a sensor",
    }
}
