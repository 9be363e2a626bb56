//! Claim `filter-length`: proved of the emitted source, true of runs of it, refused when damaged.

use std::path::Path;

use checker::claims::filter_length::check::{SquaredNorms, check};
use checker::claims::primitives;
use checker::{Machine, Module};
use num_rational::BigRational;
use proptest::prelude::*;

fn sources() -> Vec<(String, String)> {
    checker::language::module::sources(Path::new("../generated")).unwrap()
}

fn module(sources: &[(String, String)]) -> Module {
    let borrowed: Vec<_> = sources
        .iter()
        .map(|(path, text)| (path.as_str(), text.as_str()))
        .collect();
    Module::parse(&borrowed).unwrap()
}

fn lengths(module: &Module) -> Result<SquaredNorms, String> {
    check(module, &primitives::proved(&primitives::primitives(module)))
}

/// 1 + `distance`, which is a double and so exact.
fn beside_one(distance: f64) -> BigRational {
    BigRational::from_float(1.0 + distance).unwrap()
}

/// The largest error of q S(ε) is (1 + ε) S² − 1 = 5ε³/8 − 15ε⁴/64 + 9ε⁵/64 at the longest sum,
/// ε = 3/64 + 2⁻¹¹ + …: 6.6e-5. The proved bound is therefore at least the largest error that was
/// found, and not far above that error. The range is taken term by term, so that −15ε⁴/64 = −1.2e-6
/// counts in full below.
#[test]
fn is_proved_and_tight() {
    let found = lengths(&module(&sources())).unwrap();
    let (least, most) = found.after_step;
    assert!(
        beside_one(6.6e-5) < most && most < beside_one(7.0e-5),
        "{most}"
    );
    assert!(beside_one(-1.3e-6) < least, "{least}");
    let (least, most) = found.after_alignment;
    assert!(beside_one(-2.5e-4) < least && most < beside_one(2.5e-4));
}

/// The largest β T that the generator takes, 2⁻⁸, is still proved; sixteen times that is not.
#[test]
fn holds_up_to_a_large_beta() {
    let with_beta = |word: &str| {
        let mut sources = sources();
        let (_, constants) = sources
            .iter_mut()
            .find(|(path, _)| path == "src/constants.rs")
            .unwrap();
        let changed = constants.replace("beta: 1_133_871", &format!("beta: {word}"));
        assert_ne!(changed, *constants);
        *constants = changed;
        lengths(&module(&sources))
    };
    with_beta("134_217_728").unwrap();
    let refusal = with_beta("2_147_483_647").unwrap_err();
    // By the length's own bound, or before it by the contract of the turn about the vertical, which β T limits.
    let names_beta = refusal.contains("β times the sample time");
    assert!(
        names_beta || refusal.contains("its contract allows"),
        "{refusal}"
    );
}

