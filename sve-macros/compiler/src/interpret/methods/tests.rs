//! Each row of the table is understood for some receiver and arguments.

use super::METHODS;
use crate::tests::expand;

const RECEIVERS: [&str; 10] = [
    "q[0]", "q", "q.iter()", "[q, q]", "d", "one", "w", "m", "r", "u",
];

/// The same in a scene, whose coordinates are slices.
const RECEIVERS_OF_SCENES: [&str; 2] = ["q", "q.iter()"];

const ARGUMENTS: [&str; 14] = [
    "",
    "0.5",
    "1",
    "0, 1",
    "0.5, 2.0",
    "&w",
    "&d",
    "&w, 0.5",
    "q.iter()",
    "|x| ()",
    "|x| true",
    "&w, |a, b| a * b",
    "|x| [x, x]",
    "0.0, |a, b| a + b",
];

/// Returns whether a body of a scene has no mistake except in its last line.
fn is_understood_in_scene(body: &str) -> bool {
    has_one_mistake(
        "endpoint",
        &format!(
            "impl P {{ fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {{ let value = {body}; unknown }} }}"
        ),
    )
}

/// Returns whether a body has no mistake except in its last line.
fn is_understood(body: &str) -> bool {
    let item = format!(
        "impl P {{ fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {{
            let (d, w) = (Vector2::new(q[0], 1.0), Vector3::new(q[0], q[1], 2.0));
            let (m, u) = (w * w.transpose(), Vector3::z_axis());
            let r = Rotation3::from_axis_angle(&u, q[0]);
            let one = d.transpose() * d;
            let value = {body};
            unknown
        }} }}"
    );
    has_one_mistake("midpoint", &item)
}

/// Returns whether the unknown name in a block is its only mistake.
fn has_one_mistake(attribute: &str, item: &str) -> bool {
    let [attribute, item] = [attribute, item].map(|text| text.parse().expect("tokens"));
    let expansion = expand(&attribute, &item).to_string();
    assert!(
        expansion.contains("`unknown` is not known here"),
        "{expansion}"
    );
    expansion.matches("compile_error").count() == 1
}

#[test]
fn each_method_of_the_table_is_understood() {
    let names = METHODS.iter().flat_map(|method| method.names.split(' '));
    for name in names.chain(["sin", "atan2", "powi", "sin_cos"]) {
        let generics = match name {
            "fixed_view" => "::<1, 1>",
            name if name.starts_with("fixed_") => "::<1>",
            _ => "",
        };
        let is_row = |receivers: &[&str], is_understood: &dyn Fn(&str) -> bool| {
            receivers.iter().any(|receiver| {
                let of = |arguments: &&str| format!("{receiver}.{name}{generics}({arguments})");
                ARGUMENTS
                    .iter()
                    .any(|arguments| is_understood(&of(arguments)))
            })
        };
        assert!(
            is_row(&RECEIVERS, &is_understood)
                || is_row(&RECEIVERS_OF_SCENES, &is_understood_in_scene),
            "{name}"
        );
    }
}
