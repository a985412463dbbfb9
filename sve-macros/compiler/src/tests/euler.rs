//! Increments of Euler's method: the systems that have them, and the increments that are stepped in
//! lanes.

use crate::tests::expand_members;

#[test]
fn increments_are_written_where_the_velocity_is_a_formula_or_solved_for() {
    let plain = "fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q.cos() }";
    assert!(
        expand_members("midpoint", plain)
            .to_string()
            .contains("fn euler_increment (")
    );
    let relativistic =
        "fn lagrangian(&self, q: f64, v: f64) -> f64 { -(1.0 - v * v).sqrt() - q * q }";
    let code = expand_members("midpoint", relativistic).to_string();
    assert!(!code.contains("fn euler_increment") && code.contains("type EulerNumbers = () ;"));
}

#[test]
fn long_increments_are_not_stepped_in_lanes() {
    let short = "fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q.cos() }";
    let code = expand_members("midpoint", short).to_string();
    assert!(code.contains("fn euler_increment_in_lane"), "{code}");
    assert!(code.contains("EULER_STAGES_IN_LANES"), "{code}");
    // five functions of different angles
    let long = "fn lagrangian(&self, q: f64, v: f64) -> f64 {
        let waves: f64 = (1..6).map(|k| (k as f64 * q).cos()).sum();
        0.5 * v * v + waves
    }";
    let code = expand_members("midpoint", long).to_string();
    assert!(code.contains("fn euler_increment (") && !code.contains("fn euler_increment_in_lane"));
}
