//! Limits of work and size. A system within the limits is accepted, a larger one is one error that
//! names the limit. The limit may be reached at any place.

use crate::Settings;
use crate::driver::expand_within;
use crate::tests::robustness::{SYSTEMS, expanded};
use crate::tests::{expand_members, rows, tokens};

/// Returns a block of particles with a term in L.
fn system(n: usize, body: &str) -> String {
    format!(
        "fn lagrangian(&self, q: [f64; {n}], v: [f64; {n}]) -> f64 {{ let mut s: f64 = v.iter().zip(&self.m).map(|(v, m)| 0.5 * m * v * v).sum(); {body} }}"
    )
}

/// Returns the helpers `f0` to `f39`, each of which calls the previous one three times.
fn doubling() -> String {
    let mut helpers = vec!["fn f0(&self, x: f64) -> f64 { x.sin() * x }".to_owned()];
    helpers.extend((1..40).map(|i| {
        let f = i - 1;
        format!("fn f{i}(&self, x: f64) -> f64 {{ self.f{f}(x + {i}.0) * self.f{f}(x) + self.f{f}(x * x) }}")
    }));
    helpers.join(" ")
}

/// Returns a block of free particles with many noises.
fn noises(n: usize, m: usize) -> String {
    format!(
        "{} #[h1] fn noise(&self, q: [f64; {n}], p: [f64; {n}]) -> [f64; {m}] {{ let mut a = [0.0; {m}]; for i in 0..{m} {{ a[i] = (q[i % {n}] * (i as f64 + 1.0)).sin() * p[(i + 1) % {n}]; }} a }}",
        system(n, "s")
    )
}