/// Damage that keeps every range but not the length.
#[test]
fn damage_is_refused() {
    let cases = [
        // A sign of the quaternion product.
        (
            "src/madgwick.rs",
            "w * a + y * c - z * b -",
            "w * a - y * c - z * b -",
        ),
        // A swapped axis.
        (
            "src/madgwick.rs",
            "w * b + z * a - x * c -",
            "w * b + z * b - x * c -",
        ),
        // The correction of another component.
        (
            "src/madgwick.rs",
            "- correction.direction[3] as i64 * gain",
            "- correction.direction[2] as i64 * gain",
        ),
        // 3ε²/8 halved, and its sign.
        (
            "src/madgwick.rs",
            "(square + (square >> 1) - half)",
            "((square >> 1) + half)",
        ),
        (
            "src/madgwick.rs",
            "let half = excess * 16;",
            "let half = excess * 8;",
        ),
        (
            "src/madgwick.rs",
            "squared - 0x0800_0000",
            "squared - 0x07f0_0000",
        ),
        // A component left out of the length.
        (
            "src/madgwick.rs",
            "+ (mul_high(q[3], q[3]) >> 1);\n    // ε",
            "+ (mul_high(q[2], q[2]) >> 1);\n    // ε",
        ),
        // A gain without the length.
        (
            "src/madgwick.rs",
            "gain: mul_high(inverse, beta),",
            "gain: beta,",
        ),
        (
            "src/madgwick.rs",
            "clamp(squared, 0, 0x0fff_ffff) * 4",
            "clamp(squared, 0, 0x0fff_ffff)",
        ),
        // An alignment of twice or half the length.
        (
            "src/madgwick.rs",
            "clamp(unit[1] * 2, -",
            "clamp(unit[1], -",
        ),
        (
            "src/madgwick.rs",
            "return [0, ONE, 0, 0];",
            "return [ONE, ONE, 0, 0];",
        ),
        (
            "src/madgwick.rs",
            "is_within(turn[0], 0x4_0000)",
            "is_within(turn[0], 0x0_1000)",
        ),
        // Seeds and steps of the inverse root, coarse and fine.
        ("src/root.rs", "1_696_124_550", "1_666_124_550"),
        (
            "src/root.rs",
            "refined(n * 2, refined(n * 2, seed(n)))",
            "seed(n)",
        ),
        // A clamp that picks the wrong end, a start that is no unit quaternion.
        (
            "src/product.rs",
            "value < low {\n        low",
            "value < low {\n        high",
        ),
        (
            "src/filter.rs",
            "quaternion: [ONE, 0, 0, 0]",
            "quaternion: [ONE, ONE, 0, 0]",
        ),
        // A vector that is not scaled up far enough.
        (
            "src/scaling.rs",
            "lift3(lift3(long, 0x1000_0000, 4), SCALED_MIN, 2)",
            "lift3(long, 0x1000_0000, 4)",
        ),
    ];
    // The contracts of the primitives stand as they were; the length is to notice by itself.
    let contracts = primitives::proved(&primitives::primitives(&module(&sources())));
    for (file, from, to) in cases {
        let mut sources = sources();
        let (_, text) = sources.iter_mut().find(|(path, _)| path == file).unwrap();
        assert!(text.contains(from), "{file} has no `{from}`");
        *text = text.replacen(from, to, 1);
        let found = check(&module(&sources), &contracts);
        println!("{from} -> {to}: {:?}", found.as_ref().err());
        assert!(found.is_err(), "{file}: `{from}` -> `{to}` is accepted");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Runs of `Attitude::update_imu` and `align` keep the proved lengths from the second step on,
    /// whatever the readings.
    #[test]
    fn runs_keep_the_proved_length(
        readings in prop::collection::vec(
            (prop::array::uniform3(any::<i16>()), prop::array::uniform3(any::<i16>()), 0..8u8),
            1..40,
        ),
    ) {
        thread_local! {
            static PROVED: (Module, SquaredNorms) = {
                let module = module(&sources());
                let lengths = lengths(&module).unwrap();
                (module, lengths)
            };
        }
        PROVED.with(|(module, lengths)| {
            let mut step = Machine::new(module.function("Attitude::update_imu").unwrap());
            let mut align = Machine::new(module.function("Attitude::align").unwrap());
            let mut new = Machine::new(module.function("Attitude::new").unwrap());
            let mut state = new.call(&[]).unwrap().to_vec();
            for (gyro, accel, kind) in readings {
                let mut arguments = state.clone();
                let is_alignment = kind == 0;
                if !is_alignment {
                    arguments.extend(gyro.map(i128::from));
                }
                arguments.extend(accel.map(i128::from));
                let machine = if is_alignment { &mut align } else { &mut step };
                let results = machine.call(&arguments).unwrap();
                state = results[results.len() - state.len()..].to_vec();
                let squared: i128 = state[..4].iter().map(|word| word * word).sum();
                let squared = BigRational::new(squared.into(), (1_i128 << 60).into());
                let (step, alignment) = (&lengths.after_step, &lengths.after_alignment);
                prop_assert!((&step.0).min(&alignment.0) <= &squared);
                prop_assert!(&squared <= (&step.1).max(&alignment.1));
            }
            Ok(())
        })?;
    }
}
