//! The generated derivatives against differences of the users' own functions, and the generated steps against the discrete
//! Euler–Lagrange equations of a discrete action that is built from the users' own functions.
//!
//! Nothing here uses a symbolic derivative: it is the oracle of the differentiation, the residuals and the solves.

use sve_runtime::prelude::*;
use sve_runtime::{ForceJet, LagrangianJet, NoiseJet, Variational};
use sve_tests::differences::{derivative, derivatives, gradient, moved};
use sve_tests::oracle::{Model, Rule, Visitor, every_step, name};
use sve_tests::random::Random;

/// First differences are good to 1e-12 times the values (see `differences`); differences of differences divide that error by
/// δ/4 once more, 1e-9. A wrong term shows with its full size.
const FIRST: f64 = 1e-10;
const SECOND: f64 = 1e-8;

fn assert_close(got: f64, expected: f64, bound: f64, what: &dyn Fn() -> String) {
    assert!(
        (got - expected).abs() <= bound * (1.0 + expected.abs()),
        "{}: {got:e}, by differences {expected:e}",
        what()
    );
}

struct Jets(Random);

impl Visitor for Jets {
    fn visit<S, R, const N: usize, const M: usize>(&mut self, integrator: &Integrator<S, R>)
    where
        S: Model<N, M> + Variational<R>,
        R: Rule,
    {
        // once a model
        if R::NAME != Midpoint::NAME {
            return;
        }
        let system = integrator.system();
        let plan = integrator.plan();
        for _ in 0..5 {
            let State { t, q, p } = S::point(&mut self.0);
            // any velocity of a regular state will do
            let v = system.velocity_at(t, q, p).unwrap();
            lagrangian(plan.system, system, t, q, v);
            noises(plan.system, system, t, q, p);
            force(plan.system, system, t, q, v);
        }
    }
}

fn lagrangian<S, const N: usize, const M: usize>(
    name: &str,
    system: &S,
    t: f64,
    q: [f64; N],
    v: [f64; N],
) where
    S: Model<N, M>,
{
    let LagrangianJet {
        value,
        dq,
        dv,
        dqq,
        dqv,
        dvv,
        dqt,
        dvt,
    } = system.lagrangian_jet(t, &q, &v);
    let what = |entry: &str| format!("{name}: {entry} of L at t = {t}, q = {q:?}, v = {v:?}");
    // the same terms in another order
    assert_close(value, system.l(t, q, v), 1e-14, &|| what("value"));

    let by_q = |t, q, v| gradient(q, |q| system.l(t, q, v));
    let by_v = |t, q, v| gradient(v, |v| system.l(t, q, v));
    let (first_q, first_v) = (by_q(t, q, v), by_v(t, q, v));
    let dqt_differences = derivatives(|d| by_q(t + d, q, v));
    let dvt_differences = derivatives(|d| by_v(t + d, q, v));
    for i in 0..N {
        assert_close(dq[i], first_q[i], FIRST, &|| what(&format!("dq[{i}]")));
        assert_close(dv[i], first_v[i], FIRST, &|| what(&format!("dv[{i}]")));
        assert_close(dqt[i], dqt_differences[i], SECOND, &|| {
            what(&format!("dqt[{i}]"))
        });
        assert_close(dvt[i], dvt_differences[i], SECOND, &|| {
            what(&format!("dvt[{i}]"))
        });
    }
    for j in 0..N {
        let column_qq = derivatives(|d| by_q(t, moved(q, j, d), v));
        let column_qv = derivatives(|d| by_q(t, q, moved(v, j, d)));
        let column_vv = derivatives(|d| by_v(t, q, moved(v, j, d)));
        for i in 0..N {
            let entry = |matrix: &str| what(&format!("{matrix}[{i}][{j}]"));
            assert_close(dqq[i][j], column_qq[i], SECOND, &|| entry("dqq"));
            assert_close(dqv[i][j], column_qv[i], SECOND, &|| entry("dqv"));
            assert_close(dvv[i][j], column_vv[i], SECOND, &|| entry("dvv"));
        }
    }
}

