//! Integers, paths to entries of fields, and conditions, as a walk of loops reads them.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::super::super::ident;
use super::Walk;
use crate::model::scene::{Access, Array, Comparison, Condition, Int, IntNode, Step};

impl Walk<'_> {
    /// Returns an integer as an expression without effects.
    pub(in super::super) fn integer(&mut self, int: Int, code: &mut TokenStream) -> TokenStream {
        let (scene, private) = (self.scene(), self.formulas.private);
        match scene.integers.node(int) {
            IntNode::Constant(value) => {
                let literal = Literal::i64_suffixed(*value);
                return quote!((#literal));
            }
            IntNode::Counter(counter) => {
                let counter = format_ident!("counter_{}", counter.0);
                return quote!(#counter);
            }
            IntNode::Length(Array::Sites) => return quote!((n as i64)),
            _ => {}
        }
        let name = format_ident!("int_{}", self.number_of(int));
        if self.known.contains(&int) {
            return quote!(#name);
        }
        let value = match scene.integers.node(int) {
            IntNode::Length(Array::Field(access)) => {
                let place = self.field(access, code);
                quote!(#place.len() as i64)
            }
            IntNode::Field(access) => {
                let place = self.field(access, code);
                quote!(#private::scene::integer(*#place))
            }
            &IntNode::Add(a, b) => self.method(a, "wrapping_add", b, code),
            &IntNode::Sub(a, b) => self.method(a, "wrapping_sub", b, code),
            &IntNode::Mul(a, b) => self.method(a, "wrapping_mul", b, code),
            &IntNode::Min(a, b) => self.method(a, "min", b, code),
            &IntNode::Max(a, b) => self.method(a, "max", b, code),
            IntNode::Div(a, b) | IntNode::Rem(a, b) => {
                let function = match scene.integers.node(int) {
                    IntNode::Div(..) => ident("quotient"),
                    _ => ident("remainder"),
                };
                let [a, b] = [*a, *b].map(|operand| self.integer(operand, code));
                let text = self.text(&scene.integers.text(int));
                self.checked(&quote!(#private::scene::#function(#a, #b, #text)))
            }
            IntNode::Constant(_) | IntNode::Counter(_) | IntNode::Length(Array::Sites) => {
                TokenStream::new()
            }
        };
        self.known.push(int);
        code.extend(quote!(let #name: i64 = #value;));
        quote!(#name)
    }

    fn method(&mut self, a: Int, name: &str, b: Int, code: &mut TokenStream) -> TokenStream {
        let [a, b] = [a, b].map(|operand| self.integer(operand, code));
        let name = match name {
            "min" | "max" => {
                let name = ident(name);
                quote!(::core::cmp::Ord::#name)
            }
            _ => {
                let name = ident(name);
                quote!(i64::#name)
            }
        };
        quote!(#name(#a, #b))
    }

    /// Returns the place of a field, as an expression that can be borrowed.
    pub(super) fn field(&mut self, access: &Access, code: &mut TokenStream) -> TokenStream {
        let private = self.formulas.private;
        let mut place = quote!(self);
        let mut is_reference = true;
        for (at, step) in access.steps.iter().enumerate() {
            let found = match step {
                Step::Member(member) => {
                    place = quote!(#place.#member);
                    is_reference = false;
                    continue;
                }
                Step::Index(index) => {
                    let index = self.integer(*index, code);
                    quote! {
                        #place.get(#private::scene::position(#index)),
                        #index,
                        #place.len(),
                    }
                }
                Step::Pair(row, column) => {
                    let [row, column] = [*row, *column].map(|index| self.integer(index, code));
                    quote! {
                        #place.get((#private::scene::position(#row), #private::scene::position(#column))),
                        if #private::scene::position(#row) < #place.nrows() { #column } else { #row },
                        if #private::scene::position(#row) < #place.nrows() { #place.ncols() } else { #place.nrows() },
                    }
                }
            };
            let steps = access.steps[..=at].to_vec();
            let text = self.text(&self.scene().integers.path_text(&Access { steps }));
            let name = format_ident!("place_{}", self.places);
            self.places += 1;
            let found = self.checked(&quote!(#private::scene::place(#found #text)));
            code.extend(quote!(let #name = #found;));
            place = quote!(#name);
            is_reference = true;
        }
        if is_reference {
            place
        } else {
            quote!((&#place))
        }
    }

    /// Returns a condition as an expression.
    pub(super) fn condition(
        &mut self,
        condition: &Condition,
        code: &mut TokenStream,
    ) -> TokenStream {
        match condition {
            Condition::Integers(comparison, a, b) => {
                let [a, b] = [*a, *b].map(|operand| self.integer(operand, code));
                let comparison = operator(*comparison);
                quote!((#a #comparison #b))
            }
            Condition::Numbers(comparison, a, b) => {
                let arena = self.formulas.arena;
                for symbol in [*a, *b].into_iter().flat_map(|e| arena.symbols_of(e)) {
                    self.symbol(symbol, code);
                }
                let (statements, values) = self.formulas.within_loop(&[*a, *b]);
                let (comparison, [a, b]) = (operator(*comparison), [&values[0], &values[1]]);
                quote!({ #statements #a #comparison #b })
            }
            Condition::Not(inner) => {
                let inner = self.condition(inner, code);
                quote!((!#inner))
            }
            Condition::And(a, b) => {
                let [a, b] = [self.condition(a, code), self.condition_alone(b)];
                quote!((#a && #b))
            }
            Condition::Or(a, b) => {
                let [a, b] = [self.condition(a, code), self.condition_alone(b)];
                quote!((#a || #b))
            }
        }
    }

    /// Returns a condition that reads in its own block, since another one decides whether it may.
    fn condition_alone(&mut self, condition: &Condition) -> TokenStream {
        let [known, symbols] = [self.known.len(), self.symbols.len()];
        let rows = self.rows.clone();
        let mut code = TokenStream::new();
        let value = self.condition(condition, &mut code);
        self.known.truncate(known);
        self.symbols.truncate(symbols);
        self.rows = rows;
        quote!({ #code #value })
    }
}

fn operator(comparison: Comparison) -> TokenStream {
    match comparison {
        Comparison::Equal => quote!(==),
        Comparison::Less => quote!(<),
        Comparison::LessOrEqual => quote!(<=),
    }
}
