//! The units of length, time and mass do not matter: the same problem in units that differ by
//! powers of two gives the same bits.
//!
//! Multiplication by a power of two commutes with every rounding, so that a step whose every
//! operation is homogeneous in the units has to agree bit for bit: sums of terms of one unit,
//! products, quotients, square roots, and the solves and stopping tests of Newton's method for one
//! and two unknowns, which compare terms of one unit. From three unknowns on the pivots are chosen
//! by size, relative to the row: they stay the same where the unknowns have one unit, and where
//! these differ the results agree to a few ulp instead. An absolute constant hidden anywhere (a
//! tolerance, a first guess) breaks this.

use sve_models::models::{
    Chain, DoublePendulum, Kubo, Magnetic, Polar, Quartic, Relativistic, SphericalPendulum,
};
use sve_models::oracle::{
    chain, double_pendulum, magnetic, polar, quartic, relativistic, spherical_pendulum,
};
use sve_models::stepper::{Stepper, one_node};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

const STEPS: u64 = 200;

/// The unit of `length^a time^b mass^c`.
#[derive(Clone, Copy, Debug)]
struct Units {
    length: i32,
    time: i32,
    mass: i32,
}

const fn units(length: i32, time: i32, mass: i32) -> Units {
    Units { length, time, mass }
}

impl Units {
    fn of(self, a: i32, b: i32, c: i32) -> f64 {
        2.0_f64.powi(a * self.length + b * self.time + c * self.mass)
    }

    fn energy(self) -> f64 {
        self.of(2, -2, 1)
    }

    fn action(self) -> f64 {
        self.of(2, -1, 1)
    }

    /// Returns the unit of dW, whose square is a time.
    fn wiener(self) -> f64 {
        2.0_f64.powi(self.time / 2)
    }

    /// Returns the unit of a noise Hamiltonian, whose product with dW is an action.
    fn noise(self) -> f64 {
        self.action() / self.wiener()
    }
}

/// Other units: one at a time by 2^±60, and mixtures.
fn others() -> impl Iterator<Item = Units> {
    [-60, 60].into_iter().flat_map(|k| {
        [
            units(k, 0, 0),
            units(0, k, 0),
            units(0, 0, k),
            units(k, k, 0),
            units(0, -k, k),
        ]
    })
}

/// The unit of each coordinate.
type CoordinateUnits<const N: usize> = fn(Units) -> [f64; N];

/// Largest difference between a run and the same in other units, brought back; relative to the
/// largest entry of its kind.
fn difference<const N: usize, const M: usize>(
    [here, there]: [&dyn Stepper<[f64; N], [f64; M]>; 2],
    units: Units,
    coordinates: CoordinateUnits<N>,
    start: State<[f64; N]>,
) -> f64 {
    let unit_q = coordinates(units);
    // the momentum of a coordinate: an action over its unit
    let unit_p = unit_q.map(|unit| units.action() / unit);
    let scaled = |state: &State<[f64; N]>| State {
        t: state.t * units.of(0, 1, 0),
        q: core::array::from_fn(|i| state.q[i] * unit_q[i]),
        p: core::array::from_fn(|i| state.p[i] * unit_p[i]),
    };
    let h = 0.05;
    let noise = Wiener::new(77);
    let (mut a, mut b) = (start, scaled(&start));
    let (mut worst, mut size): (f64, f64) = (0.0, 0.0);
    for step in 0..STEPS {
        let dw: [f64; M] = core::array::from_fn(|i| noise.increment(step, i, h));
        here.step(&mut a, h, &dw).unwrap();
        let dw = dw.map(|dw| dw * units.wiener());
        if let Err(error) = there.step(&mut b, h * units.of(0, 1, 0), &dw) {
            panic!("step {step} in {units:?}: {error}");
        }
        let expected = scaled(&a);
        assert_eq!(b.t, expected.t);
        for i in 0..N {
            size = size.max(a.q[i].abs()).max(a.p[i].abs());
            worst = worst.max((b.q[i] - expected.q[i]).abs() / unit_q[i]);
            worst = worst.max((b.p[i] - expected.p[i]).abs() / unit_p[i]);
        }
    }
    worst / size
}

