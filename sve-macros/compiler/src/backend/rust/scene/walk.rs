//! Loops as the user wrote them, with checked indices.
//!
//! Input: summands, each with what is done in an instance. Output: the loops and conditions around
//! them. Integers, rows and fields are read where they are first needed. A site whose index does
//! not change in the innermost loop is read before that loop, and what is added to the site is
//! gathered in a variable until the end of the loop; the index is checked where the site is used.

mod blocks;
mod computed;
mod integers;
mod kinetic;
mod leaf;
mod rows;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::super::function::Formulas;
use super::super::{ident, number, verbatim};
use super::nodes::where_defined;
use crate::algebra::Symbol;
use crate::model::scene::{
    Array, Counter, Each, Head, Int, IntNode, Scene, Slot, SlotArray, SumId,
};
use crate::program::symbol_name;
use crate::scene::Derived;
pub(super) use leaf::{Action, Leaf};

/// Returns whether the computation of an integer may end with an error.
fn may_fail(node: &IntNode) -> bool {
    matches!(
        node,
        IntNode::Field(_) | IntNode::Length(Array::Field(_)) | IntNode::Div(..) | IntNode::Rem(..)
    )
}

/// Prints the loops of a root.
pub(super) struct Walk<'a> {
    derived: &'a Derived,
    formulas: Formulas<'a>,
    function: &'a str,
    leaves: Vec<Leaf>,
    /// All integers that have names, and those that are known where the code stands.
    integers: Vec<Int>,
    known: Vec<Int>,
    /// The symbols that are known where the code stands.
    symbols: Vec<Symbol>,
    /// The rows that are known where the code stands.
    rows: Vec<Row>,
    /// The sites with a variable for what is added to them.
    gathered: Vec<Int>,
    places: usize,
    /// The counters of the loops around, the outermost first.
    counters: Vec<Counter>,
}

/// A row that has been read.
#[derive(Clone, PartialEq)]
struct Row {
    array: SlotArray,
    is_checked: bool,
}

impl<'a> Walk<'a> {
    pub(super) fn new(
        derived: &'a Derived,
        formulas: Formulas<'a>,
        function: &'a str,
        leaves: Vec<Leaf>,
    ) -> Self {
        Self {
            derived,
            formulas,
            function,
            leaves,
            integers: Vec::new(),
            known: Vec::new(),
            symbols: Vec::new(),
            rows: Vec::new(),
            gathered: Vec::new(),
            places: 0,
            counters: Vec::new(),
        }
    }

    /// Prints a root with the loop `sum`, or without a loop.
    pub(super) fn root(&mut self, sum: Option<SumId>) -> TokenStream {
        self.block(None, sum.into_iter().collect())
    }

