//! The language of a body with vectors, matrices and rotations of nalgebra: the derived value is the user's own function, the
//! derived derivatives are its differences.

// bodies may have references and copies wherever nalgebra takes them
#![allow(clippy::op_ref, clippy::clone_on_copy, clippy::needless_borrow)]

use sve_models::language::{check, close};
use sve_runtime::System;
use sve_runtime::nalgebra as na;
use sve_runtime::nalgebra::{
    Matrix2, Matrix2x3, Matrix3, Matrix3x2, Rotation2, Rotation3, SMatrix, SVector, Unit, Vector2,
    Vector3, Vector4,
};
use sve_runtime::prelude::*;

/// A constant from outside the block.
const WIND: Vector3<f64> = Vector3::new(0.3, 0.2, 0.5);

/// Methods and operators of vectors, and parameters whose types their uses say.
struct Vectors {
    k: f64,
    gravity: Vector3<f64>,
    anchors: [Vector3<f64>; 2],
    body: Body,
}

struct Body {
    mass: f64,
    centre: Vector3<f64>,
}

#[variational(midpoint)]
impl Vectors {
    const AXIS: Vector3<f64> = Vector3::new(0.5, -1.5, 2.0);

    fn lagrangian(&self, t: f64, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * self.body.mass * v.norm_squared() + self.arithmetic(&q, &v) + self.products(q, v)
            - self.assignments(q, v) * t
            + Self::entries(&q, &v)
            + self.parameters(q, v)
            + Self::closures(q, v)
    }

    fn arithmetic(&self, q: &Vector3<f64>, v: &Vector3<f64>) -> f64 {
        let a = q + v * 2.0 - self.k * (q - v) / 3.0;
        let b = -(&a + *q) + 0.25 * a.clone();
        (a - &b).norm() + (&b).dot(&a) + a.metric_distance(v)
    }

    fn products(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        let l = q.cross(&v) + q.cross_matrix() * v.map(f64::sin);
        let unit = (q + Self::AXIS).normalize();
        let outer = q * v.transpose();
        l.magnitude_squared()
            + unit.dot(&v)
            + (outer * unit).sum()
            + outer.trace()
            + q.component_mul(&v).component_div(&(q + WIND)).mean()
            + q.xy().perp(&v.yz())
            + v.xyz().product()
            + q.tr_mul(&v)[(0, 0)]
            + q.lerp(&v, 0.3)
                .scale(2.0)
                .unscale(self.k)
                .add_scalar(0.5)
                .norm()
    }

    fn assignments(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        let mut a = q;
        a += v;
        a -= self.gravity;
        a *= self.k;
        a /= 1.0 + q.x * q.x;
        a.x = a.y * v.z;
        a[2] += a.x;
        for entry in a.iter_mut() {
            *entry = *entry * *entry + 1.0;
        }
        let mut both = [a, q];
        both[1].y -= both[0][0];
        for b in &mut both {
            *b *= 0.5;
            b.z += 0.25;
        }
        both[0].dot(&both[1])
    }

    fn entries(q: &Vector3<f64>, v: &Vector3<f64>) -> f64 {
        let mut sum = 0.0;
        for i in 0..q.len() {
            sum += q[i] * v[(i + 1) % 3] * (q[(i, 0)] + 1.0);
        }
        for (x, y) in q.iter().zip(v.iter()) {
            sum += x.sin() * y;
        }
        for x in q {
            sum += x.powi(3);
        }
        let [x, y, z]: [f64; 3] = (*q).into();
        let back = Vector3::from([z, y, x]);
        let again: Vector3<f64> = [x, y, z].into();
        sum + back.dot(v) + again.x * q.fixed_rows::<2>(1).norm_squared() + v.rows(0, 2).norm()
    }

    /// The types of the fields are not written: they follow from the other operand or argument.
    fn parameters(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        let lever = q - self.body.centre;
        let Self { gravity, .. } = self;
        let mut sum = self.body.mass * q.dot(&self.gravity) + gravity.cross(&v).dot(&lever);
        for anchor in self.anchors.iter().zip(&[q, v]) {
            sum += (anchor.0 - anchor.1).norm_squared();
        }
        let named: Vector3<f64> = self.gravity;
        let anchors: [Vector3<f64>; 2] = self.anchors;
        for anchor in &anchors {
            sum += (q - anchor).norm().ln() * named.norm();
        }
        sum + self.gravity.z * q.z
            + self.anchors[1][0] * self.length(self.body.centre)
            + self.pull().dot(&q)
    }

