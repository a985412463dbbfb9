//! Steps whose residuals cannot be smaller than the rounding errors of their terms: far from the origin, the force between neighbours
//! has a rounding error that does not decrease with the momenta. The step must succeed and be accurate to this rounding error.

use sve_models::oracle::{chain, rails};
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

/// Beads at the distances where the bonds are at rest: L = Σ ½v² − Σ (1 − exp(−(Δq − 1)))².
struct Morse;

#[variational(initial_point, endpoint, midpoint)]
impl Morse {
    fn lagrangian(&self, q: [f64; 6], v: [f64; 6]) -> f64 {
        let mut l = 0.0;
        for i in 0..6 {
            l += 0.5 * v[i] * v[i];
        }
        for i in 1..6 {
            l -= (1.0 - (1.0 + q[i - 1] - q[i]).exp()).powi(2);
        }
        l
    }

    #[gamma]
    fn shake(&self, q: [f64; 6]) -> f64 {
        (q[0] - q[1]).sin()
    }
}

/// The step of a chain that is kicked at one end, from rest at `offset + i · spacing`.
fn kicked<S, R, const N: usize>(
    integrator: &Integrator<S, R>,
    h: f64,
    place: (f64, f64),
) -> State<[f64; N]>
where
    S: Variational<R> + System<Dims = Dims<N, 1>>,
{
    let (offset, spacing) = place;
    let mut p = [0.0; N];
    p[0] = 1.0;
    let q = core::array::from_fn(|i| offset + spacing * i as f64);
    let mut state = State::new(q, p);
    integrator
        .step(&mut state, h, &[0.0])
        .unwrap_or_else(|error| panic!("h = {h}, offset {offset}: {error}"));
    state
}

/// L depends on differences only, so a step far from the origin is the translated step at the origin.
fn check<S, R, const N: usize>(integrator: &Integrator<S, R>, spacing: f64)
where
    S: Variational<R> + System<Dims = Dims<N, 1>>,
{
    for h in [0.1, 1e-2, 1e-3, 1e-5] {
        let near = kicked(integrator, h, (0.0, spacing));
        for offset in [0.1, -3.7, 1e3, 1e6] {
            let far = kicked(integrator, h, (offset, spacing));
            for i in 0..N {
                // coordinates are known to half a unit in the last place, forces to stiffnesses below 10 times that
                let rounding = 2.0 * f64::EPSILON * (offset.abs() + N as f64);
                let (dq, dp) = (far.q[i] - offset - near.q[i], far.p[i] - near.p[i]);
                assert!(
                    dq.abs() <= rounding * (1.0 + 10.0 * h)
                        && dp.abs() <= 20.0 * h * rounding + 8.0 * f64::EPSILON,
                    "h = {h}, offset {offset}, bead {i}: {dq:e}, {dp:e}"
                );
            }
        }
    }
}

#[test]
fn a_chain_that_is_kicked_far_from_the_origin() {
    check::<_, InitialPoint, 6>(&Integrator::new(chain(), InitialPoint), 0.0);
    check::<_, Endpoint, 6>(&Integrator::new(chain(), Endpoint), 0.0);
    check::<_, Midpoint, 6>(&Integrator::new(chain(), Midpoint), 0.0);
    check::<_, Midpoint, 8>(&Integrator::new(rails(), Midpoint), 0.0);
}

#[test]
fn bonds_at_rest() {
    check::<_, InitialPoint, 6>(&Integrator::new(Morse, InitialPoint), 1.0);
    check::<_, Endpoint, 6>(&Integrator::new(Morse, Endpoint), 1.0);
    check::<_, Midpoint, 6>(&Integrator::new(Morse, Midpoint), 1.0);
}
