//! Random systems as plain descriptions. Forward-mode evaluation of their discrete actions is the
//! oracle of equations and schemes; it does not use the algebra.

use quote::quote;

use crate::algebra::tests::number::{Bounded, Dual, Number};
use crate::algebra::tests::recipe::{Make, Random, build, evaluate, grow};
use crate::algebra::{Arena, Symbol};
use crate::catalogue::Rule;
use crate::model::configuration::{Configuration, Factor};
use crate::model::{CoordinateNames, Meaning, Model, NoiseKind, NoiseTerm, Symbols};

/// `L = Σ v_i² m/2 + a part of any form`, with noises of any form.
#[derive(Debug)]
pub(super) struct System {
    pub(super) n: usize,
    /// A function of t, m, q and v.
    lagrangian: Vec<Make>,
    /// Functions of t, m, q and, if marked, p. The unmarked ones are γ's.
    noises: Vec<(bool, Vec<Make>)>,
}

/// Values of all variables in the equations of a step.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub(super) t: f64,
    pub(super) m: f64,
    pub(super) h: f64,
    pub(super) q0: Vec<f64>,
    pub(super) p0: Vec<f64>,
    pub(super) dw: Vec<f64>,
    pub(super) d: Vec<f64>,
    /// Internal variables in the order of the action.
    pub(super) internal: Vec<f64>,
}

/// Factor of the part of any form. It is small, so that masses stay positive and steps have
/// solutions.
const PART: f64 = 0.05;

impl System {
    /// Returns a random system with a point where all its functions are moderate.
    pub(super) fn random(random: &mut Random, momenta: bool) -> (Self, Point) {
        let n = 1 + random.below(2);
        let list = |random: &mut Random, count: usize, low: f64, high: f64| -> Vec<f64> {
            (0..count).map(|_| random.uniform(low, high)).collect()
        };
        let noises = random.below(3);
        let point = Point {
            t: random.uniform(0.2, 1.0),
            m: random.uniform(0.7, 1.5),
            h: random.uniform(0.005, 0.02),
            q0: list(random, n, 0.3, 1.2),
            p0: list(random, n, 0.3, 1.2),
            dw: list(random, noises, -0.02, 0.02),
            d: list(random, n, -0.01, 0.01),
            internal: list(random, 4 * n, 0.3, 1.2),
        };
        let known = |with: &[f64]| [&[point.t, point.m], &point.q0[..], with].concat();
        let length = 2 + random.below(10);
        let lagrangian = grow(random, &known(&point.internal[..n]), length);
        let mut noise = || {
            let with_momenta = momenta && random.below(2) == 0;
            let with = if with_momenta { &point.p0[..] } else { &[] };
            let length = 1 + random.below(5);
            (with_momenta, grow(random, &known(with), length))
        };
        let noises = (0..noises).map(|_| noise()).collect();
        let system = Self {
            n,
            lagrangian,
            noises,
        };
        (system, point)
    }

    /// Returns the model that the macro derives from the system.
    pub(super) fn model(&self, arena: &mut Arena) -> Model {
        let mut symbols = Symbols::default();
        symbols.configuration = Configuration::new(vec![Factor::Vector(self.n)]);
        let time = symbols.declare(Meaning::Time);
        let q = symbols.declare_all(self.n, Meaning::Position);
        let v = symbols.declare_all(self.n, Meaning::Velocity);
        let p = symbols.declare_all(self.n, Meaning::Momentum);
        let mass = symbols.declare(Meaning::Parameter {
            name: "m".to_owned(),
            access: quote!(self.m),
            input: None,
        });
        let variables = |with: &[Symbol]| -> Vec<Symbol> { [&[time, mass], &q[..], with].concat() };
        let part = *build(&self.lagrangian, &variables(&v), arena)
            .last()
            .expect("one");
        let mut terms = vec![(PART, part)];
        let m = arena.symbol(mass);
        for &v in &v {
            let v = arena.symbol(v);
            terms.push((0.5, arena.product(&[(m, 1), (v, 2)])));
        }
        let lagrangian = arena.sum(0.0, &terms);
        let mut noises = Vec::new();
        for (momenta, recipe) in &self.noises {
            let with = if *momenta { &p[..] } else { &[] };
            let value = *build(recipe, &variables(with), arena).last().expect("one");
            let hamiltonian = if *momenta { value } else { arena.neg(value) };
            let name = "noise".to_owned();
            noises.push(NoiseTerm {
                name,
                kind: if *momenta {
                    NoiseKind::H1
                } else {
                    NoiseKind::Gamma
                },
                force: None,
                hamiltonian,
            });
        }
        Model {
            constants: Vec::new(),
            names: CoordinateNames::default(),
            symbols,
            time,
            q,
            v,
            p,
            attitude: Vec::new(),
            lagrangian,
            noises,
            force: None,
            symmetries: Vec::new(),
            constraints: Vec::new(),
            time_scale: None,
        }
    }

