//! Random bodies of loops: what is read is right, and what is refused has a message.

use std::collections::HashMap;
use std::fmt::Write as _;

use super::{Field, compare, try_read};
use crate::algebra::tests::recipe::Random;
use crate::tests::expand_members;

/// A formula of a loop's body.
#[derive(Clone, Debug)]
enum Formula {
    Number(f64),
    /// `q[…]` or `self.mass[…]`.
    Entry(bool, Index),
    Product(Box<Formula>, Box<Formula>),
    Difference(Box<Formula>, Box<Formula>),
    Cosine(Box<Formula>),
}

/// An index: a counter plus a number, modulo the length.
#[derive(Clone, Copy, Debug)]
struct Index(usize, usize);

#[derive(Clone, Debug)]
enum Statement {
    Add(Formula),
    /// A local sum and a term that reads it.
    Local(Vec<Statement>, Formula),
    Loop(Vec<Statement>),
    If(Comparison, Vec<Statement>, Vec<Statement>),
    Continue(Comparison),
}

#[derive(Clone, Debug)]
enum Comparison {
    Indices(Index, Index),
    Numbers(Formula, Formula),
}

impl Index {
    fn random(depth: usize, random: &mut Random) -> Self {
        Self(random.below(depth), random.below(4))
    }

    fn text(self) -> String {
        format!("(i{} + {}) % n", self.0, self.1)
    }

    fn at(self, counters: &[usize], n: usize) -> usize {
        (counters[self.0] + self.1) % n
    }
}

impl Formula {
    fn random(depth: usize, size: usize, random: &mut Random) -> Self {
        let part = |random: &mut Random| Box::new(Self::random(depth, size / 2, random));
        match (size, random.below(6)) {
            (0, 0) => Self::Number(random.below(9) as f64 / 4.0 - 1.0),
            (0, _) | (_, 0 | 1) => Self::Entry(random.below(3) == 0, Index::random(depth, random)),
            (_, 2 | 3) => Self::Product(part(random), part(random)),
            (_, 4) => Self::Difference(part(random), part(random)),
            _ => Self::Cosine(part(random)),
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Number(value) => format!("({value:?})"),
            Self::Entry(true, index) => format!("self.mass[{}]", index.text()),
            Self::Entry(false, index) => format!("q[{}]", index.text()),
            Self::Product(a, b) => format!("{} * {}", a.text(), b.text()),
            Self::Difference(a, b) => format!("({} - {})", a.text(), b.text()),
            Self::Cosine(x) => format!("({}).cos()", x.text()),
        }
    }

    fn value(&self, data: &Data<'_>) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Entry(is_mass, index) => {
                let at = index.at(&data.counters, data.q.len());
                if *is_mass {
                    data.mass[at]
                } else {
                    data.q[at][0]
                }
            }
            Self::Product(a, b) => a.value(data) * b.value(data),
            Self::Difference(a, b) => a.value(data) - b.value(data),
            Self::Cosine(x) => x.value(data).cos(),
        }
    }
}

impl Comparison {
    fn random(depth: usize, random: &mut Random) -> Self {
        if random.below(3) == 0 {
            let mut formula = || Formula::random(depth, 2, random);
            return Self::Numbers(formula(), formula());
        }
        Self::Indices(Index::random(depth, random), Index::random(depth, random))
    }

    fn text(&self) -> String {
        match self {
            Self::Indices(a, b) => format!("{} < {}", a.text(), b.text()),
            Self::Numbers(a, b) => format!("{} < {}", a.text(), b.text()),
        }
    }

    fn holds(&self, data: &Data<'_>) -> bool {
        match self {
            Self::Indices(a, b) => {
                let [a, b] = [a, b].map(|index| index.at(&data.counters, data.q.len()));
                a < b
            }
            Self::Numbers(a, b) => a.value(data) < b.value(data),
        }
    }
}

/// The data of a loop that runs.
struct Data<'a> {
    q: &'a [Vec<f64>],
    mass: &'a [f64],
    counters: Vec<usize>,
}

/// Random statements in `depth` loops.
fn statements(depth: usize, size: usize, random: &mut Random) -> Vec<Statement> {
    let count = 1 + random.below(3);
    let one = |random: &mut Random| match (size, random.below(8)) {
        (0, _) | (_, 0..=2) => Statement::Add(Formula::random(depth, 4, random)),
        (_, 3) if depth < 3 => Statement::Loop(statements(depth + 1, size - 1, random)),
        (_, 4) => {
            let factor = Formula::random(depth, 2, random);
            Statement::Local(statements(depth, size - 1, random), factor)
        }
        (_, 5) => Statement::Continue(Comparison::random(depth, random)),
        _ => {
            let condition = Comparison::random(depth, random);
            let then = statements(depth, size - 1, random);
            let other = match random.below(2) {
                0 => Vec::new(),
                _ => statements(depth, size - 1, random),
            };
            Statement::If(condition, then, other)
        }
    };
    (0..count).map(|_| one(random)).collect()
}

