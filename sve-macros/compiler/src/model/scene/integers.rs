//! Integers known when a program runs: indices and bounds of kept loops.

use std::collections::HashMap;

use syn::Member;

/// An integer of [`Integers`]. Equal numbers are the same integer.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Int(u32);

/// The counter of a kept loop. Sums that one loop accumulates share its counter.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Counter(pub(crate) u32);

/// How an integer is computed. Division and remainder round towards zero, as in Rust.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) enum IntNode {
    Constant(i64),
    Counter(Counter),
    Length(Array),
    /// An integer that a field holds.
    Field(Access),
    Add(Int, Int),
    Sub(Int, Int),
    Mul(Int, Int),
    Div(Int, Int),
    Rem(Int, Int),
    Min(Int, Int),
    Max(Int, Int),
}

/// An object with a length.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) enum Array {
    /// The configuration, whose length is that of the velocity.
    Sites,
    Field(Access),
}

/// The path of a field from `self`: `self.eps[self.kind[i]][j].x`.
#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) struct Access {
    pub(crate) steps: Vec<Step>,
}

#[derive(Clone, PartialEq, Eq, Hash)]
pub(crate) enum Step {
    Member(Member),
    Index(Int),
    /// Row and column of a matrix.
    Pair(Int, Int),
}

/// All integers of a scene.
#[derive(Clone, Default)]
pub(crate) struct Integers {
    nodes: Vec<IntNode>,
    numbers: HashMap<IntNode, Int>,
    /// The names of the counters in the source.
    counters: Vec<String>,
}

impl Integers {
    pub(crate) fn node(&self, int: Int) -> &IntNode {
        &self.nodes[int.0 as usize]
    }

    /// Returns the counter of a new loop, as a counter and as an integer.
    pub(crate) fn counter(&mut self, name: String) -> (Counter, Int) {
        let counter = Counter(self.counters.len() as u32);
        self.counters.push(name);
        (counter, self.integer(IntNode::Counter(counter)))
    }

    pub(crate) fn constant(&mut self, value: i64) -> Int {
        self.integer(IntNode::Constant(value))
    }

    /// Returns the name of a counter in the source.
    pub(crate) fn name(&self, counter: Counter) -> &str {
        &self.counters[counter.0 as usize]
    }

    /// Returns the value of an integer that is known at compile time.
    pub(crate) fn value(&self, int: Int) -> Option<i64> {
        match self.node(int) {
            IntNode::Constant(value) => Some(*value),
            _ => None,
        }
    }

    /// Returns the integer that a node computes.
    pub(crate) fn integer(&mut self, node: IntNode) -> Int {
        if let Some(simple) = self.simplified(&node) {
            return simple;
        }
        let next = Int(self.nodes.len() as u32);
        let known = *self.numbers.entry(node.clone()).or_insert(next);
        if known == next {
            self.nodes.push(node);
        }
        known
    }

    /// Returns a number with others in the place of counters.
    pub(crate) fn replaced(&mut self, int: Int, by: &HashMap<Counter, Int>) -> Int {
        use IntNode::{Add, Div, Max, Min, Mul, Rem, Sub};
        let node = self.node(int).clone();
        let mut pair = |node: fn(Int, Int) -> IntNode, a, b| {
            let [a, b] = [a, b].map(|operand| self.replaced(operand, by));
            self.integer(node(a, b))
        };
        match node {
            IntNode::Constant(_) | IntNode::Length(Array::Sites) => int,
            IntNode::Counter(counter) => by.get(&counter).copied().unwrap_or(int),
            IntNode::Length(Array::Field(access)) => {
                let access = self.replaced_in(access, by);
                self.integer(IntNode::Length(Array::Field(access)))
            }
            IntNode::Field(access) => {
                let access = self.replaced_in(access, by);
                self.integer(IntNode::Field(access))
            }
            Add(a, b) => pair(Add, a, b),
            Sub(a, b) => pair(Sub, a, b),
            Mul(a, b) => pair(Mul, a, b),
            Div(a, b) => pair(Div, a, b),
            Rem(a, b) => pair(Rem, a, b),
            Min(a, b) => pair(Min, a, b),
            Max(a, b) => pair(Max, a, b),
        }
    }

    /// Returns a path with other numbers in the place of counters.
    pub(crate) fn replaced_in(&mut self, mut access: Access, by: &HashMap<Counter, Int>) -> Access {
        for step in &mut access.steps {
            match step {
                Step::Member(_) => {}
                Step::Index(index) => *index = self.replaced(*index, by),
                Step::Pair(row, column) => {
                    *row = self.replaced(*row, by);
                    *column = self.replaced(*column, by);
                }
            }
        }
        access
    }

