//! Reads the contracts of the functions in the source.

use crate::language::module::Module;
use crate::program::contract::{Contract, Range};

/// Reads the contract that a function has for Kani, as far as it states ranges.
///
/// Conjunctions of `(low..=high).contains(&word)`, `low..high` and comparisons of a
/// word with a constant are understood. Everything else is ignored. That is sound in both directions: a
/// contract is proved from the understood requirements alone, and only the understood promises are used.
pub fn stated(module: &Module, number: usize) -> Option<Contract> {
    let declarations = module.declarations();
    let function = &declarations.functions[number];
    let mut inputs = Vec::new();
    for argument in &function.arguments {
        inputs.extend(declarations.word_names(&argument.name, &argument.type_));
    }
    let mut contract = Contract::default();
    for attribute in &function.attributes {
        let Some((kind, condition)) = condition(attribute) else {
            continue;
        };
        let reader = Reader {
            module,
            file: &declarations.files[function.module].module,
        };
        match condition {
            syn::Expr::Closure(closure) if kind == "ensures" => {
                let Some(syn::Pat::Ident(name)) = closure.inputs.first() else {
                    continue;
                };
                let outputs = declarations.word_names(&name.ident.to_string(), &function.result);
                // A promise that is not understood is ignored; nothing depends on it.
                reader.conjunction(&closure.body, &outputs, &mut contract.ensures);
            }
            other if kind == "requires" => {
                let whole = reader.conjunction(&other, &inputs, &mut contract.requires);
                contract.is_partial |= !whole;
            }
            _ => {}
        }
    }
    (!contract.ensures.is_empty()).then_some(contract)
}

/// `requires` or `ensures`, with its condition.
fn condition(attribute: &syn::Attribute) -> Option<(String, syn::Expr)> {
    if !attribute.path().is_ident("cfg_attr") {
        return None;
    }
    let list = attribute
        .parse_args_with(syn::punctuated::Punctuated::<syn::Meta, syn::Token![,]>::parse_terminated)
        .ok()?;
    let syn::Meta::List(meta) = list.iter().nth(1)? else {
        return None;
    };
    let kind = meta.path.segments.last()?.ident.to_string();
    Some((kind, meta.parse_args().ok()?))
}

struct Reader<'a> {
    module: &'a Module,
    file: &'a str,
}

