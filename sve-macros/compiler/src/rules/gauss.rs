//! The Gauss–Galerkin rules with S stages: the action at the nodes c of Gauss quadrature with
//! weights b, positions by polynomials of degree S,
//!
//! ```text
//! S_d = Σ_i { h b_i [L(t_i, Q_i, V_i) + ⟨P_i, U_i − V_i⟩] − Σ_a G_a(t_i, Q_i, P_i) b_i ΔW_a }
//!       + ⟨λ, d − h Σ_j b_j U_j⟩
//! Q_i = q₀ + h Σ_j a_ij U_j        t_i = t₀ + c_i h
//! ```
//!
//! U are the velocities of the path at the nodes, V the arguments of L; both are internal, and so
//! are P and λ. The order is 2S, the rule is symmetric, and there is no Stratonovich correction,
//! since the weighted mean of the nodes is ½. A force does the work
//! `h b_i ⟨F(t_i, Q_i, V_i), δQ_i⟩` at each node.
//!
//! The step is not derived from this unrolled action. It solves the equations of the rule for any L
//! (`sve-runtime/src/gauss/`), with the derivatives at one node. The unrolled action remains the
//! definition; tests derive its step too, for comparison.
//!
//! Sources: Marsden, West, *Discrete mechanics and variational integrators*, Acta Numerica 10
//! (2001), section 2.6; Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006), sections
//! II.1.3 and VI.6.

use std::collections::HashMap;

use super::Discretisation;
use super::action::{Discrete, Variables};
use super::textbook::{self, Features, Point, Textbook, sum};
use crate::algebra::{Expr, Symbol};
use crate::model::{Family, NodeQuantity, Unknown};

/// The rule with `stages` stages.
pub(super) struct Gauss {
    pub(super) stages: usize,
}

/// The notation of a stage.
const STAGE: Point = Point {
    time: "tᵢ",
    position: "Qᵢ",
    velocity: "Vᵢ",
    ..textbook::START
};

