//! Systems whose steps have several solutions at large steps, of one to three coordinates and every
//! kind of term.

use sve_runtime::prelude::*;

/// A system without parameters, by the one-node rules.
macro_rules! system {
    ($name:ident $($body:tt)*) => {
        pub(super) struct $name;

        #[variational(midpoint, endpoint, initial_point)]
        impl $name {
            $($body)*
        }
    };
}

system! { DoubleWell
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.25 * (q * q - 1.0).powi(2)
    }
    #[gamma]
    fn cubic(&self, q: f64) -> f64 {
        0.15 * q.powi(3)
    }
    #[h1]
    fn mixed(&self, q: f64, p: f64) -> [f64; 3] {
        [
            0.15 * q * p,
            0.075 * p * p * (1.0 + q * q),
            0.15 * (q * p).sin(),
        ]
    }
}
system! { Kapitza
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        let (l, a, w, g) = (0.8, 0.05, 40.0, 9.81);
        0.5 * l * l * v * v - a * l * w * (w * t).sin() * v * q.sin() + g * l * q.cos()
    }
    #[gamma]
    fn wave(&self, t: f64, q: f64) -> f64 {
        0.2 * (q + t).cos()
    }
}
system! { PoschlTeller
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + 3.0 / (1.4 * q).cosh().powi(2)
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.2 * q.tanh()
    }
    #[h1]
    fn shift(&self, _q: f64, p: f64) -> f64 {
        0.2 * p.sin()
    }
}
system! { MathewsLakshmanan
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * (v * v - q * q) / (1.0 + 0.3 * q * q)
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.2 * q
    }
}
system! { QuarticKinetic
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + 0.25 * v.powi(4) - 0.325 * q.powi(4)
    }
    #[gamma]
    fn wave(&self, q: f64) -> f64 {
        0.2 * q.cos()
    }
    #[h1]
    fn shift(&self, _q: f64, p: f64) -> f64 {
        0.1 * p * p
    }
}
system! { Pendulum
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + 9.8 * q.cos()
    }
    #[gamma]
    fn wave(&self, q: f64) -> f64 {
        0.5 * q.sin()
    }
}
system! { DoublePendulum
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0]
            + 0.5 * v[1] * v[1]
            + v[0] * v[1] * (q[0] - q[1]).cos()
            + 19.6 * q[0].cos()
            + 9.8 * q[1].cos()
    }
    #[gamma]
    fn waves(&self, q: [f64; 2]) -> [f64; 2] {
        [0.3 * q[0].sin(), 0.3 * q[1].cos()]
    }
}
system! { HenonHeiles
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x * x * y + y.powi(3) / 3.0
    }
    #[gamma]
    fn shear(&self, q: [f64; 2]) -> f64 {
        0.2 * q[0] * q[1]
    }
}
system! { TurnedHenonHeiles
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x * x * y + y.powi(3) / 3.0
    }
    #[h1]
    fn turn(&self, q: [f64; 2], p: [f64; 2]) -> f64 {
        0.2 * (q[0] * p[1] - q[1] * p[0]) + 0.1 * p[0] * p[0] * q[1]
    }
}
system! { Rotor
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + 4.0 * q.cos()
    }
    #[h1]
    fn mass(&self, q: f64, p: f64) -> f64 {
        0.3 * p * p * q.cos()
    }
}
system! { Synchrotron
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos() + 0.3 * q
    }
    #[gamma]
    fn wave(&self, q: f64) -> f64 {
        0.4 * (2.0 * q).cos()
    }
}
system! { Kepler
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.0 / (q[0] * q[0] + q[1] * q[1]).sqrt()
    }
    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        0.1 * q[0]
    }
}
system! { GaussianWell
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + 2.0 * (-2.0 * q * q).exp()
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.3 * q
    }
}
system! { LorentzWell
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + 2.0 / (1.0 + q * q)
    }
    #[gamma]
    fn wave(&self, q: f64) -> f64 {
        0.3 * q.sin()
    }
}
system! { Morse
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - (1.0 - (-q).exp()).powi(2)
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.2 * q
    }
}
system! { CurvedMass
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v * (1.0 + 0.5 * q.sin()) - 0.5 * q * q
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.2 * q
    }
}
system! { PolarOrbit
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]) + 1.0 / q[0]
    }
    #[gamma]
    fn wave(&self, q: [f64; 2]) -> f64 {
        0.2 * q[1].sin()
    }
}
system! { Actions
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }
    #[h1]
    fn powers(&self, q: f64, p: f64) -> [f64; 2] {
        let action = 0.5 * (q * q + p * p);
        [0.5 * action, 0.2 * action * action]
    }
}
system! { Bounded
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q + 0.3 * (q + 3.0).ln()
    }
    #[gamma]
    fn root(&self, q: f64) -> f64 {
        0.3 * (4.0 - q * q).sqrt()
    }
}
system! { RelativisticOscillator
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        -(1.0 - v * v).sqrt() - 0.5 * q * q
    }
    #[gamma]
    fn wave(&self, q: f64) -> f64 {
        0.2 * q.sin()
    }
}
system! { CoshKinetic
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v.cosh() - 0.5 * q * q
    }
    #[gamma]
    fn wave(&self, q: f64) -> f64 {
        0.2 * q.sin()
    }
}
system! { TwoWaves
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        0.5 * v * v + (q - t).cos() + (q + 2.0 * t).cos()
    }
    #[h1]
    fn shift(&self, q: f64, p: f64) -> f64 {
        0.3 * (p + q).sin()
    }
}
system! { Chain
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let [a, b] = [q[1] - q[0], q[2] - q[1]];
        0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
            - 0.25 * (a.powi(4) + b.powi(4))
            - 0.5 * a * a
    }
    #[gamma]
    fn push(&self, q: [f64; 3]) -> f64 {
        0.2 * q[0]
    }
}
