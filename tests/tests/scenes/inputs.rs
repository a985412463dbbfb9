//! Inputs of scenes: the paths of unrolled systems with the same inputs.

use sve_runtime::prelude::*;

use crate::common::{assert_same, spread};

/// Seven sites on springs. The inputs set the stiffness, a wind, and the strengths of a noise and
/// of a noise force; a friction that reads one is a force as any other.
struct Chain {
    s: f64,
}

#[variational(endpoint, initial_point, midpoint, stormer_verlet)]
impl Chain {
    fn lagrangian(&self, q: &[f64], v: &[f64], u: [f64; 2]) -> f64 {
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for i in 1..q.len() {
            l -= 0.5 * (1.0 + u[1] * u[1]) * (q[i] - q[i - 1]).powi(2);
        }
        for i in 0..q.len() {
            l += u[0] * q[i].sin();
        }
        l
    }
    #[force]
    fn brake(&self, _q: &[f64], v: &[f64], u: [f64; 2]) -> Vec<f64> {
        v.iter().map(|v| -0.2 * u[1] * u[1] * v).collect()
    }
    #[gamma]
    fn bath(&self, q: &[f64], u: [f64; 2]) -> Vec<f64> {
        q.iter().map(|q| self.s * (1.0 + u[0]) * q).collect()
    }
    #[force(noise)]
    fn gusts(&self, q: &[f64], _v: &[f64], u: [f64; 2]) -> Vec<f64> {
        q.iter().map(|q| self.s * u[1] * q.cos()).collect()
    }
}

/// The same, unrolled.
struct Unrolled {
    s: f64,
}

#[sve_comparison::stepped(endpoint, initial_point, midpoint, stormer_verlet)]
impl Unrolled {
    fn lagrangian(&self, q: [f64; 7], v: [f64; 7], u: [f64; 2]) -> f64 {
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for i in 1..7 {
            l -= 0.5 * (1.0 + u[1] * u[1]) * (q[i] - q[i - 1]).powi(2);
        }
        for i in 0..7 {
            l += u[0] * q[i].sin();
        }
        l
    }
    #[force]
    fn brake(&self, _q: [f64; 7], v: [f64; 7], u: [f64; 2]) -> [f64; 7] {
        v.map(|v| -0.2 * u[1] * u[1] * v)
    }
    #[gamma]
    fn bath(&self, q: [f64; 7], u: [f64; 2]) -> [f64; 7] {
        q.map(|q| self.s * (1.0 + u[0]) * q)
    }
    #[force(noise)]
    fn gusts(&self, q: [f64; 7], _v: [f64; 7], u: [f64; 2]) -> [f64; 7] {
        q.map(|q| self.s * u[1] * q.cos())
    }
}

/// A feedback, and a switch.
fn inputs(step: u64, q: &[f64]) -> [f64; 2] {
    [
        0.4 * q[0] - 0.1,
        if step.is_multiple_of(3) { 0.8 } else { -0.3 },
    ]
}

#[test]
fn paths_of_scenes_with_inputs_are_those_of_unrolled_systems() {
    let row = |seed| -> [f64; 7] { spread(7, seed).try_into().expect("seven") };
    let (s, q, p) = (0.3, row(1), row(2));
    // the process of the noise force is before those of the sites in a scene
    let increments = |k: u64| -> [f64; 8] { std::array::from_fn(|j| 0.1 * spread(8, k + 9)[j]) };
    macro_rules! check {
        ($($rule:expr),*) => {$(
            let chain = Integrator::new(Chain { s }, $rule);
            let unrolled = Integrator::new(Unrolled { s }, $rule);
            let (mut one, mut other) = (State::at(0.3, q.to_vec(), p.to_vec()), State::at(0.3, q, p));
            let mut all = Vec::new();
            for k in 0..6 {
                let dw = increments(k);
                let mut turned = dw;
                turned.rotate_left(1);
                let u = inputs(k, &other.q);
                chain.step_with(&mut one, 0.05, &dw, &u).unwrap();
                unrolled.step_with(&mut other, 0.05, &turned, &u).unwrap();
                all.push(dw);
            }
            assert_same(&one, &other.q, &other.p, stringify!($rule));

            // along a trajectory, whose tables stay while the inputs change
            let noise = Recorded::new(0.05, all).unwrap();
            let path = chain.trajectory(State::at(0.3, q.to_vec(), p.to_vec()), 0.05, noise);
            let end = path.inputs(|k, state| inputs(k, &state.q)).last().unwrap().unwrap();
            assert_same(&end, &other.q, &other.p, stringify!($rule));
        )*};
    }
    check!(Endpoint, InitialPoint, Midpoint, StormerVerlet);
    check!(Composed::new(StormerVerlet, KahanLi8));
}

