//! Equations → blocks: what is explicit, what is linear, what needs Newton's method.
//!
//! Input: [`Equations`]. Output: a [`Scheme`], the same equations cut into blocks to be solved in order. First every unknown is
//! eliminated that some equation gives with a numeric coefficient, then the rest is split into strongly connected blocks of
//! equations against unknowns (Duff, Erisman, Reid: Direct Methods for Sparse Matrices, chapter 6).

use std::collections::HashMap;

use crate::action::Action;
use crate::equations::Equations;
use crate::model::{Meaning, Quantity, Symbols};
use crate::symbolic::{Arena, Expr, Node, Symbol};

/// A step, ready to be scheduled.
pub(crate) struct Scheme {
    pub(crate) blocks: Vec<Block>,
    pub(crate) dq: Vec<Expr>,
    pub(crate) dp: Vec<Expr>,
    pub(crate) form: Form,
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
    pub(crate) solution: Solution,
}

/// What there is to compute.
pub(crate) enum Solution {
    /// A single unknown by a formula, which has taken its place in everything that follows.
    Formula,
    /// A linear system; `solved` are the names of the solution in everything that follows.
    System {
        matrix: Vec<Vec<Expr>>,
        rhs: Vec<Expr>,
        solved: Vec<Symbol>,
    },
    /// An iteration from the solution of a linear system.
    Iteration(Box<Iteration>),
}

/// Newton's method on a block.
pub(crate) struct Iteration {
    /// First guess: the Newton step from zero.
    pub(crate) guess_matrix: Vec<Vec<Expr>>,
    pub(crate) guess_rhs: Vec<Expr>,
    pub(crate) residual: Vec<Expr>,
    pub(crate) jacobian: Vec<Vec<Expr>>,
    /// Names of the iterates in `residual` and `jacobian`.
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
    let mut system = Reduced {
        arena,
        symbols,
        unknowns: equations.unknowns,
        residuals: equations.residuals,
        dq: equations.dq,
        dp: equations.dp,
    };
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
        dq,
        dp,
        form: Form::Increment,
    };
    Ok(linear_map(increments, action, symbols, arena))
}

/// Equations and the unknowns that they determine.
type RowsAndColumns = (Vec<usize>, Vec<usize>);

struct Reduced<'a> {
    arena: &'a mut Arena,
    symbols: &'a mut Symbols,
    unknowns: Vec<Symbol>,
    residuals: Vec<Expr>,
    dq: Vec<Expr>,
    dp: Vec<Vec<Expr>>,
}

