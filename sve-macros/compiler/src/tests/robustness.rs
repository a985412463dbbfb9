//! The macro on random and invalid input: it does not panic, it ends, and equal input gives equal
//! output.

use proc_macro2::{Group, Ident, Punct, Spacing, Span, TokenStream, TokenTree};

use super::large_input::{with_body, with_coordinates};
use crate::algebra::tests::recipe::Random;
use crate::tests::{expand, expand_members, tokens};

pub(super) const SYSTEMS: &[(&str, &str)] = &[
    (
        "midpoint",
        "impl P { fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 { v[0].powi(2) / 2.0 + self.g * q[0].cos() } }",
    ),
    (
        "initial_point, endpoint, midpoint",
        "impl Kubo {
            const N: usize = 2;
            fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; Self::N]) -> f64 {
                let mut sum = 0.0;
                for i in 0..Self::N { sum += 0.5 * self.m[i] * v[i] * v[i] - self.bump(q[i], t.sin()); }
                let (a, [b, _]) = (q[0] - q[1], q);
                sum - a.powi(2) * b.exp() / (1.0 + a * a).sqrt()
            }
            fn bump(&self, x: f64, y: f64) -> f64 { (-x * x / self.width.powf(1.5)).exp() + y.mul_add(x, 2.0) }
            #[gamma] fn shake(&self, q: [f64; 2]) -> [f64; 2] { [self.s * q[0].sin(), self.s * q[1]] }
            #[h1] fn jitter(&self, q: [f64; 2], p: [f64; 2]) -> f64 { q[0] * p[0].hypot(1.0 + q[1]) }
        }",
    ),
    (
        "taylor2, crate = sve_runtime",
        "impl Wheel { fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * self.0 * v * v * (1.0 + self.body.r#type * q * q) - q.cosh().ln() } }",
    ),
    (
        "midpoint",
        "impl Pair {
            fn lagrangian(&self, q: [[f64; 2]; 2], v: [[f64; 2]; 2]) -> f64 {
                let r = (q[0][0] - q[1][0]).hypot(q[0][1] - q[1][1]);
                0.5 * self.m * v.as_flattened().iter().map(|v| v * v).sum::<f64>() - self.k * (r - 1.0).powi(2)
            }
            #[force] fn damping(&self, t: f64, q: [[f64; 2]; 2], v: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
                let pull = [self.nu * (v[1][0] - v[0][0]), self.nu * (v[1][1] - v[0][1])];
                [pull, [-pull[0], -pull[1]]]
            }
            #[symmetry] fn shift(&self, _q: [[f64; 2]; 2]) -> [[f64; 2]; 2] { [[1.0, 0.0]; 2] }
            #[symmetry] fn drift(&self, t: f64, _q: [[f64; 2]; 2]) -> [[f64; 2]; 2] { [[0.0, 1.0]; 2] }
        }",
    ),
    (
        "midpoint",
        "impl Spinner {
            const G: Vector3<f64> = Vector3::new(0.0, 0.5, -9.8);
            fn lagrangian(&self, q: Vector3<f64>, v: na::Vector3<f64>) -> f64 {
                let inertia: Matrix3<f64> = self.inertia;
                let mut m = inertia + q * q.transpose() * self.k;
                m[(0, 1)] += Matrix2::new(1.0, q.x, q.y, 2.0).determinant() * m.fixed_view::<1, 2>(0, 1).norm_squared();
                let turned = Rotation3::from_euler_angles(q.x, 0.0, 1.0) * self.arm(&q).zip_map(&v, |a, b| a * b.sin());
                0.5 * v.dot(&v) + (q - self.anchor).norm() + Self::G.dot(&q) + 0.1 * turned.cross(&v).map(|x| x * x).sum()
            }
            fn arm(&self, q: &Vector3<f64>) -> SVector<f64, { 2 + 1 }> { SVector::<f64, 3>::from_fn(|i, _| q[i] + i as f64) }
            #[gamma] fn shake(&self, q: Vector3<f64>) -> Vector2<f64> { Vector2::new(self.s.dot(&q), q.fixed_rows::<2>(1).norm()) }
        }",
    ),
];

