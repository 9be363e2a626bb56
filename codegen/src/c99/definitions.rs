//! Structures and enumerations of the header.

use std::collections::BTreeSet;

use super::items::Items;
use super::types::{ItemKey, Type, type_name};
use super::{comments, place};

/// A type and all types that it contains.
pub(super) fn collect(items: &Items, ty: &Type, found: &mut BTreeSet<ItemKey>) {
    match ty {
        Type::Array(element, _) => collect(items, element, found),
        Type::Tuple(parts) => {
            for part in parts {
                collect(items, part, found);
            }
        }
        Type::Struct(key) => {
            if found.insert(key.clone())
                && let Some(own) = items.structs.get(key)
            {
                for (_, ty, _) in &own.fields {
                    collect(items, ty, found);
                }
            }
        }
        Type::Enum(key) => {
            found.insert(key.clone());
        }
        _ => {}
    }
}

/// Declares structures and enumerations, each after the types that it contains.
pub(super) fn type_definitions(items: &Items, keys: &BTreeSet<ItemKey>) -> String {
    let mut text = String::new();
    let mut done: BTreeSet<ItemKey> = BTreeSet::new();
    let mut left: Vec<&ItemKey> = keys.iter().collect();
    while !left.is_empty() {
        let ready = |key: &&ItemKey| {
            let mut needed = BTreeSet::new();
            if let Some(own) = items.structs.get(*key) {
                for (_, ty, _) in &own.fields {
                    collect(items, ty, &mut needed);
                }
            }
            needed
                .iter()
                .all(|one| done.contains(one) || !keys.contains(one))
        };
        let (now, later): (Vec<&ItemKey>, Vec<&ItemKey>) = left.into_iter().partition(ready);
        if now.is_empty() {
            break;
        }
        for key in now {
            text.push_str(&type_definition(items, key));
            text.push('\n');
            done.insert(key.clone());
        }
        left = later;
    }
    text
}

fn type_definition(items: &Items, key: &ItemKey) -> String {
    let name = type_name(&key.1);
    if let Some(own) = items.enums.get(key) {
        let mut text = comments::before(&comments::lines(&own.attributes), "");
        text.push_str("typedef enum {\n");
        for (variant, value, attributes) in &own.variants {
            text.push_str(&comments::before(&comments::lines(attributes), "    "));
            text.push_str(&format!("    {} = {value},\n", place::enumerator(variant)));
        }
        // Not every compiler in its strictest mode accepts a comma before the end.
        let text = text.trim_end().trim_end_matches(',').to_string();
        return format!("{text}\n}} {name};\n");
    }
    let Some(own) = items.structs.get(key) else {
        return String::new();
    };
    let mut lines = comments::lines(&own.attributes);
    if !own.optional.is_empty() {
        lines.push(format!(
            "What the Rust module may be given besides, and does not use, is left out: {}.",
            own.optional.join(", ")
        ));
    }
    let mut text = comments::before(&lines, "");
    text.push_str("typedef struct {\n");
    for (field, ty, attributes) in &own.fields {
        text.push_str(&comments::before(&comments::lines(attributes), "    "));
        text.push_str(&format!("    {};\n", ty.declare(field)));
    }
    format!("{text}}} {name};\n")
}
