//! `src/monitor_words.rs` of an emitted crate with a monitor: its numbers.

use proc_macro2::TokenStream;
use quote::quote;

use crate::emit::{inner_docs, integer, outer_docs, print};
use crate::file::EmittedFile;
use crate::helpers::motion::MotionRow;
use crate::monitor::MonitorNumbers;
use crate::spec::ModuleSpec;

/// Emits `src/monitor_words.rs`.
pub fn file(spec: &ModuleSpec, numbers: &MonitorNumbers) -> EmittedFile {
    let words = &numbers.words;
    let memory_s = f64::from(1_u32 << words.leak) * spec.sample_time_s;
    let docs = inner_docs(&[
        "Numbers of the monitor: the sampled linear model, and how far a sound bench may be from it.",
    ]);
    let limit_docs = outer_docs(&[
        format!("Differences of a step add up over about {memory_s:.3} s."),
        String::new(),
        "| allowed | limit |".to_owned(),
        "|---|---|".to_owned(),
        format!(
            "| errors of the sensors | {:.4} rad, {:.4} rad/s, {:.3} rad/s |",
            numbers.errors[0], numbers.errors[1], numbers.errors[2]
        ),
        format!("| one push on the body | {:.3} rad/s |", numbers.push_rad_s),
        format!(
            "| sum of the wheel's own speed, beside its width | {:.3} rad/s |",
            numbers.wheel_limit_rad_s
        ),
        format!(
            "| sum of the body's rate, beside its width | {:.3} rad/s |",
            numbers.body_limit_rad_s
        ),
    ]);
    let [leak, shift] = [words.leak, words.shift].map(|value| integer(value.into()));
    let [rate, wheel_speed, wheel_limit, body_limit] = [
        words.rate,
        words.wheel_speed,
        words.wheel_limit,
        words.body_limit,
    ]
    .map(|value| integer(value.into()));
    let wheel = row(&words.wheel);
    let body = row(&words.body);
    let wheel_width = row(&words.wheel_width);
    let body_width = row(&words.body_width);
    let tokens = quote! {
        #docs
        use super::motion::{MotionLimits, MotionRow};
        #limit_docs
        pub const MOTION_LIMITS: MotionLimits = MotionLimits {
            leak: #leak,
            shift: #shift,
            rate: #rate,
            wheel_speed: #wheel_speed,
            wheel: #wheel,
            body: #body,
            wheel_width: #wheel_width,
            body_width: #body_width,
            wheel_limit: #wheel_limit,
            body_limit: #body_limit,
        };
    };
    EmittedFile {
        path: "src/monitor_words.rs".to_owned(),
        contents: print(spec, tokens),
    }
}

fn row(words: &MotionRow) -> TokenStream {
    let [angle, rate, wheel_speed, duty] =
        [words.angle, words.rate, words.wheel_speed, words.duty].map(|word| integer(word.into()));
    quote!(MotionRow {
        angle: #angle,
        rate: #rate,
        wheel_speed: #wheel_speed,
        duty: #duty,
    })
}
