//! Statements of a body: blocks, `let`, loops, assignments.

use std::collections::HashMap;

use syn::{Block, Expr as Syntax, ExprForLoop, Item, Pat, RangeLimits, Stmt, UseTree};

use super::Lowering;
use super::branches::LoopExit;
use super::calls::Argument;
use super::constants::{CONSTANTS, float_constant, imported_module};
use super::expressions::no_macro;
use super::integers::{Integer, common};
use super::places::variable_name;
use super::value::Value;

impl Lowering<'_> {
    /// Executes a block in a new scope and returns the value of its last expression.
    pub(super) fn block_value(&mut self, block: &Block) -> Value {
        self.scopes.push(HashMap::new());
        // items are visible in the whole block, also before their definition
        for statement in &block.stmts {
            if let Stmt::Item(item) = statement {
                self.item(item);
            }
        }
        let mut last = Value::Unit;
        for statement in &block.stmts {
            if !self.tick(statement) {
                last = Value::Poison;
                break;
            }
            last = self.statement(statement);
            if self.leaving.is_some() {
                break;
            }
        }
        self.scopes.pop();
        last
    }

    fn statement(&mut self, statement: &Stmt) -> Value {
        match statement {
            Stmt::Local(local) => {
                let value = match &local.init {
                    Some(init) if init.diverge.is_none() => {
                        let value = self.initial(&init.expr);
                        match &local.pat {
                            Pat::Type(typed) => self.number(value, &typed.ty, &init.expr),
                            _ => value,
                        }
                    }
                    Some(_) => {
                        self.poison_names(&local.pat);
                        return self
                            .refuse(local, "`let … else` branches: a body is straight-line code");
                    }
                    None => {
                        self.declare(&local.pat);
                        return Value::Unit;
                    }
                };
                self.bind(&local.pat, value);
                Value::Unit
            }
            Stmt::Expr(expr, semicolon) => {
                let value = self.eval(expr);
                match (semicolon, value) {
                    (_, Value::Poison) => Value::Poison,
                    (None, value) => value,
                    (Some(_), _) => Value::Unit,
                }
            }
            Stmt::Item(_) => Value::Unit,
            Stmt::Macro(mac) => self.refuse(&mac.mac.path, no_macro(&mac.mac.path)),
        }
    }

    /// Evaluates the initial value of a variable. A reference is moved, not followed.
    fn initial(&mut self, expr: &Syntax) -> Value {
        let held = variable_name(expr).and_then(|name| self.held(&name));
        match held {
            Some(reference @ Value::Place(_)) => reference.clone(),
            _ => self.eval(expr),
        }
    }

    /// Executes an item inside a body: `const`, or `use` of `std::f64::consts`.
    fn item(&mut self, item: &Item) {
        match item {
            Item::Const(constant) => {
                let value = self.eval(&constant.expr);
                let value = self.ascribed(value, &constant.ty);
                let value = self.number(value, &constant.ty, &constant.expr);
                if let Some(scope) = self.scopes.last_mut() {
                    scope.insert(constant.ident.to_string(), value);
                }
            }
            Item::Use(import) => self.import(&import.tree),
            _ => {
                if let (Item::Fn(function), Some(scope)) = (item, self.scopes.last_mut()) {
                    scope.insert(function.sig.ident.to_string(), Value::Poison);
                }
                self.refuse(item, "items inside a body are not seen: make it a function or constant of this `impl` block");
            }
        }
    }

    /// Imports the constants of `use std::f64::consts::{PI, TAU}`, and the modules of `use std::f64::consts` and `use std::f64`. Ignores other imports, whose names are
    /// reported where they are used.
    fn import(&mut self, tree: &UseTree) {
        let mut tree = tree;
        let mut path = Vec::new();
        while let UseTree::Path(step) = tree {
            path.push(step.ident.to_string());
            tree = &step.tree;
        }
        let path: Vec<&str> = path.iter().map(String::as_str).collect();
        let module = match path.as_slice() {
            ["std" | "core", "f64", "consts"] => None,
            ["std" | "core", "f64"] => Some("consts"),
            ["std" | "core"] => Some("f64"),
            _ => {
                if let UseTree::Name(name) = tree
                    && (name.ident == "consts" || name.ident == "f64")
                {
                    let message = format!(
                        "`{}` is imported within this body, which generated code does not see: import it outside of this `impl` block",
                        name.ident
                    );
                    self.refuse(name, message);
                }
                return;
            }
        };
        if let (Some(module), UseTree::Name(name)) = (module, tree) {
            if let Some(scope) = self.scopes.last_mut().filter(|_| name.ident == module) {
                scope.insert(imported_module(module), Value::Tuple(Vec::new()));
            }
            return;
        }
        if module.is_some() {
            return;
        }
        let trees: Vec<&UseTree> = match tree {
            UseTree::Group(group) => group.items.iter().collect(),
            one => vec![one],
        };
        for tree in trees {
            if matches!(tree, UseTree::Glob(_)) {
                for (name, value) in CONSTANTS {
                    self.bind_constant(name, *value);
                }
                continue;
            }
            let (name, alias) = match tree {
                UseTree::Name(name) => (name.ident.to_string(), name.ident.to_string()),
                UseTree::Rename(rename) => (rename.ident.to_string(), rename.rename.to_string()),
                _ => continue,
            };
            if let Some(value) = float_constant(&name) {
                self.bind_constant(&alias, value);
            }
        }
    }

    /// Binds a name to a constant in the innermost scope.
    fn bind_constant(&mut self, name: &str, value: f64) {
        let value = Value::Scalar(self.arena.constant(value));
        if let Some(scope) = self.scopes.last_mut() {
            scope.insert(name.to_owned(), value);
        }
    }

    pub(super) fn for_loop(&mut self, for_loop: &ExprForLoop) -> Value {
        let items = match &*for_loop.expr {
            Syntax::Reference(reference) if reference.mutability.is_some() => Argument {
                value: self.iterate_mutably(&reference.expr, reference.and_token.span),
                at: reference.and_token.span,
            },
            _ => self.argument(&for_loop.expr),
        };
        let Some(items) = self.items(&items, None) else {
            return Value::Poison;
        };
        let items = Self::as_indices(items, &for_loop.pat, &for_loop.body);
        let mistakes = self.errors.count();
        for item in items {
            if !self.tick(&for_loop.for_token) {
                return Value::Poison;
            }
            self.scopes.push(HashMap::new());
            self.bind(&for_loop.pat, item);
            self.block_value(&for_loop.body);
            self.scopes.pop();
            if self.errors.count() > mistakes {
                // the next iteration would repeat the error
                return Value::Poison;
            }
            if self.leaving.take() == Some(LoopExit::Break) {
                break;
            }
        }
        Value::Unit
    }

    /// Evaluates the iterators `A..B` and `A..=B`.
    pub(super) fn range(&mut self, range: &syn::ExprRange) -> Value {
        let (Some(start), Some(end)) = (&range.start, &range.end) else {
            return self.refuse(
                range,
                "both bounds are needed, `A..B`: to count, use `enumerate`",
            );
        };
        let Some((from, to)) = self.bound(start).zip(self.bound(end)) else {
            return Value::Poison;
        };
        let kind = match common(from, to) {
            Ok(kind) => kind,
            Err(kinds) => return self.two_kinds(kinds, range),
        };
        let (from, to) = (from.value, to.value);
        let to = match range.limits {
            RangeLimits::HalfOpen(_) => to,
            RangeLimits::Closed(_) => to.saturating_add(1),
        };
        let rounds = to.saturating_sub(from);
        if rounds > super::STEPS as i64 {
            let message = format!(
                "this range has {rounds} rounds, too many to unroll; the limit is {}",
                super::STEPS
            );
            return self.refuse(range, message);
        }
        Value::Sequence(
            (from..to)
                .map(|value| Value::Int(Integer { value, kind }))
                .collect(),
        )
    }

    fn bound(&mut self, expr: &Syntax) -> Option<Integer> {
        match self.eval(expr) {
            Value::Int(bound) => Some(bound),
            Value::Poison => None,
            Value::Field(path) if path.unseen().is_some() => {
                self.refuse(expr, path.unseen().unwrap_or_default());
                None
            }
            other => {
                let message = format!(
                    "the bounds of a loop must be known at compile time (a literal, `q.len()`, a constant `Self::N` of this block), and this is {}",
                    other.kind()
                );
                self.refuse(expr, message);
                None
            }
        }
    }
}
