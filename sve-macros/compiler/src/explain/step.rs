//! The discrete action of a rule in its textbook form, and the equations of the step that it gives.

use super::names::Names;
use super::page::Page;
use super::shown;
use crate::algebra::{Arena, Expr, Node, Notation, Sum, Symbol};
use crate::catalogue::{Rule, RuleOption};
use crate::derivation::Derived;
use crate::model::configuration::Factor;
use crate::model::{AtNode, Constraint, END, Meaning, Model, NodeQuantity, Symbols, unknown};
use crate::rules::action::Action;
use crate::rules::degenerate;
use crate::rules::discretisation;
use crate::rules::textbook::{Features, Textbook};
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

/// Writes down a step.
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
        action: with_notation(textbook, written_out, &features, model),
        step: equations(rule, action, scheme, symbols, arena).join("\n"),
        domain: domain(rule, scheme, symbols, arena),
    }
}

/// The text of an action: its textbook form, the action written out where it is short, and what stands in them.
pub(super) fn with_notation(
    textbook: Textbook,
    written_out: Vec<String>,
    features: &Features,
    model: &Model,
) -> String {
    let Textbook {
        action,
        mut notation,
        work,
    } = textbook;
    if !written_out.is_empty() {
        notation.push("Δq = q₁ − q₀".to_owned());
    }
    if features.potential.is_some() {
        notation.push(potential(model).to_owned());
    }
    let mut lines = vec![action];
    lines.extend(written_out);
    if model.force.is_some() {
        lines.push(format!("with the virtual work h·{work} beside δS"));
    }
    if !notation.is_empty() {
        lines.push(notation.join(", "));
    }
    lines.join("\n")
}

/// The constraints in the textbook form of an action.
fn constraints(model: &Model, arena: &Arena) -> String {
    let is_timed = |c: &Constraint| arena.contains(c.value, model.time);
    let [t0, t1] = if model.constraints.iter().any(is_timed) {
        ["t₀, ", "t₁, "]
    } else {
        ["", ""]
    };
    match model.constraints.len() {
        0 => String::new(),
        1 => format!(" + λ·φ({t0}q₀) + μ·φ({t1}q₁)"),
        _ => format!(" + ⟨λ, φ({t0}q₀)⟩ + ⟨μ, φ({t1}q₁)⟩"),
    }
}

/// The action in its textbook form.
fn textbook(rule: Rule, system: &Classified, features: &Features) -> Textbook {
    let plain = discretisation(rule).textbook(features);
    match (&system.degeneracy, rule.node()) {
        (Some(degeneracy), Some(node)) => degenerate::textbook(degeneracy, node, plain, features),
        _ => plain,
    }
}

/// Characters from which on an expression is not written out in a condition.
const CONDITION: usize = 120;

/// The conditions on where functions are evaluated, `1 − v² > 0`.
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

/// What of the system shows in the textbook form of an action.
pub(super) fn features(
    rule: Rule,
    system: &Classified,
    potential: Option<f64>,
    arena: &Arena,
) -> Features {
    let (model, mechanics) = (&system.model, &system.mechanics);
    let timed = |e: Expr| arena.contains(e, model.time);
    let noises = &model.noises;
    let gammas = noises.iter().filter(|g| g.is_gamma).count();
    let given = |list: &[Expr]| list.iter().any(|&e| arena.constant_value(e) != Some(0.0));
    let moves_q = mechanics.noises.iter().any(|g| given(&g.dp));
    let moves_p = mechanics.noises.iter().any(|g| given(&g.dq));
    Features {
        degrees_of_freedom: model.dof(),
        is_timed: timed(model.lagrangian) || noises.iter().any(|g| timed(g.hamiltonian)),
        force_is_timed: model.force.as_ref().map(|f| f.iter().any(|&e| timed(e))),
        potential,
        has_stage_noise: rule.options.contain(RuleOption::StageNoise),
        gammas,
        hamiltonians: noises.len() - gammas,
        moves_both: moves_q && moves_p,
    }
}

/// What K of the option `weak2` stands for.
fn potential(model: &Model) -> &'static str {
    let is_gamma = model.noises.iter().all(|noise| noise.is_gamma);
    match (is_gamma, model.noises.len(), model.dof()) {
        (true, 1, 1) => "K = (∂γ/∂q)²/(∂²L/∂v²)",
        (true, _, 1) => "K = Σ (∂γ/∂q)²/(∂²L/∂v²)",
        (true, 1, _) => "K = ⟨∂γ/∂q, M⁻¹·∂γ/∂q⟩ with M = ∂²L/∂v²",
        (true, _, _) => "K = Σ ⟨∂γ/∂q, M⁻¹·∂γ/∂q⟩ with M = ∂²L/∂v²",
        (false, _, _) => "K = Σ {G, {G, H} + ∂G/∂t} with G = −γ or H₁",
    }
}

/// The action as the expression that is differentiated, and its parts; nothing where it is long.
fn written_out(rule: Rule, action: &Action, symbols: &Symbols, arena: &Arena) -> Vec<String> {
    let mut page = Page::new(arena, Names::new(symbols, Some(rule)));
    page.name_parts(&[action.value]);
    let mut sum = Sum::default();
    sum.add(1.0, action.value, arena);
    sum.terms
        .sort_by_key(|&(term, _)| textbook_place(term, action, symbols, arena));
    let Some(text) = page.whole(&sum) else {
        return Vec::new();
    };
    let mut lines = vec![format!("S = {text}")];
    // the nodes are explained beside the textbook form
    lines.extend(page.explanations(|e| AtNode::of(e, arena).is_some()));
    lines
}

/// First L, then the constraints, then the noise.
fn textbook_place(term: Expr, action: &Action, symbols: &Symbols, arena: &Arena) -> u8 {
    let is_noise = |s| matches!(symbols.meaning(s), Meaning::Wiener(_));
    if arena.symbols_of(term).any(is_noise) {
        return 2;
    }
    let h = arena.known_symbol(action.h);
    let is_h = |factor| Some(factor) == h;
    u8::from(!arena.operands_of(term).any(is_h))
}

/// What is solved, and what follows from it.
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

    let mut lines = Vec::new();
    let mut header = String::new();
    for &(block, rows) in &shown_blocks {
        let next = heading(block, symbols);
        if next != header {
            lines.push(next.clone());
            header = next;
        }
        lines.extend(rows_of(block, rows, &mut page, symbols));
    }
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

/// The first blocks with their first rows, so many rows together.
fn shown_blocks(scheme: &Scheme<Expr>, mut room: usize) -> Vec<(&Block<Expr>, usize)> {
    let rows = scheme.blocks.iter().map(|block| {
        let rows = block.unknowns.len().min(room);
        room -= rows;
        (block, rows)
    });
    rows.filter(|&(_, rows)| rows > 0).collect()
}

/// The results of a step.
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
        ends.push("R₁ = R₀·cay(x)".to_owned());
    }
    let pushed = (0..shown(n)).map(|i| end("p", i, action.start_p[i], dp[i], page));
    ends.extend(Page::list(pushed.collect(), n, "of these"));
    ends
}

/// Whether an expression is the formula of an unknown, which has its own line.
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

/// The expressions in the first rows of a block.
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

/// The equations of a block.
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

/// A row of a matrix times the unknowns.
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

/// The coordinates of the start, in the order of the directions; `None` for the directions of a rotation.
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

/// `q₁ = q₀ + …`, with what cancels cancelled.
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
