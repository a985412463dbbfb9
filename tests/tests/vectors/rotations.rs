//! Rotations of the plane and of space.

use sve_models::language::check;
use sve_runtime::nalgebra::{Rotation2, Rotation3, Unit, Vector3};
use sve_runtime::prelude::*;

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