    /// Returns a simpler form of a number. A difference with a constant is a sum, so that equal
    /// indices are equal numbers.
    fn simplified(&mut self, node: &IntNode) -> Option<Int> {
        use IntNode::{Add, Div, Max, Min, Mul, Rem, Sub};
        let (Add(a, b) | Sub(a, b) | Mul(a, b) | Div(a, b) | Rem(a, b) | Min(a, b) | Max(a, b)) =
            *node
        else {
            return None;
        };
        if let (Some(x), Some(y)) = (self.value(a), self.value(b)) {
            let value = match node {
                Add(..) => x.checked_add(y),
                Sub(..) => x.checked_sub(y),
                Mul(..) => x.checked_mul(y),
                Div(..) => x.checked_div(y),
                Rem(..) => x.checked_rem(y),
                Min(..) => Some(x.min(y)),
                _ => Some(x.max(y)),
            };
            return value.map(|value| self.constant(value));
        }
        match (node, self.value(a), self.value(b)) {
            (Add(..) | Sub(..), _, Some(0)) | (Mul(..) | Div(..), _, Some(1)) => Some(a),
            (Add(..), Some(0), _) | (Mul(..), Some(1), _) => Some(b),
            (Min(..) | Max(..), ..) if a == b => Some(a),
            (Sub(..), ..) if a == b => Some(self.constant(0)),
            (Sub(..), _, Some(y)) => {
                let opposite = self.constant(y.checked_neg()?);
                Some(self.integer(Add(a, opposite)))
            }
            (Add(..), Some(_), _) => Some(self.integer(Add(b, a))),
            (Add(..), _, Some(y)) => {
                let Add(inner, x) = *self.node(a) else {
                    return None;
                };
                let sum = self.value(x)?.checked_add(y)?;
                let sum = self.constant(sum);
                Some(self.integer(Add(inner, sum)))
            }
            _ => None,
        }
    }

    /// Returns an integer as the source may spell it.
    pub(crate) fn text(&self, int: Int) -> String {
        self.text_within(int, 0)
    }

    /// Returns the text of an integer, in parentheses if it binds less than `binding`.
    fn text_within(&self, int: Int, binding: u8) -> String {
        use IntNode::{Add, Div, Mul, Rem, Sub};
        let (op, own, a, b) = match *self.node(int) {
            IntNode::Constant(value) => return value.to_string(),
            IntNode::Counter(counter) => return self.counters[counter.0 as usize].clone(),
            IntNode::Length(Array::Sites) => return "q.len()".to_owned(),
            IntNode::Length(Array::Field(ref field)) => {
                return format!("{}.len()", self.path_text(field));
            }
            IntNode::Field(ref field) => return self.path_text(field),
            IntNode::Min(a, b) => {
                return format!("{}.min({})", self.text_within(a, 3), self.text(b));
            }
            IntNode::Max(a, b) => {
                return format!("{}.max({})", self.text_within(a, 3), self.text(b));
            }
            Add(a, b) => match self.value(b) {
                Some(y) if y < 0 => {
                    let text = format!("{} - {}", self.text_within(a, 1), y.unsigned_abs());
                    return if binding > 1 {
                        format!("({text})")
                    } else {
                        text
                    };
                }
                _ => ('+', 1, a, b),
            },
            Sub(a, b) => ('-', 1, a, b),
            Mul(a, b) => ('*', 2, a, b),
            Div(a, b) => ('/', 2, a, b),
            Rem(a, b) => ('%', 2, a, b),
        };
        let (a, b) = (self.text_within(a, own), self.text_within(b, own + 1));
        if own < binding {
            format!("({a} {op} {b})")
        } else {
            format!("{a} {op} {b}")
        }
    }

    /// Returns a field as the source may spell it.
    pub(crate) fn path_text(&self, access: &Access) -> String {
        let steps = access.steps.iter().map(|step| match step {
            Step::Member(Member::Named(name)) => format!(".{name}"),
            Step::Member(Member::Unnamed(index)) => format!(".{}", index.index),
            Step::Index(index) => format!("[{}]", self.text(*index)),
            Step::Pair(row, column) => format!("[({}, {})]", self.text(*row), self.text(*column)),
        });
        format!("self{}", steps.collect::<String>())
    }
}
