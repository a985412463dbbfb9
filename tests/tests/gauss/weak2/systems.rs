//! Systems with the option `weak2`, and those that contain its potential by hand.

use sve_runtime::prelude::*;

/// Two systems with the same functions: one with the option, and one whose Lagrangian has the potential, of which `part` is ½κh.
macro_rules! both {
    ($system:ident $by_hand:ident $size:literal { $($functions:tt)* }) => {
        #[derive(Clone)]
        pub(crate) struct $system {
            pub(crate) s: [f64; 2],
            pub(crate) m: f64,
        }

        #[variational(
            structure = both,
            gauss(2),
            gauss(2, weak2),
            gauss(3, weak2),
            gauss(4, weak2),
            gauss(2, stage_noise, weak2),
            gauss(4, stage_noise, weak2)
        )]
        impl $system {
            fn lagrangian(&self, t: f64, q: [f64; $size], v: [f64; $size]) -> f64 {
                self.l(t, q, v)
            }

            $($functions)*
        }

        #[derive(Clone)]
        pub(crate) struct $by_hand {
            pub(crate) s: [f64; 2],
            pub(crate) m: f64,
            pub(crate) part: f64,
        }

        #[variational(gauss(2), gauss(3), gauss(4), gauss(2, stage_noise), gauss(4, stage_noise))]
        impl $by_hand {
            fn lagrangian(&self, t: f64, q: [f64; $size], v: [f64; $size]) -> f64 {
                self.l(t, q, v) - self.part * self.k(t, q)
            }

            $($functions)*
        }
    };
}

both!(Well WellByHand 1 {
    fn l(&self, _t: f64, q: [f64; 1], v: [f64; 1]) -> f64 {
        0.5 * self.m * v[0] * v[0] - 0.25 * (q[0] * q[0] - 1.0).powi(2)
    }

    #[allow(dead_code)]
    fn k(&self, _t: f64, q: [f64; 1]) -> f64 {
        ((2.0 * self.s[0] * (2.0 * q[0]).cos()).powi(2) + (self.s[1] * q[0] * q[0]).powi(2)) / self.m
    }

    #[gamma]
    fn kicks(&self, q: [f64; 1]) -> [f64; 2] {
        [self.s[0] * (2.0 * q[0]).sin(), self.s[1] * q[0].powi(3) / 3.0]
    }
});

both!(Heavy HeavyByHand 1 {
    fn l(&self, _t: f64, q: [f64; 1], v: [f64; 1]) -> f64 {
        0.5 * (self.m + 0.25 * q[0] * q[0]) * v[0] * v[0] + q[0].cos()
    }

    #[allow(dead_code)]
    fn k(&self, _t: f64, q: [f64; 1]) -> f64 {
        (self.s[0] * q[0].cos()).powi(2) / (self.m + 0.25 * q[0] * q[0])
    }

    #[gamma]
    fn kicks(&self, q: [f64; 1]) -> f64 {
        self.s[0] * q[0].sin()
    }

    #[force]
    fn drag(&self, _q: [f64; 1], v: [f64; 1]) -> [f64; 1] {
        [-self.s[1] * v[0]]
    }
});

// both angles of a double pendulum, shaken by noise that changes with time
both!(Pendulums PendulumsByHand 2 {
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

    #[gamma]
    fn shake(&self, t: f64, q: [f64; 2]) -> [f64; 2] {
        [self.s[0] * t.cos() * q[0].sin(), self.s[1] * q[1].cos()]
    }
});

/// H = ½p²w + ½kq² with H₁ = ½(aq² + bp²).
#[derive(Clone)]
pub(crate) struct Quadratic {
    pub(crate) w: f64,
    pub(crate) k: f64,
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[variational(
    gauss(2),
    gauss(3),
    gauss(4),
    gauss(2, weak2),
    gauss(3, weak2),
    gauss(4, weak2)
)]
impl Quadratic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v / self.w - 0.5 * self.k * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * (self.a * q * q + self.b * p * p)
    }
}

/// Two functions of one invariant move position and momentum, with a mass that depends on the position, a vector potential, and time.
#[derive(Clone)]
pub(crate) struct Stretched {
    pub(crate) s: [f64; 2],
    pub(crate) m: f64,
}

#[variational(structure = both, gauss(2, weak2), gauss(4, weak2))]
impl Stretched {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        0.5 * (self.m + 0.5 * q * q) * v * v + self.m * q * q * v + q.cos() * (1.0 + 0.2 * t)
    }

    #[h1]
    fn jitter(&self, t: f64, q: f64, p: f64) -> [f64; 2] {
        let invariant = q * p;
        [
            self.s[0] * (1.0 + 0.5 * t) * invariant,
            self.s[1] * invariant * invariant,
        ]
    }
}

/// The same with two coordinates and coupled masses.
#[derive(Clone)]
pub(crate) struct Moved {
    pub(crate) s: [f64; 2],
    pub(crate) m: f64,
}

#[variational(gauss(2, weak2), gauss(3, weak2), gauss(4, weak2))]
impl Moved {
    fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mass = self.m + 0.5 * q[0].sin();
        0.5 * mass * v[0] * v[0]
            + 0.5 * v[1] * v[1]
            + 0.3 * v[0] * v[1]
            + self.m * q[1] * v[0]
            + q[0].cos() * (1.0 + 0.2 * t.sin())
            - 0.5 * q[1] * q[1]
    }

    #[h1]
    fn jitter(&self, t: f64, q: [f64; 2], p: [f64; 2]) -> [f64; 2] {
        let invariant = q[0] * p[1] - q[1] * p[0];
        [
            self.s[0] * (1.0 + 0.5 * t.sin()) * invariant,
            self.s[1] * invariant * invariant,
        ]
    }
}

/// Additive noise: K is a constant, and the step has the bits of the plain one.
#[derive(Clone)]
pub(crate) struct Additive;

#[variational(
    gauss(2),
    gauss(2, weak2),
    gauss(4),
    gauss(4, weak2),
    gauss(3, stage_noise),
    gauss(3, stage_noise, weak2)
)]
impl Additive {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0] + v[0] * v[1] + v[1] * v[1] + q[0].cos() * q[1].cos()
    }

    #[gamma]
    fn push(&self, t: f64, q: [f64; 2]) -> f64 {
        q[0] - 0.5 * t.sin() * q[1]
    }
}
