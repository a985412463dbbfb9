//! Equations → blocks: what is explicit, what is linear, what needs Newton's method.
//!
//! Input: [`Equations`]. Output: a [`Scheme`], the same equations cut into blocks to be solved in order. First every unknown is
//! eliminated that some equation gives with a numeric coefficient, then the rest is split into strongly connected blocks of
//! equations against unknowns (Duff, Erisman, Reid: Direct Methods for Sparse Matrices, chapter 6).
//!
//! To show what this is worth, [`unanalysed`] does nothing of it.

mod band;
mod block;
pub(crate) mod domain;
mod enclosure;
mod graph;
mod judge;
mod outputs;

use std::collections::{HashMap, HashSet};

use crate::algebra::{Arena, Expr, Node, Purpose, Symbol};
use crate::discretise::equations::Equations;
use crate::rules::action::Action;
use crate::system::model::{Family, Meaning, Quantity, Symbols, Unknown};
pub(crate) use band::Band;
use domain::Condition;
pub(crate) use enclosure::Enclosure;
use graph::{match_columns, strong_components};
pub(crate) use judge::Judge;
use outputs::{cheapest, linear_map};

/// A step, ready to be scheduled.
pub(crate) struct Scheme {
    pub(crate) blocks: Vec<Block>,
    pub(crate) dq: Vec<Expr>,
    pub(crate) dp: Vec<Expr>,
    pub(crate) form: Form,
    /// What has to hold at the solution, so that L is defined there.
    pub(crate) domain: Vec<Condition>,
    /// `q₁ − q₀` and `p₁ − p₀` as the equations give them, for readers.
    pub(crate) increments: (Vec<Expr>, Vec<Expr>),
}

impl Scheme {
    /// Whether `dq` and `dp` are a matrix times the state, whose entries are known before it.
    pub(crate) fn is_matrix(&self) -> bool {
        self.dq != self.increments.0
    }
}

/// What `dq` and `dp` are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// `q₁ − q₀` and `p₁ − p₀`.
    Increment,
    /// `q₁` and `p₁`.
    State,
}

/// How a block is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Explicit,
    Linear,
    Newton,
}

/// Equations that are solved together.
pub(crate) struct Block {
    pub(crate) kind: Kind,
    /// Unknowns, as the equations name them.
    pub(crate) unknowns: Vec<Symbol>,
    pub(crate) nonzeros: usize,
    /// The band of its Jacobian, where it is solved as a banded matrix.
    pub(crate) band: Option<Band>,
    pub(crate) solution: Solution,
}

/// What there is to compute.
pub(crate) enum Solution {
    /// A single unknown by a formula, which has taken its place in everything that follows.
    Formula(Expr),
    /// A linear system; `solved` are the names of the solution in everything that follows.
    System { linear: Linear, solved: Vec<Symbol> },
    /// An iteration from the solution of a linear system.
    Iteration(Box<Iteration>),
}

/// A linear system.
#[derive(Clone)]
pub(crate) struct Linear {
    pub(crate) matrix: Vec<Vec<Expr>>,
    pub(crate) rhs: Vec<Expr>,
}

/// A second stage of a guess, with the same matrix as the first.
pub(crate) struct Refinement {
    /// Names of the first stage's result in `rhs`.
    pub(crate) first: Vec<Symbol>,
    pub(crate) rhs: Vec<Expr>,
}

/// Newton's method on a block.
pub(crate) struct Iteration {
    /// First guess.
    pub(crate) guess: Linear,
    /// What is added to it.
    pub(crate) refinement: Option<Refinement>,
    /// The guess after a failure: the Newton step from zero, which is the linearly implicit step.
    pub(crate) fallback: Linear,
    /// Whether the equations have no Jacobian at zero, wherever the system is: the mass vanishes at rest, as for L = v⁴/4.
    pub(crate) singular_at_rest: bool,
    pub(crate) residual: Vec<Expr>,
    pub(crate) jacobian: Vec<Vec<Expr>>,
    /// Second derivative of a single equation in a single unknown.
    pub(crate) curvature: Option<Expr>,
    /// What decides whether a solution is connected with its limit, where that can be bounded.
    pub(crate) judge: Option<Judge>,
    /// Names of the iterates in `residual`, `jacobian` and `curvature`.
    pub(crate) iterates: Vec<Symbol>,
    pub(crate) solved: Vec<Symbol>,
}

