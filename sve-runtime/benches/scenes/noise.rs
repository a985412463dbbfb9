//! A chain with a process at each site, beside a fill of the increments and a step by hand.

use std::hint::black_box;

use sve_runtime::noise::Noise;
use sve_runtime::prelude::*;

use super::hand::{Kernel, TILE, bond, dispatch, drift};
use super::measure::{Case, compare};
use super::{H, steps};

struct Noisy {
    beta: f64,
    sigma: f64,
}

#[variational(endpoint, stormer_verlet)]
impl Noisy {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for v in v {
            l += 0.5 * v * v;
        }
        for i in 1..q.len() {
            let d = q[i] - q[i - 1];
            l -= 0.5 * d * d + 0.25 * self.beta * d.powi(4);
        }
        l
    }

    #[gamma]
    fn bath(&self, q: &[f64]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * q).collect()
    }
}

const NOISY: Noisy = Noisy {
    beta: 0.7,
    sigma: 0.01,
};

/// A drift, and a kick with the sum of the increments of `KICKS` parts of steps.
struct Step<'a, const KICKS: usize> {
    q: &'a mut [f64],
    p: &'a mut [f64],
    dw: [&'a [f64]; KICKS],
    sigma: f64,
}

#[inline(always)]
fn kick<const KICKS: usize>(q: &[f64], p: &mut [f64], dw: [&[f64]; KICKS], sigma: f64) {
    let m = p.len();
    let (a, b, c) = (&q[..m], &q[1..=m], &q[2..m + 2]);
    let dw = dw.map(|dw| &dw[..m]);
    for i in 0..m {
        let mut noise = 0.0;
        for dw in dw {
            noise += dw[i];
        }
        let force = bond(NOISY.beta, c[i] - b[i]) - bond(NOISY.beta, b[i] - a[i]);
        p[i] += H * force + sigma * noise;
    }
}

impl<const KICKS: usize> Kernel for Step<'_, KICKS> {
    #[inline(always)]
    fn run(self) {
        let Self { q, p, dw, sigma } = self;
        let n = q.len();
        let mut done = 1;
        for from in (0..n).step_by(TILE) {
            let to = (from + TILE).min(n);
            drift(&mut q[from..to], &p[from..to], H);
            let inner = done..to - 1;
            let dw = dw.map(|dw| &dw[inner.clone()]);
            kick(&q[done - 1..to], &mut p[inner], dw, sigma);
            done = to - 1;
        }
        let noise = |i: usize| sigma * dw.iter().map(|dw| dw[i]).sum::<f64>();
        p[0] += H * bond(NOISY.beta, q[1] - q[0]) + noise(0);
        p[n - 1] -= H * bond(NOISY.beta, q[n - 1] - q[n - 2]) - noise(n - 1);
    }
}

/// Steps by hand, of the endpoint rule, or of that of Störmer and Verlet with momenta in the middle
/// of steps.
struct Hand {
    q: Vec<f64>,
    p: Vec<f64>,
    dw: [Vec<f64>; 2],
    noise: Wiener,
    step: u64,
}

impl Hand {
    fn new(q: &[f64]) -> Self {
        let zeros = || vec![0.0; q.len()];
        let (q, p, dw) = (q.to_vec(), zeros(), [zeros(), zeros()]);
        let (noise, step) = (Wiener::new(1), 0);
        Self {
            q,
            p,
            dw,
            noise,
            step,
        }
    }

    fn fill(&mut self) {
        let filled = self
            .noise
            .increments(self.step, H, black_box(&mut self.dw[0]));
        assert_eq!(filled, Ok(()));
        self.step += 1;
    }

    fn endpoint(&mut self) {
        self.fill();
        let Self { q, p, dw, .. } = self;
        let (dw, sigma) = ([&*dw[0]], NOISY.sigma);
        dispatch(Step { q, p, dw, sigma });
    }

    fn verlet(&mut self) {
        self.dw.swap(0, 1);
        self.fill();
        let Self { q, p, dw, .. } = self;
        let (dw, sigma) = ([&*dw[0], &dw[1]], 0.5 * NOISY.sigma);
        dispatch(Step { q, p, dw, sigma });
    }
}

pub(crate) fn chain(n: usize, is_asked: &dyn Fn(&str) -> bool) {
    let start: Vec<f64> = (0..n).map(|i| 0.3 * (0.01 * i as f64).sin()).collect();
    let (count, units) = (steps(n), steps(n) as f64 * n as f64);
    let state = State::new(start.clone(), vec![0.0; n]);
    let endpoint = Integrator::new(NOISY, Endpoint);
    let verlet = Integrator::new(NOISY, StormerVerlet);
    check(&endpoint, &state);
    let mut paths = (
        endpoint.trajectory(state.clone(), H, Wiener::new(1)),
        verlet.trajectory(state, H, Wiener::new(1)),
    );
    let hand: [fn(&mut Hand); 3] = [Hand::endpoint, Hand::verlet, Hand::fill];
    let mut hand = hand.map(|step| {
        let mut hand = Hand::new(&start);
        move || (0..count).for_each(|_| step(&mut hand))
    });
    let [by_endpoint, by_verlet, fill] = &mut hand;
    let group = |rule: &str, cases: Vec<Case<'_>>| {
        compare(&format!("noisy chain of {n}, {rule}"), is_asked, cases);
    };
    group(
        "endpoint",
        vec![
            ("fill and step by hand", units, Box::new(by_endpoint)),
            ("fill alone", units, Box::new(fill)),
            (
                "trajectory",
                units,
                Box::new(|| assert!(paths.0.advance(count).is_ok())),
            ),
        ],
    );
    group(
        "Störmer–Verlet",
        vec![
            ("fill and step by hand", units, Box::new(by_verlet)),
            (
                "trajectory",
                units,
                Box::new(|| assert!(paths.1.advance(count).is_ok())),
            ),
        ],
    );
}

/// Checks that both make the same steps.
fn check(endpoint: &Integrator<Noisy, Endpoint>, start: &State<Vec<f64>>) {
    let mut hand = Hand::new(&start.q);
    (0..3).for_each(|_| hand.endpoint());
    let mut path = endpoint.trajectory(start.clone(), H, Wiener::new(1));
    let end = path.advance(3).expect("finite numbers");
    for (x, y) in end.q.iter().chain(&end.p).zip(hand.q.iter().chain(&hand.p)) {
        assert!((x - y).abs() < 1e-14, "{x} {y}");
    }
}