impl Discretisation for Gauss {
    fn action(&self, x: &mut Variables<'_>) -> Discrete {
        let (n, stages) = (x.model.dof(), self.stages);
        let family = |x: &mut Variables<'_>, family| {
            let all = x.symbols.declare_all(stages * n, Unknown::of(family));
            all.chunks(n).map(<[Symbol]>::to_vec).collect::<Vec<_>>()
        };
        let u = family(x, Family::StageVelocity);
        let v = family(x, Family::Velocity);
        let p = family(x, Family::Momentum);
        let lambda = x
            .symbols
            .declare_all(n, Unknown::of(Family::VelocityMultiplier));
        let quadrature = Quadrature::new(stages);
        let h = x.arena.symbol(x.h);
        let (mut terms, mut work) = (Vec::new(), Vec::new());
        for i in 0..stages {
            let weight = quadrature.b[i];
            let node = node(x, i, &quadrature, [&u, &v, &p]);
            let mut energy = vec![(1.0, x.arena.substitute(x.model.lagrangian, &node))];
            for k in 0..n {
                let [u, v, p] = [u[i][k], v[i][k], p[i][k]].map(|s| x.arena.symbol(s));
                let difference = x.arena.sub(u, v);
                energy.push((1.0, x.arena.mul(p, difference)));
            }
            let energy = x.arena.sum(0.0, &energy);
            terms.push((weight, x.arena.mul(h, energy)));
            terms.extend(x.noises(weight, &node));
            if let Some((factor, term)) = x.weak2(&node) {
                terms.push((weight * factor, term));
            }
            work.extend(x.work(weight, 0, &node));
        }
        for k in 0..n {
            let mut path = vec![(1.0, x.arena.symbol(x.displacement[k]))];
            for i in 0..stages {
                let u = x.arena.symbol(u[i][k]);
                path.push((-quadrature.b[i], x.arena.mul(h, u)));
            }
            let path = x.arena.sum(0.0, &path);
            let lambda = x.arena.symbol(lambda[k]);
            terms.push((1.0, x.arena.mul(lambda, path)));
        }
        Discrete {
            value: x.arena.sum(0.0, &terms),
            internal: [u.concat(), v.concat(), p.concat(), lambda].concat(),
            work,
            rotations: Vec::new(),
        }
    }

    fn point(&self, node: usize) -> Point {
        const TIMES: [&str; 8] = ["t̄₁", "t̄₂", "t̄₃", "t̄₄", "t̄₅", "t̄₆", "t̄₇", "t̄₈"];
        const POSITIONS: [&str; 8] = ["Q₁", "Q₂", "Q₃", "Q₄", "Q₅", "Q₆", "Q₇", "Q₈"];
        const VELOCITIES: [&str; 8] = ["V₁", "V₂", "V₃", "V₄", "V₅", "V₆", "V₇", "V₈"];
        Point {
            time: TIMES[node],
            position: POSITIONS[node],
            velocity: VELOCITIES[node],
            ..STAGE
        }
    }

    fn textbook(&self, system: &Features) -> Textbook {
        let t = system.time(STAGE.time);
        let constraint = system.pairing("Pᵢ", "Uᵢ − Vᵢ");
        let p = if system.hamiltonians > 0 {
            ", Pᵢ"
        } else {
            ""
        };
        let potential = system.potential("|h|", &format!("K({t}Qᵢ{p})"), 1);
        let mut terms = vec![format!(
            "S = Σᵢ {{ h·bᵢ·(L({t}Qᵢ, Vᵢ){potential} + {constraint})"
        )];
        let (b, dw) = system.increment_at_stage();
        if system.gammas > 0 {
            terms.push(format!(" + {b}{}γ({t}Qᵢ)·{dw}", sum(system.gammas)));
        }
        if system.hamiltonians > 0 {
            terms.push(format!(
                " − {b}{}H₁({t}Qᵢ, Pᵢ)·{dw}",
                sum(system.hamiltonians)
            ));
        }
        let ends = system.pairing("λ", "q₁ − q₀ − h·Σⱼ bⱼ·Uⱼ");
        terms.push(format!(" }} + {ends}"));
        let mut notation = vec!["Qᵢ = q₀ + h·Σⱼ aᵢⱼ·Uⱼ".to_owned()];
        if system.is_timed || system.forces_are_timed {
            notation.push("tᵢ = t₀ + cᵢ·h".to_owned());
        }
        if system.has_stage_noise {
            notation.push("ωᵢ = ∫ ℓᵢ dW with the Lagrange basis ℓ of the nodes".to_owned());
        }
        let stages = self.stages;
        notation.push(format!("a, b, c of Gauss quadrature with {stages} nodes"));
        Textbook {
            action: terms.concat(),
            notation,
            work: works(system),
        }
    }
}

/// Returns the virtual work of all forces at the stages.
fn works(system: &Features) -> String {
    let mut works = Vec::new();
    let at = |force, arguments: &str| system.work(force, arguments, &STAGE);
    if system.is_forced {
        works.push(format!("h·Σᵢ bᵢ·{}", at("F", &STAGE.moving())));
    }
    if system.noise_forces > 0 {
        let (b, dw) = system.increment_at_stage();
        let sum = sum(system.noise_forces);
        works.push(format!("Σᵢ {b}{sum}{}·{dw}", at("f", &STAGE.moving())));
    }
    works.join(" + ") + &system.push("h·|h|·Σᵢ bᵢ", &at("D", STAGE.position), 1)
}