impl Reduced<'_> {
    /// Removes every unknown that an equation gives as `x = f(others)` with a numeric coefficient, the shortest
    /// equation first.
    fn eliminate(&mut self) {
        while let Some((row, unknown, coefficient)) = self.pivot() {
            let equation = self.residuals.remove(row);
            let zero = self.arena.constant(0.0);
            let rest = self
                .arena
                .substitute(equation, &HashMap::from([(unknown, zero)]));
            let value = self.arena.scale(-1.0 / coefficient, rest);
            let by = HashMap::from([(unknown, value)]);
            self.unknowns.retain(|&u| u != unknown);
            for list in std::iter::once(&mut self.residuals)
                .chain([&mut self.dq])
                .chain(&mut self.dp)
            {
                for expr in list {
                    *expr = self.arena.substitute(*expr, &by);
                }
            }
        }
    }

    /// The equation with the fewest unknowns that has one with a numeric coefficient: equation, unknown, coefficient.
    /// Of equations with equally many the first is taken, of its unknowns the first in the order of `unknowns`; so the
    /// momentum balance stays, and the velocity in it.
    fn pivot(&mut self) -> Option<(usize, Symbol, f64)> {
        let mut best: Option<(usize, usize, Symbol, f64)> = None;
        for (row, &residual) in self.residuals.clone().iter().enumerate() {
            let present: Vec<Symbol> = self
                .unknowns
                .iter()
                .copied()
                .filter(|&u| self.arena.contains(residual, u))
                .collect();
            if best.is_some_and(|b| b.0 <= present.len()) {
                continue;
            }
            for &unknown in &present {
                let slope = self.arena.diff(residual, unknown);
                if let Some(coefficient) = self.arena.constant_value(slope)
                    && coefficient != 0.0
                {
                    best = Some((present.len(), row, unknown, coefficient));
                    break;
                }
            }
        }
        best.map(|(_, row, unknown, coefficient)| (row, unknown, coefficient))
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

    /// Classifies a block and writes down what solves it; `known` gets what its unknowns are called afterwards.
    fn solve(
        &mut self,
        rows: &[usize],
        columns: &[usize],
        known: &mut HashMap<Symbol, Expr>,
    ) -> Block {
        let unknowns: Vec<Symbol> = columns.iter().map(|&c| self.unknowns[c]).collect();
        let residual: Vec<Expr> = rows
            .iter()
            .map(|&r| self.arena.substitute(self.residuals[r], known))
            .collect();
        let mut jacobian: Vec<Vec<Expr>> = Vec::new();
        for &r in &residual {
            let row = unknowns.iter().map(|&u| {
                let slope = self.arena.diff(r, u);
                if self.arena.is_zero(slope) {
                    self.arena.constant(0.0)
                } else {
                    slope
                }
            });
            jacobian.push(row.collect());
        }
        let zero = self.arena.constant(0.0);
        let nonzeros = jacobian.iter().flatten().filter(|&&e| e != zero).count();
        let at_zero: HashMap<Symbol, Expr> = unknowns.iter().map(|&u| (u, zero)).collect();
        let guess_matrix: Vec<Vec<Expr>> = jacobian
            .iter()
            .map(|row| {
                row.iter()
                    .map(|&e| self.arena.substitute(e, &at_zero))
                    .collect()
            })
            .collect();
        let guess_rhs: Vec<Expr> = residual
            .iter()
            .map(|&r| {
                let r = self.arena.substitute(r, &at_zero);
                self.arena.neg(r)
            })
            .collect();

        let linear = self.is_linear(&jacobian, &unknowns);
        let (kind, solution) = if linear && unknowns.len() == 1 {
            let formula = self.arena.div(guess_rhs[0], guess_matrix[0][0]);
            known.insert(unknowns[0], self.arena.opaque(formula));
            let kind = if self.is_parameter(guess_matrix[0][0]) {
                Kind::Explicit
            } else {
                Kind::Linear
            };
            (kind, Solution::Formula)
        } else {
            let solved: Vec<Symbol> = unknowns
                .iter()
                .map(|&u| {
                    let meaning = Meaning::Unknown(self.symbols.name(u));
                    self.symbols.declare(meaning)
                })
                .collect();
            for (&u, &s) in unknowns.iter().zip(&solved) {
                known.insert(u, self.arena.symbol(s));
            }
            if linear {
                (
                    Kind::Linear,
                    Solution::System {
                        matrix: guess_matrix,
                        rhs: guess_rhs,
                        solved,
                    },
                )
            } else {
                let iterates = unknowns.clone();
                let iteration = Iteration {
                    guess_matrix,
                    guess_rhs,
                    residual,
                    jacobian,
                    iterates,
                    solved,
                };
                (Kind::Newton, Solution::Iteration(Box::new(iteration)))
            }
        };
        Block {
            kind,
            unknowns,
            nonzeros,
            solution,
        }
    }

    /// Whether no entry of the Jacobian changes with the unknowns.
    fn is_linear(&mut self, jacobian: &[Vec<Expr>], unknowns: &[Symbol]) -> bool {
        for &entry in jacobian.iter().flatten() {
            for &u in unknowns {
                let change = self.arena.diff(entry, u);
                if !self.arena.is_zero(change) {
                    return false;
                }
            }
        }
        true
    }

    /// Whether only parameters occur: with the step size in it, a coefficient comes from an implicit equation.
    fn is_parameter(&self, expr: Expr) -> bool {
        self.arena
            .symbols_of(expr)
            .all(|s| matches!(self.symbols.meaning(s), Meaning::Parameter { .. }))
    }
}

