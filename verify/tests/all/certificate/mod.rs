//! `certificate.json` of the emitted crate, read for the tests.

use std::path::Path;
use std::sync::LazyLock;

use num_bigint::BigInt;
use num_rational::BigRational;
use serde_json::Value;

/// `certificate.json` of the emitted crate.
pub struct Certificate {
    pub json: Value,
}

impl Certificate {
    pub fn read() -> &'static Self {
        static CERTIFICATE: LazyLock<Certificate> = LazyLock::new(Certificate::load);
        &CERTIFICATE
    }

    fn load() -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../generated/certificate.json");
        let text = std::fs::read_to_string(path).unwrap();
        Self {
            json: serde_json::from_str(&text).unwrap(),
        }
    }

    pub fn constant(&self, name: &str) -> &Value {
        let constants = self.json["constants"].as_array().unwrap();
        constants.iter().find(|c| c["name"] == name).unwrap()
    }
}

/// A decimal string, with or without exponent, exactly.
pub fn rational(text: &Value) -> BigRational {
    let text = text.as_str().unwrap();
    let (mantissa, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits: BigInt = format!("{whole}{fraction}").parse().unwrap();
    let power = exponent.parse::<i32>().unwrap() - fraction.len() as i32;
    BigRational::from(digits) * BigRational::from(BigInt::from(10)).pow(power)
}
