//! Instances of the terms of the kinetic energy.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;

use super::Walk;
use crate::model::scene::SlotArray;
use crate::scene::Kinetic;

impl Walk<'_> {
    /// Shows an instance of a term of the kinetic energy to the visitor.
    pub(super) fn visit_kinetic(&mut self, number: usize, code: &mut TokenStream) {
        let Kinetic::Sites { terms, .. } = &self.derived.kinetic else {
            return;
        };
        let term = &terms[number];
        let site = self.integer(term.site, code);
        for &column in &term.columns {
            self.symbol(column, code);
        }
        let columns = term.columns.iter();
        let columns: Vec<Ident> = columns.map(|&column| self.symbol_name(column)).collect();
        let text = self.text_of(&SlotArray::Velocity(term.site));
        let number = Literal::usize_unsuffixed(number);
        let term = self.checked(&quote!(to.term(#number, #site, &[#(#columns),*], #text)));
        code.extend(quote!(#term;));
    }
}