pub(super) fn expanded(attribute: &TokenStream, item: &TokenStream) -> String {
    expand(attribute, item).to_string()
}

pub(super) fn expand_body(body: &str) -> String {
    let lagrangian = "fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64";
    expand_members("midpoint", &format!("{lagrangian} {{ {body} }}")).to_string()
}

#[test]
fn same_input_gives_same_output() {
    for (attribute, item) in SYSTEMS {
        let first = expanded(&tokens(attribute), &tokens(item));
        assert!(!first.contains("compile_error"), "{first}");
        for _ in 0..3 {
            assert_eq!(first, expanded(&tokens(attribute), &tokens(item)));
        }
    }
}

/// Returns the number of token trees, including groups.
fn size(stream: &TokenStream) -> usize {
    let inside = |t: TokenTree| match t {
        TokenTree::Group(group) => 1 + size(&group.stream()),
        _ => 1,
    };
    stream.clone().into_iter().map(inside).sum()
}

/// Returns the stream in which token number `at` is deleted, doubled, exchanged with the next one
/// or replaced.
fn mutate(
    stream: TokenStream,
    at: &mut usize,
    random: &mut Random,
    donors: &[TokenTree],
) -> TokenStream {
    let mut output: Vec<TokenTree> = Vec::new();
    let mut swapped: Option<TokenTree> = None;
    for token in stream {
        let hit = *at == 0;
        *at = at.wrapping_sub(1);
        if hit {
            match random.below(5) {
                0 => {}
                1 => output.extend([token.clone(), token]),
                2 => swapped = Some(token),
                3 => output.push(donors[random.below(donors.len())].clone()),
                _ => output.extend([token, donors[random.below(donors.len())].clone()]),
            }
            continue;
        }
        output.push(match token {
            TokenTree::Group(group) => {
                let inner = mutate(group.stream(), at, random, donors);
                let mut new = Group::new(group.delimiter(), inner);
                new.set_span(group.span());
                new.into()
            }
            other => other,
        });
        output.extend(swapped.take());
    }
    output.extend(swapped);
    output.into_iter().collect()
}

fn leaves(stream: TokenStream, into: &mut Vec<TokenTree>) {
    for token in stream {
        if let TokenTree::Group(group) = &token {
            leaves(group.stream(), into);
        }
        into.push(token);
    }
}

#[test]
fn mutated_systems() {
    let mut random = Random(1);
    let mut donors = Vec::new();
    for (attribute, item) in SYSTEMS {
        leaves(tokens(attribute), &mut donors);
        leaves(tokens(item), &mut donors);
    }
    for word in "iter_mut into from_fn for_each &mut u8 3u8 *x if match while loop return as % abs 0 -1 1e308 9223372036854775807 _ .. ..= ! |x|x 'a \"s\" async unsafe &mut".split(' ') {
        leaves(tokens(word), &mut donors);
    }
    for (attribute, item) in SYSTEMS {
        let (attribute, item) = (tokens(attribute), tokens(item));
        for round in 0..400 {
            let mut mutated = item.clone();
            for _ in 0..=round % 3 {
                let mut at = random.below(size(&mutated));
                mutated = mutate(mutated, &mut at, &mut random, &donors);
            }
            expanded(&attribute, &mutated);
            let mut at = random.below(size(&attribute));
            let arguments = mutate(attribute.clone(), &mut at, &mut random, &donors);
            if round < 40 {
                expanded(&arguments, &item);
            }
        }
    }
}

