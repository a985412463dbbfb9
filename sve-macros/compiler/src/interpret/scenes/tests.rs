//! Scenes against the same Lagrangian in Rust: the tree of sums is evaluated as it stands, for
//! random data.

mod bodies;
mod random_loops;
mod systems;

use std::collections::HashMap;

use proc_macro2::TokenStream;
use syn::Member;

use crate::algebra::tests::recipe::Random;
use crate::algebra::{Arena, Expr, Symbol};
use crate::errors::Errors;
use crate::interpret;
use crate::model::Meaning;
use crate::model::scene::{
    Access, Array, Condition, Counter, Head, Int, IntNode, Scene, SlotArray, Step, Sum,
};
use crate::syntax::parse;

/// A field of the user's struct.
#[derive(Clone, Debug)]
enum Field {
    Number(f64),
    Integer(i64),
    List(Vec<Field>),
}

impl Field {
    fn numbers(values: &[f64]) -> Self {
        Self::List(values.iter().copied().map(Self::Number).collect())
    }

    fn integers(values: &[usize]) -> Self {
        let integers = values.iter().map(|&i| Self::Integer(i as i64));
        Self::List(integers.collect())
    }

    fn bodies<const D: usize>(values: &[[f64; D]]) -> Self {
        Self::List(values.iter().map(|row| Self::numbers(row)).collect())
    }
}

/// A scene with the arena of its expressions.
struct Read {
    scene: Scene,
    arena: Arena,
}

/// The data for which a scene is evaluated.
struct Data<'a> {
    read: &'a Read,
    fields: &'a HashMap<&'a str, Field>,
    t: f64,
    q: &'a [Vec<f64>],
    v: &'a [Vec<f64>],
    counters: HashMap<Counter, i64>,
}

fn tokens(text: &str) -> TokenStream {
    text.parse().expect("tokens")
}

/// Reads a block with these members; the errors if there are any.
fn try_read(members: &str) -> Result<Read, Vec<String>> {
    let block = syn::parse2(tokens(&format!("impl P {{ {members} }}"))).expect("a block");
    let (mut errors, mut arena) = (Errors::new(), Arena::new());
    let scene = parse::annotated(tokens("endpoint"), block, &mut errors)
        .and_then(|block| interpret::scene(&block, &mut arena, &mut errors));
    match errors.finish(scene) {
        Ok(scene) => Ok(Read {
            scene: scene.expect("a scene"),
            arena,
        }),
        Err(all) => Err(all.into_iter().map(|error| error.to_string()).collect()),
    }
}

fn read(members: &str) -> Read {
    try_read(members).unwrap_or_else(|errors| panic!("{members}: {errors:?}"))
}

