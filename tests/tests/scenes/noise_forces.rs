//! Forces of places that are noise: the steps of unrolled systems, plans, and momenta.

use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;

use crate::common::{assert_same, spread};

/// Seven sites in a flow that pushes each by its neighbour, with noises of every kind.
mod flow {
    use sve_runtime::prelude::*;
    both! {
        struct { s: [f64; 3] }
        [f64] 7
        |self, q, v| {
            let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
            for i in 1..q.len() {
                l -= 0.5 * (q[i] - q[i - 1]).powi(2);
            }
            l
        }
        #[force(noise)]
        each stir(&self, q, _v; t) -> f64 |i| { self.s[0] * (q[(i + 1) % q.len()] + t.sin()) }
        #[gamma]
        each bath(&self, q) -> f64 |i| { self.s[1] * q[i] }
        #[gamma]
        fn shake(&self, q) -> f64 { q.iter().map(|q| self.s[2] * q.cos()).sum() }
        #[force(noise)]
        each push(&self, q, _v) -> f64 |i| { 0.3 + 0.1 * q[i] * q[i] }
        #[force]
        each drag(&self, q, v) -> f64 |i| { -0.2 * v[i] }
    }
}

#[test]
fn noise_forces_of_scenes_are_those_of_unrolled_systems() {
    let row = |seed| -> [f64; 7] { spread(7, seed).try_into().expect("seven") };
    let s = [0.4, 0.3, 0.5];
    let (q, p) = (row(1), row(2));
    // the listed processes: shake, stir, push; then one for each site
    let (listed, sites) = ([0.11, -0.07, 0.13], row(3).map(|x| 0.1 * x));
    let of_scene = [&listed[..], &sites].concat();
    let mut unrolled = [0.0; 10];
    unrolled[0] = listed[0];
    unrolled[1..8].copy_from_slice(&sites);
    unrolled[8..].copy_from_slice(&listed[1..]);
    macro_rules! check {
        ($($rule:expr),*) => {$(
            let flow = Integrator::new(flow::scene::System { s }, $rule);
            let mut state = State::at(0.3, q.to_vec(), p.to_vec());
            let expected = Integrator::new(flow::unrolled::System { s }, $rule);
            let mut other = State::at(0.3, q, p);
            for _ in 0..3 {
                flow.step(&mut state, 0.05, &of_scene).unwrap();
                expected.step(&mut other, 0.05, &unrolled).unwrap();
            }
            assert_same(&state, &other.q, &other.p, flow.plan().rule);
            assert_eq!(flow.plan().strong_order, StrongOrder::One);
            assert_eq!(flow.plan().weak_order, 1);
        )*};
    }
    check!(Endpoint, InitialPoint, Midpoint, StormerVerlet);
    let plan = Integrator::new(flow::scene::System { s }, Midpoint)
        .plan()
        .to_string();
    for text in ["Σ f ∘ dW", "Σ f(q̄)·δq̄ ΔW", "f, of a process, stir"] {
        assert!(plan.contains(text), "{text}: {plan}");
    }
    let plan = Integrator::new(flow::scene::System { s }, StormerVerlet)
        .plan()
        .to_string();
    assert!(
        plan.contains("½ Σ f(q₀)·δq₀ ΔW + ½ Σ f(q₁)·δq₁ ΔW"),
        "{plan}"
    );
}

/// Pairs that noise pushes apart: the sum of the momenta is kept.
struct Pairs;

#[variational(stormer_verlet)]
impl Pairs {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for i in 1..q.len() {
            l -= 0.25 * (q[i] - q[i - 1]).powi(4);
        }
        l
    }
    #[force(noise)]
    fn apart(&self, q: &[f64], _v: &[f64]) -> Vec<f64> {
        (0..q.len())
            .map(|i| {
                let mut f = 0.0;
                if i > 0 {
                    f += (q[i] - q[i - 1]).sin();
                }
                if i + 1 < q.len() {
                    f += (q[i] - q[i + 1]).sin();
                }
                f
            })
            .collect()
    }
}

#[test]
fn a_noise_of_pairs_keeps_the_sum_of_the_momenta() {
    let pairs = Integrator::new(Pairs, StormerVerlet);
    let start = State::new(spread(50, 1), spread(50, 2));
    let before: f64 = start.p.iter().sum();
    let mut path = pairs.trajectory(start, 0.05, Wiener::new(3));
    let after: f64 = path.advance(200).unwrap().p.iter().sum();
    assert!((after - before).abs() < 1e-12, "{after} {before}");
}
