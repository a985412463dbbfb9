//! Formulas in the notation of Rust: one text is evaluated in any kind of number and built by the
//! algebra.

use quote::ToTokens;
use syn::{BinOp, Lit};

use super::number::Number;
use super::recipe::{self, Make};
use crate::algebra::{Arena, Binary, Expr, Function, Symbol};

/// The variables of formulas.
const VARIABLES: [&str; 3] = ["x", "y", "z"];

/// A formula in x, y and z.
pub(crate) struct Formula(Vec<Make>);

impl Formula {
    /// Reads numbers, `+ − · /` and methods; `e.named()` gives the value of `e` a name.
    pub(crate) fn new(text: &str) -> Self {
        let expr = syn::parse_str(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let mut formula = Self(Vec::new());
        let whole = formula.read(&expr);
        formula.0.push(Make::Symbol(whole));
        formula
    }

    /// The value at a point.
    pub(crate) fn evaluate<T: Number>(&self, at: [T; 3]) -> T {
        *recipe::evaluate(&self.0, &at).last().expect("a value")
    }

    /// The expression in the symbols 0, 1 and 2.
    pub(crate) fn build(&self, arena: &mut Arena) -> Expr {
        let variables = [0, 1, 2].map(Symbol);
        let all = recipe::build(&self.0, &variables, arena);
        *all.last().expect("an expression")
    }

    /// Appends the entries of an expression, and returns the place of its value.
    fn read(&mut self, expr: &syn::Expr) -> usize {
        let make = match expr {
            expr if number(expr).is_some() => Make::Constant(number(expr).expect("a number")),
            syn::Expr::Paren(inner) => return self.read(&inner.expr),
            syn::Expr::Path(name) => {
                let name = name.to_token_stream().to_string();
                let place = VARIABLES.iter().position(|variable| *variable == name);
                return place.unwrap_or_else(|| panic!("the variable {name}"));
            }
            syn::Expr::Unary(minus) => Make::Sum(0.0, vec![(-1.0, self.read(&minus.expr))]),
            syn::Expr::Binary(binary) => self.operation(binary),
            syn::Expr::MethodCall(call) => {
                let x = self.read(&call.receiver);
                match (call.method.to_string().as_str(), call.args.first()) {
                    ("named", _) => Make::Opaque(x),
                    ("powi", Some(power)) => Make::Product(vec![(x, integer(power))]),
                    (name, Some(argument)) => {
                        let mut known = Binary::METHODS.iter();
                        let function = known.find(|function| function.name() == name);
                        Make::Call2(*function.expect(name), x, self.read(argument))
                    }
                    (name, None) => {
                        let mut known = Function::METHODS.iter();
                        let function = known.find(|function| function.name() == name);
                        Make::Call(*function.expect(name), x)
                    }
                }
            }
            other => panic!("{}", other.to_token_stream()),
        };
        self.0.push(make);
        VARIABLES.len() + self.0.len() - 1
    }

    /// A sum, a product or a quotient; a number times an expression is a sum of one term.
    fn operation(&mut self, binary: &syn::ExprBinary) -> Make {
        if let (BinOp::Mul(_), Some(by)) = (&binary.op, number(&binary.left)) {
            return Make::Sum(0.0, vec![(by, self.read(&binary.right))]);
        }
        let (left, right) = (self.read(&binary.left), self.read(&binary.right));
        match binary.op {
            BinOp::Add(_) => Make::Sum(0.0, vec![(1.0, left), (1.0, right)]),
            BinOp::Sub(_) => Make::Sum(0.0, vec![(1.0, left), (-1.0, right)]),
            BinOp::Mul(_) => Make::Product(vec![(left, 1), (right, 1)]),
            BinOp::Div(_) => Make::Product(vec![(left, 1), (right, -1)]),
            _ => panic!("{}", binary.to_token_stream()),
        }
    }
}

/// A number with its sign.
fn number(expr: &syn::Expr) -> Option<f64> {
    match expr {
        syn::Expr::Unary(minus) => number(&minus.expr).map(|x| -x),
        syn::Expr::Lit(literal) => match &literal.lit {
            Lit::Float(number) => number.base10_parse().ok(),
            _ => None,
        },
        _ => None,
    }
}

fn integer(expr: &syn::Expr) -> i32 {
    let text = expr.to_token_stream().to_string().replace(' ', "");
    text.parse().expect("an integer")
}

#[test]
fn formulas_are_those_of_rust() {
    for (text, expected) in [
        ("x - y * z", 2.0 - 3.0 * 5.0),
        ("-x / (y - 1.0) - -0.5 * z", 1.5),
        ("(2.0 * x).powi(-2) + y.hypot(4.0)", 5.0625),
        (
            "z.atan2(x).sin() * y.named().powf(1.5)",
            5f64.atan2(2.0).sin() * 3f64.powf(1.5),
        ),
    ] {
        let formula = Formula::new(text);
        let at = [2.0, 3.0, 5.0];
        let found: f64 = formula.evaluate(at);
        assert!((found - expected).abs() < 1e-14, "{text}: {found}");
        let mut arena = Arena::new();
        let built = formula.build(&mut arena);
        let found = arena.evaluate(built, |symbol| at[symbol.0 as usize]);
        assert!((found - expected).abs() < 1e-14, "{text}: {found}");
    }
}
