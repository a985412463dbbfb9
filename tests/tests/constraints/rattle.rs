//! The rule of Störmer and Verlet with constraints is RATTLE (Andersen 1983), written here by hand.

use sve_models::checks::assert_close;
use sve_models::models::OnSphere;
use sve_runtime::prelude::*;

/// One step on the unit sphere. The multiplier of SHAKE solves a quadratic equation.
fn rattle(
    system: &OnSphere,
    q: Vector3<f64>,
    p: Vector3<f64>,
    h: f64,
    dw: [f64; 2],
) -> [Vector3<f64>; 2] {
    let kick = |q: Vector3<f64>| {
        let first = Vector3::new(system.s * q.x.cos(), 0.0, 0.0) * dw[0];
        let second = Vector3::new(0.0, system.s * q.z, system.s * q.y) * dw[1];
        0.5 * (h * Vector3::new(0.0, 0.0, -system.g) + first + second)
    };
    let free = p + kick(q);
    // |q + h (free + λ q)|² = 1
    let moved = q + h * free;
    let (a, b, c) = (
        h * h * q.norm_squared(),
        h * moved.dot(&q),
        moved.norm_squared() - 1.0,
    );
    let lambda = -c / (b + (b * b - a * c).sqrt());
    let half = free + lambda * q;
    let end = q + h * half;
    let p = half + kick(end);
    [end, p - end * (end.dot(&p) / end.norm_squared())]
}

#[test]
fn stormer_verlet_is_rattle() {
    let system = OnSphere { g: 1.3, s: 0.7 };
    let integrator = Integrator::new(&system, StormerVerlet);
    let mut state = State::new([0.6, 0.0, -0.8], [0.288, 0.9, 0.216]);
    let noise = Recorded::record(Wiener::new(5), 0.05, 2, 200).unwrap();
    for k in 0..200 {
        let dw: [f64; 2] = noise.get(k).unwrap().try_into().unwrap();
        let [q, p] = [state.q, state.p].map(Vector3::from);
        let [q, p] = rattle(&system, q, p, 0.05, dw);
        integrator.step(&mut state, 0.05, &dw).unwrap();
        // the velocity of a step has the rounding errors of the positions divided by h
        assert_close(&state.q, q.as_slice(), 2e-15, k);
        assert_close(&state.p, p.as_slice(), 2e-14, k);
    }
}
