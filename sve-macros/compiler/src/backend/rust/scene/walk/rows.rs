//! Rows of sites: where they are read, and where their indices are checked.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::{Row, Walk};
use crate::model::scene::{Int, SlotArray};

impl Walk<'_> {
    /// Returns the row of a site. The index is in range after the printed code.
    pub(super) fn row(&mut self, array: &SlotArray, code: &mut TokenStream) -> Ident {
        let name = self.row_name(array);
        if self.rows.iter().any(|row| row.array == *array) {
            self.check(array, code);
            return name;
        }
        let (private, text) = (self.formulas.private, self.text_of(array));
        let (rows, site) = match array {
            SlotArray::Velocity(site) => (quote!(v), *site),
            SlotArray::Momentum(site) => (quote!(p), *site),
            SlotArray::Configuration(site) => (quote!(q), *site),
            _ => return name,
        };
        let at = self.integer(site, code);
        let entry = self.checked(&quote!(#private::scene::entry(#rows, #at, #text)));
        code.extend(quote!(let #name = *#entry;));
        let array = array.clone();
        let is_checked = true;
        self.rows.push(Row { array, is_checked });
        name
    }

    /// Checks the index of a row that was read before a loop.
    pub(super) fn check(&mut self, array: &SlotArray, code: &mut TokenStream) {
        let is_open = |row: &&mut Row| row.array == *array && !row.is_checked;
        let Some(row) = self.rows.iter_mut().find(is_open) else {
            return;
        };
        row.is_checked = true;
        if let SlotArray::Configuration(site) = array {
            let (private, text) = (self.formulas.private, self.text_of(array));
            let at = self.integer(*site, code);
            let check = self.checked(&quote!(#private::scene::check(#at, q.len(), #text)));
            code.extend(quote!(#check;));
        }
    }

    pub(super) fn row_name(&mut self, array: &SlotArray) -> Ident {
        match array {
            SlotArray::Velocity(site) => format_ident!("velocity_{}", self.number_of(*site)),
            SlotArray::Momentum(site) => format_ident!("momentum_{}", self.number_of(*site)),
            SlotArray::Configuration(site) => format_ident!("row_{}", self.number_of(*site)),
            _ => format_ident!("none"),
        }
    }

    pub(super) fn gathered_name(&mut self, site: Int) -> Ident {
        format_ident!("gathered_{}", self.number_of(site))
    }
}
