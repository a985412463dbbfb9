//! States at which tests begin.

use sve_runtime::prelude::*;

pub(crate) fn attitude(roll: f64, pitch: f64, yaw: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(roll, pitch, yaw)
}

pub(crate) fn body() -> State<UnitQuaternion<f64>> {
    State::new(attitude(0.4, -0.7, 1.1), Vector3::new(0.7, 1.1, -0.4))
}

pub(crate) fn pair() -> State<(Vector3<f64>, UnitQuaternion<f64>)> {
    let State { q, p, .. } = body();
    let (at, push) = (Vector3::new(0.5, -0.3, 0.2), Vector3::new(-0.2, 0.4, 0.6));
    State::new((at, q), (push, p))
}

pub(crate) fn three() -> State<[UnitQuaternion<f64>; 3]> {
    let q = [
        attitude(0.4, -0.7, 1.1),
        attitude(-0.2, 0.5, 0.3),
        attitude(1.4, 0.1, -0.6),
    ];
    let p = [
        Vector3::new(0.7, 1.1, -0.4),
        Vector3::new(-0.3, 0.2, 0.9),
        Vector3::new(0.5, -0.8, 0.1),
    ];
    State::new(q, p)
}
