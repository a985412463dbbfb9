//! The operations in the plans against the operations of the emitted code: statements and solves,
//! counted in the tokens.
//!
//! Compares every rule of every model of the workspace's tests, with and without structure (in
//! `lists.rs`, which expands all of them), and of the scenes of `benches/expansion`. Code that runs
//! only after the fast path fails is not counted: the additional functions of a step, and the
//! closure `rounding` of a step without structure.

use std::ops::AddAssign;

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::visit::{self, Visit};
use syn::{Expr, ImplItem, ItemImpl, Lit, Member, Pat, Stmt};

use super::growth::scenes::Scene;
use crate::tests::{expand, expand_compared, items, tokens};

/// Arithmetic operations, calls of functions, and angle additions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts([usize; 3]);

impl AddAssign<(usize, usize)> for Counts {
    fn add_assign(&mut self, (kind, count): (usize, usize)) {
        self.0[kind] += count;
    }
}

const ARITHMETIC: usize = 0;
const CALL: usize = 1;
const ADDITION: usize = 2;

/// Counts operations outside and inside of iterations.
#[derive(Default)]
struct Counter {
    outside: Counts,
    inside: Counts,
    is_inside: bool,
}

impl Counter {
    fn add(&mut self, kind: usize, count: usize) {
        let counts = if self.is_inside {
            &mut self.inside
        } else {
            &mut self.outside
        };
        *counts += (kind, count);
    }

    fn call(&mut self, path: &syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        let last = names[names.len() - 1].as_str();
        let kind = match last {
            "sin_cos_of_sum" => ADDITION,
            "abs" => ARITHMETIC,
            "power_log" => CALL,
            "from_bits" => return,
            _ if names[0] == "f64" => CALL,
            _ => return,
        };
        self.add(kind, 1);
    }
}

impl<'a> Visit<'a> for Counter {
    fn visit_expr(&mut self, expr: &'a Expr) {
        match expr {
            Expr::Binary(binary) => {
                use syn::BinOp::{Add, Div, Mul, Sub};
                if matches!(binary.op, Add(_) | Sub(_) | Mul(_) | Div(_)) {
                    self.add(ARITHMETIC, 1);
                }
            }
            Expr::Unary(unary) => {
                let is_number = matches!(*unary.expr, Expr::Lit(_));
                if matches!(unary.op, syn::UnOp::Neg(_)) && !is_number {
                    self.add(ARITHMETIC, 1);
                }
            }
            Expr::Call(call) => {
                if let Expr::Path(function) = &*call.func {
                    let name = &function.path.segments.last().expect("a name").ident;
                    if name == "solve" || name == "solve_with_sign" {
                        self.add(ARITHMETIC, solve(&call.args[0]));
                    }
                    if name == "factored" {
                        let size = dense_size(&call.args[0]);
                        self.add(ARITHMETIC, dense(size) - substitution(size));
                    }
                    self.call(&function.path);
                }
            }
            Expr::MethodCall(call) if call.method == "solve_block" => {
                let evaluation = call.args.last().expect("an evaluation");
                self.is_inside = true;
                self.visit_expr(evaluation);
                self.is_inside = false;
                return;
            }
            Expr::MethodCall(call) if call.method == "solve" => {
                let Expr::Reference(rhs) = &call.args[0] else {
                    panic!("no right-hand side");
                };
                let Expr::Array(rhs) = &*rhs.expr else {
                    panic!("no right-hand side");
                };
                self.add(ARITHMETIC, substitution(rhs.elems.len()));
            }
            Expr::Struct(literal) => {
                let is_jacobian = |m: &Member| matches!(m, Member::Named(n) if n == "jacobian");
                for field in literal.fields.iter().filter(|f| is_jacobian(&f.member)) {
                    self.add(ARITHMETIC, solve(&field.expr));
                }
            }
            _ => {}
        }
        visit::visit_expr(self, expr);
    }

