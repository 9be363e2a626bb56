//! The names of functions in C, and which functions and constants a firmware uses.

use super::items::FunctionKey;

/// The functions that a firmware calls: module, structure, name in Rust, name in C.
pub(super) const PUBLIC: [(&str, Option<&str>, &str, &str); 19] = [
    ("controller", Some("Controller"), "new", "flywheel_init"),
    ("controller", Some("Controller"), "arm", "flywheel_arm"),
    (
        "controller",
        Some("Controller"),
        "disarm",
        "flywheel_disarm",
    ),
    ("controller", Some("Controller"), "step", "flywheel_step"),
    (
        "controller",
        Some("Controller"),
        "step_with_current",
        "flywheel_step_with_current",
    ),
    (
        "controller",
        Some("Controller"),
        "status",
        "flywheel_status",
    ),
    ("controller", Some("Controller"), "fault", "flywheel_fault"),
    ("control", None, "control", "flywheel_control"),
    ("controller", None, "wheel_speed", "flywheel_wheel_speed"),
    ("encoder", Some("Encoder"), "new", "flywheel_encoder_init"),
    (
        "encoder",
        Some("Encoder"),
        "update",
        "flywheel_encoder_update",
    ),
    (
        "encoder",
        Some("Encoder"),
        "turned",
        "flywheel_encoder_turned",
    ),
    ("controller", Some("Controller"), "angle", "flywheel_angle"),
    ("controller", Some("Controller"), "rate", "flywheel_rate"),
    ("attitude", Some("Attitude"), "angle", "flywheel_angle"),
    ("attitude", Some("Attitude"), "rate", "flywheel_rate"),
    (
        "attitude",
        Some("Attitude"),
        "quaternion",
        "flywheel_quaternion",
    ),
    ("monitor", Some("Monitor"), "new", "flywheel_monitor_init"),
    (
        "monitor",
        Some("Monitor"),
        "allows",
        "flywheel_monitor_allows",
    ),
];
/// Constants that a firmware uses.
pub(super) const PUBLIC_CONSTANTS: [(&str, &str); 4] = [
    ("constants", "SAMPLE_TIME_US"),
    ("constants", "ZERO_CURRENT"),
    ("control", "CURRENT_LIMIT"),
    ("constants", "WHEEL_ENCODER"),
];

/// The name of a function in C.
pub fn function_name((module, owner, name): &FunctionKey) -> String {
    let is = |own: &&(&str, Option<&str>, &str, &str)| {
        own.0 == module && own.1 == owner.as_deref() && own.2 == name
    };
    if let Some((_, _, _, public)) = PUBLIC.iter().find(is) {
        return (*public).to_string();
    }
    match owner {
        Some(owner) => format!("{}_{name}", super::types::snake(owner)),
        None if name.starts_with(module.as_str()) => name.clone(),
        None => format!("{module}_{name}"),
    }
}

/// Whether a firmware calls the function.
pub(super) fn is_public(key: &FunctionKey) -> bool {
    let (module, owner, name) = key;
    PUBLIC
        .iter()
        .any(|one| one.0 == module && one.1 == owner.as_deref() && one.2 == name)
}
