//! The compiled law against the exact one and against its own words.

use crate::compiled::{CompiledLaw, word_law};
use nalgebra::RowVector3;
use proptest::prelude::*;
use simulate::{ExactLaw, Law, Measured};

/// The gains that the emitted law states to be rounded from.
fn exact() -> ExactLaw {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../generated");
    let certificate = checker::certificate::Certificate::read(&folder).unwrap();
    let gain = |index: usize| certificate.gains[index].text.parse::<f64>().unwrap();
    ExactLaw {
        gains: RowVector3::new(gain(0), gain(1), gain(2)),
        limit_a: 2.0,
    }
}

thread_local! {
    static EXACT: ExactLaw = exact();
}

proptest! {
    /// Within the stated ranges the emitted law is off by less than a tenth of a microampere
    /// from rounding its gains and as much from rounding the state.
    #[test]
    fn the_emitted_law_is_the_exact_one_rounded(
        angle_rad in -3.1..3.1_f64,
        rate_rad_s in -35.0..35.0_f64,
        wheel_speed_rad_s in -700.0..700.0_f64,
    ) {
        let measured = Measured { angle_rad, rate_rad_s, wheel_speed_rad_s };
        let one = EXACT.with(|exact| exact.clone().command_a(&measured)).unwrap();
        let other = CompiledLaw.command_a(&measured).unwrap();
        prop_assert!((one - other).abs() < 2e-7, "{one} {other}");
    }
}

proptest! {
    #[test]
    fn words_are_converted_as_the_compiled_law_converts_them(
        angle_rad in -6.0..6.0_f64,
        rate_rad_s in -100.0..100.0_f64,
        wheel_speed_rad_s in -2000.0..2000.0_f64,
    ) {
        let measured = Measured { angle_rad, rate_rad_s, wheel_speed_rad_s };
        let one = CompiledLaw.command_a(&measured).unwrap();
        prop_assert_eq!(one, word_law().command_a(&measured).unwrap());
    }
}

#[test]
fn values_beyond_every_format_still_give_the_limit() {
    let measured = Measured {
        angle_rad: 1e300,
        rate_rad_s: 1e300,
        wheel_speed_rad_s: 1e300,
    };
    // Falling forward: positive current drives the body backward.
    assert_eq!(CompiledLaw.command_a(&measured).unwrap(), 2.0);
    assert_eq!(word_law().command_a(&measured).unwrap(), 2.0);
    let not_a_number = Measured {
        angle_rad: f64::NAN,
        ..measured
    };
    assert!(CompiledLaw.command_a(&not_a_number).is_err());
    assert!(word_law().command_a(&not_a_number).is_err());
}
