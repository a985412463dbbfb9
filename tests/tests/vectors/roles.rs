//! Noises, forces and symmetries that take and return vectors.

use sve_models::language::{check, close};
use sve_runtime::nalgebra::{SVector, Vector2, Vector3, Vector4};
use sve_runtime::prelude::*;
use sve_runtime::system::System;

/// Vectors of any length; noises, a force and a symmetry in vectors.
struct Chain {
    stiffness: f64,
    drag: f64,
    kick: Vector4<f64>,
}

#[variational(midpoint)]
impl Chain {
    const N: usize = 4;

    fn lagrangian(&self, q: SVector<f64, { Self::N }>, v: SVector<f64, 4>) -> f64 {
        0.5 * v.dot(&v) - self.stiffness * Self::stretch(&q).fold(0.0, |sum, x| sum + x * x)
    }

    fn stretch<const K: usize>(x: &SVector<f64, K>) -> SVector<f64, K> {
        let mut differences = *x;
        for i in 0..K {
            differences[i] = x[(i + 1) % K] - x[i];
        }
        differences
    }

    #[gamma]
    fn shake(&self, q: Vector4<f64>) -> Vector2<f64> {
        Vector2::new(self.kick.dot(&q), q.norm())
    }

    #[h1]
    fn jitter(&self, q: Vector4<f64>, p: Vector4<f64>) -> f64 {
        (q + p).norm_squared().ln()
    }

    #[force]
    fn damping(&self, _q: Vector4<f64>, v: Vector4<f64>) -> Vector4<f64> {
        -self.drag * v
    }
}

#[test]
fn noises_and_forces_are_those_of_the_users_functions() {
    let system = Chain {
        stiffness: 0.8,
        drag: 0.3,
        kick: Vector4::new(1.0, 0.5, -2.0, 0.1),
    };
    check(&system, |_, q, v| {
        system.lagrangian(Vector4::from(*q), Vector4::from(*v))
    });
    let (q, p) = ([0.3, -0.7, 1.1, 0.4], [1.5, 0.2, -0.6, 0.9]);
    let (qs, ps) = (Vector4::from(q), Vector4::from(p));
    let [first, second, third] = system.noise_jets(0.0, &q, &p);
    let force = system.force_jet(0.0, &q, &p);
    let expected = system.damping(qs, ps);
    for i in 0..4 {
        close("gamma by q", first.dq[i], -system.kick[i], 1e-14);
        close("norm by q", second.dq[i], -q[i] / qs.norm(), 1e-14);
        let expected_slope = 2.0 * (q[i] + p[i]) / (qs + ps).norm_squared();
        close("h1 by p", third.dp[i], expected_slope, 1e-13);
        close("force", force.value[i], expected[i], 1e-14);
    }
}

/// A central field: rotations about z leave it unchanged.
struct Central {
    strength: f64,
}

#[variational(midpoint)]
impl Central {
    fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() + self.strength / q.norm()
    }

    #[symmetry]
    fn about_z(&self, q: Vector3<f64>) -> Vector3<f64> {
        Vector3::z().cross(&q)
    }
}

#[test]
fn symmetries_are_found_in_vectors() {
    let system = Central { strength: 1.3 };
    check(&system, |_, q, v| {
        system.lagrangian(Vector3::from(*q), Vector3::from(*v))
    });
    let q = Vector3::new(1.0, 2.0, 3.0);
    assert_eq!(system.about_z(q), Vector3::new(-2.0, 1.0, 0.0));
}
