//! The generated derivatives against differences of the users' own functions, and the generated
//! steps against the discrete Euler–Lagrange equations of a discrete action that is built from the
//! users' own functions.
//!
//! No test here uses a symbolic derivative, so the tests are independent of the differentiation,
//! the residuals and the solves.

use sve_models::case::Case;
use sve_models::checks::assert_relative;
use sve_models::differences::{derivatives, gradient, moved};
use sve_models::functions::{Force, Functions, Lagrangian, NoiseDerivatives, Point};
use sve_models::oracle::{Nodes, cases};
use sve_models::random::Random;

/// First differences are good to 1e-12 times the values (see `differences`); differences of
/// differences divide that error by δ/4 once more, 1e-9. A wrong term shows with its full size.
const FIRST: f64 = 1e-10;
const SECOND: f64 = 1e-8;

/// Compares a matrix with one by differences, whose columns a function gives.
fn assert_matrix(found: &[Vec<f64>], column: impl Fn(usize) -> Vec<f64>, bound: f64, what: &str) {
    for j in 0..found.len() {
        let found: Vec<f64> = found.iter().map(|row| row[j]).collect();
        assert_relative(&found, &column(j), bound, format!("{what}, column {j}"));
    }
}

#[test]
fn generated_derivatives_are_differences_of_the_users_functions() {
    let mut random = Random::new(5);
    // once a model
    for case in cases().iter().filter(|case| case.rule() == "midpoint") {
        let (model, name) = (case.model(), case.plan().system);
        for _ in 0..5 {
            let Point { t, q, p } = model.point(&mut random);
            // any velocity of a regular state will do
            let v = model.velocity(t, &q, &p);
            lagrangian(name, &*model, t, &q, &v);
            noises(name, &*model, t, &q, &p);
            let f = |t, q: &[f64], v: &[f64]| model.f(t, q, v);
            force(&format!("{name}: F"), model.force(t, &q, &v), f, t, &q, &v);
            for (a, jet) in model.noise_forces(t, &q, &v).into_iter().enumerate() {
                let f = |t, q: &[f64], v: &[f64]| model.w(t, q, v).swap_remove(a);
                force(&format!("{name}: noise {a}"), jet, f, t, &q, &v);
            }
        }
    }
}

fn lagrangian(name: &str, model: &dyn Functions, t: f64, q: &[f64], v: &[f64]) {
    let Lagrangian {
        value,
        dq,
        dv,
        dqq,
        dqv,
        dvv,
        dqt,
        dvt,
    } = model.lagrangian(t, q, v);
    let what = |entry: &str| format!("{name}: {entry} of L at t = {t}, q = {q:?}, v = {v:?}");
    // the same terms in another order
    assert_relative(&[value], &[model.l(t, q, v)], 1e-14, what("value"));

    let by_q = |t, q: &[f64], v: &[f64]| gradient(q, |q| model.l(t, q, v));
    let by_v = |t, q: &[f64], v: &[f64]| gradient(v, |v| model.l(t, q, v));
    assert_relative(&dq, &by_q(t, q, v), FIRST, what("dq"));
    assert_relative(&dv, &by_v(t, q, v), FIRST, what("dv"));
    let in_time = derivatives(|d| by_q(t + d, q, v));
    assert_relative(&dqt, &in_time, SECOND, what("dqt"));
    let in_time = derivatives(|d| by_v(t + d, q, v));
    assert_relative(&dvt, &in_time, SECOND, what("dvt"));
    let along_q = |j| derivatives(|d| by_q(t, &moved(q, j, d), v));
    assert_matrix(&dqq, along_q, SECOND, &what("dqq"));
    let along_v = |j| derivatives(|d| by_q(t, q, &moved(v, j, d)));
    assert_matrix(&dqv, along_v, SECOND, &what("dqv"));
    let along_v = |j| derivatives(|d| by_v(t, q, &moved(v, j, d)));
    assert_matrix(&dvv, along_v, SECOND, &what("dvv"));
}

fn noises(name: &str, model: &dyn Functions, t: f64, q: &[f64], p: &[f64]) {
    for (a, jet) in model.noises(t, q, p).into_iter().enumerate() {
        let NoiseDerivatives {
            dq,
            dp,
            dqq,
            dqp,
            dpp,
        } = jet;
        let what =
            |entry: &str| format!("{name}: {entry} of noise {a} at t = {t}, q = {q:?}, p = {p:?}");
        let by_q = |q: &[f64], p: &[f64]| gradient(q, |q| model.g(t, q, p)[a]);
        let by_p = |q: &[f64], p: &[f64]| gradient(p, |p| model.g(t, q, p)[a]);
        assert_relative(&dq, &by_q(q, p), FIRST, what("dq"));
        assert_relative(&dp, &by_p(q, p), FIRST, what("dp"));
        let along_q = |j| derivatives(|d| by_q(&moved(q, j, d), p));
        assert_matrix(&dqq, along_q, SECOND, &what("dqq"));
        let along_p = |j| derivatives(|d| by_q(q, &moved(p, j, d)));
        assert_matrix(&dqp, along_p, SECOND, &what("dqp"));
        let along_p = |j| derivatives(|d| by_p(q, &moved(p, j, d)));
        assert_matrix(&dpp, along_p, SECOND, &what("dpp"));
    }
}

