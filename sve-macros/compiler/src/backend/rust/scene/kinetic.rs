//! A kinetic energy that is no sum of `½ m v²` of components: its terms, and their derivatives.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::super::function::Formulas;
use super::super::ident;
use super::walk::{Action, Leaf, Walk};
use crate::program::symbol_name;
use crate::scene::{Derived, KineticTerm, Root};

/// `kinetic_terms` and `kinetic`: the terms of each site, and their derivatives.
pub(super) fn kinetic(
    derived: &Derived,
    terms: &[KineticTerm],
    is_affine: bool,
    formulas: Formulas<'_>,
) -> TokenStream {
    let private = formulas.private;
    let loops = derived.roots.iter().enumerate().map(|(number, root)| {
        let of_root = terms
            .iter()
            .enumerate()
            .filter(|term| term.1.root == number);
        let leaves = of_root.map(|(at, term)| Leaf {
            sum: term.sum,
            values: Vec::new(),
            conditions: Vec::new(),
            action: Action::VisitKinetic(at),
        });
        let Root { sum, function, .. } = root;
        Walk::new(derived, formulas, function, leaves.collect()).root(*sum)
    });
    let derivatives = terms.iter().enumerate().map(|(at, term)| {
        let (at, body) = (Literal::usize_unsuffixed(at), derivatives(term, formulas));
        quote!(#at => { #body })
    });
    let form = ident(if is_affine { "Affine" } else { "General" });
    quote! {
        const KINETIC: #private::scene::KineticForm = #private::scene::KineticForm::#form;
        fn kinetic_terms(
            &self,
            n: usize,
            to: &mut #private::scene::KineticTerms,
        ) -> ::core::result::Result<(), #private::scene::IndexError> {
            #({ #loops })*
            ::core::result::Result::Ok(())
        }
        #[inline(always)]
        fn kinetic(
            &self,
            term: usize,
            columns: &[f64],
            v: &Self::Row,
            to: &mut #private::scene::KineticJet<Self::Row>,
        ) {
            match term {
                #(#derivatives)*
                _ => {}
            }
        }
    }
}

/// The derivatives of a term, added to `to`.
fn derivatives(term: &KineticTerm, formulas: Formulas<'_>) -> TokenStream {
    let name = |symbol| ident(&symbol_name(formulas.symbols, symbol));
    let velocities = term.velocities.iter().map(|&(symbol, component)| {
        let (name, component) = (name(symbol), Literal::usize_unsuffixed(component));
        quote!(let #name: f64 = v[#component];)
    });
    let columns = term.columns.iter().enumerate().map(|(at, &symbol)| {
        let (name, at) = (name(symbol), Literal::usize_unsuffixed(at));
        quote!(let #name: f64 = columns[#at];)
    });
    let masses = term.masses.iter().flatten();
    let values = term.momenta.iter().chain(masses).chain(&term.conditions);
    let values: Vec<_> = values.copied().collect();
    let (statements, values) = formulas.within_loop(&values);
    let mut values = values.into_iter();
    let components = term
        .velocities
        .iter()
        .map(|v| Literal::usize_unsuffixed(v.1));
    let components: Vec<Literal> = components.collect();
    let mut code = quote!(#(#velocities)* #(#columns)* #statements);
    for row in &components {
        let value = values.next();
        code.extend(quote!(to.dv[#row] += #value;));
    }
    for row in &components {
        for column in &components {
            let value = values.next();
            code.extend(quote!(to.dvv[#row][#column] += #value;));
        }
    }
    code.extend(quote!(#(to.needs_positive(#values);)*));
    code
}
