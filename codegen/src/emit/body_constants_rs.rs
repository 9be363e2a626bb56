//! `src/constants.rs` of the emitted crate where an encoder shows the body.

use proc_macro2::TokenStream;
use quote::quote;

use crate::emit::constants_parts::{encoder, encoder_documents, field, line, wheel_and_drive};
use crate::emit::{inner_docs, integer, outer_docs};
use crate::exact::ShortestDecimal;
use crate::hardware::BodyEncoder;
use crate::hardware_words::{BodyEncoderWords, HardwareWords};
use crate::helpers::body_supervisor::Limits;
use crate::ir::IntegerLaw;
use crate::spec::ModuleSpec;
use crate::supervisor;

/// The constants.
pub(super) fn tokens(
    spec: &ModuleSpec,
    law: &IntegerLaw,
    words: &HardwareWords,
    body: &BodyEncoder,
    own: &BodyEncoderWords,
) -> TokenStream {
    let number = |value: f64| ShortestDecimal::new(value).text;
    let docs = inner_docs(&[
        "Constants of this bench: encoder on the pivot, sensor of the wheel, drive.".to_owned(),
        String::new(),
        "Each word is the real number rounded once to the format stated at its field.".to_owned(),
        String::new(),
        format!("Timer of the drive: {} bits.", spec.drive.bits),
    ]);
    let encoder_docs = outer_docs(&encoder_documents(
        "The encoder on the pivot",
        "rate",
        &body.encoder,
        spec.sample_time_s,
        &own.encoder,
    ));
    let numbers = encoder(&own.encoder);
    let zero_count = integer(own.zero.into());
    let [angle, rate, _] = &law.terms;
    let angle_docs = outer_docs(&[format!(
        "From counts relative to upright to the word of the angle ({}): {} counts a turn.",
        angle.input.format.type_name(),
        number(body.encoder.counts_per_turn)
    )]);
    let angle_line = line(&own.angle);
    let rate_docs = outer_docs(&[format!(
        "From the counts that the encoder turned over its window to the word of the rate ({}), within ±{} rad/s.",
        rate.input.format.type_name(),
        number(spec.ranges.rate_rad_s)
    )]);
    let rate_line = line(&own.rate);
    let holding_docs = outer_docs(&[
        format!(
            "From the word of the angle to the word of the current ({}) that holds the body there against gravity.",
            law.current.type_name()
        ),
        "The line replaces sin by the angle; the difference is small up to the angle that the largest current holds."
            .to_owned(),
    ]);
    let holding = line(&own.holding);
    let (duty_type, wheel_and_drive) = wheel_and_drive(spec, law, words);
    let limit_docs = outer_docs(&supervisor::documents_for_encoder(spec, body));
    let limits = limits(&own.limits);
    let micros = integer(words.sample_time_us.into());
    quote! {
        #docs
        use super::{encoder::EncoderNumbers, line::Line, supervisor::Limits};
        #duty_type
        /// Time between two steps in µs.
        pub const SAMPLE_TIME_US: u32 = #micros;
        #encoder_docs
        pub const BODY_ENCODER: EncoderNumbers = #numbers;
        /// The count of that encoder with the body upright.
        pub const BODY_ZERO: i32 = #zero_count;
        #angle_docs
        pub const BODY_ANGLE_LINE: Line = #angle_line;
        #rate_docs
        pub const BODY_RATE_LINE: Line = #rate_line;
        #holding_docs
        pub const HOLDING_LINE: Line = #holding;
        #wheel_and_drive
        #limit_docs
        pub const LIMITS: Limits = #limits;
    }
}

fn limits(words: &Limits) -> TokenStream {
    let fields = [
        ("angle_trip", words.angle_trip),
        ("angle_arm", words.angle_arm),
        ("rate_arm", words.rate_arm),
        ("still_steps", words.still_steps),
        ("wheel_low", words.wheel_low),
        ("wheel_high", words.wheel_high),
        ("wheel_steps", words.wheel_steps),
        ("left_over", words.left_over),
        ("frozen_steps", words.frozen_steps),
        ("saturated_steps", words.saturated_steps),
    ]
    .map(|(name, value)| field(name, value));
    quote!(Limits { #(#fields,)* })
}