fn noises<S, const N: usize, const M: usize>(
    name: &str,
    system: &S,
    t: f64,
    q: [f64; N],
    p: [f64; N],
) where
    S: Model<N, M>,
{
    for (a, jet) in system.noise_jets(t, &q, &p).into_iter().enumerate() {
        let NoiseJet {
            dq,
            dp,
            dqq,
            dqp,
            dpp,
        } = jet;
        let what =
            |entry: &str| format!("{name}: {entry} of noise {a} at t = {t}, q = {q:?}, p = {p:?}");
        let by_q = |q, p| gradient(q, |q| system.g(t, q, p)[a]);
        let by_p = |q, p| gradient(p, |p| system.g(t, q, p)[a]);
        let (first_q, first_p) = (by_q(q, p), by_p(q, p));
        for i in 0..N {
            assert_close(dq[i], first_q[i], FIRST, &|| what(&format!("dq[{i}]")));
            assert_close(dp[i], first_p[i], FIRST, &|| what(&format!("dp[{i}]")));
        }
        for j in 0..N {
            let column_qq = derivatives(|d| by_q(moved(q, j, d), p));
            let column_qp = derivatives(|d| by_q(q, moved(p, j, d)));
            let column_pp = derivatives(|d| by_p(q, moved(p, j, d)));
            for i in 0..N {
                let entry = |matrix: &str| what(&format!("{matrix}[{i}][{j}]"));
                assert_close(dqq[i][j], column_qq[i], SECOND, &|| entry("dqq"));
                assert_close(dqp[i][j], column_qp[i], SECOND, &|| entry("dqp"));
                assert_close(dpp[i][j], column_pp[i], SECOND, &|| entry("dpp"));
            }
        }
    }
}

fn force<S, const N: usize, const M: usize>(
    name: &str,
    system: &S,
    t: f64,
    q: [f64; N],
    v: [f64; N],
) where
    S: Model<N, M>,
{
    let ForceJet { value, dq, dv, dt } = system.force_jet(t, &q, &v);
    let what = |entry: &str| format!("{name}: {entry} of F at t = {t}, q = {q:?}, v = {v:?}");
    let exact = system.f(t, q, v);
    let in_time = derivatives(|d| system.f(t + d, q, v));
    for i in 0..N {
        // the same terms in another order
        assert_close(value[i], exact[i], 1e-14, &|| what(&format!("value[{i}]")));
        assert_close(dt[i], in_time[i], FIRST, &|| what(&format!("dt[{i}]")));
    }
    for j in 0..N {
        let column_q = derivatives(|d| system.f(t, moved(q, j, d), v));
        let column_v = derivatives(|d| system.f(t, q, moved(v, j, d)));
        for i in 0..N {
            let entry = |matrix: &str| what(&format!("{matrix}[{i}][{j}]"));
            assert_close(dq[i][j], column_q[i], FIRST, &|| entry("dq"));
            assert_close(dv[i][j], column_v[i], FIRST, &|| entry("dv"));
        }
    }
}

#[test]
fn jets_are_derivatives_of_the_users_functions() {
    every_step(&mut Jets(Random::new(5)));
}

/// A step's data beside its end points.
#[derive(Clone, Copy, Debug)]
struct Step<const M: usize> {
    t: f64,
    h: f64,
    dw: [f64; M],
}

/// The discrete action of the rule with node `c`:
/// `h L + ⟨p, q₁ − q₀ − hv⟩ − F + (c − ½) ⟨∂F/∂p, ∂F/∂q⟩` at the node, with `F = Σ G_a ΔW_a`.
fn one_node<S, const N: usize, const M: usize>(
    system: &S,
    c: f64,
    step: &Step<M>,
    ends: [[f64; N]; 2],
    internal: [[f64; N]; 2],
) -> f64
where
    S: Model<N, M>,
{
    let ([q0, q1], [v, p]) = (ends, internal);
    let Step { t, h, dw } = *step;
    let t = t + c * h;
    let q = core::array::from_fn(|i| q0[i] + c * (q1[i] - q0[i]));
    let noise = |q, p| -> f64 {
        let g = system.g(t, q, p);
        g.iter().zip(&dw).map(|(g, dw)| g * dw).sum()
    };
    let mut action = h * system.l(t, q, v) - noise(q, p);
    let by_q = gradient(q, |q| noise(q, p));
    let by_p = gradient(p, |p| noise(q, p));
    for i in 0..N {
        action += p[i] * (q1[i] - q0[i] - h * v[i]) + (c - 0.5) * by_p[i] * by_q[i];
    }
    action
}

