//! The JSON form of values of other crates: enumerations as their names, gaps in a series as null.

use diagnose::Verdict;
use identify::{Coordinate, Output, ResidualKind};
use serde::{Deserialize, Deserializer, Serializer, de};

/// A value of a fixed list that has a name.
pub(crate) trait Named: Copy + 'static {
    /// The list.
    const ALL: &'static [Self];
    /// The name in JSON.
    fn name(self) -> &'static str;

    /// The value with this name, if there is one.
    fn from_name(name: &str) -> Option<Self> {
        let mut all = Self::ALL.iter().copied();
        all.find(|value| value.name() == name)
    }
}

impl Named for Output {
    const ALL: &'static [Output] = &Output::ALL;
    fn name(self) -> &'static str {
        Output::name(self)
    }
}

impl Named for Coordinate {
    const ALL: &'static [Coordinate] = &Coordinate::ALL;
    fn name(self) -> &'static str {
        Coordinate::name(self)
    }
}

impl Named for Verdict {
    const ALL: &'static [Verdict] = &[
        Verdict::NothingMissing,
        Verdict::Explained,
        Verdict::Ambiguous,
        Verdict::Unexplained,
    ];
    fn name(self) -> &'static str {
        Verdict::name(self)
    }
}

impl Named for ResidualKind {
    const ALL: &'static [ResidualKind] = &[ResidualKind::ResidualTorque, ResidualKind::Output];
    fn name(self) -> &'static str {
        match self {
            ResidualKind::ResidualTorque => "missing torque",
            ResidualKind::Output => "output",
        }
    }
}

/// For `#[serde(with)]`.
pub(crate) fn serialize<T: Named, S: Serializer>(
    value: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(value.name())
}

/// For `#[serde(with)]`.
pub(crate) fn deserialize<'d, T: Named, D: Deserializer<'d>>(
    deserializer: D,
) -> Result<T, D::Error> {
    let name = String::deserialize(deserializer)?;
    T::from_name(&name).ok_or_else(|| de::Error::custom(format!("unknown name \"{name}\"")))
}

/// A series with gaps: NaN in memory, null in JSON.
pub(crate) mod gaps {
    use serde::{Deserialize, Deserializer, Serializer};

    pub(crate) fn serialize<S: Serializer>(
        values: &[f64],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(
            values
                .iter()
                .map(|value| value.is_finite().then_some(value)),
        )
    }

    pub(crate) fn deserialize<'d, D: Deserializer<'d>>(
        deserializer: D,
    ) -> Result<Vec<f64>, D::Error> {
        let values = Vec::<Option<f64>>::deserialize(deserializer)?;
        Ok(values
            .into_iter()
            .map(|value| value.unwrap_or(f64::NAN))
            .collect())
    }
}

/// A number that may be missing: NaN in memory, null in JSON.
pub(crate) mod gap {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(*value).serialize(serializer)
    }

    pub(crate) fn deserialize<'d, D: Deserializer<'d>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
    }
}

/// A number that may be infinite: infinite in memory, null in JSON.
pub(crate) mod unbounded {
    use serde::{Deserialize, Deserializer, Serializer};

    pub(crate) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        super::gap::serialize(value, serializer)
    }

    pub(crate) fn deserialize<'d, D: Deserializer<'d>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}