#[test]
fn odd_items() {
    for item in [
        "",
        "struct S;",
        "impl",
        "impl P",
        "impl P {}",
        "impl P { fn lagrangian() {} }",
        "fn f() {}",
        "trait T {}",
        "impl P { fn lagrangian(&self) {} fn lagrangian(&self, q: f64, v: f64) -> f64 { v * v } }",
        "impl P { type X = f64; m!(); fn f(); const C: f64; }",
        "impl !Send for P {}",
        "impl P { fn lagrangian(self: &Self, q: f64, v: f64) -> f64 { v * v } }",
        "impl dyn T { fn lagrangian(&self, q: f64, v: f64) -> f64 { v * v } }",
        "impl P { fn lagrangian(&self, (a, b): f64, [c]: f64) -> f64 { a + b + c } }",
        "impl P { const A: f64 = Self::B; const B: f64 = Self::A; fn lagrangian(&self, q: f64, v: f64) -> f64 { Self::A * v } }",
        "impl P { fn lagrangian(&self, q: [f64; { loop {} }], v: f64) -> f64 { v * v } }",
    ] {
        for attribute in [
            "midpoint",
            "",
            "crate",
            "crate =",
            "crate = ,",
            ",,",
            "midpoint midpoint",
            "\"midpoint\"",
            "midpoint(1)",
            "crate = crate = crate",
        ] {
            expanded(&tokens(attribute), &tokens(item));
        }
    }
    let stray: TokenTree = Punct::new('#', Spacing::Alone).into();
    let odd: TokenStream = [stray, Ident::new("r", Span::call_site()).into()]
        .into_iter()
        .collect();
    expanded(&odd, &odd);
}

/// Systems that contain parts of other systems.
#[test]
fn crossed_systems() {
    let mut random = Random(2);
    let streams: Vec<(TokenStream, TokenStream)> = SYSTEMS
        .iter()
        .map(|(attribute, item)| (tokens(attribute), tokens(item)))
        .collect();
    let mut groups = Vec::new();
    for (_, item) in &streams {
        leaves(item.clone(), &mut groups);
    }
    groups.retain(|token| matches!(token, TokenTree::Group(_)));
    for (attribute, item) in &streams {
        for _ in 0..300 {
            let mut crossed = item.clone();
            for _ in 0..=random.below(2) {
                let mut at = random.below(size(&crossed));
                crossed = mutate(crossed, &mut at, &mut random, &groups);
            }
            expanded(attribute, &crossed);
        }
    }
}

/// Words of the language in any order.
#[test]
fn random_bodies() {
    let mut random = Random(3);
    let words: Vec<TokenStream> = "q v self self.m q[0] v[1] 0 1 2.0 1e308 i j x + - * / % ^ = += == < . , ; .. ..= & |x| |(i,x)| let mut for in if else continue break         .iter() .into_iter() .map .sum::<f64>() .zip .enumerate() .rev() .fold .filter .windows .chunks .step_by .take .skip .flatten() .len() .powi .sin()         (q) (v) (0) (1,2) (|x|x) (|a,b|a+b) [0] [1..] [..2] [0;3] {x} {} Self::N Self::f PI const use fn return as f64 &mut *x a 3u8 i64 as u8 .iter_mut() .for_each .into() std::array::from_fn i8::MIN -1 (|x|*x*=2.0) :[f64;2] Vector2::new Vector2::zeros() Matrix2::identity() Matrix2::new(1.0,2.0,3.0,x)          :Vector2<f64> :Matrix2<f64> SVector::<f64,0>::zeros() .dot .cross .norm() .x .y [(0,1)] .transpose() .row(0) .column(1) .fixed_rows::<1>(0) .component_mul          .zip_map Rotation2::new .determinant() .normalize() .as_slice() self.g &q .from_fn"
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect();
    for _ in 0..4_000 {
        let length = 1 + random.below(14);
        let body: TokenStream = (0..length)
            .map(|_| words[random.below(words.len())].clone())
            .collect();
        expanded(&tokens("midpoint"), &with_body(body.clone()));
        expanded(&tokens("midpoint"), &with_coordinates("Vector2<f64>", body));
    }
}

#[test]
fn huge_literals() {
    for literal in [
        "9".repeat(5_000),
        format!("{}.0", "9".repeat(400)),
        format!("0.{}1", "0".repeat(5_000)),
        "1e999999999999".to_owned(),
        "0xffff_ffff_ffff_ffff_ffff".to_owned(),
        "1__________0.5__e__3".to_owned(),
        "340282366920938463463374607431768211456u128".to_owned(),
        "\"".to_owned() + &"x".repeat(10_000) + "\"",
    ] {
        expand_body(&format!("{literal} * v[0] * v[0]"));
        expand_body(&format!("v[0].powi({literal}) + q[{literal}]"));
        expand_body(&format!("for i in 0..{literal} {{}} [0.0; {literal}]"));
    }
}
