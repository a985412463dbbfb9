//! The variables of the function or closure that is being executed.
//!
//! A reference into a local array, made by `iter_mut` and `for x in &mut a`, names a [`Place`].
//! Reading a reference reads the place. A reference is valid only in the frame of the function that
//! made it. Functions and closures that are called get copies.

use std::collections::HashMap;

use super::Lowering;
use super::value::Value;

/// Largest number of references to references that are followed.
const CHAIN: usize = 8;

/// Variables by their names.
pub(super) type Scope = HashMap<String, Value>;

/// A function or closure that is being executed.
#[derive(Default)]
pub(super) struct Frame {
    /// Variables, innermost scope last.
    pub(super) scopes: Vec<Scope>,
    /// Index of the first scope of the closure that is being executed. The earlier scopes enclose
    /// the closure.
    pub(super) floor: usize,
    /// True if a closure of an iterator adapter is being executed. Rust runs such a closure only
    /// when the items of the iterator are used.
    pub(super) is_lazy: bool,
    number: usize,
    /// Number of the last frame.
    last: usize,
}

/// A variable, or an entry of a variable.
#[derive(Clone)]
pub(super) struct Place {
    frame: usize,
    pub(super) scope: usize,
    name: String,
    pub(super) path: Vec<usize>,
}

impl Place {
    pub(super) fn then(&self, entry: usize) -> Self {
        let mut inner = self.clone();
        inner.path.push(entry);
        inner
    }
}

impl Frame {
    /// Gives a name a value in the innermost scope.
    pub(super) fn set(&mut self, name: &(impl ToString + ?Sized), value: Value) {
        if let Some(scope) = self.scopes.last_mut() {
            scope.insert(name.to_string(), value);
        }
    }

    /// Returns the value that a variable holds, which may be a reference.
    pub(super) fn held(&self, name: &str) -> Option<&Value> {
        self.scopes.iter().rev().find_map(|scope| scope.get(name))
    }

    /// Returns the value of a variable; if the variable is a reference, the value to which it
    /// refers.
    pub(super) fn variable(&self, name: &str) -> Option<&Value> {
        self.held(name).map(|value| self.followed(value))
    }

    /// Returns the place of a variable.
    pub(super) fn place(&self, name: &str) -> Option<Place> {
        let scope = self.scopes.iter().rposition(|s| s.contains_key(name))?;
        Some(Place {
            frame: self.number,
            scope,
            name: name.to_owned(),
            path: Vec::new(),
        })
    }

    /// Returns the value at a place; `None` if the place belongs to another frame.
    pub(super) fn at(&self, place: &Place) -> Option<&Value> {
        if place.frame != self.number {
            return None;
        }
        let variable = self.scopes.get(place.scope)?.get(&place.name)?;
        let mut path = place.path.iter();
        path.try_fold(variable, |value, &entry| value.list()?.get(entry))
    }

    pub(super) fn at_mut(&mut self, place: &Place) -> Option<&mut Value> {
        let variable = self.scopes.get_mut(place.scope)?.get_mut(&place.name)?;
        let mut path = place.path.iter();
        path.try_fold(variable, |value, &entry| value.list_mut()?.get_mut(entry))
    }

    /// Returns the value to which a reference refers. Returns a value that is not a reference
    /// unchanged.
    pub(super) fn followed<'v>(&'v self, value: &'v Value) -> &'v Value {
        let mut value = value;
        for _ in 0..CHAIN {
            match value {
                Value::Place(place) => match self.at(place) {
                    Some(inner) => value = inner,
                    None => return &Value::Poison,
                },
                _ => break,
            }
        }
        value
    }

    /// Follows references from a place. Returns the place at their end; `None` if the place holds
    /// no reference.
    pub(super) fn referenced(&self, place: &Place) -> Option<Place> {
        let mut found: Option<Place> = None;
        for _ in 0..CHAIN {
            match self.at(found.as_ref().unwrap_or(place)) {
                Some(Value::Place(inner)) => found = Some(inner.clone()),
                _ => break,
            }
        }
        found
    }

    /// Follows a reference, as [`followed`](Self::followed) does, for an owned value.
    pub(super) fn read_through(&self, value: Value) -> Value {
        match &value {
            Value::Place(_) => self.followed(&value).clone(),
            _ => value,
        }
    }

    /// Splits a reference to an array or tuple into references to its entries.
    pub(super) fn split_reference(&self, place: &Place) -> Option<Vec<Value>> {
        match self.followed(&Value::Place(place.clone())) {
            Value::Array(values) | Value::Tuple(values) => {
                let entries = 0..values.len();
                Some(entries.map(|at| Value::Place(place.then(at))).collect())
            }
            _ => None,
        }
    }
}

impl Lowering<'_> {
    /// Calls `run` with a new innermost scope.
    pub(super) fn scoped<T>(&mut self, run: impl FnOnce(&mut Self) -> T) -> T {
        self.frame.scopes.push(Scope::new());
        let value = run(self);
        self.frame.scopes.pop();
        value
    }

    /// Calls `run` in the frame of a function or closure with these variables.
    pub(super) fn in_frame<T>(&mut self, scope: Scope, run: impl FnOnce(&mut Self) -> T) -> T {
        let number = self.frame.last + 1;
        let inner = Frame {
            scopes: vec![scope],
            number,
            last: number,
            ..Frame::default()
        };
        let outer = std::mem::replace(&mut self.frame, inner);
        let value = run(self);
        let last = self.frame.last;
        self.frame = Frame { last, ..outer };
        value
    }
}