/// The number of sites is that of the state, and a bad input names itself.
#[test]
fn inputs_of_scenes_of_other_lengths() {
    let chain = Integrator::new(Chain { s: 0.0 }, StormerVerlet);
    for n in [1, 2, 1000] {
        let mut state = State::new(vec![0.1; n], vec![0.0; n]);
        chain
            .step_with(&mut state, 0.1, &vec![0.0; n + 1], &[2.0, 0.0])
            .unwrap();
        // half a kick at each end of the step
        let q = 0.1 + 0.01 * f64::cos(0.1);
        let p = 0.1 * (f64::cos(0.1) + q.cos());
        assert!((state.q[n / 2] - q).abs() < 1e-15);
        assert!((state.p[n / 2] - p).abs() < 1e-14);
        let error = chain.step_with(&mut state, 0.1, &vec![0.0; n + 1], &[f64::NAN, 0.0]);
        assert!(error.unwrap_err().to_string().contains("u[0]"));
    }
}

/// Sites whose masses are borrowed.
struct Borrowed<'a> {
    mass: &'a [f64],
}

#[variational(midpoint, stormer_verlet)]
impl Borrowed<'_> {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * self.mass[i] * v[i] * v[i] - q[i].powi(4);
        }
        l
    }
}

/// The same with inputs, in a scene and unrolled.
struct Pushed<'a> {
    mass: &'a [f64],
}

#[variational(midpoint, stormer_verlet)]
impl Pushed<'_> {
    fn lagrangian(&self, q: &[f64], v: &[f64], u: f64) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * self.mass[i] * v[i] * v[i] - q[i].powi(4) + u * q[i];
        }
        l
    }
}

struct Pair<'a> {
    mass: &'a [f64; 2],
}

#[sve_comparison::stepped(midpoint, stormer_verlet)]
impl Pair<'_> {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2], u: f64) -> f64 {
        let mut l = 0.0;
        for i in 0..2 {
            l += 0.5 * self.mass[i] * v[i] * v[i] - q[i].powi(4) + u * q[i];
        }
        l
    }
}

/// Systems that borrow their data, also by reference and in a function that names the lifetime.
#[test]
fn systems_with_lifetimes_hold_inputs() {
    fn end(pair: &Integrator<Pair<'_>, Midpoint>, push: f64) -> State<[f64; 2]> {
        let path = pair.trajectory(State::new([0.3, 0.4], [0.0; 2]), 0.1, NoNoise);
        path.inputs(|_, _| push).take(10).last().unwrap().unwrap()
    }
    let mass = [1.0, 2.5];
    let start = State::new(vec![0.3, 0.4], vec![0.0; 2]);
    let last = |path: &mut dyn Iterator<Item = Result<State<Vec<f64>>, StepError>>| {
        path.take(10).last().unwrap().unwrap()
    };
    let pair = Integrator::new(Pair { mass: &mass }, Midpoint);
    let pushed = Integrator::new(Pushed { mass: &mass }, Midpoint);
    let by_reference = Pushed { mass: &mass };
    let by_reference = Integrator::new(&by_reference, Midpoint);
    for push in [0.0, 0.7] {
        let expected = end(&pair, push);
        let path = pushed.trajectory(start.clone(), 0.1, NoNoise);
        let found = last(&mut path.inputs(|_, _| push));
        assert_same(&found, &expected.q, &expected.p, "a scene");
        let path = by_reference.trajectory(start.clone(), 0.1, NoNoise);
        let found = last(&mut path.inputs(|_, _| push));
        assert_same(&found, &expected.q, &expected.p, "a reference");
    }
    let expected = end(&pair, 0.0);
    let borrowed = Borrowed { mass: &mass };
    let found =
        last(&mut Integrator::new(&borrowed, Midpoint).trajectory(start.clone(), 0.1, NoNoise));
    assert_same(&found, &expected.q, &expected.p, "a scene without inputs");
    let found = last(&mut Integrator::new(borrowed, Midpoint).trajectory(start, 0.1, NoNoise));
    assert_same(&found, &expected.q, &expected.p, "a scene without inputs");
}