/// The equations do not determine these unknowns.
pub(crate) struct Degenerate {
    pub(crate) unknowns: Vec<Symbol>,
}

/// Cuts the equations into blocks.
pub(crate) fn analyse(
    equations: Equations,
    action: &Action,
    symbols: &mut Symbols,
    arena: &mut Arena,
) -> Result<Scheme, Degenerate> {
    let rows = foreign(&equations, action, symbols);
    let mut system = Reduced {
        rows,
        arena,
        symbols,
        unknowns: equations.unknowns,
        residuals: equations.residuals,
        dq: equations.dq,
        dp: equations.dp,
        domain: Vec::new(),
    };
    system.domain = domain::conditions(&roots(action), system.arena);
    system.eliminate();
    let order = system.blocks()?;
    let mut blocks = Vec::new();
    let mut known = HashMap::new();
    for (rows, columns) in order {
        let block = system.solve(&rows, &columns, &mut known);
        blocks.push(block);
    }
    let dq: Vec<Expr> = system
        .dq
        .clone()
        .iter()
        .map(|&e| system.arena.substitute(e, &known))
        .collect();
    let candidates: Vec<Vec<Expr>> = system
        .dp
        .clone()
        .iter()
        .map(|list| {
            list.iter()
                .map(|&e| system.arena.substitute(e, &known))
                .collect()
        })
        .collect();
    let dp = cheapest(system.arena, &candidates, &dq, &blocks);
    let increments = Scheme {
        blocks,
        increments: (dq.clone(), dp.clone()),
        dq,
        dp,
        form: Form::Increment,
        domain: system.domain_at(&known),
    };
    let mut scheme = linear_map(increments, action, symbols, arena);
    arena.stabilise(Purpose::Step, scheme.exprs());
    Ok(scheme)
}

/// The equations as they are: Newton's method in all unknowns, whatever depends on what.
pub(crate) fn unanalysed(equations: Equations, symbols: &mut Symbols, arena: &mut Arena) -> Scheme {
    let mut system = Reduced {
        rows: Vec::new(),
        arena,
        symbols,
        unknowns: equations.unknowns,
        residuals: equations.residuals,
        dq: equations.dq,
        dp: equations.dp,
        domain: Vec::new(),
    };
    let mut known = HashMap::new();
    let block = system.whole(&mut known);
    let kicks: Vec<Expr> = system.dp.iter().map(|forms| forms[0]).collect();
    let dq = system.arena.substitute_all(&system.dq, &known);
    let dp = system.arena.substitute_all(&kicks, &known);
    let mut scheme = Scheme {
        blocks: vec![block],
        increments: (dq.clone(), dp.clone()),
        dq,
        dp,
        form: Form::Increment,
        domain: Vec::new(),
    };
    arena.stabilise(Purpose::Step, scheme.exprs());
    scheme
}

impl Scheme {
    /// All that is to be computed.
    fn exprs(&mut self) -> Vec<&mut Expr> {
        let Self {
            blocks,
            dq,
            dp,
            form: _,
            domain,
            increments: _,
        } = self;
        let mut exprs: Vec<&mut Expr> = dq.iter_mut().chain(dp).collect();
        exprs.extend(domain.iter_mut().map(|condition| &mut condition.value));
        for block in blocks {
            match &mut block.solution {
                Solution::Formula(formula) => exprs.push(formula),
                Solution::System { linear, solved: _ } => exprs.extend(linear.exprs()),
                Solution::Iteration(iteration) => exprs.extend(iteration.exprs()),
            }
        }
        exprs
    }
}

impl Linear {
    fn exprs(&mut self) -> impl Iterator<Item = &mut Expr> {
        let Self { matrix, rhs } = self;
        matrix.iter_mut().flatten().chain(rhs)
    }
}

impl Iteration {
    fn exprs(&mut self) -> impl Iterator<Item = &mut Expr> {
        let Self {
            guess,
            refinement,
            fallback,
            singular_at_rest: _,
            residual,
            jacobian,
            curvature,
            judge,
            iterates: _,
            solved: _,
        } = self;
        let refined = refinement.iter_mut().flat_map(|r| &mut r.rhs);
        let entries = residual.iter_mut().chain(jacobian.iter_mut().flatten());
        let linear = guess.exprs().chain(fallback.exprs());
        let judged = judge.iter_mut().flat_map(Judge::exprs);
        let all = linear.chain(refined).chain(entries);
        all.chain(curvature).chain(judged)
    }
}

