//! The discrete action of a rule in its textbook form, and the equations of the step that it gives.

use super::action::{constraints, features, textbook, with_notation, written_out};
use super::names::Names;
use super::page::Page;
use super::shown;
use crate::algebra::{Arena, Expr, Node, Notation, Sum, Symbol};
use crate::catalogue::Rule;
use crate::derivation::Derived;
use crate::model::configuration::Factor;
use crate::model::{AtNode, END, NodeQuantity, Symbols, unknown};
use crate::rules::action::Action;
use crate::rules::discretisation;
use crate::structure::{Block, Kind, Matrix, Scheme, Solution};
use crate::system::classify::Classified;

/// Texts of a rule.
pub(crate) struct StepTexts {
    /// The discrete action.
    pub(crate) action: String,
    /// The equations of the step after elimination, block by block, and its results.
    pub(crate) step: String,
    /// The conditions on where functions are evaluated.
    pub(crate) domain: Vec<String>,
}

/// Prints a step.
pub(crate) fn step(derived: &Derived, system: &Classified) -> StepTexts {
    let Derived {
        rule,
        symbols,
        action,
        scheme,
        arena,
        ..
    } = derived;
    let (rule, model) = (*rule, &system.model);
    let features = features(rule, system, action.half_factor, arena);
    let mut textbook = textbook(rule, system, &features);
    textbook.action += &constraints(model, arena);
    let written_out = written_out(rule, action, symbols, arena);
    StepTexts {
        action: with_notation(rule, textbook, written_out, &features, system),
        step: equations(rule, action, scheme, symbols, arena).join("\n"),
        domain: domain(rule, scheme, symbols, arena),
    }
}

/// Number of characters beyond which an expression is not written out in a condition.
const CONDITION: usize = 120;

/// Returns the conditions on where functions are evaluated, `1 − v² > 0`.
fn domain(rule: Rule, scheme: &Scheme<Expr>, symbols: &Symbols, arena: &Arena) -> Vec<String> {
    let conditions = scheme.domain.iter().map(|condition| {
        let mut names = Names::new(symbols, Some(rule));
        for e in arena.reachable(&[condition.text], |_| true) {
            names.call_node(e, arena);
        }
        let value = arena.display(condition.text, CONDITION, &names);
        let value = value.map_or_else(|| "an argument in L".to_owned(), |v| v.text);
        let relation = if condition.is_closed { "≥" } else { ">" };
        format!("{value} {relation} 0")
    });
    conditions.collect()
}

/// Returns the equations to be solved, and the results that follow from them.
fn equations(
    rule: Rule,
    action: &Action,
    scheme: &Scheme<Expr>,
    symbols: &Symbols,
    arena: &Arena,
) -> Vec<String> {
    let mut page = Page::new(arena, Names::new(symbols, Some(rule)));
    for block in &scheme.blocks {
        if let Solution::Formula(formula) = block.solution {
            let name = unknown(symbols, block.unknowns[0]);
            page.names.call(formula, name);
        }
    }
    let unknowns: usize = scheme.blocks.iter().map(|b| b.unknowns.len()).sum();
    let shown_blocks = shown_blocks(scheme, shown(unknowns));
    let [dq, dp] = &scheme.increments;
    let count = shown(dq.len());
    let mut roots: Vec<Expr> = [&dq[..count], &dp[..count]].concat();
    for &(block, rows) in &shown_blocks {
        roots.extend(parts(block, rows));
    }
    page.name_parts(&roots);

    let mut lines = solved(&shown_blocks, &mut page, symbols);
    let left = unknowns - shown(unknowns);
    if left > 0 {
        lines.push(format!("  … ({left} more unknowns)"));
    }
    let ends = ends(action, scheme, &mut page);
    let explained = page.explanations(|e| {
        let node = AtNode::of(e, arena);
        let is_end = node.is_some_and(|at| {
            matches!(at.quantity, NodeQuantity::Position(_))
                && (at.node == END || discretisation(rule).point(at.node).is_end())
        });
        is_end || is_formula(e, scheme)
    });
    let is_explicit = lines.is_empty();
    let indent = if is_explicit { "" } else { "  " };
    for (heading, part) in [("then", ends), ("with", explained)] {
        if !is_explicit && !part.is_empty() {
            lines.push(heading.to_owned());
        }
        lines.extend(part.into_iter().map(|line| format!("{indent}{line}")));
    }
    if scheme.returns.is_matrix() {
        lines.push(
            "computed as a matrix times the state, whose entries are known before it".to_owned(),
        );
    }
    lines
}

/// Returns the equations of blocks. A line about the kind of each block stands above its equations.
fn solved(blocks: &[(&Block<Expr>, usize)], page: &mut Page<'_>, symbols: &Symbols) -> Vec<String> {
    let mut lines = Vec::new();
    let mut header = String::new();
    for &(block, rows) in blocks {
        let next = heading(block, symbols);
        if next != header {
            lines.push(next.clone());
            header = next;
        }
        lines.extend(rows_of(block, rows, page, symbols));
    }
    lines
}

/// Returns the first blocks with the numbers of their first rows, `room` rows together.
fn shown_blocks(scheme: &Scheme<Expr>, mut room: usize) -> Vec<(&Block<Expr>, usize)> {
    let rows = scheme.blocks.iter().map(|block| {
        let rows = block.unknowns.len().min(room);
        room -= rows;
        (block, rows)
    });
    rows.filter(|&(_, rows)| rows > 0).collect()
}

