//! Whatever is not in the language is refused with its place.

use checker::certificate::reader::Certificate;
use checker::prove::{Emitted, settle};
use checker::{ClaimOutcome, Machine, Module, ProofSettings};

use crate::folders::copied;

fn refused(body: &str) -> String {
    let text = format!("pub fn f(a: i32, b: i32) -> i32 {{\n    {body}\n}}\n");
    match Module::parse(&[("src/x.rs", &text)]) {
        Ok(_) => panic!("understood: {body}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn constructs_outside_the_language() {
    let cases = [
        ("a / b", "2:7: found `/`"),
        ("a % b", "2:7"),
        ("a ^ b", "2:7"),
        ("a | b", "2:7"),
        ("loop {}", "2:5: found `loop {}`"),
        ("while a < b {} a", "2:5"),
        ("for i in 0..3 {} a", "2:5"),
        ("a.wrapping_add(b)", "2:7: found `.wrapping_add()`"),
        ("a.abs()", "found `.abs()`"),
        ("a as f32 as i32", "found the type `f32`"),
        ("1.5", "found `1.5`"),
        ("unsafe { a }", "2:5"),
        ("panic!()", "2:5"),
        ("let x = |y: i32| y; x(a)", "2:13"),
        ("g(a)", "`g` is no function"),
        ("let x = a; y", "`y` is not known"),
        ("a + (b as i64)", "a i32 is expected, found a i64"),
        (
            "if a < b { a } else { true }",
            "a i32 is expected, found a bool",
        ),
        ("f(a, b)", "calls itself"),
        ("5_000_000_000", "is no i32"),
        ("let [x, y] = [a, b]; x", "2:9"),
        ("[a, b][2]", "a literal below 2"),
        ("[a, b][a]", "a literal below 2"),
        ("a as i128 as i32", "128 bits stand in assertions only"),
        ("a; b", "its value is not used"),
        ("(a, b)", "returns a i32"),
        // What `cfg` takes away is no code, and a `return` ends more than its block.
        ("#[cfg(any())] let a = b; a", "an attribute stands here"),
        ("let x = #[cfg(any())] a; x", "an attribute stands here"),
        ("let x = if a < b { return a; } else { b }; x + 1", "return"),
        ("let x = { if a < b { return a; } b }; x + 1", "return"),
        ("(if a < b { return a; } else { b }) + 1", "return"),
        ("if { return a; } { b } else { a }", "return"),
        // Rust takes numbers whose type nothing states for i32, whatever they are cast to.
        (
            "(1 << 31) as i64 as i32",
            "2:6: the type of `1` is not stated",
        ),
        ("(1 + 2) as i64 as i32", "the type of `1` is not stated"),
        ("a << (1 << 3)", "the type of `1` is not stated"),
        ("a + (1 << 3)", "the type of `1` is not stated"),
        ("if 1 < 2 { a } else { b }", "the type of `1` is not stated"),
        (
            "let x = (if a < b { 1 } else { 2 }) as i64; x as i32",
            "is not clear",
        ),
        ("<i32>::MAX", "through a type"),
        ("::i32::MAX", "begins with `::`"),
        ("i32::<>::MAX", "arguments"),
        ("a.clamp::<>(b, b)", "arguments of types"),
        ("'x: { a }", "2:5: found `\\'`"),
        ("r#a + b", "2:5: found `r#`"),
        ("a \u{2212} b", "2:7: found `\\u{2212}`"),
        ("\u{e4}", "2:5: found `\\u{e4}`"),
        ("a /* b */", "2:7: found `/`"),
        ("0b1 + a", "found `0b1`"),
        ("match Some(a) { Some(x @ y) => x, None => b }", "found `@`"),
    ];
    for (body, said) in cases {
        let message = refused(body);
        assert!(message.starts_with("src/x.rs:"), "{body}: {message}");
        assert!(message.contains(said), "{body}: {message}");
    }
}

#[test]
fn items_outside_the_language() {
    let cases = [
        ("pub fn f<T>(a: T) -> i32 { 1 }", "nothing is generic"),
        ("static X: i32 = 1;", "found `static X"),
        (
            "pub enum E { A }",
            "a variant has no fields and the value 0",
        ),
        ("pub enum E { A = 0, B = 2 }", "the value 1"),
        ("pub enum E { A(i32) = 0 }", "no fields"),
        ("pub enum E<T> { A = 0 }", "nothing is generic"),
        ("pub union U { a: i32, b: u32 }", "found `pub union"),
        ("pub type A = fixed::types::I16F15;", "x + y = 32"),
        ("pub type A = i32;", "fixed::types::IxFy"),
        ("pub use law::r#control;", "found `r#`"),
        ("fn \u{434}() -> i32 { 1 }", "found `\\u{434}`"),
        (
            "// \u{202e} hidden\nfn f() -> i32 { 1 }",
            "what is not seen",
        ),
        ("#![doc = include_str!(\"x\")]", "not an attribute"),
        (
            "fn f(a: &mut i32) -> i32 { 1 }",
            "only a receiver is `&mut`",
        ),
        (
            "struct X { a: i32 } impl X { fn f(self: &mut Self) { self.a = 1; } }",
            "a receiver is",
        ),
        (
            "struct X { a: i32 } impl X { fn f(mut self) -> i32 { self.a } }",
            "a receiver is",
        ),
        ("use core::mem::swap;", "is not known in this crate"),
        ("#[cfg(test)] pub fn f() -> i32 { 1 }", "not an attribute"),
        ("const X: i32 = X;", "a constant that needs itself"),
        (
            "const X: i32 = i32::MAX + 1;",
            "the sum of 2147483647 and 1 overflows",
        ),
        ("const _: () = { assert!(1 < 1i32, \"no\"); };", "assertion"),
        ("fn f() -> i32 { 1 } fn f() -> i32 { 2 }", "defined twice"),
        ("impl Clone for X {}", "only `Default`"),
        ("fn (", "no Rust"),
        ("pub mod y;", "modules are declared in src/lib.rs"),
        ("macro_rules! m { () => {} }", "found `macro_rules!"),
        ("unsafe fn f() -> i32 { 1 }", "functions are plain"),
        (
            "fn f(#[cfg(any())] a: i32) -> i32 { 1 }",
            "an attribute stands here",
        ),
        ("fn f(ref a: i32) -> i32 { 1 }", "binds more than a name"),
        ("type i32 = fixed::types::I3F29;", "has a meaning in Rust"),
        ("struct Option { a: i32 }", "has a meaning in Rust"),
        ("#[derive(Hash)] struct X { a: i32 }", "not an attribute"),
        (
            "#[cfg_attr(kani, kani::requires(true), cfg(any()))] fn f() -> i32 { 1 }",
            "not an attribute",
        ),
        (
            "#[cfg_attr(any(kani), kani::requires(true))] fn f() -> i32 { 1 }",
            "not an attribute",
        ),
        (
            "#[cfg_attr(all(), kani::requires(true))] fn f() -> i32 { 1 }",
            "not an attribute",
        ),
        (
            "#[cfg_attr(any(), path = \"x\")] fn f() -> i32 { 1 }",
            "not an attribute",
        ),
        (
            "struct X { pub a: i32 } impl X { fn f(&mut self) { self.a = 1; } }",
            "a field that others can write",
        ),
        (
            "struct X { a: i32 } impl X { fn f(&self) -> i32 { 1 } } impl X { fn f(&self) -> i32 { 2 } }",
            "defined twice",
        ),
        (
            "struct X { a: i32 } fn f(x: X) -> X { X { a: 1, ..x } }",
            "all its fields",
        ),
    ];
    for (text, said) in cases {
        match Module::parse(&[("src/x.rs", text)]) {
            Ok(_) => panic!("understood: {text}"),
            Err(error) => assert!(error.to_string().contains(said), "{text}: {error}"),
        }
    }
}

/// Overflows are found where Rust would panic, and where it would silently lose bits.
#[test]
fn traps() {
    let cases = [
        (
            "a + b",
            [i32::MAX, 1],
            "the sum of 2147483647 and 1 overflows",
        ),
        ("a - b", [i32::MIN, 1], "the difference"),
        ("-a", [i32::MIN, 0], "the difference of 0 and -2147483648"),
        ("a * b", [1 << 16, 1 << 15], "the product"),
        ("a << b", [1, 32], "the left shift"),
        ("a << b", [3, 31], "the left shift"),
        ("a >> b", [1, -1], "the right shift"),
        (
            "(a as i64 * b as i64) as i32",
            [1 << 16, 1 << 15],
            "loses bits",
        ),
        ("a.clamp(b, -b)", [0, 1], "clamp to [1, -1]"),
    ];
    for (body, arguments, said) in cases {
        let text = format!("pub fn f(a: i32, b: i32) -> i32 {{ {body} }}");
        let module = Module::parse(&[("src/x.rs", &text)]).unwrap();
        let program = module.function("f").unwrap();
        let error = Machine::new(program)
            .call(&arguments.map(i128::from))
            .unwrap_err()
            .to_string();
        assert!(error.contains(said), "{body}: {error}");
    }
    let text = "pub fn f(a: i32) -> i32 { a }";
    let module = Module::parse(&[("src/x.rs", text)]).unwrap();
    let mut machine = Machine::new(module.function("f").unwrap());
    assert!(machine.call(&[1 << 40]).is_err());
    assert!(machine.call(&[1, 2]).is_err());
}

/// What the language can do, each with its result for (7, -3).
#[test]
fn expressions() {
    let cases = [
        ("if a > b { return b; } a", -3),
        ("let (x, y) = (a, b); y - x", -10),
        ("let v = [a, b]; v[1] * v[0]", -21),
        ("if a < 0 || b < 0 { 1 } else { 0 }", 1),
        ("if a < 0 && (a >> 40) == 0 { 1 } else { 0 }", 0),
        ("if !(a == b) && a != b { 1 } else { 0 }", 1),
        ("(b >> 1) & 1", 0),
        ("let mut x = a; if b < 0 { x = x + 1; } x", 8),
        (
            "let x: i64 = (1_i64 << (2_u32 + 3)) * (a as i64); x as i32",
            224,
        ),
        ("i64::from(a) as i32 + (1i64 << 3) as i32", 15),
        ("(0x10 - a) * -2", -18),
        ("match Some(a) { Some(x) => x, None => b }", 7),
    ];
    for (body, expected) in cases {
        let text = format!("pub fn f(a: i32, b: i32) -> i32 {{ {body} }}");
        let module =
            Module::parse(&[("src/x.rs", &text)]).unwrap_or_else(|error| panic!("{body}: {error}"));
        let mut machine = Machine::new(module.function("f").unwrap());
        assert_eq!(machine.call(&[7, -3]).unwrap(), [expected], "{body}");
    }
}

#[test]
fn the_root_declares_every_file_and_forbids_unsafe() {
    let good = "#![no_std]\n#![forbid(unsafe_code)]\npub mod x;\npub use x::f;\n";
    let x = "pub fn f(a: i32) -> i32 { a }";
    let read = |root: &str| {
        let files = [("src/lib.rs", root), ("src/x.rs", x)];
        Module::parse(&files).map_err(|error| error.to_string())
    };
    assert!(read(good).is_ok());
    let cases = [
        ("#![no_std]\n", "", "`#![no_std]` is missing"),
        (
            "#![forbid(unsafe_code)]\n",
            "",
            "`#![forbid(unsafe_code)]` is missing",
        ),
        ("unsafe_code", "missing_docs", "is missing"),
        ("pub mod x;\n", "", "a file of no module"),
        ("pub mod", "mod", "is not public"),
        ("pub use", "use", "is not public"),
        (
            "pub mod x",
            "#[path = \"y.rs\"] pub mod x",
            "not an attribute",
        ),
    ];
    for (from, to, said) in cases {
        match read(&good.replace(from, to)) {
            Ok(_) => panic!("understood without {from}"),
            Err(message) => assert!(message.contains(said), "{from}: {message}"),
        }
    }
    // An import does not silently take the place of what is defined.
    let two = [
        ("src/x.rs", "use super::y::f; pub fn f(a: i32) -> i32 { a }"),
        ("src/y.rs", "pub fn f(a: i32) -> i32 { a + 1 }"),
    ];
    let error = Module::parse(&two).unwrap_err().to_string();
    assert!(error.contains("defined twice"), "{error}");
}

#[test]
fn files_that_would_be_built_along_are_refused() {
    let folder = copied("../generated");
    let strays = || Emitted::read(folder.path()).unwrap().strays;
    assert_eq!(strays(), [""; 0]);
    std::fs::write(folder.path().join("build.rs"), "fn main() {}").unwrap();
    std::fs::create_dir(folder.path().join("src/bin")).unwrap();
    assert_eq!(strays(), ["build.rs", "src/bin"]);
    let emitted = Emitted::read(folder.path()).unwrap();
    let certificate = Certificate::parse(&emitted.certificate).unwrap();
    let settings = ProofSettings {
        cases: 10,
        compiled: false,
        smt: false,
        kani: false,
        closed_loop: false,
        python: false,
        filter_length: false,
        ..ProofSettings::default()
    };
    let results = settle(&emitted, &certificate, &settings);
    let ClaimOutcome::Failed(why) = &results[0].outcome else {
        panic!("{:?}", results[0]);
    };
    assert!(why.contains("build.rs"), "{why}");
    for name in ["benches", "examples", "tests"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
        assert!(strays().contains(&name.to_owned()), "{name}");
    }
}
