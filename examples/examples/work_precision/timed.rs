//! The systems of uneven motion that only `serve` steps: three bodies, and those with a time scale.

use sve_runtime::prelude::*;

/// Three bodies in a plane that attract one another, with the functions that are added.
macro_rules! three_bodies {
    ($(#[$doc:meta])* $name:ident, $($more:tt)*) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $name {
            pub(crate) masses: [f64; 3],
        }

        #[variational(gauss(8))]
        impl $name {
            fn lagrangian(&self, q: [[f64; 2]; 3], v: [[f64; 2]; 3]) -> f64 {
                let mut value = 0.0;
                for i in 0..3 {
                    value += 0.5 * self.masses[i] * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
                    for j in 0..i {
                        let [x, y] = [q[i][0] - q[j][0], q[i][1] - q[j][1]];
                        value += self.masses[i] * self.masses[j] / (x * x + y * y).sqrt();
                    }
                }
                value
            }

            $($more)*
        }
    };
}

three_bodies! {
    /// Three bodies without a time scale.
    ThreeBodies,
}

three_bodies! {
    /// Three bodies with the time scale (Σ (mᵢ + mⱼ)/r³)^(−½).
    TimedThreeBodies,
    #[time_scale]
    fn scale(&self, q: [[f64; 2]; 3]) -> f64 {
        let mut rate = 0.0;
        for i in 0..3 {
            for j in 0..i {
                let [x, y] = [q[i][0] - q[j][0], q[i][1] - q[j][1]];
                let r = (x * x + y * y).sqrt();
                rate += (self.masses[i] + self.masses[j]) / (r * r * r);
            }
        }
        1.0 / rate.sqrt()
    }
}

/// A planet in a plane with the time scale r^(3/2).
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimedKepler;

#[variational(gauss(8))]
impl TimedKepler {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.0 / (q[0] * q[0] + q[1] * q[1]).sqrt()
    }

    #[time_scale]
    fn scale(&self, q: [f64; 2]) -> f64 {
        (q[0] * q[0] + q[1] * q[1]).sqrt().powf(1.5)
    }
}

/// A pendulum with the time scale (ω² + E − V)^(−½), where ω² = g.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimedPendulum {
    pub(crate) g: f64,
    /// The energy of the start.
    pub(crate) energy: f64,
}

#[variational(gauss(8))]
impl TimedPendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }

    #[time_scale]
    fn scale(&self, q: f64) -> f64 {
        1.0 / (self.g + self.energy + self.g * q.cos()).sqrt()
    }
}

/// A double pendulum with the time scale (2g + E − V)^(−½).
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimedDoublePendulum {
    pub(crate) g: f64,
    /// The energy of the start.
    pub(crate) energy: f64,
}

#[variational(gauss(8))]
impl TimedDoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = v[0].powi(2) + 0.5 * v[1].powi(2) + v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + self.g * (2.0 * q[0].cos() + q[1].cos())
    }

    #[time_scale]
    fn scale(&self, q: [f64; 2]) -> f64 {
        1.0 / (2.0 * self.g + self.energy + self.g * (2.0 * q[0].cos() + q[1].cos())).sqrt()
    }
}
