//! The parts of the guide that are made from the program.
//!
//! They stand between `<!-- generated: NAME -->` and `<!-- end -->`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use bench_files::keys::{self, KeySection};
use workbench::{EffectDescription, FindingId, effect_confusions, effect_library, effect_portrait};

use super::{pages, root, text};

/// Whether the files are to be written instead of compared.
fn is_writing() -> bool {
    std::env::var_os("FLYWHEEL_WRITE_GUIDE").is_some()
}

#[test]
fn generated_parts_are_what_the_program_says() {
    let mut seen = vec![];
    for page in pages() {
        let old = text(&page);
        let mut new = String::new();
        let mut rest = old.as_str();
        while let Some(at) = rest.find("<!-- generated: ") {
            let after = &rest[at + "<!-- generated: ".len()..];
            let (name, body) = after.split_once(" -->\n").expect("the marker ends");
            let end = body.find("<!-- end -->").expect("the part ends");
            new.push_str(&rest[..at]);
            let _ = write!(new, "<!-- generated: {name} -->\n{}", part(name));
            seen.push(name.to_owned());
            rest = &body[end..];
        }
        new.push_str(rest);
        if is_writing() {
            fs::write(&page, &new).expect("the page is written");
        } else if let Some((line, (a, b))) = old
            .lines()
            .zip(new.lines())
            .enumerate()
            .find(|(_, (a, b))| a != b)
        {
            panic!(
                "{}, line {}: the guide says\n  {a}\nand the program\n  {b}\n(FLYWHEEL_WRITE_GUIDE=1 writes it)",
                page.display(),
                line + 1
            );
        } else {
            assert_eq!(old, new, "{}", page.display());
        }
    }
    for name in PARTS {
        assert!(seen.iter().any(|one| one == name), "no page has {name}");
    }
}

const PARTS: [&str; 7] = [
    "keys of bench.toml",
    "keys of model.toml",
    "keys of an own effect",
    "known parts",
    "commands",
    "effects",
    "findings",
];

fn part(name: &str) -> String {
    match name {
        "keys of bench.toml" => sections(keys::BENCH),
        "keys of model.toml" => sections(keys::MODEL),
        "keys of an own effect" => sections(keys::OWN_EFFECT),
        "known parts" => parts(),
        "commands" => commands(),
        "effects" => effects(),
        "findings" => findings(),
        _ => panic!("nothing makes \"{name}\""),
    }
}

/// A cell of a table: a bar would end it.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn sections(list: &[KeySection]) -> String {
    let mut out = String::new();
    for section in list {
        let _ = write!(
            out,
            "\n### `{}`\n\n{}\n\n| key | unit | where it is left out | example | meaning |\n|---|---|---|---|---|\n",
            section.heading, section.meaning
        );
        for key in section.keys {
            let _ = writeln!(
                out,
                "| `{}` | {} | {} | `{}` | {} |",
                key.name,
                cell(key.unit),
                cell(key.default),
                cell(key.example),
                cell(key.meaning)
            );
        }
    }
    out + "\n"
}

fn parts() -> String {
    let mut out =
        "\n| part | as | setting that the numbers hold for | source |\n|---|---|---|---|\n"
            .to_owned();
    for part in bench_files::known_parts() {
        let _ = writeln!(
            out,
            "| `{}` | {} | {} | {} |",
            part.name,
            part.role_name(),
            cell(part.setting),
            cell(part.source)
        );
    }
    out + "\n"
}

/// The help text of a command.
fn help(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_flywheel"))
        .args(arguments)
        .arg("--help")
        .env("COLUMNS", "100")
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "flywheel {arguments:?} --help");
    String::from_utf8_lossy(&output.stdout)
        .trim_end()
        .to_owned()
}

fn commands() -> String {
    let all = help(&[]);
    let names: Vec<&str> = all
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect();
    assert!(names.len() > 10, "{all}");
    let mut out = String::new();
    for name in names {
        let _ = write!(out, "\n## {name}\n\n```text\n{}\n```\n", help(&[name]));
    }
    out + "\n"
}

fn findings() -> String {
    let mut out = "\n| finding | meaning, and what mends it |\n|---|---|\n".to_owned();
    for finding in FindingId::ALL {
        let _ = writeln!(
            out,
            "| `{}` | {} |",
            finding.name(),
            cell(finding.meaning())
        );
    }
    out + "\n"
}

