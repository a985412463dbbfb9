//! One error for each mistake: the number of errors of an expansion, and the replacement of wrong
//! functions, about which the compiler of Rust would report a second error.

use crate::tests::{expand_members, rows};

fn errors(attribute: &str, members: &str) -> usize {
    let output = expand_members(attribute, members).to_string();
    output.matches("compile_error").count()
}

/// Returns a block with this body, a helper and a noise.
fn block(body: &str) -> String {
    format!(
        "const N: usize = 2;
        const G: f64 = 9.81;
        fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {{ {body} }}
        fn helper(&self, x: f64) -> f64 {{ self.k * x * x }}
        #[gamma] fn noise(&self, q: [f64; 2]) -> f64 {{ q[0] }}"
    )
}

/// Bodies, and their numbers of mistakes.
const BODIES: &str = r#"
v[0] * v[0] + v[1] * v[1] → 0
v[0].abs() + v[1] * v[1] → 1
v[0].abs() + v[1].floor() + q[0].sine() → 3
let x = q[0].abs(); let y = x * x; x + y.sin() + v[0] * x → 1
let x = q[0] % 2.0; let [a, b] = [x, x]; a * b + x.cos() → 1
let mut s = 0.0; for i in 0..9 { s += v[i]; } s → 1
let mut s = 0.0; for i in 0..2 { s += v[i].abs() + q[i].ceil(); } s → 2
q.iter().map(|x| x.abs()).sum::<f64>() → 1
q.iter().fold(0.0, |s, x| s + x.abs()) → 1
q.map(|x| x.max(0.0))[0] + q[7] → 2
self.helper(v[0].abs()) + self.helper(1) + self.helper() → 3
self.halper(v[0]) + helper(v[0]) + other(v[0]) → 3
N + G * v[0] → 2
let x = Self::Q * v[0]; x + Self::M → 2
if q[0] > 0.0 { v[0] } else { v[1].abs() } → 1
let x = match 1 { _ => v[0] }; let y = loop {}; x + y + return 1.0 → 3
println!("{}", v[0]); let f = |x: f64| x.abs(); f(v[0]) + f(v[1]) → 2
let (a, b) = v; a + b + q[0].abs() → 2
let x; v[0] + x → 1
let Some(x) = q[0] else { panic!() }; x * v[0] → 1
fn f(x: f64) -> f64 { x } f(v[0]) + f(v[1]) → 1
v[0] * v[0] + v[1] * v[1]; → 1
v[0] * 2 + v[1] * 3 → 2
let mut x = q; for x in x.iter_mut() { *x *= 2.0; } v[0] * v[0] + v[1] * v[1] * x[0] → 0
let mut x = q; for x in x.iter_mut() { *x = x.abs(); } v[0] * x[0] → 1
let mut x = q; for y in &mut x { y = 1.0; } v[0] * x[0] → 1
for x in self.m.iter_mut() { *x *= 2.0; } v[0] * v[0] → 1
let mut x = q; x.iter_mut().map(|x| { *x = 1.0; *x }).sum::<f64>() * v[0] → 1
let mut x = q; let f = |x: &mut f64| *x *= 2.0; for x in &mut x { f(x); } v[0] → 1
let a = std::array::from_fn(|i| q[i]); v[0] * a.iter().sum::<f64>() → 1
let a: [f64; 2] = std::array::from_fn(|i| q[i].abs()); v[0] * a[0] → 1
let a: [f64; 2] = std::array::from_fn(2.0); v[0] * a[0] → 1
let n = 300u8; let m = -1i32 as usize; v[0] * (2u8 + 3u16) as f64 * (200u8 + 100) as f64 → 4
let mut n = 1; for i in 0..40 { n *= 2; } v[0] * n as f64 → 1
let mut s = 0.0; for i in 0..2 { s += (i - 1) as f64 * q[i]; } v[0] * s → 1
let mut s = 0.0; for i in 0..2 { s += (i - 1) as f64 * v[i as usize]; } v[0] * v[0] + v[1] * v[1] + s * s → 0
let a = [0.0; OUTER]; let b: [f64; 2] = [v[0]; sizes::OUTER]; for i in 0..OUTER {} v[0] → 3
v → 1
let x: f64 = 1; x + self.helper(x) + self.helper(2) → 2
q.sine() + q.collect::<Vec<f64>>() → 2
for i in 0..self.n { } for x in self.m { } v[0] → 2
v[0] / 0.0 + v[0].powi(2.0) + v[0].powi(5000) + v[0] ^ 2.0 → 4
"#;

#[test]
fn one_error_a_mistake_in_a_body() {
    for [body, mistakes] in rows(BODIES) {
        assert_eq!(
            errors("midpoint", &block(body)).to_string(),
            mistakes,
            "{body}"
        );
    }
}