impl Data<'_> {
    fn place(&self, integer: Int) -> usize {
        usize::try_from(self.integer(integer)).expect("an index")
    }

    fn integer(&self, integer: Int) -> i64 {
        let of = |i: &Int| self.integer(*i);
        match self.read.scene.integers.node(integer) {
            IntNode::Constant(value) => *value,
            IntNode::Counter(counter) => self.counters[counter],
            IntNode::Length(Array::Sites) => self.q.len() as i64,
            IntNode::Length(Array::Field(access)) => match self.field(access) {
                Field::List(entries) => entries.len() as i64,
                other => panic!("the length of {other:?}"),
            },
            IntNode::Field(access) => match self.field(access) {
                Field::Integer(value) => *value,
                other => panic!("{other:?} as an integer"),
            },
            IntNode::Add(a, b) => of(a) + of(b),
            IntNode::Sub(a, b) => of(a) - of(b),
            IntNode::Mul(a, b) => of(a) * of(b),
            IntNode::Div(a, b) => of(a) / of(b),
            IntNode::Rem(a, b) => of(a) % of(b),
            IntNode::Min(a, b) => of(a).min(of(b)),
            IntNode::Max(a, b) => of(a).max(of(b)),
        }
    }

    fn field(&self, access: &Access) -> &Field {
        let name = match access.steps.first() {
            Some(Step::Member(Member::Named(name))) => name.to_string(),
            _ => panic!("no field"),
        };
        access.steps[1..]
            .iter()
            .fold(&self.fields[name.as_str()], |field, step| {
                let Field::List(entries) = field else {
                    panic!("{field:?} is no list")
                };
                &entries[match step {
                    Step::Index(index) => self.place(*index),
                    Step::Member(Member::Unnamed(index)) => index.index as usize,
                    Step::Member(Member::Named(name)) => ["x", "y", "z"]
                        .iter()
                        .position(|c| name == c)
                        .expect("a component"),
                    Step::Pair(row, column) => {
                        let Field::List(row) = &entries[self.place(*row)] else {
                            panic!("no matrix")
                        };
                        return &row[self.place(*column)];
                    }
                }]
            })
    }

    fn symbol(&self, symbol: Symbol) -> f64 {
        let scene = &self.read.scene;
        match scene.symbols.meaning(symbol) {
            Meaning::Time => self.t,
            Meaning::Parameter { access, .. } => {
                let text = access.to_string().replace(' ', "");
                let mut path = text.trim_start_matches("self.").split(['[', ']', '.']);
                let mut field = &self.fields[path.next().expect("a name")];
                for index in path.filter(|part| !part.is_empty()) {
                    let Field::List(entries) = field else {
                        panic!("{text}")
                    };
                    let component = ["x", "y", "z"].iter().position(|c| *c == index);
                    let at = component.or_else(|| index.parse().ok());
                    field = &entries[at.expect("an index")];
                }
                match field {
                    Field::Number(value) => *value,
                    other => panic!("{other:?} as a number"),
                }
            }
            Meaning::Slot(at) => {
                let slot = &scene.slots[*at];
                match &slot.array {
                    SlotArray::Configuration(i) => self.q[self.place(*i)][slot.component],
                    SlotArray::Velocity(i) => self.v[self.place(*i)][slot.component],
                    SlotArray::Number(i) => self.integer(*i) as f64,
                    SlotArray::Field(access) => match self.field(access) {
                        Field::Number(value) => *value,
                        other => panic!("{other:?} as a number"),
                    },
                    _ => panic!("a computed number in a scene"),
                }
            }
            other => panic!("{other:?} in a scene"),
        }
    }

    fn holds(&mut self, condition: &Condition) -> bool {
        match condition {
            Condition::Integers(comparison, a, b) => {
                comparison.holds(&self.integer(*a), &self.integer(*b))
            }
            Condition::Numbers(comparison, a, b) => {
                let (a, b) = (self.number(*a, None), self.number(*b, None));
                comparison.holds(&a, &b)
            }
            Condition::Not(inner) => !self.holds(inner),
            Condition::And(a, b) => self.holds(a) && self.holds(b),
            Condition::Or(a, b) => self.holds(a) || self.holds(b),
        }
    }

    /// Returns the terms of a sum.
    fn terms(&mut self, id: usize, sum: &Sum) -> Vec<f64> {
        match &sum.head {
            Head::For { counter, from, to } => {
                let rounds = self.integer(*from)..self.integer(*to);
                let term = |i| {
                    self.counters.insert(*counter, i);
                    self.number(sum.summand, Some(id))
                };
                rounds.map(term).collect()
            }
            Head::If(condition) if self.holds(condition) => {
                vec![self.number(sum.summand, Some(id))]
            }
            Head::If(_) => Vec::new(),
        }
    }

    /// Returns the value of a number that belongs to a sum or to a root.
    fn number(&mut self, number: Expr, of: Option<usize>) -> f64 {
        let read = self.read;
        let mut sums = HashMap::new();
        for symbol in read.arena.symbols_of(number) {
            if let Meaning::Sum(id) = *read.scene.symbols.meaning(symbol) {
                let sum = &read.scene.sums[id];
                assert_eq!(sum.parent.map(|parent| parent.0), of, "parents");
                let value = self.terms(id, sum).into_iter().sum::<f64>();
                sums.insert(symbol, value);
            }
        }
        let at = |symbol| {
            sums.get(&symbol)
                .copied()
                .unwrap_or_else(|| self.symbol(symbol))
        };
        read.arena.evaluate(number, at)
    }
}

/// Random rows.
fn rows(n: usize, length: usize, random: &mut Random) -> Vec<Vec<f64>> {
    let mut number = || random.below(2000) as f64 / 1000.0 - 1.0;
    (0..n)
        .map(|_| (0..length).map(|_| number()).collect())
        .collect()
}

impl Read {
    fn data<'a>(
        &'a self,
        fields: &'a HashMap<&'a str, Field>,
        q: &'a [Vec<f64>],
        v: &'a [Vec<f64>],
    ) -> Data<'a> {
        Data {
            read: self,
            fields,
            t: 0.7,
            q,
            v,
            counters: HashMap::new(),
        }
    }
}

/// Compares a scene with the Lagrangian in Rust, for random rows.
fn compare(
    members: &str,
    fields: &HashMap<&str, Field>,
    sizes: &[usize],
    expected: impl Fn(&[Vec<f64>], &[Vec<f64>]) -> f64,
) {
    let read = read(members);
    let mut random = Random(3);
    for &n in sizes {
        let length = read.scene.row.len();
        let (q, v) = (rows(n, length, &mut random), rows(n, length, &mut random));
        let value = read
            .data(fields, &q, &v)
            .number(read.scene.lagrangian, None);
        let expected = expected(&q, &v);
        let error = (value - expected).abs();
        assert!(
            error <= 1e-12 * (1.0 + expected.abs()),
            "n = {n}: {value}, not {expected}, of {members}"
        );
    }
}
