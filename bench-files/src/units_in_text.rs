//! Units as people write them: in a line of units, behind a number, in the name of a column.

/// A unit as `units` in bench.toml writes it, from other ways of writing it: `[°/s]` is `deg/s`.
pub fn plain_unit(cell: &str) -> Option<&'static str> {
    let bare = cell.trim_matches(['[', ']', '(', ')', ' ']);
    Some(match bare {
        "s" | "sec" | "seconds" | "Sekunden" => "s",
        "ms" | "msec" => "ms",
        "us" | "µs" | "μs" => "us",
        "ns" => "ns",
        "rad" => "rad",
        "mrad" => "mrad",
        "deg" | "°" | "degrees" | "Grad" => "deg",
        "rev" | "turns" => "rev",
        "rad/s" | "rad/sec" | "rad s-1" | "rads-1" => "rad/s",
        "mrad/s" => "mrad/s",
        "deg/s" | "°/s" | "dps" | "deg/sec" => "deg/s",
        "rev/s" | "rps" | "1/s" => "rev/s",
        "rpm" | "RPM" | "1/min" | "U/min" | "min-1" | "r/min" => "rpm",
        "A" => "A",
        "mA" => "mA",
        _ => return None,
    })
}

/// Endings of column names that state a unit, longest first.
const ENDINGS: [(&str, &str); 24] = [
    ("_mrad_s", "mrad/s"),
    ("_rad_s", "rad/s"),
    ("_deg_s", "deg/s"),
    ("_rad_per_s", "rad/s"),
    ("_deg_per_s", "deg/s"),
    ("_rads", "rad/s"),
    ("_dps", "deg/s"),
    ("_rpm", "rpm"),
    ("_rev_s", "rev/s"),
    ("_rps", "rev/s"),
    ("_mrad", "mrad"),
    ("_rad", "rad"),
    ("_deg", "deg"),
    ("_turns", "rev"),
    ("_revs", "rev"),
    ("_rev", "rev"),
    ("_degrees", "deg"),
    ("_grad", "deg"),
    ("_ms", "ms"),
    ("_us", "us"),
    ("_ns", "ns"),
    ("_ma", "mA"),
    ("_s", "s"),
    ("_a", "A"),
];

/// The unit in a column's name: in brackets, as an ending, or as the whole name.
pub fn unit_of_name(name: &str) -> Option<&'static str> {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let (Some(from), Some(to)) = (name.find(open), name.rfind(close))
            && from < to
            && let Some(unit) = plain_unit(&name[from..=to])
        {
            return Some(unit);
        }
    }
    if name.eq_ignore_ascii_case("rpm") {
        return Some("rpm");
    }
    let lower = name.to_lowercase().replace([' ', '-', '/'], "_");
    let ending = ENDINGS.iter().find(|(ending, _)| lower.ends_with(ending));
    ending.map(|(_, unit)| *unit)
}