#[test]
fn one_error_a_mistake_elsewhere() {
    let good = "fn lagrangian(&self, q: f64, v: f64) -> f64 { v * v }";
    let rough = "fn lagrangian(&self, q: f64, v: f64) -> f64 { v * v + q.abs() }";
    for (attribute, members, mistakes) in [
        ("midpoint", good.to_owned(), 0),
        ("", good.to_owned(), 1),
        ("midpont, midpoint, midpoint, leapfrog", good.to_owned(), 3),
        ("midpoint(2)", good.to_owned(), 1),
        ("order = 2", good.to_owned(), 1),
        ("\"midpoint\"", good.to_owned(), 1),
        ("midpont", rough.to_owned(), 2),
        ("midpoint", String::new(), 1),
        ("midpont", String::new(), 2),
        ("midpoint", format!("{good} {good}"), 1),
        ("midpoint", format!("{rough} #[gamma] fn a(&self, q: f64, v: f64) -> f64 {{ v }}"), 2),
        ("midpoint", format!("{good} #[gamma] fn a(q: f64) -> f64 {{ q }} #[h1] fn b(&self, q: f64) -> f64 {{ q }}"), 2),
        ("midpoint", format!("{good} #[gamma] #[h1] fn a(&self, q: f64) -> f64 {{ q }}"), 1),
        ("midpoint", format!("{good} #[gamma] fn a(&self, q: f64) -> [f64; 2] {{ [q, 1.0] }} #[gamma] fn b(&self, q: f64) -> f64 {{ 2.0 }}"), 2),
        ("midpoint", format!("{good} #[gamma] fn a(&self, q: f64) -> (f64, f64) {{ (q, q.abs()) }}"), 2),
        ("taylor2", format!("{good} #[gamma] fn a(&self, q: f64) -> f64 {{ q }}"), 1),
        ("midpoint", "const N: usize = 1; fn lagrangian(&self, q: [f64; N], v: [f64; N]) -> f64 { v[0] * v[0] }".to_owned(), 1),
        ("midpoint", "const G: f64 = 9; fn lagrangian(&self, q: f64, v: f64) -> f64 { v * v + Self::G * q + Self::G * q * q }".to_owned(), 1),
        ("midpoint", "fn f(&self, x: f64) -> f64 { x.abs() } fn lagrangian(&self, q: f64, v: f64) -> f64 { self.f(v) + self.f(q) }".to_owned(), 1),
        ("midpoint", "fn lagrangian(&self, q: f64, v: f64) -> f64 { q }".to_owned(), 1),
        ("midpoint", "fn lagrangian(&self, q: f64, v: f64) -> [f64; 1] { [v * v] }".to_owned(), 1),
        ("midpoint", "fn lagrangian(&self, q: [f64; DIM], v: [f64; DIM]) -> f64 { v[0] * v[0] }".to_owned(), 1),
        ("midpoint", "fn lagrangian(&self, q: [f64; sizes::DIM], v: [f64; sizes::DIM]) -> f64 { v[0] * v[0] }".to_owned(), 1),
        ("midpoint", "const N: usize = DIM; fn lagrangian(&self, q: [f64; Self::N], v: [f64; Self::N]) -> f64 { v[0] * v[0] }".to_owned(), 1),
        ("midpoint", "fn lagrangian(&self, v: f64, q: f64) -> f64 { v * v } #[h1] fn a(&self, p: f64, q: f64) -> f64 { p }".to_owned(), 2),
    ] {
        assert_eq!(errors(attribute, &members), mistakes, "{attribute}: {members}");
    }
}

/// Returns the expansion after its errors.
fn rest(members: &str) -> String {
    let output = expand_members("midpoint", members).to_string();
    let at = output.find("impl P").expect("the block");
    output[at..].to_owned()
}

#[test]
fn mistaken_functions_lose_their_bodies_and_others_keep_them() {
    let output = rest(
        "const K: f64 = 3141; const C: f64 = 2.5;
        fn lagrangian(&self, q: f64, v: f64) -> f64 { v * v - Self::K * self.good(q) - self.bad(q) }
        fn good(&self, x: f64) -> f64 { kept(x) + Self::C }
        fn bad(&self, x: f64) -> f64 { x.sine() }
        fn other(&self) -> String { format!(\"{}\", 1) }",
    );
    for (gone, text) in [
        (true, "sine"),
        (true, "3141"),
        (true, "kept"),
        (false, "self . good"),
        (false, "2.5"),
        (false, "format !"),
        (false, "fn bad (& self , x : f64) -> f64"),
    ] {
        assert_eq!(!output.contains(text), gone, "{text}: {output}");
    }
}

#[test]
fn own_lengths_are_replaced() {
    let output = rest(
        "const N: usize = 2; fn lagrangian(&self, q: [f64; 2 * N], v: [[f64; N]; (N)]) -> f64 { v[0][0] }",
    );
    assert!(output.contains("2 * Self :: N"), "{output}");
    assert!(!output.contains("; N]"), "{output}");
}
