//! Claim `source-understood`: the sources are written in the checker's language, and nothing else is built or run with
//! them.

use crate::claims::outcome::ClaimOutcome;
use crate::language::emitted::Emitted;
use crate::language::manifest;
use crate::language::module::Module;

/// For sources that were read as `module`: what lies beside them, and the manifest.
pub fn by_reading(emitted: &Emitted, module: &Module) -> ClaimOutcome {
    let functions = module.declarations().functions.len();
    ClaimOutcome::proved(
        check_surroundings(emitted)
            .map(|()| format!("{functions} functions in {} files", emitted.sources.len())),
    )
}

/// Nothing is built but the sources, with nothing but `fixed`.
fn check_surroundings(emitted: &Emitted) -> Result<(), String> {
    if let Some(stray) = emitted.strays.first() {
        return Err(format!("{stray} does not belong to an emitted crate"));
    }
    if !emitted.sources.iter().any(|(path, _)| path == "src/lib.rs") {
        return Err("there is no src/lib.rs".to_owned());
    }
    manifest::read(&emitted.cargo).map(|_| ())
}
