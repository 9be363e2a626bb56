//! A proposal as the text of a bench.toml that shows every key.

use std::collections::BTreeMap;

use bench_files::Channel;

use super::Draft;

/// The text above the experiments.
const HEAD: &str = r#"
[known]                        # what was measured directly; each may be missing
# gravity         = 9.81       # m/s2
# torque_constant = 0.0335     # N m/A, from the motor's data sheet
# body_mass       = 0.2        # kg, without the wheel
# wheel_mass      = 0.106      # kg
# pivot_to_wheel  = 0.085      # m, from the pivot to the wheel's axis
# pivot_to_com    = 0.0799     # m, from the pivot to the body's centre of mass
# gravity_torque  = 0.2451     # N m, instead of masses and lengths
# total_inertia   = 2.3e-3     # kg m2, about the pivot; wheel_inertia and body_inertia likewise, where known
# wheel_inertia   = 1.36e-4
# body_inertia    = 5.0e-4

# [controller]                 # only with balance logs: u = -K (angle - pi, rate, wheel speed), clipped
# gains         = [-24.27, -2.13, -0.0226]
# current_limit = 2.0          # A
# sample_time   = 0.001        # s

# Every key of an [[experiment]]:
#   kind      "free-swing" (wheel locked, hanging), "spin-up" (body clamped), "balance" (upright, under a
#             controller), "driven" (everything free, hanging, open loop)
#   columns   = { time = "t", angle = "pend", rate = "gyro", wheel_speed = "rpm", wheel_angle = "enc", current = "i" }
#             standard names need none: time_s, angle_rad, rate_rad_s, wheel_speed_rad_s, wheel_angle_rad, current_A
#   units     = { time = "ms", angle = "deg", rate = "deg/s", wheel_speed = "rpm", wheel_angle = "rev", current = "mA" }
#   scale     = { angle = 0.5 }       value = sign * scale * (column in SI) + offset
#   sign      = { angle = -1 }
#   offset    = { angle = 3.14159265 }
#   constants = { current = 0.6 }     an input that was held and not logged, A
#   current_meaning = "measured"      what flowed; left out: what was asked for
#   from = 8.0   until = 60.0         seconds of the log to use
#   time_step = 0.005                 s from line to line, where there is no time column
#   accept    = ["rate-factor"]       findings of `flywheel check` that this experiment may have
"#;

/// The text below the experiments.
const TAIL: &str = r#"
# [hardware.gyroscope]         # likewise accelerometer, magnetometer: what the controller's raw counts mean
# part      = "FXAS21002"      # a preset; the keys below override it
# scale     = 1.0908308e-3     # rad/s (accelerometer m/s2, magnetometer uT) per count
# bits      = 16
# justified = "right"
# clip      = [32767, 32767, 32767]
# rate      = 800.0            # fresh samples a second
# axes      = ["x", "y", "z"]  # the body axis that each sensor axis shows, "-y" reversed; or
# rotation  = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]   # sensor to body
# lever_arm = [0.0, 0.0]       # m, accelerometer, along body x and y
# [hardware.wheel_speed]
# kind      = "converter"      # slope, offset (rad/s), low, high (counts); "encoder": counts_per_turn, bits, window, largest;
#                              # "driver": scale (rad/s per unit), largest (rad/s)
# [hardware.angle]
# kind      = "inertial"       # "encoder": counts_per_turn, bits, zero (the count upright)
# [hardware.drive]
# kind      = "current"        # "voltage": supply_voltage, winding_resistance
# bits      = 16               # duty_zero, duty_low, duty_high (counts)
# amperes_per_count = 8.39246e-5   # negative: inverted

# [bring_up]                   # recordings of raw counts: gx gy gz ax ay az wheel duty time_s
# hanging      = "hanging.csv"
# tilted       = "tilted.csv"        # towards positive angles
# wheel_spun   = "wheel-spun.csv"    # in that sense
# current_step = "current-step.csv"  # positive current, body held
"#;

/// The whole text.
pub(super) fn bench_toml(name: &str, known: &BTreeMap<String, f64>, drafts: &[Draft]) -> String {
    let mut text = format!(
        "# Proposed by `flywheel new`; the reasons stand beside each line. `flywheel check` says what is wrong.\n\
         [bench]\nname = {}\n{}",
        quoted(name),
        head(known)
    );
    for draft in drafts {
        text.push_str(&experiment(draft));
    }
    text + TAIL
}