/// Equations and the unknowns that they determine.
type RowsAndColumns = (Vec<usize>, Vec<usize>);

struct Reduced<'a> {
    /// Of each residual, which unknowns may not be eliminated by it.
    rows: Vec<HashSet<Symbol>>,
    arena: &'a mut Arena,
    symbols: &'a mut Symbols,
    unknowns: Vec<Symbol>,
    residuals: Vec<Expr>,
    dq: Vec<Expr>,
    dp: Vec<Vec<Expr>>,
    domain: Vec<Condition>,
}

/// What the functions of a step are called in: the action and the force.
fn roots(action: &Action) -> Vec<Expr> {
    let impulses = action.work.iter().map(|w| w.impulse);
    std::iter::once(action.value).chain(impulses).collect()
}

/// An unknown that an equation gives as `x = f(others)`.
#[derive(Clone, Copy)]
struct Pivot {
    unknown: Symbol,
    coefficient: f64,
}

/// An equation that may give an unknown: looked at again only when it has changed.
struct Candidate {
    /// Unknowns in it, in the order of `unknowns`.
    present: Vec<Symbol>,
    /// Whether `pivot` was sought.
    asked: bool,
    pivot: Option<Pivot>,
}

impl Reduced<'_> {
    /// The conditions of the domain at the solution of all blocks.
    fn domain_at(&mut self, known: &HashMap<Symbol, Expr>) -> Vec<Condition> {
        let conditions = self.domain.clone().into_iter();
        let at = conditions.map(|condition| Condition {
            value: self.arena.substitute(condition.value, known),
            ..condition
        });
        at.collect()
    }

    /// Removes every unknown that an equation gives as `x = f(others)` with a numeric coefficient, the shortest
    /// equation first.
    fn eliminate(&mut self) {
        let mut candidates: Vec<Candidate> = Vec::new();
        for row in 0..self.residuals.len() {
            candidates.push(self.candidate(row));
        }
        while let Some((
            row,
            Pivot {
                unknown,
                coefficient,
            },
        )) = self.best(&mut candidates)
        {
            candidates.remove(row);
            self.rows.remove(row);
            let equation = self.residuals.remove(row);
            let zero = self.arena.constant(0.0);
            let rest = self
                .arena
                .substitute(equation, &HashMap::from([(unknown, zero)]));
            let value = self.arena.scale(-1.0 / coefficient, rest);
            let by = HashMap::from([(unknown, value)]);
            self.unknowns.retain(|&u| u != unknown);
            for row in 0..self.residuals.len() {
                if self.arena.contains(self.residuals[row], unknown) {
                    self.residuals[row] = self.arena.substitute(self.residuals[row], &by);
                    candidates[row] = self.candidate(row);
                }
            }
            for list in std::iter::once(&mut self.dq).chain(&mut self.dp) {
                for expr in list {
                    if self.arena.contains(*expr, unknown) {
                        *expr = self.arena.substitute(*expr, &by);
                    }
                }
            }
            for condition in &mut self.domain {
                condition.value = self.arena.substitute(condition.value, &by);
            }
        }
    }

    /// The equation with the fewest unknowns that has one with a numeric coefficient; of equations with equally many the
    /// first.
    fn best(&mut self, candidates: &mut [Candidate]) -> Option<(usize, Pivot)> {
        let mut best: Option<(usize, usize, Pivot)> = None;
        for (row, candidate) in candidates.iter_mut().enumerate() {
            self.arena.spend(1);
            if self.arena.is_exhausted() {
                return None;
            }
            let present = candidate.present.len();
            if best.is_some_and(|b| b.0 <= present) {
                continue;
            }
            if !std::mem::replace(&mut candidate.asked, true) {
                candidate.pivot = self.pivot(row, &candidate.present);
            }
            if let Some(pivot) = candidate.pivot {
                best = Some((present, row, pivot));
            }
        }
        best.map(|(_, row, pivot)| (row, pivot))
    }

    fn candidate(&self, row: usize) -> Candidate {
        let contained = |u: &Symbol| self.arena.contains(self.residuals[row], *u);
        Candidate {
            present: self.unknowns.iter().copied().filter(contained).collect(),
            asked: false,
            pivot: None,
        }
    }

    /// Of an equation's unknowns the first, in the order of `unknowns`, with a numeric coefficient; so the momentum balance
    /// stays, and the velocity in it.
    fn pivot(&mut self, row: usize, present: &[Symbol]) -> Option<Pivot> {
        let residual = self.residuals[row];
        for &unknown in present {
            if self.rows[row].contains(&unknown) || self.moves_node(residual, unknown) {
                continue;
            }
            let slope = self.arena.diff(residual, unknown);
            if let Some(coefficient) = self.arena.constant_value(slope)
                && coefficient != 0.0
            {
                return Some(Pivot {
                    unknown,
                    coefficient,
                });
            }
        }
        None
    }

    /// Whether an unknown occurs within a named intermediate result, `q₀ + c d`. There it stands beside something much larger
    /// when the step is small, so that the equation gives it with the rounding of that: `m v − B (q₀ + d) = p₀` is no
    /// equation for d.
    fn moves_node(&self, residual: Expr, unknown: Symbol) -> bool {
        let mut nodes = self
            .arena
            .reachable(&[residual], |e| self.arena.contains(e, unknown))
            .into_iter();
        nodes.any(|e| matches!(self.arena.node(e), Node::Opaque(_)))
    }

    /// Rows and columns of each block, in the order of solution.
    fn blocks(&mut self) -> Result<Vec<RowsAndColumns>, Degenerate> {
        let n = self.unknowns.len();
        let depends: Vec<Vec<usize>> = self
            .residuals
            .iter()
            .map(|&r| {
                (0..n)
                    .filter(|&c| self.arena.contains(r, self.unknowns[c]))
                    .collect()
            })
            .collect();
        let row_of = match_columns(&depends, n).map_err(|free| Degenerate {
            unknowns: free.into_iter().map(|c| self.unknowns[c]).collect(),
        })?;
        // unknown c is given by equation row_of[c], which needs the unknowns in it
        let needs: Vec<Vec<usize>> = (0..n).map(|c| depends[row_of[c]].clone()).collect();
        Ok(strong_components(&needs)
            .into_iter()
            .map(|mut columns| {
                columns.sort_unstable();
                let mut rows: Vec<usize> = columns.iter().map(|&c| row_of[c]).collect();
                rows.sort_unstable();
                (rows, columns)
            })
            .collect())
    }
}

