//! Statements and expressions of a body.

use std::collections::HashMap;

use syn::spanned::Spanned;
use syn::{BinOp, Block, Expr as Syntax, ExprForLoop, Lit, RangeLimits, Stmt, UnOp};

use super::Lowering;
use super::value::{FieldPath, Value};
use crate::errors::nearest;

/// Nesting of expressions in a source text that is followed.
const DEPTH: usize = 200;

impl Lowering<'_> {
    /// Runs a block in a scope of its own; the value of its last expression.
    pub(super) fn block_value(&mut self, block: &Block) -> Value {
        self.scopes.push(HashMap::new());
        let mut last = Value::Unit;
        for statement in &block.stmts {
            if !self.tick(statement.span()) {
                last = Value::Poison;
                break;
            }
            last = self.statement(statement);
        }
        self.scopes.pop();
        last
    }

    fn statement(&mut self, statement: &Stmt) -> Value {
        match statement {
            Stmt::Local(local) => {
                let value = match &local.init {
                    Some(init) if init.diverge.is_none() => self.eval(&init.expr),
                    Some(_) => self.refuse(local, "`let … else` branches: a body is straight-line code"),
                    None => self.refuse(local, "give this variable a value where it is declared, as in `let mut x = 0.0;`"),
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
            Stmt::Item(item) => self.refuse(item, "items inside a body are not seen: make it a function or constant of this `impl` block"),
            Stmt::Macro(mac) => self.refuse(&mac.mac.path, "a macro call cannot be differentiated: write the formula"),
        }
    }

    /// Reports a mistake and goes on with a poisoned value.
    pub(super) fn refuse(&mut self, at: &impl Spanned, message: impl std::fmt::Display) -> Value {
        self.errors.push(at.span(), message);
        Value::Poison
    }

    /// The value of an expression.
    pub(super) fn eval(&mut self, expr: &Syntax) -> Value {
        if !self.tick(expr.span()) {
            return Value::Poison;
        }
        if self.depth >= DEPTH {
            return self.refuse(
                expr,
                format!(
                    "this expression is nested more than {DEPTH} deep: name parts of it with `let`"
                ),
            );
        }
        self.depth += 1;
        let value = self.eval_inner(expr);
        self.depth -= 1;
        value
    }

    fn eval_inner(&mut self, expr: &Syntax) -> Value {
        match expr {
            Syntax::Lit(literal) => self.literal(&literal.lit),
            Syntax::Paren(inner) => self.eval(&inner.expr),
            Syntax::Group(inner) => self.eval(&inner.expr),
            Syntax::Reference(reference) if reference.mutability.is_none() => {
                self.eval(&reference.expr)
            }
            Syntax::Path(path) => self.path(path),
            Syntax::Unary(unary) => self.unary(unary),
            Syntax::Binary(binary) => self.binary(binary),
            Syntax::Field(field) => self.field(field),
            Syntax::Index(index) => self.index(index),
            Syntax::Array(array) => {
                Value::Array(array.elems.iter().map(|e| self.eval(e)).collect())
            }
            Syntax::Tuple(tuple) if tuple.elems.is_empty() => Value::Unit,
            Syntax::Tuple(tuple) => {
                Value::Tuple(tuple.elems.iter().map(|e| self.eval(e)).collect())
            }
            Syntax::Repeat(repeat) => self.repeat(repeat),
            Syntax::Block(block) if block.label.is_none() => self.block_value(&block.block),
            Syntax::ForLoop(for_loop) => self.for_loop(for_loop),
            Syntax::Assign(assign) => {
                let value = self.eval(&assign.right);
                self.store(&assign.left, value);
                Value::Unit
            }
            Syntax::Call(call) => self.call(call),
            Syntax::MethodCall(call) => self.method_call(call),
            other => {
                let (at, message) = refusal(other);
                self.refuse(&at, message)
            }
        }
    }

    fn literal(&mut self, literal: &Lit) -> Value {
        match literal {
            Lit::Float(float) if matches!(float.suffix(), "" | "f64") => {
                match float.base10_parse::<f64>() {
                    Ok(value) if value.is_finite() => Value::Scalar(self.arena.constant(value)),
                    _ => self.refuse(literal, "this number does not fit into an `f64`"),
                }
            }
            Lit::Int(int) if int.suffix() == "f64" => match int.base10_parse::<f64>() {
                Ok(value) => Value::Scalar(self.arena.constant(value)),
                Err(_) => self.refuse(literal, "this number does not fit into an `f64`"),
            },
            Lit::Int(int) => match int.base10_parse::<i64>() {
                Ok(value) => Value::Int(value),
                Err(_) => self.refuse(literal, "this integer is too large"),
            },
            Lit::Float(_) => self.refuse(literal, "every number of a body is an `f64`"),
            _ => self.refuse(literal, "only numbers have a place here"),
        }
    }

    fn path(&mut self, expr: &syn::ExprPath) -> Value {
        let path = &expr.path;
        if let Some(ident) = path.get_ident() {
            let name = ident.to_string();
            if name == "self" {
                return Value::Field(FieldPath::new());
            }
            if let Some(value) = self.scopes.iter().rev().find_map(|scope| scope.get(&name)) {
                return value.clone();
            }
            if self.constant_named(&name).is_some() {
                return self.refuse(
                    expr,
                    format!("a constant of this block is written `Self::{name}`"),
                );
            }
            let known: Vec<&str> = self
                .scopes
                .iter()
                .flat_map(|scope| scope.keys().map(String::as_str))
                .collect();
            let mut known: Vec<&str> = known;
            known.sort_unstable();
            let hint = nearest(&name, known)
                .map(|near| format!("; did you mean `{near}`?"))
                .unwrap_or_default();
            return self.refuse(
                expr,
                format!("`{name}` is not known here{hint} Constants from outside are not seen: make it `const {name}: f64 = …;` in this block and write `Self::{name}`, or a field of the struct"),
            );
        }
        self.long_path(expr)
    }

    fn unary(&mut self, unary: &syn::ExprUnary) -> Value {
        let value = self.eval(&unary.expr);
        match (&unary.op, value) {
            (_, Value::Poison) => Value::Poison,
            (UnOp::Neg(_), Value::Int(i)) => Value::Int(-i),
            (UnOp::Neg(_), value) => match self.scalar(&value, unary.expr.span()) {
                Some(x) => Value::Scalar(self.arena.neg(x)),
                None => Value::Poison,
            },
            (UnOp::Deref(_), value) => value,
            (op, _) => self.refuse(op, "this operator has no derivative"),
        }
    }

    fn binary(&mut self, binary: &syn::ExprBinary) -> Value {
        let right = |this: &mut Self| this.eval(&binary.right);
        if let Some(op) = compound(&binary.op) {
            let left = self.eval(&binary.left);
            let right = right(self);
            let value = self.arithmetic(
                op,
                &binary.op,
                (&left, &binary.left),
                (&right, &binary.right),
            );
            self.store(&binary.left, value);
            return Value::Unit;
        }
        let Some(op) = plain(&binary.op) else {
            let message = match binary.op {
                BinOp::Rem(_) | BinOp::RemAssign(_) => {
                    "`%` is not smooth: an angle needs no reduction, use `sin` and `cos`"
                }
                BinOp::Eq(_)
                | BinOp::Ne(_)
                | BinOp::Lt(_)
                | BinOp::Le(_)
                | BinOp::Gt(_)
                | BinOp::Ge(_) => {
                    "a comparison is not smooth: a Lagrangian is one formula everywhere; use a smooth transition such as `tanh`"
                }
                _ => "this operator has no derivative",
            };
            return self.refuse(&binary.op, message);
        };
        let left = self.eval(&binary.left);
        let right = right(self);
        self.arithmetic(
            op,
            &binary.op,
            (&left, &binary.left),
            (&right, &binary.right),
        )
    }

    fn arithmetic(
        &mut self,
        op: char,
        token: &BinOp,
        left: (&Value, &Syntax),
        right: (&Value, &Syntax),
    ) -> Value {
        if let (Value::Int(a), Value::Int(b)) = (left.0, right.0) {
            let result = match op {
                '+' => a.checked_add(*b),
                '-' => a.checked_sub(*b),
                '*' => a.checked_mul(*b),
                _ => a.checked_div(*b),
            };
            return match result {
                Some(value) => Value::Int(value),
                None => self.refuse(
                    token,
                    "this integer arithmetic overflows or divides by zero",
                ),
            };
        }
        let a = self.scalar(left.0, left.1.span());
        let b = self.scalar(right.0, right.1.span());
        let (Some(a), Some(b)) = (a, b) else {
            return Value::Poison;
        };
        let value = match op {
            '+' => self.arena.add(a, b),
            '-' => self.arena.sub(a, b),
            '*' => self.arena.mul(a, b),
            _ => {
                if self.arena.constant_value(b) == Some(0.0) {
                    return self.refuse(right.1, "this divides by zero");
                }
                self.arena.div(a, b)
            }
        };
        match self.arena.constant_value(value) {
            Some(constant) if !constant.is_finite() => {
                self.refuse(token, "this constant overflows an `f64`")
            }
            _ => Value::Scalar(value),
        }
    }

    fn field(&mut self, field: &syn::ExprField) -> Value {
        match (self.eval(&field.base), &field.member) {
            (Value::Poison, _) => Value::Poison,
            (Value::Field(path), member) => Value::Field(path.member(member)),
            (Value::Tuple(values), syn::Member::Unnamed(index))
                if (index.index as usize) < values.len() =>
            {
                values[index.index as usize].clone()
            }
            (other, _) => {
                let message = format!("{} has no such field", other.kind());
                self.refuse(&field.member, message)
            }
        }
    }

    fn index(&mut self, index: &syn::ExprIndex) -> Value {
        let base = self.eval(&index.expr);
        let Some(at) = self.index_value(&index.index) else {
            return Value::Poison;
        };
        match base {
            Value::Poison => Value::Poison,
            Value::Field(path) => Value::Field(path.index(at)),
            Value::Array(values) => match values.get(at) {
                Some(value) => value.clone(),
                None => self.refuse(
                    &index.index,
                    format!(
                        "index {at} is out of range: the array has {} entries, the last is [{}]",
                        values.len(),
                        values.len().saturating_sub(1)
                    ),
                ),
            },
            other => {
                let message = format!("{} cannot be indexed", other.kind());
                self.refuse(&index.expr, message)
            }
        }
    }

    fn index_value(&mut self, expr: &Syntax) -> Option<usize> {
        match self.eval(expr) {
            Value::Int(i) if i >= 0 => usize::try_from(i).ok(),
            Value::Poison => None,
            Value::Int(i) => {
                self.refuse(expr, format!("index {i} is negative"));
                None
            }
            other => {
                let message = format!(
                    "an index must be known at compile time (a literal, a loop variable, a constant of this block), and this is {}",
                    other.kind()
                );
                self.refuse(expr, message);
                None
            }
        }
    }

    fn repeat(&mut self, repeat: &syn::ExprRepeat) -> Value {
        let value = self.eval(&repeat.expr);
        match self.index_value(&repeat.len) {
            Some(n) if n <= super::STEPS / 100 => Value::Array(vec![value; n]),
            Some(n) => self.refuse(
                &repeat.len,
                format!("an array of {n} entries is too large to unroll"),
            ),
            None => Value::Poison,
        }
    }

    fn for_loop(&mut self, for_loop: &ExprForLoop) -> Value {
        let items = match &*for_loop.expr {
            Syntax::Range(range) => self.range(range),
            other => match self.eval(other) {
                Value::Array(values) => Some(values),
                Value::Poison => None,
                value => {
                    let message = format!(
                        "a loop runs over a range `A..B` with bounds known at compile time or over an array, and this is {}",
                        value.kind()
                    );
                    self.refuse(other, message);
                    None
                }
            },
        };
        let Some(items) = items else {
            return Value::Poison;
        };
        let mistakes = self.errors.count();
        for item in items {
            if !self.tick(for_loop.for_token.span) {
                return Value::Poison;
            }
            self.scopes.push(HashMap::new());
            self.bind(&for_loop.pat, item);
            self.block_value(&for_loop.body);
            self.scopes.pop();
            if self.errors.count() > mistakes {
                // the same mistake in the next round would be the same error
                return Value::Poison;
            }
        }
        Value::Unit
    }

    fn range(&mut self, range: &syn::ExprRange) -> Option<Vec<Value>> {
        let (Some(start), Some(end)) = (&range.start, &range.end) else {
            self.refuse(range, "a loop needs both bounds: `A..B`");
            return None;
        };
        let (from, to) = (self.eval(start), self.eval(end));
        match (from, to) {
            (Value::Int(from), Value::Int(to)) => {
                let to = match range.limits {
                    RangeLimits::HalfOpen(_) => to,
                    RangeLimits::Closed(_) => to.saturating_add(1),
                };
                if to.saturating_sub(from) > super::STEPS as i64 {
                    self.refuse(
                        range,
                        format!(
                            "this loop has {} rounds, too many to unroll; the limit is {}",
                            to.saturating_sub(from),
                            super::STEPS
                        ),
                    );
                    return None;
                }
                Some((from..to).map(Value::Int).collect())
            }
            (Value::Poison, _) | (_, Value::Poison) => None,
            (Value::Int(_), other) => {
                let message = format!(
                    "the bounds of a loop must be known at compile time (a literal, `q.len()`, a constant of this block), and this is {}",
                    other.kind()
                );
                self.refuse(end, message);
                None
            }
            (other, _) => {
                let message = format!(
                    "the bounds of a loop must be known at compile time (a literal, a constant of this block), and this is {}",
                    other.kind()
                );
                self.refuse(start, message);
                None
            }
        }
    }

    /// Assigns to a variable, an entry or a component.
    fn store(&mut self, place: &Syntax, value: Value) {
        let mut path = Vec::new();
        let mut base = place;
        let name = loop {
            match base {
                Syntax::Index(index) => {
                    let Some(at) = self.index_value(&index.index) else {
                        return;
                    };
                    path.push((at, index.index.span()));
                    base = &index.expr;
                }
                Syntax::Field(field) if matches!(&field.member, syn::Member::Unnamed(_)) => {
                    if let syn::Member::Unnamed(index) = &field.member {
                        path.push((index.index as usize, index.span));
                    }
                    base = &field.base;
                }
                Syntax::Paren(inner) => base = &inner.expr,
                Syntax::Path(path) if path.path.get_ident().is_some() => {
                    break path.path.get_ident().map(ToString::to_string);
                }
                other => {
                    self.refuse(
                        other,
                        "only a local variable, or an entry of one, can be assigned to",
                    );
                    return;
                }
            }
        };
        let slot = name.and_then(|name| {
            self.scopes
                .iter_mut()
                .rev()
                .find_map(|scope| scope.get_mut(&name))
        });
        let Some(mut slot) = slot else {
            self.refuse(base, "this variable is not known here");
            return;
        };
        for (at, span) in path.into_iter().rev() {
            let kind = slot.kind();
            slot = match slot {
                Value::Poison => return,
                Value::Array(values) | Value::Tuple(values) => match values.get_mut(at) {
                    Some(entry) => entry,
                    None => {
                        return self
                            .errors
                            .push(span, format!("index {at} is out of range of {kind}"));
                    }
                },
                _ => return self.errors.push(span, format!("{kind} cannot be indexed")),
            };
        }
        *slot = value;
    }
}

fn plain(op: &BinOp) -> Option<char> {
    match op {
        BinOp::Add(_) => Some('+'),
        BinOp::Sub(_) => Some('-'),
        BinOp::Mul(_) => Some('*'),
        BinOp::Div(_) => Some('/'),
        _ => None,
    }
}

fn compound(op: &BinOp) -> Option<char> {
    match op {
        BinOp::AddAssign(_) => Some('+'),
        BinOp::SubAssign(_) => Some('-'),
        BinOp::MulAssign(_) => Some('*'),
        BinOp::DivAssign(_) => Some('/'),
        _ => None,
    }
}

/// What to say of syntax outside the language, and at which token.
fn refusal(expr: &Syntax) -> (proc_macro2::Span, &'static str) {
    match expr {
        Syntax::If(e) => (
            e.if_token.span,
            "`if` is not smooth: a Lagrangian is one formula everywhere; use a smooth transition such as `tanh`",
        ),
        Syntax::Match(e) => (
            e.match_token.span,
            "`match` is not smooth: a Lagrangian is one formula everywhere",
        ),
        Syntax::While(e) => (
            e.while_token.span,
            "the rounds of `while` are not known at compile time: write `for i in A..B`",
        ),
        Syntax::Loop(e) => (
            e.loop_token.span,
            "the rounds of `loop` are not known at compile time: write `for i in A..B`",
        ),
        Syntax::Cast(e) => (
            e.as_token.span,
            "`as` is not understood: write the number as a float, `2.0`",
        ),
        Syntax::Closure(e) => (
            e.span(),
            "closures are not understood: make it a function of this `impl` block, or a `for` loop",
        ),
        Syntax::Macro(e) => (
            e.mac.path.span(),
            "a macro call cannot be differentiated: write the formula",
        ),
        Syntax::Return(e) => (
            e.return_token.span,
            "`return` is not needed: end the body with the value",
        ),
        Syntax::Break(e) => (
            e.break_token.span,
            "`break` is not understood: a body is straight-line code",
        ),
        Syntax::Continue(e) => (
            e.continue_token.span,
            "`continue` is not understood: a body is straight-line code",
        ),
        Syntax::Unsafe(e) => (e.unsafe_token.span, "`unsafe` has no place in a formula"),
        Syntax::Try(e) => (
            e.question_token.span,
            "`?` is not understood: a body is straight-line code",
        ),
        Syntax::Struct(e) => (
            e.path.span(),
            "structures are not understood here: use arrays and tuples",
        ),
        Syntax::Range(e) => (e.span(), "a range stands only in a loop, `for i in A..B`"),
        other => (
            other.span(),
            "this expression is not understood: a body is made of `let`, arithmetic, arrays, `for` over constant bounds, helpers of this block and smooth `f64` functions",
        ),
    }
}
