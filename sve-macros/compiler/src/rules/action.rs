//! Rule → discrete action: one function a rule, and nothing else is particular to a rule.
//!
//! Input: the model. Output: `S_d` as an expression in the start `q₀`, the displacement `d = q₁ − q₀`, the internal variables
//! of the rule, the step size and the Wiener increments (`docs/mathematics.md`, section 2). The displacement is the variable, not q₁,
//! so that a small step does not cancel: `∂S_d/∂q₁ = ∂S/∂d` and `∂S_d/∂q₀ = ∂S/∂q₀ − ∂S/∂d`.

use std::collections::HashMap;

use crate::algebra::{self, Arena, Expr, Symbol};
use crate::rules::Rule;
use crate::system::model::{Family, Meaning, Model, Quantity, Symbols, Unknown};

/// A discrete action with its variables.
pub(crate) struct Action {
    pub(crate) value: Expr,
    pub(crate) h: Symbol,
    pub(crate) start_q: Vec<Symbol>,
    pub(crate) start_p: Vec<Symbol>,
    pub(crate) displacement: Vec<Symbol>,
    /// Variables in which the action is stationary.
    pub(crate) internal: Vec<Symbol>,
    pub(crate) work: Vec<Work>,
}

/// Virtual work of a component of the force, Lagrange–d'Alembert: `impulse · δ place` joins δS.
pub(crate) struct Work {
    /// A component of F at a node, times its weight in time.
    pub(crate) impulse: Expr,
    /// The coordinate of the node.
    pub(crate) place: Expr,
}

/// What an intermediate result of an action stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Node {
    Time,
    Position(usize),
    Velocity(usize),
}

/// What `t + c h`, `q₀ + c d` or, in `taylor2`, `v + h a` is, also after unknowns were eliminated from it; nothing for other
/// expressions.
pub(crate) fn node(expr: Expr, symbols: &Symbols, arena: &Arena) -> Option<Node> {
    let algebra::Node::Opaque(content) = *arena.node(expr) else {
        return None;
    };
    let algebra::Node::Sum(_, terms) = arena.node(content) else {
        return None;
    };
    terms.iter().find_map(|&(term, c)| match arena.node(term) {
        algebra::Node::Symbol(symbol) if c.get() == 1.0 => match symbols.meaning(*symbol) {
            Meaning::Time => Some(Node::Time),
            Meaning::Start(Quantity::Position, i) => Some(Node::Position(*i)),
            Meaning::Unknown(Unknown {
                family: Family::Velocity,
                index,
            }) => Some(Node::Velocity(*index)),
            _ => None,
        },
        _ => None,
    })
}

/// The variables that every rule has.
struct Step<'a> {
    arena: &'a mut Arena,
    model: &'a Model,
    symbols: &'a mut Symbols,
    h: Symbol,
    start_q: Vec<Symbol>,
    displacement: Vec<Symbol>,
    dw: Vec<Symbol>,
}

/// The discrete action of `rule`.
pub(crate) fn discretise(
    rule: Rule,
    model: &Model,
    symbols: &mut Symbols,
    arena: &mut Arena,
) -> Action {
    let n = model.dof();
    let h = symbols.declare(Meaning::StepSize);
    let start_q = symbols.declare_all(n, |i| Meaning::Start(Quantity::Position, i));
    let start_p = symbols.declare_all(n, |i| Meaning::Start(Quantity::Momentum, i));
    let displacement = symbols.declare_all(n, Unknown::of(Family::Displacement));
    let dw = symbols.declare_all(model.noises.len(), Meaning::Wiener);
    let mut step = Step {
        arena,
        model,
        symbols,
        h,
        start_q,
        displacement,
        dw,
    };
    let (value, internal, work) = match rule {
        Rule::InitialPoint => step.one_node(0.0),
        Rule::Midpoint => step.one_node(0.5),
        Rule::Endpoint => step.one_node(1.0),
        Rule::Taylor2 => step.taylor2(),
    };
    let Step {
        start_q,
        displacement,
        ..
    } = step;
    Action {
        value,
        h,
        start_q,
        start_p,
        displacement,
        internal,
        work,
    }
}

