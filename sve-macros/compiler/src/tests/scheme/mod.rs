//! From Lagrangian and noises to the instructions of a step, on random systems: equations,
//! residuals, Jacobians, momenta and solutions against evaluation of the plain descriptions; and
//! programs with and without sharing of subexpressions.
//!
//! The tests evaluate the scheduled programs. A back end prints each instruction as one statement.

mod solve;
mod system;

use std::collections::HashMap;

use crate::algebra::tests::number::{Bounded, Dual, Number};
use crate::algebra::tests::recipe::{Random, values};
use crate::algebra::{Arena, Expr, Purpose, Symbol};
use crate::catalogue::Rule;
use crate::discretise::equations::equations;
use crate::model::{Meaning, Quantity, Symbols};
use crate::program::tests::run;
use crate::program::{Scheduler, Tier, Tiers};
use crate::rules::action::{Action, Terms, discretise};
use crate::structure::{Iteration, Matrix, Scheme, Solution, analyse};
use solve::solution;
use system::{Point, System, gradient};

/// A random system with its action for a rule.
struct Case {
    system: System,
    point: Point,
    rule: Rule,
    arena: Arena,
    symbols: Symbols,
    action: Action,
}

impl Case {
    fn new(seed: u64, momenta: bool) -> Self {
        let random = &mut Random(seed);
        // the runtime has the equations of stages
        let mut rules = Rule::all();
        rules.retain(|rule| rule.stages().is_none());
        let rule = rules[seed as usize % rules.len()];
        let (system, point) = loop {
            let (system, point) = System::random(random, momenta);
            if rule.takes.noise || point.dw.is_empty() {
                break (system, point);
            }
        };
        let mut arena = Arena::new();
        let model = system.model(&mut arena);
        let mut symbols = model.symbols.clone();
        let action = discretise(rule, &model, None, Terms::NONE, &mut symbols, &mut arena);
        Self {
            system,
            point,
            rule,
            arena,
            symbols,
            action,
        }
    }

    fn scheme(&mut self) -> Scheme<Expr> {
        let equations = equations(&self.action, &self.symbols, &mut self.arena);
        let scheme = analyse(equations, &self.action, &mut self.symbols, &mut self.arena);
        scheme.unwrap_or_else(|_| panic!("{:?} is degenerate", self.system))
    }

    /// Returns the value of a symbol at the point. A symbol of the solution has the value of its
    /// unknown.
    fn value(&self, symbol: Symbol) -> f64 {
        let point = &self.point;
        match self.symbols.meaning(symbol) {
            Meaning::Parameter { .. } => point.m,
            Meaning::Time => point.t,
            Meaning::StepSize => point.h,
            Meaning::Start(Quantity::Position, i) => point.q0[*i],
            Meaning::Start(Quantity::Momentum, i) => point.p0[*i],
            Meaning::Wiener(i) => point.dw[*i],
            Meaning::Position(_)
            | Meaning::Velocity(_)
            | Meaning::Momentum(_)
            | Meaning::Limit(_)
            | Meaning::End(_)
            | Meaning::NodeEntry(_)
            | Meaning::Attitude(_)
            | Meaning::Radius(_)
            | Meaning::Sum(_)
            | Meaning::Slot(_)
            | Meaning::Read(_)
            | Meaning::Total(_)
            | Meaning::Partial => f64::NAN,
            Meaning::Unknown(unknown) => {
                let (list, symbols) = (&self.action.internal, &self.symbols);
                let same = |s: &&Symbol| matches!(symbols.meaning(**s), Meaning::Unknown(u) if u == unknown);
                let find = |list: &[Symbol]| list.iter().position(|s| same(&s));
                match find(list) {
                    Some(at) => point.internal[at],
                    None => find(&self.action.displacement).map_or(f64::NAN, |at| point.d[at]),
                }
            }
        }
    }
}

