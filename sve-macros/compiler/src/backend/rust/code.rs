//! Instructions → `let` statements, one each, named by what they are.

use std::collections::{BTreeSet, HashMap, HashSet};

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{ToTokens, quote};

use super::axis::Axis;
use super::function::Formulas;
use super::{ident, number};
use crate::model::{Argument, Meaning, Quantity};
use crate::program::limits::{SPARSE_ENTRY, SPARSE_SIZE};
use crate::program::{
    Array, Labels, Names, Operation, Program, Shape, Tier, Value, operands, symbol_name,
};
use crate::structure::Storage;

/// Variables of emitted code that are no values of the program.
const DECLARED: &str = "angle limit q v p h t dw dq dv dp dqt dvt time state value newton prepared states kept \
    lane any next q_lane p_lane guess origin refinement factors fallback rounding unknowns rhs \
    solution start stage stages poison impulses inverse masses offset motion kicks memory \
    carried tangents pairs varied seeds radii system inputs";

/// Where printed statements stand.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// In a step of a single state.
    Single,
    /// The same, with bounds of the rounding errors.
    Rounded,
    /// In a function of a single state that a loop over lanes calls, and so without branches.
    WithinLoop,
    /// In a loop over an axis, without branches.
    Over(Axis),
}

/// Prints a program.
pub(super) struct Printer<'a> {
    pub(super) program: &'a Program,
    pub(super) formulas: Formulas<'a>,
    names: Names,
    /// Values that the step reads from what `prepare` returned, with their place there.
    prepared: HashMap<Value, usize>,
    pub(super) place: Place,
    /// Values that have no statement.
    omitted: BTreeSet<Value>,
    /// Values that are computed within the statement that uses them.
    pub(super) inlined: BTreeSet<Value>,
}

impl<'a> Printer<'a> {
    pub(super) fn new(
        place: Place,
        program: &'a Program,
        labels: &Labels,
        formulas: Formulas<'a>,
    ) -> Self {
        let declared: Vec<&str> = DECLARED.split_whitespace().collect();
        let names = Names::new(program, formulas.symbols, labels, &declared);
        Self {
            program,
            formulas,
            inlined: program.inlined(|value| !names.is_numbered(value)),
            names,
            prepared: HashMap::new(),
            place,
            omitted: BTreeSet::new(),
        }
    }

    /// The same without the statements of some values.
    pub(super) fn without(self, omitted: &BTreeSet<Value>) -> Self {
        Self {
            omitted: omitted.clone(),
            ..self
        }
    }

