//! Strong orders of degenerate systems, of coordinates and momenta. Wrong steps fail the same test.

use sve_models::degenerate::wrong::{self, Plain};
use sve_models::degenerate::{
    InternalLotkaVolterra, Kubo, Spin, StormyLotkaVolterra, TumblingSpin, VortexPair,
};
use sve_models::orders::{Path, Paths, Row, Tolerance, end, numbers, total};
use sve_runtime::__private::VectorCoordinates;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// Against the midpoint rule with small steps.
const FINE: Paths = Paths {
    seed: 2024,
    batches: 36,
    count: 8,
    coarsest: 6,
    levels: 5,
    finest: 14,
    tolerance: Tolerance {
        bias: 0.0,
        error: 0.03,
    },
};

/// Against exact paths.
const EXACT: Paths = Paths {
    coarsest: 8,
    finest: 12,
    ..FINE
};

/// Rows of the three rules with one node.
fn rules<S, Q, const N: usize, const M: usize>(system: S, start: State<Q>) -> [Row<'static>; 3]
where
    S: System<Dims = Dims<N, M, Q>>
        + Variational<InitialPoint>
        + Variational<Midpoint>
        + Variational<Endpoint>
        + Copy
        + 'static,
    Q: VectorCoordinates<N>,
{
    [
        Row::new(system, InitialPoint, start),
        Row::new(system, Midpoint, start),
        Row::new(system, Endpoint, start),
    ]
}

/// The rest state of a configuration.
fn rest<S, Q, const N: usize, const M: usize>(system: &S, q: Q) -> State<Q>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    State::from_configuration(system, q).unwrap()
}

/// The end of the midpoint rule with the recorded steps.
fn fine<S, Q, const N: usize, const M: usize>(system: S, start: State<Q>) -> impl Fn(u64) -> Path
where
    S: System<Dims = Dims<N, M, Q>> + Variational<Midpoint>,
    Q: VectorCoordinates<N>,
{
    let midpoint = Integrator::new(system, Midpoint);
    FINE.against(M, move |path| end(&midpoint, start, path))
}

#[test]
fn a_rotation_against_its_exact_path() {
    let exact = EXACT.against(1, |path| {
        let (s, c) = (1.0 + 0.5 * total::<1>(path)[0]).sin_cos();
        numbers(&rest(&Kubo, [c - 0.5 * s, s + 0.5 * c]))
    });
    let rows = rules(Kubo, rest(&Kubo, [1.0, 0.5]));
    EXACT.check("γ = −H/2, exact path", &rows, exact);
}

/// The spin of a stereographic point, turned about (0.6, 0, 0.8) by an angle, and its stereographic
/// point.
fn turned([u, v]: [f64; 2], angle: f64) -> [f64; 2] {
    let square = u * u + v * v;
    let spin = [2.0 * u, 2.0 * v, 1.0 - square].map(|x| x / (1.0 + square));
    let axis = [0.6, 0.0, 0.8];
    let along: f64 = (0..3).map(|i| axis[i] * spin[i]).sum();
    let (s, c) = angle.sin_cos();
    let cross = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        axis[j] * spin[k] - axis[k] * spin[j]
    };
    let end: [f64; 3] =
        core::array::from_fn(|i| c * spin[i] + s * cross(i) + (1.0 - c) * along * axis[i]);
    [end[0] / (1.0 + end[2]), end[1] / (1.0 + end[2])]
}

const SPIN: [f64; 2] = [0.3125, 0.40625];

fn spin_exact(path: &Recorded) -> Vec<f64> {
    let angle = -(1.0 + 0.5 * total::<1>(path)[0]);
    numbers(&rest(&Spin, turned(SPIN, angle)))
}

#[test]
fn a_spin_against_its_exact_path() {
    let rows = [Row::new(Spin, Midpoint, rest(&Spin, SPIN))];
    let exact = EXACT.against(1, spin_exact);
    EXACT.check("γ = −H/2, exact path", &rows, exact);
}

#[test]
fn two_vortices_against_their_exact_path() {
    let pair = VortexPair {
        strength: [1.0, 2.0],
        sigma: 0.3,
    };
    let start = rest(&pair, [[1.0, 0.0], [-0.5, 0.0]]);
    let exact = EXACT.against(1, |path| {
        let angle = 3.0 / 2.25 * (1.0 + 0.3 * total::<1>(path)[0]);
        let (s, c) = angle.sin_cos();
        numbers(&rest(&pair, [[c, s], [-0.5 * c, -0.5 * s]]))
    });
    let rows = [Row::new(pair, Midpoint, start)];
    EXACT.check("γ = −σH, exact path", &rows, exact);
}

#[test]
fn lotka_volterra_with_one_noise() {
    let system = InternalLotkaVolterra;
    let start = rest(&system, [1.5, 0.8]);
    FINE.check("one γ", &rules(system, start), fine(system, start));
}

#[test]
fn noises_of_positions_that_do_not_commute() {
    let system = StormyLotkaVolterra;
    let start = rest(&system, [1.5, 0.8]);
    let rows = rules(system, start);
    FINE.check("γ = 0.2 (ln x, y)", &rows, fine(system, start));
    let spin = TumblingSpin;
    let start = rest(&spin, SPIN);
    let rows = [Row::new(spin, Midpoint, start)];
    FINE.check("γ = 0.2 (S_x, S_y)", &rows, fine(spin, start));
}

/// A spring between a mass and a joint without mass, which a stiffening spring ties to the origin.
#[derive(Clone, Copy, Debug)]
struct Joint;

#[variational(initial_point, midpoint, endpoint)]
impl Joint {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * v[0] * v[0] - (x - y).powi(2) - 0.5 * y * y - 0.25 * y.powi(4)
    }

    #[gamma]
    fn shake(&self, q: [f64; 2]) -> f64 {
        0.8 * (2.0 * q[0]).sin()
    }
}

#[test]
fn a_joint_without_mass() {
    let start = rest(&Joint, [0.8, 0.4]);
    FINE.check("γ = 0.8 sin 2x", &rules(Joint, start), fine(Joint, start));
}

/// The plain discrete equations lose their order, and projecting after each step converges to
/// another equation.
#[test]
fn wrong_steps_have_no_order() {
    let paths = Paths {
        count: 4,
        finest: 10,
        ..FINE
    };
    let row = |what: Plain| Row {
        system: "Spin".to_owned(),
        rule: format!("midpoint, {what:?}"),
        order: 0.0,
        end: Box::new(move |path| {
            let start = rest(&Spin, SPIN);
            let (mut q, mut p) = (start.q, start.p);
            for step in 0..path.len() {
                let dw = [path.get(step).unwrap()[0]];
                (q, p) = wrong::step(&Spin, what, (q, p), path.h(), &dw);
            }
            numbers(&rest(&Spin, q))
        }),
    };
    let rows = [Plain::Free, Plain::Projected].map(row);
    let orders = paths.measure(&rows, &paths.against(1, spin_exact));
    for (row, order) in rows.iter().zip(orders) {
        println!("| Spin | {} | γ = −H/2 | none | {order:?} |", row.rule);
        assert!(order.value < 0.8, "{}: {order:?}", row.rule);
    }
}
