//! Correct modules with other weights, sample times, sensors, drives and observers are emitted and proved; none is
//! refused.

use std::path::Path;

use checker::certificate::reader::Certificate;
use checker::prove::{Emitted, settle};
use checker::{ClaimOutcome, ProofSettings};
use rayon::prelude::*;
use workbench::ControlDesign;

/// A module: its name, and the sections of its model that differ from that of the thesis.
struct Sound {
    name: &'static str,
    changes: &'static [(&'static str, &'static str)],
}

/// A normal test run emits only a few modules.
const FEW: usize = 3;

const MODULES: [Sound; 12] = [
    Sound {
        name: "5 ms",
        changes: &[("sample_time = 0.001", "sample_time = 0.005")],
    },
    Sound {
        name: "an observer of the angle's bias",
        changes: &[(
            "current_limit = 2.0",
            "current_limit = 2.0\nbias_time_constant = 1.0",
        )],
    },
    Sound {
        name: "standard errors of 1.3 %",
        changes: &[
            ("value = 2.30344e-3", "value = 2.30344e-3\nstd = 3.0e-5"),
            ("value = 1.36125e-4", "value = 1.36125e-4\nstd = 1.8e-6"),
            ("value = 0.245158", "value = 0.245158\nstd = 3.2e-3"),
            ("value = 0.0335", "value = 0.0335\nstd = 4.4e-4"),
            ("value = 2.12e-5", "value = 2.12e-5\nstd = 2.8e-7"),
            ("value = 4.485e-4", "value = 4.485e-4\nstd = 5.8e-6"),
            ("value = 1.75204e-5", "value = 1.75204e-5\nstd = 2.3e-7"),
        ],
    },
    Sound {
        name: "the thesis",
        changes: &[],
    },
    Sound {
        name: "0.5 ms",
        changes: &[("sample_time = 0.001", "sample_time = 0.0005")],
    },
    Sound {
        name: "2 ms",
        changes: &[("sample_time = 0.001", "sample_time = 0.002")],
    },
    Sound {
        name: "4 ms",
        changes: &[("sample_time = 0.001", "sample_time = 0.004")],
    },
    Sound {
        name: "an angle that costs more",
        changes: &[("[25.0, 0.5, 5e-4]", "[100.0, 1.0, 1e-3]")],
    },
    Sound {
        name: "a current that costs more",
        changes: &[("current_weight = 1.0", "current_weight = 4.0")],
    },
    Sound {
        name: "a slower gyroscope of a finer range",
        changes: &[(
            "part = \"FXAS21002\"",
            "scale = 2.7270769e-4\nbits = 16\nclip = [32767, 32767, 32767]\nrate = 400.0",
        )],
    },
    Sound {
        name: "a converter of 10 bits, 1.2 A",
        changes: &[
            ("slope = 0.893372608506227", "slope = 1.35"),
            ("high = 1546", "high = 1023"),
            ("current_limit = 2.0", "current_limit = 1.2"),
        ],
    },
    Sound {
        name: "an accelerometer 5 cm up the body",
        changes: &[(
            "part = \"FXOS8700\"\naxes = [\"x\", \"y\", \"z\"]",
            "part = \"FXOS8700\"\naxes = [\"x\", \"y\", \"z\"]\nlever_arm = [0.05, 0.0]",
        )],
    },
];

/// Claims that fail, and those that no engine settles.
fn refused(module: &Sound, filter_length: bool) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/thesis-4.4.toml");
    let mut text = std::fs::read_to_string(path).expect("the model of the thesis");
    for (from, to) in module.changes {
        assert!(text.contains(from), "{}: no `{from}`", module.name);
        text = text.replacen(from, to, 1);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let model = folder.path().join("model.toml");
    std::fs::write(&model, &text).expect("written");
    let design =
        ControlDesign::read(&model).unwrap_or_else(|error| panic!("{}: {error}", module.name));
    let controller = design
        .generate(None)
        .unwrap_or_else(|error| panic!("{}: {error}", module.name));
    controller.write(folder.path()).expect("written");

    let emitted = Emitted::read(folder.path()).expect("a crate");
    let certificate = Certificate::parse(&emitted.certificate).expect("a certificate");
    let settings = ProofSettings {
        cases: 3_000,
        seed: 11,
        compiled: false,
        smt: false,
        kani: false,
        python: false,
        filter_length,
        ..ProofSettings::default()
    };
    let rows = settle(&emitted, &certificate, &settings);
    for row in &rows {
        if let ClaimOutcome::NotRun(why) = &row.outcome
            && !why.contains("switched off")
        {
            println!("{}: {} is not run: {why}", module.name, row.id);
        }
        if row.id == "loop-as-shipped" || row.id == "stable-for-parameters" {
            println!("{}: {}: {}", module.name, row.id, row.outcome.detail());
        }
    }
    let failed = rows
        .iter()
        .filter(|row| matches!(row.outcome, ClaimOutcome::Failed(_)));
    failed
        .map(|row| {
            format!(
                "{}: {} by {}: {}",
                module.name,
                row.id,
                row.engine,
                row.outcome.detail()
            )
        })
        .collect()
}

fn none_is_refused(modules: &[Sound], filter_length: bool) {
    let each = modules.par_iter();
    let all: Vec<String> = each
        .flat_map_iter(|module| refused(module, filter_length))
        .collect();
    assert!(all.is_empty(), "{all:#?}");
}

/// The claim about the filter's length takes half of the time of a proof. It is left out here, because other tests
/// prove it of other modules.
#[test]
fn a_few_sound_modules_are_not_refused() {
    none_is_refused(&MODULES[..FEW], false);
}

#[test]
#[ignore = "minutes: cargo test -p workbench --test all sound_modules -- --ignored"]
fn no_sound_module_is_refused() {
    none_is_refused(&MODULES[FEW..], true);
}
