//! `verify/src/modes.rs` of the harness crate: the modes of the closed loop.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use crate::emit::{inner_docs, integer, outer_docs, print};
use crate::file::EmittedFile;
use crate::modes::{ModeWords, Modes};
use crate::spec::ModuleSpec;

/// Emits `verify/src/modes.rs`. All values are `None` for a loop without such modes.
pub fn file(spec: &ModuleSpec, modes: Option<&Modes>) -> EmittedFile {
    let docs = inner_docs(&[
        match modes {
            Some(modes) if modes.has_pair => {
                "The modes of the closed loop, in coordinates in which the first decays by itself, and the other two, \
                 a complex pair, beside each other."
            }
            _ => "The modes of the closed loop, in coordinates in which each decays by itself.",
        },
        "",
        match modes {
            Some(_) => "The rows of the coordinates stand in `certificate.json` under `modes`.",
            None => {
                "This loop has no box of modes that a step maps into itself: nothing is claimed, and all numbers are zero."
            }
        },
    ]);
    let nothing = ModeWords {
        decay: 0,
        rest: 0,
        input: 0,
    };
    let words = modes.map_or([nothing; 3], |modes| modes.words);
    let names = ["FIRST", "SECOND", "THIRD"];
    let constants: Vec<TokenStream> = names
        .iter()
        .zip(words)
        .map(|(name, mode)| {
            let docs = outer_docs(&[format!("The {} mode.", name.to_lowercase())]);
            let name = format_ident!("{name}");
            let [decay, rest, input] = [mode.decay, mode.rest, mode.input].map(integer);
            quote! {
                #docs
                pub const #name: Mode = Mode { decay: #decay, rest: #rest, input: #input };
            }
        })
        .collect();
    let tokens = quote! {
        #docs
        /// One mode: a coordinate of at most 2^28 becomes, in units of 2^-30 of it, at most `decay` times itself and `rest`,
        /// and `input` for each unit of the command's difference.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Mode {
            /// By what the coordinate is multiplied, in Q30.
            pub decay: i64,
            /// What the other coordinates may add.
            pub rest: i64,
            /// What a sixteenth of a unit of the sum of products adds.
            pub input: i64,
        }
        #(#constants)*
    };
    EmittedFile {
        path: "verify/src/modes.rs".to_owned(),
        contents: print(spec, tokens),
    }
}
