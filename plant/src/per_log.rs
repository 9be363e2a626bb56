//! Effects with one parameter for each log: the number of their parameters depends on the bench.
//!
//! The library holds such an effect once, with the one parameter of a log without a name. [`EffectId::for_logs`] makes
//! the effect for a bench: its description lists one parameter for each log of that bench. Fit, reports and model.toml
//! read this description like that of any other effect. In an experiment only the parameter of its log acts
//! ([`crate::Plant::for_log`]).

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};
use std::sync::{Mutex, PoisonError};

use crate::EffectId;
use crate::effect::{EffectInfo, ParameterInfo};

/// An effect of the library made for the logs of a bench. Two that are made from the same effect for the same logs are
/// equal.
#[derive(Clone, Copy)]
pub struct PerLog(&'static Made);

struct Made {
    template: EffectId,
    logs: Vec<String>,
    info: EffectInfo,
}

impl Made {
    fn key(&self) -> (EffectId, &[String]) {
        (self.template, &self.logs)
    }
}

impl PerLog {
    /// The effect of the library.
    pub(crate) fn template(self) -> EffectId {
        self.0.template
    }

    /// The description, with a parameter for each log.
    pub(crate) fn info(self) -> &'static EffectInfo {
        &self.0.info
    }

    /// The index of the parameter that belongs to `log`.
    pub fn parameter_of(self, log: &str) -> Option<usize> {
        self.0.logs.iter().position(|own| own == log)
    }
}

impl std::fmt::Debug for PerLog {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "PerLog({:?}, {:?})", self.0.template, self.0.logs)
    }
}

impl PartialEq for PerLog {
    fn eq(&self, other: &PerLog) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for PerLog {}

impl Hash for PerLog {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.key().hash(state);
    }
}

impl PartialOrd for PerLog {
    fn partial_cmp(&self, other: &PerLog) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for PerLog {
    fn cmp(&self, other: &PerLog) -> Ordering {
        self.0.key().cmp(&other.0.key())
    }
}

/// The effects that were made so far. An entry lives as long as the program, which lets an [`EffectId`] stay a plain
/// value.
static MADE: Mutex<Vec<&'static Made>> = Mutex::new(vec![]);

/// The same value for each log.
fn for_each(values: &'static [f64], logs: usize) -> &'static [f64] {
    values.repeat(logs).leak()
}

impl EffectId {
    /// The effect for a bench whose logs have these names. An effect of which the library has one parameter per log
    /// gets a parameter for each name. Any other effect is returned unchanged, and so is every effect if `logs` is
    /// empty.
    #[must_use]
    pub fn for_logs(self, logs: &[String]) -> EffectId {
        let template = match self {
            EffectId::PerLog(made) => made.template(),
            other => other,
        };
        let info = template.info();
        if info.per_log.is_none() || logs.is_empty() {
            return template;
        }
        let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = made.iter().find(|known| known.key() == (template, logs)) {
            return EffectId::PerLog(PerLog(known));
        }
        let parameters: Vec<ParameterInfo> = logs
            .iter()
            .flat_map(|log| {
                info.parameters.iter().map(move |one| ParameterInfo {
                    name: parameter_name(one.name, log).leak(),
                    ..*one
                })
            })
            .collect();
        let starts: Vec<&'static [f64]> = info
            .starts
            .iter()
            .map(|start| for_each(start, logs.len()))
            .collect();
        let entry: &'static Made = Box::leak(Box::new(Made {
            template,
            logs: logs.to_vec(),
            info: EffectInfo {
                parameters: parameters.leak(),
                starts: starts.leak(),
                absent: info.absent.map(|absent| for_each(absent, logs.len())),
                ..*info
            },
        }));
        made.push(entry);
        EffectId::PerLog(PerLog(entry))
    }

    /// Whether the parameter at this position of the effect acts in `log`: false only for a parameter that belongs to
    /// another log.
    pub fn is_of_log(self, parameter: usize, log: &str) -> bool {
        match self {
            EffectId::PerLog(made) => made.parameter_of(log) == Some(parameter),
            _ => true,
        }
    }

    /// The log to which the parameter with this name belongs, if this effect of the library has such a parameter.
    pub fn log_of(self, parameter: &str) -> Option<&str> {
        self.info().per_log?;
        let (own, _) = self.info().parameters.first()?.name.split_once('/')?;
        parameter.strip_prefix(own)?.strip_prefix('/')
    }
}

/// The name of a log's parameter: `NAME/LOG`, with the name of the log (that of its experiment) after the slash.
fn parameter_name(template: &str, log: &str) -> String {
    let own = template.split_once('/').map_or(template, |(own, _)| own);
    format!("{own}/{log}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, Model, Plant, State};

    #[test]
    fn every_log_has_a_zero_of_its_own() {
        let logs = ["a".to_owned(), "b".to_owned()];
        let zero = EffectId::AngleZero.for_logs(&logs);
        assert_eq!(zero, EffectId::AngleZero.for_logs(&logs));
        assert_eq!(
            (zero.name(), zero.info().parameters.len()),
            ("angle-zero", 2)
        );
        let model = Model::base().with(EffectId::AngleOffset).with(zero);
        assert!(!model.has(EffectId::AngleOffset));
        let own: Vec<&str> = model.parameters()[6..].iter().map(|one| one.name).collect();
        assert_eq!(own, ["angle_zero/a", "angle_zero/b"]);
        let values = [2e-3, 1e-4, 0.2, 0.03, 0.0, 0.0, 0.1, -0.2];
        let plant = Plant::new(&model, &values, Kind::FreeSwing);
        for (log, expected) in [("a", 0.1), ("b", -0.2), ("c", 0.0)] {
            let plant = plant.clone().for_log(log);
            assert_eq!(plant.read(&State::rest()).angle_rad, expected);
        }
        // The effect made for more logs replaces the one made for fewer: 6 base and friction parameters plus 3.
        let more = zero.for_logs(&["a".to_owned(), "b".to_owned(), "c".to_owned()]);
        assert_eq!(model.with(more).parameter_count(), 9);
        assert_eq!(EffectId::AngleZero.log_of("angle_zero/a/b"), Some("a/b"));
        assert_eq!(EffectId::GyroBias.for_logs(&logs), EffectId::GyroBias);
    }
}
