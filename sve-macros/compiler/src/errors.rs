//! The error sink. Mistakes are gathered within a stage; a stage with mistakes ends the pipeline.
//!
//! Invariant: a sink that received an error cannot be turned into a value ([`Errors::finish`] is
//! the only way out).

use std::collections::BTreeSet;

use proc_macro2::Span;

/// The mistakes found so far.
#[derive(Default)]
#[must_use = "call `finish` to learn whether anything was wrong"]
pub(crate) struct Errors {
    first: Option<syn::Error>,
    count: usize,
    /// The function or constant that is being read.
    place: Option<String>,
    /// Functions and constants with mistakes.
    places: BTreeSet<String>,
}

impl Errors {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Records a mistake at a token.
    pub(crate) fn push(&mut self, span: Span, message: impl std::fmt::Display) {
        self.add(syn::Error::new(span, message));
    }

    pub(crate) fn add(&mut self, error: syn::Error) {
        self.count += 1;
        self.places.extend(self.place.clone());
        match &mut self.first {
            Some(first) => first.combine(error),
            None => self.first = Some(error),
        }
    }

    /// Attributes the following mistakes to the function or constant `place`. Returns the previous
    /// place, to be restored with [`Errors::leave`].
    pub(crate) fn enter(&mut self, place: &str) -> Option<String> {
        self.place.replace(place.to_owned())
    }

    pub(crate) fn leave(&mut self, outer: Option<String>) {
        self.place = outer;
    }

    /// Returns the functions and constants with mistakes so far.
    pub(crate) fn places(&self) -> &BTreeSet<String> {
        &self.places
    }

    /// Appends the mistakes of another sink.
    pub(crate) fn append(&mut self, other: Self) {
        self.count += other.count;
        self.places.extend(other.places);
        match (&mut self.first, other.first) {
            (Some(first), Some(error)) => first.combine(error),
            (None, error) => self.first = error,
            (Some(_), None) => {}
        }
    }

    /// Returns the number of mistakes so far.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Returns the value of a result. Records its mistake if there is one.
    pub(crate) fn keep<T>(&mut self, result: syn::Result<T>) -> Option<T> {
        result.map_err(|error| self.add(error)).ok()
    }

    /// Returns `value` if there are no mistakes.
    pub(crate) fn finish<T>(self, value: T) -> syn::Result<T> {
        match self.first {
            Some(error) => Err(error),
            None => Ok(value),
        }
    }
}

/// Returns the name in `known` that is nearest to `name`, if it is near enough to be the intended
/// one.
pub(crate) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|candidate| (distance(name, candidate), candidate))
        .filter(|&(d, candidate)| d < name.len() && d <= 1 + candidate.len().min(name.len()) / 4)
        .min()
        .map(|(_, candidate)| candidate)
}

/// Returns Levenshtein's distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
