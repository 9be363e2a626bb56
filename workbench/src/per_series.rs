//! One number for each measured series.

use std::fmt;

use identify::{Output, Record};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};
use serde::ser::{Serialize, SerializeMap, Serializer};

use crate::named::Named;

/// A measured series: a channel of an experiment, in JSON "experiment/channel".
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SeriesName {
    /// The experiment.
    pub experiment: String,
    /// The channel.
    pub channel: Output,
}

impl fmt::Display for SeriesName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.experiment, self.channel.name())
    }
}

/// One number for each series, in the order of the experiments; an object in JSON. A number that is not finite is
/// null.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PerSeries(pub Vec<(SeriesName, f64)>);

impl PerSeries {
    /// The number of this series.
    pub fn get(&self, experiment: &str, channel: Output) -> Option<f64> {
        let mut all = self.0.iter();
        all.find(|(name, _)| name.experiment == experiment && name.channel == channel)
            .map(|(_, value)| *value)
    }

    /// The number of this series.
    pub fn of(&self, series: &SeriesName) -> Option<f64> {
        self.get(&series.experiment, series.channel)
    }

    /// The series with their numbers.
    pub fn iter(&self) -> impl Iterator<Item = &(SeriesName, f64)> {
        self.0.iter()
    }
}

impl FromIterator<(SeriesName, f64)> for PerSeries {
    fn from_iter<I: IntoIterator<Item = (SeriesName, f64)>>(numbers: I) -> PerSeries {
        PerSeries(numbers.into_iter().collect())
    }
}

impl Serialize for PerSeries {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(&name.to_string(), &value.is_finite().then_some(*value))?;
        }
        map.end()
    }
}

impl<'d> Deserialize<'d> for PerSeries {
    fn deserialize<D: Deserializer<'d>>(deserializer: D) -> Result<PerSeries, D::Error> {
        struct InOrder;
        impl<'d> Visitor<'d> for InOrder {
            type Value = PerSeries;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object with a number for each \"experiment/channel\"")
            }

            fn visit_map<M: MapAccess<'d>>(self, mut map: M) -> Result<PerSeries, M::Error> {
                let mut numbers = Vec::new();
                while let Some((key, value)) = map.next_entry::<String, Option<f64>>()? {
                    let name = key
                        .rsplit_once('/')
                        .and_then(|(experiment, channel)| {
                            Some(SeriesName {
                                experiment: experiment.to_owned(),
                                channel: Output::from_name(channel)?,
                            })
                        })
                        .ok_or_else(|| M::Error::custom(format!("no series \"{key}\"")))?;
                    numbers.push((name, value.unwrap_or(f64::NAN)));
                }
                Ok(PerSeries(numbers))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

/// Numbers in the order of the records and their channels, with the names of the series.
pub(crate) fn per_series(records: &[Record], values: impl IntoIterator<Item = f64>) -> PerSeries {
    let names = records.iter().flat_map(|record| {
        record.channels.iter().map(|channel| SeriesName {
            experiment: record.name.clone(),
            channel: channel.output,
        })
    });
    names.zip(values).collect()
}