    fn length(&self, x: Vector3<f64>) -> f64 {
        x.norm() + x.z
    }

    fn pull(&self) -> Vector3<f64> {
        self.gravity
    }

    fn closures(q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        let energy = |a: &Vector3<f64>, b: Vector3<f64>| a.dot(&b) + b.norm();
        let squares = q.map(|x| x * x);
        energy(&squares, v)
            + q.zip_map(&v, |a, b| a.exp() * b).sum()
            + q.fold(1.0, |product, x| product * x.cos())
            + q.iter().map(|x| x.tanh()).sum::<f64>()
    }
}

#[test]
fn vectors_have_the_derivatives_of_the_users_functions() {
    let system = Vectors {
        k: 1.7,
        gravity: Vector3::new(0.1, -0.3, -9.8),
        anchors: [Vector3::new(2.0, 1.0, -1.0), Vector3::new(-1.0, 0.5, 3.0)],
        body: Body {
            mass: 2.5,
            centre: Vector3::new(0.2, 0.1, -0.4),
        },
    };
    check(&system, |t, q, v| {
        system.lagrangian(t, Vector3::from(*q), Vector3::from(*v))
    });
}

/// Matrices: construction, parts, products, and parameters whose types are written.
struct Matrices {
    inertia: Matrix2<f64>,
    coupling: SMatrix<f64, 2, 3>,
    stiffness: [[f64; 2]; 2],
    scale: f64,
}

#[variational(midpoint)]
impl Matrices {
    const SHEAR: Matrix2<f64> = Matrix2::new(1.0, 0.5, -0.25, 2.0);

    fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        let inertia: Matrix2<f64> = self.inertia;
        let mass = inertia + Self::metric(&q) * self.scale;
        0.5 * v.dot(&(mass * v)) + self.made(q, v) + self.taken_apart(q, v)
            - mass.determinant() / mass.trace()
            + (v.transpose() * self.inertia() * q)[(0, 0)]
            + self.inertia[(0, 1)] * q.x
    }

    fn inertia(&self) -> Matrix2<f64> {
        self.inertia
    }

    fn metric(q: &Vector2<f64>) -> Matrix2<f64> {
        Matrix2::identity() + q * q.transpose() + Matrix2::from_diagonal(&q.map(|x| x * x))
    }

    fn made(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        let (a, b) = (q.x, v.y);
        let wide = Matrix2x3::new(a, b, 1.0, 2.0, a * b, 3.0);
        let tall = Matrix3x2::from_columns(&[Vector3::new(a, b, 1.0), Vector3::repeat(b)]);
        let stacked = Matrix2::from_rows(&[q.transpose(), v.transpose()]);
        let rows = Matrix2::from_row_slice(&[a, b, 1.0, 2.0]);
        let columns = Matrix2::from_column_slice(&[a, b, 1.0, 2.0]);
        let nested = Matrix2::from([[a, b], [1.0, 2.0]]);
        let stiffness = Matrix2::from(self.stiffness);
        let computed = SMatrix::<f64, 2, 2>::from_fn(|i, j| (i as f64 + 1.0) * a + j as f64 * b);
        let coupling: SMatrix<f64, 2, 3> = self.coupling;
        (wide * tall).determinant()
            + stacked.norm()
            + (rows * columns - nested).component_mul(&stiffness).sum()
            + (computed * Self::SHEAR * 0.5)[(1, 0)]
            + (coupling * tall).trace()
            + (na::Matrix3::from_diagonal_element(a) * Matrix3::identity()).determinant()
    }

    fn taken_apart(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        let mut m = Matrix3::new(q.x, q.y, 1.0, v.x, v.y, 2.0, q.x * v.y, 0.5, q.y * v.x);
        m[(0, 2)] += m.m21;
        m[1] *= 2.0;
        m.m33 = m[(0, 0)] - m[7];
        let mut sum = m.determinant() + m.transpose().diagonal().norm_squared();
        for column in m.column_iter() {
            sum += column.norm();
        }
        for row in m.row_iter() {
            sum -= row[0] * row[2];
        }
        for (i, x) in m.iter().enumerate() {
            sum += x * i as f64;
        }
        let block = m.fixed_view::<2, 2>(1, 0);
        let big = SMatrix::<f64, 4, 4>::from_fn(|i, j| {
            if i == j {
                1.0 + q.x
            } else {
                q.y / (i + j) as f64
            }
        });
        sum + (block * v).dot(&q) + m.row(1).dot(&m.column(2).transpose()) + big.determinant()
    }
}

