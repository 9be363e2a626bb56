//! The header: constants, types and functions that a firmware uses, with the units of their words.

use std::collections::{BTreeMap, BTreeSet};

use super::comments;
use super::definitions::type_definitions;
use super::items::{Function, FunctionKey, Items, Translated};
use super::names::{PUBLIC, PUBLIC_CONSTANTS};
use super::types::{ItemKey, snake};

/// The words of the law, in the order in which the header states them.
const WORDS: [&str; 4] = ["Angle", "Rate", "WheelSpeed", "Current"];

/// The text of the header.
pub(super) fn header(
    items: &Items,
    title: &str,
    functions: &BTreeMap<FunctionKey, Translated>,
    constants: &BTreeMap<ItemKey, String>,
    types: &BTreeSet<ItemKey>,
) -> String {
    let mut text = format!(
        "/* {title} */\n\
         #ifndef FLYWHEEL_H\n#define FLYWHEEL_H\n\n#include <stdint.h>\n\n\
         /* Fixed-point controller of a reaction-wheel pendulum: raw sensor counts in, duty of the timer out.\n \
         *\n \
         *     flywheel_init(&controller);\n \
         *     every FLYWHEEL_SAMPLE_TIME_US:\n \
         *         duty = flywheel_step(&controller, &sample);\n \
         *     when the user wants it: flywheel_arm(&controller); (also after a trip)\n \
         *\n \
         * flywheel_loop.h has a loop around it that `flywheel record` commands and records.\n \
         *\n \
         * Words are whole numbers; each stands for its value times a power of two that is stated where it is\n \
         * used. Booleans are 0 and 1. No function keeps anything but what it is given, and none fails.\n \
         */\n\n\
         #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n"
    );
    text.push_str(&public_constants(items, constants, false));
    for name in WORDS {
        let key = ("control".to_string(), name.to_string());
        if let (Some(bits), Some((_, attributes))) =
            (items.fraction_bits.get(&key), items.words.get(&key))
        {
            let meaning = comments::lines(attributes).join(" ");
            text.push_str(&format!(
                "/* {meaning}\n * A word of it is in units of 2^-{bits} {}. */\n#define {} {bits}u\n\n",
                unit(&meaning),
                bits_name(name)
            ));
        }
    }
    text.push_str(&type_definitions(items, types));
    text.push_str(&public_constants(items, constants, true));
    for (module, owner, name, _) in PUBLIC {
        let key = (
            module.to_string(),
            owner.map(str::to_string),
            name.to_string(),
        );
        if let (Some(translated), Some(function)) = (functions.get(&key), items.functions.get(&key))
        {
            let mut lines = comments::lines(&function.attributes);
            lines.extend(units(items, function));
            text.push_str(&comments::before(&lines, ""));
            text.push_str(&format!("{};\n\n", translated.prototype));
        }
    }
    text + "#ifdef __cplusplus\n}\n#endif\n\n#endif\n"
}

/// The public constants: numbers, or tables, which refer to the types of the header.
fn public_constants(
    items: &Items,
    constants: &BTreeMap<ItemKey, String>,
    are_tables: bool,
) -> String {
    let mut text = String::new();
    for (module, name) in PUBLIC_CONSTANTS {
        let key = (module.to_string(), name.to_string());
        let own = items.constants.get(&key);
        let is_wanted = own.is_some_and(|own| own.ty.is_aggregate() == are_tables);
        if let (Some(constant), true) = (constants.get(&key), is_wanted) {
            text.push_str(constant);
            text.push('\n');
        }
    }
    text
}

/// The units of a function's words, a line each.
fn units(items: &Items, function: &Function) -> Vec<String> {
    let words = function.words.iter();
    let line = |(name, key): &(String, ItemKey)| {
        let (bits, (_, attributes)) = (items.fraction_bits.get(key)?, items.words.get(key)?);
        let unit = unit(&comments::lines(attributes).join(" "));
        Some(format!("{name}: in units of 2^-{bits} {unit}"))
    };
    words.filter_map(line).collect()
}

/// The unit that the documentation of a word has in brackets.
fn unit(meaning: &str) -> String {
    let open = meaning.split_once('(');
    let unit = open.and_then(|(_, rest)| rest.split_once(')'));
    unit.map_or(String::new(), |(unit, _)| unit.to_string())
}

/// The name of the constant with the fraction bits of a word.
fn bits_name(word: &str) -> String {
    format!("FLYWHEEL_{}_FRACTION_BITS", snake(word).to_uppercase())
}