/// Returns systems whose derivatives are far larger than the systems: helpers that double, dense
/// couplings, products of long sums, high powers, many noises.
fn large_systems() -> Vec<(&'static str, String)> {
    let of_row = |[rule, n, body]: [&'static str; 3]| (rule, system(n.parse().expect("n"), body));
    let mut systems: Vec<_> = rows(LARGE).into_iter().map(of_row).collect();
    for body in ["s - self.f39(q[0])", "s - self.f8(q[0] + q[1])"] {
        systems.push(("midpoint", format!("{} {}", system(2, body), doubling())));
    }
    systems.extend([("endpoint", noises(4, 64)), ("endpoint", noises(64, 64))]);
    systems
}

/// Rules, numbers of coordinates, and terms.
const LARGE: &str = "
midpoint → 512 → for i in 1..512 { s -= (q[i] - q[i - 1]).cos(); } s
midpoint → 512 → s - q.iter().sum::<f64>().sin()
midpoint → 6 → let mut p = 1.0; for k in 0..100 { let mut t = 1.0; for i in 0..6 { t += self.a[6 * k + i] * q[i]; } p *= t; } s - p
midpoint → 40 → let mut p = 1.0; for k in 0..40 { p *= (1.0 + q[k] * v[k]).sin(); } s - p
midpoint → 2 → let mut x = q[0]; for i in 0..3000 { x = x.sin() * x + v[0]; } s + x
midpoint → 8 → let mut x = q; for k in 0..200 { for i in 0..8 { x[i] = x[i].sin() + x[(i + 1) % 8] * x[(i + 3) % 8]; } } s - x[0]
taylor2 → 24 → let x: f64 = q.iter().zip(v).map(|(a, b)| a * b).sum(); s - x.sin()
midpoint → 3 → for i in 0..3 { for j in 0..1_000_000_000 { s += q[i]; } } s
";

#[test]
fn large_systems_are_one_error_with_a_limit() {
    for (attribute, members) in large_systems() {
        let output = expand_members(attribute, &members).to_string();
        assert_eq!(output.matches("compile_error").count(), 1, "{members}");
        assert!(output.contains("limit"), "{members}");
    }
}

const RULES: [&str; 5] = [
    "initial_point",
    "endpoint",
    "midpoint",
    "stormer_verlet",
    "gauss(2)",
];

/// Returns the rules that an error of size says to be within the limit.
fn named(error: &str) -> Vec<String> {
    let Some((_, after)) = error.split_once("which is the limit; ") else {
        return Vec::new();
    };
    let names = after.split(';').next().unwrap_or_default();
    let is_named = |rule: &&str| names.contains(&format!("`{rule}`"));
    let rules = RULES.into_iter().filter(is_named);
    rules.map(ToOwned::to_owned).collect()
}

/// An error of size names exactly the rules that a system of this size may have.
#[test]
fn an_error_of_size_names_the_rules_that_fit() {
    let bodies = system(
        6,
        "for i in 0..6 { for j in 0..i { s -= 1.0 / (1.0 + (q[i] - q[j]).powi(2)).sqrt(); } } s",
    );
    let pendulum = system(
        4,
        "for i in 0..4 { s += q[i].cos(); for j in 0..i { s += v[i] * v[j] * (q[i] - q[j]).cos(); } } s",
    );
    let mut claims = 0;
    for members in [bodies, pendulum] {
        let item = tokens(&format!("impl P {{ {members} }}"));
        for work in [20_000, 50_000, 100_000, 200_000, 400_000, 800_000] {
            let outputs = RULES.map(|rule| {
                let output = expand_within(&tokens(rule), &item, Settings::default(), work);
                (rule, output.to_string())
            });
            let (refused, accepted): (Vec<_>, Vec<_>) = outputs
                .into_iter()
                .partition(|(_, text)| text.contains("compile_error"));
            let fit: Vec<&str> = accepted.iter().map(|(rule, _)| *rule).collect();
            for (rule, text) in refused {
                assert_eq!(named(&text), fit, "{rule} {work}");
                claims += usize::from(!fit.is_empty());
            }
        }
    }
    assert!(claims > 4, "{claims}");
}

/// Bodies in the plane are a case of `growth::limits_are_those_of_the_documentation`.
#[test]
fn systems_of_48_coordinates_are_accepted() {
    let chain = "fn lagrangian(&self, q: [f64; 48], v: [f64; 48]) -> f64 {
        let mut s: f64 = v.iter().zip(&self.m).map(|(v, m)| 0.5 * m * v * v).sum();
        for i in 1..48 { s -= self.k * (q[i] - q[i - 1]).powi(4) + (q[i] - q[i - 1]).cos(); }
        s
    }";
    let in_space = "fn lagrangian(&self, q: [[f64; 3]; 16], v: [[f64; 3]; 16]) -> f64 {
        let mut s = 0.0;
        for i in 0..16 {
            s += 0.5 * self.m[i] * (v[i][0].powi(2) + v[i][1].powi(2) + v[i][2].powi(2));
            for j in 0..i {
                let (x, y, z) = (q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]);
                let s6 = (x * x + y * y + z * z).powi(-3);
                s -= self.m[j] * (s6 * s6 - s6);
            }
        }
        s
    }";
    for (attribute, members) in [
        ("initial_point, endpoint, midpoint, taylor2", chain),
        ("stormer_verlet", in_space),
    ] {
        let output = expand_members(attribute, members).to_string();
        assert!(!output.contains("compile_error"), "{members}");
    }
}

/// The limit of work can be reached anywhere. The error is the only consequence.
#[test]
fn work_may_end_anywhere() {
    for (attribute, item) in SYSTEMS {
        let (attribute, item) = (tokens(attribute), tokens(item));
        let whole = expanded(&attribute, &item);
        let mut work = 1;
        let mut refused = 0;
        loop {
            let output = expand_within(&attribute, &item, Settings::default(), work).to_string();
            if !output.contains("compile_error") {
                assert_eq!(output, whole, "{work}");
                break;
            }
            assert_eq!(
                output.matches("compile_error").count(),
                1,
                "{work}: {output}"
            );
            assert!(
                output.contains(&format!("{work} operations")),
                "{work}: {output}"
            );
            refused += 1;
            // every number at first, then steps of a thirtieth
            work += 1 + work / 30;
        }
        assert!(refused > 150, "{refused}");
    }
}
