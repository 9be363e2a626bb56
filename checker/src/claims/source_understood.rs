//! Claim `source-understood`: the sources are written in the checker's language, and nothing else is built or run with
//! them.

use crate::claims::outcome::ClaimOutcome;
use crate::language::emitted::Emitted;
use crate::language::manifest;
use crate::language::module::Module;

/// The items that a firmware uses: structs whose fields it fills or reads, functions and methods. All are `pub`.
const FIELDS: [&str; 2] = ["Sample", "Duty"];
const FUNCTIONS: [&str; 21] = [
    "control",
    "duty",
    "wheel_speed",
    "body_angle",
    "body_rate",
    "Controller::new",
    "Controller::arm",
    "Controller::disarm",
    "Controller::fault",
    "Controller::status",
    "Controller::attitude",
    "Controller::angle",
    "Controller::rate",
    "Controller::step",
    "Controller::step_with_current",
    "Attitude::new",
    "Attitude::align",
    "Attitude::update_imu",
    "Attitude::update_marg",
    "Attitude::quaternion",
    "Attitude::angle",
];

/// Whether all that a firmware calls is public.
fn check_public(module: &Module) -> Result<(), String> {
    let declarations = module.declarations();
    for name in FIELDS {
        let found = declarations.structs.iter().find(|found| found.name == name);
        if found.is_some_and(|found| !found.is_whole) {
            return Err(format!("the fields of {name} are not public"));
        }
    }
    for name in FUNCTIONS {
        let of_name = declarations.functions.iter();
        let mut of_name = of_name.filter(|function| function.name == name).peekable();
        if of_name.peek().is_some() && of_name.all(|function| !function.is_public) {
            return Err(format!("{name} is not public"));
        }
    }
    Ok(())
}

/// For sources that were read as `module`: what lies beside them, and the manifest.
pub fn by_reading(emitted: &Emitted, module: &Module) -> ClaimOutcome {
    let functions = module.declarations().functions.len();
    ClaimOutcome::proved(
        check_surroundings(emitted)
            .and_then(|()| check_public(module))
            .map(|()| format!("{functions} functions in {} files", emitted.sources.len())),
    )
}

/// Nothing is built but the sources, with nothing but `fixed`; and the harness crate with nothing but these.
fn check_surroundings(emitted: &Emitted) -> Result<(), String> {
    if let Some(stray) = emitted.strays.first() {
        return Err(format!("{stray} does not belong to an emitted crate"));
    }
    if !emitted.sources.iter().any(|(path, _)| path == "src/lib.rs") {
        return Err("there is no src/lib.rs".to_owned());
    }
    let own = manifest::read(&emitted.cargo)?;
    match (&emitted.harness_cargo, emitted.harnesses.is_empty()) {
        (Some(text), _) => manifest::read_harness(text, &own.name),
        (None, true) => Ok(()),
        (None, false) => Err("there is no verify/Cargo.toml".to_owned()),
    }
}
