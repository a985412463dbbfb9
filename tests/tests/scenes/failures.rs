//! Indices out of range and fields of wrong lengths are errors of the step, and leave the state as
//! it is.

use sve_runtime::prelude::*;

struct Listed {
    mass: Vec<f64>,
    bonds: Vec<[i64; 2]>,
    width: usize,
}

#[variational(endpoint, stormer_verlet)]
#[allow(clippy::cast_sign_loss)] // negative indices are what is tested
impl Listed {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * self.mass[i] * v[i] * v[i];
        }
        for bond in &self.bonds {
            l -= 0.5 * (q[bond[0] as usize] - q[bond[1] as usize]).powi(2);
        }
        for i in 0..q.len() / self.width {
            l -= 0.5 * q[i * self.width].powi(2);
        }
        l
    }
}

/// Returns the message of the failed first step.
fn message(system: &Listed, n: usize) -> String {
    let start = State::new(vec![0.5; n], vec![1.0; n]);
    let mut state = start.clone();
    let integrator = Integrator::new(system, StormerVerlet);
    let error = integrator.step(&mut state, 0.1, &[]).expect_err("an error");
    assert_eq!(state, start);
    error.to_string()
}

#[test]
fn indices_out_of_range_are_errors() {
    let good = || Listed {
        mass: vec![1.0; 4],
        bonds: vec![[0, 1]],
        width: 2,
    };
    let mut state = State::new(vec![0.5; 4], vec![1.0; 4]);
    Integrator::new(good(), Endpoint)
        .step(&mut state, 0.1, &[])
        .expect("a step");
    for (system, n, parts) in [
        (good(), 5, ["self.mass[i]", "index 4", "4"]),
        (
            Listed {
                bonds: vec![[0, 1], [2, 4]],
                ..good()
            },
            4,
            ["q[", "index 4", "4"],
        ),
        (
            Listed {
                bonds: vec![[-1, 0]],
                ..good()
            },
            4,
            ["q[", "index -1", "4"],
        ),
        (
            Listed {
                bonds: vec![[i64::MIN, i64::MAX]],
                ..good()
            },
            4,
            ["q[", "index", "4"],
        ),
        (
            Listed { width: 0, ..good() },
            4,
            ["q.len() / self.width", "lagrangian", "4"],
        ),
        (
            Listed {
                mass: Vec::new(),
                ..good()
            },
            4,
            ["self.mass[i]", "index 0", "0"],
        ),
    ] {
        let message = message(&system, n);
        for part in parts {
            assert!(message.contains(part), "{message} lacks {part}");
        }
    }
}

#[test]
fn no_sites_are_a_state() {
    let system = Listed {
        mass: Vec::new(),
        bonds: Vec::new(),
        width: 1,
    };
    let mut state = State::new(Vec::new(), Vec::new());
    Integrator::new(system, Endpoint)
        .step(&mut state, 0.1, &[])
        .expect("a step");
    assert_eq!((state.q.len(), state.t), (0, 0.1));
}

/// An index is executed where the source executes it: a term that a condition leaves out is not
/// read, and neither are the bounds of a loop in it.
#[test]
fn what_a_condition_leaves_out_is_not_read() {
    struct Guarded {
        start: Vec<usize>,
        far: Vec<usize>,
    }
    #[variational(endpoint)]
    impl Guarded {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            let n = q.len();
            let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
            for i in 0..n {
                if i > 0 && self.far[i - 1] < n {
                    l -= q[self.far[i - 1]] * q[i - 1];
                }
                if i < self.start.len() {
                    for k in 0..self.start[i] {
                        if i + k < n {
                            l -= q[i] * q[i + k];
                        }
                    }
                }
            }
            l
        }
    }
    let system = Guarded {
        start: vec![2, 1],
        far: vec![7, 0],
    };
    let p = impulses!(&system, [1.0, 2.0, 4.0], 0.0, 1.0, &[]);
    // −q₀q₁ of far; −q₀² − q₀q₁ − q₁² of start
    assert_eq!(p, [-2.0 - 2.0 - 2.0, -1.0 - 1.0 - 4.0, 0.0]);
}

/// An index in a sum that enters a formula is checked like others.
#[test]
fn an_index_out_of_range_in_a_total_is_an_error() {
    struct Weighted {
        weight: Vec<f64>,
    }
    #[variational(stormer_verlet)]
    impl Weighted {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            let s = (0..q.len()).map(|i| self.weight[i] * q[i]).sum::<f64>();
            v.iter().map(|v| 0.5 * v * v).sum::<f64>() - s * s
        }
    }
    let weight = vec![1.0; 2];
    let weighted = Integrator::new(Weighted { weight }, StormerVerlet);
    let start = State::new(vec![1.0; 3], vec![0.5; 3]);
    let expected = StepError::Index {
        t: 0.0,
        text: "`self.weight[i]` in `lagrangian` (i = 2)".into(),
        index: 2,
        length: 2,
    };
    let mut state = start.clone();
    assert_eq!(weighted.step(&mut state, 0.1, &[]), Err(expected.clone()));
    assert_eq!(state, start);
    let mut path = weighted.trajectory(start, 0.1, NoNoise);
    assert_eq!(path.advance(10), Err(expected.clone()));
    assert_eq!(weighted.system().hamiltonian(&state), Err(expected));
}
