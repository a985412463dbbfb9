//! Patterns: names, tuples, arrays, `_`.

use syn::Pat;
use syn::spanned::Spanned;

use super::Lowering;
use super::value::Value;

/// Largest depth of nested arrays and tuples in a variable. Deeper values would overflow the stack.
const NESTING: usize = 32;

impl Lowering<'_> {
    /// Binds the names of a pattern in the innermost scope.
    pub(super) fn bind(&mut self, pattern: &Pat, value: Value) {
        match pattern {
            Pat::Ident(ident) => {
                let value = self.shallow(value, pattern);
                if let Some((_, inner)) = &ident.subpat {
                    self.bind(inner, value.clone());
                }
                self.frame.set(&ident.ident, value);
            }
            Pat::Wild(_) | Pat::Rest(_) => {}
            Pat::Paren(inner) => self.bind(&inner.pat, value),
            Pat::Type(typed) => {
                let value = self.ascribed(value, &typed.ty);
                self.bind(&typed.pat, value);
            }
            Pat::Reference(reference) => {
                let value = self.frame.read_through(value);
                self.bind(&reference.pat, value);
            }
            Pat::Tuple(tuple) => self.bind_list(pattern, &tuple.elems, value, "tuple"),
            Pat::Slice(slice) => self.bind_list(pattern, &slice.elems, value, "array"),
            Pat::TupleStruct(fields) if matches!(value, Value::Field(_)) => {
                let Value::Field(path) = value else { return };
                for (at, field) in fields.elems.iter().enumerate() {
                    self.bind(field, Value::Field(path.member(&syn::Member::from(at))));
                }
            }
            // `let Self { mass, length } = self;`
            Pat::Struct(fields) if matches!(value, Value::Field(_)) => {
                let Value::Field(path) = value else { return };
                for field in &fields.fields {
                    self.bind(&field.pat, Value::Field(path.member(&field.member)));
                }
            }
            _ => {
                self.errors.push(pattern.span(), "this pattern is not understood: bind names, tuples `(a, b)` or arrays `[a, b]`");
                self.declare(pattern, &Value::Poison);
            }
        }
    }

    fn bind_list(
        &mut self,
        whole: &Pat,
        patterns: &syn::punctuated::Punctuated<Pat, syn::Token![,]>,
        value: Value,
        wanted: &str,
    ) {
        let rest = patterns.iter().position(is_rest);
        let values = match (value.unconverted(), wanted) {
            (Value::Place(place), _) => self.frame.split_reference(&place),
            (Value::Tuple(values), "tuple") | (Value::Array(values), "array") => Some(values),
            // `v.into()`
            (Value::Matrix(matrix), "array") => Some(matrix.entries),
            // the length of a field's array is not known, so its entries can only be counted from
            // the start
            (Value::Field(path), "array") if rest.is_none_or(|at| at + 1 == patterns.len()) => {
                let entries = 0..patterns.len();
                Some(entries.map(|i| Value::Field(path.index(i))).collect())
            }
            (Value::Field(path), _) if self.scene.is_scene() => {
                let entries = 0..patterns.len();
                Some(
                    entries
                        .map(|i| Value::Field(path.member(&i.into())))
                        .collect(),
                )
            }
            (Value::Poison, _) => None,
            (other, _) => {
                let kind = other.kind();
                let message = format!("this pattern takes {kind} apart, which is not a {wanted}");
                self.refuse(whole, message)
            }
        };
        let Some(values) = values else {
            for pattern in patterns {
                self.bind(pattern, Value::Poison);
            }
            return;
        };
        let named = patterns.len() - usize::from(rest.is_some());
        if values.len() < named || (rest.is_none() && values.len() > named) {
            let message = format!(
                "this pattern has {}, and the value has {}: name each, or write `_` or `..`",
                entries(named),
                values.len()
            );
            self.errors.push(whole.span(), message);
        }
        let skipped = values.len().saturating_sub(named);
        let mut values = values.into_iter();
        for (at, pattern) in patterns.iter().enumerate() {
            if rest == Some(at) {
                let middle: Vec<Value> = values.by_ref().take(skipped).collect();
                if let Pat::Ident(name) = pattern {
                    self.frame.set(&name.ident, Value::Array(middle));
                }
                continue;
            }
            self.bind(pattern, values.next().unwrap_or(Value::Poison));
        }
    }

    /// Gives the names of a pattern a value: no value yet after `let x;`, or a poisoned value if
    /// the pattern is not understood, so that its uses report no further errors.
    pub(super) fn declare(&mut self, pattern: &Pat, value: &Value) {
        for name in names(pattern) {
            self.frame.set(&name, value.clone());
        }
    }

    /// Returns a value, or reports an error if it is nested too deeply for a variable.
    pub(super) fn shallow(&mut self, value: Value, at: &impl Spanned) -> Value {
        if !value.is_deeper(NESTING) {
            return value;
        }
        let message = format!("arrays nested more than {NESTING} deep");
        self.errors.push(at.span(), message);
        Value::Poison
    }
}

fn entries(n: usize) -> String {
    match n {
        1 => "1 entry".to_owned(),
        _ => format!("{n} entries"),
    }
}

/// Returns whether a pattern is `..` or `rest @ ..`.
fn is_rest(pattern: &Pat) -> bool {
    match pattern {
        Pat::Rest(_) => true,
        Pat::Ident(name) => name
            .subpat
            .as_ref()
            .is_some_and(|(_, inner)| matches!(**inner, Pat::Rest(_))),
        _ => false,
    }
}

/// Returns the names that a pattern binds.
fn names(pattern: &Pat) -> Vec<String> {
    struct Names(Vec<String>);
    impl<'ast> syn::visit::Visit<'ast> for Names {
        fn visit_pat_ident(&mut self, ident: &'ast syn::PatIdent) {
            self.0.push(ident.ident.to_string());
        }
    }
    let mut names = Names(Vec::new());
    syn::visit::Visit::visit_pat(&mut names, pattern);
    names.0
}
