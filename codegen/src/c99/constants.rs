//! Constants and their initialisers.

use super::Result;
use super::comments;
use super::items::Items;
use super::scope::{Needs, Scope};
use super::types::ItemKey;

/// The name of a constant in C: module and name, since two modules may use the same name.
pub fn name((module, own): &ItemKey) -> String {
    match module.as_str() {
        "constants" | "control" => format!("FLYWHEEL_{own}"),
        _ => format!("{}_{own}", module.to_uppercase()),
    }
}

/// Its definition, and the items that it needs.
pub fn definition(items: &Items, key: &ItemKey) -> Result<(String, Needs)> {
    let mut scope = Scope::new(items, &key.0, None, &key.1);
    scope.depth = 0;
    let Some(constant) = items.constants.get(key) else {
        return scope.refuse("this constant");
    };
    let comment = comments::before(&comments::lines(&constant.attributes), "");
    let own = name(key);
    let text = if constant.ty.is_aggregate() {
        let value = scope.initialiser(&constant.value, &constant.ty)?;
        format!("static const {} = {value};", constant.ty.declare(&own))
    } else {
        let value = scope.scalar(&constant.value, Some(&constant.ty))?;
        format!("#define {own} {}", value.within(0))
    };
    Ok((format!("{comment}{text}\n"), scope.needs))
}
