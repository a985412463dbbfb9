//! Forces in every rule: closed forms, the exact contraction by linear friction, and orders of
//! convergence. `derivatives` tests that the steps obey the discrete equations with a force.

use sve_models::checks::assert_states_close;
use sve_models::models::{Bath, Damped};
use sve_models::oracle::{damped, stirred};
use sve_models::random::Random;
use sve_models::stepper::one_node;
use sve_runtime::Variational;
use sve_runtime::baseline::{
    BackwardEulerMaruyama, EulerMaruyama, Heun, RungeKutta4, TaylorSeries2,
};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// Solves two linear equations.
fn solve(a: [[f64; 2]; 2], b: [f64; 2]) -> [f64; 2] {
    let det = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    [
        (b[0] * a[1][1] - b[1] * a[0][1]) / det,
        (b[1] * a[0][0] - b[0] * a[1][0]) / det,
    ]
}

/// The one-node rules have `v = p̃ = c p₀ + (1−c) p₁`, `q₁ − q₀ = h p̃`, `p₁ − p₀ = −h (q₀ +
/// c(q₁−q₀)) − hν p̃ + σΔW`.
fn closed_form(c: f64, nu: f64, kick: f64, h: f64, q: f64, p: f64) -> (f64, f64) {
    let matrix = [[1.0, -h * (1.0 - c)], [h * c, 1.0 + h * nu * (1.0 - c)]];
    let rhs = [q + h * c * p, p - h * (1.0 - c) * q - h * nu * c * p + kick];
    let [q1, p1] = solve(matrix, rhs);
    (q1, p1)
}

#[test]
fn closed_forms_of_the_damped_oscillator() {
    let system = Bath {
        omega: 1.0,
        nu: 0.8,
        sigma: 0.5,
    };
    for (rule, c) in one_node(&system).iter().zip([0.0, 0.5, 1.0]) {
        let mut random = Random::new(3);
        for _ in 0..1000 {
            let [[q], [p], [w]] = [2.0, 2.0, 1.0].map(|size| random.array(-size, size));
            let state = rule.after(State::new([q], [p]), 0.3, &[w], 1);
            let (q1, p1) = closed_form(c, system.nu, system.sigma * w, 0.3, q, p);
            // a dozen operations on terms up to 3
            assert_states_close(&state, &State::new([q1], [p1]), 1e-14, rule.name());
        }
    }
}

/// Three coupled beads, each with friction by its own momentum, in a quartic potential.
struct Beads {
    m: [f64; 3],
    nu: f64,
}

#[variational(initial_point, endpoint, midpoint)]
impl Beads {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let mut sum = 0.0;
        for i in 0..3 {
            sum += 0.5 * self.m[i] * v[i].powi(2) - 0.25 * q[i].powi(4);
        }
        for i in 1..3 {
            sum -= (q[i] - q[i - 1]).cosh();
        }
        sum
    }

    #[force]
    fn friction(&self, _q: [f64; 3], v: [f64; 3]) -> [f64; 3] {
        let mut force = [0.0; 3];
        for i in 0..3 {
            force[i] = -self.nu * self.m[i] * v[i];
        }
        force
    }

    #[gamma]
    fn kicks(&self, q: [f64; 3]) -> [f64; 2] {
        [0.3 * q[0] * q[1], 0.2 * q[2].sin()]
    }
}

/// `Σ dxᵢ∧dyᵢ` on two columns of a linear map, for rows x and y.
fn form<const N: usize>(
    x: impl Fn(usize, usize) -> f64,
    y: impl Fn(usize, usize) -> f64,
    [a, b]: [usize; 2],
) -> f64 {
    (0..N).map(|i| x(i, a) * y(i, b) - y(i, a) * x(i, b)).sum()
}

