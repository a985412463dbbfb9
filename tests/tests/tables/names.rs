//! Columns have the names that the Lagrangian gives the coordinates.

use sve_models::models::Kubo;
use sve_runtime::StateTable;
use sve_runtime::prelude::*;
use sve_runtime::system::System;

/// Declares a system with this L, and checks the names of its coordinates and momenta.
macro_rules! check_names {
    ($($name:ident ($($rule:tt)*): fn lagrangian(&self, $($argument:pat => $type:ty),*) $body:block, [$($q:literal),*], [$($p:literal),*];)*) => {
        $(
            mod $name {
                use sve_runtime::prelude::*;
                pub(super) struct Names;

                #[variational($($rule)*)]
                impl Names {
                    fn lagrangian(&self, $($argument: $type),*) -> f64 $body
                }
            }
        )*

        #[test]
        fn names_are_those_of_the_lagrangian() {
            $(
                let names: [&[&str]; 2] = [&[$($q),*], &[$($p),*]];
                let [coordinates, momenta] = names;
                assert_eq!($name::Names::COORDINATES, coordinates, stringify!($name));
                assert_eq!($name::Names::MOMENTA, momenta, stringify!($name));
            )*
        }
    };
}

check_names! {
    number (midpoint): fn lagrangian(&self, q => f64, v => f64) { 0.5 * v * v - q * q }, ["q"], ["p"];
    angle (midpoint): fn lagrangian(&self, theta => f64, v => f64) { 0.5 * v * v + theta.cos() }, ["theta"], ["p_theta"];
    unused (midpoint): fn lagrangian(&self, _q => f64, v => f64) { 0.5 * v * v }, ["q"], ["p"];
    nameless (midpoint): fn lagrangian(&self, _ => f64, v => f64) { 0.5 * v * v }, ["q"], ["p"];
    row (midpoint): fn lagrangian(&self, q => [f64; 2], v => [f64; 2]) { 0.5 * (v[0] * v[0] + v[1] * v[1]) - q[0] * q[0] }, ["q[0]", "q[1]"], ["p[0]", "p[1]"];
    taken_apart (midpoint): fn lagrangian(&self, q => [f64; 2], v => [f64; 2]) {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - x * x - y * y
    }, ["x", "y"], ["p_x", "p_y"];
    in_the_signature (midpoint): fn lagrangian(&self, [x, y] => [f64; 2], [a, b] => [f64; 2]) { 0.5 * (a * a + b * b) - x * x - y * y }, ["x", "y"], ["p_x", "p_y"];
    partly (midpoint): fn lagrangian(&self, q => [f64; 2], v => [f64; 2]) {
        let [x, _] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - x * x
    }, ["q[0]", "q[1]"], ["p[0]", "p[1]"];
    like_the_time (midpoint): fn lagrangian(&self, q => [f64; 2], v => [f64; 2]) {
        let [t, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - t * y
    }, ["q[0]", "q[1]"], ["p[0]", "p[1]"];
    bodies (midpoint): fn lagrangian(&self, q => [[f64; 2]; 2], v => [[f64; 2]; 2]) {
        let [sun, moon] = q;
        0.5 * (v[0][0] * v[0][0] + v[0][1] * v[0][1] + v[1][0] * v[1][0] + v[1][1] * v[1][1]) - sun[0] * moon[1]
    }, ["sun[0]", "sun[1]", "moon[0]", "moon[1]"], ["p_sun[0]", "p_sun[1]", "p_moon[0]", "p_moon[1]"];
    vectors (midpoint): fn lagrangian(&self, q => [Vector2<f64>; 2], v => [Vector2<f64>; 2]) {
        0.5 * (v[0].norm_squared() + v[1].norm_squared()) - q[0].dot(&q[1])
    }, ["q[0].x", "q[0].y", "q[1].x", "q[1].y"], ["p[0].x", "p[0].y", "p[1].x", "p[1].y"];
    many (midpoint): fn lagrangian(&self, q => SVector<f64, 7>, v => SVector<f64, 7>) { 0.5 * v.norm_squared() - q.norm_squared() },
        ["q[0]", "q[1]", "q[2]", "q[3]", "q[4]", "q[5]", "q[6]"], ["p[0]", "p[1]", "p[2]", "p[3]", "p[4]", "p[5]", "p[6]"];
    body (midpoint): fn lagrangian(&self, q => Vector2<f64>, _r => Rotation3<f64>, v => Vector2<f64>, w => Vector3<f64>) {
        0.5 * v.norm_squared() + 0.5 * w.norm_squared() - q.y
    }, ["q.x", "q.y", "r.w", "r.i", "r.j", "r.k"], ["p.x", "p.y", "pi.x", "pi.y", "pi.z"];
    reduced (midpoint, reduced): fn lagrangian(&self, w => Vector3<f64>) { 0.5 * w.norm_squared() }, [], ["pi.x", "pi.y", "pi.z"];
}

#[test]
fn a_table_has_a_column_for_each_number_of_a_state() -> Result<(), StepError> {
    let body = Integrator::new(body::Names, Midpoint);
    let start = State::new(
        (Vector2::new(0.5, 1.5), UnitQuaternion::identity()),
        (Vector2::new(2.5, 3.5), Vector3::new(4.0, 5.0, 6.0)),
    );
    let states = body.trajectory(start, 0.1, NoNoise).every(3).take(2);
    let table = StateTable::of(body.system(), states)?;
    let names: Vec<&str> = table.names().collect();
    assert_eq!(names.len(), 1 + 6 + 5);
    let first: Vec<f64> = names
        .iter()
        .map(|name| table.get(name).unwrap()[0])
        .collect();
    assert_eq!(
        first,
        [0.0, 0.5, 1.5, 1.0, 0.0, 0.0, 0.0, 2.5, 3.5, 4.0, 5.0, 6.0]
    );
    assert_eq!(table.get("t"), Some(&[0.0, 0.3][..]));
    assert_eq!(table.get("v"), None);
    // a borrowed system has the same names
    assert_eq!(<&Kubo as System>::COORDINATES, Kubo::COORDINATES);
    let table = table.with(body.system(), "energy", |system, state| {
        system.hamiltonian(state)
    })?;
    assert_eq!(
        table.get("energy").unwrap()[0],
        0.5 * (2.5 * 2.5 + 3.5 * 3.5) + 0.5 * 77.0 + 1.5
    );
    Ok(())
}

#[test]
#[should_panic(expected = "another system")]
fn a_function_of_another_system_is_a_mistake() {
    let table = StateTable::of(&row::Names, []).unwrap();
    let _ = table.with(&taken_apart::Names, "x", |_, state| state.q[0]);
}

#[test]
#[should_panic(expected = "already: give the values another name")]
fn a_second_column_of_a_name_is_a_mistake() {
    let table = StateTable::of(&row::Names, []).unwrap();
    let name = table.names().nth(1).unwrap().to_owned();
    let _ = table.with(&row::Names, name, |_, state| state.q[0]);
}
