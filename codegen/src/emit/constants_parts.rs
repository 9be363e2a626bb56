//! The constants that every bench has, whichever sensor measures the body: the wheel's sensor, the drive, lines and
//! words.

use proc_macro2::TokenStream;
use quote::quote;

use crate::emit::{integer, outer_docs};
use crate::exact::ShortestDecimal;
use crate::hardware::{EncoderSpec, WheelSensor};
use crate::hardware_words::{DutyWords, HardwareWords};
use crate::helpers::encoder::EncoderNumbers;
use crate::helpers::line::Line;
use crate::helpers::plane::Plane;
use crate::ir::IntegerLaw;
use crate::spec::ModuleSpec;

/// The constants of the wheel's sensor and of the drive, after the types of the drive that they need.
pub(super) fn wheel_and_drive(
    spec: &ModuleSpec,
    law: &IntegerLaw,
    words: &HardwareWords,
) -> (Option<TokenStream>, TokenStream) {
    let wheel_docs = outer_docs(&[wheel_document(spec, law)]);
    let wheel_line = line(&words.wheel_speed);
    let wheel_encoder = wheel_encoder(spec, words);
    let (duty_type, duty) = duty(spec, law, words);
    let zero = integer(words.zero_current.into());
    let zero_docs = outer_docs(&zero_documents(spec));
    let constants = quote! {
        #wheel_docs
        pub const WHEEL_SPEED_LINE: Line = #wheel_line;
        #wheel_encoder
        #duty
        #zero_docs
        pub const ZERO_CURRENT: u16 = #zero;
    };
    (duty_type, constants)
}

/// The documentation of the wheel's sensor and its words.
fn wheel_document(spec: &ModuleSpec, law: &IntegerLaw) -> String {
    let number = |value: f64| ShortestDecimal::new(value).text;
    let hardware = &spec.hardware;
    format!(
        "From {} to the word of the wheel speed ({}): {} count + {} rad/s, within ±{} rad/s.",
        match hardware.wheel {
            WheelSensor::Converter => "counts",
            WheelSensor::Driver => "the driver's word",
            WheelSensor::Encoder(_) => "the counts that the encoder turned over its window",
        },
        law.terms[2].input.format.type_name(),
        number(hardware.wheel_speed_per_count),
        number(hardware.wheel_speed_at_zero),
        number(spec.ranges.wheel_speed_rad_s)
    )
}

/// The constant of the wheel's encoder, where there is one.
fn wheel_encoder(spec: &ModuleSpec, words: &HardwareWords) -> Option<TokenStream> {
    let (WheelSensor::Encoder(stated), Some(numbers)) =
        (&spec.hardware.wheel, &words.wheel_encoder)
    else {
        return None;
    };
    let docs = outer_docs(&encoder_documents(
        "The wheel's encoder",
        "speed",
        stated,
        spec.sample_time_s,
        numbers,
    ));
    let numbers = encoder(numbers);
    Some(quote! {
        #docs
        pub const WHEEL_ENCODER: EncoderNumbers = #numbers;
    })
}

/// The duty's words. Its type is imported if the other lines use another one.
fn duty(
    spec: &ModuleSpec,
    law: &IntegerLaw,
    words: &HardwareWords,
) -> (Option<TokenStream>, TokenStream) {
    let number = |value: f64| ShortestDecimal::new(value).text;
    let current = law.current.type_name();
    match (&words.duty, &spec.drive.voltage) {
        (DutyWords::Plane(words), Some(voltage)) => {
            let docs = outer_docs(&[
                format!(
                    "From the words of the current ({current}) and of the wheel speed ({}) to the duty of the voltage",
                    law.terms[2].input.format.type_name()
                ),
                format!(
                    "{} Ohm u + {} V s/rad w: {} V per count, duty {} at 0 V, within the supply's ±{} V.",
                    number(voltage.winding_ohm),
                    number(voltage.back_emf_v_s),
                    number(voltage.volts_per_count),
                    spec.drive.duty_zero,
                    number(voltage.supply_v)
                ),
                "At its ends the supply is too low for the current, and less current flows."
                    .to_owned(),
            ]);
            let plane = plane(words);
            let tokens = quote! {
                #docs
                pub const DUTY_PLANE: Plane = #plane;
            };
            let import = quote! { use super::plane::Plane; };
            (Some(import), tokens)
        }
        (DutyWords::Line(words), _) => {
            let docs = outer_docs(&[format!(
                "From the word of the current ({current}) to the duty: {} A per count, duty {} at zero current.",
                number(spec.drive.amperes_per_count),
                spec.drive.duty_zero
            )]);
            let line = line(words);
            let tokens = quote! {
                #docs
                pub const DUTY_LINE: Line = #line;
            };
            (None, tokens)
        }
        (DutyWords::Plane(_), None) => (None, quote!()),
    }
}

