//! Every key of bench.toml, model.toml and an own effect's file, stated once: the readers allow these keys and
//! no others, and the guide prints them.

mod bench;
mod hardware;
mod model;
mod own_effect;

use serde::Serialize;

/// A key that a file may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// The SI unit of its value; empty where it has none.
    pub unit: &'static str,
    /// The value that holds if the key is left out; "needed" if it cannot be left out.
    pub default: &'static str,
    /// The line as a person would write it.
    pub example: &'static str,
    /// The meaning of its value.
    pub meaning: &'static str,
}

/// A section of a file with its keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct KeySection {
    /// Its name as a reader finds it: `known`, `hardware.drive`. A section whose keys depend on `kind` stands once
    /// for each kind, as `hardware.drive, voltage`.
    pub name: &'static str,
    /// The line that opens it.
    pub heading: &'static str,
    /// The purpose of the section.
    pub meaning: &'static str,
    /// Its keys.
    pub keys: &'static [Key],
}

/// A key; keeps the tables short.
const fn key(
    name: &'static str,
    unit: &'static str,
    default: &'static str,
    example: &'static str,
    meaning: &'static str,
) -> Key {
    Key {
        name,
        unit,
        default,
        example,
        meaning,
    }
}

/// Stands as the default of a key that must not be left out.
const NEEDED: &str = "needed";

/// The sections of bench.toml.
pub const BENCH: &[KeySection] = &[
    bench::BENCH,
    bench::KNOWN,
    bench::CONTROLLER,
    bench::EXPERIMENT,
    bench::CALIBRATION,
    bench::CALIBRATION_PLUMB_LINES,
    hardware::HARDWARE,
    hardware::GYROSCOPE,
    hardware::ACCELEROMETER,
    hardware::WHEEL_SPEED_CONVERTER,
    hardware::WHEEL_SPEED_ENCODER,
    hardware::WHEEL_SPEED_DRIVER,
    hardware::ANGLE_INERTIAL,
    hardware::ANGLE_ENCODER,
    hardware::DRIVE_CURRENT,
    hardware::DRIVE_VOLTAGE,
    bench::BRING_UP,
];

/// The sections of model.toml beside `[hardware]`, which is as in bench.toml.
pub const MODEL: &[KeySection] = &[
    model::PARAMETERS,
    model::CORRELATION,
    model::EFFECTS,
    model::LEARNED,
    model::DESIGN,
    model::CALIBRATION,
];

/// The file of an effect of one's own, `effects/NAME.toml`; in model.toml it stands as `[own.NAME]`.
pub const OWN_EFFECT: &[KeySection] = &[own_effect::EFFECT, own_effect::PARAMETERS];

/// The names of the keys that a section may have.
/// Empty for a section that is in none of the tables above; a test reads every section that the readers name.
pub(crate) fn names(sections: &[KeySection], section: &str) -> Vec<&'static str> {
    sections
        .iter()
        .find(|one| one.name == section)
        .map(|one| one.keys.iter().map(|key| key.name).collect())
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use toml_edit::DocumentMut;

    /// Each example is TOML that sets its key; the example of a subsection is its heading.
    #[test]
    fn examples_set_their_keys() {
        for section in BENCH.iter().chain(MODEL).chain(OWN_EFFECT) {
            assert!(!section.keys.is_empty(), "{}", section.name);
            for key in section.keys {
                let document: DocumentMut = key
                    .example
                    .parse()
                    .unwrap_or_else(|error| panic!("{} {}: {error}", section.name, key.example));
                let place = if key.example.starts_with('[') {
                    let inside = key.example.trim_matches(['[', ']']);
                    assert!(
                        inside.ends_with(&format!(".{}", key.name))
                            || inside.starts_with(&format!("{}.", key.name)),
                        "{}",
                        key.example
                    );
                    continue;
                } else {
                    document.as_table().contains_key(key.name)
                };
                assert!(place, "{} does not set {}", key.example, key.name);
            }
        }
    }

    /// The readers look a section up by its name; a name that is missing here would make them refuse every key.
    #[test]
    fn sections_have_one_name_each() {
        for list in [BENCH, MODEL, OWN_EFFECT] {
            for (index, section) in list.iter().enumerate() {
                assert_eq!(names(list, section.name).len(), section.keys.len());
                assert!(list[..index].iter().all(|one| one.name != section.name));
            }
        }
        assert!(names(BENCH, "unheard of").is_empty());
    }
}
