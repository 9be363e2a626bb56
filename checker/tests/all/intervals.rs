//! The interval analysis never promises less than what happens.

use std::path::Path;

use checker::domains::intervals::{IntegerInterval, every_bit_pattern, ranges};
use checker::program::steps::Program;
use checker::{Machine, Module};
use proptest::prelude::*;
use proptest::test_runner::TestRng;
use rand_core::Rng;

/// Whether the analysis of a box holds at points of the box.
fn holds(program: &Program, domain: &[IntegerInterval], rng: &mut TestRng, points: usize) {
    let Ok(found) = ranges(program, domain) else {
        return;
    };
    let mut machine = Machine::new(program);
    for _ in 0..points {
        let arguments: Vec<i128> = domain
            .iter()
            .map(|interval| {
                let width = interval.high - interval.low;
                match rng.next_u64() % 4 {
                    0 => interval.low,
                    1 => interval.high,
                    _ => interval.low + i128::from(rng.next_u64()) % (width + 1),
                }
            })
            .collect();
        let results = machine
            .call(&arguments)
            .unwrap_or_else(|trap| panic!("{}: {trap} for {arguments:?}", program.name));
        for (result, interval) in results.iter().zip(&found) {
            assert!(
                IntegerInterval::point(*result).is_within(*interval),
                "{}: {result} is not within {interval:?} for {arguments:?}",
                program.name
            );
        }
    }
}

/// A box around a random point, of random size.
fn random_box(program: &Program, rng: &mut TestRng) -> Vec<IntegerInterval> {
    every_bit_pattern(program)
        .into_iter()
        .map(|whole| {
            let width = whole.high - whole.low;
            let size = width >> (rng.next_u64() % 40);
            let low = whole.low + i128::from(rng.next_u64()) % (width - size + 1);
            IntegerInterval::new(low, low + size)
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn of_every_emitted_function(rng in any::<u64>().prop_perturb(|_, rng| rng)) {
        let mut rng = rng;
        let module = Module::read(Path::new("../generated")).unwrap();
        let count = module.declarations().functions.len();
        for number in 0..count {
            let program = module.program(number).unwrap();
            for _ in 0..10 {
                let domain = random_box(program, &mut rng);
                holds(program, &domain, &mut rng, 20);
            }
        }
    }
}

/// What a branch narrows is narrowed on its side alone: behind it the word has its whole range.
#[test]
fn behind_a_branch_the_words_are_whole_again() {
    let text = "pub fn f(a: i16, b: i16) -> (i32, i32) {\n    let c: i16 = if a < b { if b < 5 { b } \
                else { 5 } } else { a };\n    (a as i32 + b as i32, c as i32)\n}\n";
    let module = Module::parse(&[("src/x.rs", text)]).unwrap();
    let box_ = [IntegerInterval::new(-7, 9), IntegerInterval::new(2, 20)];
    let found = ranges(module.function("f").unwrap(), &box_).unwrap();
    // a + b of any a and b; c is b within [2, 4], 5, or a within [2, 9].
    assert_eq!(found[0], IntegerInterval::new(-5, 29));
    assert_eq!(found[1], IntegerInterval::new(2, 9));
}

/// Conditions in every combination, where narrowing decides; all points of small boxes.
#[test]
fn of_conditions() {
    let bodies = [
        "if a < b && b < 5 { b - a } else { a }",
        "if a < b || b < 5 { b } else { a - b }",
        "if !(a < b) && !(b == 3) { a - b } else { b }",
        "if a > 0 && (b > a || b < -a) { b * a } else { 0 }",
        "let x = a - b; if x < 0 && -x < 4 { 10 - x } else { x }",
        "let is = a < 2 && b < a; if is { a } else if a < 2 { b } else { 7 }",
        "let is = a == b || a < -2; if is || b < 0 { a } else { b }",
        "if a * a < 10 && a != b { a * a } else { b }",
        "if a < 3 { if a < b { return b - a; } a } else { (a >> 1) & 3 }",
        "let x = if a < b { a } else { b }; if x < 0 && a < b { x } else { b.clamp(-2, 2) }",
        "let x = if a < 0 && b < 0 { (a, b) } else { (b, a) }; if x.0 < x.1 { x.0 } else { x.1 }",
    ];
    for body in bodies {
        let text = format!("pub fn f(a: i32, b: i32) -> i32 {{ {body} }}");
        let module =
            Module::parse(&[("src/x.rs", &text)]).unwrap_or_else(|e| panic!("{body}: {e}"));
        let program = module.function("f").unwrap();
        let mut machine = Machine::new(program);
        for low_a in -6..6 {
            for low_b in -6..6 {
                for size in 0..7 {
                    let domain = [
                        IntegerInterval::new(low_a, low_a + size),
                        IntegerInterval::new(low_b, low_b + size / 2),
                    ];
                    let found = ranges(program, &domain).unwrap_or_else(|e| panic!("{body}: {e}"));
                    for a in domain[0].low..=domain[0].high {
                        for b in domain[1].low..=domain[1].high {
                            let result = machine.call(&[a, b]).unwrap()[0];
                            assert!(
                                IntegerInterval::point(result).is_within(found[0]),
                                "{body}: {result} for {a}, {b} in {domain:?}: {found:?}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// What cannot be shown is reported with its place.
#[test]
fn findings() {
    let cases = [
        ("a + b", "1:37: the sum of"),
        (
            "if a < 0 { -a } else { a }",
            "the difference of [0, 0] and [-2147483648, -1]",
        ),
        ("a.clamp(b, 5)", "ends may cross"),
        ("(a as i64 * b as i64) as i32", "may lose bits"),
        ("1i32 << b", "the left shift"),
    ];
    for (body, said) in cases {
        let text = format!("pub fn f(a: i32, b: i32) -> i32 {{ {body} }}");
        let module = Module::parse(&[("src/x.rs", &text)]).unwrap();
        let program = module.function("f").unwrap();
        let error = ranges(program, &every_bit_pattern(program))
            .unwrap_err()
            .to_string();
        assert!(error.contains(said), "{body}: {error}");
    }
}
