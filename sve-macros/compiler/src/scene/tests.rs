//! Scenes that are built by hand.

use proc_macro2::Span;

use super::share::share;
use super::{Derived, Kinetic, Read, derive};
use crate::algebra::{Arena, Expr, Node, Symbol};
use crate::model::scene::{
    Array, Head, IntNode, Integers, Row, Scene, Slot, SlotArray, Sum, SumId,
};
use crate::model::{Meaning, Symbols};

struct Builder {
    arena: Arena,
    scene: Scene,
}

impl Builder {
    fn new(row: Row) -> Self {
        let mut arena = Arena::new();
        let mut symbols = Symbols::default();
        let time = symbols.declare(Meaning::Time);
        let lagrangian = arena.constant(0.0);
        let scene = Scene {
            symbols,
            time,
            row,
            integers: Integers::default(),
            slots: Vec::new(),
            sums: Vec::new(),
            lagrangian,
            noises: Vec::new(),
            forces: Vec::new(),
            symmetries: Vec::new(),
            constants: Vec::new(),
        };
        Self { arena, scene }
    }

    fn slot(&mut self, array: SlotArray, component: usize) -> Expr {
        self.scene.slots.push(Slot { array, component });
        let meaning = Meaning::Slot(self.scene.slots.len() - 1);
        let symbol = self.scene.symbols.declare(meaning);
        self.arena.symbol(symbol)
    }

    fn sum(&mut self, parent: Option<SumId>, head: Head) -> (SumId, Expr) {
        let id = SumId(self.scene.sums.len());
        let summand = self.arena.constant(0.0);
        self.scene.sums.push(Sum {
            parent,
            head,
            summand,
            at: Span::call_site(),
        });
        let symbol = self.scene.symbols.declare(Meaning::Sum(id.0));
        (id, self.arena.symbol(symbol))
    }
}

/// The chain of Fermi, Pasta, Ulam and Tsingou.
fn chain() -> (Builder, Derived) {
    let mut b = Builder::new(Row::Number);
    let n = b.scene.integers.integer(IntNode::Length(Array::Sites));
    let [zero, one] = [0, 1].map(|value| b.scene.integers.constant(value));
    let (counter, i) = b.scene.integers.counter("i".into());
    let head = |from| Head::For {
        counter,
        from,
        to: n,
    };
    let (masses, kinetic) = b.sum(None, head(zero));
    let v = b.slot(SlotArray::Velocity(i), 0);
    let squared = b.arena.mul(v, v);
    b.scene.sums[masses.0].summand = b.arena.scale(0.5, squared);
    let (springs, potential) = b.sum(None, head(one));
    let before = b.scene.integers.integer(IntNode::Sub(i, one));
    let ends = [i, before].map(|site| b.slot(SlotArray::Configuration(site), 0));
    let d = b.arena.sub(ends[0], ends[1]);
    let [squared, fourth] = [2, 4].map(|k| b.arena.pow(d, k));
    let terms = [(-0.5, squared), (-0.25, fourth)];
    b.scene.sums[springs.0].summand = b.arena.sum(0.0, &terms);
    b.scene.lagrangian = b.arena.add(kinetic, potential);
    let derived = derive(b.scene.clone(), &mut b.arena).expect("a scene");
    (b, derived)
}

/// At the node b between a and c the impulse is `h (f(c − b) − f(b − a))` with `f(d) = d + d³`.
#[test]
fn impulse_of_an_inner_node_is_that_of_its_two_springs() {
    let (b, derived) = chain();
    assert_eq!((derived.common, derived.node.counts), (2, [2, 0, 0]));
    assert!(derived.roots.iter().all(|root| root.is_stream));
    let (own, before, after, h) = (0.3, -0.4, 0.9, 0.125);
    let at = |symbol: Symbol| {
        if symbol == derived.step {
            return h;
        }
        let read = derived.node.reads.iter().find(|read| read.0 == symbol);
        match read.expect("an input of the node").1 {
            Read::Own(0) => own,
            Read::Row(0, 0) => before,
            Read::Row(1, 0) => after,
            other => panic!("{other:?}"),
        }
    };
    let force = |d: f64| d + d.powi(3);
    let expected = h * (force(after - own) - force(own - before));
    let found = b.arena.evaluate(derived.node.impulse[0], at);
    assert!((found - expected).abs() < 1e-15, "{found} {expected}");
}

#[test]
fn mass_of_a_site_is_the_second_derivative() {
    let (b, derived) = chain();
    let Kinetic::Masses(masses) = &derived.kinetic else {
        panic!("masses");
    };
    let [mass] = masses.as_slice() else {
        panic!("{}", masses.len());
    };
    assert_eq!(b.arena.constant_value(mass.value), Some(1.0));
    assert_eq!(derived.scene.integers.text(mass.site), "i");
}

/// The derivatives of `r⁻¹² − r⁻⁶` in the three components of a distance are one factor times a
/// component.
#[test]
fn derivatives_of_a_pair_share_one_factor() {
    let mut b = Builder::new(Row::Array(3));
    let (_, i) = b.scene.integers.counter("i".into());
    let (_, j) = b.scene.integers.counter("j".into());
    let [a, c] = [i, j]
        .map(|site| [0, 1, 2].map(|component| b.slot(SlotArray::Configuration(site), component)));
    let arena = &mut b.arena;
    let d = [0, 1, 2].map(|k| arena.sub(a[k], c[k]));
    let squares = d.map(|d| (1.0, arena.mul(d, d)));
    let r2 = arena.sum(0.0, &squares);
    let [repulsion, attraction] = [-6, -3].map(|k| arena.pow(r2, k));
    let potential = arena.sub(repulsion, attraction);
    let slopes = a.map(|a| {
        let symbol = arena.symbols_of(a).next().expect("a symbol");
        arena.diff(potential, symbol)
    });
    let mut shared = slopes;
    share(shared.iter_mut().collect(), arena);
    let at = |symbol: Symbol| (1.7 * f64::from(symbol.0)).sin();
    for (plain, shared) in slopes.into_iter().zip(shared) {
        let (plain, shared) = (arena.evaluate(plain, at), arena.evaluate(shared, at));
        assert!((plain / shared - 1.0).abs() < 1e-14, "{plain} {shared}");
    }
    let opaque = |e: Expr| {
        let parts = arena.reachable(&[e], |_| true).into_iter();
        let opaque = parts.filter(|&e| matches!(arena.node(e), Node::Opaque(..)));
        opaque.collect::<Vec<Expr>>()
    };
    let factor = opaque(shared[0]);
    assert_eq!(factor.len(), 1);
    assert!(shared.iter().all(|&slope| opaque(slope) == factor));
}
