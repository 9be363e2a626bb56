//! Every claim of the certificate is settled somewhere, and every harness settles a claim.

use crate::certificate;

use certificate::{Certificate, rational};
use num_traits::ToPrimitive;

/// Every harness, and the claim that it settles or is part of.
const HARNESSES: &[(&str, &str)] = &[
    ("control_total", "control-total"),
    ("control_accurate", "control-accurate"),
    ("closed_loop_agreement", "closed-loop-agreement"),
    ("filter_total", "filter-total"),
    ("filter_total_heading", "filter-total"),
    ("filter_total_tracked", "filter-total"),
    ("filter_total_angle", "filter-total"),
    ("step_total", "step-total"),
    ("supervisor_counts", "supervisor"),
    ("supervisor_judges", "supervisor"),
    ("supervisor_observes", "supervisor"),
    ("supervisor_gathers", "supervisor"),
    ("supervisor_freezes", "supervisor"),
    // Contracts and ranges that the steps rest on.
    ("mul_high_contract", "primitives"),
    ("round_high_contract", "primitives"),
    ("clamp_contract", "primitives"),
    ("clamp_wide_contract", "primitives"),
    ("seed_contract", "primitives"),
    ("refined_contract", "primitives"),
    ("inverse_root_contract", "primitives"),
    ("inverse_length_contract", "primitives"),
    ("scaled_up2_contract", "primitives"),
    ("scaled_up3_contract", "primitives"),
    ("scaled_up4_contract", "primitives"),
    ("arc_tangent2_contract", "primitives"),
    ("wrapped_contract", "primitives"),
    ("dot_contract", "primitives"),
    ("coarse_inverse_length_contract", "primitives"),
    ("coarse_inverse_root_contract", "primitives"),
    ("calibration_in_range", "primitives"),
    ("lever_arm_in_range", "primitives"),
    ("length_in_range", "primitives"),
    ("drift_in_range", "primitives"),
    ("lines_in_range", "primitives"),
    ("observer_in_range", "primitives"),
    // Of a bench with an encoder, or a voltage drive.
    ("encoder_in_range", "primitives"),
    ("body_in_range", "primitives"),
    ("plane_in_range", "primitives"),
];

/// Claims that Kani cannot settle, or need not, and why.
const NOT_BY_KANI: &[(&str, &str)] = &[
    ("source-understood", "it speaks of the text, not of words"),
    ("texts-audited", "it speaks of the text"),
    ("compiled-agrees", "it compares a compiler with a reader"),
    ("certificate-consistent", "it speaks of the certificate"),
    ("model-matches", "it speaks of the user's model"),
    (
        "hardware-words",
        "real numbers against constants: exact arithmetic",
    ),
    ("physical-signs", "physics of the bench, sines included"),
    (
        "control-accurate-real-gains",
        "real numbers: exact arithmetic on the certificate",
    ),
    (
        "control-monotone",
        "two copies of a product compared: does not close as bits",
    ),
    (
        "filter-length",
        "a polynomial of degree six: does not close as bits",
    ),
    ("filter-accurate", "floating point against words"),
    (
        "monitor-total",
        "a module may have none; intervals prove it for every word",
    ),
    (
        "monitor-silent",
        "real numbers: the model's, and its uncertainties",
    ),
    ("filter-exact", "two copies of the same arithmetic compared"),
    (
        "encoder-exact",
        "sums of turns in two orders do not close as bits; their ranges do (`encoder_in_range`)",
    ),
    (
        "closed-loop-stable",
        "real numbers: exact arithmetic on the certificate",
    ),
    (
        "encoder-loop-stable",
        "real numbers: exact arithmetic on the certificate",
    ),
    ("bias-observer-stable", "real numbers"),
    ("closed-loop-for-all-time", "real numbers over all time"),
    ("region-of-attraction", "real numbers over all time"),
    ("loop-as-shipped", "real numbers over all time"),
    ("motion-kept-up", "real numbers over all time"),
    ("stable-for-parameters", "real numbers"),
];

/// The texts of all proofs, of whatever bench.
fn proofs() -> Vec<String> {
    let folder = std::path::Path::new("../codegen/harnesses");
    let entries = std::fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let is_proof = |path: &std::path::PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        name.contains("proofs")
    };
    let found: Vec<String> = paths
        .filter(is_proof)
        .map(|path| std::fs::read_to_string(path).unwrap())
        .collect();
    assert!(found.len() > 7);
    found
}

