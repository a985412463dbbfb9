//! Patterns: names, tuples, arrays, `_`.

use syn::Pat;
use syn::spanned::Spanned;

use super::Lowering;
use super::value::Value;

impl Lowering<'_> {
    /// Binds the names of a pattern in the innermost scope.
    pub(super) fn bind(&mut self, pattern: &Pat, value: Value) {
        match pattern {
            Pat::Ident(ident) if ident.subpat.is_none() => {
                if let Some(scope) = self.scopes.last_mut() {
                    scope.insert(ident.ident.to_string(), value);
                }
            }
            Pat::Wild(_) => {}
            Pat::Paren(inner) => self.bind(&inner.pat, value),
            Pat::Type(typed) => self.bind(&typed.pat, value),
            Pat::Reference(reference) => self.bind(&reference.pat, value),
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
        let values = match value {
            Value::Tuple(values) if wanted == "tuple" => values,
            Value::Array(values) if wanted == "array" => values,
            Value::Field(path) if wanted == "array" => (0..patterns.len())
                .map(|i| Value::Field(path.index(i)))
                .collect(),
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
        if values.len() != patterns.len() {
            self.errors.push(
                whole.span(),
                format!(
                    "this pattern has {} entries, and the value has {}: name each, or write `_`",
                    patterns.len(),
                    values.len()
                ),
            );
        }
        let mut values = values.into_iter();
        for pattern in patterns {
            self.bind(pattern, values.next().unwrap_or(Value::Poison));
        }
    }

    /// After a pattern that is not understood: its names hold errors, so that their uses report nothing.
    fn poison_names(&mut self, pattern: &Pat) {
        struct Names(Vec<String>);
        impl<'ast> syn::visit::Visit<'ast> for Names {
            fn visit_pat_ident(&mut self, ident: &'ast syn::PatIdent) {
                self.0.push(ident.ident.to_string());
            }
        }
        let mut names = Names(Vec::new());
        syn::visit::Visit::visit_pat(&mut names, pattern);
        if let Some(scope) = self.scopes.last_mut() {
            for name in names.0 {
                scope.insert(name, Value::Poison);
            }
        }
    }
}