    fn visit_stmt(&mut self, statement: &'a Stmt) {
        if let Stmt::Local(local) = statement
            && let Pat::Ident(name) = &local.pat
            && name.ident == "rounding"
        {
            return;
        }
        visit::visit_stmt(self, statement);
    }
}

/// Returns the arithmetic operations of the runtime's solve with a matrix, by following its loops.
fn solve(matrix: &Expr) -> usize {
    match matrix {
        Expr::Reference(reference) => solve(&reference.expr),
        Expr::Array(_) | Expr::Block(_) => dense(dense_size(matrix)),
        Expr::Call(call) => {
            let Expr::Path(function) = &*call.func else {
                panic!("no matrix");
            };
            let kind = function.path.segments.last().expect("a name");
            if kind.ident == "Diagonal" {
                let Expr::Array(rows) = &call.args[0] else {
                    panic!("no diagonal");
                };
                return rows.elems.len();
            }
            let syn::PathArguments::AngleBracketed(sizes) = &kind.arguments else {
                panic!("no sizes");
            };
            let sizes: Vec<usize> = sizes
                .args
                .iter()
                .map(|size| match size {
                    syn::GenericArgument::Const(size) => number(size),
                    _ => panic!("no size"),
                })
                .collect();
            banded(sizes[0], sizes[1], sizes[2])
        }
        _ => panic!("no matrix"),
    }
}

/// Returns the number of rows of a dense matrix.
fn dense_size(matrix: &Expr) -> usize {
    match matrix {
        Expr::Reference(reference) => dense_size(&reference.expr),
        Expr::Array(rows) => rows.elems.len(),
        // `{ let mut entries = [[0f64; K]; K]; … }`
        Expr::Block(block) => {
            let Some(Stmt::Local(local)) = block.block.stmts.first() else {
                panic!("no entries");
            };
            match &*local.init.as_ref().expect("zeros").expr {
                Expr::Repeat(rows) => number(&rows.len),
                _ => panic!("no matrix"),
            }
        }
        _ => panic!("no dense matrix"),
    }
}

/// Returns the operations of `Factors::solve` of the runtime.
fn substitution(k: usize) -> usize {
    let mut operations = 0;
    for row in 0..k {
        operations += 2 * row + 2 * (k - row - 1) + 1;
    }
    operations
}

fn number(literal: &Expr) -> usize {
    match literal {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Int(number) => number.base10_parse().expect("a number"),
            _ => panic!("no number"),
        },
        _ => panic!("no number"),
    }
}

/// Returns the operations of `solve::dense` of the runtime.
fn dense(k: usize) -> usize {
    match k {
        0 | 1 => k,
        2 => 3 + 1 + 2 * 4,
        _ => {
            let mut operations = 0;
            for column in 0..k {
                for _ in column + 1..k {
                    // the factor, the right-hand side, and the entries behind the pivot
                    operations += 1 + 2 + 2 * (k - column - 1);
                }
            }
            for row in 0..k {
                operations += 2 * (k - row - 1) + 1;
            }
            operations
        }
    }
}

/// Returns the operations of `Banded::solve_with_sign` of the runtime.
fn banded(k: usize, lower: usize, width: usize) -> usize {
    let mut operations = 0;
    for column in 0..k {
        for _ in column + 1..k.min(column + lower + 1) {
            operations += 1 + 2 + 2 * (width - 1);
        }
        for _ in 1..width.min(k - column) {
            operations += 2;
        }
        operations += 1;
    }
    operations
}

/// Returns the operations of preparation, step and iteration in the plan of an implementation.
fn told(plan: &Expr) -> [Counts; 3] {
    let fields = |expr: &Expr| match expr {
        Expr::Struct(literal) => literal.fields.clone(),
        Expr::Reference(reference) => match &*reference.expr {
            Expr::Struct(literal) => literal.fields.clone(),
            _ => panic!("no plan"),
        },
        _ => panic!("no plan"),
    };
    let field = |expr: &Expr, name: &str| {
        let fields = fields(expr).into_iter();
        let mut named = fields.filter(|f| matches!(&f.member, Member::Named(n) if n == name));
        named.next().expect("a field").expr
    };
    ["prepare", "step", "iteration"].map(|part| {
        let part = field(plan, part);
        Counts(
            ["arithmetic", "transcendental", "angle_additions"]
                .map(|kind| number(&field(&part, kind))),
        )
    })
}

