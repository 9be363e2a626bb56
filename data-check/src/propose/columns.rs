//! The channel of each column, from its name, its unit and its values.

use bench_files::{Channel, Table, unit_of_name};

use crate::thresholds::propose::FALLS;
use crate::view::{largest, range};

/// The proposal for one channel.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mapped {
    pub channel: Channel,
    /// Index of the column.
    pub index: usize,
    pub column: String,
    /// A unit that is not SI, or the name of a factor.
    pub unit: Option<&'static str>,
    /// The reason.
    pub reason: String,
}

/// The physical quantity of a unit.
#[derive(Clone, Copy, PartialEq)]
enum Quantity {
    Time,
    Angle,
    Speed,
    Current,
}

fn quantity(unit: &str) -> Quantity {
    match unit {
        "s" | "ms" | "us" | "ns" => Quantity::Time,
        "rad" | "mrad" | "deg" | "rev" => Quantity::Angle,
        "A" | "mA" => Quantity::Current,
        _ => Quantity::Speed,
    }
}

const WHEEL: [&str; 9] = [
    "wheel", "rpm", "motor", "phi", "φ", "rotor", "rad_s_w", "schwung", "drehzahl",
];
const RATE: [&str; 11] = [
    "gyro",
    "geschw",
    "rate",
    "dtheta",
    "dalpha",
    "_dot",
    "angvel",
    "drehrate",
    "gz",
    "body_speed",
    "pend_vel",
];
const ANGLE: [&str; 11] = [
    "angle", "pend", "theta", "θ", "alpha", "α", "pitch", "winkel", "tilt", "deg", "pos",
];
/// Words for the wheel's angle in a column's name, in addition to the words for the wheel.
const TURNED: [&str; 6] = ["angle", "pos", "winkel", "turn", "encoder", "count"];
const CURRENT: [&str; 5] = ["current", "curr", "strom", "amp", "i_mot"];
const TIME: [&str; 8] = [
    "time", "zeit", "millis", "micros", "stamp", "epoch", "datum", "date",
];

/// The channel that name and unit suggest.
fn named(name: &str, unit: Option<&str>) -> Option<Channel> {
    // A sample is no ampere.
    let lower = name.to_lowercase().replace("sample", "");
    let has = |parts: &[&str]| parts.iter().any(|part| lower.contains(part));
    let of_wheel = has(&WHEEL);
    match unit.map(quantity) {
        Some(Quantity::Time) => Some(Channel::Time),
        Some(Quantity::Current) => Some(Channel::Current),
        Some(Quantity::Angle) if of_wheel => Some(Channel::WheelAngle),
        Some(Quantity::Angle) => Some(Channel::Angle),
        Some(Quantity::Speed) if of_wheel || unit == Some("rpm") => Some(Channel::WheelSpeed),
        Some(Quantity::Speed) if has(&RATE) || has(&ANGLE) => Some(Channel::Rate),
        Some(Quantity::Speed) => Some(Channel::WheelSpeed),
        None if ["t", "ts"].contains(&lower.as_str()) || lower.starts_with("t_") || has(&TIME) => {
            Some(Channel::Time)
        }
        None if has(&CURRENT) || ["i", "cur"].contains(&lower.as_str()) => Some(Channel::Current),
        None if of_wheel && has(&TURNED) => Some(Channel::WheelAngle),
        None if of_wheel => Some(Channel::WheelSpeed),
        None if has(&RATE) => Some(Channel::Rate),
        None if has(&ANGLE) => Some(Channel::Angle),
        None if has(&["omega", "speed"]) => Some(Channel::WheelSpeed),
        // A command, the current that the controller requested.
        None if lower == "u" || lower.starts_with("u_") => Some(Channel::Current),
        None => None,
    }
}

/// Whether a column can be the time: it never falls, and is larger at the end than at the start.
fn rises(values: &[f64]) -> bool {
    values.len() > 1
        && values.iter().all(|value| value.is_finite())
        && values.windows(2).all(|pair| pair[1] >= pair[0])
        && values[values.len() - 1] > values[0]
}

/// Whether a column with a time's name can be the time: it rises, or would but for a few lines, at which the log was started
/// again or a counter began anew. Reading such a log says which line it is.
fn rises_mostly(values: &[f64]) -> bool {
    let falls = values.windows(2).filter(|pair| pair[1] < pair[0]).count();
    values.iter().all(|value| value.is_finite())
        && largest(values) > 0.0
        && falls as f64 <= FALLS * values.len() as f64
        && range(values).is_some_and(|(low, high)| low < high)
}

/// Whether the values are consecutive whole numbers: an index of rows, or milliseconds of a log at 1 kHz.
pub(super) fn is_index(values: &[f64]) -> bool {
    rises(values) && values.windows(2).all(|pair| pair[1] - pair[0] == 1.0)
}

/// The channels of a file, each with its best column. Of two equally good columns, the first is taken.
pub(super) fn mapped(table: &Table) -> Vec<Mapped> {
    let mut found: Vec<Mapped> = vec![];
    for channel in Channel::ALL {
        let candidates = table.names.iter().enumerate().filter_map(|(index, name)| {
            let of_line = table.units[index];
            let unit = of_line.or_else(|| unit_of_name(name));
            if found.iter().any(|mapped| mapped.index == index) {
                return None;
            }
            let values = &table.columns[index];
            if named(name, unit) != Some(channel)
                || (channel == Channel::Time && !rises_mostly(values))
            {
                return None;
            }
            let standard = name == channel.standard_name();
            let reason = match (standard, of_line, unit) {
                (true, _, _) => "its standard name".to_owned(),
                (false, Some(unit), _) => format!("its name and its unit, {unit}"),
                (false, None, Some(unit)) => format!("its name, which says {unit}"),
                (false, None, None) => "its name".to_owned(),
            };
            let mapped = Mapped {
                channel,
                index,
                column: name.clone(),
                unit,
                reason,
            };
            Some((
                2 * usize::from(standard) + usize::from(unit.is_some()),
                mapped,
            ))
        });
        // `max_by_key` would take the last of equals.
        let best = candidates.fold(None, |best: Option<(usize, Mapped)>, next| match best {
            Some(best) if best.0 >= next.0 => Some(best),
            _ => Some(next),
        });
        found.extend(best.map(|(_, mapped)| mapped));
    }
    if !found.iter().any(|mapped| mapped.channel == Channel::Time) {
        found.extend(unnamed_time(table, &found));
    }
    found
}

/// The only column that rises and has no other use, as the time.
fn unnamed_time(table: &Table, found: &[Mapped]) -> Option<Mapped> {
    let free = |index: &usize| !found.iter().any(|mapped| mapped.index == *index);
    let mut rising = (0..table.names.len())
        .filter(free)
        .filter(|index| rises(&table.columns[*index]) && !is_index(&table.columns[*index]));
    let (index, more) = (rising.next()?, rising.next());
    more.is_none().then(|| Mapped {
        channel: Channel::Time,
        index,
        column: table.names[index].clone(),
        unit: None,
        reason: "the only column that rises from line to line".to_owned(),
    })
}
