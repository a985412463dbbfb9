//! Indices that are out of range, with the round of the loops in which they are.

use core::fmt;

/// An index that is out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexError {
    /// The indexed expression and its function: "`q[i - 1]` in `lagrangian`".
    pub text: &'static str,
    /// The index.
    pub index: i64,
    /// The length of the array.
    pub length: usize,
    /// The round of the loops.
    pub instance: Instance,
}

/// Nested loops kept in an [`Instance`], at most: the innermost ones.
const NESTED: usize = 4;

/// The counters of nested loops, the outermost first; none outside of loops.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Instance {
    names: &'static [&'static str],
    counters: [i64; NESTED],
}

impl fmt::Display for Instance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, (name, counter)) in self.names.iter().zip(self.counters).enumerate() {
            let before = if at == 0 { " (" } else { ", " };
            write!(f, "{before}{name} = {counter}")?;
        }
        f.write_str(if self.names.is_empty() { "" } else { ")" })
    }
}

/// An error that may have an instance.
pub trait InLoops {
    /// Adds the instance.
    #[must_use]
    fn at(self, instance: Instance) -> Self;
}

impl InLoops for IndexError {
    fn at(self, instance: Instance) -> Self {
        Self { instance, ..self }
    }
}

impl InLoops for Stop {
    fn at(self, instance: Instance) -> Self {
        match self {
            Self::Index(error) => Self::Index(error.at(instance)),
            Self::AsWritten => self,
        }
    }
}

/// Adds the counters of the loops around a read to its error.
///
/// # Errors
/// The same as `result`.
#[inline(always)]
pub fn within<T, E: InLoops, const N: usize>(
    result: Result<T, E>,
    names: &'static [&'static str; N],
    counters: [i64; N],
) -> Result<T, E> {
    #[cold]
    fn located<E: InLoops>(error: E, names: &'static [&'static str], all: &[i64]) -> E {
        let first = names.len().saturating_sub(NESTED);
        let (names, mut counters) = (&names[first..], [0; NESTED]);
        counters[..names.len()].copy_from_slice(&all[first..]);
        error.at(Instance { names, counters })
    }
    result.map_err(|error| located(error, names, &counters))
}

impl fmt::Display for IndexError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            text,
            index,
            length,
            instance,
        } = self;
        write!(
            f,
            "{text}{instance} has the index {index}, and the length is {length}"
        )
    }
}

/// The reason why a visit of instances ends early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// An index is out of range.
    Index(IndexError),
    /// The loop has too many instances, or too few consecutive ones.
    AsWritten,
}

impl From<IndexError> for Stop {
    fn from(error: IndexError) -> Self {
        Self::Index(error)
    }
}

/// Returns an entry of an array.
///
/// # Errors
/// The index, if it is out of range.
#[inline(always)]
pub fn entry<'a, T>(array: &'a [T], index: i64, text: &'static str) -> Result<&'a T, IndexError> {
    let length = array.len();
    let found = usize::try_from(index).ok().and_then(|at| array.get(at));
    found.ok_or(IndexError {
        text,
        index,
        length,
        instance: Instance::default(),
    })
}
