//! The printed mathematics against the system and the steps, read by a program that knows nothing
//! of how it was made: L, the noise terms and the equations of motion have the values of the user's
//! functions and their derivatives, and the printed equations of a step, solved here, give the
//! step.

use std::collections::HashMap;

use sve_models::case::Case;
use sve_models::functions::{Functions, Point};
use sve_models::oracle::{Nodes, cases};
use sve_models::random::Random;
use sve_runtime::Plan;

#[path = "../../../sve-macros/compiler/src/algebra/reader.rs"]
mod reader;
use reader::read;

type Values = HashMap<String, f64>;

/// Rounding of formulas of a hundred terms of the order of 10, in another order than that of the
/// code.
const ROUNDING: f64 = 1e-11;

/// Equations solved here by differences of size 1e-6 are solved to about 1e-12, times their
/// condition, below 100.
const SOLVED: f64 = 1e-9;

/// `a = b` of each line that is whole, without indentation.
fn equations(text: &str) -> Vec<(&str, &str)> {
    let whole = text.lines().filter(|line| !line.contains('…'));
    whole
        .filter_map(|line| line.trim().split_once(" = "))
        .collect()
}

/// The fields of a system, from how it prints itself for debugging.
fn parameters(model: &dyn Functions) -> Values {
    let text = format!("{model:?}");
    let mut values = Values::new();
    let fields = text.split_once('{').map_or("", |(_, fields)| fields);
    let mut field = String::new();
    let mut index = None;
    for word in fields
        .split([' ', '}', ','])
        .filter(|word| !word.is_empty())
    {
        if let Some(name) = word.strip_suffix(':') {
            name.clone_into(&mut field);
            index = None;
            continue;
        }
        if word.starts_with('[') {
            index = Some(0);
        }
        let number: f64 = word.trim_matches(['[', ']']).parse().unwrap();
        let full = match &mut index {
            None => field.clone(),
            Some(i) => {
                *i += 1;
                format!("{field}[{}]", *i - 1)
            }
        };
        values.insert(format!("self.{full}"), number);
        values.insert(full, number);
    }
    values
}

/// `letter[i]`, without an index where there is one component.
fn insert(values: &mut Values, letter: &str, components: &[f64]) {
    for (i, &x) in components.iter().enumerate() {
        values.insert(component(letter, i, components.len()), x);
    }
}

fn component(letter: &str, i: usize, of: usize) -> String {
    if of == 1 {
        letter.to_owned()
    } else {
        format!("{letter}[{i}]")
    }
}

/// The index in `letter[i]`.
fn component_of(name: &str) -> usize {
    name.split(['[', ']'])
        .nth(1)
        .map_or(0, |i| i.parse().unwrap())
}

/// Adds what the equations say of names that nothing is known of yet, as far as it follows.
fn follow(equations: &[(&str, &str)], values: &mut Values) {
    for _ in 0..equations.len() {
        for &(left, right) in equations {
            let is_new = !left.contains([' ', '·']) && left != "0" && !values.contains_key(left);
            if is_new && let Some(value) = read(right, values) {
                values.insert(left.to_owned(), value);
            }
        }
    }
}

#[track_caller]
fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() <= tolerance * (1.0 + expected.abs()),
        "{what}: {found}, not {expected}"
    );
}

struct Systems {
    random: Random,
    lines: usize,
}