/// Both nodes of the Taylor rule, place and velocity, found by fixed-point iterations, which converge as h² does.
fn taylor_nodes<S, const N: usize, const M: usize>(
    system: &S,
    step: &Step<M>,
    q0: [f64; N],
    q1: [f64; N],
) -> [([f64; N], [f64; N]); 2]
where
    S: Model<N, M>,
{
    let Step { t, h, .. } = *step;
    let mut v: [f64; N] = core::array::from_fn(|i| (q1[i] - q0[i]) / h);
    let mut a = [0.0; N];
    for _ in 0..40 {
        a = acceleration(system, t, q0, v, a);
        v = core::array::from_fn(|i| (q1[i] - q0[i]) / h - 0.5 * h * a[i]);
    }
    let end = (
        core::array::from_fn(|i| q0[i] + h * v[i]),
        core::array::from_fn(|i| v[i] + h * a[i]),
    );
    [(q0, v), end]
}

/// The action of the Taylor rule; `work` adds the virtual work of the force at the nodes of the step itself.
fn taylor<S, const N: usize, const M: usize>(
    system: &S,
    step: &Step<M>,
    q0: [f64; N],
    q1: [f64; N],
    work: &[[f64; N]; 2],
) -> f64
where
    S: Model<N, M>,
{
    let [(q, v), (q_end, v_end)] = taylor_nodes(system, step, q0, q1);
    let mut action = system.l(step.t, q, v) + system.l(step.t + step.h, q_end, v_end);
    for i in 0..N {
        action += work[0][i] * q[i] + work[1][i] * q_end[i];
    }
    0.5 * step.h * action
}

/// One correction of `a` towards the solution of `d/dt ∂L/∂v = ∂L/∂q + F`; `d/dt` is a difference along the parabola.
fn acceleration<S, const N: usize, const M: usize>(
    system: &S,
    t: f64,
    q: [f64; N],
    v: [f64; N],
    mut a: [f64; N],
) -> [f64; N]
where
    S: Model<N, M>,
{
    let force = gradient(q, |q| system.l(t, q, v));
    let other = system.f(t, q, v);
    // the equation is linear in a, with the mass matrix
    let rate = |a: [f64; N]| {
        derivatives(|d| {
            let q = core::array::from_fn(|i| q[i] + d * v[i] + 0.5 * d * d * a[i]);
            let v = core::array::from_fn(|i| v[i] + d * a[i]);
            gradient(v, |v| system.l(t + d, q, v))
        })
    };
    let here = rate(a);
    let residual: Vec<f64> = (0..N).map(|i| force[i] + other[i] - here[i]).collect();
    let columns: Vec<[f64; N]> = (0..N)
        .map(|j| derivatives(|d| gradient(moved(v, j, d), |v| system.l(t, q, v))))
        .collect();
    // Cramer's rule: the models with this rule have one or two coordinates
    if N == 1 {
        a[0] += residual[0] / columns[0][0];
    } else {
        let (x, y) = (columns[0], columns[1]);
        let det = x[0] * y[1] - x[1] * y[0];
        a[0] += (residual[0] * y[1] - residual[1] * y[0]) / det;
        a[1] += (x[0] * residual[1] - x[1] * residual[0]) / det;
    }
    a
}

/// Bound of the discrete equations: the correction in the action is a difference (1e-12), differentiated again (4/δ), and
/// for the Taylor rule the acceleration comes from second differences (1e-10), differentiated again.
/// A wrong force is of the size of h, 0.1, a wrong correction or acceleration of the size of h² or ΔW², 0.01.
const EQUATIONS: f64 = 1e-7;

struct Equations {
    random: Random,
    worst: f64,
}

