//! Noises with several processes for each site: steps are those of the unrolled system.

use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;

use crate::common::spread;

/// Bodies in a well whose processes are those of bonds and those of sites, in turn.
mod vectors {
    use sve_runtime::nalgebra::Vector3;
    use sve_runtime::prelude::*;
    both! {
        struct { sigma: Vec<f64> }
        [Vector3<f64>] 5
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i].norm_squared() - 0.25 * q[i].norm_squared().powi(2);
            }
            for i in 1..q.len() {
                l -= 0.5 * (q[i] - q[i - 1]).norm_squared();
            }
            l
        }
        #[gamma]
        each bath(&self, q) -> Vector3<f64> |i| { q[i].map(|x| self.sigma[i] * x.sin()) }
        {
            #[gamma]
            fn bonds(&self, q: &[Vector3<f64>]) -> Vec<[f64; 2]> {
                (1..q.len()).map(|i| [q[i].dot(&q[i - 1]), q[i].x * q[i - 1].y]).collect()
            }
        } or {
            #[gamma]
            fn bonds(&self, q: [Vector3<f64>; 5]) -> [[f64; 2]; 4] {
                let mut noises = [[0.0; 2]; 4];
                for i in 1..5 {
                    noises[i - 1] = [q[i].dot(&q[i - 1]), q[i].x * q[i - 1].y];
                }
                noises
            }
        }
        #[gamma]
        fn all(&self, q) -> [[f64; 1]; 2] {
            let x = q.iter().map(|q| q.x).sum::<f64>();
            [[0.3 * x], [0.1 * x * x]]
        }
    }
}

#[test]
fn processes_of_components_are_numbered_row_by_row() {
    let vectors = |seed| {
        let numbers = spread(15, seed);
        let row = |i: usize| Vector3::from_column_slice(&numbers[3 * i..3 * i + 3]);
        std::array::from_fn::<_, 5, _>(row)
    };
    let dw: [f64; 25] = std::array::from_fn(|i| 0.1 * spread(25, 3)[i]);
    compare!(
        vectors {
            sigma: spread(5, 9)
        },
        vectors(1),
        vectors(2),
        dw
    );
}

/// Two processes a site, beside one function with one process a site.
#[test]
fn long_scenes_have_the_noise_of_each_site() {
    struct Baths {
        k: f64,
    }
    #[variational(endpoint)]
    impl Baths {
        fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
                l -= 0.5 * self.k * (q[i][0] * q[i][0] + q[i][1] * q[i][1]);
            }
            l
        }
        #[gamma]
        fn push(&self, q: &[[f64; 2]]) -> Vec<f64> {
            q.iter().map(|q| q[0] + q[1]).collect()
        }
        #[gamma]
        fn bath(&self, q: &[[f64; 2]]) -> Vec<[f64; 2]> {
            q.iter().map(|q| [2.0 * q[0], 3.0 * q[1]]).collect()
        }
    }
    let n = 1000;
    let dw = spread(3 * n, 4);
    let mut state = State::new(vec![[0.0; 2]; n], vec![[0.0; 2]; n]);
    let baths = Integrator::new(Baths { k: 1.0 }, Endpoint);
    baths.step(&mut state, 0.1, &dw).expect("a step");
    for (i, p) in state.p.iter().enumerate() {
        let (push, bath) = (dw[i], &dw[n + 2 * i..]);
        let expected = [push + 2.0 * bath[0], push + 3.0 * bath[1]];
        assert!((p[0] - expected[0]).abs() < 1e-14 && (p[1] - expected[1]).abs() < 1e-14);
    }
    let text = baths.plan().to_string();
    assert!(text.contains("γ bath: 2 processes for"), "{text}");
}
