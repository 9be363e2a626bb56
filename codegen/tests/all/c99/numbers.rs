//! The numbers of the emitted Rust and of its C, read by two readers that the translation does not use: a function
//! or a constant of the C has the numbers of that of the Rust, each as often. So a number that is damaged in the C is
//! noticed even where no answer of the controller shows it: the last bit of a polynomial's coefficient.

use std::collections::BTreeMap;

use codegen::EmittedCrate;
use syn::visit::{self, Visit};

/// The numbers of each function and constant, by its name in C. Those of a constant stand in their order.
type Numbers = BTreeMap<String, Vec<u64>>;

/// Functions of the C that no function of the Rust stands for, with their numbers.
const OWN: [(&str, &[u64]); 1] = [("clamp_64", &[])];

/// The numbers of an emitted crate, to which those of its C are compared.
pub struct Expected(Numbers);

impl Expected {
    pub fn of(emitted: &EmittedCrate) -> Expected {
        Expected(of_rust(emitted))
    }

    /// The first function or constant of the C whose numbers are not those of the Rust.
    pub fn difference(&self, header: &str, source: &str) -> Option<String> {
        let c = of_c(&format!("{header}\n{source}"));
        assert!(
            c.len() > 40,
            "the C has {} functions and constants",
            c.len()
        );
        c.into_iter().find_map(|(name, found)| {
            if let Some((_, expected)) = OWN.iter().find(|(own, _)| *own == name) {
                return (found != *expected).then(|| format!("{name}: {found:?}"));
            }
            match self.0.get(&name) {
                None => Some(format!("{name}: the Rust has no such function or constant")),
                Some(expected) if *expected == found => None,
                Some(expected) => Some(format!("{name}: {found:?}, in the Rust {expected:?}")),
            }
        })
    }
}

// --- Rust ---

fn of_rust(emitted: &EmittedCrate) -> Numbers {
    let mut numbers = Numbers::new();
    for file in &emitted.files {
        let Some(module) = file
            .path
            .strip_prefix("src/")
            .and_then(|path| path.strip_suffix(".rs"))
        else {
            continue;
        };
        for item in syn::parse_file(&file.contents).expect("Rust").items {
            match item {
                syn::Item::Fn(item) => {
                    let name = c_name(module, None, &item.sig.ident.to_string());
                    numbers.insert(name, of_block(&item.block));
                }
                // The number of fraction bits of a word of the law.
                syn::Item::Type(item) if module == "control" => {
                    let syn::Type::Path(path) = &*item.ty else {
                        panic!("a word that is no path");
                    };
                    let ty = path.path.segments.last().expect("a name").ident.to_string();
                    let bits = ty.split_once('F').expect("a type of fixed").1;
                    let mut name = "FLYWHEEL".to_owned();
                    for letter in item.ident.to_string().chars() {
                        if letter.is_ascii_uppercase() {
                            name.push('_');
                        }
                        name.push(letter.to_ascii_uppercase());
                    }
                    let bits = vec![bits.parse().expect("a number of bits")];
                    numbers.insert(name + "_FRACTION_BITS", bits);
                }
                syn::Item::Const(item) => {
                    let own = item.ident.to_string();
                    let name = match module {
                        "constants" | "control" => format!("FLYWHEEL_{own}"),
                        _ => format!("{}_{own}", module.to_uppercase()),
                    };
                    let mut found = Found::default();
                    found.visit_expr(&item.expr);
                    numbers.insert(name, found.0);
                }
                syn::Item::Impl(item) => {
                    let syn::Type::Path(owner) = &*item.self_ty else {
                        continue;
                    };
                    let owner = owner.path.segments[0].ident.to_string();
                    for inner in &item.items {
                        if let syn::ImplItem::Fn(function) = inner {
                            let own = function.sig.ident.to_string();
                            let name = c_name(module, Some(&owner), &own);
                            numbers.insert(name, of_block(&function.block));
                        }
                    }
                }
                _ => {}
            }
        }
    }
    numbers
}

/// As the header documents it: what a firmware calls begins with `flywheel`, the rest with its module or its type.
fn c_name(module: &str, owner: Option<&str>, own: &str) -> String {
    match (owner, own) {
        (Some("Controller"), "new") => "flywheel_init".to_owned(),
        (
            Some("Controller"),
            "arm" | "disarm" | "step" | "step_with_current" | "status" | "fault" | "angle" | "rate",
        )
        | (Some("Attitude"), "angle" | "rate" | "quaternion")
        | (None, "control" | "wheel_speed") => format!("flywheel_{own}"),
        (Some("Encoder"), "new") => "flywheel_encoder_init".to_owned(),
        (Some("Encoder"), "update" | "turned") => format!("flywheel_encoder_{own}"),
        (Some(owner), _) => format!("{}_{own}", owner.to_lowercase()),
        (None, _) if own.starts_with(module) => own.to_owned(),
        (None, _) => format!("{module}_{own}"),
    }
}

