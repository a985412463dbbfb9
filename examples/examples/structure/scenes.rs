//! The scenes of the paper and of the examples, and facts about their steps: the columns of the
//! table that are the same on every machine. `tests/tests/structure/comparison.rs` includes this
//! file.

use sve_comparison::compared;
use sve_runtime::__private::Unstructured;
use sve_runtime::__private::VectorCoordinates;
use sve_runtime::plan::{BlockKind, Operations};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, StateOf, System};
use sve_runtime::{Plan, Rule, Variational};

#[derive(Clone, Copy, Debug)]
pub(crate) struct Pendulum {
    g: f64,
}

#[compared(endpoint, midpoint, taylor2)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Oscillator {
    sigma: f64,
}

#[compared(endpoint, midpoint)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Kubo {
    a: f64,
    sigma: f64,
}

#[compared(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - self.a / 2.0 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        self.sigma / 2.0 * (q * q + p * p)
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Synchrotron {
    omega: f64,
    sigma: [f64; 2],
}

#[compared(endpoint, midpoint)]
impl Synchrotron {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.omega.powi(2) * q.cos()
    }

    #[gamma]
    fn kicks(&self, q: f64) -> [f64; 2] {
        [-self.sigma[0] * q.cos(), -self.sigma[1] * q.sin()]
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct DoublePendulum {
    m: [f64; 2],
    l: [f64; 2],
    g: f64,
    s: f64,
}

#[compared(midpoint)]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let ([m1, m2], [l1, l2]) = (self.m, self.l);
        let kinetic = 0.5 * (m1 + m2) * (l1 * v[0]).powi(2) + 0.5 * m2 * (l2 * v[1]).powi(2);
        let coupling = m2 * l1 * l2 * v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + coupling + self.g * ((m1 + m2) * l1 * q[0].cos() + m2 * l2 * q[1].cos())
    }

    #[gamma]
    fn shake(&self, q: [f64; 2]) -> [f64; 2] {
        [self.s * q[0].sin(), self.s * q[0].cos()]
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Kepler {
    m: [f64; 2],
    k: f64,
    sigma: f64,
}

#[compared(midpoint)]
impl Kepler {
    fn inverse_distance(&self, q: [[f64; 2]; 2]) -> f64 {
        let [[x1, y1], [x2, y2]] = q;
        (x2 - x1).hypot(y2 - y1).recip()
    }

    fn lagrangian(&self, q: [[f64; 2]; 2], v: [[f64; 2]; 2]) -> f64 {
        let mut kinetic = 0.0;
        for i in 0..2 {
            for k in 0..2 {
                kinetic += 0.5 * self.m[i] * v[i][k].powi(2);
            }
        }
        kinetic + self.k * self.inverse_distance(q)
    }

    #[gamma]
    fn attraction(&self, q: [[f64; 2]; 2]) -> f64 {
        self.sigma * self.inverse_distance(q)
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Langevin {
    a: f64,
    nu: f64,
    kt: f64,
}

#[compared(midpoint)]
impl Langevin {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - self.a * (q * q - 1.0).powi(2)
    }

    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }

    #[gamma]
    fn bath(&self, q: f64) -> f64 {
        (2.0 * self.nu * self.kt).sqrt() * q
    }
}

/// Beads on a line between walls, coupled by springs that harden.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chain {
    m: f64,
    k: f64,
}

#[compared(endpoint, midpoint)]
impl Chain {
    const N: usize = 12;

    fn lagrangian(&self, q: [f64; Self::N], v: [f64; Self::N]) -> f64 {
        let mut l = 0.0;
        for i in 0..Self::N {
            l += 0.5 * self.m * v[i].powi(2);
        }
        for i in 1..Self::N {
            let s = q[i] - q[i - 1];
            l -= self.k * (0.5 * s.powi(2) + 0.25 * s.powi(4));
        }
        l - 0.5 * self.k * (q[0].powi(2) + q[Self::N - 1].powi(2))
    }
}

/// A system with a rule, and steps to make.
pub(crate) struct Scene<S: System, R> {
    pub(crate) name: &'static str,
    pub(crate) derived: Integrator<S, R>,
    pub(crate) unstructured: Integrator<S, Unstructured<R>>,
    pub(crate) start: StateOf<S>,
    pub(crate) h: f64,
}

/// A function that is called with every scene.
pub(crate) trait Visitor {
    /// Visits a scene.
    fn visit<S, R, Q, const N: usize, const M: usize>(&mut self, scene: &Scene<S, R>)
    where
        S: System<Dims = Dims<N, M, Q>> + Variational<R> + Variational<Unstructured<R>> + Copy,
        Q: VectorCoordinates<N>,
        R: Copy;
}

