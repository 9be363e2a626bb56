//! Header and source, and the order of all files.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use super::definitions::{collect, type_definitions};
use super::header::header;
use super::items::{FunctionKey, Items, Passing, Translated};
use super::names::{PUBLIC, PUBLIC_CONSTANTS, function_name, is_public};
use super::scope::{CPlace, Scope};
use super::statement::Target;
use super::types::{ItemKey, Type, type_name};
use super::{Result, Untranslatable, board_loop, comments, constants, library, sketch};
use crate::file::{EmittedCrate, EmittedFile};

/// Translates an emitted crate: a C99 header and source, with an Arduino and a PlatformIO library around them, an
/// example, and the certificate, which states that the language is C.
///
/// # Errors
/// [`Untranslatable`] if the crate contains something that the translation does not support.
pub fn emit(emitted: &EmittedCrate) -> Result<EmittedCrate> {
    let items = Items::read(emitted)?;
    let mut functions: BTreeMap<FunctionKey, Translated> = BTreeMap::new();
    let mut used: BTreeSet<ItemKey> = BTreeSet::new();
    let mut clamps_64 = false;
    let mut waiting: VecDeque<FunctionKey> = PUBLIC
        .iter()
        .map(|(module, owner, name, _)| {
            let owner = owner.map(str::to_string);
            ((*module).to_string(), owner, (*name).to_string())
        })
        .filter(|key| items.functions.contains_key(key))
        .collect();
    let mut constant_texts: BTreeMap<ItemKey, String> = BTreeMap::new();
    let mut constants_waiting: VecDeque<ItemKey> = PUBLIC_CONSTANTS
        .iter()
        .map(|(module, name)| ((*module).to_string(), (*name).to_string()))
        .filter(|key| items.constants.contains_key(key))
        .collect();
    while let Some(key) = waiting.pop_front() {
        if functions.contains_key(&key) {
            continue;
        }
        let (translated, needs) = translate(&items, &key)?;
        clamps_64 |= needs.clamp_64;
        waiting.extend(needs.functions);
        constants_waiting.extend(needs.constants);
        functions.insert(key, translated);
    }
    while let Some(key) = constants_waiting.pop_front() {
        if constant_texts.contains_key(&key) {
            continue;
        }
        let (text, needs) = constants::definition(&items, &key)?;
        constants_waiting.extend(needs.constants);
        if let Some(constant) = items.constants.get(&key) {
            collect(&items, &constant.ty, &mut used);
        }
        constant_texts.insert(key, text);
    }
    for key in functions.keys() {
        if let Some(function) = items.functions.get(key) {
            let types = function.parameters.iter().map(|(_, ty)| ty);
            for ty in types.chain([&function.returns]) {
                collect(&items, ty, &mut used);
            }
            if let Some(owner) = &function.owner {
                let own = Type::Struct((function.module.clone(), owner.clone()));
                collect(&items, &own, &mut used);
            }
        }
    }
    let mut shown = BTreeSet::new();
    let kept_by_the_firmware = [
        ("controller", "Controller"),
        ("controller", "Sample"),
        ("monitor", "Monitor"),
    ];
    for (module, name) in kept_by_the_firmware {
        let key = (module.to_string(), name.to_string());
        if items.structs.contains_key(&key) {
            collect(&items, &Type::Struct(key), &mut shown);
        }
    }
    for (module, name) in PUBLIC_CONSTANTS {
        let key = (module.to_string(), name.to_string());
        if let Some(constant) = items.constants.get(&key) {
            collect(&items, &constant.ty, &mut shown);
        }
    }
    for key in functions.keys().filter(|key| is_public(key)) {
        let parameters = items.functions.get(key).map(|own| &own.parameters);
        for (_, ty) in parameters.into_iter().flatten() {
            collect(&items, ty, &mut shown);
        }
    }
    let title = title(emitted);
    let source = source(&Parts {
        items: &items,
        title: &title,
        functions: &functions,
        constants: &constant_texts,
        types: used.difference(&shown).cloned().collect(),
        clamps_64,
    });
    let header = header(&items, &title, &functions, &constant_texts, &shown);
    let file = |path: &str, contents: String| EmittedFile {
        path: path.to_string(),
        contents,
    };
    let mut files = vec![
        file("src/flywheel.h", header),
        file("src/flywheel.c", source),
    ];
    files.extend(board_loop::files(emitted));
    files.extend(library::files(
        &emitted.name(),
        &title,
        emitted.file("src/monitor.rs").is_some(),
    ));
    files.push(sketch::file(emitted));
    files.push(file("certificate.json", certificate(emitted)?));
    Ok(EmittedCrate { files })
}

/// The first line of the emitted source, which names the model.
fn title(emitted: &EmittedCrate) -> String {
    let library = emitted.file("src/lib.rs").unwrap_or_default();
    let first = library.lines().next().unwrap_or_default();
    first.trim_start_matches("//").trim().to_string()
}

/// The certificate with its language.
fn certificate(emitted: &EmittedCrate) -> Result<String> {
    let fault = |what: String| Untranslatable {
        place: "certificate.json".to_string(),
        what,
    };
    let text = emitted.file("certificate.json").unwrap_or_default();
    let open = text
        .find('{')
        .ok_or_else(|| fault("a certificate that is no object".to_string()))?;
    // The text is kept unchanged, with all digits of its numbers.
    let (before, after) = text.split_at(open + 1);
    Ok(format!("{before}\n  \"language\": \"c\",{after}"))
}