fn effects() -> String {
    let library = effect_library();
    let mut out = String::new();
    for role in ["body", "wheel", "motor", "sensor"] {
        let heading = match role {
            "body" => "Torques on the body",
            "wheel" => "Torques on the wheel",
            "motor" => "Between command and torque",
            _ => "What sensors make of the motion",
        };
        let _ = write!(out, "\n## {heading}\n");
        for effect in library.iter().filter(|effect| effect.role == role) {
            out.push_str(&whole(effect));
        }
    }
    out + "\n"
}

fn whole(effect: &EffectDescription) -> String {
    let names = |list: &[String]| -> String {
        let names: Vec<String> = list.iter().map(|name| format!("`{name}`")).collect();
        names.join(", ")
    };
    let mut out = format!(
        "\n### {}\n\nCause: {}.\n\nEquation: {}\n\nWhat to look for: {}. Experiments that show the effect: {}.\n\n",
        effect.name,
        effect.meaning,
        effect.equation,
        effect.fingerprint,
        effect.shows_in.join(", ")
    );
    for parameter in &effect.parameters {
        let unit = match parameter.unit.as_str() {
            "1" => "no unit",
            unit => unit,
        };
        let _ = writeln!(
            out,
            "- `{}` ({unit}): {}",
            parameter.name, parameter.meaning
        );
    }
    out.push('\n');
    if !effect.replaces.is_empty() {
        let _ = write!(
            out,
            "This effect contains and replaces {}.\n\n",
            names(&effect.replaces)
        );
    }
    let confusions = effect_confusions(&effect.name);
    for confusion in &confusions {
        let apart = match &confusion.told_apart_by {
            Some(experiment) => format!("Told apart by {experiment}."),
            None => "None of the usual experiments tells them apart.".to_owned(),
        };
        let _ = write!(
            out,
            "Easily taken for `{}` in {}. {apart}\n\n",
            confusion.with, confusion.alike_in
        );
    }
    for name in &effect.confused_with {
        if confusions.iter().all(|one| one.with != *name) {
            let _ = write!(out, "Easily taken for `{name}`.\n\n");
        }
    }
    let _ = write!(out, "Source: {}.\n\n", effect.source.trim_end_matches('.'));
    if let Some(portrait) = effect_portrait(&effect.name) {
        let _ = writeln!(
            out,
            "![{} in {}](effects/{}.svg)",
            effect.name, portrait.experiment, effect.name
        );
    }
    out
}

/// The numbers of a picture, and the text between them.
fn numbers(text: &str) -> (Vec<f64>, String) {
    let mut found = vec![];
    let mut between = String::new();
    let mut number = String::new();
    for c in text.chars().chain([' ']) {
        if c.is_ascii_digit() || c == '.' || (c == '-' && number.is_empty()) {
            number.push(c);
            continue;
        }
        if !number.is_empty() {
            match number.parse() {
                Ok(value) => found.push(value),
                Err(_) => between.push_str(&number),
            }
            number.clear();
        }
        between.push(c);
    }
    (found, between)
}

/// The pictures of the effects are those that the model draws: another machine's mathematics may move a point by
/// a tenth of a pixel.
#[test]
fn pictures_of_effects_are_of_this_model() {
    let folder = root().join("docs/guide/effects");
    for effect in effect_library() {
        let Some(portrait) = effect_portrait(&effect.name) else {
            continue;
        };
        let drawing = portrait.drawing().expect("a picture");
        let file = folder.join(&drawing.name);
        if is_writing() {
            fs::create_dir_all(&folder).expect("a folder");
            fs::write(&file, &drawing.text).expect("the picture is written");
            continue;
        }
        compare(&file, &drawing.text);
    }
}

fn compare(file: &Path, drawn: &str) {
    let (old, new) = (numbers(&text(file)), numbers(drawn));
    let same = old.1 == new.1
        && old.0.len() == new.0.len()
        && old.0.iter().zip(&new.0).all(|(a, b)| (a - b).abs() <= 0.11);
    assert!(
        same,
        "{} is not what the model draws (FLYWHEEL_WRITE_GUIDE=1 writes it)",
        file.display()
    );
}