fn scene<S, R>(name: &'static str, system: S, rule: R, start: StateOf<S>, h: f64) -> Scene<S, R>
where
    S: Variational<R> + Variational<Unstructured<R>> + Copy,
    R: Copy,
{
    Scene {
        name,
        derived: Integrator::new(system, rule),
        unstructured: Integrator::new(system, Unstructured(rule)),
        start,
        h,
    }
}

/// Visits every scene, in the order of the table.
pub(crate) fn every_scene(visitor: &mut impl Visitor) {
    let at = |q: f64, p: f64| State::new([q], [p]);
    let pendulum = Pendulum { g: 9.8 };
    visitor.visit(&scene("pendulum", pendulum, Endpoint, at(1.5, 0.0), 0.1));
    visitor.visit(&scene("pendulum", pendulum, Midpoint, at(1.5, 0.0), 0.1));
    visitor.visit(&scene("pendulum", pendulum, Taylor2, at(1.5, 0.0), 0.1));
    let oscillator = Oscillator { sigma: 1.0 };
    let name = "linear oscillator";
    visitor.visit(&scene(name, oscillator, Endpoint, at(1.0, 0.0), 0.1));
    visitor.visit(&scene(name, oscillator, Midpoint, at(1.0, 0.0), 0.1));
    let kubo = Kubo { a: 1.0, sigma: 0.5 };
    visitor.visit(&scene("Kubo", kubo, Midpoint, at(1.0, 0.0), 0.1));
    let synchrotron = Synchrotron {
        omega: 1.0,
        sigma: [0.1; 2],
    };
    let name = "synchrotron";
    visitor.visit(&scene(name, synchrotron, Endpoint, at(0.5, 0.0), 0.02));
    visitor.visit(&scene(name, synchrotron, Midpoint, at(0.5, 0.0), 0.02));
    let langevin = Langevin {
        a: 1.0,
        nu: 1.0,
        kt: 0.3,
    };
    visitor.visit(&scene("Langevin", langevin, Midpoint, at(1.0, 0.0), 0.05));
    let double = DoublePendulum {
        m: [1.0; 2],
        l: [1.0; 2],
        g: 9.8,
        s: 0.2,
    };
    let start = State::new([2.0, 1.0], [0.0; 2]);
    visitor.visit(&scene("double pendulum", double, Midpoint, start, 0.005));
    let kepler = Kepler {
        m: [1.0, 0.5],
        k: 1.0,
        sigma: 0.01,
    };
    let start = State::new(
        [[-1.6 / 3.0, 0.0], [3.2 / 3.0, 0.0]],
        [[0.0, -0.23], [0.0, 0.23]],
    );
    visitor.visit(&scene("Kepler", kepler, Midpoint, start, 0.01));
    let chain = Chain { m: 1.0, k: 1.0 };
    let q = core::array::from_fn(|i| 0.1 * (i as f64).sin());
    let start = State::new(q, [0.0; Chain::N]);
    visitor.visit(&scene("chain of 12", chain, Endpoint, start, 0.1));
    visitor.visit(&scene("chain of 12", chain, Midpoint, start, 0.1));
}

/// Facts about a derived step, as the cells of the table.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Facts {
    /// The implicit blocks, with their unknowns.
    pub(crate) blocks: String,
    /// Operations of a step, and of each iteration.
    pub(crate) operations: String,
    /// Calls of functions in a step, and in each iteration.
    pub(crate) calls: String,
    /// Sines and cosines that are computed by angle addition, in a step and in each iteration.
    pub(crate) additions: String,
    /// Bytes of the state.
    pub(crate) state: usize,
    /// Bytes in addition to the state: values that are kept for a step size, and the largest system
    /// of equations.
    pub(crate) beside: usize,
}

impl Facts {
    /// Returns the facts about the step of a system by a rule.
    pub(crate) fn of<S: Variational<R>, R>() -> Self {
        let plan = <R as Rule<S::Itself>>::PLAN;
        let count = |of: fn(&Operations) -> usize| {
            let (step, iteration) = (of(&plan.step), of(&plan.iteration));
            match (step, iteration) {
                (step, 0) => step.to_string(),
                (0, iteration) => format!("{iteration} n"),
                (step, iteration) => format!("{step} + {iteration} n"),
            }
        };
        let equations = plan
            .blocks
            .iter()
            .map(|b| system_bytes(b.unknowns.len(), b.band));
        Self {
            blocks: blocks(plan),
            operations: count(|o| o.arithmetic),
            calls: count(|o| o.transcendental),
            additions: count(|o| o.angle_additions),
            state: size_of::<StateOf<S>>(),
            beside: size_of::<<R as Rule<S::Itself>>::Prepared>() + equations.max().unwrap_or(0),
        }
    }
}

/// Returns the bytes of a matrix and a right-hand side; a formula needs none.
fn system_bytes(k: usize, band: Option<(usize, usize)>) -> usize {
    let width = band.map_or(k, |(before, behind)| before + 1 + behind);
    if k == 1 {
        0
    } else {
        size_of::<f64>() * k * (width + 1)
    }
}

fn blocks(plan: &Plan) -> String {
    let implicit = plan.blocks.iter().filter(|b| b.kind != BlockKind::Explicit);
    let words = implicit.map(|block| {
        let band = if block.band.is_some() { " banded" } else { "" };
        format!("{} {}{band}", block.kind, block.unknowns.len())
    });
    let words: Vec<String> = words.collect();
    if words.is_empty() {
        "explicit".to_owned()
    } else {
        words.join(", ")
    }
}