/// Returns the results of a step.
fn ends(action: &Action, scheme: &Scheme<Expr>, page: &mut Page<'_>) -> Vec<String> {
    let [dq, dp] = &scheme.increments;
    let n = dq.len();
    let positions = positions(action);
    let is_unknown = |e: Expr| matches!(page.arena.node(e), Node::Symbol(_));
    let given: Vec<usize> = (0..shown(n))
        .filter(|&i| positions[i].is_some() || !is_unknown(dq[i]))
        .collect();
    let moved = given.into_iter().map(|i| match positions[i] {
        Some(start) => end("q", i, start, dq[i], page),
        // the increment of a rotation
        None => {
            let name = page.names.symbols.component("Δq", i);
            format!("{name} = {}", page.formula(dq[i]))
        }
    });
    let mut ends = Page::list(moved.collect(), n, "of these");
    if action.configuration.has_rotations() {
        ends.push("R₁ = R₀·exp(x)".to_owned());
    }
    let pushed = (0..shown(n)).map(|i| end("p", i, action.start_p[i], dp[i], page));
    ends.extend(Page::list(pushed.collect(), n, "of these"));
    ends
}

/// Returns whether an expression is the formula of an unknown. Such a formula has its own line.
fn is_formula(expr: Expr, scheme: &Scheme<Expr>) -> bool {
    let mut solutions = scheme.blocks.iter().map(|b| &b.solution);
    solutions.any(|s| matches!(s, Solution::Formula(formula) if *formula == expr))
}

fn heading(block: &Block<Expr>, symbols: &Symbols) -> String {
    let names: Vec<String> = block
        .unknowns
        .iter()
        .map(|&u| unknown(symbols, u))
        .collect();
    let names = match names.as_slice() {
        [first, .., last] if names.len() > super::ALL => format!("{first}, …, {last}"),
        _ => names.join(", "),
    };
    match (&block.solution, block.kind) {
        (Solution::Formula(_), Kind::Explicit) => "explicitly".to_owned(),
        (Solution::Formula(_), _) => "from a linear equation".to_owned(),
        (Solution::System { .. }, _) => format!("linear equations for {names}"),
        (Solution::Iteration(_), _) => format!("Newton's method for {names}"),
    }
}

/// Returns the expressions in the first rows of a block.
fn parts(block: &Block<Expr>, rows: usize) -> Vec<Expr> {
    match &block.solution {
        Solution::Formula(_) => Vec::new(),
        Solution::System { linear, .. } => {
            let matrix = (0..rows).flat_map(|i| linear.matrix.row(i).map(|x| x.1));
            matrix
                .chain(linear.rhs.iter().take(rows).copied())
                .collect()
        }
        Solution::Iteration(iteration) => iteration.residual.iter().take(rows).copied().collect(),
    }
}

/// Returns the equations of a block.
fn rows_of(
    block: &Block<Expr>,
    rows: usize,
    page: &mut Page<'_>,
    symbols: &Symbols,
) -> Vec<String> {
    match &block.solution {
        Solution::Formula(formula) => {
            let name = unknown(symbols, block.unknowns[0]);
            vec![format!("  {name} = {}", page.definition(*formula))]
        }
        Solution::System { linear, .. } => (0..rows)
            .map(|i| {
                let left = row(&linear.matrix, i, &block.unknowns, page, symbols);
                format!("  {left} = {}", page.formula(linear.rhs[i]))
            })
            .collect(),
        Solution::Iteration(iteration) => iteration.residual[..rows]
            .iter()
            .map(|&r| format!("  0 = {}", page.formula(r)))
            .collect(),
    }
}

/// Returns a row of a matrix times the unknowns.
fn row(
    matrix: &Matrix<Expr>,
    i: usize,
    unknowns: &[Symbol],
    page: &mut Page<'_>,
    symbols: &Symbols,
) -> String {
    let mut text = String::new();
    for (column, entry) in matrix.row(i) {
        let mut sum = Sum::default();
        sum.add(1.0, entry, page.arena);
        if sum.is_zero() {
            continue;
        }
        let (negative, factor) = page.factor(&sum);
        text.push_str(match (text.is_empty(), negative) {
            (true, true) => "−",
            (true, false) => "",
            (false, true) => " − ",
            (false, false) => " + ",
        });
        if factor != "1" {
            text.push_str(&factor);
            text.push('·');
        }
        text.push_str(&unknown(symbols, unknowns[column]));
    }
    text
}

/// Returns the coordinates of the start, in the order of the directions; `None` for the directions
/// of a rotation.
fn positions(action: &Action) -> Vec<Option<Symbol>> {
    let mut positions = Vec::new();
    for block in action.configuration.blocks() {
        match block.factor {
            Factor::Vector(_) => {
                positions.extend(action.start_q[block.entries].iter().map(|&s| Some(s)));
            }
            Factor::Rotation => positions.extend([None; 3]),
        }
    }
    positions
}

/// Returns `q₁ = q₀ + …` after cancellation.
fn end(letter: &str, i: usize, start: Symbol, increment: Expr, page: &mut Page<'_>) -> String {
    let mut sum = Sum::default();
    let start_name = page.names.symbol(start);
    let name = page.names.symbols.component(&format!("{letter}₁"), i);
    match page.arena.known_symbol(start) {
        Some(start) => {
            sum.add(1.0, start, page.arena);
            sum.add(1.0, increment, page.arena);
            format!("{name} = {}", page.sum(&sum))
        }
        None => format!("{name} = {start_name} + {}", page.formula(increment)),
    }
}