/// Names of the functions under `#[kani::proof…]`.
fn harnesses(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut lines = text.lines();
    while lines.any(|line| line.starts_with("#[kani::proof")) {
        let name = lines.find_map(|line| line.strip_prefix("fn ")).unwrap();
        found.push(name.split_once('(').unwrap().0.to_owned());
    }
    found
}

#[test]
fn every_claim_has_a_harness_or_a_reason_and_every_harness_a_claim() {
    let mut found: Vec<String> = proofs().iter().flat_map(|text| harnesses(text)).collect();
    let mut listed: Vec<String> = HARNESSES
        .iter()
        .map(|(name, _)| (*name).to_owned())
        .collect();
    found.sort();
    // Two kinds of benches have harnesses of one name.
    found.dedup();
    listed.sort();
    assert_eq!(found, listed);

    // CLAIMS.md holds every claim of the checker and its engines; a test of the checker holds it to its table.
    let claims = include_str!("../../../CLAIMS.md");
    let rows: Vec<Vec<&str>> = claims
        .lines()
        .skip_while(|line| !line.starts_with("| claim"))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    assert!(rows.len() > 20);
    for row in &rows {
        let id = row[1].trim_matches('`');
        let has_harness = HARNESSES.iter().any(|(_, claim)| *claim == id);
        let has_reason = NOT_BY_KANI.iter().any(|(claim, _)| *claim == id);
        assert!(
            has_harness != has_reason,
            "{id}: a harness or a reason, not both"
        );
        assert_eq!(
            row[5].contains("Kani"),
            has_harness,
            "{id}: engines of CLAIMS.md"
        );
    }
    for (name, claim) in HARNESSES {
        assert!(
            rows.iter().any(|row| row[1].trim_matches('`') == *claim),
            "{name}"
        );
        // The checker files a harness under the claim that its name begins with.
        let is_named = name.replace('_', "-").starts_with(claim);
        assert!(is_named || *claim == "primitives", "{name}");
    }
}

/// No function stands in for one whose contract Kani sees: an unpatched Kani refuses that, and then runs nothing
/// (model-checking/kani issue 4591).
#[test]
fn no_plain_stub_of_a_function_with_a_contract() {
    let folder = std::path::Path::new("../generated/src");
    let mut contracted = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
        let mut lines = text.lines();
        while lines.any(|line| line.starts_with("#[cfg_attr(kani, kani::")) {
            let name = lines.find_map(|line| line.strip_prefix("pub fn ")).unwrap();
            contracted.push(name.split_once('(').unwrap().0.to_owned());
        }
    }
    assert!(contracted.len() > 10);
    let texts = proofs();
    for text in &texts {
        for line in text.lines() {
            if let Some(rest) = line.strip_prefix("#[kani::stub(") {
                let path = rest.split_once(',').unwrap().0;
                let name = path.rsplit("::").next().unwrap();
                assert!(!contracted.contains(&name.to_owned()), "{line}");
            }
            if let Some(rest) = line.strip_prefix("#[kani::stub_verified(") {
                let name = rest.split_once(')').unwrap().0;
                assert!(contracted.contains(&name.to_owned()), "{line}");
                let own = format!("#[kani::proof_for_contract({name})]");
                assert!(texts.iter().any(|text| text.contains(&own)), "{name}");
            }
        }
    }
}

/// Claim `closed-loop-stable`: a power of the loop's matrix maps every state to a smaller one.
///
/// If ‖Mᵏ‖ < 1 for any k, the spectral radius of M is below 1.
#[test]
fn the_closed_loop_is_stable() {
    let json = &Certificate::read().json;
    let number = |value| rational(value).to_f64().unwrap();
    let gains = ["ANGLE_GAIN", "RATE_GAIN", "WHEEL_SPEED_GAIN"].map(|name| {
        let constant = Certificate::read().constant(name);
        let bits = constant["fraction_bits"].as_i64().unwrap() as i32;
        constant["raw"].as_i64().unwrap() as f64 * 2_f64.powi(-bits)
    });
    let mut power = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            // The constants are −K.
            power[i][j] =
                number(&json["plant"]["Ad"][i][j]) + number(&json["plant"]["Bd"][i]) * gains[j];
        }
    }
    // Squared 20 times: about a million samples.
    for _ in 0..20 {
        let mut square = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                square[i][j] = (0..3).map(|k| power[i][k] * power[k][j]).sum();
            }
        }
        power = square;
    }
    let norm = power.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
    assert!(
        norm < 1.0,
        "the loop's matrix to a large power has norm {norm}"
    );
}
