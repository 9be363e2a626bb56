//! A program that calls the public functions of an emitted crate with words from its input.
//!
//! A line of input is the number of a call and the words of its arguments; a line of output
//! is the words of the result. For structs with private fields, one object of each is kept between lines. After a call
//! that changes it, it is printed by `Debug`, which shows its integers in order.

use std::fmt::Write;

use crate::language::declarations::{Declarations, Function};
use crate::language::module::Module;
use crate::program::types::Type;

/// A call that the program can make.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// Number of the function in [`Declarations::functions`].
    pub function: usize,
    /// The struct with private fields whose single object is the receiver, or becomes the result.
    pub object: Option<usize>,
    /// Whether the call creates the object.
    pub is_new: bool,
    /// Whether the object's words come after those of the result.
    pub shows_object: bool,
}

/// The calls that a module offers, and the program that makes them.
#[derive(Clone, Debug)]
pub struct Harness {
    /// Calls, by their numbers.
    pub calls: Vec<Call>,
    /// Text of the program.
    pub text: String,
}

/// The name under which the emitted crate is compiled.
pub const CRATE: &str = "emitted";

/// Writes the program for `module`.
pub fn harness(module: &Module) -> Harness {
    let declarations = module.declarations();
    let writer = Writer { declarations };
    let calls: Vec<Call> = (0..declarations.functions.len())
        .filter_map(|number| writer.call(number))
        .collect();
    let objects: Vec<usize> = (0..declarations.structs.len())
        .filter(|number| {
            calls
                .iter()
                .any(|call| call.is_new && call.object == Some(*number))
        })
        .collect();
    // A method needs an object, and an object needs its `new`.
    let calls: Vec<Call> = calls
        .into_iter()
        .filter(|call| call.object.is_none_or(|object| objects.contains(&object)))
        .collect();
    let mut arms = String::new();
    for (index, call) in calls.iter().enumerate() {
        let body = writer.body(call);
        arms.push_str(&format!("        {index} => {{\n{body}        }}\n"));
    }
    let fields: String = objects
        .iter()
        .map(|object| format!("    o{object}: {},\n", writer.struct_path(*object)))
        .collect();
    let starts: String = objects
        .iter()
        .map(|object| {
            format!(
                "        o{object}: {}::new(),\n",
                writer.struct_path(*object)
            )
        })
        .collect();
    // `Debug` prints the name of an enum's variant; two enums may use the same name for different values.
    let mut values = std::collections::BTreeMap::new();
    for found in &declarations.enums {
        for (value, name) in found.variants.iter().enumerate() {
            values.entry(name.as_str()).or_insert(value);
        }
    }
    let variants: String = values
        .iter()
        .map(|(name, value)| format!("            &quot;{name}&quot; => out.push({value}),\n"))
        .collect();
    let text = format!(
        r"//! Written by the checker: calls the emitted crate with the words of its input.
use std::io::{{BufRead, Write}};

struct Objects {{
{fields}}}

fn shown(value: &dyn core::fmt::Debug, out: &mut Vec<i128>) {{
    let text = format!(&quot;{{value:?}}&quot;);
    let pieces = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-' || c == '_'));
    for piece in pieces {{
        match piece {{
            &quot;true&quot; => out.push(1),
            &quot;false&quot; => out.push(0),
{variants}            other => out.extend(other.parse::<i128>().ok()),
        }}
    }}
}}

#[allow(unused_variables)]
fn call(index: usize, w: &[i128], objects: &mut Objects, out: &mut Vec<i128>) {{
    match index {{
{arms}        _ => {{}}
    }}
}}

fn main() {{
    std::panic::set_hook(Box::new(|_| {{}}));
    let mut objects = Objects {{
{starts}    }};
    let input = std::io::stdin().lock();
    let mut output = std::io::BufWriter::new(std::io::stdout().lock());
    for line in input.lines() {{
        let Ok(line) = line else {{ break }};
        let words: Vec<i128> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
        let Some((index, words)) = words.split_first() else {{ continue }};
        let mut out = Vec::new();
        let run = std::panic::AssertUnwindSafe(|| call(*index as usize, words, &mut objects, &mut out));
        let text = match std::panic::catch_unwind(run) {{
            Ok(()) => out.iter().map(i128::to_string).collect::<Vec<_>>().join(&quot; &quot;),
            Err(_) => &quot;panic&quot;.to_owned(),
        }};
        if writeln!(output, &quot;{{text}}&quot;).is_err() {{
            break;
        }}
    }}
}}
"
    )
    .replace("&quot;", "\"");
    Harness { calls, text }
}