/// An equation for each unknown, by augmenting paths; or the unknowns left without one.
fn match_columns(depends: &[Vec<usize>], n: usize) -> Result<Vec<usize>, Vec<usize>> {
    let mut row_of: Vec<Option<usize>> = vec![None; n];
    for row in 0..depends.len() {
        augment(row, depends, &mut row_of);
    }
    let free: Vec<usize> = (0..n).filter(|&c| row_of[c].is_none()).collect();
    if free.is_empty() {
        Ok(row_of.into_iter().flatten().collect())
    } else {
        Err(free)
    }
}

/// Finds an equation's unknown by a breadth-first search for an augmenting path.
fn augment(start: usize, depends: &[Vec<usize>], row_of: &mut [Option<usize>]) {
    let mut from: Vec<Option<usize>> = vec![None; row_of.len()];
    let mut queue = std::collections::VecDeque::from([start]);
    while let Some(row) = queue.pop_front() {
        for &column in &depends[row] {
            if from[column].is_some() {
                continue;
            }
            from[column] = Some(row);
            match row_of[column] {
                Some(next) => queue.push_back(next),
                None => {
                    // walk back, shifting each equation to its new unknown
                    let mut column = column;
                    while let Some(row) = from[column] {
                        let previous = row_of.iter().position(|&r| r == Some(row));
                        row_of[column] = Some(row);
                        match previous {
                            Some(p) if row != start => column = p,
                            _ => return,
                        }
                    }
                    return;
                }
            }
        }
    }
}

/// Strongly connected components, each after those it needs (Tarjan 1972, with an explicit stack).
fn strong_components(needs: &[Vec<usize>]) -> Vec<Vec<usize>> {
    const UNSEEN: usize = usize::MAX;
    let n = needs.len();
    let (mut index, mut low, mut on_stack) = (vec![UNSEEN; n], vec![0; n], vec![false; n]);
    let (mut stack, mut components, mut counter) = (Vec::new(), Vec::new(), 0);
    for root in 0..n {
        if index[root] != UNSEEN {
            continue;
        }
        let mut calls = vec![(root, 0)];
        while let Some(&mut (node, ref mut edge)) = calls.last_mut() {
            if *edge == 0 {
                index[node] = counter;
                low[node] = counter;
                counter += 1;
                stack.push(node);
                on_stack[node] = true;
            }
            if let Some(&next) = needs[node].get(*edge) {
                *edge += 1;
                if index[next] == UNSEEN {
                    calls.push((next, 0));
                } else if on_stack[next] {
                    low[node] = low[node].min(index[next]);
                }
                continue;
            }
            calls.pop();
            if let Some(&(parent, _)) = calls.last() {
                low[parent] = low[parent].min(low[node]);
            }
            if low[node] == index[node] {
                let mut component = Vec::new();
                while let Some(member) = stack.pop() {
                    on_stack[member] = false;
                    component.push(member);
                    if member == node {
                        break;
                    }
                }
                components.push(component);
            }
        }
    }
    components
}

/// Degrees of freedom up to which a linear step is written as a matrix.
const MATRIX: usize = 2;

