//! Sizes, increments and stored forms of states.

use sve_runtime::__private::Coordinates;
use sve_runtime::Configuration;
use sve_runtime::prelude::*;

use crate::{START, Six, every_type};

#[test]
fn sizes_storage_and_increments() {
    fn check<Q: Six>() {
        let mut q: Q = Q::from_coordinates(&START.q);
        assert_eq!([q.degrees_of_freedom(), q.stored_values()], [6, 6]);
        assert_eq!([Q::DEGREES_OF_FREEDOM, Q::STORED_VALUES], [6, 6]);
        let mut values = [f64::NAN; 6];
        q.store(&mut values);
        assert_eq!(values, START.q);
        let increment = [1.0, -0.5, 0.25, 1e-3, 7.0, 0.0];
        q.retract(&increment);
        let moved: [f64; 6] = std::array::from_fn(|i| START.q[i] + increment[i]);
        assert_eq!(q.coordinates(), moved);
        q.restore(&START.q);
        assert_eq!(q, Q::from_coordinates(&START.q));
        assert_eq!(Q::origin().coordinates(), [0.0; 6]);
    }
    every_type!(check);
    let rows = [[1.0, 2.0], [3.0, 4.0]];
    assert_eq!(Coordinates::<4>::coordinates(&rows), [1.0, 2.0, 3.0, 4.0]);
    let vectors = [Vector2::new(1.0, 2.0), Vector2::new(3.0, 4.0)];
    assert_eq!(
        Coordinates::<4>::coordinates(&vectors),
        [1.0, 2.0, 3.0, 4.0]
    );
}

#[test]
#[should_panic(expected = "an increment of another length")]
fn an_increment_of_another_length_is_refused() {
    Vector3::zeros().retract(&[1.0, 2.0]);
}

#[test]
#[should_panic(expected = "an increment longer than the degrees of freedom")]
fn an_increment_that_is_too_long_for_the_bodies_is_refused() {
    [[0.0; 2]; 2].retract(&[0.0; 5]);
}

#[test]
fn states_are_stored_as_a_row_of_numbers() {
    let vectors = State::at(
        0.5,
        [Vector2::new(1.0, f64::NAN), Vector2::new(0.1, 2.0)],
        [Vector2::zeros(), Vector2::new(f64::NEG_INFINITY, 3.0)],
    );
    let text = serde_json::to_string(&vectors).unwrap();
    assert_eq!(
        text,
        r#"{"t":0.5,"q":[1.0,"NaN",0.1,2.0],"p":[0.0,0.0,"-inf",3.0]}"#
    );
    let back: State<[Vector2<f64>; 2]> = serde_json::from_str(&text).unwrap();
    assert_eq!((back.q[1], back.p), (vectors.q[1], vectors.p));
    let rows: State<[f64; 4]> = serde_json::from_str(&text).unwrap();
    assert_eq!(rows.p, [0.0, 0.0, f64::NEG_INFINITY, 3.0]);
    assert!(serde_json::from_str::<State<[Vector3<f64>; 2]>>(&text).is_err());
    assert!(serde_json::from_str::<State<Vector3<f64>>>(&text).is_err());
}
