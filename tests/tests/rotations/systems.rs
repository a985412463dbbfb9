//! Systems with rotations.

use sve_runtime::prelude::*;

/// Principal moments of inertia.
pub(crate) const I: Vector3<f64> = Vector3::new(1.0, 2.0, 3.0);

pub(crate) const NOISY_BODY: NoisyBody = NoisyBody {
    i: I,
    chi: Vector3::new(0.3, -0.2, 0.5),
    k: Vector3::new(0.5, 0.2, -0.3),
};

pub(crate) const TOP: HeavyTop = HeavyTop {
    i: I,
    weight: 2.0,
    s: 0.5,
};

pub(crate) const SYMMETRIC_TOP: SymmetricTop = SymmetricTop {
    i: I,
    weight: 2.0,
    s: 0.3,
};

pub(crate) const TETHERED: Tethered = Tethered {
    m: 1.5,
    i: I,
    at: Vector3::new(0.3, -0.2, 0.8),
    k: 1.2,
    s: 0.3,
};

pub(crate) const THREE: Three = Three {
    i: I,
    k: 0.7,
    s: 0.3,
};

pub(crate) const DRIVEN: Driven = Driven {
    i: I,
    weight: 2.0,
    nu: 0.4,
    torque: 0.3,
};

/// A free rigid body with the principal moments of inertia `i`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeBody {
    pub(crate) i: Vector3<f64>,
}

#[variational(midpoint, stormer_verlet)]
impl FreeBody {
    pub(crate) fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * w.dot(&self.i.component_mul(&w))
    }
    /// Turns space about an axis.
    #[symmetry]
    pub(crate) fn third_axis(&self, r: Rotation3<f64>) -> Vector3<f64> {
        r.inverse() * Vector3::new(0.0, 0.0, 1.0)
    }
}

/// A rigid body with the noises of the reference steps, `χ·Π` and `½ Σ K Π²`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoisyBody {
    pub(crate) i: Vector3<f64>,
    pub(crate) chi: Vector3<f64>,
    pub(crate) k: Vector3<f64>,
}

#[variational(midpoint, stormer_verlet)]
impl NoisyBody {
    pub(crate) fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * w.dot(&self.i.component_mul(&w))
    }
    #[h1]
    fn kicks(&self, _r: Rotation3<f64>, pi: Vector3<f64>) -> [f64; 2] {
        [self.chi.dot(&pi), 0.5 * pi.dot(&self.k.component_mul(&pi))]
    }
}

/// A heavy top, with noise in the torque of gravity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeavyTop {
    pub(crate) i: Vector3<f64>,
    pub(crate) weight: f64,
    pub(crate) s: f64,
}

#[variational(midpoint, stormer_verlet)]
impl HeavyTop {
    pub(crate) fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        let axis = r * Vector3::z();
        0.5 * w.dot(&self.i.component_mul(&w)) - self.weight * axis.z
    }
    #[gamma]
    fn wind(&self, r: Rotation3<f64>) -> f64 {
        self.s * r[(0, 0)]
    }
}

/// A heavy top without noise, symmetric about its axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SymmetricTop {
    pub(crate) i: Vector3<f64>,
    pub(crate) weight: f64,
    pub(crate) s: f64,
}

#[variational(midpoint, stormer_verlet)]
impl SymmetricTop {
    pub(crate) fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (self.i.x * (w.x * w.x + w.y * w.y) + self.i.z * w.z * w.z)
            - self.weight * r.matrix()[(2, 2)]
    }
    #[gamma]
    fn shaking(&self, r: Rotation3<f64>) -> f64 {
        self.s * r[(2, 2)]
    }
    #[h1]
    fn spin(&self, r: Rotation3<f64>, pi: Vector3<f64>) -> f64 {
        self.s * (r * pi).z * pi.z
    }
    /// Turns space about the vertical.
    #[symmetry]
    pub(crate) fn vertical(&self, r: Rotation3<f64>) -> Vector3<f64> {
        r.transpose() * Vector3::z()
    }
    /// Turns the body about its axis.
    #[symmetry]
    pub(crate) fn figure_axis(&self, _r: Rotation3<f64>) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, 1.0)
    }
}

/// A rigid body in space that is held by a spring at a point of the body, with noise in the force
/// and in the momenta.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tethered {
    pub(crate) m: f64,
    pub(crate) i: Vector3<f64>,
    pub(crate) at: Vector3<f64>,
    pub(crate) k: f64,
    pub(crate) s: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Tethered {
    pub(crate) fn lagrangian(
        &self,
        q: Vector3<f64>,
        r: Rotation3<f64>,
        v: Vector3<f64>,
        w: Vector3<f64>,
    ) -> f64 {
        let at: Vector3<f64> = self.at;
        let end = q + r * at;
        0.5 * self.m * v.norm_squared() + 0.5 * w.dot(&self.i.component_mul(&w))
            - 0.5 * self.k * end.norm_squared()
    }
    #[gamma]
    fn gusts(&self, q: Vector3<f64>, r: Rotation3<f64>) -> f64 {
        self.s * (q.x + q.y * r[(1, 2)])
    }
    #[h1]
    fn kicks(&self, q: Vector3<f64>, r: Rotation3<f64>, p: Vector3<f64>, pi: Vector3<f64>) -> f64 {
        self.s * (r.inverse_transform_vector(&p).dot(&pi) + q.z * pi.x)
    }
}

/// Three bodies whose axes attract each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Three {
    pub(crate) i: Vector3<f64>,
    pub(crate) k: f64,
    pub(crate) s: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Three {
    pub(crate) fn lagrangian(&self, r: [Rotation3<f64>; 3], w: [Vector3<f64>; 3]) -> f64 {
        let mut l = 0.0;
        for b in 0..3 {
            l += 0.5 * w[b].dot(&self.i.component_mul(&w[b]));
            let relative = r[b].inverse() * r[(b + 1) % 3];
            l += self.k * (relative[(2, 2)] + 0.5 * relative[(0, 0)]);
        }
        l
    }
    #[h1]
    fn kicks(&self, r: [Rotation3<f64>; 3], pi: [Vector3<f64>; 3]) -> f64 {
        let relative = r[0].inverse() * r[1];
        self.s * ((r[0] * pi[0]).dot(&(r[1] * pi[1])) + pi[2].z + relative[(2, 2)] * pi[2].x)
    }
    /// Turns all bodies about the first axis of space.
    #[symmetry]
    pub(crate) fn together(&self, r: [Rotation3<f64>; 3]) -> [Vector3<f64>; 3] {
        r.map(|r| r.inverse() * Vector3::x())
    }
}

/// A heavy top with friction and a driving torque.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Driven {
    pub(crate) i: Vector3<f64>,
    pub(crate) weight: f64,
    pub(crate) nu: f64,
    pub(crate) torque: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Driven {
    pub(crate) fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * w.dot(&self.i.component_mul(&w)) - self.weight * r[(2, 2)]
    }
    #[force]
    fn friction(&self, r: Rotation3<f64>, w: Vector3<f64>) -> Vector3<f64> {
        -self.nu * w + self.torque * (r.inverse() * Vector3::x())
    }
}
