//! The maps between equal steps of τ are symplectic for a fixed energy, and for no other reading of
//! the equations; steps against formulas by hand.

use sve_runtime::prelude::*;

use super::{Comet, DoublePendulum, distance, perihelion, symplecticity};

/// States on the path and beside it, where K is not zero.
fn states(start: State<[f64; 2]>) -> [State<[f64; 2]>; 2] {
    [start, State::new([0.3, 0.4], [0.5, -1.2])]
}

#[test]
fn steps_of_every_rule_are_symplectic_at_equal_steps_of_tau() {
    fn check<'a, R>(comet: &'a Integrator<Comet, R>, limit: f64)
    where
        R: Copy + sve_runtime::Rule<<Comet as WithTimeScale>::Held<'a>, Increments = [f64; 0]>,
    {
        let start = perihelion(0.6);
        for state in states(*start) {
            let m = comet.at_energy(start.energy()).tangent(&state, 0.1, &[]);
            let found = symplecticity(&m.expect("a step"));
            assert!(found < limit, "{found:e}");
        }
    }
    let comet = Comet { mu: 1.0 };
    check(&Integrator::new(comet, Gauss::<2>), 6e-16);
    check(&Integrator::new(comet, Gauss::<3>), 6e-16);
    check(&Integrator::new(comet, Gauss::<8>), 6e-16);
    check(&Integrator::new(comet, Midpoint), 3e-15);
    check(&Integrator::new(comet, StormerVerlet), 3e-15);
    check(&Integrator::new(comet, Endpoint), 3e-15);
    check(&Integrator::new(comet, InitialPoint), 3e-15);
    check(
        &Integrator::new(comet, Composed::new(Midpoint, KahanLi8)),
        1e-14,
    );
}

#[test]
fn steps_with_coupled_masses_are_symplectic() {
    let start = TimedState::new(&DoublePendulum, [1.2, -0.4], [0.3, 0.8]).expect("a time scale");
    let pendulum = Integrator::new(DoublePendulum, Gauss::<8>);
    let m = pendulum.at_energy(start.energy()).tangent(&start, 0.3, &[]);
    assert!(symplecticity(&m.expect("a step")) < 2e-15);
}

/// K = s (½p² − 1/r − E) with s = r^{3/2}: returns its vector field, with `part` of the term
/// (H − E) ∇s.
fn field(z: [f64; 4], energy: f64, part: f64) -> [f64; 4] {
    let [x, y, a, b] = z;
    let r = x.hypot(y);
    let (s, slope) = (r.powf(1.5), 1.5 * r.powf(-0.5));
    let excess = part * (0.5 * (a * a + b * b) - 1.0 / r - energy);
    let force = |q: f64| -s * q / (r * r * r) - excess * slope * q;
    [s * a, s * b, force(x), force(y)]
}

fn hamiltonian(z: [f64; 4]) -> f64 {
    0.5 * (z[2] * z[2] + z[3] * z[3]) - 1.0 / z[0].hypot(z[1])
}

/// Returns the end of a step of the midpoint rule, and the place of its node.
fn midpoint(z: [f64; 4], h: f64, energy: f64, part: f64) -> [[f64; 4]; 2] {
    let mut node = z;
    for _ in 0..200 {
        let slope = field(node, energy, part);
        for i in 0..4 {
            node[i] = z[i] + 0.5 * h * slope[i];
        }
    }
    let end = std::array::from_fn(|i| 2.0 * node[i] - z[i]);
    [end, node]
}

#[test]
fn a_step_of_the_midpoint_rule_is_the_one_by_hand() {
    let comet = Integrator::new(Comet { mu: 1.0 }, Midpoint);
    let start = perihelion(0.6);
    let off = TimedState::on_path(State::at(2.0, [0.3, 0.4], [0.5, -1.2]), -0.4);
    for (start, h) in [(start, 0.2), (start, -0.1), (off, 0.1)] {
        let mut state = start;
        comet.step(&mut state, h, &[]).expect("a step");
        let z = [start.q[0], start.q[1], start.p[0], start.p[1]];
        let [end, node] = midpoint(z, h, start.energy(), 1.0);
        let by_hand = State::new([end[0], end[1]], [end[2], end[3]]);
        assert!(distance(&state, &by_hand) < 1e-15, "{state:?} {by_hand:?}");
        let t = start.t + h * node[0].hypot(node[1]).powf(1.5);
        assert!((state.t - t).abs() < 1e-15, "{} {t}", state.t);
        assert_eq!(state.energy(), start.energy());
    }
}