/// With F = −νp and a constant mass a step with node c changes the symplectic form by
///
/// ```text
/// Σ dq₁∧dp₁ = Σ dq₀∧dp₀ − hν Σ dq₀∧dp̃        p̃ = c p₀ + (1−c) p₁
/// ```
///
/// whatever the potential and the noise: the step without the force is symplectic from `p₀ +
/// (1−c)hF` to `p₁ − chF`, and dq₁ = dq₀ + h m⁻¹ dp̃. So the endpoint contracts it by 1 − hν, the
/// initial point by 1/(1+hν).
fn contraction<S, R, const N: usize, const M: usize>(
    system: S,
    rule: R,
    (c, nu): (f64, f64),
    factor: Option<f64>,
) where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let h = 0.2;
    let integrator = Integrator::new(system, rule);
    let mut random = Random::new(9);
    for _ in 0..50 {
        let start = State::new(random.array(-1.0, 1.0), random.array(-1.0, 1.0));
        let dw = random.array(-0.5, 0.5);
        let m = integrator.tangent(&start, h, &dw).unwrap();
        let unit = |row: usize, column: usize| f64::from(u8::from(row == column));
        for pair in (0..2 * N).flat_map(|a| (0..2 * N).map(move |b| [a, b])) {
            let before = form::<N>(unit, |i, k| unit(N + i, k), pair);
            let after = form::<N>(|i, k| m[i][k], |i, k| m[N + i][k], pair);
            let mean = |i: usize, k: usize| c * unit(N + i, k) + (1.0 - c) * m[N + i][k];
            let lost = h * nu * form::<N>(unit, mean, pair);
            let expected = factor.map_or(before - lost, |factor| factor * before);
            // a dozen products of entries up to 2
            assert!(
                (after - expected).abs() < 1e-13,
                "{pair:?}: {after}, expected {expected}"
            );
        }
    }
}

#[test]
fn linear_friction_contracts_the_symplectic_form_exactly() {
    let nu = 0.7;
    let beads = || Beads {
        m: [1.0, 0.5, 2.0],
        nu,
    };
    let single = || Damped { nu, ..damped() };
    let initial_point = 1.0 / (1.0 + 0.2 * nu);
    let endpoint = 1.0 - 0.2 * nu;
    contraction::<Beads, _, 3, 2>(beads(), InitialPoint, (0.0, nu), Some(initial_point));
    contraction(beads(), InitialPoint, (0.0, nu), None);
    contraction(beads(), Midpoint, (0.5, nu), None);
    contraction(beads(), Endpoint, (1.0, nu), Some(endpoint));
    contraction::<Damped, _, 1, 1>(single(), InitialPoint, (0.0, nu), Some(initial_point));
    contraction(single(), Midpoint, (0.5, nu), None);
    contraction(single(), Endpoint, (1.0, nu), Some(endpoint));
}

/// Returns the state after `steps` steps over unit time.
fn end<M>(method: &M, steps: u32) -> State<[f64; 2]>
where
    M: Method,
    M::System: System<Dims = Dims<2, 0>>,
{
    let mut state = State::new([0.5, -0.3], [0.2, 0.4]);
    for _ in 0..steps {
        method
            .step(&mut state, 1.0 / f64::from(steps), &[])
            .unwrap();
    }
    state
}

/// Every method against RK4 with a fine step. A force that is missing in one place of a method
/// would reduce the order.
#[test]
fn orders_of_convergence_with_a_force() {
    let exact = end(&RungeKutta4::new(stirred()), 4000);
    let distance = |state: State<[f64; 2]>| -> f64 {
        let parts = [(state.q, exact.q), (state.p, exact.p)];
        let squares = parts.map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2));
        (squares[0] + squares[1]).sqrt()
    };
    macro_rules! order {
        ($($method:expr => $order:literal),* $(,)?) => {$({
            let method = $method;
            let [coarse, fine] = [160, 320].map(|steps| distance(end(&method, steps)));
            let order = (coarse / fine).log2();
            println!("{}: {order:.3}", stringify!($method));
            // the next term of the error is of relative size h
            assert!((order - $order).abs() < 0.05, "{}: {order}", stringify!($method));
        })*};
    }
    order! {
        Integrator::new(stirred(), InitialPoint) => 1.0,
        Integrator::new(stirred(), Endpoint) => 1.0,
        Integrator::new(stirred(), Midpoint) => 2.0,
        Integrator::new(stirred(), Taylor2) => 2.0,
        EulerMaruyama::new(stirred()) => 1.0,
        BackwardEulerMaruyama::new(stirred()) => 1.0,
        Heun::new(stirred()) => 2.0,
        TaylorSeries2::new(stirred()) => 2.0,
    }
}
