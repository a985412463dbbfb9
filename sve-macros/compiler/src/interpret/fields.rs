//! Parameters: fields of the user's struct and constants from outside the block. Generated code
//! reads their values.

mod path;

use std::collections::{HashMap, HashSet};

pub(super) use path::{FieldPath, FieldStep, unseen};

use super::Lowering;
use super::entries::spellings;
use super::matrices::{Matrix, MatrixType};
use super::value::Value;
use crate::algebra::{Expr, Symbol};
use crate::model::Meaning;

/// Knowledge of fields that an execution can only have from an earlier one.
#[derive(Default)]
pub(super) struct Known {
    /// Types of vectors and matrices, which may be annotated after a use as a number.
    types: HashMap<String, MatrixType>,
    /// Entries of vectors and matrices that are written in several ways. Maps each spelling to the
    /// spelling that generated code reads.
    spellings: HashMap<String, FieldPath>,
    /// The fields of a scene that are integers, by their paths without indices.
    integers: HashSet<String>,
}

impl Known {
    fn is_first(&self) -> bool {
        self.types.is_empty() && self.spellings.is_empty()
    }
}

/// The parameters of an execution.
#[derive(Default)]
pub(super) struct Fields {
    known: Known,
    symbols: HashMap<String, Symbol>,
    names: HashSet<String>,
    /// Parameters in the order of their first use.
    paths: Vec<FieldPath>,
    /// The paths of parameters and of reads with an index, by their symbols.
    paths_of: HashMap<Symbol, FieldPath>,
    /// The fields of a scene that this execution has found to be integers.
    integers: HashSet<String>,
    /// Fields that are used as vectors or matrices of a known type.
    vectors: HashMap<String, MatrixType>,
    /// The last parameter that was used as a number, for a hint in messages.
    pub(super) taken_for_number: Option<FieldPath>,
}

impl Fields {
    pub(super) fn new(known: Known) -> Self {
        Self {
            known,
            ..Self::default()
        }
    }

    /// Records that a field of a scene is an integer.
    pub(super) fn learn_integer(&mut self, path: &FieldPath) {
        self.integers.insert(path.kind_of_entry());
    }

    /// Returns whether an earlier execution has found that a field is an integer.
    pub(super) fn is_integer(&self, path: &FieldPath) -> bool {
        !self.known.integers.is_empty() && self.known.integers.contains(&path.kind_of_entry())
    }

    /// Keeps a name from parameters that are declared later.
    pub(super) fn reserve(&mut self, name: &str) {
        self.names.insert(name.to_owned());
    }

    /// Returns the paths of the parameters, in the order of their first use.
    pub(super) fn paths(&self) -> &[FieldPath] {
        &self.paths
    }

    /// Returns the path of a field that a symbol stands for.
    pub(super) fn path_of(&self, symbol: Symbol) -> Option<FieldPath> {
        self.paths_of.get(&symbol).cloned()
    }

    /// If an earlier execution found the type of a parameter, returns the vector or matrix of this
    /// parameter. Returns other values unchanged.
    pub(super) fn typed(&self, value: Value) -> Value {
        match &value {
            Value::Field(path) if !self.known.types.is_empty() && !path.is_converted() => {
                let ty = self.known.types.get(&path.access().to_string());
                ty.map_or(value.clone(), |&ty| {
                    Value::Matrix(Matrix::of_field(path, ty))
                })
            }
            _ => value,
        }
    }
}

impl Lowering<'_> {
    /// Returns the knowledge that another execution needs: types of fields, if a vector or matrix
    /// was taken for a number or a reported mistake may come from an unknown type; the common
    /// spelling, if an entry was read in several ways.
    pub(super) fn learnt(&mut self) -> Option<Known> {
        let fields = &mut self.fields;
        let known = fields.known.integers.len();
        fields.integers.extend(fields.known.integers.drain());
        let integers = std::mem::take(&mut fields.integers);
        if integers.len() > known {
            return Some(Known {
                types: std::mem::take(&mut fields.known.types),
                integers,
                ..Known::default()
            });
        }
        let is_number = |field| fields.symbols.contains_key(field);
        let has_mistakes = self.errors.count() > 0 || fields.vectors.keys().any(is_number);
        if fields.known.is_first() && !fields.vectors.is_empty() && has_mistakes {
            let types = std::mem::take(&mut fields.vectors);
            return Some(Known {
                types,
                integers,
                ..Known::default()
            });
        }
        if !fields.known.spellings.is_empty() {
            return None;
        }
        let spellings = spellings(&fields.paths, &fields.vectors, &mut self.errors);
        (self.errors.count() == 0 && !spellings.is_empty()).then(|| Known {
            types: std::mem::take(&mut fields.known.types),
            spellings,
            integers,
        })
    }

    /// Returns the symbol of a parameter, and declares it at the first use.
    pub(super) fn parameter(&mut self, path: &FieldPath) -> Expr {
        let fields = &mut self.fields;
        if let (Some(ty), Some((vector, _))) = (path.vector(), path.last_step()) {
            let vector = vector.access().to_string();
            fields.vectors.entry(vector).or_insert(ty);
        }
        if path.is_running() {
            let number = self.field_slot(path);
            let symbols = self.arena.symbols_of(number);
            self.fields
                .paths_of
                .extend(symbols.map(|symbol| (symbol, path.clone())));
            return number;
        }
        let spelling = fields.known.spellings.get(&path.access().to_string());
        let path = spelling.unwrap_or(path);
        let access = path.access();
        let key = access.to_string();
        let symbol = *fields.symbols.entry(key).or_insert_with(|| {
            // `self.a_b` and `self.a.b` are two parameters with the same name
            let mut name = path.name();
            while !fields.names.insert(name.clone()) {
                name.push('_');
            }
            fields.paths.push(path.clone());
            self.symbols.declare(Meaning::Parameter {
                name,
                access,
                input: None,
            })
        });
        if !path.is_outside() {
            fields.paths_of.insert(symbol, path.clone());
        }
        self.arena.symbol(symbol)
    }
}