impl Step<'_> {
    /// The rule with one node at `q̄ = q₀ + c d`, `t̄ = t₀ + c h`:
    ///
    /// ```text
    /// S_d = h L(t̄,q̄,v) + ⟨p, d − h v⟩ − Σ G_a(t̄,q̄,p) ΔW_a + (c − ½) Σ_ab ⟨∂G_a/∂p, ∂G_b/∂q⟩ ΔW_a ΔW_b
    /// ```
    ///
    /// The last term is the Stratonovich correction. A force does the work `⟨h F(t̄,q̄,v), δq̄⟩`.
    fn one_node(&mut self, c: f64) -> (Expr, Vec<Symbol>, Vec<Work>) {
        let n = self.model.dof();
        let v = self.symbols.declare_all(n, Unknown::of(Family::Velocity));
        let p = self.symbols.declare_all(n, Unknown::of(Family::Momentum));
        let h = self.arena.symbol(self.h);
        let mut node = HashMap::new();
        let t = self.arena.symbol(self.model.time);
        let t_node = self.arena.sum(0.0, &[(1.0, t), (c, h)]);
        node.insert(self.model.time, self.arena.opaque(t_node));
        for i in 0..n {
            let (q, d) = (
                self.arena.symbol(self.start_q[i]),
                self.arena.symbol(self.displacement[i]),
            );
            let at = self.arena.sum(0.0, &[(1.0, q), (c, d)]);
            node.insert(self.model.q[i], self.arena.opaque(at));
            node.insert(self.model.v[i], self.arena.symbol(v[i]));
            node.insert(self.model.p[i], self.arena.symbol(p[i]));
        }

        let lagrangian = self.arena.substitute(self.model.lagrangian, &node);
        let mut terms = vec![(1.0, self.arena.mul(h, lagrangian))];
        for i in 0..n {
            let [d, v, p] = [self.displacement[i], v[i], p[i]].map(|s| self.arena.symbol(s));
            let hv = self.arena.mul(h, v);
            let slip = self.arena.sub(d, hv);
            terms.push((1.0, self.arena.mul(p, slip)));
        }
        for (noise, &dw) in self.model.noises.iter().zip(&self.dw) {
            let g = self.arena.substitute(noise.hamiltonian, &node);
            let dw = self.arena.symbol(dw);
            terms.push((-1.0, self.arena.mul(g, dw)));
        }
        if c != 0.5 {
            let correction = self.stratonovich(&node);
            terms.push((c - 0.5, correction));
        }
        let value = self.arena.sum(0.0, &terms);
        let work = self.work(1.0, &node);
        (value, v.into_iter().chain(p).collect(), work)
    }

    /// The work of the force at a node, for a part of the step.
    fn work(&mut self, part: f64, node: &HashMap<Symbol, Expr>) -> Vec<Work> {
        let h = self.arena.symbol(self.h);
        let components = self.model.force.iter().flatten().zip(&self.model.q);
        let work = components.map(|(&f, q)| {
            let f = self.arena.substitute(f, node);
            let impulse = self.arena.mul(h, f);
            Work {
                impulse: self.arena.scale(part, impulse),
                place: node[q],
            }
        });
        work.collect()
    }

    /// `Σ_a Σ_b ⟨∂G_a/∂p, ∂G_b/∂q⟩ ΔW_a ΔW_b` at a node.
    fn stratonovich(&mut self, node: &HashMap<Symbol, Expr>) -> Expr {
        let mut terms = Vec::new();
        for (a, &dw_a) in self.model.noises.iter().zip(&self.dw) {
            for (b, &dw_b) in self.model.noises.iter().zip(&self.dw) {
                if self.arena.is_exhausted() {
                    return self.arena.constant(0.0);
                }
                let (dw_a, dw_b) = (self.arena.symbol(dw_a), self.arena.symbol(dw_b));
                for i in 0..self.model.dof() {
                    let dp = self.arena.diff(a.hamiltonian, self.model.p[i]);
                    let dq = self.arena.diff(b.hamiltonian, self.model.q[i]);
                    let product = self.arena.product(&[(dp, 1), (dq, 1)]);
                    let at_node = self.arena.substitute(product, node);
                    terms.push((
                        1.0,
                        self.arena.product(&[(at_node, 1), (dw_a, 1), (dw_b, 1)]),
                    ));
                }
            }
        }
        self.arena.sum(0.0, &terms)
    }

    /// The second-order Taylor variational integrator (Schmitt, Shingel, Leok): with the initial velocity `v` and the
    /// acceleration `a` of the Euler–Lagrange flow at `(q₀, v)`,
    ///
    /// ```text
    /// S_d = ½h [ L(q₀,v) + L(q₀+hv, v+ha) ] + ⟨μ, d − hv − ½h²a⟩ + ½h² ⟨ν, L_vv a + L_vq v + L_vt − L_q⟩
    /// ```
    ///
    /// `v` and `a` are defined by equations, so they join the action with the multipliers μ and ν; the second is scaled
    /// by ½h² to be of the size of a momentum. A force F joins the flow, `… − F` in the last bracket, and does half of its work
    /// at each end.
    fn taylor2(&mut self) -> (Expr, Vec<Symbol>, Vec<Work>) {
        let n = self.model.dof();
        let families = [
            Family::Velocity,
            Family::Acceleration,
            Family::Impulse,
            Family::Flow,
        ];
        let [v, a, mu, nu] = families.map(|f| self.symbols.declare_all(n, Unknown::of(f)));
        let h = self.arena.symbol(self.h);
        let t = self.arena.symbol(self.model.time);
        let (mut start, mut end) = (HashMap::new(), HashMap::new());
        let t_end = self.arena.add(t, h);
        end.insert(self.model.time, self.arena.opaque(t_end));
        for i in 0..n {
            let [q, v, a] = [self.start_q[i], v[i], a[i]].map(|s| self.arena.symbol(s));
            let (hv, ha) = (self.arena.mul(h, v), self.arena.mul(h, a));
            let (q_end, v_end) = (self.arena.add(q, hv), self.arena.add(v, ha));
            start.insert(self.model.q[i], q);
            start.insert(self.model.v[i], v);
            end.insert(self.model.q[i], self.arena.opaque(q_end));
            end.insert(self.model.v[i], self.arena.opaque(v_end));
        }
        let accelerations: Vec<Expr> = a.iter().map(|&s| self.arena.symbol(s)).collect();
        let mut terms = Vec::new();
        for node in [&start, &end] {
            let lagrangian = self.arena.substitute(self.model.lagrangian, node);
            terms.push((0.5, self.arena.mul(h, lagrangian)));
        }
        for i in 0..n {
            let [d, v, a, mu, nu] =
                [self.displacement[i], v[i], a[i], mu[i], nu[i]].map(|s| self.arena.symbol(s));
            let hv = self.arena.mul(h, v);
            let half_h2_a = self.arena.product(&[(h, 2), (a, 1)]);
            let slip = self
                .arena
                .sum(0.0, &[(1.0, d), (-1.0, hv), (-0.5, half_h2_a)]);
            terms.push((1.0, self.arena.mul(mu, slip)));
            let flow = self.euler_lagrange(i, &start, &accelerations);
            terms.push((0.5, self.arena.product(&[(h, 2), (nu, 1), (flow, 1)])));
        }
        let value = self.arena.sum(0.0, &terms);
        let mut work = self.work(0.5, &start);
        work.extend(self.work(0.5, &end));
        (value, [v, a, mu, nu].concat(), work)
    }

    /// Component `i` of `L_vv a + L_vq v + L_vt − L_q − F` at a node.
    fn euler_lagrange(&mut self, i: usize, node: &HashMap<Symbol, Expr>, a: &[Expr]) -> Expr {
        let momentum = self.arena.diff(self.model.lagrangian, self.model.v[i]);
        let force = self.arena.diff(self.model.lagrangian, self.model.q[i]);
        let drift = self.arena.diff(momentum, self.model.time);
        let mut terms = vec![(1.0, drift), (-1.0, force)];
        terms.extend(self.model.force.iter().map(|f| (-1.0, f[i])));
        for j in 0..self.model.dof() {
            let v = self.arena.symbol(self.model.v[j]);
            let moved = self.arena.diff(momentum, self.model.q[j]);
            terms.push((1.0, self.arena.mul(moved, v)));
            let mass = self.arena.diff(momentum, self.model.v[j]);
            terms.push((1.0, self.arena.mul(mass, a[j])));
        }
        let sum = self.arena.sum(0.0, &terms);
        self.arena.substitute(sum, node)
    }
}
