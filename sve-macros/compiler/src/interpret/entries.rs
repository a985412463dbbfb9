//! One symbol for each entry of a vector or matrix parameter, even if the entry is written in
//! several ways: `g.z`, `g[2]`, `g[(2, 0)]`.
//!
//! Input: the parameters of an execution, and the types that follow from their uses. Output: a
//! common spelling for each entry that has several, and errors for indices out of range.

use std::collections::HashMap;

use proc_macro2::Span;
use syn::Member;

use super::fields::{FieldPath, FieldStep};
use super::matrices::{COMPONENTS, Kind, MatrixType, entry_of_field, row_and_column};
use super::places::{Mistake, Pick, matrix_entry};
use crate::errors::Errors;

/// The entries of the same field that were read, in the order of their first use.
struct Entries<'p> {
    base: FieldPath,
    paths: Vec<(&'p FieldPath, &'p FieldStep)>,
}

/// An entry of a vector or matrix of unknown type.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Place {
    /// Index in storage, which is by columns.
    Stored(usize),
    /// Row and column. An entry of the first column is `Stored`; for other columns the index
    /// depends on the unknown number of rows.
    Pair(usize, usize),
}

/// Chooses one spelling for each entry and maps the other spellings to it. Reports an error for an
/// index out of range. `vectors` has the types of fields that are known.
pub(super) fn spellings(
    paths: &[FieldPath],
    vectors: &HashMap<String, MatrixType>,
    errors: &mut Errors,
) -> HashMap<String, FieldPath> {
    let mut spellings = HashMap::new();
    for entries in grouped(paths) {
        let found = match vectors.get(&entries.base.access().to_string()) {
            Some(&ty) => entries.spellings_of_type(ty),
            None => entries.spellings(),
        };
        match found {
            Ok(found) => {
                let found = found.into_iter();
                spellings.extend(found.filter(|(old, new)| *old != new.access().to_string()));
            }
            Err((span, message)) => errors.push(span, message),
        }
    }
    spellings
}

fn grouped(paths: &[FieldPath]) -> Vec<Entries<'_>> {
    let mut groups: Vec<Entries<'_>> = Vec::new();
    let mut places = HashMap::new();
    for path in paths {
        let Some((base, step)) = path.last_step() else {
            continue;
        };
        let place = *places
            .entry(base.access().to_string())
            .or_insert(groups.len());
        if place == groups.len() {
            let paths = Vec::new();
            groups.push(Entries { base, paths });
        }
        groups[place].paths.push((path, step));
    }
    groups
}

type Spellings = Vec<(String, FieldPath)>;

impl Entries<'_> {
    /// Maps each spelling of an entry to the common spelling, for a vector or matrix of known type.
    fn spellings_of_type(&self, ty: MatrixType) -> Result<Spellings, Mistake> {
        let mut found = Vec::new();
        for (path, step) in &self.paths {
            let place = match step {
                FieldStep::Named(name) => ty.place_of(&Member::Named(name.clone())),
                // an array of columns has no other spelling
                FieldStep::Numbered(_)
                | FieldStep::Read(..)
                | FieldStep::At(..)
                | FieldStep::AtPair(..) => None,
                // the compiler of Rust reports that a rotation has no such entry
                FieldStep::Index(..) if ty.kind == Kind::Rotation => None,
                FieldStep::Index(index, span) => {
                    let pick = Pick::Index(*index, span.unwrap_or_else(Span::call_site));
                    Some(matrix_entry(ty, &pick)?)
                }
                FieldStep::Pair(row, column, span) => {
                    let pick = Pick::Pair(*row, *column, span.unwrap_or_else(Span::call_site));
                    Some(matrix_entry(ty, &pick)?)
                }
            };
            if let Some(place) = place {
                let (row, column) = (place % ty.rows, place / ty.rows);
                let entry = entry_of_field(&self.base, ty, row, column);
                found.push((path.access().to_string(), entry));
            }
        }
        Ok(found)
    }

    /// Maps each spelling of an entry to the common spelling, for a field of unknown type. If the
    /// field is read with brackets, `.x` and `.m11` are names of entries too.
    fn spellings(&self) -> Result<Spellings, Mistake> {
        let has_brackets = self
            .paths
            .iter()
            .any(|(_, step)| matches!(step, FieldStep::Index(..) | FieldStep::Pair(..)));
        if !has_brackets {
            return Ok(Vec::new());
        }
        self.check_ambiguity()?;
        let has_components = self.paths.iter().any(|(_, step)| component(step).is_some());
        // a name comes before row and column, and these before an index in storage
        let rank = |step: &FieldStep| match step {
            FieldStep::Named(_) if component(step).is_some() => 0,
            FieldStep::Pair(..) => 1,
            _ => 2,
        };
        let mut best: HashMap<Place, (usize, &FieldPath)> = HashMap::new();
        for (path, step) in &self.paths {
            if let Some(place) = place(step, has_components) {
                let found = best.entry(place).or_insert((rank(step), path));
                if rank(step) < found.0 {
                    *found = (rank(step), path);
                }
            }
        }
        let spelling = |(path, step): &(&FieldPath, &FieldStep)| {
            let (_, best) = best.get(&place(step, has_components)?)?;
            Some((path.access().to_string(), (*best).clone()))
        };
        Ok(self.paths.iter().filter_map(spelling).collect())
    }

    /// Returns an error if two spellings, such as `m[2]` and `m[(0, 1)]`, may be the same entry,
    /// depending on the number of rows.
    fn check_ambiguity(&self) -> Result<(), Mistake> {
        let pairs: Vec<(usize, usize)> = self.paths.iter().filter_map(|(_, s)| pair(s)).collect();
        let last_row = pairs.iter().map(|&(row, _)| row).max().unwrap_or(0);
        for (_, step) in &self.paths {
            let FieldStep::Index(index, span) = step else {
                continue;
            };
            let same = pairs.iter().find(|&&(row, column)| {
                column > 0
                    && index
                        .checked_sub(row)
                        .is_some_and(|i| i % column == 0 && i / column > last_row)
            });
            if let Some((row, column)) = same {
                let name = crate::syntax::readable(&self.base.access());
                let message = format!(
                    "`{name}[{index}]` and `{name}[({row}, {column})]` may be the same entry, and the type of `{name}` is not known to the macro: name it, `let {}: Matrix2<f64> = {name};`, or write rows and columns",
                    self.base.name()
                );
                return Err((span.unwrap_or_else(Span::call_site), message));
            }
        }
        Ok(())
    }
}

fn component(step: &FieldStep) -> Option<usize> {
    match step {
        FieldStep::Named(name) => COMPONENTS.iter().position(|component| name == component),
        _ => None,
    }
}

fn pair(step: &FieldStep) -> Option<(usize, usize)> {
    match step {
        FieldStep::Pair(row, column, _) => Some((*row, *column)),
        FieldStep::Named(name) => row_and_column(&name.to_string()),
        _ => None,
    }
}

/// Returns the entry that a step selects. `has_components` says that the field is a vector, a row
/// or a column.
fn place(step: &FieldStep, has_components: bool) -> Option<Place> {
    if let FieldStep::Index(index, _) = step {
        return Some(Place::Stored(*index));
    }
    if let Some(at) = component(step) {
        return Some(Place::Stored(at));
    }
    pair(step).map(|(row, column)| match (row, column) {
        (row, 0) => Place::Stored(row),
        (0, column) if has_components => Place::Stored(column),
        _ => Place::Pair(row, column),
    })
}
