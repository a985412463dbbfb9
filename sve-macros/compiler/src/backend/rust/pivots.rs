//! Gaussian elimination with a fixed order of pivots, written out: what is zero is not computed.
//!
//! Input: a matrix, a right-hand side and the order. Output: an expression for the solution with a
//! number of the sign of the determinant. Without exchanges of rows it has no branches and no
//! loops, so a loop over lanes with it compiles to vector instructions.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

/// A linear system, zeros left out.
pub(super) struct Sparse {
    /// The entries by row and column.
    pub(super) entries: BTreeMap<(usize, usize), TokenStream>,
    pub(super) rhs: Vec<TokenStream>,
}

/// The elimination so far.
struct Elimination {
    statements: TokenStream,
    /// Which entries differ from zero.
    present: BTreeSet<(usize, usize)>,
    /// True if the sums of the magnitudes of the terms of each entry are computed.
    tests_pivots: bool,
}

/// Solves a system by these pivots. If `tests_pivots` is set, the solution is NaN where a pivot may
/// be only rounding error.
pub(super) fn solved(
    system: &Sparse,
    pivots: &[(usize, usize)],
    tests_pivots: bool,
    private: &TokenStream,
) -> TokenStream {
    let mut elimination = Elimination {
        statements: TokenStream::new(),
        present: system.entries.keys().copied().collect(),
        tests_pivots,
    };
    elimination.start(system);
    let size = Literal::usize_unsuffixed(pivots.len());
    for (k, &(row, column)) in pivots.iter().enumerate() {
        let (pivot, inverse, terms) = (entry(row, column), inverse(k), terms(row, column));
        if tests_pivots {
            elimination.statements.extend(quote! {
                let is_sure = is_sure & #private::lane::has_digits::<#size>(#pivot, #terms);
            });
        }
        elimination.statements.extend(quote! {
            let is_negative = is_negative ^ (#pivot < 0f64);
            let #inverse = 1f64 / #pivot;
        });
        elimination.column(k, pivots);
    }
    for (k, &(row, column)) in pivots.iter().enumerate().rev() {
        let (right, x, inverse) = (right(row), unknown(column), inverse(k));
        let others = pivots[k + 1..].iter().map(|&(_, other)| other);
        let others = others.filter(|&other| elimination.present.contains(&(row, other)));
        let others = others.map(|other| {
            let (a, x) = (entry(row, other), unknown(other));
            quote!(- #a * #x)
        });
        let sum = quote!((#right #(#others)*) * #inverse);
        elimination.statements.extend(quote!(let #x = #sum;));
    }
    let statements = elimination.statements;
    let unknowns = (0..pivots.len()).map(unknown);
    let by = quote!([#(#unknowns),*]);
    let by = if tests_pivots {
        quote!(if is_sure { #by } else { [f64::NAN; #size] })
    } else {
        by
    };
    quote!({
        #statements
        #private::lane::Solved {
            by: #by,
            determinant: if is_negative { -1f64 } else { 1f64 },
        }
    })
}

impl Elimination {
    fn start(&mut self, system: &Sparse) {
        self.statements.extend(quote!(let is_negative = false;));
        if self.tests_pivots {
            self.statements.extend(quote!(let is_sure = true;));
        }
        for (&(row, column), value) in &system.entries {
            let (a, t) = (entry(row, column), terms(row, column));
            self.statements.extend(quote!(let #a = #value;));
            if self.tests_pivots {
                self.statements.extend(quote!(let #t = #a.abs();));
            }
        }
        for (row, value) in system.rhs.iter().enumerate() {
            let b = right(row);
            self.statements.extend(quote!(let #b = #value;));
        }
    }

    /// Eliminates the column of pivot `k` from the rows below.
    fn column(&mut self, k: usize, pivots: &[(usize, usize)]) {
        let (row, column) = pivots[k];
        for &(below, _) in &pivots[k + 1..] {
            if !self.present.contains(&(below, column)) {
                continue;
            }
            let (a, inverse) = (entry(below, column), inverse(k));
            self.statements.extend(quote!(let factor = #a * #inverse;));
            for &(_, other) in &pivots[k + 1..] {
                if self.present.contains(&(row, other)) {
                    self.subtract(row, below, other);
                }
            }
            let (b, from) = (right(row), right(below));
            self.statements
                .extend(quote!(let #from = #from - factor * #b;));
        }
    }

    /// Subtracts the multiple of an entry from the entry below it.
    fn subtract(&mut self, row: usize, below: usize, column: usize) {
        let (by, from) = (entry(row, column), entry(below, column));
        let (by_terms, from_terms) = (terms(row, column), terms(below, column));
        let was_present = !self.present.insert((below, column));
        self.statements.extend(if was_present {
            quote!(let #from = #from - factor * #by;)
        } else {
            quote!(let #from = -(factor * #by);)
        });
        if !self.tests_pivots {
            return;
        }
        self.statements.extend(if was_present {
            quote!(let #from_terms = #from_terms + factor.abs() * #by_terms;)
        } else {
            quote!(let #from_terms = factor.abs() * #by_terms;)
        });
    }
}

fn entry(row: usize, column: usize) -> Ident {
    format_ident!("a_{row}_{column}")
}

fn terms(row: usize, column: usize) -> Ident {
    format_ident!("terms_{row}_{column}")
}

fn right(row: usize) -> Ident {
    format_ident!("b_{row}")
}

fn unknown(column: usize) -> Ident {
    format_ident!("x_{column}")
}

fn inverse(k: usize) -> Ident {
    format_ident!("inverse_{k}")
}