/// Without the term (H − E) ∇s, which is zero along the path, or with the energy of the state in
/// place of a number, the step is not symplectic.
#[test]
fn the_term_that_vanishes_on_the_path_and_the_fixed_energy_make_steps_symplectic() {
    let start = perihelion(0.6);
    let z = [start.q[0], start.q[1], start.p[0], start.p[1]];
    let h = 0.1;
    let map = |z: [f64; 4], variant: &str| {
        let [end, _] = match variant {
            "as derived" => midpoint(z, h, start.energy(), 1.0),
            "without the term" => midpoint(z, h, start.energy(), 0.0),
            _ => midpoint(z, h, hamiltonian(z), 1.0),
        };
        end
    };
    let broken = |variant: &str| {
        let mut columns = [[0.0; 4]; 4];
        let d = 1e-5;
        for j in 0..4 {
            let moved = |by: f64| {
                let mut z = z;
                z[j] += by;
                map(z, variant)
            };
            let points = [moved(2.0 * d), moved(d), moved(-d), moved(-2.0 * d)];
            for i in 0..4 {
                let [a, b, c, e] = points.map(|point| point[i]);
                columns[j][i] = (8.0 * (b - c) - (a - e)) / (12.0 * d);
            }
        }
        let bracket = |i: usize, j: usize| -> f64 {
            let terms = (0..2)
                .map(|k| columns[i][k] * columns[j][2 + k] - columns[i][2 + k] * columns[j][k]);
            terms.sum()
        };
        let mut most = 0.0_f64;
        for i in 0..4 {
            for j in 0..4 {
                let canonical = f64::from(u8::from(j == i + 2)) - f64::from(u8::from(i == j + 2));
                most = most.max((bracket(i, j) - canonical).abs());
            }
        }
        most
    };
    assert!(broken("as derived") < 1e-9);
    assert!(broken("without the term") > 0.01);
    assert!(broken("with the energy of the state") > 0.01);
}

#[test]
fn momenta_of_symmetries_are_conserved() {
    let comet = Integrator::new(Comet { mu: 1.0 }, Gauss::<8>);
    let start = perihelion(0.9);
    let end = comet
        .trajectory(start, 0.8, NoNoise)
        .nth(999)
        .expect("no end")
        .expect("a step");
    let change = comet.system().turn_momentum(&end) - comet.system().turn_momentum(&start);
    assert!(change.abs() < 1e-14, "{change:e}");
    assert_eq!(comet.plan().conserved, ["turn_momentum"]);
}

#[test]
fn symmetric_rules_step_back() {
    let start = perihelion(0.6);
    let mut state = start;
    let comet = Integrator::new(Comet { mu: 1.0 }, Gauss::<3>);
    comet.step(&mut state, 0.1, &[]).expect("a step");
    assert!(state.t > 0.02);
    comet.step(&mut state, -0.1, &[]).expect("a step");
    assert!(
        distance(&state, &start) < 1e-15 && state.t.abs() < 1e-17,
        "{state:?}"
    );
}

#[test]
fn the_plan_says_what_is_kept() {
    let comet = Integrator::new(Comet { mu: 1.0 }, Gauss::<8>);
    let text = comet.plan().to_string();
    for part in [
        "time scale s = ",
        "symplectic for K = s (H − E) at equal steps of τ",
        "H oscillates about E without drift",
        "between equal times t is not symplectic",
        "`.tolerance(tol)` adapts the size of the steps",
        "such steps are not symplectic, and conserve no momenta",
    ] {
        assert!(text.contains(part), "{text}");
    }
    assert!(text.contains("E·") && !text.contains("u[0]"), "{text}");
}

#[test]
fn quantities_are_those_of_the_lagrangian_in_t() {
    let pendulum = DoublePendulum;
    let (q, v) = ([1.2, -0.4], [0.7, -0.9]);
    let state = TimedState::from_velocity(&pendulum, q, v).expect("a time scale");
    let c = 1.6_f64.cos();
    for (p, expected) in state.p.iter().zip([2.0 * v[0] + c * v[1], v[1] + c * v[0]]) {
        assert!((p - expected).abs() < 1e-15);
    }
    for (x, expected) in pendulum.velocity(&state).expect("a velocity").iter().zip(v) {
        assert!((x - expected).abs() < 1e-15);
    }
    let kinetic = v[0] * v[0] + 0.5 * v[1] * v[1] + c * v[0] * v[1];
    let energy = kinetic - 2.0 * q[0].cos() - q[1].cos();
    assert!((state.energy() - energy).abs() < 1e-15);
    let scale = pendulum.scale_at(&state).expect("a time scale");
    assert!((scale - pendulum.scale(q)).abs() < 1e-16);
    assert_eq!(
        DoublePendulum.lagrangian(q, v),
        kinetic + 2.0 * q[0].cos() + q[1].cos()
    );
}