/// Returns the values of expressions, computed by one program in any type of number.
fn program<T: Number>(
    case: &Case,
    tiers: Tiers,
    exprs: &[Expr],
    at: &dyn Fn(Symbol) -> T,
) -> Vec<T> {
    let mut scheduler = Scheduler::new(&case.arena, &case.symbols, tiers, exprs);
    let results = scheduler.values(exprs);
    let program = scheduler.finish(&results);
    let values = run(&program, at);
    results.iter().map(|v| values[v]).collect()
}

#[test]
fn equations_are_derivatives_of_the_action() {
    let (mut sharp, mut compared) = (0, 0);
    for seed in 0..400 {
        let mut case = Case::new(seed, true);
        let n = case.system.n;
        let mut found = equations(&case.action, &case.symbols, &mut case.arena);
        let exprs = found
            .residuals
            .iter_mut()
            .chain(found.dp.iter_mut().flatten());
        case.arena.stabilise(Purpose::Step, exprs.collect());
        let unknowns = case.action.internal.iter().chain(&case.action.displacement);
        let tiers: Tiers = unknowns.map(|&s| (s, Tier::Iterate(0))).collect();
        let exprs = [found.residuals.clone(), found.dp.concat()].concat();
        let values = program(&case, tiers, &exprs, &|s| Bounded::of(case.value(s)));

        let slope = |along: &dyn Fn(&mut system::Variables<Dual<Bounded>>)| {
            gradient(&case.system, case.rule, &case.point, along)
        };
        let one = Bounded::of(1.0);
        let internal =
            (0..case.action.internal.len()).map(|k| slope(&|x| x.internal[k].slope = one));
        let mut expected: Vec<Bounded> = internal.collect();
        let mut momenta = Vec::new();
        for i in 0..n {
            let end = slope(&|x| x.d[i].slope = one);
            let kick = slope(&|x| x.q0[i].slope = one);
            let p0 = Bounded::of(case.point.p0[i]);
            let balance = end.minus(kick).minus(p0);
            expected.push(balance);
            momenta.extend((0..3).map(|k| kick.plus(balance.scale(f64::from(k)))));
        }
        expected.extend(momenta);
        assert_eq!(values.len(), expected.len());
        for (at, (value, expected)) in values.iter().zip(&expected).enumerate() {
            compared += 1;
            if !(value.is_sharp() && expected.is_sharp()) {
                continue;
            }
            sharp += 1;
            // equations of internal variables may have been divided by a power of h
            let powers = if at < case.action.internal.len() {
                0..3
            } else {
                0..1
            };
            let h = Bounded::of(case.point.h);
            let same = powers
                .into_iter()
                .any(|k| value.times(h.power(k)).agrees(*expected));
            assert!(
                same,
                "seed {seed}, {:?}, entry {at}: {value:?} for {expected:?}\n{:?}",
                case.rule, case.system
            );
        }
    }
    println!("{sharp} of {compared} are sharp");
    assert!(10 * sharp > 9 * compared, "{sharp} of {compared}");
}

/// Returns all expressions of a scheme, and the order in which its unknowns become known, as the
/// emitter sees them.
fn contents(scheme: &Scheme<Expr>) -> (Vec<Expr>, Tiers) {
    let mut tiers = Tiers::new();
    let mut all: Vec<Expr> = [&scheme.dq[..], &scheme.dp].concat();
    for (at, block) in scheme.blocks.iter().enumerate() {
        match &block.solution {
            Solution::Formula(_) => {}
            Solution::System { linear, solved } => {
                tiers.extend(solved.iter().map(|&s| (s, Tier::Solved(at))));
                all.extend(linear.matrix.stored().chain(linear.rhs.clone()));
            }
            Solution::Iteration(iteration) => {
                for (stage, r) in iteration.refinements.iter().enumerate() {
                    tiers.extend(r.first.iter().map(|&s| (s, Tier::Guess(at, stage))));
                    all.extend(&r.rhs);
                }
                tiers.extend(iteration.iterates.iter().map(|&s| (s, Tier::Iterate(at))));
                tiers.extend(iteration.solved.iter().map(|&s| (s, Tier::Solved(at))));
                let (guess, fallback) = (&iteration.guess, &iteration.fallback);
                let matrices = [&guess.matrix, &fallback.matrix, &iteration.jacobian];
                all.extend(matrices.into_iter().flat_map(Matrix::stored));
                let vectors = [&guess.rhs, &fallback.rhs, &iteration.residual];
                all.extend(vectors.into_iter().flatten().chain(&iteration.curvature));
            }
        }
    }
    (all, tiers)
}

