//! The sections `[learned.COORDINATE]` of a model: torques that were learned as curves.

use plant::{EffectId, FEWEST_KNOTS, LearnedCoordinate, LearnedCurve, MOST_KNOTS};
use toml_edit::{Array, TableLike, Value};

use crate::error::{Error, Problem};
use crate::parameter::{PER_INERTIA, Parameter};
use crate::toml_section::Section;
use crate::toml_writing::{number, set, table_in};

const KNOTS_EXAMPLE: &str =
    "knots = [-0.3, -0.1, 0.1, 0.3], the values of the coordinate, increasing";
const TORQUE_EXAMPLE: &str = "torque = [0.0, 1e-4, -1e-4, 0.0], N m as it acts, one for every knot";

/// Reads `[learned]`: the curves, and their torques as parameters of the model.
pub(crate) fn read(root: &Section) -> Result<(Vec<EffectId>, Vec<Parameter>), Error> {
    let (mut effects, mut parameters) = (vec![], vec![]);
    let Some(section) = root.section("learned")? else {
        return Ok((effects, parameters));
    };
    section.allow_only(&LearnedCoordinate::ALL.map(LearnedCoordinate::name))?;
    for coordinate in LearnedCoordinate::ALL {
        if let Some(entry) = section.section(coordinate.name())? {
            let (effect, own) = read_curve(coordinate, &entry)?;
            effects.push(effect);
            parameters.extend(own);
        }
    }
    Ok((effects, parameters))
}

fn read_curve(
    coordinate: LearnedCoordinate,
    entry: &Section,
) -> Result<(EffectId, Vec<Parameter>), Error> {
    entry.allow_only(&crate::keys::names(crate::keys::MODEL, "learned"))?;
    let required = |key: &'static str, example: &'static str| {
        let found = entry.numbers(key, &[0], "a list of numbers")?;
        found.ok_or_else(|| entry.error(entry.missing(key, example)))
    };
    let knots = required("knots", KNOTS_EXAMPLE)?;
    let torque = required("torque", TORQUE_EXAMPLE)?;
    let std = entry.numbers("std", &[0], "a list of numbers")?;
    let wrong = |key: &str, what: String| Err(entry.error_at(key, Problem::Curve(what)));
    let count = knots.len();
    if !(FEWEST_KNOTS..=MOST_KNOTS).contains(&count) {
        return wrong(
            "knots",
            format!("a learned curve has {FEWEST_KNOTS} to {MOST_KNOTS} knots; there are {count}"),
        );
    }
    if let Some(pair) = knots.windows(2).find(|pair| pair[1] <= pair[0]) {
        return wrong(
            "knots",
            format!(
                "knots increase; {} does not come after {}",
                pair[1], pair[0]
            ),
        );
    }
    if let Some(period) = coordinate.period()
        && knots[count - 1] - knots[0] >= period
    {
        return wrong(
            "knots",
            format!("the knots over the wheel's angle lie within one turn, {period:.5} rad"),
        );
    }
    let lists = [("torque", Some(&torque)), ("std", std.as_ref())];
    for (key, list) in lists {
        if let Some(list) = list.filter(|list| list.len() != count) {
            let own = list.len();
            return wrong(
                key,
                format!("there are {count} knots, but {own} values here"),
            );
        }
    }
    if let Some(negative) = std.iter().flatten().find(|std| **std < 0.0) {
        return Err(entry.error_at(
            "std",
            Problem::OutOfRange {
                key: "std".to_owned(),
                value: *negative,
                must_be: "zero or positive".to_owned(),
            },
        ));
    }
    let unit = entry
        .text("unit")?
        .map_or("N m".to_owned(), |unit| unit.value);
    if unit.strip_suffix(PER_INERTIA).unwrap_or(&unit) != "N m" {
        return Err(entry.error_at(
            "unit",
            Problem::UnitNotSi {
                name: coordinate.effect_name().to_owned(),
                unit,
                si: "N m",
            },
        ));
    }
    let source = entry
        .text("source")?
        .map_or(String::new(), |text| text.value);
    let Some(effect) = LearnedCurve::effect(coordinate, &knots, None) else {
        return wrong("knots", "no curve can be made of these knots".to_owned());
    };
    let infos = effect.info().parameters.iter().enumerate();
    let parameters = infos.map(|(index, info)| Parameter {
        name: info.name.to_owned(),
        value: torque[index],
        std: std.as_ref().map(|std| std[index]),
        unit: unit.clone(),
        source: source.clone(),
    });
    Ok((effect, parameters.collect()))
}

/// Writes the curves of a model in the place of those that were there.
pub(crate) fn write(
    root: &mut dyn TableLike,
    effects: &[EffectId],
    parameter: &dyn Fn(&str) -> Option<Parameter>,
) {
    let curves: Vec<(EffectId, &LearnedCurve)> = effects
        .iter()
        .filter_map(|effect| Some((*effect, effect.info().learned?)))
        .collect();
    if curves.is_empty() {
        root.remove("learned");
        return;
    }
    let section = table_in(root, "learned", true);
    for coordinate in LearnedCoordinate::ALL {
        let name = coordinate.name();
        let Some((effect, curve)) = curves.iter().find(|(_, one)| one.coordinate == coordinate)
        else {
            section.remove(name);
            continue;
        };
        let entry = table_in(section, name, false);
        let list = |values: Vec<f64>| -> Value {
            Value::Array(values.into_iter().map(number).collect::<Array>())
        };
        let own: Vec<Option<Parameter>> = effect
            .info()
            .parameters
            .iter()
            .map(|info| parameter(info.name))
            .collect();
        set(entry, "knots", list(curve.spline.knots().to_vec()));
        let torque = own.iter().flatten().map(|one| one.value);
        set(entry, "torque", list(torque.collect()));
        let std: Option<Vec<f64>> = own.iter().map(|one| one.as_ref()?.std).collect();
        match std {
            Some(std) => set(entry, "std", list(std)),
            None => {
                entry.remove("std");
            }
        }
        let first = own.iter().flatten().next();
        let texts = [
            (
                "unit",
                first
                    .filter(|one| one.is_per_inertia())
                    .map(|one| one.unit.as_str()),
            ),
            (
                "source",
                first
                    .map(|one| one.source.as_str())
                    .filter(|text| !text.is_empty()),
            ),
        ];
        for (key, text) in texts {
            match text {
                Some(text) => set(entry, key, Value::from(text)),
                None => {
                    entry.remove(key);
                }
            }
        }
    }
}
