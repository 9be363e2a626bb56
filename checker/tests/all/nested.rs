//! The time for nested branches and long expressions grows with their length, not with the number of paths through them.

use checker::domains::intervals::{every_bit_pattern, ranges};
use checker::{Machine, Module};

/// To follow 2⁶⁰ paths one by one would take centuries.
const DEPTH: usize = 60;

#[test]
fn deep_branches() {
    // Every branch lies inside the one before.
    let inside = (0..DEPTH).rev().fold("x".to_owned(), |rest, k| {
        format!("if x < {k} {{ x }} else {{ {rest} }}")
    });
    // Every branch follows the one before, and its condition depends on earlier results.
    let mut after = String::new();
    for k in 0..DEPTH {
        after.push_str(&format!(
            "let y = if y < {k} && (x < y || y == {k}) {{ x }} else {{ y }};\n"
        ));
    }
    // Every branch returns.
    let returning: String = (0..DEPTH)
        .map(|k| format!("if x == {k} {{ return y; }}\n"))
        .collect();
    // The reader looks for the type of such an operand on both sides of the operator.
    let sum = (0..DEPTH).fold("x".to_owned(), |rest, k| format!("((y & {k}) + {rest})"));
    let bodies = [
        inside,
        format!("{after} y"),
        format!("{returning} x"),
        format!("(({sum} as i64) & 7_i64) as i32"),
    ];
    for body in bodies {
        let text = format!("pub fn f(x: i32, y: i32) -> i32 {{ {body} }}");
        let module =
            Module::parse(&[("src/x.rs", &text)]).unwrap_or_else(|e| panic!("{e}: {body}"));
        let program = module.function("f").unwrap();
        assert!(program.len() < 20 * DEPTH, "{} steps", program.len());
        // A sum that may overflow is a legitimate result; only the time counts here.
        let _ = ranges(program, &every_bit_pattern(program));
        assert!(Machine::new(program).call(&[3, 5]).is_ok(), "{body}");
    }
}