struct Writer<'a> {
    declarations: &'a Declarations,
}

impl Writer<'_> {
    /// The call of a function from outside the crate; `None` if it cannot be called.
    fn call(&self, number: usize) -> Option<Call> {
        let function = &self.declarations.functions[number];
        if !function.is_public {
            return None;
        }
        let (receiver, others) = match function.arguments.first() {
            Some(first) if first.name == "self" => (Some(first), &function.arguments[1..]),
            _ => (None, &function.arguments[..]),
        };
        if !others.iter().all(|argument| self.is_open(&argument.type_)) {
            return None;
        }
        let plain = Call {
            function: number,
            object: None,
            is_new: false,
            shows_object: false,
        };
        let Some(receiver) = receiver else {
            let opaque = match function.result {
                Type::Struct(object) if !self.is_open(&function.result) => Some(object),
                _ => None,
            };
            return match opaque {
                Some(object) if self.is_shown(&function.result) => Some(Call {
                    object: Some(object),
                    is_new: others.is_empty() && short_name(function) == "new",
                    shows_object: true,
                    ..plain
                })
                .filter(|call| call.is_new),
                Some(_) => None,
                None => self.is_open(&function.result).then_some(plain),
            };
        };
        let is_result_known = self.is_open(&function.result) || self.is_shown(&function.result);
        match receiver.type_ {
            _ if !is_result_known => None,
            Type::Struct(object)
                if self.is_shown(&receiver.type_) && !self.is_open(&receiver.type_) =>
            {
                Some(Call {
                    object: Some(object),
                    shows_object: receiver.is_mutable,
                    ..plain
                })
            }
            _ if !receiver.is_mutable && self.is_open(&receiver.type_) => Some(plain),
            _ => None,
        }
    }

    /// Whether a value of this type can be created and read from outside the crate.
    fn is_open(&self, type_: &Type) -> bool {
        match type_ {
            Type::Integer(_) | Type::Bool | Type::Fixed(_) | Type::Enum(..) => true,
            Type::Struct(number) => {
                let found = &self.declarations.structs[*number];
                found.is_whole && found.fields.iter().all(|(_, type_)| self.is_open(type_))
            }
            Type::Array(element, _) => self.is_open(element),
            Type::Tuple(elements) => elements.iter().all(|element| self.is_open(element)),
            Type::Option(content) => self.is_open(content),
        }
    }

    /// Whether `Debug` prints the words of a value in order.
    fn is_shown(&self, type_: &Type) -> bool {
        match type_ {
            Type::Integer(_) | Type::Bool | Type::Enum(..) => true,
            Type::Fixed(_) | Type::Option(_) => false,
            Type::Struct(number) => {
                let fields = &self.declarations.structs[*number].fields;
                fields.iter().all(|(_, type_)| self.is_shown(type_))
            }
            Type::Array(element, _) => self.is_shown(element),
            Type::Tuple(elements) => elements.iter().all(|element| self.is_shown(element)),
        }
    }

    fn struct_path(&self, number: usize) -> String {
        let found = &self.declarations.structs[number];
        self.path(found.module, &found.name)
    }

    fn path(&self, module: usize, name: &str) -> String {
        let module = &self.declarations.files[module].module;
        if module.is_empty() {
            format!("{CRATE}::{name}")
        } else {
            format!("{CRATE}::{module}::{name}")
        }
    }

    /// The statements of one call.
    fn body(&self, call: &Call) -> String {
        let function = &self.declarations.functions[call.function];
        let mut next = 0;
        let mut made = Vec::new();
        let is_method = function.arguments.first().is_some_and(|a| a.name == "self");
        let own = usize::from(is_method && call.object.is_some());
        for argument in &function.arguments[own..] {
            let value = self.made(&argument.type_, &mut next);
            made.push(if argument.is_reference {
                format!("&{value}")
            } else {
                value
            });
        }
        let name = short_name(function);
        let path = match function.owner {
            Some(owner) => format!("{}::{name}", self.struct_path(owner)),
            None => self.path(function.module, name),
        };
        let mut arguments = made;
        let object = call.object.map(|object| format!("objects.o{object}"));
        if let (Some(object), true) = (&object, is_method) {
            let borrow = if call.shows_object { "&mut " } else { "&" };
            arguments.insert(0, format!("{borrow}{object}"));
        }
        let called = format!("{path}({})", arguments.join(", "));
        let mut text = String::new();
        if let (Some(object), true) = (&object, call.is_new) {
            let _ = writeln!(text, "            {object} = {called};");
        } else {
            let _ = writeln!(text, "            let r = {called};");
            self.read(&function.result, "r", &mut text);
        }
        if let (Some(object), true) = (&object, call.shows_object) {
            let _ = writeln!(text, "            shown(&{object}, out);");
        }
        text
    }

    /// An expression that makes a value from the words from `next` on.
    fn made(&self, type_: &Type, next: &mut usize) -> String {
        let mut word = || {
            *next += 1;
            format!("w[{}]", *next - 1)
        };
        match type_ {
            Type::Integer(_) => format!("({} as {})", word(), self.declarations.type_name(type_)),
            Type::Bool => format!("({} != 0)", word()),
            Type::Enum(number, _) => {
                let found = &self.declarations.enums[*number];
                let path = self.path(found.module, &found.name);
                let named = found.variants.iter().enumerate();
                let arms: String = named
                    .map(|(value, name)| format!("{value} => {path}::{name}, "))
                    .collect();
                let first = found.variants.first().map_or("", String::as_str);
                format!("match {} {{ {arms}_ => {path}::{first} }}", word())
            }
            Type::Fixed(_) => format!(
                "fixed::types::{}::from_bits({} as i32)",
                self.declarations.type_name(type_),
                word()
            ),
            Type::Array(element, length) => {
                let all: Vec<_> = (0..*length).map(|_| self.made(element, next)).collect();
                format!("[{}]", all.join(", "))
            }
            Type::Tuple(elements) => {
                let all: String = elements
                    .iter()
                    .map(|element| self.made(element, next) + ", ")
                    .collect();
                format!("({all})")
            }
            Type::Option(content) => {
                let is_some = word();
                let content = self.made(content, next);
                format!("if {is_some} != 0 {{ Some({content}) }} else {{ None }}")
            }
            Type::Struct(number) => {
                let fields = &self.declarations.structs[*number].fields;
                let all: String = fields
                    .iter()
                    .map(|(name, type_)| format!("{name}: {}, ", self.made(type_, next)))
                    .collect();
                format!("{} {{ {all}}}", self.struct_path(*number))
            }
        }
    }

    /// Statements that append the words of `value`.
    fn read(&self, type_: &Type, value: &str, text: &mut String) {
        match type_ {
            Type::Integer(_) | Type::Bool | Type::Enum(..) => {
                let _ = writeln!(text, "            out.push({value} as i128);");
            }
            Type::Fixed(_) => {
                let _ = writeln!(text, "            out.push({value}.to_bits() as i128);");
            }
            Type::Array(element, length) => {
                for index in 0..*length {
                    self.read(element, &format!("{value}[{index}]"), text);
                }
            }
            Type::Tuple(elements) => {
                for (index, element) in elements.iter().enumerate() {
                    self.read(element, &format!("{value}.{index}"), text);
                }
            }
            Type::Option(content) => {
                let width = self.declarations.width(content);
                let _ = writeln!(
                    text,
                    "            if let Some(some) = {value} {{ out.push(1);"
                );
                self.read(content, "some", text);
                let _ = writeln!(
                    text,
                    "            }} else {{ out.extend([0_i128; {}]); }}",
                    width + 1
                );
            }
            Type::Struct(number) if self.is_open(type_) => {
                for (name, type_) in &self.declarations.structs[*number].fields {
                    self.read(type_, &format!("{value}.{name}"), text);
                }
            }
            Type::Struct(_) => {
                let _ = writeln!(text, "            shown(&{value}, out);");
            }
        }
    }
}

/// `step` of `Controller::step`.
fn short_name(function: &Function) -> &str {
    function.name.rsplit("::").next().unwrap_or(&function.name)
}
