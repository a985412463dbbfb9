//! Systems without noise, for all four rules.

use sve_comparison::compared;

/// The double pendulum, at rest or not: its mass matrix depends on q.
#[derive(Clone, Debug)]
pub struct PlanarDoublePendulum {
    /// Masses.
    pub m: [f64; 2],
    /// Lengths.
    pub l: [f64; 2],
    /// Gravity.
    pub g: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet, taylor2)]
impl PlanarDoublePendulum {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [m1, m2] = self.m;
        let [l1, l2] = self.l;
        let kinetic = 0.5 * (m1 + m2) * l1.powi(2) * v[0].powi(2)
            + 0.5 * m2 * l2.powi(2) * v[1].powi(2)
            + m2 * l1 * l2 * v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + (m1 + m2) * self.g * l1 * q[0].cos() + m2 * self.g * l2 * q[1].cos()
    }
}

/// A charged particle in a plane with a magnetic field b (1 + c|q|²), whose potential is linear in
/// v, and a trap.
#[derive(Clone, Debug)]
pub struct Magnetic {
    /// Mass.
    pub m: f64,
    /// Field in the middle.
    pub b: f64,
    /// Growth of the field.
    pub c: f64,
    /// Stiffness of the trap.
    pub k: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet, taylor2)]
impl Magnetic {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let r2 = q[0].powi(2) + q[1].powi(2);
        let field = self.b * (0.5 + 0.25 * self.c * r2);
        let kinetic = 0.5 * self.m * (v[0].powi(2) + v[1].powi(2));
        kinetic + field * (q[0] * v[1] - q[1] * v[0]) - 0.5 * self.k * r2
    }
}

/// A pendulum on a sphere, q = (angle from the downward vertical, azimuth); singular at the poles.
#[derive(Clone, Debug)]
pub struct SphericalPendulum {
    /// Mass.
    pub m: f64,
    /// Length.
    pub l: f64,
    /// Gravity.
    pub g: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet, taylor2)]
impl SphericalPendulum {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let (m, l, g) = (self.m, self.l, self.g);
        0.5 * m * l.powi(2) * (v[0].powi(2) + q[0].sin().powi(2) * v[1].powi(2))
            + m * g * l * q[0].cos()
    }
}

/// A fast particle in a trap that couples the coordinates: ∂L/∂v is not affine in v.
#[derive(Clone, Debug)]
pub struct Relativistic {
    /// Mass.
    pub m: f64,
    /// Speed of light.
    pub c: f64,
    /// Stiffness.
    pub k: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet, taylor2)]
impl Relativistic {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let (m, c, k) = (self.m, self.c, self.k);
        let beta2 = (v[0].powi(2) + v[1].powi(2)) / c.powi(2);
        let trap = 0.5 * k * (q[0].powi(2) + q[0] * q[1] + q[1].powi(2));
        -m * c.powi(2) * (1.0 - beta2).sqrt() - trap
    }
}

/// The Hénon–Heiles system.
#[derive(Clone, Debug)]
pub struct HenonHeiles;

#[compared(initial_point, endpoint, midpoint, stormer_verlet, taylor2)]
impl HenonHeiles {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x.powi(2) * y + y.powi(3) / 3.0
    }
}

/// L = ½mv² − ¼kq⁴.
#[derive(Clone, Debug)]
pub struct Quartic {
    /// Mass.
    pub m: f64,
    /// Stiffness.
    pub k: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet, taylor2)]
impl Quartic {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * self.m * v.powi(2) - 0.25 * self.k * q.powi(4)
    }
}