fn translate(items: &Items, key: &FunctionKey) -> Result<(Translated, super::scope::Needs)> {
    let Some(function) = items.functions.get(key) else {
        return Err(Untranslatable {
            place: key.0.clone(),
            what: format!("the function {}", key.2),
        });
    };
    let owner = function.owner.as_deref();
    let mut scope = Scope::new(items, &function.module, owner, &function.name);
    scope.returns = function.returns.clone();
    let mut parameters = vec![];
    if let (Some(passing), Some(owner)) = (function.receiver, owner) {
        let ty = Type::Struct((function.module.clone(), owner.to_string()));
        let own = scope.fresh("self");
        let constant = if passing == Passing::Shared {
            "const "
        } else {
            ""
        };
        parameters.push(format!("{constant}{} *{own}", type_name(owner)));
        scope.bind("self", CPlace::behind(&own, ty));
    }
    for (name, ty) in &function.parameters {
        let own = scope.fresh(name);
        let (text, place) = match ty {
            Type::Struct((_, structure)) => (
                format!("const {} *{own}", type_name(structure)),
                CPlace::behind(&own, ty.clone()),
            ),
            Type::Array(..) => (
                format!("const {}", ty.declare(&own)),
                CPlace::variable(&own, ty.clone()),
            ),
            _ => (ty.declare(&own), CPlace::variable(&own, ty.clone())),
        };
        parameters.push(text);
        scope.bind(name, place);
    }
    let name = function_name(key);
    let outs = if function.returns_reference {
        vec![]
    } else {
        CPlace::outs(&function.returns)
    };
    let returns = match &function.returns {
        Type::Struct((_, structure)) if function.returns_reference => {
            format!("const {} *", type_name(structure))
        }
        ty if ty.is_aggregate() => "void ".to_string(),
        ty => ty.declare(""),
    };
    for out in outs {
        parameters.push(match (&out.ty, out.is_pointer) {
            (ty, true) => ty.declare(&format!("*{}", out.text)),
            (ty, false) => ty.declare(&out.text),
        });
    }
    if parameters.is_empty() {
        parameters.push("void".to_string());
    }
    scope.block(&function.body, &Target::Return)?;
    let prototype = format!("{returns}{name}({})", parameters.join(", "));
    let mut body = std::mem::take(&mut scope.lines);
    if function.receiver.is_some() && !body.iter().any(|line| line.contains("self")) {
        body.insert(0, "    (void)self;".to_string());
    }
    Ok((Translated { prototype, body }, scope.needs))
}

struct Parts<'a> {
    items: &'a Items,
    title: &'a str,
    functions: &'a BTreeMap<FunctionKey, Translated>,
    constants: &'a BTreeMap<ItemKey, String>,
    types: BTreeSet<ItemKey>,
    clamps_64: bool,
}

fn source(parts: &Parts) -> String {
    let items = parts.items;
    let mut text = format!(
        "/* {} */\n\
         #include \"flywheel.h\"\n\n\
         /* A shift of a negative number to the right must keep its sign, as every compiler in use does; the\n \
         * language leaves it open. The build stops here where it does not. */\n\
         typedef char flywheel_right_shift_keeps_the_sign[((-INT32_C(2) >> 1) == -INT32_C(1)) ? 1 : -1];\n\n",
        parts.title
    );
    text.push_str(&type_definitions(items, &parts.types));
    // Numbers come before tables, which refer to them.
    for is_table in [false, true] {
        for key in &items.constant_order {
            let is_public = PUBLIC_CONSTANTS
                .iter()
                .any(|(module, name)| key.0 == *module && key.1 == *name);
            let own = items.constants.get(key);
            let is_now = own.is_some_and(|own| own.ty.is_aggregate() == is_table);
            if let (Some(constant), true, false) = (parts.constants.get(key), is_now, is_public) {
                text.push_str(constant);
                text.push('\n');
            }
        }
    }
    if parts.clamps_64 {
        text.push_str(
            "/* The nearest value within [low, high]. */\n\
             static int64_t clamp_64(int64_t value, int64_t low, int64_t high) {\n    \
             if (value < low) {\n        return low;\n    }\n    \
             if (value > high) {\n        return high;\n    }\n    return value;\n}\n\n",
        );
    }
    for key in &items.function_order {
        if let (Some(translated), false) = (parts.functions.get(key), is_public(key)) {
            text.push_str(&format!("static {};\n", translated.prototype));
        }
    }
    for (module, attributes) in &items.modules {
        let own: Vec<&FunctionKey> = items
            .function_order
            .iter()
            .filter(|key| key.0 == *module && parts.functions.contains_key(key))
            .collect();
        if own.is_empty() {
            continue;
        }
        let lines = comments::lines(attributes);
        text.push_str(&format!("\n/* ---- {module} ---- */\n"));
        text.push_str(&comments::before(&lines, ""));
        for key in own {
            let (Some(translated), Some(function)) =
                (parts.functions.get(key), items.functions.get(key))
            else {
                continue;
            };
            text.push('\n');
            let storage = if is_public(key) {
                ""
            } else {
                text.push_str(&comments::before(
                    &comments::lines(&function.attributes),
                    "",
                ));
                "static "
            };
            text.push_str(&format!("{storage}{} {{\n", translated.prototype));
            for line in &translated.body {
                text.push_str(line);
                text.push('\n');
            }
            text.push_str("}\n");
        }
    }
    text
}