/// One program for all expressions, a program for each, and evaluation of the unscheduled nodes
/// agree.
#[test]
fn sharing_changes_nothing() {
    let (mut sharp, mut compared) = (0, 0);
    for seed in 0..300 {
        let mut case = Case::new(seed, true);
        let scheme = case.scheme();
        let (exprs, tiers) = contents(&scheme);
        let at = |s: Symbol| Bounded::of(case.value(s));
        let together = program(&case, tiers.clone(), &exprs, &at);
        let plain = values(&case.arena, &exprs, at);
        for ((&expr, together), plain) in exprs.iter().zip(&together).zip(&plain) {
            let alone = program(&case, tiers.clone(), &[expr], &at)[0];
            compared += 1;
            if !(together.is_sharp() && plain.is_sharp() && alone.is_sharp()) {
                continue;
            }
            sharp += 1;
            assert!(
                together.agrees(*plain),
                "seed {seed}: {together:?} {plain:?}"
            );
            assert!(alone.agrees(*plain), "seed {seed}: {alone:?} {plain:?}");
        }
    }
    println!("{sharp} of {compared} are sharp");
    // a fallback is a step from rest, where not all random functions are defined
    assert!(10 * sharp > 8 * compared, "{sharp} of {compared}");
}

/// Returns the iterations of a scheme.
fn iterations(scheme: &Scheme<Expr>) -> impl Iterator<Item = &Iteration<Expr>> {
    scheme
        .blocks
        .iter()
        .filter_map(|block| match &block.solution {
            Solution::Iteration(iteration) => Some(&**iteration),
            _ => None,
        })
}

/// The emitted Jacobian is the derivative of the emitted residual, and the curvature is the
/// derivative of the Jacobian; both are differentiated instruction by instruction.
#[test]
fn jacobians_are_derivatives_of_residuals() {
    let (mut entries, mut curvatures, mut sharp) = (0, 0, 0);
    for seed in 0..300 {
        let mut case = Case::new(seed, true);
        let scheme = case.scheme();
        let (_, tiers) = contents(&scheme);
        for iteration in iterations(&scheme) {
            let n = iteration.iterates.len();
            let entries_of = |i: usize| iteration.jacobian.row(i).map(move |(j, e)| (i, j, e));
            let jacobian: Vec<(usize, usize, Expr)> = (0..n).flat_map(entries_of).collect();
            let exprs: Vec<Expr> = iteration
                .residual
                .iter()
                .copied()
                .chain(jacobian.iter().map(|x| x.2))
                .chain(iteration.curvature)
                .collect();
            for (j, &iterate) in iteration.iterates.iter().enumerate() {
                let at = |s: Symbol| {
                    let slope = if s == iterate { 1.0 } else { 0.0 };
                    Dual::new(Bounded::of(case.value(s)), slope)
                };
                let found = program(&case, tiers.clone(), &exprs, &at);
                // an entry that is not stored is zero
                let stored = |i: usize| jacobian.iter().position(|x| (x.0, x.1) == (i, j));
                let entry = |i: usize| stored(i).map_or(Bounded::of(0.0), |at| found[n + at].value);
                let mut pairs: Vec<(Bounded, Bounded)> =
                    (0..n).map(|i| (entry(i), found[i].slope)).collect();
                if iteration.curvature.is_some() {
                    pairs.push((found[2].value, found[1].slope));
                    curvatures += 1;
                }
                for (entry, slope) in pairs {
                    entries += 1;
                    if entry.is_sharp() && slope.is_sharp() {
                        sharp += 1;
                        assert!(entry.agrees(slope), "seed {seed}: {entry:?} {slope:?}");
                    }
                }
            }
        }
    }
    println!("{sharp} of {entries} are sharp, {curvatures} curvatures");
    assert!(
        10 * sharp > 9 * entries && curvatures > 50,
        "{sharp} of {entries}"
    );
}