    pub(super) fn l<T: Number>(&self, t: T, m: T, q: &[T], v: &[T]) -> T {
        let at = [&[t, m], q, v].concat();
        let part = *evaluate(&self.lagrangian, &at).last().expect("one");
        v.iter().fold(part.scale(PART), |sum, v| {
            sum.plus(m.times(v.power(2)).scale(0.5))
        })
    }

    /// Returns `Σ G_a ΔW_a`.
    fn noise<T: Number>(&self, t: T, m: T, q: &[T], p: &[T], dw: &[T]) -> T {
        let terms = self.noises.iter().zip(dw).map(|((momenta, recipe), dw)| {
            let (with, sign) = if *momenta { (p, 1.0) } else { (&[][..], -1.0) };
            let at = [&[t, m], q, with].concat();
            let value = *evaluate(recipe, &at).last().expect("one");
            value.times(*dw).scale(sign)
        });
        terms.fold(T::of(0.0), T::plus)
    }

    /// Returns the discrete action (`docs/mathematics.md`, section 2).
    pub(super) fn action<T: Number>(&self, rule: Rule, x: &Variables<T>) -> T {
        match rule.attribute_name {
            "initial_point" => self.one_node(0.0, x),
            "midpoint" => self.one_node(0.5, x),
            "endpoint" => self.one_node(1.0, x),
            "stormer_verlet" => self.verlet(x),
            "taylor2" => self.taylor(x),
            other => panic!("no action of {other}"),
        }
    }

    fn one_node<T: Number>(&self, c: f64, x: &Variables<T>) -> T {
        let n = self.n;
        let (v, p) = (&x.internal[..n], &x.internal[n..2 * n]);
        let t = x.t.plus(x.h.scale(c));
        let q: Vec<T> = (0..n).map(|i| x.q0[i].plus(x.d[i].scale(c))).collect();
        let mut action = x.h.times(self.l(t, x.m, &q, v));
        action = action.minus(self.noise(t, x.m, &q, p, &x.dw));
        for i in 0..n {
            let constraint = x.d[i].minus(x.h.times(v[i]));
            action = action.plus(p[i].times(constraint));
            // in the direction of one coordinate, of q or of p
            let slope = |of_q: f64, of_p: f64| {
                let along = |list: &[T], by: f64| -> Vec<Dual<T>> {
                    let entry =
                        |(j, &value): (usize, &T)| Dual::new(value, if i == j { by } else { 0.0 });
                    list.iter().enumerate().map(entry).collect()
                };
                let dw: Vec<Dual<T>> = x.dw.iter().map(|&w| Dual::new(w, 0.0)).collect();
                let (t, m) = (Dual::new(t, 0.0), Dual::new(x.m, 0.0));
                self.noise(t, m, &along(&q, of_q), &along(p, of_p), &dw)
                    .slope
            };
            let correction = slope(0.0, 1.0).times(slope(1.0, 0.0));
            action = action.plus(correction.scale(c - 0.5));
        }
        action
    }

