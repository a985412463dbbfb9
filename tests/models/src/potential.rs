//! Systems with the option `weak2`, and systems whose Lagrangian contains the potential of the
//! option explicitly.

use sve_comparison::compared_with_derivatives;
use sve_runtime::prelude::*;

/// Systems with the same functions: one with the option, one whose Lagrangian has the potential,
/// and one whose steps are also derived without structure.
macro_rules! both {
    ($system:ident $by_hand:ident $unstructured:ident $size:literal $functions:tt) => {
        both! { @with_option $unstructured (compared_with_derivatives) (gauss(2, weak2), gauss(4, weak2)) $size $functions }
        both! {
            $system (
                midpoint,
                midpoint(weak2),
                stormer_verlet,
                stormer_verlet(weak2),
                gauss(2),
                gauss(2, weak2),
                gauss(3, weak2),
                gauss(4, weak2),
                gauss(2, stage_noise, weak2),
                gauss(4, stage_noise, weak2)
            )
            $by_hand (
                midpoint,
                stormer_verlet,
                gauss(2),
                gauss(3),
                gauss(4),
                gauss(2, stage_noise),
                gauss(4, stage_noise)
            )
            $size $functions
        }
    };
    (@with_option $system:ident ($attribute:ident) $rules:tt $size:literal { $($functions:tt)* }) => {
        /// The system with the option.
        #[derive(Clone, Debug)]
        pub struct $system {
            /// Strengths of the noise, or of noise and friction.
            pub s: [f64; 2],
            /// Mass.
            pub m: f64,
        }

        #[$attribute $rules]
        impl $system {
            /// L.
            pub fn lagrangian(&self, t: f64, q: [f64; $size], v: [f64; $size]) -> f64 {
                self.l(t, q, v)
            }

            $($functions)*
        }
    };
    ($system:ident $rules:tt $by_hand:ident $rules_by_hand:tt $size:literal { $($functions:tt)* }) => {
        both! { @with_option $system (variational) $rules $size { $($functions)* } }

        /// The system with the potential.
        #[derive(Clone, Debug)]
        pub struct $by_hand {
            /// Strengths of the noise, or of noise and friction.
            pub s: [f64; 2],
            /// Mass.
            pub m: f64,
            /// ½κh for the rule and the size of its steps.
            pub part: f64,
        }

        #[variational $rules_by_hand]
        impl $by_hand {
            /// L − ½κhK.
            pub fn lagrangian(&self, t: f64, q: [f64; $size], v: [f64; $size]) -> f64 {
                self.l(t, q, v) - self.part * self.k(t, q)
            }

            $($functions)*
        }
    };
}

both!(Well WellByHand WellUnstructured 1 {
    fn l(&self, _t: f64, q: [f64; 1], v: [f64; 1]) -> f64 {
        0.5 * self.m * v[0] * v[0] - 0.25 * (q[0] * q[0] - 1.0).powi(2)
    }

    #[allow(dead_code)]
    fn k(&self, _t: f64, q: [f64; 1]) -> f64 {
        ((2.0 * self.s[0] * (2.0 * q[0]).cos()).powi(2) + (self.s[1] * q[0] * q[0]).powi(2)) / self.m
    }

    /// γ.
    #[gamma]
    pub fn kicks(&self, q: [f64; 1]) -> [f64; 2] {
        [self.s[0] * (2.0 * q[0]).sin(), self.s[1] * q[0].powi(3) / 3.0]
    }
});

both!(Heavy HeavyByHand HeavyUnstructured 1 {
    fn l(&self, _t: f64, q: [f64; 1], v: [f64; 1]) -> f64 {
        0.5 * (self.m + 0.25 * q[0] * q[0]) * v[0] * v[0] + q[0].cos()
    }

    #[allow(dead_code)]
    fn k(&self, _t: f64, q: [f64; 1]) -> f64 {
        (self.s[0] * q[0].cos()).powi(2) / (self.m + 0.25 * q[0] * q[0])
    }

    /// γ.
    #[gamma]
    pub fn kicks(&self, q: [f64; 1]) -> f64 {
        self.s[0] * q[0].sin()
    }

    /// F.
    #[force]
    pub fn drag(&self, _q: [f64; 1], v: [f64; 1]) -> [f64; 1] {
        [-self.s[1] * v[0]]
    }
});

// The angles of a double pendulum, both shaken by noise that changes with time.
both!(Pendulums PendulumsByHand PendulumsUnstructured 2 {
    fn l(&self, _t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
        self.m * v[0] * v[0] + 0.5 * v[1] * v[1] + (q[0] - q[1]).cos() * v[0] * v[1]
            + 2.0 * q[0].cos() + q[1].cos()
    }

    #[allow(dead_code)]
    fn k(&self, t: f64, q: [f64; 2]) -> f64 {
        let c = (q[0] - q[1]).cos();
        let (a, b) = (self.s[0] * t.cos() * q[0].cos(), -self.s[1] * q[1].sin());
        // M = (2m, c; c, 1)
        (a * a + 2.0 * self.m * b * b) / (2.0 * self.m - c * c)
    }

    /// γ.
    #[gamma]
    pub fn shake(&self, t: f64, q: [f64; 2]) -> [f64; 2] {
        [self.s[0] * t.cos() * q[0].sin(), self.s[1] * q[1].cos()]
    }
});

/// Inverse of the 4 × 4 matrix with 3 on the diagonal and 1 beside it, times 55.
const INVERSE: [[f64; 4]; 4] = [
    [21.0, -8.0, 3.0, -1.0],
    [-8.0, 24.0, -9.0, 3.0],
    [3.0, -9.0, 24.0, -8.0],
    [-1.0, 3.0, -8.0, 21.0],
];

both!(Chain (midpoint, midpoint(weak2), stormer_verlet, stormer_verlet(weak2)) ChainByHand (midpoint, stormer_verlet) 4 {
    fn l(&self, _t: f64, q: [f64; 4], v: [f64; 4]) -> f64 {
        let mut l = 0.0;
        for i in 0..4 {
            l += self.m * 1.5 * v[i] * v[i] + q[i].cos();
        }
        for i in 1..4 {
            l += self.m * v[i] * v[i - 1] - 0.5 * (q[i] - q[i - 1]).powi(2);
        }
        l
    }

    #[allow(dead_code)]
    fn k(&self, _t: f64, q: [f64; 4]) -> f64 {
        let slopes = [self.s[0] * q[1], self.s[0] * q[0], self.s[1] * q[2].cos(), 0.0];
        let mut k = 0.0;
        for i in 0..4 {
            for j in 0..4 {
                k += slopes[i] * INVERSE[i][j] * slopes[j] / (55.0 * self.m);
            }
        }
        k
    }

    /// γ.
    #[gamma]
    pub fn shake(&self, q: [f64; 4]) -> f64 {
        self.s[0] * q[0] * q[1] + self.s[1] * q[2].sin()
    }
});

/// Additive noise: K is a constant, and the step has the bits of the step without the option.
#[derive(Clone, Debug)]
pub struct Additive;

#[variational(
    midpoint,
    midpoint(weak2),
    stormer_verlet,
    stormer_verlet(weak2),
    gauss(2),
    gauss(2, weak2),
    gauss(4),
    gauss(4, weak2),
    gauss(3, stage_noise),
    gauss(3, stage_noise, weak2)
)]
impl Additive {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0] + v[0] * v[1] + v[1] * v[1] + q[0].cos() * q[1].cos()
    }

    /// γ.
    #[gamma]
    pub fn push(&self, t: f64, q: [f64; 2]) -> f64 {
        q[0] - 0.5 * t.sin() * q[1]
    }
}
