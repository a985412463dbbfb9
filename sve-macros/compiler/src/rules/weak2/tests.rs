//! `Σ_a K_a` against Poisson brackets of the Hamiltonian as a function of q and p, for systems
//! whose Hamiltonian is a formula; systems that need no term; and the rules that take a term.

use proc_macro2::TokenStream;

use super::{Obstacle, potential, weak_order};
use crate::algebra::{Arena, Expr};
use crate::catalogue::{Rule, RuleOption};
use crate::errors::Errors;
use crate::interpret;
use crate::model::Model;
use crate::syntax::parse;
use crate::system::classify::{Classified, classify};
use crate::system::inverse_mass::NoFormula;
use crate::system::size::{Budget, WORK};

/// Returns the model of a block.
fn read(members: &str) -> (Classified, Arena) {
    let tokens = |text: &str| -> TokenStream { text.parse().expect("tokens") };
    let item = syn::parse2(tokens(&format!("impl P {{ {members} }}"))).expect("a block");
    let (mut arena, mut errors) = (Arena::new(), Errors::new());
    let block = parse::annotated(tokens("midpoint"), item, &mut errors).expect("a block");
    let model = interpret::interpret(&block, &mut arena, &mut errors);
    let model = errors.finish(model).expect("no mistakes").expect("a model");
    let budget = Budget::new(&block, &model, WORK).expect("a small system");
    let system = classify(&block, model, &budget, &mut arena).expect("no mistakes");
    (system, arena)
}

/// Returns {f, g}.
fn bracket(f: Expr, g: Expr, model: &Model, arena: &mut Arena) -> Expr {
    let mut terms = Vec::new();
    for (&q, &p) in model.q.iter().zip(&model.p) {
        let [f_q, g_q] = [f, g].map(|e| arena.diff(e, q));
        let [f_p, g_p] = [f, g].map(|e| arena.diff(e, p));
        terms.push((1.0, arena.mul(f_q, g_p)));
        terms.push((-1.0, arena.mul(f_p, g_q)));
    }
    arena.sum(0.0, &terms)
}

/// `L = ½v₀²m + ½v₁²(2 + q₀q₁) + a v₀ q₁ − V`, whose Hamiltonian is
/// `½(p₀ − a q₁)²/m + ½p₁²/(2 + q₀q₁) + V`.
const LAGRANGIAN: &str = "fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
    let v0 = v[0] * v[0] * (1.0 + q[1] * q[1]);
    0.5 * v0 + 0.5 * v[1] * v[1] * (2.0 + q[0] * q[1]) + self.a * v[0] * q[1] - q[0].cos() * q[1] - t * q[0]
}";
const HAMILTONIAN: &str = "fn hamiltonian(&self, t: f64, q: [f64; 2], p: [f64; 2]) -> f64 {
    let k = p[0] - self.a * q[1];
    0.5 * k * k / (1.0 + q[1] * q[1]) + 0.5 * p[1] * p[1] / (2.0 + q[0] * q[1]) + q[0].cos() * q[1] + t * q[0]
}";

#[test]
fn the_potential_is_the_double_bracket_with_the_hamiltonian() {
    for noise in [
        "#[gamma] fn push(&self, t: f64, q: [f64; 2]) -> f64 { self.s * t * q[0].sin() * q[1] + q[0] * q[0] }",
        "#[h1] fn drag(&self, t: f64, q: [f64; 2], p: [f64; 2]) -> f64 { self.s * t * p[0] * q[1] + p[1] * p[1] * q[0] }",
    ] {
        // the Hamiltonian is read as another noise
        let members = format!("{LAGRANGIAN} {noise} #[h1] {HAMILTONIAN}");
        let (mut system, mut arena) = read(&members);
        let hamiltonian = system.model.noises.pop().expect("two noises").hamiltonian;
        system.mechanics.noises.pop();
        system.commutation = super::Commutation::All(crate::algebra::Vanishing::Proved);
        let model = &system.model;
        let g = model.noises[0].hamiltonian;
        let found = potential(&system, true, &mut arena);
        let found = found.expect("no obstacle").expect("a potential");
        let inner = bracket(g, hamiltonian, model, &mut arena);
        let drift = arena.diff(g, model.time);
        let inner = arena.add(inner, drift);
        let expected = bracket(g, inner, model, &mut arena);
        let difference = arena.sub(found.value, expected);
        assert!(arena.constant_value(expected).is_none());
        assert!(arena.is_zero(difference), "{noise}");
        if let Some(gradient) = found.gradient {
            for (&slope, &q) in gradient.iter().zip(&model.q) {
                let direct = arena.diff(found.value, q);
                let difference = arena.sub(slope, direct);
                assert!(arena.is_zero(difference), "{noise}");
            }
        } else {
            assert!(noise.starts_with("#[h1]"));
        }
    }
}

const FREE: &str = "fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 { v[0] * v[0] + v[0] * v[1] + v[1] * v[1] - q[0].cos() * q[1].sin() }";