    fn verlet<T: Number>(&self, x: &Variables<T>) -> T {
        let n = self.n;
        let (v, p) = (&x.internal[..n], &x.internal[n..2 * n]);
        let end: Vec<T> = (0..n).map(|i| x.q0[i].plus(x.d[i])).collect();
        let mut action = T::of(0.0);
        for (t, q) in [(x.t, &x.q0), (x.t.plus(x.h), &end)] {
            let lagrangian = x.h.times(self.l(t, x.m, q, v));
            let noise = self.noise(t, x.m, q, p, &x.dw);
            action = action.plus(lagrangian.minus(noise).scale(0.5));
        }
        for i in 0..n {
            let constraint = x.d[i].minus(x.h.times(v[i]));
            action = action.plus(p[i].times(constraint));
        }
        action
    }

    fn taylor<T: Number>(&self, x: &Variables<T>) -> T {
        let n = self.n;
        let part = |k: usize| &x.internal[k * n..(k + 1) * n];
        let (v, a, mu, nu) = (part(0), part(1), part(2), part(3));
        let h = x.h;
        let moved =
            |x: &[T], by: &[T]| -> Vec<T> { (0..n).map(|i| x[i].plus(h.times(by[i]))).collect() };
        let end = self.l(x.t.plus(h), x.m, &moved(&x.q0, v), &moved(v, a));
        let both = self.l(x.t, x.m, &x.q0, v).plus(end);
        let mut action = h.times(both).scale(0.5);
        for i in 0..n {
            let half = h.times(h).scale(0.5);
            let constraint = x.d[i].minus(h.times(v[i])).minus(half.times(a[i]));
            action = action.plus(mu[i].times(constraint));
            // d/dt ∂L/∂v_i along the flow, minus ∂L/∂q_i
            let flow = |value: T, rate: T, by: f64| Dual {
                value: Dual { value, slope: rate },
                slope: Dual::of(by),
            };
            let zero = T::of(0.0);
            let unit = |j: usize| if i == j { 1.0 } else { 0.0 };
            let (t, m) = (flow(x.t, T::of(1.0), 0.0), flow(x.m, zero, 0.0));
            let q: Vec<_> = (0..n).map(|j| flow(x.q0[j], v[j], 0.0)).collect();
            let w: Vec<_> = (0..n).map(|j| flow(v[j], a[j], unit(j))).collect();
            let rate = self.l(t, m, &q, &w).slope.slope;
            let still = |x: T, by: f64| Dual::new(x, by);
            let q: Vec<_> = (0..n).map(|j| still(x.q0[j], unit(j))).collect();
            let w: Vec<_> = (0..n).map(|j| still(v[j], 0.0)).collect();
            let force = self.l(still(x.t, 0.0), still(x.m, 0.0), &q, &w).slope;
            let flow = rate.minus(force);
            action = action.plus(half.times(nu[i]).times(flow));
        }
        action
    }
}

/// A point whose coordinates are numbers of any type.
pub(super) struct Variables<T> {
    t: T,
    m: T,
    h: T,
    pub(super) q0: Vec<T>,
    dw: Vec<T>,
    pub(super) d: Vec<T>,
    pub(super) internal: Vec<T>,
}

/// Returns a derivative of the action, with a bound of its error.
pub(super) fn gradient(
    system: &System,
    rule: Rule,
    point: &Point,
    along: impl Fn(&mut Variables<Dual<Bounded>>),
) -> Bounded {
    let of = |x: f64| Dual::new(Bounded::of(x), 0.0);
    let list = |x: &[f64]| x.iter().map(|&x| of(x)).collect::<Vec<_>>();
    let mut variables = Variables {
        t: of(point.t),
        m: of(point.m),
        h: of(point.h),
        q0: list(&point.q0),
        dw: list(&point.dw),
        d: list(&point.d),
        internal: list(&point.internal),
    };
    along(&mut variables);
    system.action(rule, &variables).slope
}