impl Systems {
    fn check(&mut self, model: &dyn Functions, plan: &Plan) {
        let Point { t, q, p } = model.point(&mut self.random);
        let (q, p) = (q.as_slice(), p.as_slice());
        let v = &self.random.vector(q.len(), -0.5, 0.5);
        let mut values = parameters(model);
        values.insert("t".to_owned(), t);
        insert(&mut values, "q", q);
        insert(&mut values, "v", v);
        insert(&mut values, "p", p);
        let what = |line: (&str, &str)| format!("{}: {} = {}", plan.system, line.0, line.1);

        let force = model.f(t, q, v);
        let (g, of_noises) = (model.g(t, q, p), model.w(t, q, v));
        let lines = equations(plan.formulas.system);
        let mut known = values.clone();
        follow(&lines, &mut known);
        let mut noises = g.iter();
        let mut of_noises = of_noises.iter().skip_while(|f| f.iter().all(|x| *x == 0.0));
        for line in lines {
            if line.0.starts_with("f ") {
                let components = line.1.trim_matches(['(', ')']).split(", ");
                let forces = of_noises.next().unwrap();
                let components: Vec<&str> = match forces.len() {
                    1 => vec![line.1],
                    _ => components.collect(),
                };
                for (text, &expected) in components.into_iter().zip(forces) {
                    close(read(text, &known).unwrap(), expected, ROUNDING, &what(line));
                    self.lines += 1;
                }
                continue;
            }
            let expected = match line.0.split_once(' ') {
                None if line.0 == "L" => model.l(t, q, v),
                Some(("γ", _)) => -noises.next().unwrap(),
                Some(("H₁", _)) => *noises.next().unwrap(),
                None if line.0.starts_with('F') => force[component_of(line.0)],
                _ => continue,
            };
            close(
                read(line.1, &known).unwrap(),
                expected,
                ROUNDING,
                &what(line),
            );
            self.lines += 1;
        }

        let (jet, jets) = (model.lagrangian(t, q, v), model.noises(t, q, p));
        let pushes = model.w(t, q, v);
        let m = jets.len();
        let lines = equations(plan.formulas.motion);
        let mut known = values;
        // the momenta of the noise terms are not those of the velocities here
        let definitions: Vec<_> = lines
            .iter()
            .copied()
            .filter(|l| l.0.is_ascii() && !l.0.starts_with(['d', 'p']))
            .collect();
        follow(&definitions, &mut known);
        for line in lines {
            let index = component_of(line.0);
            let (letter, right) = (line.0.split('[').next().unwrap(), line.1);
            // dx = a dt + b ∘ dW: with one of the differentials 1 at a time
            let right = right.replace(" dt", "·dt").replace(" ∘ dW", "·dW");
            for a in 0..=m {
                let mut known = known.clone();
                let mut differentials = vec![0.0; m];
                if a < m {
                    differentials[a] = 1.0;
                }
                insert(&mut known, "dW", &differentials);
                known.insert("dt".to_owned(), if a == m { 1.0 } else { 0.0 });
                let expected = match (letter, a < m) {
                    ("p", _) => jet.dv[index],
                    ("dq", false) => v[index],
                    ("dq", true) => jets[a].dp[index],
                    ("dp", false) => jet.dq[index] + force[index],
                    ("dp", true) => pushes[a][index] - jets[a].dq[index],
                    _ => continue,
                };
                close(
                    read(&right, &known).unwrap(),
                    expected,
                    ROUNDING,
                    &what(line),
                );
                self.lines += 1;
            }
        }
    }
}

#[test]
fn systems_and_their_motion_have_the_values_of_the_users_functions() {
    let mut systems = Systems {
        random: Random::new(31),
        lines: 0,
    };
    for case in cases() {
        for _ in 0..3 {
            systems.check(&*case.model(), case.plan());
        }
    }
    assert!(systems.lines > 1000, "{}", systems.lines);
}

/// Returns the residuals of the equations if the unknowns have the values `x`, and all values that
/// follow from these.
fn residuals(
    equations: &[(&str, &str)],
    unknowns: &[&str],
    known: &Values,
    x: &[f64],
) -> (Vec<f64>, Values) {
    let mut values = known.clone();
    for (name, &x) in unknowns.iter().zip(x) {
        values.insert((*name).to_owned(), x);
    }
    follow(equations, &mut values);
    let is_equation =
        |left: &str| left.contains([' ', '·']) || left == "0" || unknowns.contains(&left);
    let residuals = equations.iter().filter(|line| is_equation(line.0));
    let residuals =
        residuals.map(|line| read(line.0, &values).unwrap() - read(line.1, &values).unwrap());
    (residuals.collect(), values)
}

/// Newton's method with a Jacobian by differences.
fn solve(equations: &[(&str, &str)], unknowns: &[&str], known: &Values, mut x: Vec<f64>) -> Values {
    let n = unknowns.len();
    for _ in 0..30 {
        let (r, _) = residuals(equations, unknowns, known, &x);
        assert_eq!(r.len(), n, "as many equations as unknowns");
        let mut rows: Vec<Vec<f64>> = r.iter().map(|&r| vec![-r]).collect();
        for j in (0..n).rev() {
            let mut moved = [x.clone(), x.clone()];
            moved[0][j] += 1e-6;
            moved[1][j] -= 1e-6;
            let [plus, minus] = moved.map(|x| residuals(equations, unknowns, known, &x).0);
            for (row, (plus, minus)) in rows.iter_mut().zip(plus.iter().zip(minus)) {
                row.insert(0, (plus - minus) / 2e-6);
            }
        }
        for (x, step) in x.iter_mut().zip(gauss(rows)) {
            *x += step;
        }
    }
    residuals(equations, unknowns, known, &x).1
}

/// The solution of a linear system whose right side is the last column.
fn gauss(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for j in 0..n {
        let best = (j..n).max_by(|&a, &b| rows[a][j].abs().total_cmp(&rows[b][j].abs()));
        rows.swap(j, best.unwrap());
        let pivot = rows[j].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != j) {
            let factor = row[j] / pivot[j];
            for (entry, &p) in row.iter_mut().zip(&pivot) {
                *entry -= factor * p;
            }
        }
    }
    (0..n).map(|j| rows[j][n] / rows[j][j]).collect()
}

