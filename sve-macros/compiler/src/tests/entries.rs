//! Entries of vector and matrix parameters: one symbol for each entry, even if the entry is written
//! in several ways.

use super::{rows, vectors::model};
use crate::algebra::Arena;
use crate::model::{Meaning, Symbols};

/// Returns a block with this body. Its coordinates are vectors of length 2.
fn block(body: &str) -> String {
    format!(
        "fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {{ 0.5 * v.norm_squared() - {{ {body} }} }}
        fn sum(&self) -> f64 {{ let mut sum = 0.0; for i in 0..2 {{ sum += self.g[i]; }} sum }}"
    )
}

/// Returns the code by which generated code reads the parameters.
fn reads(symbols: &Symbols) -> Vec<String> {
    let access = |symbol| match symbols.meaning(symbol) {
        Meaning::Parameter { access, .. } => access.to_string().replace(' ', ""),
        _ => String::new(),
    };
    let mut reads: Vec<String> = symbols.parameters().map(access).collect();
    reads.sort_unstable();
    reads
}

/// Bodies, and the parameters that are read.
const BODIES: &str = r"
// the type of the field shows before or after the entry
self.g.dot(&q) + self.g[1] * q.x → self.g.x, self.g.y
self.g[1] * q.x + self.g.dot(&q) → self.g.x, self.g.y
self.g[(1, 0)] * q.x + self.g.dot(&q) → self.g.x, self.g.y
self.sum() * q.x + self.g.dot(&q) → self.g.x, self.g.y
let g: Vector2<f64> = self.g; self.sum() * q.x + g.x → self.g.x, self.g.y
self.g.dot(&q) + self.g.iter().zip(q.iter()).map(|(g, q)| g * q * q).sum::<f64>() → self.g.x, self.g.y
let [a, b]: [f64; 2] = self.g.into(); self.g.dot(&q) + a * q.x * q.x + b * q.y → self.g.x, self.g.y
let mut e = self.g.dot(&q); let g: [f64; 2] = self.g.into(); for x in &g { e += x * q.x.sin(); } e → self.g.x, self.g.y
self.a[1].dot(&q) + self.a[1][0] * q.x.sin() → self.a[1].x, self.a[1].y
WIND.dot(&q) + WIND[0] * q.x.sin() → WIND.x, WIND.y
// an array becomes a vector
let a: Vector2<f64> = self.a.into(); a.dot(&q) → self.a[0], self.a[1]
q.dot(&self.a.into()) + self.a[1] * q.x → self.a[0], self.a[1]
let g: Vector2<f64> = self.g.into(); g.dot(&q) + self.g.dot(&q).sin() → self.g.x, self.g.y
// of unknown type
self.g.x * q.x + self.g[0] * q.y → self.g.x
self.g[0] * q.x + self.g.x * q.y + self.g[1] → self.g.x, self.g[1]
self.g[(1, 0)] * q.x + self.g[1] * q.y → self.g[(1,0)]
self.r[(0, 1)] * q.x + self.r.y * q.y → self.r.y
self.m.m12 * q.x + self.m[(0, 1)] * q.y → self.m[(0,1)]
self.m.m21 * q.x + self.m[1] * q.y → self.m.m21
// matrices are stored in columns
let m: Matrix2<f64> = self.m; (m * q).dot(&q) + self.m[2] * q.x + self.m.m21 + self.m[(0, 0)] → self.m[(0,0)], self.m[(0,1)], self.m[(1,0)], self.m[(1,1)]
let m: Matrix2x3<f64> = self.m; m[(0, 1)] * q.x + self.m[2] * q.y → self.m[(0,1)]
let g: SVector<f64, 7> = self.g; g[3] * q.x + self.g[3] → self.g[3]
// other entries than these
self.g[0] * q.x + self.g[1] * q.y → self.g[0], self.g[1]
self.m[(1, 1)] * q.x + self.m[0] * q.y → self.m[(1,1)], self.m[0]
self.b.x * q.x + self.b.m11 * q.y → self.b.m11, self.b.x
self.b[0].x * q.x + self.b[1].x * q.y → self.b[0].x, self.b[1].x
self.w[0][1] * q.x + self.w[1][0] * q.y → self.w[0][1], self.w[1][0]
";

#[test]
fn an_entry_is_one_parameter_however_it_is_written() {
    let mut wrong = Vec::new();
    for [body, expected] in rows(BODIES) {
        match model(&block(body), &mut Arena::new()) {
            Ok(model) => {
                let found = reads(&model.symbols);
                if found.join(", ") != expected {
                    wrong.push(format!("{body}: {found:?}"));
                }
            }
            Err(mistakes) => wrong.push(format!("{body}: {mistakes:?}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Bodies with one mistake: the token at which it is reported, and a part of the message.
const MISTAKES: &str = r"
self.m[2] * q.x + self.m[(0, 1)] * q.y → 2 → `self.m[2]` and `self.m[(0, 1)]` may be the same entry
self.g[2] * q.x + self.g.dot(&q) → 2 → index 2 is out of range: a `Vector2<f64>` has the entries `.x`, `.y`
let m: Matrix2<f64> = self.m; m.trace() * q.x + self.m[(3, 0)] → (3, 0) → index (3, 0) is out of range
let m: Matrix2<f64> = self.m; m.trace() * q.x + self.m[4] → 4 → index 4 is out of range
";

#[test]
fn mistaken_entries_of_parameters_are_reported_at_their_index() {
    let mut wrong = Vec::new();
    for [body, at, message] in rows(MISTAKES) {
        match model(&block(body), &mut Arena::new()) {
            Ok(model) => wrong.push(format!("{body}: {:?}", reads(&model.symbols))),
            Err(found) => {
                let fits = found.len() == 1 && found[0].0 == at && found[0].1.contains(message);
                if !fits {
                    wrong.push(format!("{body}: {found:?}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A symmetry holds for one entry in two spellings, and two symbols would break it.
#[test]
fn entries_in_two_spellings_are_equal_numbers() {
    for (a, b) in [
        ("self.a.x", "self.a[0]"),
        ("self.a[1]", "self.a.y"),
        ("self.a[(0, 0)]", "self.a[0]"),
        ("self.m.m22", "self.m[(1, 1)]"),
    ] {
        let mut arena = Arena::new();
        let read = |body: String, arena: &mut Arena| {
            let model = model(&block(&body), arena);
            model.unwrap_or_else(|e| panic!("{body}: {e:?}")).lagrangian
        };
        let two = read(format!("{a} * q.x * q.x + {b} * q.y * q.y"), &mut arena);
        let one = read(format!("{a} * q.x * q.x + {a} * q.y * q.y"), &mut arena);
        assert_eq!(two, one, "{a} and {b}");
    }
}