/// The duty while the controller does not run.
fn zero_documents(spec: &ModuleSpec) -> Vec<String> {
    let Some(voltage) = &spec.drive.voltage else {
        return vec!["Duty at zero current.".to_owned()];
    };
    let speed = spec.ranges.wheel_speed_rad_s;
    vec![
        "Duty while the controller does not run: 0 V, whatever the sensors read, so that the motor gets no power."
            .to_owned(),
        "A bridge that stays on then shorts the winding, so that the motor brakes the wheel. At".to_owned(),
        format!(
            "{speed} rad/s a current of {:.2} A would begin to flow. A firmware that is to let the wheel run out",
            voltage.back_emf_v_s * speed / voltage.winding_ohm
        ),
        "switches the bridge off while `status()` is not `Running`.".to_owned(),
    ]
}

/// The documentation of an encoder and its words.
pub(super) fn encoder_documents(
    name: &str,
    shows: &str,
    encoder: &EncoderSpec,
    sample_time_s: f64,
    numbers: &EncoderNumbers,
) -> Vec<String> {
    vec![
        format!(
            "{name}: {} counts a turn, wrapping at {}; its turn over {} steps is the {shows} of",
            ShortestDecimal::new(encoder.counts_per_turn).text,
            numbers.wrap,
            numbers.window
        ),
        format!(
            "{} s ago. A turn that differs from the turn of the step before by more than {} counts is a fault.",
            ShortestDecimal::new(0.5 * f64::from(encoder.window) * sample_time_s).text,
            numbers.jump
        ),
    ]
}

pub(super) fn encoder(words: &EncoderNumbers) -> TokenStream {
    let wrap = integer(words.wrap.into());
    let window = integer(words.window.into());
    let jump = integer(words.jump.into());
    quote!(EncoderNumbers { wrap: #wrap, window: #window, jump: #jump })
}

fn plane(words: &Plane) -> TokenStream {
    let current = integer(words.current.into());
    let speed = integer(words.speed.into());
    let offset = integer(words.offset);
    let shift = integer(words.shift.into());
    let low = integer(words.low.into());
    let high = integer(words.high.into());
    quote!(Plane {
        current: #current, speed: #speed, offset: #offset, shift: #shift, low: #low, high: #high,
    })
}

pub(super) fn stated(what: &str, value: Option<String>, unit: &str) -> String {
    match value {
        Some(value) => format!("{what}: {value} {unit}."),
        None => format!("{what}: not stated."),
    }
}

pub(super) fn line(words: &Line) -> TokenStream {
    let scale = integer(words.scale.into());
    let offset = integer(words.offset);
    let shift = integer(words.shift.into());
    let low = integer(words.low.into());
    let high = integer(words.high.into());
    quote!(Line { scale: #scale, offset: #offset, shift: #shift, low: #low, high: #high })
}

/// `name: value` of a struct literal.
pub(super) fn field(name: &str, value: i32) -> TokenStream {
    let name = quote::format_ident!("{name}");
    let value = integer(value.into());
    quote!(#name: #value)
}

pub(super) fn array(values: &[i32]) -> TokenStream {
    let values = values.iter().map(|&value| integer(value.into()));
    quote!([#(#values),*])
}
