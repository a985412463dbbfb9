//! Systems whose Lagrangian does not determine every velocity, each with its known properties; and
//! wrong steps of such systems.

pub mod wrong;

use sve_runtime::prelude::*;

/// Two species, in a gauge in which both velocities occur; one coordinate can be removed by a
/// quadratic gauge.
#[derive(Clone, Copy, Debug)]
pub struct LotkaVolterra;

#[variational(midpoint)]
impl LotkaVolterra {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let energy = q[0] + q[1] - q[0].ln() - 2.0 * q[1].ln();
        (q[1].ln() / q[0] + q[1]) * v[0] + q[0] * v[1] - energy
    }

    #[gamma]
    fn weather(&self, q: [f64; 2]) -> f64 {
        0.25 * q[0] * q[1].ln()
    }
}

/// The Lotka–Volterra system in the gauge without the second velocity.
#[derive(Clone, Copy, Debug)]
pub struct InternalLotkaVolterra;

#[variational(initial_point, midpoint, endpoint)]
impl InternalLotkaVolterra {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let energy = q[0] + q[1] - q[0].ln() - 2.0 * q[1].ln();
        q[1].ln() / q[0] * v[0] - energy
    }

    #[gamma]
    fn weather(&self, q: [f64; 2]) -> f64 {
        0.25 * q[0] * q[1].ln()
    }
}

/// The Lotka–Volterra system, slowly, with two noises that do not commute, although both are
/// functions of the configuration.
#[derive(Clone, Copy, Debug)]
pub struct StormyLotkaVolterra;

#[variational(initial_point, midpoint, endpoint)]
impl StormyLotkaVolterra {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let energy = q[0] + q[1] - q[0].ln() - 2.0 * q[1].ln();
        q[1].ln() / q[0] * v[0] - 0.01 * energy
    }

    #[gamma]
    fn weather(&self, q: [f64; 2]) -> [f64; 2] {
        [0.2 * q[0].ln(), 0.2 * q[1]]
    }
}

/// The Lotka–Volterra system in a cubic gauge, which has no internal form.
#[derive(Clone, Copy, Debug)]
pub struct CubicLotkaVolterra;

#[variational(midpoint)]
impl CubicLotkaVolterra {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let energy = q[0] + q[1] - q[0].ln() - 2.0 * q[1].ln();
        // The gradient of x²y + y³/3.
        let gauge = 2.0 * q[0] * q[1] * v[0] + (q[0] * q[0] + q[1] * q[1]) * v[1];
        q[1].ln() / q[0] * v[0] + gauge - energy
    }
}

/// A spin in stereographic coordinates. With γ = −½H the motion is the precession by −(t + ½W)
/// about (0.6, 0, 0.8).
#[derive(Clone, Copy, Debug)]
pub struct Spin;

#[variational(midpoint)]
impl Spin {
    fn energy(&self, q: [f64; 2]) -> f64 {
        let square = q[0] * q[0] + q[1] * q[1];
        (0.6 * 2.0 * q[0] + 0.8 * (1.0 - square)) / (1.0 + square)
    }

    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let square = q[0] * q[0] + q[1] * q[1];
        2.0 * (q[0] * v[1] - q[1] * v[0]) / (1.0 + square) - self.energy(q)
    }

    #[gamma]
    fn field(&self, q: [f64; 2]) -> f64 {
        -0.5 * self.energy(q)
    }
}

/// A slow spin in a field that fluctuates in two directions, whose noises do not commute.
#[derive(Clone, Copy, Debug)]
pub struct TumblingSpin;

#[variational(midpoint)]
impl TumblingSpin {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let square = q[0] * q[0] + q[1] * q[1];
        let height = (1.0 - square) / (1.0 + square);
        2.0 * (q[0] * v[1] - q[1] * v[0]) / (1.0 + square) - 0.01 * height
    }

    #[gamma]
    fn field(&self, q: [f64; 2]) -> [f64; 2] {
        let square = q[0] * q[0] + q[1] * q[1];
        [0.4 * q[0] / (1.0 + square), 0.4 * q[1] / (1.0 + square)]
    }
}

/// The oscillator as a system of first order, with α = (−y, 0). With γ = −½H the motion is the
/// rotation by t + ½W.
#[derive(Clone, Copy, Debug)]
pub struct Kubo;

#[variational(initial_point, midpoint, endpoint)]
impl Kubo {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        -q[1] * v[0] - 0.5 * (q[0] * q[0] + q[1] * q[1])
    }

    #[gamma]
    fn noise(&self, q: [f64; 2]) -> f64 {
        -0.25 * (q[0] * q[0] + q[1] * q[1])
    }
}

/// Four point vortices, in the gauge that has no preferred axis; α is affine.
#[derive(Clone, Copy, Debug)]
pub struct Vortices {
    /// Circulations.
    pub strength: [f64; 4],
}