impl Reader<'_> {
    /// Adds the ranges of a conjunction; returns whether all of it was understood.
    fn conjunction(
        &self,
        expression: &syn::Expr,
        words: &[String],
        ranges: &mut Vec<Range>,
    ) -> bool {
        match expression {
            syn::Expr::Paren(inner) => self.conjunction(&inner.expr, words, ranges),
            syn::Expr::Block(block) => match block.block.stmts.as_slice() {
                [syn::Stmt::Expr(inner, None)] => self.conjunction(inner, words, ranges),
                _ => false,
            },
            syn::Expr::Binary(binary) if matches!(binary.op, syn::BinOp::And(_)) => {
                let left = self.conjunction(&binary.left, words, ranges);
                let right = self.conjunction(&binary.right, words, ranges);
                left && right
            }
            other => {
                let range = self.range(other, words);
                let is_understood = range.is_some();
                if let Some(range) = range {
                    match ranges.iter_mut().find(|known| known.word == range.word) {
                        Some(known) => {
                            known.low = known.low.max(range.low);
                            known.high = known.high.min(range.high);
                        }
                        None => ranges.push(range),
                    }
                }
                is_understood
            }
        }
    }

    fn range(&self, expression: &syn::Expr, words: &[String]) -> Option<Range> {
        let whole = |word| Range {
            word,
            low: i32::MIN.into(),
            high: i32::MAX.into(),
        };
        match expression {
            syn::Expr::MethodCall(call) if call.method == "contains" => {
                let word = self.word(call.args.first()?, words)?;
                let syn::Expr::Paren(paren) = &*call.receiver else {
                    return None;
                };
                let syn::Expr::Range(range) = &*paren.expr else {
                    return None;
                };
                let low = self.value(range.start.as_ref()?)?;
                let end = self.value(range.end.as_ref()?)?;
                let is_closed = matches!(range.limits, syn::RangeLimits::Closed(_));
                let high = if is_closed { end } else { end - 1 };
                Some(Range { word, low, high })
            }
            syn::Expr::Binary(binary) => {
                let (word, bound, is_left) = match self.word(&binary.left, words) {
                    Some(word) => (word, self.value(&binary.right)?, true),
                    None => (
                        self.word(&binary.right, words)?,
                        self.value(&binary.left)?,
                        false,
                    ),
                };
                let mut range = whole(word);
                match (&binary.op, is_left) {
                    (syn::BinOp::Ge(_), true) | (syn::BinOp::Le(_), false) => range.low = bound,
                    (syn::BinOp::Le(_), true) | (syn::BinOp::Ge(_), false) => range.high = bound,
                    (syn::BinOp::Gt(_), true) | (syn::BinOp::Lt(_), false) => range.low = bound + 1,
                    (syn::BinOp::Lt(_), true) | (syn::BinOp::Gt(_), false) => {
                        range.high = bound - 1;
                    }
                    _ => return None,
                }
                Some(range)
            }
            _ => None,
        }
    }

    /// The position of the word that an expression refers to: `x`, `&x`, `*r`, `&v[1]`.
    fn word(&self, expression: &syn::Expr, words: &[String]) -> Option<usize> {
        match expression {
            syn::Expr::Reference(inner) => self.word(&inner.expr, words),
            syn::Expr::Paren(inner) => self.word(&inner.expr, words),
            syn::Expr::Unary(inner) if matches!(inner.op, syn::UnOp::Deref(_)) => {
                self.word(&inner.expr, words)
            }
            other => {
                let name = path_text(other)?;
                words.iter().position(|word| *word == name)
            }
        }
    }

    /// A constant.
    fn value(&self, expression: &syn::Expr) -> Option<i128> {
        match expression {
            syn::Expr::Paren(inner) => self.value(&inner.expr),
            syn::Expr::Lit(literal) => match &literal.lit {
                syn::Lit::Int(integer) => integer.base10_parse().ok(),
                _ => None,
            },
            syn::Expr::Unary(unary) if matches!(unary.op, syn::UnOp::Neg(_)) => {
                Some(-self.value(&unary.expr)?)
            }
            syn::Expr::Binary(binary) => {
                let (a, b) = (self.value(&binary.left)?, self.value(&binary.right)?);
                match binary.op {
                    syn::BinOp::Add(_) => a.checked_add(b),
                    syn::BinOp::Sub(_) => a.checked_sub(b),
                    syn::BinOp::Mul(_) => a.checked_mul(b),
                    _ => None,
                }
            }
            syn::Expr::Path(path) => {
                let name = path.path.get_ident()?.to_string();
                match self.module.constant(self.file, &name)? {
                    [word] => Some(*word),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

/// `name`, `name.field`, `name[0]` as words are called.
fn path_text(expression: &syn::Expr) -> Option<String> {
    match expression {
        syn::Expr::Path(path) => Some(path.path.get_ident()?.to_string()),
        syn::Expr::Field(field) => {
            let member = match &field.member {
                syn::Member::Named(name) => name.to_string(),
                syn::Member::Unnamed(index) => index.index.to_string(),
            };
            Some(format!("{}.{member}", path_text(&field.base)?))
        }
        syn::Expr::Index(index) => {
            let syn::Expr::Lit(literal) = &*index.index else {
                return None;
            };
            let syn::Lit::Int(position) = &literal.lit else {
                return None;
            };
            Some(format!(
                "{}[{}]",
                path_text(&index.expr)?,
                position.base10_digits()
            ))
        }
        _ => None,
    }
}