    /// The same with a statement for each of these values.
    pub(super) fn keeping<'b>(mut self, kept: impl IntoIterator<Item = &'b Value>) -> Self {
        for value in kept {
            self.inlined.remove(value);
        }
        self
    }

    /// Returns whether elementary functions are evaluated without branches, for vectors.
    pub(super) fn is_vector(&self) -> bool {
        matches!(self.place, Place::WithinLoop | Place::Over(_))
    }

    /// Chooses what `prepare` returns: values of its tier that anything later, or `roots`, uses.
    pub(super) fn split_prepared(&mut self, roots: &[Value]) -> Vec<Value> {
        let later = self
            .program
            .all()
            .filter(|(_, i)| i.tier != Tier::Prepare)
            .flat_map(|(_, i)| operands(i.operation));
        let mut wanted: Vec<Value> = later
            .chain(roots.iter().copied())
            .filter(|&v| self.is_prepared(v))
            .collect();
        wanted.sort_unstable();
        wanted.dedup();
        self.prepared = wanted.iter().enumerate().map(|(at, &v)| (v, at)).collect();
        wanted
    }

    /// Returns whether a value is worth keeping: computed in `prepare`, neither a constant nor an
    /// input.
    fn is_prepared(&self, value: Value) -> bool {
        let instruction = self.program.get(value);
        instruction.tier == Tier::Prepare
            && !matches!(
                instruction.operation,
                Operation::Constant(_) | Operation::Input(_)
            )
    }

    /// Statements of `prepare`.
    pub(super) fn prepare(&self) -> TokenStream {
        self.statements(Tier::Prepare)
    }

    /// Statements that read inputs known before the step, and what `prepare` returned.
    pub(super) fn load(&self, results: &[Value]) -> TokenStream {
        let mut used: HashSet<Value> = results.iter().copied().collect();
        let later = self.program.all().filter(|(_, i)| i.tier != Tier::Prepare);
        used.extend(later.flat_map(|(_, i)| operands(i.operation)));
        let mut tokens = TokenStream::new();
        let mut names = vec![TokenStream::new(); self.prepared.len()];
        for (value, operation) in self.program.of_tier(Tier::Prepare) {
            if let Some(&at) = self.prepared.get(&value) {
                names[at] = self.name(value).to_token_stream();
            } else if matches!(operation, Operation::Input(_)) && used.contains(&value) {
                tokens.extend(self.statement(value, operation));
            }
        }
        let prepared = (!names.is_empty()).then(|| quote!(let [#(#names),*] = *prepared;));
        quote!(#prepared #tokens)
    }

    /// Statements of a tier, in order.
    pub(super) fn statements(&self, tier: Tier) -> TokenStream {
        self.program
            .of_tier(tier)
            .filter(|(value, _)| !self.omitted.contains(value))
            .map(|(value, operation)| self.statement(value, operation))
            .collect()
    }

    /// The names of sine and cosine in a pair.
    pub(super) fn pair(&self, both: Value) -> [String; 2] {
        self.names.pair(both)
    }

    pub(super) fn array(&self, values: &[Value]) -> TokenStream {
        let operands = values.iter().map(|&v| self.operand(v));
        quote!([#(#operands),*])
    }

    /// Rows as an array of arrays; of a large matrix with few entries only these are written.
    pub(super) fn matrix(&self, rows: &[Vec<Value>]) -> TokenStream {
        let entries = |row: usize| {
            let entries = rows[row].iter().enumerate();
            entries.filter(|x| !self.is_zero(*x.1))
        };
        let (height, width) = (rows.len(), rows.first().map_or(0, Vec::len));
        let count: usize = (0..height).map(|row| entries(row).count()).sum();
        if height >= SPARSE_SIZE && width >= SPARSE_SIZE && SPARSE_ENTRY * count <= height * width {
            let assignments = (0..height).flat_map(|row| {
                let i = Literal::usize_unsuffixed(row);
                entries(row).map(move |(column, &value)| {
                    let (j, value) = (Literal::usize_unsuffixed(column), self.operand(value));
                    quote!(entries[#i][#j] = #value;)
                })
            });
            let [height, width] = [height, width].map(Literal::usize_unsuffixed);
            return quote!({
                let mut entries = [[0f64; #width]; #height];
                #(#assignments)*
                entries
            });
        }
        let rows = rows.iter().map(|row| self.array(row));
        quote!([#(#rows),*])
    }

    /// An array, in its shape.
    pub(super) fn shaped(&self, array: &Array<Value>) -> TokenStream {
        let rows = &array.rows;
        match array.shape {
            Shape::Number => self.operand(rows[0][0]),
            Shape::Vector => self.array(&rows[0]),
            Shape::Matrix(storage) => self.stored(storage, rows),
        }
    }

    /// Rows of stored entries as a matrix of the runtime.
    pub(super) fn stored(&self, storage: Storage, rows: &[Vec<Value>]) -> TokenStream {
        let (private, size) = (self.formulas.private, rows.len());
        let rows = self.matrix(rows);
        match storage {
            Storage::Dense => rows,
            Storage::Cofactors => quote!(#private::Cofactors(#rows)),
            Storage::Diagonal => quote!(#private::Diagonal(#rows)),
            Storage::Banded(band) => {
                let numbers = [size, band.lower, band.width()];
                let [size, lower, width] = numbers.map(Literal::usize_unsuffixed);
                quote!(#private::Banded::<#size, #lower, #width>(#rows))
            }
        }
    }

    pub(super) fn is_zero(&self, value: Value) -> bool {
        self.program.get(value).operation == Operation::Constant(0)
    }

    /// The statement of a value; nothing where it is bound otherwise, or computed within another
    /// statement.
    pub(super) fn statement(&self, value: Value, operation: Operation) -> TokenStream {
        let private = self.formulas.private;
        match operation {
            Operation::Constant(_) | Operation::SinOf(_) | Operation::CosOf(_) => {
                TokenStream::new()
            }
            Operation::Input(symbol) => {
                let meaning = self.formulas.symbols.meaning(symbol);
                let Some(access) = input(meaning, self.place) else {
                    return TokenStream::new();
                };
                let access = match meaning {
                    Meaning::Parameter { .. } => number(&access, private),
                    _ => access,
                };
                let name = self.name(value);
                quote!(let #name: f64 = #access;)
            }
            Operation::SinCos(_) | Operation::AngleAddition(..) => {
                let [sin, cos] = self.names.pair(value).map(|name| ident(&name));
                let pair = self.sin_cos(operation);
                quote!(let (#sin, #cos) = #pair;)
            }
            _ if self.inlined.contains(&value) => TokenStream::new(),
            operation => {
                let (name, expression) = (self.name(value), self.computed(operation).1);
                quote!(let #name = #expression;)
            }
        }
    }

    pub(super) fn name(&self, value: Value) -> Ident {
        match self.program.get(value).operation {
            Operation::Input(symbol) => ident(&symbol_name(self.formulas.symbols, symbol)),
            Operation::SinOf(both) => ident(&self.names.pair(both)[0]),
            Operation::CosOf(both) => ident(&self.names.pair(both)[1]),
            _ => ident(&self.names.of(value)),
        }
    }
}

/// The place of a total: they stand after the increments, the last one first.
pub(super) fn total(number: usize) -> TokenStream {
    let from_end = Literal::usize_unsuffixed(number + 1);
    quote!(dw[dw.len() - #from_end])
}

/// How an input is read; nothing where it is bound otherwise.
fn input(meaning: &Meaning, place: Place) -> Option<TokenStream> {
    if let Place::Over(axis) = place
        && let Some(access) = axis.input(meaning)
    {
        return Some(access);
    }
    let (row, i) = match *meaning {
        Meaning::Parameter { ref access, .. } => return Some(access.clone()),
        Meaning::Time => return Some(quote!(time)),
        Meaning::Radius(Argument::Time) => return Some(quote!(radii.t)),
        Meaning::Position(i) => (quote!(q), i),
        Meaning::Velocity(i) => (quote!(v), i),
        Meaning::Momentum(i) => (quote!(p), i),
        Meaning::Radius(Argument::Position(i)) => (quote!(radii.q), i),
        Meaning::Radius(Argument::Velocity(i)) => (quote!(radii.v), i),
        Meaning::Radius(Argument::Momentum(i)) => (quote!(radii.p), i),
        Meaning::Start(Quantity::Position, i) => (quote!(state.q), i),
        Meaning::Start(Quantity::Momentum, i) => (quote!(state.p), i),
        Meaning::Wiener(i) => (quote!(dw), i),
        Meaning::Total(i) => return Some(total(i)),
        Meaning::StepSize
        | Meaning::Unknown(_)
        | Meaning::Limit(_)
        | Meaning::End(_)
        | Meaning::NodeEntry(_)
        | Meaning::Attitude(_)
        | Meaning::Sum(_)
        | Meaning::Slot(_)
        | Meaning::Read(_)
        | Meaning::Partial => return None,
    };
    let i = Literal::usize_unsuffixed(i);
    Some(quote!(#row[#i]))
}
