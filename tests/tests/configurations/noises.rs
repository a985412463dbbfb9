//! A γ in the shape of q: each of its numbers is a Wiener process, in the order of memory.

use sve_runtime::prelude::*;

use crate::{H, START, flat, state};

const DW: [f64; 6] = [0.1, -0.2, 0.05, 0.3, -0.15, 0.02];

/// A system of six coordinates in a well whose noises are `$noise`, of the type `$noises`.
macro_rules! bath {
    ($name:ident: $q:ty, |$well:ident| $square:expr, |$this:ident, $at:ident| $noises:ty { $noise:expr }) => {
        struct $name {
            sigma: f64,
        }

        #[variational(midpoint, stormer_verlet)]
        impl $name {
            fn lagrangian(&self, q: $q, v: $q) -> f64 {
                0.5 * Self::square(v) - 0.25 * Self::square(q).powi(2)
            }
            fn square($well: $q) -> f64 {
                $square
            }
            #[gamma]
            fn bath(&$this, $at: $q) -> $noises {
                $noise
            }
        }
    };
}

bath!(Flat: [f64; 6], |x| x.iter().map(|x| x * x).sum(), |self, q| [f64; 6] {
    q.map(|q| self.sigma * q.sin())
});
bath!(Rows: [[f64; 2]; 3], |x| x.iter().flatten().map(|x| x * x).sum(), |self, q| [[f64; 2]; 3] {
    q.map(|row| row.map(|q| self.sigma * q.sin()))
});
bath!(Vectors: [Vector3<f64>; 2], |x| x.iter().flat_map(|x| x.iter()).map(|x| x * x).sum(), |self, q| [Vector3<f64>; 2] {
    q.map(|q| q.map(|q| self.sigma * q.sin()))
});
bath!(OneVector: Vector6<f64>, |x| x.iter().map(|x| x * x).sum(), |self, q| Vector6<f64> {
    q.map(|q| self.sigma * q.sin())
});
// neither has the shape of q
bath!(VectorsOfFlat: [f64; 6], |x| x.iter().map(|x| x * x).sum(), |self, q| [Vector2<f64>; 3] {
    [0, 2, 4].map(|i| Vector2::new(self.sigma * q[i].sin(), self.sigma * q[i + 1].sin()))
});

#[test]
fn a_gamma_in_the_shape_of_q_has_the_bits_of_a_flat_one() {
    macro_rules! compare {
        ($name:ident, $rule:expr) => {{
            let flat_one = Integrator::new(Flat { sigma: 0.3 }, $rule);
            let integrator = Integrator::new($name { sigma: 0.3 }, $rule);
            assert_eq!(integrator.plan().noises, 6);
            let (mut expected, mut own) = (START, state(&START));
            for _ in 0..20 {
                flat_one.step(&mut expected, H, &DW).unwrap();
                integrator.step(&mut own, H, &DW).unwrap();
                assert_eq!(flat(&own), expected, stringify!($name));
            }
        }};
    }
    compare!(Rows, Midpoint);
    compare!(Vectors, Midpoint);
    compare!(OneVector, Midpoint);
    compare!(VectorsOfFlat, Midpoint);
    compare!(Rows, StormerVerlet);
    compare!(Vectors, StormerVerlet);
    compare!(OneVector, StormerVerlet);
    compare!(VectorsOfFlat, StormerVerlet);
}

#[test]
fn the_plan_names_processes_like_coordinates() {
    let rows = Integrator::new(Rows { sigma: 0.3 }, StormerVerlet);
    let vectors = Integrator::new(Vectors { sigma: 0.3 }, StormerVerlet);
    for (plan, names) in [
        (rows.plan(), ["bath[0][1] =", "bath[1][0] ="]),
        (vectors.plan(), ["bath[0].x =", "bath[0].z ="]),
    ] {
        sve_models::checks::assert_says(plan, &names);
    }
}
