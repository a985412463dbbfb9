//! The identity of a system: a hash of its formulas, and the values of its parameters.
//!
//! Input: the model. Output: members of `impl System`. Invariant: the hash is that of the
//! expressions as they were read, so that names of functions, comments and the rules do not matter;
//! equal formulas that are written in another way may have another one.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::hash::Hasher as _;

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use twox_hash::XxHash64;

use super::number;
use crate::algebra::{Arena, Expr, Node};
use crate::model::{Meaning, Model};

/// `FORMULAS`, and `parameters` where there are some.
pub(super) fn identity(model: &Model, arena: &Arena, private: &TokenStream) -> TokenStream {
    let formulas = Literal::u64_unsuffixed(hash(model, arena));
    let parameters = model.symbols.parameters();
    let values: Vec<TokenStream> = parameters
        .filter_map(|symbol| match model.symbols.meaning(symbol) {
            Meaning::Parameter { access, .. } => Some(number(access, private)),
            _ => None,
        })
        .collect();
    let visited = (!values.is_empty()).then(|| {
        quote! {
            fn parameters(&self, visit: &mut dyn ::core::ops::FnMut(f64)) {
                #(visit(#values);)*
            }
        }
    });
    quote! {
        const FORMULAS: u64 = #formulas;
        #visited
    }
}

/// The hash of L, the noises and the force: a line for each part of their expressions, in the order
/// of evaluation.
fn hash(model: &Model, arena: &Arena) -> u64 {
    let mut roots = vec![("L", model.lagrangian)];
    roots.extend(
        model
            .noises
            .iter()
            .map(|noise| ("noise", noise.hamiltonian)),
    );
    let force = model.forces().flatten();
    roots.extend(force.map(|&component| ("force", component)));
    let constraints = model.constraints.iter().map(|constraint| constraint.value);
    roots.extend(constraints.map(|value| ("constraint", value)));
    let expressions: Vec<Expr> = roots.iter().map(|&(_, expr)| expr).collect();
    let mut places = HashMap::new();
    let mut text = String::new();
    for expr in arena.reachable(&expressions, |_| true) {
        let line = line(model, arena, expr, &places);
        // writing to a string does not fail
        let _ = writeln!(text, "{line}");
        places.insert(expr, places.len());
    }
    for (what, expr) in roots {
        let _ = writeln!(text, "{what} {:?}", places.get(&expr));
    }
    let mut hash = XxHash64::default();
    hash.write(text.as_bytes());
    hash.finish()
}

/// An expression over those that stand at their places before it.
fn line(model: &Model, arena: &Arena, expr: Expr, places: &HashMap<Expr, usize>) -> String {
    let place = |expr: &Expr| places.get(expr).copied().unwrap_or(usize::MAX);
    let bits = |x: f64| format!("{:016x}", x.to_bits());
    match arena.node(expr) {
        Node::Constant(x) => bits(x.get()),
        Node::Symbol(symbol) => model.symbols.source(*symbol),
        Node::Sum(constant, terms) => {
            let terms = terms.iter().map(|(e, x)| (place(e), bits(x.get())));
            format!(
                "sum {} {:?}",
                bits(constant.get()),
                terms.collect::<Vec<_>>()
            )
        }
        Node::Product(factors) => {
            let factors = factors.iter().map(|(e, n)| (place(e), n));
            format!("product {:?}", factors.collect::<Vec<_>>())
        }
        Node::Call(function, e) => format!("{function:?} {}", place(e)),
        Node::Call2(function, a, b) => format!("{function:?} {} {}", place(a), place(b)),
        Node::Opaque(e, _) => format!("opaque {}", place(e)),
    }
}
