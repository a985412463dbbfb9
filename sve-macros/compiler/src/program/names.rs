//! Names of temporaries. The name of a value is its label; without a label, it is the value's
//! operation with a number.
//!
//! Input: a program and the labels of some of its values. Output: a name for each value. Invariant:
//! names that are in scope together differ from one another, from the names of inputs, and from
//! reserved names.

use std::collections::{HashMap, HashSet};

use super::labels::Labels;
use super::{Operation, Program, Tier, Value};
use crate::algebra::{Function, Symbol};
use crate::model::{Meaning, Symbols};

/// Returns the name of a symbol in generated code. The prefix of parameters separates them from all
/// other names.
pub(crate) fn symbol_name(symbols: &Symbols, symbol: Symbol) -> String {
    match symbols.meaning(symbol) {
        Meaning::Parameter { name, .. } => format!("self_{name}"),
        _ => symbols.name(symbol),
    }
}

/// The name of each value that has a statement of its own. A pair of sine and cosine has the name
/// of its angle.
pub(crate) struct Names {
    names: HashMap<Value, String>,
    /// Values whose names tell the operation alone.
    numbered: HashSet<Value>,
}

impl Names {
    /// Names the values of a program. The names differ from those in `reserved`, the other
    /// variables that a back end declares.
    pub(crate) fn new(
        program: &Program,
        symbols: &Symbols,
        labels: &Labels,
        reserved: &[&str],
    ) -> Self {
        let mut scope = Scope::new(program, symbols, reserved);
        let mut names: HashMap<Value, String> = HashMap::new();
        let mut numbered = HashSet::new();
        for (value, instruction) in program.in_order() {
            scope.enter(instruction.tier);
            let known = |v: Value| match program.get(v).operation {
                Operation::Input(symbol) => Some(symbol_name(symbols, symbol)),
                _ => labels.values.get(&v).cloned(),
            };
            let number = value.index();
            let wanted = match instruction.operation {
                Operation::Input(_)
                | Operation::Constant(_)
                | Operation::SinOf(_)
                | Operation::CosOf(_) => continue,
                Operation::SinCos(_) | Operation::AngleAddition(..) => {
                    let angle = match (labels.pairs.get(&value), instruction.operation) {
                        (Some(word), _) => Some(word.clone()),
                        (None, Operation::SinCos(angle)) => known(angle),
                        _ => None,
                    };
                    let angle = angle.unwrap_or_else(|| number.to_string());
                    let parts = |angle: &str| [format!("sin_{angle}"), format!("cos_{angle}")];
                    names.insert(value, scope.free(angle, number, parts));
                    continue;
                }
                operation => match labels.values.get(&value) {
                    Some(label) => label.clone(),
                    None => match operation {
                        Operation::Mul(a, b) if a == b && known(a).is_some() => {
                            format!("{}_squared", known(a).unwrap_or_default())
                        }
                        Operation::Call(function, a) if !matches!(function, Function::Powf(_)) => {
                            let argument = known(a).unwrap_or_else(|| {
                                numbered.insert(value);
                                number.to_string()
                            });
                            format!("{}_{argument}", function.name())
                        }
                        _ => {
                            numbered.insert(value);
                            format!("{}_{number}", prefix(operation))
                        }
                    },
                },
            };
            names.insert(value, scope.free(wanted, number, |name| [name.to_owned()]));
        }
        Self { names, numbered }
    }

    /// Returns whether the name of a value tells its operation alone.
    pub(crate) fn is_numbered(&self, value: Value) -> bool {
        self.numbered.contains(&value)
    }

    pub(crate) fn of(&self, value: Value) -> String {
        match self.names.get(&value) {
            Some(name) => name.clone(),
            None => format!("value_{}", value.index()),
        }
    }

    /// Returns the names of sine and cosine of a pair.
    pub(crate) fn pair(&self, both: Value) -> [String; 2] {
        let angle = self.names.get(&both).cloned();
        let angle = angle.unwrap_or_else(|| both.index().to_string());
        ["sin", "cos"].map(|part| format!("{part}_{angle}"))
    }
}