#[test]
fn matrices_have_the_derivatives_of_the_users_functions() {
    let system = Matrices {
        inertia: Matrix2::new(2.0, 0.3, 0.3, 1.5),
        coupling: Matrix2x3::new(0.5, 1.0, -1.0, 2.0, 0.25, 0.75),
        stiffness: [[1.0, -0.5], [0.25, 3.0]],
        scale: 0.7,
    };
    check(&system, |_, q, v| {
        system.lagrangian(Vector2::from(*q), Vector2::from(*v))
    });
}

/// Rotations by angles that depend on the state.
struct Turned {
    axis: Unit<Vector3<f64>>,
    mount: Rotation3<f64>,
    lever: Vector3<f64>,
}

#[variational(midpoint)]
impl Turned {
    fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        let mount: Rotation3<f64> = self.mount;
        let axis: &Unit<Vector3<f64>> = &self.axis;
        let lever: Vector3<f64> = self.lever;
        let attitude = Rotation3::from_euler_angles(q.x, q.y, q.z);
        let about = Rotation3::from_axis_angle(&Vector3::y_axis(), q.y)
            * Rotation3::from_axis_angle(axis, q.x * q.z);
        let tilted = Rotation3::from_axis_angle(&Unit::new_normalize(q + lever), 0.3 + q.z);
        let plane = Rotation2::new(q.x - q.y);
        let tip = attitude * lever + about.inverse() * v;
        0.5 * v.norm_squared()
            + tip.norm()
            + (mount * tip).dot(&attitude.transform_vector(&v))
            + (tilted.transpose() * self.lever()).x
            + (plane * v.xy()).dot(&plane.inverse_transform_vector(&q.yz()))
            + (attitude * mount).matrix().trace()
            + attitude[(2, 1)]
            + axis.dot(&q)
            + (about.into_inner() * lever).sum()
    }

    fn lever(&self) -> Vector3<f64> {
        self.lever
    }
}

#[test]
fn rotations_have_the_derivatives_of_the_users_functions() {
    let system = Turned {
        axis: Unit::new_normalize(Vector3::new(1.0, 2.0, -0.5)),
        mount: Rotation3::from_euler_angles(0.2, -0.4, 1.1),
        lever: Vector3::new(1.5, 0.3, -0.6),
    };
    check(&system, |_, q, v| {
        system.lagrangian(Vector3::from(*q), Vector3::from(*v))
    });
}

/// Arrays of vectors: three bodies that attract one another.
struct Cluster {
    masses: [f64; 3],
    field: Vector3<f64>,
}

#[variational(midpoint)]
impl Cluster {
    const BODIES: usize = 3;

    fn lagrangian(&self, q: [Vector3<f64>; Self::BODIES], v: [na::Vector3<f64>; 3]) -> f64 {
        let mut l = 0.0;
        for (m, v) in self.masses.iter().zip(&v) {
            l += 0.5 * m * v.norm_squared();
        }
        for i in 0..3 {
            for j in 0..i {
                l += self.masses[i] * self.masses[j] / (q[i] - q[j]).norm_squared().hypot(0.3);
            }
        }
        let centre = q.iter().sum::<Vector3<f64>>() / 3.0;
        let momentum = v.iter().fold(Vector3::zeros(), |sum, v| sum + v);
        let spread: f64 = q.iter().map(|x| (x - centre).norm_squared()).sum();
        let shifted = q.map(|x| x - centre);
        l + self.field.dot(&centre) * momentum.norm() + spread * Self::closest(&shifted)
    }

    fn closest(q: &[Vector3<f64>; 3]) -> f64 {
        let [a, b, c] = q;
        a.dot(b) + b.dot(c)
    }
}

#[test]
fn arrays_of_vectors_have_the_derivatives_of_the_users_functions() {
    let system = Cluster {
        masses: [1.0, 2.0, 0.5],
        field: Vector3::new(0.3, 1.0, -2.0),
    };
    let bodies = |x: &[f64; 9]| {
        let [a, b, c] = [0, 3, 6].map(|i| Vector3::new(x[i], x[i + 1], x[i + 2]));
        [a, b, c]
    };
    check(&system, |_, q, v| system.lagrangian(bodies(q), bodies(v)));
}

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
