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
                if let Some(scope) = self.scopes.last_mut() {
                    scope.insert(ident.ident.to_string(), value);
                }
            }
            Pat::Wild(_) | Pat::Rest(_) => {}
            Pat::Paren(inner) => self.bind(&inner.pat, value),
            Pat::Type(typed) => {
                let value = self.ascribed(value, &typed.ty);
                self.bind(&typed.pat, value);
            }
            Pat::Reference(reference) => {
                let value = self.read_through(value);
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
                self.poison_names(pattern);
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
        let value = match value {
            Value::Place(place) => match (self.split_reference(&place), wanted) {
                (Some(parts), "tuple") => Value::Tuple(parts),
                (Some(parts), _) => Value::Array(parts),
                (None, _) => Value::Poison,
            },
            value => value.unconverted(),
        };
        let values = match value {
            Value::Tuple(values) if wanted == "tuple" => values,
            Value::Array(values) if wanted == "array" => values,
            // `v.into()`
            Value::Matrix(matrix) if wanted == "array" => matrix.entries,
            // the length of a field's array is not known, so its entries can only be counted from the start
            Value::Field(path)
                if wanted == "array" && rest.is_none_or(|at| at + 1 == patterns.len()) =>
            {
                (0..patterns.len())
                    .map(|i| Value::Field(path.index(i)))
                    .collect()
            }
            Value::Poison => {
                for pattern in patterns {
                    self.bind(pattern, Value::Poison);
                }
                return;
            }
            other => {
                self.errors.push(
                    whole.span(),
                    format!(
                        "this pattern takes {} apart, which is not a {wanted}",
                        other.kind()
                    ),
                );
                for pattern in patterns {
                    self.bind(pattern, Value::Poison);
                }
                return;
            }
        };
        let named = patterns.len() - usize::from(rest.is_some());
        if values.len() < named || (rest.is_none() && values.len() > named) {
            self.errors.push(
                whole.span(),
                format!(
                    "this pattern has {}, and the value has {}: name each, or write `_` or `..`",
                    entries(named),
                    values.len()
                ),
            );
        }
        let skipped = values.len().saturating_sub(named);
        let mut values = values.into_iter();
        for (at, pattern) in patterns.iter().enumerate() {
            if rest == Some(at) {
                let middle: Vec<Value> = values.by_ref().take(skipped).collect();
                if let Pat::Ident(name) = pattern
                    && let Some(scope) = self.scopes.last_mut()
                {
                    scope.insert(name.ident.to_string(), Value::Array(middle));
                }
                continue;
            }
            self.bind(pattern, values.next().unwrap_or(Value::Poison));
        }
    }

    /// Declares the names of `let x;`, which have no values yet.
    pub(super) fn declare(&mut self, pattern: &Pat) {
        for name in names(pattern) {
            if let Some(scope) = self.scopes.last_mut() {
                scope.insert(name, Value::Unset);
            }
        }
    }

    /// Returns a value, or reports an error if it is nested too deeply for a variable.
    pub(super) fn shallow(&mut self, value: Value, at: &impl Spanned) -> Value {
        if value.is_deeper(NESTING) {
            return self.refuse(at, format!("arrays nested more than {NESTING} deep"));
        }
        value
    }

    /// Poisons the names of a pattern that is not understood, so that their uses report no further errors.
    pub(super) fn poison_names(&mut self, pattern: &Pat) {
        for name in names(pattern) {
            if let Some(scope) = self.scopes.last_mut() {
                scope.insert(name, Value::Poison);
            }
        }
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