/// Writes statements that add to the variable `to`.
fn write(statements: &[Statement], depth: usize, to: &str, text: &mut String) {
    for statement in statements {
        let result = match statement {
            Statement::Add(formula) => writeln!(text, "{to} += {};", formula.text()),
            Statement::Local(inner, factor) => {
                let own = format!("{to}x");
                writeln!(text, "let mut {own} = 0.0;").expect("a text");
                // a `continue` within would leave out the use of the local sum
                write(&without_continue(inner), depth, &own, text);
                writeln!(text, "{to} -= {own} * {};", factor.text())
            }
            Statement::Loop(inner) => {
                writeln!(text, "for i{depth} in 0..n {{").expect("a text");
                write(inner, depth + 1, to, text);
                writeln!(text, "}}")
            }
            Statement::If(condition, then, other) => {
                writeln!(text, "if {} {{", condition.text()).expect("a text");
                write(then, depth, to, text);
                writeln!(text, "}} else {{").expect("a text");
                write(other, depth, to, text);
                writeln!(text, "}}")
            }
            Statement::Continue(condition) => {
                writeln!(text, "if {} {{ continue; }}", condition.text())
            }
        };
        result.expect("a text");
    }
}

fn without_continue(statements: &[Statement]) -> Vec<Statement> {
    let inner = |statement: &Statement| match statement {
        Statement::Continue(_) => None,
        Statement::Local(list, factor) => {
            Some(Statement::Local(without_continue(list), factor.clone()))
        }
        Statement::If(condition, then, other) => Some(Statement::If(
            condition.clone(),
            without_continue(then),
            without_continue(other),
        )),
        other => Some(other.clone()),
    };
    statements.iter().filter_map(inner).collect()
}

/// Executes statements. Returns whether a `continue` has ended them.
fn run(statements: &[Statement], data: &mut Data<'_>, to: &mut f64) -> bool {
    for statement in statements {
        match statement {
            Statement::Add(formula) => *to += formula.value(data),
            Statement::Local(inner, factor) => {
                let mut own = 0.0;
                run(&without_continue(inner), data, &mut own);
                *to -= own * factor.value(data);
            }
            Statement::Loop(inner) => {
                for i in 0..data.q.len() {
                    data.counters.push(i);
                    run(inner, data, to);
                    data.counters.pop();
                }
            }
            Statement::If(condition, then, other) => {
                let part = if condition.holds(data) { then } else { other };
                if run(part, data, to) {
                    return true;
                }
            }
            Statement::Continue(condition) => {
                if condition.holds(data) {
                    return true;
                }
            }
        }
    }
    false
}

#[test]
fn random_bodies_of_loops() {
    let mass: Vec<f64> = (0..8).map(|i| 0.5 + 0.25 * f64::from(i)).collect();
    let fields = HashMap::from([("mass", Field::numbers(&mass))]);
    let mut random = Random(11);
    for _ in 0..400 {
        let body = statements(1, 3, &mut random);
        let mut text = String::new();
        write(&body, 1, "l", &mut text);
        let members = format!(
            "fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {{
                let n = q.len();
                let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
                for i0 in 0..n {{ {text} }}
                l
            }}"
        );
        compare(&members, &fields, &[0, 1, 2, 5], |q, v| {
            let counters = Vec::new();
            let mut data = Data {
                q,
                mass: &mass,
                counters,
            };
            let mut l = v.iter().map(|v| 0.5 * v[0] * v[0]).sum();
            run(&[Statement::Loop(body.clone())], &mut data, &mut l);
            l
        });
    }
}

/// Random words as the body of a loop: no panic, and an error for what is not read.
#[test]
fn random_words() {
    let words = "q v q[i] v[j] q[0] self.k self.n self.list[i] self.list[i][j] i j n 0 1 2.0 x l + - * / % = += -= *= == != < && ! ( ) { } [ ] . , ; .. ..= & for in if else continue; break; let mut as f64 usize .len() .iter() .enumerate() .zip(q) .map(|x|x) .filter(|x|**x>0.0) .sum::<f64>() .rev() .skip(1) .take(n) .windows(2) .collect() .is_empty() .min(2) .max .saturating_sub(1) .powi(2) .cos() q[(i+1)%n] for&[i,j]in&self.list for(i,x)in q.iter().enumerate() for i in 0..n for j in i..n if i<n if x>0.0 {l+=q[i];} l+= let x= let j= let mut x=0.0; |x| self.f(i) Self::f";
    let words: Vec<&str> = words.split(' ').collect();
    let mut random = Random(5);
    for _ in 0..4000 {
        let count = 1 + random.below(14);
        let body: Vec<&str> = (0..count)
            .map(|_| words[random.below(words.len())])
            .collect();
        let body = body.join(" ");
        let members = format!(
            "fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {{
                let (n, mut l) = (q.len(), 0.0);
                for i in 0..n {{ let x = q[i]; {body} }}
                l
            }}
            fn f(&self, i: usize) -> f64 {{ self.k * i as f64 }}"
        );
        if members.parse::<proc_macro2::TokenStream>().is_err() {
            continue;
        }
        let expansion = expand_members("endpoint", &members).to_string();
        let block = format!("impl P {{ {members} }}");
        if syn::parse_str::<syn::ItemImpl>(&block).is_ok() && try_read(&members).is_err() {
            assert!(expansion.contains("compile_error"), "{body}");
        }
    }
}
