//! Statements of a body: blocks, `let`, loops, assignments.

use syn::spanned::Spanned;
use syn::{Block, Expr as Syntax, ExprForLoop, Item, Pat, RangeLimits, Stmt, UseTree};

use super::Lowering;
use super::branches::LoopExit;
use super::calls::Argument;
use super::constants::{CONSTANTS, float_constant, imported_module};
use super::expressions::no_macro;
use super::integers::Integer;
use super::places::variable_name;
use super::value::Value;

impl Lowering<'_> {
    /// Executes a block in a new scope and returns the value of its last expression.
    pub(super) fn block_value(&mut self, block: &Block) -> Option<Value> {
        self.scoped(|this| {
            // items are visible in the whole block, also before their definition
            for statement in &block.stmts {
                if let Stmt::Item(item) = statement {
                    this.item(item);
                }
            }
            this.statements(&block.stmts)
        })
    }

    /// Executes the statements of a block. A `continue` under a condition that is known when the
    /// program runs puts the rest under its negation.
    fn statements(&mut self, statements: &[Stmt]) -> Option<Value> {
        let mut last = Some(Value::Unit);
        for (at, statement) in statements.iter().enumerate() {
            self.tick(statement)?;
            last = self.statement(statement);
            if self.leaving.is_some() {
                break;
            }
            if let Some(condition) = self.scene.rest() {
                let rest = &statements[at + 1..];
                self.rest_of_block(rest, condition, |this| this.statements(rest));
                return Some(Value::Unit);
            }
        }
        last
    }

    fn statement(&mut self, statement: &Stmt) -> Option<Value> {
        match statement {
            Stmt::Local(local) => {
                let Some(init) = &local.init else {
                    self.declare(&local.pat, &Value::Unset);
                    return Some(Value::Unit);
                };
                if init.diverge.is_some() {
                    self.declare(&local.pat, &Value::Poison);
                    let message = "`let … else` branches: a body is straight-line code";
                    return self.refuse(local, message);
                }
                let mut value = self.initial(&init.expr);
                if let Pat::Type(typed) = &local.pat {
                    value = self.number(value, &typed.ty, &init.expr);
                }
                self.bind(&local.pat, value);
                Some(Value::Unit)
            }
            Stmt::Expr(expr, semicolon) => {
                let value = self.eval(expr)?;
                Some(semicolon.map_or(value, |_| Value::Unit))
            }
            Stmt::Item(_) => Some(Value::Unit),
            Stmt::Macro(mac) => self.refuse(&mac.mac.path, no_macro(&mac.mac.path)),
        }
    }

    /// Evaluates the initial value of a variable. A reference is moved, not followed.
    fn initial(&mut self, expr: &Syntax) -> Value {
        let held = variable_name(expr).and_then(|name| self.frame.held(&name));
        match held {
            Some(reference @ Value::Place(_)) => reference.clone(),
            _ => self.value(expr),
        }
    }

    /// Executes an item inside a body: `const`, or `use` of `std::f64::consts`.
    fn item(&mut self, item: &Item) {
        match item {
            Item::Const(constant) => {
                let value = self.value(&constant.expr);
                let value = self.ascribed(value, &constant.ty);
                let value = self.number(value, &constant.ty, &constant.expr);
                self.frame.set(&constant.ident, value);
            }
            Item::Use(import) => self.import(&import.tree),
            _ => {
                if let Item::Fn(function) = item {
                    self.frame.set(&function.sig.ident, Value::Poison);
                }
                self.errors.push(item.span(), "items inside a body are not seen: make it a function or constant of this `impl` block");
            }
        }
    }

    /// Imports the constants of `use std::f64::consts::{PI, TAU}`, and the modules of
    /// `use std::f64::consts` and `use std::f64`. Ignores other imports, whose names are reported
    /// where they are used.
    fn import(&mut self, tree: &UseTree) {
        let mut tree = tree;
        let mut path = Vec::new();
        while let UseTree::Path(step) = tree {
            path.push(step.ident.to_string());
            tree = &step.tree;
        }
        let path: Vec<&str> = path.iter().map(String::as_str).collect();
        let module = match path.as_slice() {
            ["std" | "core", "f64", "consts"] => return self.import_constants(tree),
            ["std" | "core", "f64"] => "consts",
            ["std" | "core"] => "f64",
            _ => {
                if let UseTree::Name(name) = tree
                    && (name.ident == "consts" || name.ident == "f64")
                {
                    let message = format!(
                        "`{}` is imported within this body, which generated code does not see: import it outside of this `impl` block",
                        name.ident
                    );
                    self.errors.push(name.span(), message);
                }
                return;
            }
        };
        if let UseTree::Name(name) = tree
            && name.ident == module
        {
            let module = imported_module(module);
            self.frame.set(&module, Value::Tuple(Vec::new()));
        }
    }

    /// Binds the constants of `std::f64::consts` that are imported, in the innermost scope.
    fn import_constants(&mut self, tree: &UseTree) {
        let (name, alias) = match tree {
            UseTree::Group(group) => {
                return group
                    .items
                    .iter()
                    .for_each(|tree| self.import_constants(tree));
            }
            UseTree::Glob(_) => {
                for &(name, value) in CONSTANTS {
                    let value = self.constant(value);
                    self.frame.set(name, value);
                }
                return;
            }
            UseTree::Name(name) => (&name.ident, &name.ident),
            UseTree::Rename(rename) => (&rename.ident, &rename.rename),
            UseTree::Path(_) => return,
        };
        if let Some(value) = float_constant(&name.to_string()) {
            let value = self.constant(value);
            self.frame.set(alias, value);
        }
    }

    pub(super) fn for_loop(&mut self, for_loop: &ExprForLoop) -> Option<Value> {
        let items = match &*for_loop.expr {
            Syntax::Reference(reference) if reference.mutability.is_some() => {
                let at = reference.and_token.span;
                let value = self.iterate_mutably(&reference.expr, at)?;
                Argument { value, at }
            }
            _ => self.argument(&for_loop.expr),
        };
        if let Some(stream) = self.stream(&items.value) {
            return self.kept_loop(&stream, for_loop);
        }
        let items = self.items(&items, None)?;
        let items = Self::as_indices(items, &for_loop.pat, &for_loop.body);
        let mistakes = self.errors.count();
        for item in items {
            self.tick(&for_loop.for_token)?;
            self.unrolled(|this| {
                this.bind(&for_loop.pat, item);
                this.block_value(&for_loop.body);
            });
            if self.errors.count() > mistakes {
                // the next iteration would repeat the error
                return None;
            }
            if self.end_round() == Some(LoopExit::Break) {
                break;
            }
        }
        Some(Value::Unit)
    }

    /// Evaluates the iterators `A..B` and `A..=B`.
    pub(super) fn range(&mut self, range: &syn::ExprRange) -> Option<Value> {
        let (Some(start), Some(end)) = (&range.start, &range.end) else {
            return self.refuse(
                range,
                "both bounds are needed, `A..B`: to count, use `enumerate`",
            );
        };
        let bounds = [start, end].map(|bound| self.value(bound));
        if let Some(stream) = self.running_range(range, [&bounds[0], &bounds[1]]) {
            return Some(stream);
        }
        let [from, to] = bounds;
        let (from, to) = self.bound(from, start).zip(self.bound(to, end))?;
        let kind = self.common(from, to, range).ok()?;
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
        let items = (from..to).map(|value| Value::Int(Integer { value, kind }));
        Some(Value::Sequence(items.collect()))
    }

    fn bound(&mut self, bound: Value, expr: &Syntax) -> Option<Integer> {
        let message = match bound {
            Value::Int(bound) => return Some(bound),
            Value::Poison => return None,
            other => other.unseen().unwrap_or_else(|| format!(
                "the bounds of a loop must be known at compile time (a literal, `q.len()`, a constant `Self::N` of this block), and this is {}",
                other.kind()
            )),
        };
        self.refuse(expr, message)
    }
}
