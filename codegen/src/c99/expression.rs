//! Scalars: numbers, booleans, enumerators.

use syn::{BinOp, Expr, UnOp};

use super::Result;
use super::items::{FunctionKey, last, literal, suffix};
use super::scope::{Place, Scope};
use super::types::{Int, Key, Type};

/// A scalar in C.
#[derive(Debug, Clone)]
pub struct Scalar {
    /// Its text.
    pub text: String,
    /// Its type.
    pub ty: Type,
    /// Binding strength: 0 for a text that never needs parentheses.
    pub strength: u8,
}

/// A cast or a sign.
const UNARY: u8 = 1;
const PRODUCT: u8 = 2;
const SUM: u8 = 3;
const SHIFT: u8 = 4;
const COMPARISON: u8 = 5;
const BITS: u8 = 6;
const AND: u8 = 7;
const OR: u8 = 8;

impl Scalar {
    fn new(text: impl Into<String>, ty: Type, strength: u8) -> Scalar {
        Scalar {
            text: text.into(),
            ty,
            strength,
        }
    }

    /// The text, in parentheses unless it binds at least this tightly.
    pub fn within(&self, strength: u8) -> String {
        if self.strength <= strength {
            self.text.clone()
        } else {
            format!("({})", self.text)
        }
    }
}

/// An expression without parentheses and references around it.
pub fn bare(expression: &Expr) -> &Expr {
    match expression {
        Expr::Paren(inner) => bare(&inner.expr),
        Expr::Group(inner) => bare(&inner.expr),
        Expr::Reference(inner) => bare(&inner.expr),
        other => other,
    }
}

/// Whether it is a number whose type follows from the context.
fn is_untyped(expression: &Expr) -> bool {
    match bare(expression) {
        Expr::Lit(value) => literal(&value.lit).is_some() && suffix(&value.lit).is_none(),
        Expr::Unary(unary) => matches!(unary.op, UnOp::Neg(_)) && is_untyped(&unary.expr),
        _ => false,
    }
}

/// A call with its arguments.
pub struct Call<'e> {
    /// The function.
    pub key: FunctionKey,
    /// The receiver, if there is one.
    pub receiver: Option<&'e Expr>,
    /// The others.
    pub arguments: Vec<&'e Expr>,
}