/// If noise moves momenta alone, the displacement is `h v`, and the equation
/// `p₀ + (1 − c) ∂S/∂q̄ − ∂L/∂v` remains.
#[test]
fn residuals_in_the_velocity() {
    let mut compared = 0;
    for seed in 0..400 {
        let mut case = Case::new(seed, false);
        if !case.rule.takes.noise {
            continue;
        }
        let scheme = case.scheme();
        let n = case.system.n;
        let (_, tiers) = contents(&scheme);
        let Some(iteration) = iterations(&scheme).find(|i| i.iterates.len() == n) else {
            continue;
        };
        for i in 0..n {
            case.point.d[i] = case.point.h * case.point.internal[i];
        }
        let found = program(&case, tiers, &iteration.residual, &|s| {
            Bounded::of(case.value(s))
        });
        let one = Bounded::of(1.0);
        let expected: Vec<Bounded> = (0..n)
            .map(|i| {
                let slope = |along: &dyn Fn(&mut system::Variables<Dual<Bounded>>)| {
                    gradient(&case.system, case.rule, &case.point, along)
                };
                // ∂S/∂v_i = h (∂L/∂v_i − p_i), and ∂S/∂d_i = p_i + c g_i
                let p = Bounded::of(case.point.internal[n + i]);
                let momentum = slope(&|x| x.internal[i].slope = one);
                let momentum = momentum.over(Bounded::of(case.point.h)).plus(p);
                let kick = slope(&|x| x.q0[i].slope = one);
                let end = slope(&|x| x.d[i].slope = one).minus(p);
                let p0 = Bounded::of(case.point.p0[i]);
                momentum.plus(end).minus(kick).minus(p0)
            })
            .collect();
        // the order depends on the equation from which the momentum was eliminated
        let agree = |order: &[usize]| (0..n).all(|i| found[i].agrees(expected[order[i]]));
        assert!(
            agree(&[0, 1]) || n == 2 && agree(&[1, 0]),
            "seed {seed}, {:?}: {found:?} for {expected:?}",
            case.rule,
        );
        compared += n;
    }
    println!("{compared} residuals");
    assert!(compared > 100, "{compared}");
}

/// Solving a scheme block by block gives a step of the discrete equations.
#[test]
fn solutions_satisfy_the_discrete_equations() {
    let (mut solved, mut tried) = (0, 0);
    for seed in 0..300 {
        let mut case = Case::new(seed, true);
        let c = match case.rule.attribute_name {
            "initial_point" => 0.0,
            "midpoint" => 0.5,
            "endpoint" => 1.0,
            // in rules with more nodes the momentum is not such a part of its change
            _ => continue,
        };
        tried += 1;
        let scheme = case.scheme();
        let (exprs, tiers) = contents(&scheme);
        let given = |s: Symbol| case.value(s);
        let Some((d, dp)) = solution(&case, &scheme, &exprs, tiers, &given) else {
            continue;
        };
        let n = case.system.n;
        let mut point = case.point.clone();
        point.d.clone_from(&d);
        for i in 0..n {
            point.internal[n + i] = point.p0[i] + (1.0 - c) * dp[i];
        }
        let Some(worst) = solve::residual(&case.system, case.rule, &mut point, &dp) else {
            continue;
        };
        solved += 1;
        // all quantities have the size of 1, and so do the derivatives of the equations
        assert!(worst < 1e-11, "seed {seed}, {:?}: {worst:e}", case.rule);
    }
    println!("{solved} of {tried} steps");
    assert!(10 * solved > 9 * tried, "{solved} of {tried}");
}

/// Symbols with their values.
type Known = HashMap<Symbol, f64>;