/// Compares the plans of an expansion with its code. Returns the number of rules, and the counts of
/// the last one.
pub(super) fn compare(what: &str, expansion: &TokenStream) -> (usize, [Counts; 3]) {
    let (mut rules, mut last) = (0, [Counts::default(); 3]);
    let implementations = items(expansion.clone()).into_iter();
    let implementations = implementations.filter_map(|item| match item {
        syn::Item::Impl(implementation) => Some(implementation),
        _ => None,
    });
    for ItemImpl { trait_, items, .. } in implementations {
        let is_rule = trait_.as_ref().is_some_and(|(path, _)| {
            let last = path.segments.last().expect("a name");
            // the equations of the Gauss rules are solved by code of the runtime
            let is_solved_there = last
                .arguments
                .to_token_stream()
                .to_string()
                .contains("Gauss");
            last.ident == "StepEquations" && !is_solved_there
        });
        if !is_rule {
            continue;
        }
        let (mut prepare, mut step, mut plan) = (Counter::default(), Counter::default(), None);
        for item in &items {
            match item {
                ImplItem::Const(constant) if constant.ident == "PLAN" => {
                    plan = Some(&constant.expr);
                }
                ImplItem::Fn(f) if f.sig.ident == "prepare" => prepare.visit_block(&f.block),
                ImplItem::Fn(f) if f.sig.ident == "increment" => step.visit_block(&f.block),
                _ => {}
            }
        }
        last = told(plan.expect("a plan"));
        let counted = [prepare.outside, step.outside, step.inside];
        let path = trait_.as_ref().map(|(path, _)| path);
        let rule = quote::quote!(#path).to_string();
        assert_eq!(last, counted, "{what}, {rule}");
        rules += 1;
    }
    assert!(rules > 0, "{what}: {expansion}");
    (rules, last)
}

#[test]
fn plans_tell_the_operations_of_scenes_of_any_size() {
    for scene in Scene::ALL {
        for n in [1, 2, 3, 4, 5, 7, 12] {
            // without structure, derivations of large scenes take long
            let (expand, taylor): (fn(&_, &_) -> _, _) = match n {
                ..=5 => (expand_compared, "taylor2"),
                _ => (expand, ""),
            };
            let rules = format!("initial_point, endpoint, midpoint, {taylor}");
            let expansion = expand(&tokens(&rules), &tokens(&scene.block(n)));
            compare(&format!("{} of {n}", scene.name()), &expansion);
        }
    }
}

/// A chain of 12 masses with hardening springs: its mass matrix is diagonal, and its Jacobian is
/// tridiagonal.
#[test]
fn a_diagonal_mass_matrix_costs_a_division_per_unknown() {
    let block = "impl Chain {
        fn lagrangian(&self, q: [f64; 12], v: [f64; 12]) -> f64 {
            let mut l = 0.0;
            for i in 0..12 { l += 0.5 * self.m * v[i] * v[i]; }
            for i in 1..12 { let x = q[i] - q[i - 1]; l -= 0.5 * self.k * x * x + 0.25 * self.a * x.powi(4); }
            l
        }
    }";
    let expansion = expand(&tokens("midpoint"), &tokens(block));
    let (_, [_, step, iteration]) = compare("chain", &expansion);
    let solve = 12;
    let sums = step.0[ARITHMETIC] - 2 * solve;
    // the second stage of the guess, and q and p at the end, each proportional to the number of
    // masses
    assert!(sums < 14 * 12, "{step:?}");
    assert!(iteration.0[ARITHMETIC] > banded(12, 1, 3), "{iteration:?}");
}
