//! `src/constants.rs` of the emitted crate: the words of sensors, mounting, converter and drive.

use proc_macro2::TokenStream;

use crate::emit::{body_constants_rs, inertial_constants_rs, print};
use crate::file::EmittedFile;
use crate::hardware::BodySensor;
use crate::hardware_words::{BodyWords, HardwareWords};
use crate::ir::IntegerLaw;
use crate::spec::ModuleSpec;

/// Emits `src/constants.rs`.
pub fn file(spec: &ModuleSpec, law: &IntegerLaw, words: &HardwareWords) -> EmittedFile {
    let tokens = match (&spec.hardware.body, &words.body) {
        (BodySensor::Inertial(attitude), BodyWords::Inertial(own)) => {
            inertial_constants_rs::tokens(spec, law, words, attitude, own)
        }
        (BodySensor::Encoder(body), BodyWords::Encoder(own)) => {
            body_constants_rs::tokens(spec, law, words, body, own)
        }
        // The words of a module are derived from its sensors.
        _ => TokenStream::new(),
    };
    EmittedFile {
        path: "src/constants.rs".to_owned(),
        contents: print(spec, tokens),
    }
}