/// Returns the values of the model's variables at node `i`.
fn node(
    x: &mut Variables<'_>,
    i: usize,
    quadrature: &Quadrature,
    [u, v, p]: [&[Vec<Symbol>]; 3],
) -> HashMap<Symbol, Expr> {
    let mut node = HashMap::new();
    let (t, h) = (x.arena.symbol(x.model.time), x.arena.symbol(x.h));
    let t_node = x.arena.sum(0.0, &[(1.0, t), (quadrature.c[i], h)]);
    node.insert(x.model.time, x.at_node(i, NodeQuantity::Time, t_node));
    for k in 0..x.model.dof() {
        let mut at = vec![(1.0, x.arena.symbol(x.start_q[k]))];
        for (j, u) in u.iter().enumerate() {
            let u = x.arena.symbol(u[k]);
            at.push((quadrature.a[i][j], x.arena.mul(h, u)));
        }
        let at = x.arena.sum(0.0, &at);
        node.insert(x.model.q[k], x.at_node(i, NodeQuantity::Position(k), at));
        node.insert(x.model.v[k], x.arena.symbol(v[i][k]));
        node.insert(x.model.p[k], x.arena.symbol(p[i][k]));
    }
    node
}

/// The coefficients of Gauss quadrature on (0, 1), to rounding.
pub(crate) struct Quadrature {
    /// Nodes, ascending.
    pub(crate) c: Vec<f64>,
    /// Weights.
    pub(crate) b: Vec<f64>,
    /// Integrals of the Lagrange polynomial of node j from 0 to node i.
    pub(crate) a: Vec<Vec<f64>>,
}

impl Quadrature {
    /// Returns the coefficients for this number of nodes. Newton's method finds the roots of the
    /// Legendre polynomial, starting near the roots of Chebyshev's polynomial.
    pub(crate) fn new(stages: usize) -> Self {
        let last = stages as f64 + 0.5;
        let roots = (0..stages).map(|i| {
            let mut y = -f64::cos(std::f64::consts::PI * (i as f64 + 0.75) / last);
            for _ in 0..8 {
                let p = legendre(stages, y);
                let slope = stages as f64 * (y * p[stages] - p[stages - 1]) / (y * y - 1.0);
                y -= p[stages] / slope;
            }
            y
        });
        let at: Vec<Vec<f64>> = roots.map(|y| legendre(stages, y)).collect();
        let weight = |p: &Vec<f64>| {
            let squares = (0..stages).map(|k| (2 * k + 1) as f64 * p[k] * p[k]);
            1.0 / squares.sum::<f64>()
        };
        let b: Vec<f64> = at.iter().map(weight).collect();
        let integral = |i: usize, j: usize| {
            let terms = (1..stages).map(|k| at[j][k] * (at[i][k + 1] - at[i][k - 1]));
            0.5 * b[j] * (1.0 + at[i][1] + terms.sum::<f64>())
        };
        let row = |i: usize| (0..stages).map(|j| integral(i, j)).collect();
        Self {
            c: at.iter().map(|p| 0.5 * (1.0 + p[1])).collect(),
            a: (0..stages).map(row).collect(),
            b,
        }
    }
}

/// Returns the Legendre polynomials of degree 0 to `degree` at `y`.
fn legendre(degree: usize, y: f64) -> Vec<f64> {
    let mut p = vec![1.0, y];
    for k in 1..degree {
        let next = ((2 * k + 1) as f64 * y * p[k] - k as f64 * p[k - 1]) / (k + 1) as f64;
        p.push(next);
    }
    p
}

#[cfg(test)]
mod tests {
    use super::Quadrature;

    #[test]
    fn quadrature_is_exact_for_polynomials() {
        for stages in 2..=8 {
            let Quadrature { c, b, a } = Quadrature::new(stages);
            for degree in 0..2 * stages {
                let power = |x: f64| x.powi(degree as i32);
                let integral = 1.0 / (degree + 1) as f64;
                let sum: f64 = (0..stages).map(|i| b[i] * power(c[i])).sum();
                assert!(
                    (sum - integral).abs() < 1e-15,
                    "{stages} nodes, degree {degree}: {sum}"
                );
                for i in (0..stages).filter(|_| degree < stages) {
                    let sum: f64 = (0..stages).map(|j| a[i][j] * power(c[j])).sum();
                    let integral = integral * c[i].powi(degree as i32 + 1);
                    assert!(
                        (sum - integral).abs() < 1e-15,
                        "{stages} nodes, degree {degree}"
                    );
                }
            }
        }
    }
}
