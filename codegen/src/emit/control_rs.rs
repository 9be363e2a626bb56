//! `src/control.rs` of the emitted crate: the control law.

use proc_macro2::{Ident, Span, TokenStream};
use quote::{format_ident, quote};

use crate::emit::{inner_docs, integer, outer_docs, print, single_line};
use crate::exact::{ShortestDecimal, outward};
use crate::file::EmittedFile;
use crate::format::Format;
use crate::ir::{IntegerLaw, Term};
use crate::spec::ModuleSpec;

/// Where the control law goes inside the emitted crate.
pub const PATH: &str = "src/control.rs";

/// Emits `src/control.rs`.
pub fn file(spec: &ModuleSpec, law: &IntegerLaw) -> EmittedFile {
    let docs = inner_docs(&module_docs(spec, law));
    let types = law.terms.iter().map(input_type);
    let current = current_items(law);
    let gains = law.terms.iter().map(gain_constant);
    let rounding = rounding_items(law);
    let function = control_function(law);
    let tokens = quote! {
        #docs
        #(#types)*
        #current
        #(#gains)*
        #rounding
        #function
    };
    EmittedFile {
        path: PATH.to_owned(),
        contents: print(spec, tokens),
    }
}

fn module_docs(spec: &ModuleSpec, law: &IntegerLaw) -> Vec<String> {
    let number = |value: f64| ShortestDecimal::new(value).text;
    let [angle, rate, wheel_speed] = &law.terms;
    let mut lines = vec![
        "State feedback with saturation.".to_owned(),
        String::new(),
        "```text".to_owned(),
        "current = clamp(-K1 angle - K2 rate - K3 wheel_speed, -CURRENT_LIMIT, CURRENT_LIMIT)"
            .to_owned(),
        "```".to_owned(),
        String::new(),
        format!(
            "One command every {} s. Positive current drives the wheel forward and the body backward.",
            number(spec.sample_time_s)
        ),
        String::new(),
        "# Formats".to_owned(),
        "Each is the finest 32-bit format that holds the stated range.".to_owned(),
        String::new(),
        "| value | range | type | one unit |".to_owned(),
        "|---|---|---|---|".to_owned(),
    ];
    for term in [angle, rate, wheel_speed] {
        let input = &term.input;
        lines.push(format!(
            "| `{}` | ±{} {unit} | `{}` | {} {unit} |",
            input.argument,
            input.range.text,
            input.format.type_name(),
            outward(&input.format.unit(), 3),
            unit = input.unit,
        ));
    }
    lines.extend([
        format!(
            "| current | ±{} A | `{}` | {} A |",
            number(spec.drive.current_range_a()),
            law.current.type_name(),
            outward(&law.current.unit(), 3),
        ),
        String::new(),
        "# Arithmetic".to_owned(),
        format!(
            "The three products have {} fraction bits each. Their sum is exact in 64 bits for every bit",
            law.product_fraction_bits
        ),
        "pattern of the inputs: no word exceeds 2^31 in magnitude, and the assertion below bounds the"
            .to_owned(),
        "sum by that. It is rounded once, to the nearest unit of"
            .to_owned(),
        "[`Current`], halves upward, and then clamped.".to_owned(),
        String::new(),
        "# Error of a step".to_owned(),
        format!(
            "- Against the clamped law with the gains of this file: {} A (half a unit), for every bit",
            outward(&law.bounds.rounding, 3)
        ),
        "  pattern.".to_owned(),
        format!(
            "- Against the clamped law with the real gains: {} A, within the ranges above.",
            outward(&law.bounds.real_gains, 3)
        ),
        format!(
            "- Rounding a real state to the nearest representable one adds at most {} A to either.",
            outward(&law.bounds.state_rounding, 3)
        ),
        String::new(),
        "# Origin".to_owned(),
        format!("- Model: `{}`.", single_line(&spec.model_name)),
        format!(
            "- State weights {}; current weight {}.",
            spec.state_weights.map(number).join(", "),
            number(spec.current_weight)
        ),
        format!("- Gains K: {}.", spec.gains.map(number).join(", ")),
    ]);
    if !spec.parameters.is_empty() {
        lines.extend([
            String::new(),
            "| parameter | value | standard error | unit |".to_owned(),
            "|---|---|---|---|".to_owned(),
        ]);
        for parameter in &spec.parameters {
            lines.push(format!(
                "| `{}` | {} | {} | {} |",
                single_line(&parameter.name),
                number(parameter.value),
                parameter.std.map_or("not stated".to_owned(), number),
                single_line(&parameter.unit),
            ));
        }
    }
    lines
}

