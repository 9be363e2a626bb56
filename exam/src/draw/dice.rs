//! Random draws that several files use.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A number whose logarithm is uniform.
pub fn log_uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    (rng.random_range(low.ln()..high.ln())).exp()
}

/// 1 or −1.
pub fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_bool(0.5) { 1.0 } else { -1.0 }
}
