//! Changes to a TOML document that keep its comments, and values that are equal to the new ones.

use toml_edit::{Item, Table, TableLike, Value};

/// The table under a key; it is created if it does not exist. `header_only` tables contain nothing but other
/// tables, and get no line of their own.
pub(crate) fn table_in<'a>(
    parent: &'a mut dyn TableLike,
    key: &str,
    header_only: bool,
) -> &'a mut dyn TableLike {
    // The reader has checked that these keys hold a table or do not exist.
    if !parent.get(key).is_some_and(Item::is_table_like) {
        let mut table = Table::new();
        table.set_implicit(header_only);
        parent.insert(key, Item::Table(table));
    }
    parent
        .get_mut(key)
        .and_then(Item::as_table_like_mut)
        .expect("a table was put there just now")
}

/// Sets a value and keeps its comment. An equal value is not rewritten.
pub(crate) fn set(table: &mut dyn TableLike, key: &str, value: Value) {
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) if same(old, &value) => {}
        Some(old) => {
            let decor = old.decor().clone();
            *old = value;
            *old.decor_mut() = decor;
        }
        None => {
            table.insert(key, Item::Value(value));
        }
    }
}

/// Whether two values are equal: numbers, texts, or lists of these.
fn same(a: &Value, b: &Value) -> bool {
    let as_number = |value: &Value| {
        value
            .as_float()
            .or_else(|| value.as_integer().map(|i| i as f64))
    };
    match (a, b) {
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b.iter()).all(|(a, b)| same(a, b))
        }
        _ => match (as_number(a), as_number(b)) {
            (Some(a), Some(b)) => a.to_bits() == b.to_bits(),
            _ => a.as_str().is_some() && a.as_str() == b.as_str(),
        },
    }
}

/// A number as TOML, in the shortest form that reads back as the same number.
pub(crate) fn number(value: f64) -> Value {
    let text = if value == 0.0 || (1e-2..1e6).contains(&value.abs()) {
        format!("{value:?}")
    } else {
        format!("{value:e}")
    };
    // A finite float formatted by `format!` is always a TOML float; otherwise the library's form is used.
    text.parse().unwrap_or_else(|_| Value::from(value))
}
