//! Claim `model-matches`: the certificate is about the model in the user's file.
//!
//! Parameters and requirements of the design are compared here. Sensors and drive become matrices through parts lists
//! and mountings, which is the work of the generator. The caller of this program compares them with
//! the generator's output for the same file.

use toml_edit::{DocumentMut, Item, TableLike};

use crate::certificate::reader::{Certificate, StatedDecimal};
use crate::claims::outcome::ClaimOutcome;

/// Compares the certificate with the text of a model.toml.
pub fn by_reading(certificate: &Certificate, model: &str) -> ClaimOutcome {
    ClaimOutcome::proved(check(certificate, model))
}

fn check(certificate: &Certificate, model: &str) -> Result<String, String> {
    let document: DocumentMut = model.parse().map_err(|error: toml_edit::TomlError| {
        format!("the model is no TOML: {}", error.message())
    })?;
    let parameters = table(document.as_table(), "parameters")?;
    for stated in &certificate.parameters {
        let name = &stated.name;
        let own = table(parameters, name)?;
        same(
            &format!("{name}.value"),
            Some(&stated.value),
            own.get("value"),
        )?;
        same(&format!("{name}.std"), stated.std.as_ref(), own.get("std"))?;
        let unit = own.get("unit").and_then(Item::as_str).unwrap_or_default();
        if unit != stated.unit {
            return Err(format!(
                "{name} is in `{unit}`, the certificate says `{}`",
                stated.unit
            ));
        }
    }
    let missing = parameters
        .iter()
        .find(|(name, _)| certificate.parameters.iter().all(|own| own.name != *name));
    if let Some((name, _)) = missing {
        return Err(format!("the certificate does not state {name}"));
    }
    same_correlations(certificate, &document)?;
    let mut wishes = 0;
    if let Some(design) = document.get("design").and_then(Item::as_table_like) {
        let mut wish = |key: &str, stated: &StatedDecimal| match design.get(key) {
            Some(item) => {
                wishes += 1;
                same(&format!("design.{key}"), Some(stated), Some(item))
            }
            None => Ok(()),
        };
        wish("sample_time", &certificate.sample_time_s)?;
        wish("current_weight", &certificate.weights.current)?;
        wish("current_limit", &certificate.constants[3].real)?;
        if let Some(weights) = design.get("state_weights").and_then(Item::as_array) {
            wishes += 1;
            let own: Vec<Option<f64>> = weights
                .iter()
                .map(|value| {
                    value
                        .as_float()
                        .or(value.as_integer().map(|whole| whole as f64))
                })
                .collect();
            let stated: Vec<Option<f64>> = certificate.weights.state.iter().map(value_of).collect();
            if own != stated {
                return Err("design.state_weights are not those of the certificate".to_owned());
            }
        }
    }
    Ok(format!(
        "{} parameters, {wishes} design settings",
        certificate.parameters.len()
    ))
}

/// [correlation] is stated as it stands in the file.
fn same_correlations(certificate: &Certificate, document: &DocumentMut) -> Result<(), String> {
    let own = document.get("correlation").and_then(Item::as_table_like);
    let (own, stated) = match (own, &certificate.correlation) {
        (None, None) => return Ok(()),
        (Some(own), Some(stated)) => (own, stated),
        (Some(_), None) => {
            return Err("the certificate does not state the model's [correlation]".to_owned());
        }
        (None, Some(_)) => {
            return Err("the certificate states correlations, the model has none".to_owned());
        }
    };
    let list = |key: &str| own.get(key).and_then(Item::as_array);
    let names = list("parameters").into_iter().flatten();
    let names: Vec<&str> = names
        .map(|name| name.as_str().unwrap_or_default())
        .collect();
    let rows = list("matrix").into_iter().flatten();
    let matrix: Vec<Vec<Option<f64>>> = rows
        .map(|row| {
            let entries = row.as_array().into_iter().flatten();
            let number = |entry: &toml_edit::Value| {
                entry
                    .as_float()
                    .or(entry.as_integer().map(|whole| whole as f64))
            };
            entries.map(number).collect()
        })
        .collect();
    let wanted: Vec<Vec<Option<f64>>> = stated
        .matrix
        .iter()
        .map(|row| row.iter().map(value_of).collect())
        .collect();
    if names == stated.parameters && matrix == wanted {
        Ok(())
    } else {
        Err("the certificate states other correlations than the model".to_owned())
    }
}

fn table<'a>(within: &'a dyn TableLike, key: &str) -> Result<&'a dyn TableLike, String> {
    within
        .get(key)
        .and_then(Item::as_table_like)
        .ok_or_else(|| format!("the model has no [{key}]"))
}

fn value_of(stated: &StatedDecimal) -> Option<f64> {
    stated.text.parse().ok()
}

/// The same double, or nothing on both sides.
fn same(what: &str, stated: Option<&StatedDecimal>, own: Option<&Item>) -> Result<(), String> {
    let found = own.and_then(|item| {
        item.as_float()
            .or(item.as_integer().map(|whole| whole as f64))
    });
    let wanted = stated.and_then(value_of);
    if found == wanted {
        return Ok(());
    }
    let shown =
        |value: Option<f64>| value.map_or("not stated".to_owned(), |value| value.to_string());
    Err(format!(
        "{what} is {}, the certificate says {}",
        shown(found),
        shown(wanted)
    ))
}