#[variational(initial_point, midpoint, endpoint)]
impl Vortices {
    fn lagrangian(&self, q: [[f64; 2]; 4], v: [[f64; 2]; 4]) -> f64 {
        let mut l = 0.0;
        for i in 0..4 {
            l += 0.5 * self.strength[i] * (q[i][1] * v[i][0] - q[i][0] * v[i][1]);
            for j in 0..i {
                let square = (q[i][0] - q[j][0]).powi(2) + (q[i][1] - q[j][1]).powi(2);
                l += 0.5 * self.strength[i] * self.strength[j] * square.ln();
            }
        }
        l
    }

    #[gamma]
    fn strain(&self, q: [[f64; 2]; 4]) -> [f64; 2] {
        let mut strain = [0.0; 2];
        for i in 0..4 {
            strain[0] += 0.1 * self.strength[i] * q[i][0] * q[i][1];
            strain[1] += 0.05 * self.strength[i] * (q[i][0] * q[i][0] - q[i][1] * q[i][1]);
        }
        strain
    }
}

/// Two vortices whose noise is a multiple of the energy: they turn about their centre by (Γ₁ +
/// Γ₂)/d² (t + σW).
#[derive(Clone, Copy, Debug)]
pub struct VortexPair {
    /// Circulations.
    pub strength: [f64; 2],
    /// The noise relative to the energy.
    pub sigma: f64,
}

#[variational(midpoint)]
impl VortexPair {
    fn logarithm(&self, q: [[f64; 2]; 2]) -> f64 {
        let square = (q[0][0] - q[1][0]).powi(2) + (q[0][1] - q[1][1]).powi(2);
        0.5 * self.strength[0] * self.strength[1] * square.ln()
    }

    fn lagrangian(&self, q: [[f64; 2]; 2], v: [[f64; 2]; 2]) -> f64 {
        let mut l = self.logarithm(q);
        for i in 0..2 {
            l += 0.5 * self.strength[i] * (q[i][1] * v[i][0] - q[i][0] * v[i][1]);
        }
        l
    }

    #[gamma]
    fn shake(&self, q: [[f64; 2]; 2]) -> f64 {
        self.sigma * self.logarithm(q)
    }

    /// Turns the plane.
    #[symmetry]
    pub fn turn(&self, q: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
        [[-q[0][1], q[0][0]], [-q[1][1], q[1][0]]]
    }
}

/// Charged particles that drift in a magnetic field along z, of strength B = 1 + x²/2 − xy/4, in a
/// potential. The gauge has no axis, so that both components of α are not linear.
#[derive(Clone, Copy, Debug)]
pub struct Drift;

#[variational(midpoint)]
impl Drift {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        let potential = 0.5 * x * x + 0.3 * y * y + 0.1 * (x * y).sin();
        (x * y * y / 16.0 - 0.5 * y - x * x * y / 6.0) * v[0] + (0.5 * x - x * x * y / 16.0) * v[1]
            - potential
    }

    #[gamma]
    fn fields(&self, q: [f64; 2]) -> [f64; 2] {
        [0.2 * q[0], 0.2 * q[1] * q[0].cos()]
    }
}

/// A particle with mass whose potential depends on a massless pair; α is not affine.
#[derive(Clone, Copy, Debug)]
pub struct MassWithPair {
    /// Mass of the particle at rest.
    pub mass: f64,
}

#[variational(midpoint)]
impl MassWithPair {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let [x, a, b] = q;
        let inertia = self.mass * (1.0 + 0.2 * (x * x + a * a));
        let square = a * a + b * b;
        0.5 * inertia * v[0] * v[0]
            + 0.3 * a * v[0]
            + (1.0 + 0.1 * x) * (a * v[2] - b * v[1]) / (1.0 + square)
            - 0.5 * x * x
            - (1.0 - square) / (1.0 + square) * (1.0 + 0.3 * x)
            - 0.2 * a * b
    }

    #[gamma]
    fn kicks(&self, q: [f64; 3]) -> [f64; 2] {
        [0.1 * q[0] * q[1], 0.1 * q[2]]
    }
}

/// A particle with mass and a massless pair with a constant two-form: an oscillator coupled to a
/// spin near its pole.
#[derive(Clone, Copy, Debug)]
pub struct MassWithAffinePair;

#[variational(midpoint)]
impl MassWithAffinePair {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let [x, a, b] = q;
        0.5 * v[0] * v[0] + 0.5 * (a * v[2] - b * v[1]) + 0.3 * x * v[1]
            - 0.5 * x * x
            - 0.5 * (a * a + b * b)
            - 0.2 * x * a * b
    }

    #[gamma]
    fn kicks(&self, q: [f64; 3]) -> [f64; 2] {
        [0.1 * q[0] * q[1], 0.1 * q[2]]
    }
}

/// A spring between a mass and a joint without mass, which a stiffening spring ties to the origin.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    /// Stiffness of the spring.
    pub k: f64,
}

#[variational(initial_point, midpoint, endpoint)]
impl Joint {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * v[0] * v[0] - 0.5 * self.k * (x - y).powi(2) - 0.5 * y * y - 0.25 * y.powi(4)
    }

    #[gamma]
    fn shake(&self, q: [f64; 2]) -> f64 {
        0.3 * q[0].sin()
    }

    #[h1]
    fn jolt(&self, _q: [f64; 2], p: [f64; 2]) -> f64 {
        0.2 * p[0]
    }
}
