//! Paths of degenerate systems: exact motions, energies over many steps, ensembles, compositions;
//! and steps that are wrong.

use sve_models::degenerate::wrong::{self, Plain};
use sve_models::degenerate::{
    CubicLotkaVolterra, Drift, InternalLotkaVolterra, Joint, Kubo, LotkaVolterra, MassWithPair,
    Spin, VortexPair, Vortices,
};
use sve_runtime::__private::VectorCoordinates;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// The three rules on the same noise stay near the exact rotation, and the midpoint rule keeps the
/// energy.
#[test]
fn a_rotation_is_followed() {
    let start = State::from_configuration(&Kubo, [1.0, 0.5]).unwrap();
    let steps = 2000;
    let noise = Recorded::record(Wiener::new(3), 1e-3, 1, steps).unwrap();
    let w: f64 = (0..steps).map(|k| noise.get(k).unwrap()[0]).sum();
    let (s, c) = (2.0 + 0.5 * w).sin_cos();
    let exact = [c - 0.5 * s, s + 0.5 * c];
    let off = |end: State<[f64; 2]>| (end.q[0] - exact[0]).hypot(end.q[1] - exact[1]);
    let middle = Integrator::new(Kubo, Midpoint);
    let end = middle
        .trajectory(start, 1e-3, &noise)
        .last()
        .unwrap()
        .unwrap();
    let energy = Kubo.hamiltonian(&start).unwrap();
    assert!((Kubo.hamiltonian(&end).unwrap() - energy).abs() < 1e-14);
    assert!(off(end) < 5e-4, "{}", off(end));
    let first = Integrator::new(Kubo, InitialPoint);
    let last = Integrator::new(Kubo, Endpoint);
    let end = first
        .trajectory(start, 1e-3, &noise)
        .last()
        .unwrap()
        .unwrap();
    assert!(off(end) < 2e-2, "{}", off(end));
    let end = last
        .trajectory(start, 1e-3, &noise)
        .last()
        .unwrap()
        .unwrap();
    assert!(off(end) < 2e-2, "{}", off(end));
}

/// Two vortices turn about their centre by (Γ₁ + Γ₂)/d² (t + σW); distance, centre and momentum map
/// stay.
#[test]
fn two_vortices_turn() {
    let pair = VortexPair {
        strength: [1.0, 2.0],
        sigma: 0.3,
    };
    let start = State::from_configuration(&pair, [[1.0, 0.0], [-0.5, 0.0]]).unwrap();
    let integrator = Integrator::new(pair, Midpoint);
    let (h, steps) = (1e-3, 4000);
    let noise = Recorded::record(Wiener::new(5), h, 1, steps).unwrap();
    let w: f64 = (0..steps).map(|k| noise.get(k).unwrap()[0]).sum();
    let end = integrator
        .trajectory(start, h, &noise)
        .last()
        .unwrap()
        .unwrap();
    let (s, c) = (3.0 / 2.25 * (4.0 + 0.3 * w)).sin_cos();
    let exact = [[c, s], [-0.5 * c, -0.5 * s]];
    for i in 0..2 {
        for k in 0..2 {
            assert!(
                (end.q[i][k] - exact[i][k]).abs() < 2e-3,
                "{:?} {exact:?}",
                end.q
            );
            let moment = |q: [[f64; 2]; 2]| 1.0 * q[0][k] + 2.0 * q[1][k];
            assert!((moment(end.q) - moment(start.q)).abs() < 1e-12);
        }
    }
    let turned = |state: &State<[[f64; 2]; 2]>| pair.turn_momentum(state);
    assert!((turned(&end) - turned(&start)).abs() < 1e-12);
    assert_eq!(integrator.plan().conserved, ["turn_momentum"]);
}

/// Largest deviation of the energy in each of two halves of a path without noise.
fn energy_errors<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<Q>,
    h: f64,
    steps: usize,
) -> [f64; 2]
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let system = integrator.system();
    let energy = system.hamiltonian(&start).unwrap();
    let mut worst = [0.0f64; 2];
    let path = integrator.trajectory(start, h, NoNoise).take(steps);
    for (at, state) in path.enumerate() {
        let off = (system.hamiltonian(&state.unwrap()).unwrap() - energy).abs();
        let half = &mut worst[2 * at / steps];
        *half = half.max(off);
    }
    worst
}