/// Runs every rule in other units. `make` gives the system in such units.
fn check<S, const N: usize, const M: usize>(
    others: impl Iterator<Item = Units>,
    make: impl Fn(Units) -> S,
    coordinates: CoordinateUnits<N>,
    start: State<[f64; N]>,
    bound: f64,
) where
    S: System<Dims = Dims<N, M>>
        + Variational<InitialPoint>
        + Variational<Endpoint>
        + Variational<Midpoint>,
{
    let here = make(units(0, 0, 0));
    for other in others {
        let there = make(other);
        for (here, there) in one_node(&here).iter().zip(&one_node(&there)) {
            let difference = difference([&**here, &**there], other, coordinates, start);
            let name = here.name();
            assert!(difference <= bound, "{name} in {other:?}: {difference:e}");
        }
    }
}

fn lengths<const N: usize>(units: Units) -> [f64; N] {
    [units.of(1, 0, 0); N]
}

fn angles<const N: usize>(_: Units) -> [f64; N] {
    [1.0; N]
}

#[test]
fn one_unknown() {
    let make = |u: Units| Quartic {
        m: quartic().m * u.of(0, 0, 1),
        k: quartic().k * u.of(-2, -2, 1),
    };
    check(others(), make, lengths, State::new([0.8], [0.5]), 0.0);

    // aq² is an energy: the unit of q and p is the root of an action, a power of two here
    let make = |u: Units| Kubo {
        a: 1.3 * u.of(0, -1, 0),
        sigma: 0.6 / u.wiener(),
    };
    let root = |u: Units| [u.action().sqrt()];
    check(others(), make, root, State::new([0.8], [0.5]), 0.0);
}

#[test]
fn two_unknowns() {
    let make = |u: Units| Magnetic {
        m: magnetic().m * u.of(0, 0, 1),
        b: magnetic().b * u.of(0, -1, 1),
        c: magnetic().c * u.of(-2, 0, 0),
        k: magnetic().k * u.of(0, -2, 1),
    };
    check(
        others(),
        make,
        lengths,
        State::new([0.8, -0.3], [0.5, 0.2]),
        0.0,
    );

    let make = |u: Units| Relativistic {
        m: relativistic().m * u.of(0, 0, 1),
        c: relativistic().c * u.of(1, -1, 0),
        k: relativistic().k * u.of(0, -2, 1),
    };
    check(
        others(),
        make,
        lengths,
        State::new([0.8, -0.3], [0.5, 0.2]),
        0.0,
    );

    let make = |u: Units| SphericalPendulum {
        m: spherical_pendulum().m * u.of(0, 0, 1),
        l: spherical_pendulum().l * u.of(1, 0, 0),
        g: spherical_pendulum().g * u.of(1, -2, 0),
    };
    check(
        others(),
        make,
        angles,
        State::new([1.2, -0.3], [0.5, 0.6]),
        0.0,
    );

    let DoublePendulum { m, l, g, s } = double_pendulum();
    let make = |u: Units| DoublePendulum {
        m: m.map(|m| m * u.of(0, 0, 1)),
        l: l.map(|l| l * u.of(1, 0, 0)),
        g: g * u.of(1, -2, 0),
        s: s * u.noise(),
    };
    check(
        others(),
        make,
        angles,
        State::new([0.8, -0.3], [0.2, 0.4]),
        0.0,
    );
}

/// Six unknowns of one unit: the pivots are the same.
#[test]
fn six_unknowns() {
    let Chain { m, k, s } = chain();
    // the springs harden at a stretch of 1: lengths cannot change their unit
    let make = |u: Units| Chain {
        m: m.map(|m| m * u.of(0, 0, 1)),
        k: k * u.of(0, -2, 1),
        s: s * u.noise(),
    };
    let start = State::new(
        [0.1, -0.2, 0.3, 0.0, 0.2, -0.1],
        [0.3, 0.1, -0.5, 0.7, 0.2, -0.4],
    );
    let of_chains = others().filter(|u| u.length == 0);
    check(of_chains, make, angles, start, 0.0);
}

/// Three unknowns of different units (an increment of r, velocities of r and θ): other pivots, so
/// the same to rounding, which 200 steps of a regular motion multiply by less than 1e4.
#[test]
fn unknowns_of_different_units() {
    let Polar { m, k, sigma } = polar();
    let make = |u: Units| Polar {
        m: m * u.of(0, 0, 1),
        k: k * u.energy() * u.of(1, 0, 0),
        sigma: [
            sigma[0] * u.noise() * u.of(-1, 0, 0),
            sigma[1] * u.noise() / u.action().powi(2) * u.of(2, 0, 0),
        ],
    };
    let coordinates = |u: Units| [u.of(1, 0, 0), 1.0];
    check(
        others(),
        make,
        coordinates,
        State::new([1.4, 0.3], [0.1, 1.2]),
        1e-12,
    );
}
