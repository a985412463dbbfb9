//! Methods and operators of vectors, single and in arrays.

use sve_models::language::check;
use sve_runtime::nalgebra as na;
use sve_runtime::nalgebra::Vector3;
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
