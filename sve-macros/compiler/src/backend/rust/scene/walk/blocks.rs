//! Inner loops over consecutive sites, which the runtime makes in blocks.
//!
//! Such a loop has one summand and no branch. Its index is that of one site, and of numbers of
//! fields; what else it reads is read before it. If an index would be out of range, the loop is
//! made as it is written, and finds it.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::super::nodes::where_defined;
use super::{Action, Leaf, Row, Walk, may_fail};
use crate::algebra::{Expr, Symbol};
use crate::model::scene::{Access, Counter, Int, IntNode, SlotArray, Step, SumId};
use crate::scene::indices;

/// A loop that can be made in blocks.
struct Block {
    counter: Counter,
    values: Vec<Expr>,
    conditions: Vec<Expr>,
    /// The sites that the summand is added to.
    receivers: Vec<Int>,
    /// The site whose index is that of the loop.
    site: Int,
    /// The numbers of fields with such an index, with their indices.
    columns: Vec<(Symbol, Access, Int)>,
    /// The other reads.
    ahead: Vec<Symbol>,
}

impl Walk<'_> {
    /// Prints the loop over `counter` with the sum's only summand in blocks, and `plain` for where
    /// this is not possible.
    pub(super) fn in_blocks(
        &mut self,
        sum: SumId,
        counter: Counter,
        [from, to]: [&TokenStream; 2],
        plain: &TokenStream,
    ) -> Option<TokenStream> {
        let block = self.block_of(sum, counter)?;
        let [known, symbols] = [self.known.len(), self.symbols.len()];
        let rows = self.rows.clone();
        let code = self.print_block(&block, [from, to], plain);
        self.known.truncate(known);
        self.symbols.truncate(symbols);
        self.rows = rows;
        Some(code)
    }

    fn block_of(&self, sum: SumId, counter: Counter) -> Option<Block> {
        let scene = self.scene();
        let within = |leaf: &&Leaf| scene.around(leaf.sum).any(|around| around == sum);
        let mut leaves = self.leaves.iter().filter(within);
        let (leaf, None) = (leaves.next()?, leaves.next()) else {
            return None;
        };
        let Action::AddRows(receivers) = &leaf.action else {
            return None;
        };
        if leaf.sum != Some(sum) {
            return None;
        }
        let mut moving = receivers.iter().filter(|&&s| scene.has_counter(s, counter));
        let (&site, None) = (moving.next()?, moving.next()) else {
            return None;
        };
        let mut others = receivers.iter().filter(|&&other| other != site);
        if !self.advances(site, counter) || !others.all(|other| self.gathered.contains(other)) {
            return None;
        }
        let mut block = Block {
            counter,
            values: leaf.values.clone(),
            conditions: leaf.conditions.clone(),
            receivers: receivers.clone(),
            site,
            columns: Vec::new(),
            ahead: Vec::new(),
        };
        let mut numbers = leaf.values.iter().chain(&leaf.conditions);
        let are_in_blocks = numbers.all(|&number| self.reads_in_blocks(number, &mut block));
        are_in_blocks.then_some(block)
    }

    /// Returns whether an index is the counter and a number that does not change in its loop.
    fn advances(&self, index: Int, counter: Counter) -> bool {
        let scene = self.scene();
        let is_fixed = |int| !scene.has_counter(int, counter) && !scene.reads(int, &may_fail);
        match *scene.integers.node(index) {
            IntNode::Counter(of) => of == counter,
            IntNode::Add(a, b) if is_fixed(a) => self.advances(b, counter),
            IntNode::Add(a, b) | IntNode::Sub(a, b) => is_fixed(b) && self.advances(a, counter),
            _ => false,
        }
    }

    /// Collects the reads of a number. Returns whether it can be computed in blocks.
    fn reads_in_blocks(&self, number: Expr, block: &mut Block) -> bool {
        let (scene, counter) = (self.scene(), block.counter);
        self.formulas.arena.symbols_of(number).all(|symbol| {
            let is_column = block.columns.iter().any(|column| column.0 == symbol);
            if self.symbols.contains(&symbol) || is_column {
                return true;
            }
            if self
                .derived
                .each
                .iter()
                .any(|each| each.increment == symbol)
            {
                return false;
            }
            let Some(slot) = scene.slot(symbol) else {
                return true;
            };
            match &slot.array {
                &SlotArray::Configuration(site) => {
                    let is_ahead = !scene.has_counter(site, counter);
                    if is_ahead {
                        block.ahead.push(symbol);
                    }
                    is_ahead || site == block.site
                }
                SlotArray::Field(access) => {
                    let mut all = access.steps.iter().flat_map(indices);
                    if !all.any(|index| scene.has_counter(index, counter)) {
                        block.ahead.push(symbol);
                        return true;
                    }
                    let [members @ .., Step::Index(index)] = &access.steps[..] else {
                        return false;
                    };
                    let are_members = members.iter().all(|step| matches!(step, Step::Member(_)));
                    if !are_members || !self.advances(*index, counter) {
                        return false;
                    }
                    let steps = members.to_vec();
                    block.columns.push((symbol, Access { steps }, *index));
                    true
                }
                &SlotArray::Rounded(inner) => self.reads_in_blocks(inner, block),
                _ => false,
            }
        })
    }

    fn print_block(
        &mut self,
        block: &Block,
        [from, to]: [&TokenStream; 2],
        plain: &TokenStream,
    ) -> TokenStream {
        let private = self.formulas.private;
        let count = quote!(i64::wrapping_sub(#to, #from));
        let first = self.first(block.site, block.counter, from);
        let columns = block.columns.iter().map(|(_, access, index)| {
            let field = self.field(access, &mut TokenStream::new());
            let first = self.first(*index, block.counter, from);
            quote!(#private::scene::Field(#field).consecutive(#first, #count)?)
        });
        let columns: Vec<TokenStream> = columns.collect();
        let mut ahead = TokenStream::new();
        let others = block.receivers.iter().copied();
        let sites: Vec<Int> = others.filter(|&other| other != block.site).collect();
        for &site in &sites {
            self.row(&SlotArray::Configuration(site), &mut ahead);
        }
        for &symbol in &block.ahead {
            self.symbol(symbol, &mut ahead);
        }
        let array = SlotArray::Configuration(block.site);
        let row = self.row_name(&array);
        self.rows.push(Row {
            array,
            is_checked: true,
        });
        let mut inside = TokenStream::new();
        for (at, (symbol, ..)) in block.columns.iter().enumerate() {
            let (name, at) = (self.symbol_name(*symbol), Literal::usize_unsuffixed(at));
            self.symbols.push(*symbol);
            inside.extend(quote!(let #name: f64 = columns[#at];));
        }
        for &value in block.values.iter().chain(&block.conditions) {
            for symbol in self.formulas.arena.symbols_of(value) {
                self.symbol(symbol, &mut inside);
            }
        }
        let (statements, values) = where_defined(&block.values, &block.conditions, self.formulas);
        let size = self.scene().row.len();
        let rows = block.receivers.iter().zip(values.chunks(size));
        let (own, others): (Vec<_>, Vec<_>) = rows.partition(|row| *row.0 == block.site);
        let array = |row: &(&Int, &[TokenStream])| {
            let numbers = row.1;
            quote!([#(#numbers),*])
        };
        let (own, others): (Vec<_>, Vec<_>) = (
            own.iter().map(array).collect(),
            others.iter().map(array).collect(),
        );
        let gathered: Vec<_> = sites.iter().map(|&site| self.gathered_name(site)).collect();
        quote! {
            let streams = (|| {
                #[allow(unused_imports)]
                use #private::scene::NoNumbers as _;
                let sites = #private::scene::consecutive(#first, #count, q.len())?;
                ::core::option::Option::Some((sites, [#(#columns),*]))
            })();
            if let ::core::option::Option::Some((sites, columns)) = streams {
                #ahead
                let mut fixed = [#(#gathered),*];
                #private::scene::in_blocks(
                    &q[sites.clone()],
                    columns,
                    &mut to[sites],
                    &mut fixed,
                    #[inline(always)]
                    |#row, columns| {
                        #inside
                        #statements
                        (#(#own)*, [#(#others),*])
                    },
                );
                [#(#gathered),*] = fixed;
            } else {
                #plain
            }
        }
    }

    /// Returns an index in the first round of a loop, as an expression.
    fn first(&mut self, index: Int, counter: Counter, from: &TokenStream) -> TokenStream {
        let known = self.known.len();
        let mut code = TokenStream::new();
        let index = self.integer(index, &mut code);
        self.known.truncate(known);
        let counter = format_ident!("counter_{}", counter.0);
        quote!({ let #counter: i64 = #from; #code #index })
    }
}