fn prefix(operation: Operation) -> &'static str {
    match operation {
        Operation::Add(..) | Operation::Sub(..) => "sum",
        Operation::Mul(..) => "product",
        Operation::Div(..) => "ratio",
        Operation::Neg(_) => "minus",
        Operation::Abs(_) => "size",
        Operation::Recip(_) => "inverse",
        Operation::Call(function, _) => function.name(),
        Operation::Call2(function, ..) => function.name(),
        _ => "value",
    }
}

/// The names that are in use. Names in a guess or an iteration are in scope in its block only.
struct Scope {
    tier: Tier,
    outer: HashSet<String>,
    inner: HashSet<String>,
}

impl Scope {
    fn new(program: &Program, symbols: &Symbols, reserved: &[&str]) -> Self {
        let inputs = program.all().filter_map(|(_, i)| match i.operation {
            Operation::Input(symbol) => Some(symbol_name(symbols, symbol)),
            _ => None,
        });
        let reserved = reserved.iter().map(|&name| name.to_owned());
        Self {
            tier: Tier::Prepare,
            outer: inputs.chain(reserved).collect(),
            inner: HashSet::new(),
        }
    }

    fn enter(&mut self, tier: Tier) {
        if tier != self.tier {
            self.tier = tier;
            self.inner.clear();
        }
    }

    /// Returns `wanted`, with a suffix if one of its `parts` is in use. The parts of the returned
    /// name are then in use.
    fn free<const N: usize>(
        &mut self,
        wanted: String,
        number: usize,
        parts: impl Fn(&str) -> [String; N],
    ) -> String {
        let taken = |name: &String| self.outer.contains(name) || self.inner.contains(name);
        let mut name = wanted;
        if parts(&name).iter().any(taken) {
            name = format!("{name}_{number}");
        }
        while parts(&name).iter().any(taken) {
            name.push('_');
        }
        let scope = match self.tier {
            Tier::Guess(..) | Tier::Iterate(_) => &mut self.inner,
            _ => &mut self.outer,
        };
        scope.extend(parts(&name));
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::Arena;
    use crate::model::{Family, Unknown};
    use crate::program::{Scheduler, Tiers};

    /// The values are `x + h`, where x is known before an iteration, in it, or after it.
    #[test]
    fn names_in_scope_together_differ() {
        let (mut arena, mut symbols, mut tiers) = (Arena::new(), Symbols::default(), Tiers::new());
        let step = symbols.declare(Meaning::StepSize);
        let h = arena.symbol(step);
        let places = [
            Tier::State,
            Tier::State,
            Tier::Iterate(0),
            Tier::Iterate(0),
            Tier::Solved(0),
            Tier::Iterate(1),
        ];
        let mut roots = Vec::new();
        for (i, tier) in places.into_iter().enumerate() {
            let symbol = symbols.declare(Unknown::of(Family::Displacement)(i));
            tiers.insert(symbol, tier);
            let x = arena.symbol(symbol);
            roots.push(arena.add(x, h));
        }
        let last = arena.call(Function::Exp, roots[0]);
        roots.push(last);
        let mut scheduler = Scheduler::new(&arena, &symbols, tiers, &roots);
        let values = scheduler.values(&roots);
        let program = scheduler.finish(&values);
        let all_named = |names: [&str; 7]| {
            let mut labels = Labels::default();
            for (&value, name) in values.iter().zip(names) {
                labels.call(value, name.to_owned());
            }
            let names = Names::new(&program, &symbols, &labels, &["state", "guess"]);
            values.iter().map(|&v| names.of(v)).collect::<Vec<_>>()
        };

        let found = all_named(["a", "a", "b", "b", "b", "b", "c"]);
        assert_eq!(found[0], "a");
        assert_ne!(found[1], "a");
        assert_eq!(found[2], "b");
        assert_ne!(found[3], "b");
        // names of an iteration are out of scope after it
        assert_eq!(found[4], "b");
        assert_ne!(found[5], "b");
        // a value that is known before an iteration is in scope in it
        assert_ne!(all_named(["a", "b", "a", "c", "d", "e", "f"])[2], "a");
        // names of inputs and reserved names
        for taken in ["d_3", "h", "state", "guess"] {
            assert_ne!(all_named([taken, "b", "a", "c", "d", "e", "f"])[0], taken);
        }
    }
}
