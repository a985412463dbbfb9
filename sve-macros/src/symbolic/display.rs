//! Expressions as readable mathematics, cut off where they grow too long to read.

use super::expr::{Arena, Expr, Function, Node, Symbol};

/// How tightly an expression binds.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binds {
    Sum,
    Product,
    Atom,
}

/// Nesting beyond which an ellipsis is written.
const DEPTH: usize = 12;

impl Arena {
    /// `expr` in mathematical notation, or nothing where it has more than `limit` characters.
    pub(crate) fn display(
        &self,
        expr: Expr,
        limit: usize,
        name: &dyn Fn(Symbol) -> String,
    ) -> Option<String> {
        let mut printer = Printer {
            arena: self,
            name,
            limit,
            out: String::new(),
        };
        printer.print(expr, Binds::Sum, DEPTH);
        (printer.out.len() <= limit).then_some(printer.out)
    }
}

struct Printer<'a> {
    arena: &'a Arena,
    name: &'a dyn Fn(Symbol) -> String,
    limit: usize,
    out: String,
}

impl Printer<'_> {
    fn print(&mut self, expr: Expr, inside: Binds, depth: usize) {
        if depth == 0 || self.out.len() > self.limit {
            self.out.push('…');
            return;
        }
        match self.arena.node(expr) {
            Node::Constant(bits) => self.put(format_args!("{}", bits.get())),
            Node::Symbol(symbol) => self.out.push_str(&(self.name)(*symbol)),
            Node::Opaque(x) => self.print(*x, inside, depth),
            Node::Sum(constant, terms) => {
                let open = inside > Binds::Sum;
                self.bracket(open, '(');
                let mut first = true;
                for (x, c) in terms {
                    self.term(c.get(), *x, first, depth);
                    first = false;
                }
                if constant.get() != 0.0 {
                    let c = constant.get();
                    self.out.push_str(if c < 0.0 { " - " } else { " + " });
                    self.put(format_args!("{}", c.abs()));
                }
                self.bracket(open, ')');
            }
            Node::Product(factors) => self.product(factors, inside, depth),
            Node::Call(function, x) => {
                if let Function::Powf(k) = function {
                    self.print(*x, Binds::Atom, depth - 1);
                    self.put(format_args!("^{}", k.get()));
                    return;
                }
                self.put(format_args!("{}(", function.name()));
                self.print(*x, Binds::Sum, depth - 1);
                self.out.push(')');
            }
            Node::Call2(function, x, y) => {
                self.put(format_args!("{}(", function.name()));
                self.print(*x, Binds::Sum, depth - 1);
                self.out.push_str(", ");
                self.print(*y, Binds::Sum, depth - 1);
                self.out.push(')');
            }
        }
    }

    fn term(&mut self, c: f64, x: Expr, first: bool, depth: usize) {
        match (first, c < 0.0) {
            (true, true) => self.out.push('-'),
            (true, false) => {}
            (false, true) => self.out.push_str(" - "),
            (false, false) => self.out.push_str(" + "),
        }
        if c.abs() != 1.0 {
            self.put(format_args!("{}·", c.abs()));
        }
        self.print(x, Binds::Product, depth - 1);
    }

    fn product(&mut self, factors: &[(Expr, i32)], inside: Binds, depth: usize) {
        let open = inside > Binds::Product;
        self.bracket(open, '(');
        for (at, &(base, k)) in factors.iter().enumerate() {
            if at > 0 {
                self.out.push('·');
            }
            self.print(base, Binds::Atom, depth - 1);
            if k != 1 {
                self.put(format_args!("^{k}"));
            }
        }
        self.bracket(open, ')');
    }

    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        self.out.push_str(&text.to_string());
    }

    fn bracket(&mut self, open: bool, bracket: char) {
        if open {
            self.out.push(bracket);
        }
    }
}