/// [`HEAD`] with what is known in the place of its example.
fn head(known: &BTreeMap<String, f64>) -> String {
    let lines = HEAD.lines().map(|line| {
        let key = line
            .strip_prefix("# ")
            .and_then(|line| line.split_whitespace().next());
        match key.and_then(|key| Some((key, known.get(key)?))) {
            Some((key, value)) => {
                let about = line
                    .split_once('#')
                    .and_then(|(_, rest)| rest.split_once('#'));
                let about = about.map_or(String::new(), |(_, about)| format!("#{about}"));
                let line = format!("{:30} {about}", format!("{key:15} = {value:?}"));
                format!("{}\n", line.trim_end())
            }
            None => format!("{line}\n"),
        }
    });
    lines.collect()
}

/// A text in quotation marks, as TOML writes it.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out.push_str(&format!("\\u{:04X}", c as u32)),
            c => out.push(c),
        }
    }
    out + "\""
}

/// A comment of one line.
fn comment(text: &str) -> String {
    let plain: String = text
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect();
    format!("# {plain}\n")
}

fn experiment(draft: &Draft) -> String {
    let mut text = format!(
        "\n[[experiment]]\nname = {}\nfile = {}\n",
        quoted(&draft.name),
        quoted(&draft.file)
    );
    text.push_str(&comment(&format!(
        "{}: {}",
        draft.kind.name(),
        draft.kind_reason
    )));
    text.push_str(&format!("kind = \"{}\"\n", draft.kind.name()));
    for one in &draft.mapped {
        text.push_str(&comment(&format!(
            "{}: \"{}\", {}",
            one.channel.key(),
            one.column,
            one.reason
        )));
    }
    // A column with the standard name needs no entry.
    let columns = draft
        .mapped
        .iter()
        .filter(|one| one.column != one.channel.standard_name());
    let columns = columns.map(|one| format!("{} = {}", one.channel.key(), quoted(&one.column)));
    text.push_str(&table("columns", columns));
    let units = draft.mapped.iter().filter_map(|one| {
        let unit = one.unit.filter(|unit| !is_si(one.channel, unit))?;
        Some(format!("{} = \"{unit}\"", one.channel.key()))
    });
    text.push_str(&table("units", units));
    for (_, reason) in &draft.signs {
        text.push_str(&comment(reason));
    }
    let signs = draft
        .signs
        .iter()
        .map(|(channel, _)| format!("{} = -1", channel.key()));
    text.push_str(&table("sign", signs));
    if let Some((offset_rad, reason)) = &draft.offset_rad {
        text.push_str(&comment(reason));
        text.push_str(&format!("offset = {{ angle = {offset_rad:.8} }}\n"));
    }
    if let Some((current_a, reason)) = &draft.held_current_a {
        text.push_str(&comment(reason));
        text.push_str(&format!("constants = {{ current = {current_a:?} }}\n"));
    }
    if let Some((from_s, reason)) = &draft.from_s {
        text.push_str(&comment(reason));
        text.push_str(&format!("from = {from_s:?}\n"));
    }
    if let Some(until_s) = draft.until_s {
        text.push_str(&format!("until = {until_s:?}\n"));
    }
    if let Some(time_step_s) = draft.time_step_s {
        text.push_str(&format!("time_step = {time_step_s:?}\n"));
    }
    for question in &draft.questions {
        text.push_str(&comment(&format!("TO DECIDE: {question}")));
    }
    if !draft.unused.is_empty() {
        text.push_str(&comment(&format!("not used: {}", draft.unused.join(", "))));
    }
    text
}

/// Whether a unit is the default, which needs no entry.
fn is_si(channel: Channel, unit: &str) -> bool {
    let si = match channel {
        Channel::Time => "s",
        Channel::Angle | Channel::WheelAngle => "rad",
        Channel::Rate | Channel::WheelSpeed => "rad/s",
        Channel::Current => "A",
    };
    unit == si
}

fn table(key: &str, entries: impl Iterator<Item = String>) -> String {
    let entries: Vec<String> = entries.collect();
    if entries.is_empty() {
        return String::new();
    }
    format!("{key} = {{ {} }}\n", entries.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bench_files::keys::BENCH;

    /// Every key of a bench.toml that begins a bench stands in the text, at least as a comment.
    #[test]
    fn every_key_stands_in_the_proposal() {
        let text = bench_toml("bench", &BTreeMap::new(), &[]) + "[[experiment]] name file";
        for section in BENCH
            .iter()
            .filter(|section| !section.name.starts_with("calibration"))
        {
            for key in section.keys {
                assert!(text.contains(key.name), "{}: {}", section.name, key.name);
            }
        }
    }
}