fn input_type(term: &Term) -> TokenStream {
    let input = &term.input;
    let docs = outer_docs(&[format!(
        "{} ({}), within ±{} on the bench.",
        input.meaning, input.unit, input.range.text
    )]);
    let name = ident(input.type_name);
    let fixed = fixed_type(input.format);
    quote! {
        #docs
        pub type #name = fixed::types::#fixed;
    }
}

fn current_items(law: &IntegerLaw) -> TokenStream {
    let fixed = fixed_type(law.current);
    let limit = integer(law.limit_raw.into());
    let limit_docs = outer_docs(&[format!(
        "Largest magnitude of a command: {} A, as {} / 2^{}.",
        law.limit.text, law.limit_raw, law.current.fraction_bits
    )]);
    quote! {
        /// Motor current (A); positive current drives the wheel forward.
        pub type Current = fixed::types::#fixed;

        #limit_docs
        pub const CURRENT_LIMIT: Current = Current::from_bits(#limit);
    }
}

fn gain_constant(term: &Term) -> TokenStream {
    let gain = &term.gain;
    let docs = outer_docs(&[
        format!(
            "-{} = {} {}, as {} / 2^{}.",
            gain.symbol, gain.real.text, gain.unit, gain.raw, gain.fraction_bits
        ),
        String::new(),
        format!(
            "Rounding error {} {}: {} A at the end of the range of `{}`.",
            outward(&gain.error, 3),
            gain.unit,
            outward(&(&gain.error * &term.input.range.value), 3),
            term.input.argument
        ),
    ]);
    let name = ident(gain.constant);
    let raw = integer(gain.raw.into());
    quote! {
        #docs
        pub const #name: i32 = #raw;
    }
}

fn rounding_items(law: &IntegerLaw) -> TokenStream {
    let shift_docs = outer_docs(&[format!(
        "Number of bits that the rounding removes: {} of a product minus {} of a [`Current`].",
        law.product_fraction_bits, law.current.fraction_bits
    )]);
    let shift = integer(law.shift.into());
    let gains = law.terms.iter().map(|term| ident(term.gain.constant));
    let arguments = law.terms.iter().map(|term| ident(term.input.argument));
    let names = arguments.clone();
    quote! {
        #shift_docs
        pub const SHIFT: u32 = #shift;

        /// Half a unit of a [`Current`], on the scale of the products.
        const HALF_UNIT: i64 = 1_i64 << (SHIFT - 1);

        const _: () = {
            #(let #arguments = (#gains as i128).abs();)*
            let largest_sum = (#(#names)+*) * (1_i128 << 31) + HALF_UNIT as i128;
            assert!(largest_sum <= i64::MAX as i128, "the sum overflows");
        };
    }
}

fn control_function(law: &IntegerLaw) -> TokenStream {
    let arguments = law.terms.iter().map(|term| {
        let name = ident(term.input.argument);
        let input_type = ident(term.input.type_name);
        quote!(#name: #input_type)
    });
    let products = law.terms.iter().map(|term| {
        let name = ident(term.input.argument);
        let gain = ident(term.gain.constant);
        quote!(i64::from(#gain) * i64::from(#name.to_bits()))
    });
    let docs = outer_docs(&[
        "The current that drives the pendulum back to upright: -K x, within ±[`CURRENT_LIMIT`].",
        "",
        "Defined for every bit pattern of its inputs.",
    ]);
    quote! {
        #docs
        pub fn control(#(#arguments),*) -> Current {
            let sum = #(#products)+*;
            let command = (sum + HALF_UNIT) >> SHIFT;
            let limit = i64::from(CURRENT_LIMIT.to_bits());
            Current::from_bits(command.clamp(-limit, limit) as i32)
        }
    }
}

fn fixed_type(format: Format) -> Ident {
    format_ident!("{}", format.type_name())
}

fn ident(name: &str) -> Ident {
    Ident::new(name, Span::call_site())
}