/// A step that is solved by linear formulas and affine in the state becomes a matrix, `z₁ − z₀ = A z₀ + b`, whose entries are
/// known before the state: the shortest chain of operations from one state to the next.
///
/// Where A depends on the increments of the noise, `z₁ = (1 + A) z₀ + b` is shorter still; the rounding of `1 + A` is another
/// one in each step, so it does not add up, as it would where A is the same in all steps.
fn linear_map(scheme: Scheme, action: &Action, symbols: &Symbols, arena: &mut Arena) -> Scheme {
    let formulas = scheme
        .blocks
        .iter()
        .all(|b| matches!(b.solution, Solution::Formula));
    let implicit = scheme.blocks.iter().any(|b| b.kind == Kind::Linear);
    if !formulas || !implicit || action.start_q.len() > MATRIX {
        return scheme;
    }
    let state: Vec<Symbol> = action
        .start_q
        .iter()
        .chain(&action.start_p)
        .copied()
        .collect();
    let zero = arena.constant(0.0);
    let origin: HashMap<Symbol, Expr> = state.iter().map(|&s| (s, zero)).collect();
    let is_noisy = |arena: &Arena, e: Expr| {
        arena
            .symbols_of(e)
            .any(|s| matches!(symbols.meaning(s), Meaning::Wiener(_)))
    };
    let mut rows = Vec::new();
    let mut noisy = true;
    for (at, &increment) in scheme.dq.iter().chain(&scheme.dp).enumerate() {
        let mut row = Vec::new();
        for &s in &state {
            let entry = arena.diff(increment, s);
            if state.iter().any(|&other| arena.contains(entry, other)) {
                return scheme;
            }
            row.push(entry);
        }
        noisy &= is_noisy(arena, row[at]);
        rows.push((row, arena.substitute(increment, &origin)));
    }
    let form = if noisy { Form::State } else { Form::Increment };
    let mut outputs = rows.into_iter().enumerate().map(|(at, (mut row, offset))| {
        if form == Form::State {
            row[at] = arena.sum(1.0, &[(1.0, row[at])]);
        }
        let mut terms = vec![(1.0, offset)];
        for (&entry, &s) in row.iter().zip(&state) {
            let entry = arena.opaque(entry);
            let s = arena.symbol(s);
            terms.push((1.0, arena.mul(entry, s)));
        }
        arena.sum(0.0, &terms)
    });
    let n = action.start_q.len();
    let dq = outputs.by_ref().take(n).collect();
    let dp = outputs.collect();
    Scheme {
        dq,
        dp,
        form,
        ..scheme
    }
}

/// Operations that a call of a function is worth.
const CALL: usize = 20;

/// Operations that have to be saved before a momentum increment is written other than as the kick itself, which rounds least.
const WORTH: usize = 10;

/// For each momentum increment the form that adds least to what is computed anyway.
fn cheapest(arena: &Arena, candidates: &[Vec<Expr>], dq: &[Expr], blocks: &[Block]) -> Vec<Expr> {
    let mut needed: Vec<Expr> = dq.to_vec();
    for block in blocks {
        if let Solution::System { matrix, rhs, .. } = &block.solution {
            needed.extend(matrix.iter().flatten().chain(rhs));
        }
    }
    let mut chosen = Vec::new();
    for list in candidates {
        let base = cost(arena, &needed);
        let price = |e: Expr| {
            let mut with = needed.clone();
            with.push(e);
            cost(arena, &with) - base
        };
        let mut best = (price(list[0]), list[0]);
        for &other in &list[1..] {
            let p = price(other);
            if p + WORTH <= best.0 {
                best = (p, other);
            }
        }
        needed.push(best.1);
        chosen.push(best.1);
    }
    chosen
}

fn cost(arena: &Arena, roots: &[Expr]) -> usize {
    arena
        .reachable(roots, |_| true)
        .into_iter()
        .map(|e| match arena.node(e) {
            Node::Constant(_) | Node::Symbol(_) | Node::Opaque(_) => 0,
            Node::Sum(_, terms) => terms.len(),
            Node::Product(factors) => factors.len(),
            Node::Call(..) | Node::Call2(..) => CALL,
        })
        .sum()
}

/// Whether a symbol is part of the state at the start of the step.
pub(crate) fn is_state(symbols: &Symbols, symbol: Symbol) -> bool {
    matches!(
        symbols.meaning(symbol),
        Meaning::Start(Quantity::Position | Quantity::Momentum, _)
    )
}
