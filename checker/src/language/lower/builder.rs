//! The builder of a program: its words so far, and the context in which a body is read.

use std::collections::HashMap;
use std::sync::Arc;

use syn::spanned::Spanned;

use crate::language::declarations::{Constants, Declarations, Named, Read, refuse, shown};
use crate::program::contract::Contract;
use crate::program::place::SourcePlace;
use crate::program::steps::Slot;
use crate::program::types::Type;

/// The words of a value.
#[derive(Clone, Debug)]
pub(super) struct Value {
    pub(super) type_: Type,
    pub(super) slots: Vec<Slot>,
}

/// The context in which the body of one function is read.
#[derive(Clone, Debug)]
pub(super) struct Scope {
    pub(super) module: usize,
    pub(super) path: Arc<str>,
    pub(super) owner: Option<usize>,
    pub(super) variables: Vec<(String, Value)>,
    /// `assert!`, `abs` and `i128` are for constants that assert something.
    pub(super) is_assertion: bool,
    /// Whether the expression that is being read gives the value of the function. The reader
    /// accepts `return` only there.
    pub(super) is_tail: bool,
}

/// Builds one program.
pub(super) struct Builder<'a> {
    pub(super) declarations: &'a Declarations,
    pub(super) constants: &'a mut Constants,
    pub(super) contracts: &'a HashMap<usize, Contract>,
    pub(super) initial: Vec<i128>,
    pub(super) is_constant: Vec<bool>,
    pub(super) pool: HashMap<i128, Slot>,
    pub(super) places: Vec<SourcePlace>,
    /// Functions that are being put in place, against recursion.
    pub(super) stack: Vec<usize>,
}

impl<'a> Builder<'a> {
    pub(super) fn new(
        declarations: &'a Declarations,
        constants: &'a mut Constants,
        contracts: &'a HashMap<usize, Contract>,
    ) -> Self {
        Builder {
            declarations,
            constants,
            contracts,
            initial: Vec::new(),
            is_constant: Vec::new(),
            pool: HashMap::new(),
            places: Vec::new(),
            stack: Vec::new(),
        }
    }
}

impl Builder<'_> {
    pub(super) fn slot(&mut self) -> Slot {
        self.initial.push(0);
        self.is_constant.push(false);
        self.initial.len() - 1
    }

    pub(super) fn fresh(&mut self, type_: &Type) -> Value {
        let width = self.declarations.width(type_);
        Value {
            type_: type_.clone(),
            slots: (0..width).map(|_| self.slot()).collect(),
        }
    }

    pub(super) fn known(&mut self, value: i128) -> Slot {
        if let Some(slot) = self.pool.get(&value) {
            return *slot;
        }
        let slot = self.slot();
        self.initial[slot] = value;
        self.is_constant[slot] = true;
        self.pool.insert(value, slot);
        slot
    }

    pub(super) fn at(&mut self, scope: &Scope, span: proc_macro2::Span) -> u32 {
        self.places.push(SourcePlace::of(&scope.path, span));
        u32::try_from(self.places.len() - 1).unwrap_or(u32::MAX)
    }

    pub(super) fn mismatch<T>(
        &self,
        scope: &Scope,
        span: proc_macro2::Span,
        expected: &Type,
        found: &Type,
    ) -> Read<T> {
        refuse(
            &scope.path,
            span,
            format!(
                "a {} is expected, found a {}",
                self.declarations.type_name(expected),
                self.declarations.type_name(found)
            ),
        )
    }

    pub(super) fn require(
        &self,
        scope: &Scope,
        span: proc_macro2::Span,
        expected: &Type,
        found: &Type,
    ) -> Read<()> {
        if expected == found {
            Ok(())
        } else {
            self.mismatch(scope, span, expected, found)
        }
    }

    pub(super) fn field(
        &self,
        scope: &Scope,
        type_: &Type,
        member: &syn::Member,
    ) -> Read<(usize, Type)> {
        let name = match member {
            syn::Member::Named(name) => name.to_string(),
            syn::Member::Unnamed(index) => index.index.to_string(),
        };
        let fields: Vec<(String, Type)> = match type_ {
            Type::Struct(index) => self.declarations.structs[*index].fields.clone(),
            Type::Tuple(elements) => elements
                .iter()
                .enumerate()
                .map(|(index, type_)| (index.to_string(), type_.clone()))
                .collect(),
            _ => Vec::new(),
        };
        let mut offset = 0;
        for (field, type_) in fields {
            if field == name {
                return Ok((offset, type_));
            }
            offset += self.declarations.width(&type_);
        }
        refuse(
            &scope.path,
            member.span(),
            format!(
                "a {} has no field `{name}`",
                self.declarations.type_name(type_)
            ),
        )
    }

    /// The target of an assignment or of a `&mut` receiver: variable, offset and type.
    pub(super) fn target(
        &self,
        scope: &Scope,
        expression: &syn::Expr,
    ) -> Read<(usize, usize, Type)> {
        match expression {
            syn::Expr::Path(path) => {
                if let Some(name) = path.path.get_ident()
                    && let Some(index) = scope.variables.iter().rposition(|(n, _)| name == n)
                {
                    return Ok((index, 0, scope.variables[index].1.type_.clone()));
                }
                refuse(
                    &scope.path,
                    path.span(),
                    format!("{} cannot be assigned to", shown(path)),
                )
            }
            syn::Expr::Field(field) => {
                let (variable, base, type_) = self.target(scope, &field.base)?;
                let (offset, type_) = self.field(scope, &type_, &field.member)?;
                Ok((variable, base + offset, type_))
            }
            other => refuse(
                &scope.path,
                other.span(),
                format!("{} cannot be assigned to", shown(other)),
            ),
        }
    }

    pub(super) fn struct_number(&self, scope: &Scope, path: &syn::Path) -> Option<usize> {
        let name = path.get_ident()?.to_string();
        if name == "Self" {
            return scope.owner;
        }
        match self.declarations.files[scope.module].names.get(&name) {
            Some(Named::Type(Type::Struct(number))) => Some(*number),
            _ => None,
        }
    }
}
