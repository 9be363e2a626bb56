//! The JSON of the contract. Fields that the contract does not name follow those that it does.

use serde::ser::{Serialize, SerializeMap, Serializer};

/// A parameter.
#[derive(serde::Serialize)]
pub struct Parameter {
    /// Name in the contract.
    pub name: String,
    /// Value in `unit`.
    pub value: f64,
    /// Standard error in `unit`; null where the value was given.
    pub std: Option<f64>,
    /// SI unit.
    pub unit: String,
}

/// Correlations of the errors of parameters, row by row in their order.
#[derive(serde::Serialize)]
pub struct Correlation {
    parameters: Vec<String>,
    matrix: Vec<Vec<f64>>,
}

/// Of model.toml's section.
pub fn correlation(found: Option<&bench_files::Correlation>) -> Option<Correlation> {
    found.map(|found| Correlation {
        parameters: found.parameters.clone(),
        matrix: found.matrix.clone(),
    })
}

/// Parameters of a model.toml.
pub fn parameters(parameters: &[bench_files::Parameter]) -> Vec<Parameter> {
    parameters
        .iter()
        .map(|parameter| Parameter {
            name: parameter.name.clone(),
            value: parameter.value,
            std: parameter.std,
            unit: parameter.unit.clone(),
        })
        .collect()
}

/// A JSON object whose keys keep their order: one number for each "experiment/channel".
#[derive(Default)]
pub struct Keyed(pub Vec<(String, f64)>);

impl Serialize for Keyed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (key, value) in &self.0 {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}