fn force(
    name: &str,
    jet: Force,
    f: impl Fn(f64, &[f64], &[f64]) -> Vec<f64>,
    t: f64,
    q: &[f64],
    v: &[f64],
) {
    let Force { value, dq, dv, dt } = jet;
    let what = |entry: &str| format!("{name}: {entry} at t = {t}, q = {q:?}, v = {v:?}");
    // the same terms in another order
    assert_relative(&value, &f(t, q, v), 1e-14, what("value"));
    let in_time = derivatives(|d| f(t + d, q, v));
    assert_relative(&dt, &in_time, FIRST, what("dt"));
    let along_q = |j| derivatives(|d| f(t, &moved(q, j, d), v));
    assert_matrix(&dq, along_q, FIRST, &what("dq"));
    let along_v = |j| derivatives(|d| f(t, q, &moved(v, j, d)));
    assert_matrix(&dv, along_v, FIRST, &what("dv"));
}

/// `h F + Σ f_a ΔW_a`.
fn impulse(model: &dyn Functions, t: f64, step: &Step, q: &[f64], v: &[f64]) -> Vec<f64> {
    let mut impulse: Vec<f64> = model.f(t, q, v).iter().map(|f| step.h * f).collect();
    for (force, dw) in model.w(t, q, v).iter().zip(&step.dw) {
        impulse = sum(&impulse, *dw, force);
    }
    impulse
}

/// `Σ_ab E_ab ΔW_a ΔW_b` with `E_ab = ∂_q X_a · X_b^q − ∂_p X_a · X_b^p` for the fields
/// `X_a = (∂G_a/∂p, f_a − ∂G_a/∂q)`, less the same without forces: in q and in p.
fn correction(model: &dyn Functions, t: f64, dw: &[f64], q: &[f64], p: &[f64]) -> [Vec<f64>; 2] {
    let noise = |q: &[f64], p: &[f64]| product(&model.g(t, q, p), dw);
    let field = |q: &[f64], p: &[f64], part: f64| {
        let mut rate: Vec<f64> = gradient(q, |q| noise(q, p)).iter().map(|x| -x).collect();
        let v = model.velocity(t, q, p);
        for (force, dw) in model.w(t, q, &v).iter().zip(dw) {
            rate = sum(&rate, part * dw, force);
        }
        [gradient(p, |p| noise(q, p)), rate].concat()
    };
    let along = |part: f64| {
        let direction = field(q, p, part);
        let (in_q, in_p) = direction.split_at(q.len());
        derivatives(|d| field(&sum(q, d, in_q), &sum(p, -d, in_p), part))
    };
    let all = sum(&along(1.0), -1.0, &along(0.0));
    let (in_q, in_p) = all.split_at(q.len());
    [in_q.to_vec(), in_p.to_vec()]
}

/// The data of a step other than its end points.
#[derive(Clone, Debug)]
struct Step {
    t: f64,
    h: f64,
    dw: Vec<f64>,
}