#[test]
fn energies_do_not_drift() {
    let mut wrong = Vec::new();
    let mut check = |name: &str, [first, second]: [f64; 2], bound: f64| {
        println!("{name}: {first:e} {second:e}");
        if first > bound || second > 1.02 * first + 1e-12 {
            wrong.push(format!("{name}: {first:e} {second:e}"));
        }
    };
    let steps = 100_000;
    let lv = State::from_configuration(&LotkaVolterra, [1.5, 0.8]).unwrap();
    let internal = State::from_configuration(&InternalLotkaVolterra, [1.5, 0.8]).unwrap();
    let integrator = Integrator::new(LotkaVolterra, Midpoint);
    check("LV", energy_errors(&integrator, lv, 0.1, steps), 2e-2);
    let integrator = Integrator::new(InternalLotkaVolterra, Endpoint);
    check(
        "LV, endpoint",
        energy_errors(&integrator, internal, 0.05, steps),
        0.21,
    );
    let spin = State::from_configuration(&Spin, [0.3, 0.4]).unwrap();
    let integrator = Integrator::new(Spin, Midpoint);
    check("spin", energy_errors(&integrator, spin, 0.1, steps), 1e-3);
    let drift = State::from_configuration(&Drift, [0.6, 0.5]).unwrap();
    let integrator = Integrator::new(Drift, Midpoint);
    check("drift", energy_errors(&integrator, drift, 0.1, steps), 1e-3);
    let mass = MassWithPair { mass: 1.5 };
    let mut start = State::from_configuration(&mass, [0.5, 0.3, -0.4]).unwrap();
    start.p[0] += 0.3;
    let integrator = Integrator::new(mass, Midpoint);
    check(
        "mass with a pair",
        energy_errors(&integrator, start, 0.05, steps),
        3e-3,
    );
    let vortices = Vortices {
        strength: [1.0, 1.0, 1.0, 1.0],
    };
    let corners = [[0.0, 1.0], [1.1, 0.2], [-0.9, -0.3], [0.2, -1.2]];
    let start = State::from_configuration(&vortices, corners).unwrap();
    let integrator = Integrator::new(vortices, Midpoint);
    check(
        "vortices",
        energy_errors(&integrator, start, 0.05, steps),
        1e-4,
    );
    let joint = Joint { k: 3.0 };
    let start = State::from_configuration(&joint, [1.0, 0.0]).unwrap();
    let integrator = Integrator::new(joint, Midpoint);
    check("joint", energy_errors(&integrator, start, 0.1, steps), 1e-2);
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// The cubic gauge is the known limit: the same motion, whose energy drifts.
#[test]
fn the_gauge_matters_for_projected_steps() {
    let start = State::from_configuration(&CubicLotkaVolterra, [1.5, 0.8]).unwrap();
    let integrator = Integrator::new(CubicLotkaVolterra, Midpoint);
    let [_, short] = energy_errors(&integrator, start, 0.1, 70);
    let [_, long] = energy_errors(&integrator, start, 0.1, 100_000);
    println!("cubic gauge: {short:e} {long:e}");
    assert!(long > 5.0 * short && long > 0.3, "{short:e} {long:e}");
}

/// The plain discrete Euler–Lagrange equations leave p = α(q); projecting after the step gives
/// another equation.
#[test]
fn wrong_steps_are_noticed() {
    let start = State::from_configuration(&LotkaVolterra, [1.5, 0.8]).unwrap();
    let energy = LotkaVolterra.hamiltonian(&start).unwrap();
    for (what, steps, least) in [(Plain::Projected, 2000, 0.05), (Plain::Free, 20_000, 0.0)] {
        let (mut q, mut p) = (start.q, start.p);
        let (mut off, mut apart) = (0.0f64, 0.0f64);
        for _ in 0..steps {
            let (next, momentum) = wrong::step(&LotkaVolterra, what, (q, p), 0.05, &[0.0]);
            (q, p) = (next, momentum);
            if !(q[0] > 0.0 && q[1] > 0.0) {
                off = f64::INFINITY;
                break;
            }
            let here = State::from_configuration(&LotkaVolterra, q).unwrap();
            off = off.max((LotkaVolterra.hamiltonian(&here).unwrap() - energy).abs());
            apart = apart.max((here.p[0] - p[0]).abs());
        }
        println!("{what:?}: energy {off:e}, |p − α| {apart:e}");
        assert!(off > least);
        if what == Plain::Free {
            assert!(apart > 1e-4, "{apart:e}");
        }
    }
}

/// Ensembles step lanes; each path is that of the scalar step to rounding.
#[test]
fn paths_of_ensembles_are_single_paths() {
    fn check<S, R, Q, const N: usize, const M: usize>(system: S, rule: R, q: Q)
    where
        S: Variational<R> + System<Dims = Dims<N, M, Q>> + Sync,
        R: Sync,
        Q: VectorCoordinates<N>,
        Q::Momentum: Send + Sync,
    {
        let (h, steps) = (0.05, 40);
        let integrator = Integrator::new(system, rule);
        let start = State::from_configuration(integrator.system(), q).unwrap();
        let ensemble = Ensemble::new(&integrator)
            .paths(70)
            .steps(h, steps)
            .start(start);
        let ensemble = ensemble.seed(8).keep_final_states(true);
        let summary = ensemble.run().unwrap();
        assert_eq!(summary.final_states().count(), 70);
        for (path, end) in summary.final_states() {
            let noise = Wiener::new(8).path(path);
            let single = integrator
                .trajectory(start, h, noise)
                .take(steps as usize)
                .last();
            let single = single.unwrap().unwrap().q.coordinates();
            for (a, b) in end.q.iter().zip(single) {
                let name = integrator.plan().system;
                assert!(
                    (a - b).abs() < 1e-11,
                    "{name} {path}: {:?} {single:?}",
                    end.q
                );
            }
        }
    }
    check(Kubo, Midpoint, [1.0, 0.5]);
    check(Kubo, Endpoint, [1.0, 0.5]);
    check(LotkaVolterra, Midpoint, [1.5, 0.8]);
    check(Spin, Midpoint, [0.3, 0.4]);
    check(Drift, Midpoint, [0.6, 0.5]);
    check(Joint { k: 2.0 }, Midpoint, [0.5, 0.2]);
    check(Joint { k: 2.0 }, Endpoint, [0.5, 0.2]);
    check(MassWithPair { mass: 1.5 }, Midpoint, [0.5, 0.3, -0.4]);
    let corners = [[0.0, 1.0], [1.1, 0.2], [-0.9, -0.3], [0.2, -1.2]];
    let vortices = Vortices {
        strength: [1.0, 0.8, 1.1, 0.9],
    };
    check(vortices, Midpoint, corners);
}

/// Compositions of the midpoint rule are rules of degenerate systems too.
#[test]
fn compositions_have_a_higher_order() {
    let start = State::from_configuration(&Drift, [0.6, 0.5]).unwrap();
    let composed = Integrator::new(Drift, Composed::new(Midpoint, KahanLi8));
    let run = |steps: usize| {
        let path = composed.trajectory(start, 2.0 / steps as f64, NoNoise);
        path.take(steps).last().unwrap().unwrap().q
    };
    let reference = run(256);
    let error = |steps: usize| {
        let q = run(steps);
        (q[0] - reference[0]).hypot(q[1] - reference[1])
    };
    let (coarse, fine) = (error(4), error(8));
    println!("{coarse:e} {fine:e}");
    assert!((coarse / fine).log2() > 7.0, "{coarse:e} {fine:e}");
}

/// Derivatives of steps against differences: massless momenta follow the configuration.
#[test]
fn derivatives_of_steps_are_differences() {
    let system = MassWithPair { mass: 1.5 };
    let integrator = Integrator::new(system, Midpoint);
    let dw = [0.1, -0.2];
    let start = |q: [f64; 3], kick: f64| {
        let mut state = State::from_configuration(&system, q).unwrap();
        let rest = state.p[0];
        state.p[0] = 0.3 * q[1] + kick;
        assert!((rest - 0.3 * q[1]).abs() < 1e-15);
        state
    };
    let q = [0.5, 0.3, -0.4];
    let (tangent, sensitivity) = integrator
        .step_with_derivatives(&mut start(q, 0.7), 0.1, &dw)
        .unwrap();
    let end = |q, kick, system: MassWithPair| {
        let mut state = start(q, kick);
        Integrator::new(system, Midpoint)
            .step(&mut state, 0.1, &dw)
            .unwrap();
        state
    };
    let e = 1e-6;
    for k in 0..3 {
        let moved = |sign: f64| {
            let mut q = q;
            q[k] += sign * e;
            // the momentum of the mass stays
            end(q, 0.7 + 0.3 * (0.3 - q[1]), system)
        };
        let (a, b) = (moved(1.0), moved(-1.0));
        for i in 0..3 {
            assert!(((a.q[i] - b.q[i]) / (2.0 * e) - tangent[i][k]).abs() < 1e-8);
            assert!(((a.p[i] - b.p[i]) / (2.0 * e) - tangent[3 + i][k]).abs() < 1e-8);
        }
    }
    let (a, b) = (end(q, 0.7 + e, system), end(q, 0.7 - e, system));
    let mass = |m: f64| end(q, 0.7, MassWithPair { mass: m });
    let (heavy, light) = (mass(1.5 + e), mass(1.5 - e));
    let by_mass = sensitivity.get("mass").unwrap();
    for i in 0..3 {
        assert!(((a.q[i] - b.q[i]) / (2.0 * e) - tangent[i][3]).abs() < 1e-8);
        assert!(((heavy.q[i] - light.q[i]) / (2.0 * e) - by_mass.q[i]).abs() < 1e-8);
        assert!(((heavy.p[i] - light.p[i]) / (2.0 * e) - by_mass.p[i]).abs() < 1e-8);
        // massless momenta are no variables of their own
        for column in [4, 5] {
            assert_eq!((tangent[i][column], tangent[3 + i][column]), (0.0, 0.0));
        }
    }
}

/// Compensated sums keep p = α(q), and the energy error of a long path.
#[test]
fn compensated_trajectories_stay_consistent() {
    for h in [0.1, -0.1] {
        let start = State::from_configuration(&Drift, [0.6, 0.5]).unwrap();
        let integrator = Integrator::new(Drift, Midpoint);
        let energy = Drift.hamiltonian(&start).unwrap();
        let path = integrator.trajectory(start, h, NoNoise).compensated();
        for state in path.take(20_000) {
            let state = state.unwrap();
            let expected = State::from_configuration(&Drift, state.q).unwrap();
            for i in 0..2 {
                assert!((state.p[i] - expected.p[i]).abs() < 1e-15);
            }
            assert!((Drift.hamiltonian(&state).unwrap() - energy).abs() < 5e-5);
        }
    }
}

/// A step backwards undoes a step: the rule and its projection are symmetric.
#[test]
fn projected_steps_are_symmetric() {
    let mass = MassWithPair { mass: 1.5 };
    let mut start = State::from_configuration(&mass, [0.5, 0.3, -0.4]).unwrap();
    start.p[0] += 0.7;
    let integrator = Integrator::new(mass, Midpoint);
    let mut state = start;
    integrator.step(&mut state, 0.1, &[0.2, -0.1]).unwrap();
    assert!((state.q[1] - start.q[1]).abs() > 1e-3);
    integrator.step(&mut state, -0.1, &[-0.2, 0.1]).unwrap();
    for i in 0..3 {
        assert!((state.q[i] - start.q[i]).abs() < 1e-14);
        assert!((state.p[i] - start.p[i]).abs() < 1e-14);
    }
}
