//! Quantities that steps of scenes conserve, and their order with noise.

use sve_runtime::prelude::*;

use crate::common::spread;

struct Fput {
    beta: f64,
    sigma: f64,
}

#[variational(endpoint, midpoint, stormer_verlet)]
impl Fput {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for i in 0..n {
            let d = q[(i + 1) % n] - q[i];
            l -= 0.5 * d * d + 0.25 * self.beta * d.powi(4);
        }
        l
    }

    #[gamma]
    fn bath(&self, q: &[f64]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * q.sin()).collect()
    }
}

/// The same without noise.
struct Quiet {
    beta: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Quiet {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for i in 0..n {
            let d = q[(i + 1) % n] - q[i];
            l -= 0.5 * d * d + 0.25 * self.beta * d.powi(4);
        }
        l
    }
}

/// The energy oscillates by O(h²) and does not drift over 10⁵ steps, and the total momentum stays.
#[test]
fn energy_of_a_ring_has_no_drift() {
    let system = Quiet { beta: 0.5 };
    let energy = |state: &State<Vec<f64>>| {
        // at rest L is −V
        let kinetic: f64 = state.p.iter().map(|p| 0.5 * p * p).sum();
        kinetic - system.lagrangian(&state.q, &vec![0.0; state.q.len()])
    };
    check_energy(&system, StormerVerlet, energy);
    check_energy(&system, Midpoint, energy);
}

fn check_energy<R>(system: &Quiet, rule: R, energy: impl Fn(&State<Vec<f64>>) -> f64)
where
    R: sve_runtime::Rule<Quiet, Increments = [f64]>,
{
    let integrator = Integrator::new(system, rule);
    let mut state = State::new(spread(32, 1), spread(32, 2));
    let (start, momentum) = (energy(&state), state.p.iter().sum::<f64>());
    let mut worst: [f64; 2] = [0.0; 2];
    for step in 0..100_000 {
        integrator.step(&mut state, 0.05, &[]).expect("a step");
        let half = usize::from(step >= 50_000);
        worst[half] = worst[half].max((energy(&state) / start - 1.0).abs());
    }
    assert!(worst[0] < 2e-3, "{worst:?}");
    // the motion is chaotic, so that the largest values of two halves differ by up to a quarter for
    // other starts; with a drift the second one would be twice the first one
    assert!(worst[1] < 1.5 * worst[0], "{worst:?}");
    let after = state.p.iter().sum::<f64>();
    assert!((after - momentum).abs() < 1e-10, "{after} {momentum}");
}

/// The Jacobian M of a noisy step satisfies Mᵀ J M = J.
#[test]
fn noisy_steps_are_symplectic() {
    const N: usize = 4;
    let system = Fput {
        beta: 0.5,
        sigma: 0.8,
    };
    check_form::<N, _>(&Integrator::new(&system, StormerVerlet));
    check_form::<N, _>(&Integrator::new(&system, Midpoint));
}

fn check_form<const N: usize, R>(integrator: &Integrator<&Fput, R>)
where
    R: sve_runtime::Rule<Fput, Increments = [f64]>,
{
    let (start, dw) = (spread(2 * N, 5), spread(N, 6));
    let step = |x: &[f64]| {
        let mut state = State::new(x[..N].to_vec(), x[N..].to_vec());
        integrator.step(&mut state, 0.3, &dw).expect("a step");
        [state.q, state.p].concat()
    };
    let column = |at: usize| {
        let moved = |by: f64| {
            let mut x = start.clone();
            x[at] += by;
            step(&x)
        };
        let h = 1e-3;
        let [a, b, c, d] = [moved(h), moved(-h), moved(2.0 * h), moved(-2.0 * h)];
        let entry = |i: usize| (8.0 * (a[i] - b[i]) - (c[i] - d[i])) / (12.0 * h);
        (0..2 * N).map(entry).collect::<Vec<f64>>()
    };
    let columns: Vec<Vec<f64>> = (0..2 * N).map(column).collect();
    for i in 0..2 * N {
        for j in 0..2 * N {
            let (a, b) = (&columns[i], &columns[j]);
            let form: f64 = (0..N).map(|k| a[k] * b[N + k] - a[N + k] * b[k]).sum();
            let expected = f64::from(u8::from(j == i + N)) - f64::from(u8::from(i == j + N));
            assert!((form - expected).abs() < 1e-9, "{i} {j}: {form}");
        }
    }
}

/// With one path of each site, the error of the endpoint rule is proportional to h: halving h three
/// times divides it by about 8.
#[test]
fn strong_order_with_a_process_a_site_is_one() {
    const N: usize = 16;
    let system = Fput {
        beta: 0.5,
        sigma: 0.5,
    };
    let integrator = Integrator::new(&system, Endpoint);
    let (q, p) = (spread(N, 1), spread(N, 2));
    let finest: u32 = 1 << 10;
    let end = |increments: &[Vec<f64>], merged: usize| {
        let mut state = State::new(q.clone(), p.clone());
        for part in increments.chunks(merged) {
            let dw: Vec<f64> = (0..N).map(|i| part.iter().map(|dw| dw[i]).sum()).collect();
            let h = merged as f64 / f64::from(finest);
            integrator.step(&mut state, h, &dw).expect("a step");
        }
        [state.q, state.p].concat()
    };
    let mut errors = [0.0; 2];
    for path in 0..40 {
        // sums of twelve numbers are near enough to normal
        let scale = (1.0 / f64::from(finest)).sqrt() / 2.0;
        let normal = |seed: u64| {
            let uniform = spread(12 * N, 1000 * path + seed + 17);
            let sums = uniform.chunks(12).map(|x| scale * x.iter().sum::<f64>());
            sums.collect::<Vec<f64>>()
        };
        let increments: Vec<Vec<f64>> = (0..u64::from(finest)).map(normal).collect();
        let exact = end(&increments, 1);
        for (error, merged) in errors.iter_mut().zip([128, 16]) {
            let found = end(&increments, merged);
            let square: f64 = found.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum();
            *error += square;
        }
    }
    let order = (errors[0] / errors[1]).sqrt().log2() / 3.0;
    assert!((0.9..1.25).contains(&order), "{order}");
}