fn of_block(block: &syn::Block) -> Vec<u64> {
    let mut found = Found::default();
    found.visit_block(block);
    found.0.sort_unstable();
    found.0
}

/// Numbers and booleans, but for indices, lengths of types and attributes.
#[derive(Default)]
struct Found(Vec<u64>);

impl Visit<'_> for Found {
    fn visit_lit(&mut self, literal: &syn::Lit) {
        match literal {
            syn::Lit::Int(number) => self.0.push(number.base10_parse().expect("a number")),
            syn::Lit::Bool(value) => self.0.push(u64::from(value.value)),
            _ => {}
        }
    }

    fn visit_expr_index(&mut self, index: &syn::ExprIndex) {
        self.visit_expr(&index.expr);
    }

    fn visit_type(&mut self, _: &syn::Type) {}

    fn visit_attribute(&mut self, _: &syn::Attribute) {}

    fn visit_expr_repeat(&mut self, repeat: &syn::ExprRepeat) {
        // C writes the element once for each place.
        let syn::Expr::Lit(length) = &*repeat.len else {
            panic!("a length that is no number");
        };
        let syn::Lit::Int(length) = &length.lit else {
            panic!("a length that is no number");
        };
        for _ in 0..length.base10_parse::<usize>().expect("a length") {
            self.visit_expr(&repeat.expr);
        }
    }

    fn visit_expr_unary(&mut self, unary: &syn::ExprUnary) {
        // C has no −2³¹: it writes −(2³¹ − 1) − 1.
        if let syn::Expr::Lit(inner) = &*unary.expr
            && let syn::Lit::Int(number) = &inner.lit
            && number
                .base10_parse()
                .is_ok_and(|value: u64| value == 1 << 31)
        {
            self.0.extend([(1 << 31) - 1, 1]);
            return;
        }
        visit::visit_expr_unary(self, unary);
    }
}

// --- C ---

fn of_c(text: &str) -> Numbers {
    let text = without_comments(text);
    let mut numbers = Numbers::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(define) = line.strip_prefix("#define ") {
            if let Some((name, value)) = define.split_once(' ') {
                numbers.insert(name.to_owned(), of_text(value));
            }
            continue;
        }
        let is_constant = line.starts_with("static const ") && line.contains(" = ");
        let is_function = !line.starts_with([' ', '#', '}', '/', 't']) && line.contains('(');
        if is_constant {
            let mut value = line.to_owned();
            while !value.trim_end().ends_with(';') {
                value += lines.next().expect("the constant's end");
            }
            let (head, value) = value.split_once(" = ").expect("a value");
            let head = head.split('[').next().unwrap_or_default();
            let name = head.rsplit(' ').next().unwrap_or_default();
            numbers.insert(name.to_owned(), of_text(value));
        } else if is_function {
            let mut head = line.to_owned();
            while !head.ends_with(['{', ';']) {
                head += lines.next().expect("the head's end");
            }
            if head.ends_with(';') {
                continue;
            }
            let before = head.split('(').next().unwrap_or_default();
            let name = before
                .rsplit([' ', '*'])
                .next()
                .unwrap_or_default()
                .to_owned();
            let body: Vec<&str> = lines.by_ref().take_while(|line| *line != "}").collect();
            let mut found = of_text(&body.join("\n"));
            found.sort_unstable();
            numbers.insert(name, found);
        }
    }
    numbers
}

fn without_comments(text: &str) -> String {
    let mut rest = text;
    let mut out = String::new();
    while let Some((before, after)) = rest.split_once("/*") {
        out.push_str(before);
        rest = after.split_once("*/").map_or("", |(_, after)| after);
    }
    out + rest
}

/// The numbers of a text, but for indices.
fn of_text(text: &str) -> Vec<u64> {
    let mut found = Vec::new();
    let mut characters = text.char_indices().peekable();
    let mut depth = 0;
    while let Some((start, first)) = characters.next() {
        match first {
            '[' => depth += 1,
            ']' => depth -= 1,
            _ => {}
        }
        if !(first.is_ascii_alphanumeric() || first == '_') {
            continue;
        }
        let mut end = start + 1;
        while let Some((at, next)) = characters.peek().copied() {
            if !(next.is_ascii_alphanumeric() || next == '_') {
                break;
            }
            end = at + 1;
            characters.next();
        }
        let word = &text[start..end];
        if first.is_ascii_digit() && depth == 0 {
            let word = word.trim_end_matches(['u', 'U', 'l', 'L']);
            let number = match word.strip_prefix("0x") {
                Some(digits) => u64::from_str_radix(digits, 16),
                None => word.parse(),
            };
            // What cannot be read is no number of the Rust.
            found.push(number.unwrap_or(u64::MAX));
        }
    }
    found
}