/// For each equation the unknowns that it may not give, although it has them with a numeric coefficient: such a coefficient
/// may be small beside the masses, as that of a weak coupling or of friction is. A velocity, an acceleration or its
/// multiplier may come from the equation of its own coordinate, and a velocity not from the equation of motion: elimination
/// along the diagonal of a mass matrix, which is positive definite, needs no pivoting (Higham, Accuracy and Stability of
/// Numerical Algorithms, section 10.1).
fn foreign(equations: &Equations, action: &Action, symbols: &Symbols) -> Vec<HashSet<Symbol>> {
    let n = action.start_q.len();
    let as_unknown = |symbol: Symbol| match symbols.meaning(symbol) {
        Meaning::Unknown(unknown) => Some(*unknown),
        _ => None,
    };
    let forbidden = |row: usize, unknown: Symbol| {
        let Some(Unknown { family, index }) = as_unknown(unknown) else {
            return false;
        };
        let variation = action.internal.get(row).copied().and_then(as_unknown);
        let is_own = index == variation.map_or(row % n, |of| of.index);
        let is_motion = variation.is_some_and(|of| of.family == Family::Flow);
        match family {
            Family::Velocity => is_motion || !is_own,
            Family::Acceleration | Family::Flow => !is_own,
            Family::Displacement | Family::Momentum | Family::Impulse => false,
        }
    };
    let rows = 0..equations.residuals.len();
    rows.map(|row| {
        let unknowns = equations.unknowns.iter().copied();
        unknowns.filter(|&u| forbidden(row, u)).collect()
    })
    .collect()
}

/// Whether a symbol is part of the state at the start of the step.
pub(crate) fn is_state(symbols: &Symbols, symbol: Symbol) -> bool {
    matches!(
        symbols.meaning(symbol),
        Meaning::Start(Quantity::Position | Quantity::Momentum, _)
    )
}