/// Solves the printed equations of a case's step; false where they are cut off.
fn printed_steps_are_the_steps(case: &dyn Case, random: &mut Random) -> bool {
    let (plan, model) = (case.plan(), case.model());
    if plan.formulas.step.contains('…') {
        return false;
    }
    let lines = equations(plan.formulas.step);
    // where a name is only one for what the text writes out there is no block for it
    let written = |unknown: &&str| plan.formulas.step.contains(*unknown);
    let all = plan.blocks.iter().flat_map(|b| b.unknowns.iter().copied());
    let unknowns: Vec<&str> = all.filter(written).collect();
    for _ in 0..3 {
        let start = model.point(random);
        let (h, dw) = (0.05, random.vector(case.dimensions().1, -0.1, 0.1));
        let end = case.stepped(&start, h, &dw);
        let mut known = parameters(&*model);
        known.insert("h".to_owned(), h);
        known.insert("t₀".to_owned(), start.t);
        insert(&mut known, "q₀", &start.q);
        insert(&mut known, "p₀", &start.p);
        insert(&mut known, "ΔW", &dw);
        // several solutions may exist: the search begins near the step's
        let mut guess = Values::new();
        let moved: Vec<f64> = end.q.iter().zip(&start.q).map(|(a, b)| a - b).collect();
        let velocity: Vec<f64> = moved.iter().map(|d| d / h).collect();
        insert(&mut guess, "Δq", &moved);
        insert(&mut guess, "v", &velocity);
        let x = unknowns
            .iter()
            .map(|u| guess.get(*u).copied().unwrap_or(0.0));
        let found = solve(&lines, &unknowns, &known, x.collect());
        for (letter, expected) in [("q₁", &end.q), ("p₁", &end.p)] {
            for (i, &expected) in expected.iter().enumerate() {
                let name = component(letter, i, end.q.len());
                let what = format!("{name} of {}", case.name());
                close(found[&name], expected, SOLVED, &what);
            }
        }
    }
    true
}

#[test]
fn printed_equations_give_the_step() {
    let mut random = Random::new(32);
    let cases = cases();
    let solved = cases
        .iter()
        .map(|case| printed_steps_are_the_steps(&**case, &mut random));
    let solved = solved.filter(|solved| *solved).count();
    // all but chains, whose equations are cut off, and the largest steps of others
    assert!(solved >= 50, "{solved}");
}

/// Compares the printed action with the action of the user's functions; false where there is none.
fn printed_actions_are_the_actions(case: &dyn Case, random: &mut Random) -> bool {
    let (plan, model) = (case.plan(), case.model());
    let (n, m) = case.dimensions();
    let lines = equations(plan.formulas.action);
    // below the textbook form, where it is short enough
    let actions: Vec<_> = lines.iter().filter(|line| line.0 == "S").collect();
    let (Nodes::One(c), [_, (_, text)]) = (case.nodes(), actions.as_slice()) else {
        return false;
    };
    for _ in 0..3 {
        let Point { t, q, p } = model.point(random);
        let (h, dw) = (0.3, random.vector(m, -0.5, 0.5));
        let d = random.vector(n, -0.1, 0.1);
        let v = random.vector(n, -0.5, 0.5);
        let node: Vec<f64> = (0..n).map(|i| q[i] + c * d[i]).collect();
        let time = t + c * h;
        let mut expected = h * model.l(time, &node, &v);
        for i in 0..n {
            expected += p[i] * (d[i] - h * v[i]);
        }
        let g = model.g(time, &node, &p);
        let jets = model.noises(time, &node, &p);
        for a in 0..m {
            expected -= g[a] * dw[a];
            for b in 0..m {
                for i in 0..n {
                    expected += (c - 0.5) * jets[a].dp[i] * jets[b].dq[i] * dw[a] * dw[b];
                }
            }
        }
        let mut known = parameters(&*model);
        known.insert("h".to_owned(), h);
        insert(&mut known, "ΔW", &dw);
        let vectors = [
            ("v", &v),
            ("p", &p),
            ("Δq", &d),
            ("q₀", &q),
            ("q̄", &node),
            ("q₁", &node),
        ];
        for (letter, vector) in vectors {
            insert(&mut known, letter, vector);
        }
        for (letter, time) in [("t₀", t), ("t̄", time), ("t₁", time)] {
            known.insert(letter.to_owned(), time);
        }
        // parts of it, whose names begin with a small letter
        let is_part = |line: &&(&str, &str)| line.0.starts_with(|c: char| c.is_ascii_lowercase());
        let parts: Vec<_> = lines.iter().filter(is_part).copied().collect();
        follow(&parts, &mut known);
        let what = format!("S of {}", case.name());
        close(read(text, &known).unwrap(), expected, ROUNDING, &what);
    }
    true
}

#[test]
fn printed_actions_have_the_values_of_the_users_functions() {
    let mut random = Random::new(33);
    let cases = cases();
    let read = cases
        .iter()
        .map(|case| printed_actions_are_the_actions(&**case, &mut random));
    let read = read.filter(|read| *read).count();
    assert!(read >= 35, "{read}");
}