    fn scene(&self) -> &'a Scene {
        &self.derived.scene
    }

    /// Prints the body of a sum with these inner sums; without a sum, what is around a root.
    fn block(&mut self, sum: Option<SumId>, inner: Vec<SumId>) -> TokenStream {
        let [known, symbols, rows, gathered] = [
            self.known.len(),
            self.symbols.len(),
            self.rows.len(),
            self.gathered.len(),
        ];
        let checked = self.rows.clone();
        let mut code = TokenStream::new();
        for site in self.sites_before_loops(sum) {
            self.read_ahead(site, &mut code);
        }
        self.inner_totals(sum, &mut code);
        for at in 0..self.leaves.len() {
            if self.leaves[at].sum == sum {
                self.leaf(at, &mut code);
            }
        }
        for sum in inner {
            self.sum(sum, &mut code);
        }
        for site in self.gathered.split_off(gathered) {
            let (private, at) = (self.formulas.private, self.integer(site, &mut code));
            let gathered = self.gathered_name(site);
            code.extend(quote!(#private::scene::accumulate(to, #at, #gathered);));
        }
        self.known.truncate(known);
        self.symbols.truncate(symbols);
        self.rows.truncate(rows);
        self.rows.clone_from_slice(&checked);
        code
    }

    /// Prints a sum, unless it has no summand in print.
    fn sum(&mut self, sum: SumId, code: &mut TokenStream) {
        let scene = self.scene();
        let is_within = |leaf: &Leaf| scene.around(leaf.sum).any(|around| around == sum);
        if !self.leaves.iter().any(is_within) {
            return;
        }
        let sums = scene.sums.iter().enumerate();
        let inner = sums.filter(|(_, inner)| inner.parent == Some(sum));
        let inner: Vec<SumId> = inner.map(|(at, _)| SumId(at)).collect();
        match &scene.sums[sum.0].head {
            Head::For { counter, from, to } => {
                let [from, to] = [from, to].map(|bound| self.integer(*bound, code));
                let name = format_ident!("counter_{}", counter.0);
                self.counters.push(*counter);
                let body = self.block(Some(sum), inner);
                self.counters.pop();
                let plain = quote!(for #name in #from..#to { #body });
                let in_blocks = self.in_blocks(sum, *counter, [&from, &to], &plain);
                code.extend(in_blocks.unwrap_or(plain));
            }
            Head::If(condition) => {
                let condition = self.condition(condition, code);
                let body = self.block(Some(sum), inner);
                code.extend(quote!(if #condition { #body }));
            }
        }
    }

    /// Returns the sites that are read in the body of a sum, before its inner loops: their index is
    /// fixed there and used in a loop within.
    fn sites_before_loops(&self, sum: Option<SumId>) -> Vec<Int> {
        let scene = self.scene();
        let mut sites = Vec::new();
        for leaf in &self.leaves {
            let Action::AddRows(of_leaf) = &leaf.action else {
                continue;
            };
            let loops = scene.around(leaf.sum);
            let loops = loops.filter_map(|sum| match scene.sums[sum.0].head {
                Head::For { counter, .. } => Some((sum, counter)),
                Head::If(_) => None,
            });
            let loops: Vec<_> = loops.collect();
            for &site in of_leaf {
                let fixed_in = loops.iter().position(|l| scene.has_counter(site, l.1));
                let home = fixed_in.map(|at| loops[at].0);
                let is_before_loop = fixed_in != Some(0) && !loops.is_empty();
                if is_before_loop
                    && home == sum
                    && !scene.reads(site, &may_fail)
                    && !sites.contains(&site)
                {
                    sites.push(site);
                }
            }
        }
        sites
    }

    fn read_ahead(&mut self, site: Int, code: &mut TokenStream) {
        let private = self.formulas.private;
        let at = self.integer(site, code);
        let array = SlotArray::Configuration(site);
        let (row, gathered) = (self.row_name(&array), self.gathered_name(site));
        let size = Literal::usize_unsuffixed(self.scene().row.len());
        code.extend(quote! {
            let #row = #private::scene::row_if_any(q, #at);
            let mut #gathered = [0f64; #size];
        });
        let is_checked = false;
        self.rows.push(Row { array, is_checked });
        self.gathered.push(site);
    }

    /// Prints an instance of a summand.
    fn leaf(&mut self, at: usize, code: &mut TokenStream) {
        let private = self.formulas.private;
        let arena = self.formulas.arena;
        let Leaf {
            values, conditions, ..
        } = &self.leaves[at];
        let (values, conditions) = (values.clone(), conditions.clone());
        if let Action::AddRows(sites) = &self.leaves[at].action {
            for site in sites.clone() {
                self.row(&SlotArray::Configuration(site), code);
            }
        }
        for &value in values.iter().chain(&conditions) {
            for symbol in arena.symbols_of(value) {
                self.symbol(symbol, code);
            }
        }
        let (statements, values) = where_defined(&values, &conditions, self.formulas);
        code.extend(statements);
        match &self.leaves[at].action {
            Action::AddRows(sites) => {
                let size = self.scene().row.len();
                for (site, row) in sites.clone().into_iter().zip(values.chunks(size)) {
                    let target = if self.gathered.contains(&site) {
                        let name = self.gathered_name(site);
                        quote!(#name)
                    } else {
                        let at = self.integer(site, code);
                        quote!(to[#at as usize])
                    };
                    let components = (0..size).map(Literal::usize_unsuffixed);
                    code.extend(quote!(#(#target[#components] += #row;)*));
                }
            }
            &Action::AddComponent(site, component) => {
                let component = Literal::usize_unsuffixed(component);
                let (at, text) = (
                    self.integer(site, code),
                    self.text_of(&SlotArray::Velocity(site)),
                );
                let check = self.checked(&quote!(#private::scene::check(#at, n, #text)));
                code.extend(quote! {
                    #check;
                    to[#at as usize][#component] += #(#values)*;
                });
            }
            Action::AddValue => code.extend(quote!(value += #(#values)*;)),
            &Action::Visit(term) => self.visit(term, code),
            &Action::VisitKinetic(term) => self.visit_kinetic(term, code),
        }
    }

    /// Shows an instance of a term to the visitor.
    fn visit(&mut self, number: usize, code: &mut TokenStream) {
        let term = &self.derived.terms[number];
        let sites: Vec<TokenStream> = term.sites.iter().map(|&s| self.integer(s, code)).collect();
        for &column in &term.columns {
            self.symbol(column, code);
        }
        let columns = term.columns.iter();
        let columns: Vec<Ident> = columns.map(|&column| self.symbol_name(column)).collect();
        let increment = match term.increment {
            Some(each) => {
                let index = self.increment(each, code);
                quote!(#index as usize)
            }
            None => quote!(0),
        };
        let number = Literal::usize_unsuffixed(number);
        let call = quote!(to.instance(#number, &[#(#sites),*], &[#(#columns),*], #increment));
        let call = self.checked(&call);
        code.extend(quote!(#call;));
    }

    /// Returns the number of the increment of an instance of a function that returns a `Vec`.
    fn increment(&mut self, each: usize, code: &mut TokenStream) -> TokenStream {
        let Each { sum, of, .. } = self.derived.each[each];
        let offset = format_ident!("offset_{each}");
        let Head::For { counter, from, .. } = self.scene().sums[sum.0].head else {
            return quote!(#offset);
        };
        let from = self.integer(from, code);
        let counter = format_ident!("counter_{}", counter.0);
        let index = quote!((#counter - #from));
        let index = match of {
            1 => index,
            of => {
                let of = Literal::i64_suffixed(of as i64);
                quote!(#of * #index)
            }
        };
        quote!((#offset + #index))
    }

    /// Reads a symbol, unless it is known.
    fn symbol(&mut self, symbol: Symbol, code: &mut TokenStream) {
        if self.symbols.contains(&symbol) {
            // the row may be known from before a loop and not be checked
            if let Some(slot) = self.scene().slot(symbol) {
                self.check(&slot.array, code);
            }
            return;
        }
        let private = self.formulas.private;
        let each = self
            .derived
            .each
            .iter()
            .position(|each| each.increment == symbol);
        let value = if let Some(each) = each {
            let index = self.increment(each, code);
            let text = verbatim(&format!("the increment of `{}`", self.function));
            let entry = self.checked(&quote!(#private::scene::entry(dw, #index, #text)));
            quote!(*#entry)
        } else if let Some(Slot { array, component }) = self.scene().slot(symbol) {
            match array {
                SlotArray::Configuration(_) | SlotArray::Velocity(_) | SlotArray::Momentum(_) => {
                    let component = Literal::usize_unsuffixed(*component);
                    let row = self.row(array, code);
                    quote!(#row[#component])
                }
                SlotArray::Field(access) => {
                    let place = self.field(access, code);
                    number(&quote!(*#place), private)
                }
                SlotArray::Number(integer) => {
                    let integer = self.integer(*integer, code);
                    quote!(#integer as f64)
                }
                &SlotArray::Rounded(number) => {
                    let number = self.number(number, &[], code);
                    quote!({ #number.round() })
                }
                &SlotArray::Weight(number) => {
                    let conditions = self.derived.inner.conditions.get(&symbol);
                    self.number(number, conditions.map_or(&[], Vec::as_slice), code)
                }
                &SlotArray::Sum(number) => self.inner_total(number),
            }
        } else {
            return;
        };
        self.symbols.push(symbol);
        let name = self.symbol_name(symbol);
        code.extend(quote!(let #name: f64 = #value;));
    }

    /// Returns a call that ends with its error, which tells the counters of the loops around it.
    fn checked(&self, call: &TokenStream) -> TokenStream {
        if self.counters.is_empty() {
            return quote!(#call?);
        }
        let private = self.formulas.private;
        let names = self.counters.iter();
        let names = names.map(|&counter| verbatim(self.scene().integers.name(counter)));
        let counters = self.counters.iter();
        let counters = counters.map(|counter| format_ident!("counter_{}", counter.0));
        quote!(#private::scene::within(#call, &[#(#names),*], [#(#counters),*])?)
    }

    fn symbol_name(&self, symbol: Symbol) -> Ident {
        ident(&symbol_name(self.formulas.symbols, symbol))
    }

    fn number_of(&mut self, int: Int) -> usize {
        let known = self.integers.iter().position(|known| *known == int);
        known.unwrap_or_else(|| {
            self.integers.push(int);
            self.integers.len() - 1
        })
    }

    /// Returns a read and its function, for messages.
    fn text_of(&self, array: &SlotArray) -> Literal {
        let slot = Slot {
            array: array.clone(),
            component: 0,
        };
        self.text(&self.scene().text(&slot))
    }

    fn text(&self, what: &str) -> Literal {
        verbatim(&format!("`{what}` in `{}`", self.function))
    }
}
