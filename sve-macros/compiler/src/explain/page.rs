//! Formulas that are short because subexpressions have names: the choice of names, the truncation
//! of long formulas, and the explanations of the names.
//!
//! Invariant: every name that occurs in a formula of the page is explained by
//! [`Page::explanations`], or is part of the notation; omitted parts are counted.

use std::collections::HashMap;

use super::names::Names;
use super::shown;
use crate::algebra::{Arena, Expr, Node, Notation, Sum, Text};
use crate::model::AtNode;

/// Number of characters beyond which a formula is truncated.
const FORMULA: usize = 240;

/// Number of characters from which on repeated parts of formulas get names.
const LONG: usize = 110;

/// Number of characters from which on a function gets a name; `PART` is the number for a sum.
const FUNCTION: usize = 12;
const PART: usize = 16;

/// Largest number of names on a page; `SEARCHED` is the largest number of expressions that are
/// searched for repeated parts.
const NAMES: usize = 12;
const SEARCHED: usize = 3000;

/// Formulas of one section.
pub(super) struct Page<'a> {
    pub(super) arena: &'a Arena,
    pub(super) names: Names<'a>,
    /// Expressions whose names occur in the text so far.
    used: Vec<Expr>,
}

impl<'a> Page<'a> {
    pub(super) fn new(arena: &'a Arena, names: Names<'a>) -> Self {
        Self {
            arena,
            names,
            used: Vec::new(),
        }
    }

    /// Gives names to nodes of the step and, if formulas are long, to subexpressions that occur
    /// more than once.
    pub(super) fn name_parts(&mut self, roots: &[Expr]) {
        for e in self.below(roots) {
            self.names.call_node(e, self.arena);
        }
        let long = |e: &Expr| self.arena.display(*e, LONG, &self.names).is_none();
        let inside = self.below(roots);
        if !roots.iter().any(long) || inside.len() > SEARCHED {
            return;
        }
        // Counts how often each expression is printed. The users of an expression are counted
        // before it, since an expression with a name is printed once.
        let mut times: HashMap<Expr, usize> = HashMap::new();
        let mut chosen = Vec::new();
        for &e in inside.iter().rev() {
            let root = usize::from(roots.contains(&e));
            let mut here = times.get(&e).copied().unwrap_or(0).saturating_add(root);
            if here > 1 && root == 0 && self.is_worth_a_name(e) {
                chosen.push(e);
                here = 1;
            }
            for operand in self.arena.operands_of(e) {
                let sum = times.entry(operand).or_default();
                *sum = sum.saturating_add(here);
            }
        }
        for &e in chosen.iter().rev().take(NAMES) {
            // the same part of two equations may be two expressions: one contains an unknown, the
            // other its solution
            if let Some(text) = self.arena.display(e, FORMULA, &self.names) {
                self.names.number(e, text.text, self.arena);
            }
        }
    }

    fn is_worth_a_name(&self, expr: Expr) -> bool {
        let worth = match self.arena.node(expr) {
            Node::Call(..) | Node::Call2(..) => FUNCTION,
            Node::Sum(_, terms) if terms.len() > 1 => PART,
            _ => return false,
        };
        let short = self.arena.display(expr, worth - 1, &self.names);
        short.is_none()
    }

    /// Returns the subexpressions of formulas down to those that have names.
    fn below(&self, roots: &[Expr]) -> Vec<Expr> {
        self.arena
            .reachable(roots, |e| self.names.name(e).is_none())
    }

    fn take(&mut self, text: Text) -> String {
        self.used.extend(text.named);
        text.text
    }

    /// Prints an expression.
    pub(super) fn formula(&mut self, expr: Expr) -> String {
        if let Some(text) = self.arena.display(expr, FORMULA, &self.names) {
            return self.take(text);
        }
        let mut sum = Sum::default();
        sum.add(1.0, expr, self.arena);
        self.sum(&sum)
    }

    /// Prints a sum; `None` if it is too long to be shown whole.
    pub(super) fn whole(&mut self, sum: &Sum) -> Option<String> {
        let text = self.arena.display_sum(sum, FORMULA, &self.names)?;
        Some(self.take(text))
    }

    /// Prints a sum. If it is too long, prints the first terms and the number of the others.
    pub(super) fn sum(&mut self, sum: &Sum) -> String {
        let Sum { constant, terms } = sum;
        if let Some(text) = self.whole(sum) {
            return text;
        }
        for count in (1..terms.len().min(FORMULA / 4)).rev() {
            let part = Sum {
                constant: *constant,
                terms: terms[..count].to_vec(),
            };
            if let Some(text) = self.arena.display_sum(&part, FORMULA, &self.names) {
                let left = terms.len() - count;
                let plural = if left == 1 { "" } else { "s" };
                return format!("{} + … ({left} more term{plural})", self.take(text));
            }
        }
        self.cut(terms)
    }

    /// Prints a sum as a factor: whether a minus sign stands in front, and the text without the
    /// sign.
    pub(super) fn factor(&mut self, sum: &Sum) -> (bool, String) {
        match self.arena.display_factor(sum, FORMULA, &self.names) {
            Some((negative, text)) => (negative, self.take(text)),
            None => (false, format!("({})", self.sum(sum))),
        }
    }

    fn cut(&self, terms: &[(Expr, f64)]) -> String {
        let roots: Vec<Expr> = terms.iter().map(|t| t.0).collect();
        format!("… ({} operations)", self.arena.operations(&roots))
    }

    /// Prints the operation of an expression that has a name.
    pub(super) fn definition(&mut self, expr: Expr) -> String {
        match self.arena.display_definition(expr, FORMULA, &self.names) {
            Some(text) => self.take(text),
            None => self.cut(&[(expr, 1.0)]),
        }
    }

    /// Returns the explanations of the names in the text so far: nodes first, then parts, where a
    /// part precedes the parts that contain it. Names that are `known` get no line.
    pub(super) fn explanations(&mut self, known: impl Fn(Expr) -> bool) -> Vec<String> {
        let mut explained: Vec<(String, String, bool)> = Vec::new();
        // the operands of an expression were created before it
        while let Some(&last) = self.used.iter().max() {
            self.used.retain(|&e| e != last);
            let name = self.names.name(last).unwrap_or_default().to_owned();
            if known(last) || explained.iter().any(|e| e.0 == name) {
                continue;
            }
            let definition = self.definition(last);
            let is_node = AtNode::of(last, self.arena).is_some();
            explained.push((name, definition, is_node));
        }
        explained.reverse();
        explained.sort_by_key(|e| !e.2);
        let line = |(name, definition, _)| format!("{name} = {definition}");
        explained.into_iter().map(line).collect()
    }

    /// Returns the first lines of a list, and the number of the others.
    pub(super) fn list(lines: Vec<String>, length: usize, what: &str) -> Vec<String> {
        let count = shown(length);
        let mut lines: Vec<String> = lines.into_iter().take(count).collect();
        if length > count {
            lines.push(format!("… ({} more {what})", length - count));
        }
        lines
    }
}