impl Equations {
    fn vanishes(&mut self, residual: f64, what: &dyn Fn() -> String) {
        self.worst = self.worst.max(residual.abs());
        assert!(residual.abs() < EQUATIONS, "{}: {residual:e}", what());
    }

    fn one_node<S, const N: usize, const M: usize>(
        &mut self,
        system: &S,
        c: f64,
        step: &Step<M>,
        [start, end]: [&State<[f64; N]>; 2],
        what: &dyn Fn(&str) -> String,
    ) where
        S: Model<N, M>,
    {
        let action = |q0, q1, v, p| one_node(system, c, step, [q0, q1], [v, p]);
        // p₀ = p − (1−c) g and p₁ = p + c g
        let p = core::array::from_fn(|i| c * start.p[i] + (1.0 - c) * end.p[i]);
        // ∂S/∂p = 0 is affine in v, with the coefficient −h
        let at_rest = gradient(p, |p| action(start.q, end.q, [0.0; N], p));
        let v = at_rest.map(|slip| slip / step.h);
        let node = core::array::from_fn(|i| start.q[i] + c * (end.q[i] - start.q[i]));
        let impulse = system.f(step.t + c * step.h, node, v).map(|f| f * step.h);
        let stationary = gradient(v, |v| action(start.q, end.q, v, p));
        let start_p = gradient(start.q, |q| action(q, end.q, v, p));
        let end_p = gradient(end.q, |q| action(start.q, q, v, p));
        for i in 0..N {
            self.vanishes(stationary[i], &|| what(&format!("∂S/∂v[{i}]")));
            // the force does the work h⟨F, (1−c)δq₀ + cδq₁⟩
            let (at_start, at_end) = ((1.0 - c) * impulse[i], c * impulse[i]);
            self.vanishes(start.p[i] + start_p[i] + at_start, &|| {
                what(&format!("p₀[{i}] + ∂S/∂q₀"))
            });
            self.vanishes(end.p[i] - end_p[i] - at_end, &|| {
                what(&format!("p₁[{i}] − ∂S/∂q₁"))
            });
        }
    }

    fn taylor<S, const N: usize, const M: usize>(
        &mut self,
        system: &S,
        step: &Step<M>,
        [start, end]: [&State<[f64; N]>; 2],
        what: &dyn Fn(&str) -> String,
    ) where
        S: Model<N, M>,
    {
        let [(q, v), (q_end, v_end)] = taylor_nodes(system, step, start.q, end.q);
        let work = [
            system.f(step.t, q, v),
            system.f(step.t + step.h, q_end, v_end),
        ];
        for i in 0..N {
            let by_start = derivative(|d| taylor(system, step, moved(start.q, i, d), end.q, &work));
            let by_end = derivative(|d| taylor(system, step, start.q, moved(end.q, i, d), &work));
            self.vanishes(start.p[i] + by_start, &|| {
                what(&format!("p₀[{i}] + ∂S/∂q₀"))
            });
            self.vanishes(end.p[i] - by_end, &|| what(&format!("p₁[{i}] − ∂S/∂q₁")));
        }
    }
}

impl Visitor for Equations {
    fn visit<S, R, const N: usize, const M: usize>(&mut self, integrator: &Integrator<S, R>)
    where
        S: Model<N, M> + Variational<R>,
        R: Rule,
    {
        let system = integrator.system();
        for _ in 0..5 {
            let start = S::point(&mut self.random);
            let h = 0.1;
            let dw = self.random.array(-0.3, 0.3);
            let step = Step { t: start.t, h, dw };
            let mut end = start;
            integrator.step(&mut end, h, &dw).unwrap();
            let what = |equation: &str| {
                format!(
                    "{}: {equation} in {step:?} from {start:?}",
                    name(integrator)
                )
            };
            let ends = [&start, &end];
            match R::NODE {
                Some(c) => self.one_node(system, c, &step, ends, &what),
                None => self.taylor(system, &step, ends, &what),
            }
        }
    }
}

#[test]
fn steps_satisfy_the_discrete_equations() {
    let mut check = Equations {
        random: Random::new(6),
        worst: 0.0,
    };
    every_step(&mut check);
    println!("largest residual {:e}", check.worst);
}
