//! Systems on surfaces, each for a feature of constraints.

use sve_runtime::prelude::*;

/// A particle on a torus, whose equation is not quadratic: γ = s sin(x + 2z).
#[derive(Clone, Debug)]
pub struct Torus {
    /// Gravity.
    pub g: f64,
    /// Distance of the tube's centre from the axis.
    pub a: f64,
    /// Radius of the tube.
    pub b: f64,
    /// Strength of the noise.
    pub s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Torus {
    /// L.
    pub fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    /// γ.
    #[gamma]
    pub fn shake(&self, q: Vector3<f64>) -> f64 {
        self.s * (q.x + 2.0 * q.z).sin()
    }

    /// The torus.
    #[constraint]
    pub fn torus(&self, q: Vector3<f64>) -> f64 {
        let from_axis = (q.x * q.x + q.y * q.y).sqrt();
        0.5 * ((from_axis - self.a).powi(2) + q.z * q.z - self.b * self.b)
    }
}

/// A particle on an ellipsoid that noise moves along level curves, H₁ = s ⟨n × c, p⟩ with the
/// normal n = Dφ.
#[derive(Clone, Debug)]
pub struct Ellipsoid {
    /// Squares of the semi-axes.
    pub axes: [f64; 3],
    /// Gravity.
    pub g: f64,
    /// Strength of the noise.
    pub s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Ellipsoid {
    /// The normal.
    fn normal(&self, q: Vector3<f64>) -> Vector3<f64> {
        let [a, b, c] = self.axes;
        Vector3::new(q.x / a, q.y / b, q.z / c)
    }

    /// L.
    pub fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    /// H₁.
    #[h1]
    pub fn slide(&self, q: Vector3<f64>, p: Vector3<f64>) -> f64 {
        self.s * self.normal(q).cross(&Vector3::new(0.2, -0.5, 1.0)).dot(&p)
    }

    /// The ellipsoid.
    #[constraint]
    pub fn ellipsoid(&self, q: Vector3<f64>) -> f64 {
        0.5 * (self.normal(q).dot(&q) - 1.0)
    }
}

/// A particle on the unit sphere with a fluctuating mass, H₁ = s (1 + x/2) |p|²/2 with the momentum
/// along the sphere.
#[derive(Clone, Debug)]
pub struct Curved {
    /// Gravity.
    pub g: f64,
    /// Strength of the noise.
    pub s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Curved {
    /// L.
    pub fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    /// H₁.
    #[h1(tangent)]
    pub fn mass(&self, q: Vector3<f64>, p: Vector3<f64>) -> f64 {
        0.5 * self.s * (1.0 + 0.5 * q.x) * p.norm_squared()
    }

    /// The unit sphere.
    #[constraint]
    pub fn sphere(&self, q: Vector3<f64>) -> f64 {
        0.5 * (q.norm_squared() - 1.0)
    }
}

/// Coupled masses that depend on q, on the surface z = y sin x: γ = s x z.
#[derive(Clone, Debug)]
pub struct Saddle {
    /// Coupling of the masses.
    pub c: f64,
    /// Strength of the noise.
    pub s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Saddle {
    /// L.
    pub fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let [x, y, z] = q;
        let kinetic = 0.5 * (1.5 + y.sin()) * v[0].powi(2)
            + 0.5 * (1.0 + x.powi(2)) * v[1].powi(2)
            + self.c * (x + y).cos() * v[0] * v[1]
            + 0.5 * v[2].powi(2);
        kinetic + 0.3 * y * v[2] - 0.5 * x.powi(2) - 0.25 * y.powi(4) - z
    }

    /// γ.
    #[gamma]
    pub fn push(&self, q: [f64; 3]) -> f64 {
        self.s * q[0] * q[2]
    }

    /// The surface.
    #[constraint]
    pub fn surface(&self, q: [f64; 3]) -> f64 {
        q[2] - q[1] * q[0].sin()
    }
}

/// A particle on a sphere whose radius changes with time, r = 1 + d sin t: γ = s x z.
#[derive(Clone, Debug)]
pub struct Breathing {
    /// Gravity.
    pub g: f64,
    /// Amplitude of the radius.
    pub d: f64,
    /// Strength of the noise.
    pub s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Breathing {
    /// The radius.
    pub fn radius(&self, t: f64) -> f64 {
        1.0 + self.d * t.sin()
    }

    /// L.
    pub fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    /// γ.
    #[gamma]
    pub fn shake(&self, q: Vector3<f64>) -> f64 {
        self.s * q.x * q.z
    }

    /// The sphere.
    #[constraint]
    pub fn sphere(&self, t: f64, q: Vector3<f64>) -> f64 {
        0.5 * (q.norm_squared() - self.radius(t).powi(2))
    }
}

/// A heavy particle on the unit sphere in a heat bath: friction −ν v and additive noise √(2νT).
#[derive(Clone, Debug)]
pub struct Thermal {
    /// Gravity.
    pub g: f64,
    /// Friction.
    pub nu: f64,
    /// Temperature.
    pub temperature: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Thermal {
    /// L.
    pub fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    /// F.
    #[force]
    pub fn friction(&self, _q: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {
        v * -self.nu
    }

    /// γ of three processes.
    #[gamma]
    pub fn bath(&self, q: Vector3<f64>) -> Vector3<f64> {
        q * (2.0 * self.nu * self.temperature).sqrt()
    }

    /// The unit sphere.
    #[constraint]
    pub fn sphere(&self, q: Vector3<f64>) -> f64 {
        0.5 * (q.norm_squared() - 1.0)
    }
}