#[test]
fn a_constant_potential_needs_no_term() {
    for (members, needs_term) in [
        (
            format!(
                "{FREE} #[gamma] fn push(&self, q: [f64; 2]) -> f64 {{ self.s * q[0] - q[1] }}"
            ),
            false,
        ),
        (
            format!(
                "{FREE} #[gamma] fn push(&self, t: f64, q: [f64; 2]) -> f64 {{ t.cos() * q[0] }}"
            ),
            false,
        ),
        (
            format!("{FREE} #[gamma] fn push(&self, q: [f64; 2]) -> f64 {{ q[0] + q[1].sin() }}"),
            true,
        ),
        // σ² (sin² + cos²)
        (
            "fn lagrangian(&self, q: f64, v: f64) -> f64 { v * v - q.cos() }
          #[gamma] fn push(&self, q: f64) -> [f64; 2] { [self.s * q.sin(), self.s * q.cos()] }"
                .to_owned(),
            false,
        ),
        // the coordinate q² has a constant mass
        (
            "fn lagrangian(&self, q: f64, v: f64) -> f64 { q * q * v * v - q.cos() }
          #[gamma] fn push(&self, q: f64) -> f64 { self.s * q * q }"
                .to_owned(),
            false,
        ),
        (
            "fn lagrangian(&self, q: f64, v: f64) -> f64 { q * q * v * v - q.cos() }
          #[gamma] fn push(&self, q: f64) -> f64 { self.s * q }"
                .to_owned(),
            true,
        ),
    ] {
        let (system, mut arena) = read(&members);
        let found = potential(&system, false, &mut arena).expect("no obstacle");
        assert_eq!(found.is_some(), needs_term, "{members}");
    }
}

#[test]
fn obstacles_are_found() {
    let coupled = |n: usize, mass: &str| {
        format!(
            "fn lagrangian(&self, q: [f64; {n}], v: [f64; {n}]) -> f64 {{
                let mut l = 0.0;
                for i in 0..{n} {{ l += v[i] * v[i] * {n}.0; for j in 0..i {{ l += {mass} * v[i] * v[j]; }} }}
                l
            }}
            #[gamma] fn push(&self, q: [f64; {n}]) -> f64 {{ q[0] * q[1] }}"
        )
    };
    let one = |rest: &str| {
        format!("fn lagrangian(&self, q: f64, v: f64) -> f64 {{ 0.5 * v * v - q * q }} {rest}")
    };
    let moved = |is_forced| Obstacle::MovesPosition {
        noise: "drag".to_owned(),
        is_forced,
    };
    let clash = Obstacle::NonCommuting("push".to_owned(), "drag".to_owned());
    let coupled_too_much = Obstacle::NoInverseMass(NoFormula::TooManyCoupled(4));
    let push = "#[gamma] fn push(&self, q: f64) -> f64 { q * q }";
    let drag = "#[h1] fn drag(&self, q: f64, p: f64) -> f64 { q * p }";
    for (members, expected) in [
        (one(&format!("{push} {drag}")), Some(clash)),
        (one(drag), Some(moved(false))),
        (one(&format!("{drag} #[force] fn air(&self, q: f64, v: f64) -> f64 {{ -v - q }}")), Some(moved(true))),
        (one("#[h1] fn place(&self, q: f64, p: f64) -> f64 { q * q + 0.0 * p }"), None),
        (
            format!("fn lagrangian(&self, q: f64, v: f64) -> f64 {{ -(1.0 - v * v).sqrt() - q * q }} {push}"),
            Some(Obstacle::MomentumNotAffine),
        ),
        (
            one(&format!("{push} #[force] fn air(&self, q: f64, v: f64) -> f64 {{ -v * v * v }}")),
            Some(Obstacle::ForceNotAffine),
        ),
        (one(&format!("{push} #[force] fn air(&self, q: f64, v: f64) -> f64 {{ -q * v + q * q }}")), None),
        (coupled(3, "(q[i] - q[j]).cos()"), None),
        (coupled(4, "(q[i] - q[j]).cos()"), Some(coupled_too_much)),
        (coupled(4, "self.c"), None),
        (
            "fn lagrangian(&self, q: [f64; 4], v: [f64; 4]) -> f64 { v[0] * v[1] + v[1] * v[2] + v[2] * v[3] - q[0] }
             #[gamma] fn push(&self, q: [f64; 4]) -> f64 { q[0] * q[1] }".to_owned(),
            Some(Obstacle::NoInverseMass(NoFormula::NoPivot(4))),
        ),
    ] {
        let (system, mut arena) = read(&members);
        let found = potential(&system, false, &mut arena);
        assert_eq!(found.err(), expected, "{members}");
    }
}

#[test]
fn noise_in_momentum_beside_a_force_is_an_obstacle_of_rules_that_take_it() {
    let members = "fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - q * q }
        #[h1] fn drag(&self, q: f64, p: f64) -> f64 { q * p }
        #[force] fn air(&self, q: f64, v: f64) -> f64 { -v }";
    let (system, mut arena) = read(members);
    let found = potential(&system, true, &mut arena);
    let expected = Obstacle::MovesPositionWithForce("drag".to_owned());
    assert_eq!(found.err(), Some(expected));
}

#[test]
fn weak_orders_of_all_rules() {
    let additive = format!("{FREE} #[gamma] fn push(&self, q: [f64; 2]) -> f64 {{ q[0] }}");
    let multiplicative =
        format!("{FREE} #[gamma] fn push(&self, q: [f64; 2]) -> f64 {{ q[0] * q[0] }}");
    for rule in Rule::all_with_options() {
        let order = |members: &str| {
            let (system, mut arena) = read(members);
            weak_order(rule, &system, &mut arena)
        };
        let deterministic = rule.order;
        assert_eq!(order(FREE), deterministic, "{rule:?}");
        assert_eq!(order(&additive), deterministic.min(2), "{rule:?}");
        let is_corrected = rule.options.contain(RuleOption::Weak2);
        assert_eq!(
            order(&multiplicative),
            if is_corrected { 2 } else { 1 },
            "{rule:?}"
        );
    }
}