impl Scope<'_> {
    /// A scalar; `wanted` is the type that the context requires, if it does.
    pub fn scalar(&mut self, expression: &Expr, wanted: Option<&Type>) -> Result<Scalar> {
        self.scalar_beside(expression, wanted, true)
    }

    /// `is_beside_wide`: another operand, or the target, gives the number its width.
    fn scalar_beside(
        &mut self,
        expression: &Expr,
        wanted: Option<&Type>,
        is_beside_wide: bool,
    ) -> Result<Scalar> {
        match bare(expression) {
            Expr::Lit(value) => self.number(&value.lit, wanted, is_beside_wide),
            Expr::Unary(unary) => self.unary(unary, wanted, is_beside_wide),
            Expr::Binary(binary) => self.binary(binary, wanted),
            Expr::Cast(cast) => {
                let ty = self.items.type_of(self.module, &cast.ty)?;
                self.cast(&cast.expr, ty)
            }
            Expr::MethodCall(call) => self.method(call),
            Expr::Call(call) => self.call(call),
            Expr::If(_) => self.conditional(expression, wanted),
            Expr::Path(_) | Expr::Field(_) | Expr::Index(_) => {
                let place = self.place(expression)?;
                if place.ty.is_aggregate() {
                    return self.refuse("a structure where a number is wanted");
                }
                let text = if place.is_pointer {
                    format!("*{}", place.text)
                } else {
                    place.text
                };
                Ok(Scalar::new(text, place.ty, u8::from(place.is_pointer)))
            }
            Expr::Block(block) if block.block.stmts.len() == 1 => match &block.block.stmts[0] {
                syn::Stmt::Expr(inner, None) => self.scalar(inner, wanted),
                _ => self.refuse("a block in an expression"),
            },
            other => self.refuse(kind(other)),
        }
    }

    fn number(
        &mut self,
        value: &syn::Lit,
        wanted: Option<&Type>,
        is_beside_wide: bool,
    ) -> Result<Scalar> {
        if let syn::Lit::Bool(value) = value {
            return Ok(Scalar::new(
                u8::from(value.value).to_string(),
                Type::Bool,
                0,
            ));
        }
        let Some((magnitude, text)) = literal(value) else {
            return self.refuse("this literal");
        };
        let int = match (suffix(value), wanted) {
            (Some(int), _) => int,
            (None, Some(Type::Int(int))) => *int,
            _ => Int::I32,
        };
        let text = int.literal(magnitude, &text, is_beside_wide);
        Ok(Scalar::new(text, Type::Int(int), 0))
    }

    fn unary(
        &mut self,
        unary: &syn::ExprUnary,
        wanted: Option<&Type>,
        is_beside_wide: bool,
    ) -> Result<Scalar> {
        match unary.op {
            UnOp::Neg(_) => {
                if let Expr::Lit(value) = bare(&unary.expr)
                    && let Some((0x8000_0000, _)) = literal(&value.lit)
                    && !matches!(wanted, Some(Type::Int(Int::I64)))
                {
                    // C has no negative numbers, and 2^31 does not fit.
                    let text = "-INT32_C(2147483647) - 1";
                    return Ok(Scalar::new(text, Type::Int(Int::I32), SUM));
                }
                let inner = self.scalar_beside(&unary.expr, wanted, is_beside_wide)?;
                Ok(Scalar::new(
                    format!("-{}", inner.within(0)),
                    inner.ty,
                    UNARY,
                ))
            }
            UnOp::Not(_) => {
                let inner = self.scalar(&unary.expr, wanted)?;
                if inner.ty != Type::Bool {
                    return self.refuse("`!` of a number");
                }
                Ok(Scalar::new(
                    format!("!{}", inner.within(0)),
                    Type::Bool,
                    UNARY,
                ))
            }
            UnOp::Deref(_) => self.scalar(&unary.expr, wanted),
            _ => self.refuse("this sign"),
        }
    }

    fn binary(&mut self, binary: &syn::ExprBinary, wanted: Option<&Type>) -> Result<Scalar> {
        let (sign, strength) = match binary.op {
            BinOp::Add(_) => ("+", SUM),
            BinOp::Sub(_) => ("-", SUM),
            BinOp::Mul(_) => ("*", PRODUCT),
            BinOp::Shl(_) => return self.shift_left(binary, wanted),
            BinOp::Shr(_) => {
                let left = self.scalar(&binary.left, wanted)?;
                let right = self.shift_amount(&binary.right)?;
                let text = format!("{} >> {right}", left.within(UNARY));
                return Ok(Scalar::new(text, left.ty, SHIFT));
            }
            BinOp::BitAnd(_) => ("&", BITS),
            BinOp::Lt(_) => ("<", COMPARISON),
            BinOp::Le(_) => ("<=", COMPARISON),
            BinOp::Gt(_) => (">", COMPARISON),
            BinOp::Ge(_) => (">=", COMPARISON),
            BinOp::Eq(_) => ("==", COMPARISON),
            BinOp::Ne(_) => ("!=", COMPARISON),
            BinOp::And(_) => return self.logical(binary, "&&", AND),
            BinOp::Or(_) => return self.logical(binary, "||", OR),
            _ => return self.refuse("this operator"),
        };
        let is_comparison = strength == COMPARISON;
        let wanted = if is_comparison { None } else { wanted };
        let (left, right) = match (is_untyped(&binary.left), is_untyped(&binary.right)) {
            (true, false) => {
                let right = self.scalar(&binary.right, wanted)?;
                let ty = right.ty.clone();
                (self.scalar_beside(&binary.left, Some(&ty), true)?, right)
            }
            (false, true) => {
                let left = self.scalar(&binary.left, wanted)?;
                let ty = left.ty.clone();
                let right = self.scalar_beside(&binary.right, Some(&ty), true)?;
                (left, right)
            }
            (both, _) => (
                self.scalar_beside(&binary.left, wanted, !both)?,
                self.scalar_beside(&binary.right, wanted, !both)?,
            ),
        };
        if left.ty != right.ty {
            return self.refuse(format!("{:?} {sign} {:?}", left.ty, right.ty));
        }
        let is_narrow = matches!(left.ty, Type::Int(Int::I16 | Int::U16 | Int::U8));
        if !is_comparison && (is_narrow || !matches!(left.ty, Type::Int(_))) {
            return self.refuse("arithmetic of words narrower than `int`");
        }
        // The left operand of a chain of sums needs no parentheses; a product in a sum neither.
        let own = if strength == BITS { UNARY } else { strength };
        let left_text = left.within(if is_comparison { SUM } else { own });
        let right_text = right.within(if is_comparison { SUM } else { own - 1 });
        let ty = if is_comparison { Type::Bool } else { left.ty };
        Ok(Scalar::new(
            format!("{left_text} {sign} {right_text}"),
            ty,
            strength,
        ))
    }

    fn logical(&mut self, binary: &syn::ExprBinary, sign: &str, strength: u8) -> Result<Scalar> {
        let left = self.scalar(&binary.left, Some(&Type::Bool))?;
        let lines = self.lines.len();
        let right = self.scalar(&binary.right, Some(&Type::Bool))?;
        if self.lines.len() != lines {
            // C would compute these steps even if the left side decides the result.
            return self.refuse(format!("steps on the right of `{sign}`"));
        }
        // Parentheses where the two signs meet, as compilers advise.
        let text = |side: &Scalar| {
            if side.strength == strength {
                side.text.clone()
            } else {
                side.within(BITS)
            }
        };
        let text = format!("{} {sign} {}", text(&left), text(&right));
        Ok(Scalar::new(text, Type::Bool, strength))
    }

    /// A left shift, only of a number that is not negative: C leaves the others undefined.
    fn shift_left(&mut self, binary: &syn::ExprBinary, wanted: Option<&Type>) -> Result<Scalar> {
        let Expr::Lit(_) = bare(&binary.left) else {
            return self.refuse("a shift to the left of something that may be negative");
        };
        let left = self.scalar_beside(&binary.left, wanted, false)?;
        let right = self.shift_amount(&binary.right)?;
        let text = format!("{} << {right}", left.within(UNARY));
        Ok(Scalar::new(text, left.ty, SHIFT))
    }

    fn shift_amount(&mut self, expression: &Expr) -> Result<String> {
        if is_untyped(expression) {
            let amount = self.scalar_beside(expression, None, true)?;
            return Ok(amount.text);
        }
        Ok(self
            .scalar(expression, Some(&Type::Int(Int::U32)))?
            .within(UNARY))
    }

    /// `inner as ty`.
    fn cast(&mut self, inner: &Expr, ty: Type) -> Result<Scalar> {
        let inner = self.scalar(inner, None)?;
        let Type::Int(int) = ty else {
            return self.refuse("this cast");
        };
        if inner.ty == ty {
            return Ok(inner);
        }
        let text = format!("({}){}", int.c_name(), inner.within(UNARY));
        Ok(Scalar::new(text, ty, UNARY))
    }

    fn conditional(&mut self, expression: &Expr, wanted: Option<&Type>) -> Result<Scalar> {
        let ty = match (wanted, self.infer(expression)?) {
            (_, Some(ty)) => ty,
            (Some(ty), None) => ty.clone(),
            (None, None) => Type::Int(Int::I32),
        };
        let place = self.temporary(&ty);
        self.assign(expression, &place)?;
        Ok(Scalar::new(place.text, ty, 0))
    }

    fn method(&mut self, call: &syn::ExprMethodCall) -> Result<Scalar> {
        match call.method.to_string().as_str() {
            "to_bits" => self.scalar(&call.receiver, None),
            "clamp" => {
                let value = self.scalar(&call.receiver, None)?;
                let mut texts = vec![value.text.clone()];
                for argument in &call.args {
                    texts.push(self.scalar(argument, Some(&value.ty))?.text);
                }
                if value.ty != Type::Int(Int::I64) {
                    return self.refuse("`clamp` of this type");
                }
                self.needs.clamp_64 = true;
                let text = format!("clamp_64({})", texts.join(", "));
                Ok(Scalar::new(text, value.ty, 0))
            }
            _ => self.called(&Expr::MethodCall(call.clone())),
        }
    }

    fn call(&mut self, call: &syn::ExprCall) -> Result<Scalar> {
        let Expr::Path(path) = &*call.func else {
            return self.refuse("this call");
        };
        let names: Vec<String> = path
            .path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string())
            .collect();
        let argument = call.args.first();
        match (&names[..], argument) {
            ([name], Some(inner)) if self.word(name).is_some() => {
                let word = self.word(name);
                self.scalar(inner, word.as_ref())
            }
            ([word, make], Some(inner)) if make == "from_bits" && self.word(word).is_some() => {
                self.scalar(inner, Some(&Type::Int(Int::I32)))
            }
            ([int, make], Some(inner)) if make == "from" => match Int::from_name(int) {
                Some(int) => self.cast(inner, Type::Int(int)),
                None => self.refuse(format!("{int}::from")),
            },
            _ => self.called(&Expr::Call(call.clone())),
        }
    }

    /// The number that a type of the module stands for.
    fn word(&self, name: &str) -> Option<Type> {
        let key = self.items.resolve(self.module, name);
        let own = (self.module.to_string(), name.to_string());
        let words = &self.items.words;
        words
            .get(&key)
            .or_else(|| words.get(&own))
            .map(|(word, _)| word.clone())
    }

    /// A call that returns a scalar.
    fn called(&mut self, expression: &Expr) -> Result<Scalar> {
        let call = self.resolved(expression)?;
        let text = self.call_text(&call, &[])?;
        let returns = self.function(&call.key)?.returns.clone();
        Ok(Scalar::new(text, returns, 0))
    }

    /// The function that is called.
    pub fn resolved<'e>(&mut self, expression: &'e Expr) -> Result<Call<'e>> {
        match bare(expression) {
            Expr::Call(call) => {
                let Expr::Path(path) = &*call.func else {
                    return self.refuse("this call");
                };
                let name = last(&path.path);
                let key = match path.path.segments.len() {
                    1 => {
                        let (module, name) = self.items.resolve(self.module, &name);
                        (module, None, name)
                    }
                    _ => {
                        let owner = path.path.segments[0].ident.to_string();
                        let owner = match (owner.as_str(), self.owner) {
                            ("Self", Some(own)) => own.to_string(),
                            _ => owner,
                        };
                        let (module, owner) = self.items.resolve(self.module, &owner);
                        (module, Some(owner), name)
                    }
                };
                Ok(Call {
                    key,
                    receiver: None,
                    arguments: call.args.iter().collect(),
                })
            }
            Expr::MethodCall(call) => {
                let receiver = self.infer(&call.receiver)?;
                let Some(Type::Struct((module, owner))) = receiver else {
                    return self.refuse(format!("the method {}", call.method));
                };
                Ok(Call {
                    key: (module, Some(owner), call.method.to_string()),
                    receiver: Some(&call.receiver),
                    arguments: call.args.iter().collect(),
                })
            }
            other => self.refuse(kind(other)),
        }
    }

    /// The function with this key.
    pub fn function(&self, key: &FunctionKey) -> Result<&super::items::Function> {
        match self.items.functions.get(key) {
            Some(function) => Ok(function),
            None => self.refuse(format!("a call of {}::{}", key.0, key.2)),
        }
    }

    /// The text of a call; structures and arrays that it returns go to `targets`.
    pub fn call_text(&mut self, call: &Call, targets: &[Place]) -> Result<String> {
        self.needs.functions.insert(call.key.clone());
        let parameters: Vec<Type> = {
            let function = self.function(&call.key)?;
            function
                .parameters
                .iter()
                .map(|(_, ty)| ty.clone())
                .collect()
        };
        let mut texts = vec![];
        if let Some(receiver) = call.receiver {
            texts.push(self.place(receiver)?.argument());
        }
        for (argument, ty) in call.arguments.iter().zip(&parameters) {
            texts.push(if ty.is_aggregate() {
                self.place(argument)?.argument()
            } else {
                self.scalar(argument, Some(ty))?.text
            });
        }
        texts.extend(targets.iter().map(Place::argument));
        Ok(format!(
            "{}({})",
            super::files::function_name(&call.key),
            texts.join(", ")
        ))
    }

    /// The place that an expression names, or a new one with its value.
    pub fn place(&mut self, expression: &Expr) -> Result<Place> {
        match bare(expression) {
            Expr::Path(path) => self.named_place(&path.path),
            Expr::Field(field) => {
                let base = self.place(&field.base)?;
                match (&field.member, &base.ty) {
                    (syn::Member::Named(name), Type::Struct(key)) => {
                        let name = name.to_string();
                        match self.items.field(key, &name) {
                            Some(ty) => Ok(base.field(&name, ty.clone())),
                            None => self.refuse(format!("the field {name}")),
                        }
                    }
                    // A structure around one number is that number.
                    (syn::Member::Unnamed(_), Type::Int(_)) => Ok(base),
                    _ => self.refuse("this field"),
                }
            }
            Expr::Index(index) => {
                let base = self.place(&index.expr)?;
                let number = match bare(&index.index) {
                    Expr::Lit(value) => literal(&value.lit),
                    _ => None,
                };
                match number.and_then(|(number, _)| base.element(number as usize)) {
                    Some(place) => Ok(place),
                    None => self.refuse("this index"),
                }
            }
            Expr::Unary(unary) if matches!(unary.op, UnOp::Deref(_)) => self.place(&unary.expr),
            other => {
                let Some(ty) = self.infer(other)? else {
                    return self.refuse(kind(other));
                };
                if let Expr::MethodCall(_) | Expr::Call(_) = other
                    && ty.is_aggregate()
                {
                    let call = self.resolved(other)?;
                    if self.function(&call.key)?.returns_reference {
                        let text = self.call_text(&call, &[])?;
                        return Ok(Place::behind(&text, ty));
                    }
                }
                let place = self.temporary(&ty);
                self.assign(other, &place)?;
                Ok(place)
            }
        }
    }

    fn named_place(&mut self, path: &syn::Path) -> Result<Place> {
        let name = last(path);
        if path.segments.len() == 1 {
            if let Some(place) = self.lookup(&name) {
                return Ok(place.clone());
            }
            let key = self.items.resolve(self.module, &name);
            if let Some(constant) = self.items.constants.get(&key) {
                let ty = constant.ty.clone();
                self.needs.constants.insert(key.clone());
                return Ok(Place::variable(&super::constants::name(&key), ty));
            }
        } else {
            let owner = path.segments[path.segments.len() - 2].ident.to_string();
            let key = self.items.resolve(self.module, &owner);
            if let Some(own) = self.items.enums.get(&key)
                && own.variants.iter().any(|(variant, _, _)| *variant == name)
            {
                let text = enumerator(&name);
                return Ok(Place::variable(&text, Type::Enum(key)));
            }
            let constant: Key = (owner, name.clone());
            if let Some(found) = self.items.constants.get(&constant) {
                let ty = found.ty.clone();
                self.needs.constants.insert(constant.clone());
                return Ok(Place::variable(&super::constants::name(&constant), ty));
            }
        }
        self.refuse(format!("the name {name}"))
    }

    /// The type of an expression; `None` if it follows from the context.
    pub fn infer(&mut self, expression: &Expr) -> Result<Option<Type>> {
        Ok(match bare(expression) {
            Expr::Lit(value) => match &value.lit {
                syn::Lit::Bool(_) => Some(Type::Bool),
                other => suffix(other).map(Type::Int),
            },
            Expr::Unary(unary) => self.infer(&unary.expr)?,
            Expr::Cast(cast) => Some(self.items.type_of(self.module, &cast.ty)?),
            Expr::Binary(binary) => match binary.op {
                BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::BitAnd(_) => {
                    match self.infer(&binary.left)? {
                        Some(ty) => Some(ty),
                        None => self.infer(&binary.right)?,
                    }
                }
                BinOp::Shl(_) | BinOp::Shr(_) => self.infer(&binary.left)?,
                _ => Some(Type::Bool),
            },
            Expr::Array(array) => {
                let mut element = None;
                for one in &array.elems {
                    if element.is_none() {
                        element = self.infer(one)?;
                    }
                }
                let element = element.unwrap_or(Type::Int(Int::I32));
                Some(Type::Array(Box::new(element), array.elems.len()))
            }
            Expr::Struct(value) => {
                let name = last(&value.path);
                let name = match (name.as_str(), self.owner) {
                    ("Self", Some(owner)) => owner.to_string(),
                    _ => name,
                };
                Some(self.items.named(self.module, &name)?)
            }
            Expr::If(value) => match self.infer_block(&value.then_branch)? {
                Some(ty) => Some(ty),
                None => match &value.else_branch {
                    Some((_, otherwise)) => self.infer(otherwise)?,
                    None => Some(Type::Unit),
                },
            },
            Expr::Block(block) => self.infer_block(&block.block)?,
            Expr::MethodCall(call) => match call.method.to_string().as_str() {
                "to_bits" | "clamp" => self.infer(&call.receiver)?,
                _ => {
                    let call = self.resolved(expression)?;
                    Some(self.function(&call.key)?.returns.clone())
                }
            },
            Expr::Call(call) => {
                let Expr::Path(path) = &*call.func else {
                    return self.refuse("this call");
                };
                let first = path.path.segments[0].ident.to_string();
                let name = last(&path.path);
                if let Some(word) = self.word(&first) {
                    Some(word)
                } else if name == "from" {
                    Int::from_name(&first).map(Type::Int)
                } else {
                    let call = self.resolved(expression)?;
                    Some(self.function(&call.key)?.returns.clone())
                }
            }
            Expr::Path(_) | Expr::Field(_) | Expr::Index(_) => Some(self.place(expression)?.ty),
            other => return self.refuse(kind(other)),
        })
    }

    /// The type of a block's last expression, if it can be found without the block's names.
    fn infer_block(&mut self, block: &syn::Block) -> Result<Option<Type>> {
        match block.stmts.last() {
            Some(syn::Stmt::Expr(last, None)) if block.stmts.len() == 1 => self.infer(last),
            Some(syn::Stmt::Expr(_, None)) => Ok(None),
            _ => Ok(Some(Type::Unit)),
        }
    }
}

/// `NotAligned` is `FLYWHEEL_NOT_ALIGNED`.
pub fn enumerator(name: &str) -> String {
    format!("FLYWHEEL_{}", super::types::snake(name).to_uppercase())
}

/// What an expression is, for messages.
fn kind(expression: &Expr) -> String {
    let text = quote::quote!(#expression).to_string();
    format!("`{}`", text.chars().take(60).collect::<String>())
}
