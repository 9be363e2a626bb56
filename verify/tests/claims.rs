//! Every claim of the certificate is settled somewhere, and every harness settles a claim.

mod certificate;

use certificate::{Certificate, rational};
use num_traits::ToPrimitive;

/// Where a claim is settled besides the tests of this crate.
#[derive(PartialEq)]
enum Engine {
    /// A harness of `src/proofs.rs` that is called like the claim.
    Kani,
    /// Exact arithmetic on the certificate; no statement about code that Kani could settle.
    ExactArithmetic,
}

const CLAIMS: &[(&str, Engine)] = &[
    ("control-total", Engine::Kani),
    ("control-accurate", Engine::Kani),
    ("control-accurate-real-gains", Engine::ExactArithmetic),
    ("closed-loop-stable", Engine::ExactArithmetic),
];

#[test]
fn every_claim_has_an_engine_and_every_harness_a_claim() {
    let certificate = Certificate::read();
    let stated = certificate.json["claims"].as_array().unwrap();
    let stated: Vec<_> = stated.iter().map(|c| c["id"].as_str().unwrap()).collect();
    let settled: Vec<_> = CLAIMS.iter().map(|(claim, _)| *claim).collect();
    assert_eq!(stated, settled);

    let mut harnesses = Vec::new();
    let mut lines = include_str!("../src/proofs.rs").lines();
    while lines.any(|line| line.starts_with("#[kani::proof")) {
        let name = lines.find_map(|line| line.strip_prefix("fn ")).unwrap();
        harnesses.push(name.split_once('(').unwrap().0.replace('_', "-"));
    }
    let by_kani: Vec<_> = CLAIMS
        .iter()
        .filter(|(_, engine)| *engine == Engine::Kani)
        .map(|(claim, _)| (*claim).to_owned())
        .collect();
    assert_eq!(harnesses, by_kani);
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