/// `a + factor b`.
fn sum(a: &[f64], factor: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a + c (b − a)`.
fn between(a: &[f64], b: &[f64], c: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + c * (b - a)).collect()
}

/// The discrete action of the rule with node `c`:
/// `h L + ⟨p, q₁ − q₀ − hv⟩ − F + (c − ½) ⟨∂F/∂p, ∂F/∂q⟩` at the node, with `F = Σ G_a ΔW_a`.
fn one_node(
    model: &dyn Functions,
    c: f64,
    step: &Step,
    [q0, q1]: [&[f64]; 2],
    [v, p]: [&[f64]; 2],
) -> f64 {
    let Step { t, h, dw } = step;
    let t = t + c * h;
    let q = between(q0, q1, c);
    let noise = |q: &[f64], p: &[f64]| product(&model.g(t, q, p), dw);
    let by_q = gradient(&q, |q| noise(q, p));
    let by_p = gradient(p, |p| noise(&q, p));
    let defect = sum(&sum(q1, -1.0, q0), -h, v);
    h * model.l(t, &q, v) - noise(&q, p) + product(p, &defect) + (c - 0.5) * product(&by_p, &by_q)
}

/// Both nodes of the Taylor rule, place and velocity, found by fixed-point iterations, which
/// converge as h² does.
fn taylor_nodes(
    model: &dyn Functions,
    step: &Step,
    q0: &[f64],
    q1: &[f64],
) -> [(Vec<f64>, Vec<f64>); 2] {
    let Step { t, h, .. } = *step;
    let mean: Vec<f64> = sum(q1, -1.0, q0).iter().map(|d| d / h).collect();
    let (mut v, mut a) = (mean.clone(), vec![0.0; q0.len()]);
    for _ in 0..40 {
        a = acceleration(model, t, q0, &v, a);
        v = sum(&mean, -0.5 * h, &a);
    }
    let end = (sum(q0, h, &v), sum(&v, h, &a));
    [(q0.to_vec(), v), end]
}

/// The action of the Taylor rule; `work` adds the virtual work of the force at the nodes of the
/// step itself.
fn taylor(model: &dyn Functions, step: &Step, q0: &[f64], q1: &[f64], work: &[Vec<f64>; 2]) -> f64 {
    let [(q, v), (q_end, v_end)] = taylor_nodes(model, step, q0, q1);
    let action = model.l(step.t, &q, &v) + model.l(step.t + step.h, &q_end, &v_end);
    0.5 * step.h * (action + product(&work[0], &q) + product(&work[1], &q_end))
}

/// One correction of `a` towards the solution of `d/dt ∂L/∂v = ∂L/∂q + F`; `d/dt` is a difference
/// along the parabola.
fn acceleration(model: &dyn Functions, t: f64, q: &[f64], v: &[f64], mut a: Vec<f64>) -> Vec<f64> {
    let force = sum(&gradient(q, |q| model.l(t, q, v)), 1.0, &model.f(t, q, v));
    // the equation is linear in a, with the mass matrix
    let rate = derivatives(|d| {
        let q = sum(&sum(q, d, v), 0.5 * d * d, &a);
        let v = sum(v, d, &a);
        gradient(&v, |v| model.l(t + d, &q, v))
    });
    let residual = sum(&force, -1.0, &rate);
    let columns: Vec<Vec<f64>> = (0..q.len())
        .map(|j| derivatives(|d| gradient(&moved(v, j, d), |v| model.l(t, q, v))))
        .collect();
    // Cramer's rule: the models with this rule have one or two coordinates
    if q.len() == 1 {
        a[0] += residual[0] / columns[0][0];
    } else {
        let (x, y) = (&columns[0], &columns[1]);
        let det = x[0] * y[1] - x[1] * y[0];
        a[0] += (residual[0] * y[1] - residual[1] * y[0]) / det;
        a[1] += (x[0] * residual[1] - x[1] * residual[0]) / det;
    }
    a
}

/// Bound of the discrete equations: the correction in the action is a difference (1e-12),
/// differentiated again (4/δ), and for the Taylor rule the acceleration comes from second
/// differences (1e-10), differentiated again. A wrong force is of the size of h, 0.1, a wrong
/// correction or acceleration of the size of h² or ΔW², 0.01.
const EQUATIONS: f64 = 1e-7;

fn vanishes(residual: &[f64], what: &dyn Fn(&str) -> String, equation: &str) {
    let worst = residual.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    assert!(
        worst < EQUATIONS && residual.iter().all(|x| x.is_finite()),
        "{}: {residual:?}",
        what(equation)
    );
}

fn one_node_equations(
    model: &dyn Functions,
    c: f64,
    step: &Step,
    [start, end]: [&Point; 2],
    what: &dyn Fn(&str) -> String,
) {
    let action =
        |q0: &[f64], q1: &[f64], v: &[f64], p: &[f64]| one_node(model, c, step, [q0, q1], [v, p]);
    let (q0, q1) = (&start.q, &end.q);
    // p₀ = p − (1−c) g and p₁ = p + c g
    let p = between(&end.p, &start.p, c);
    let (node, time) = (between(q0, q1, c), step.t + c * step.h);
    let [shift, kick] = correction(model, time, &step.dw, &node, &p);
    // the correction acts on δp too: 0 = ∂S/∂p + (c − ½) shift is affine in v, with the
    // coefficient −h
    let rest = vec![0.0; q0.len()];
    let at_rest = gradient(&p, |p| action(q0, q1, &rest, p));
    let at_rest = sum(&at_rest, c - 0.5, &shift);
    let v: Vec<f64> = at_rest.iter().map(|defect| defect / step.h).collect();
    let impulse = impulse(model, time, step, &node, &v);
    let impulse = sum(&impulse, 0.5 - c, &kick);
    let stationary = gradient(&v, |v| action(q0, q1, v, &p));
    let by_start = gradient(q0, |q| action(q, q1, &v, &p));
    let by_end = gradient(q1, |q| action(q0, q, &v, &p));
    vanishes(&stationary, what, "∂S/∂v");
    // the forces do the work ⟨hF + Σ f ΔW, (1−c)δq₀ + cδq₁⟩
    let at_start = sum(&start.p, 1.0, &by_start);
    vanishes(&sum(&at_start, 1.0 - c, &impulse), what, "p₀ + ∂S/∂q₀");
    let at_end = sum(&end.p, -1.0, &by_end);
    vanishes(&sum(&at_end, -c, &impulse), what, "p₁ − ∂S/∂q₁");
}

/// The action of the rule of Störmer and Verlet.
fn verlet(model: &dyn Functions, step: &Step, [q0, q1]: [&[f64]; 2], [v, p]: [&[f64]; 2]) -> f64 {
    let end = step.t + step.h;
    let mut action = 0.5 * step.h * (model.l(step.t, q0, v) + model.l(end, q1, v));
    action += product(p, &sum(&sum(q1, -1.0, q0), -step.h, v));
    let (g0, g1) = (model.g(step.t, q0, p), model.g(end, q1, p));
    for (a, dw) in step.dw.iter().enumerate() {
        action -= 0.5 * (g0[a] + g1[a]) * dw;
    }
    action
}

fn verlet_equations(
    model: &dyn Functions,
    step: &Step,
    [start, end]: [&Point; 2],
    what: &dyn Fn(&str) -> String,
) {
    let (q0, q1, h) = (&start.q, &end.q, step.h);
    let action =
        |q0: &[f64], q1: &[f64], v: &[f64], p: &[f64]| verlet(model, step, [q0, q1], [v, p]);
    let (mut v, mut p) = (vec![0.0; q0.len()], start.p.clone());
    for _ in 0..60 {
        // ∂S/∂p = 0 is affine in v, with the coefficient −h
        let at_rest = gradient(&p, |p| action(q0, q1, &vec![0.0; q0.len()], p));
        v = at_rest.iter().map(|defect| defect / h).collect();
        // p₀ + ∂S/∂q₀ = 0 is affine in its first p, with the coefficient −1
        let defect = sum(&start.p, 1.0, &gradient(q0, |q| action(q, q1, &v, &p)));
        let defect = sum(&defect, 0.5, &impulse(model, step.t, step, q0, &v));
        p = sum(&p, 1.0, &defect);
    }
    vanishes(&gradient(&v, |v| action(q0, q1, v, &p)), what, "∂S/∂v");
    let at_end = sum(&end.p, -1.0, &gradient(q1, |q| action(q0, q, &v, &p)));
    let at_end = sum(&at_end, -0.5, &impulse(model, step.t + h, step, q1, &v));
    vanishes(&at_end, what, "p₁ − ∂S/∂q₁");
}

fn taylor_equations(
    model: &dyn Functions,
    step: &Step,
    [start, end]: [&Point; 2],
    what: &dyn Fn(&str) -> String,
) {
    let (q0, q1) = (&start.q, &end.q);
    let [(q, v), (q_end, v_end)] = taylor_nodes(model, step, q0, q1);
    let work = [
        model.f(step.t, &q, &v),
        model.f(step.t + step.h, &q_end, &v_end),
    ];
    let by_start = gradient(q0, |q| taylor(model, step, q, q1, &work));
    let by_end = gradient(q1, |q| taylor(model, step, q0, q, &work));
    vanishes(&sum(&start.p, 1.0, &by_start), what, "p₀ + ∂S/∂q₀");
    vanishes(&sum(&end.p, -1.0, &by_end), what, "p₁ − ∂S/∂q₁");
}

fn satisfies_the_discrete_equations(case: &dyn Case, random: &mut Random) {
    let (h, model) = (0.1, case.model());
    for _ in 0..5 {
        let start = model.point(random);
        let dw = random.vector(case.dimensions().1, -0.3, 0.3);
        let end = case.stepped(&start, h, &dw);
        let step = Step { t: start.t, h, dw };
        let what =
            |equation: &str| format!("{}: {equation} in {step:?} from {start:?}", case.name());
        match case.nodes() {
            Nodes::One(c) => one_node_equations(&*model, c, &step, [&start, &end], &what),
            Nodes::Ends => verlet_equations(&*model, &step, [&start, &end], &what),
            Nodes::Predicted => taylor_equations(&*model, &step, [&start, &end], &what),
        }
    }
}

#[test]
fn steps_satisfy_the_discrete_equations() {
    let mut random = Random::new(6);
    for case in cases() {
        satisfies_the_discrete_equations(&*case, &mut random);
    }
}
