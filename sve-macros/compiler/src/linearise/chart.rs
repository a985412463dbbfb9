//! The charts in which tangent maps and sensitivities of rotations are written.
//!
//! Input: the derivatives of a step in the entries of R₀, in Π₀ and in the parameters. Output: the
//! derivatives in canonical coordinates.
//!
//! Near a rotation R with momentum Π the coordinates are the vector ε of a small rotation, R
//! exp(ε̂), and the momentum y conjugate to ε. To first order `Π = y − ½ ε × Π`, so that
//! `δy = δΠ + ½ ε × Π`. The form `dε ∧ dy` is canonical, and the tangent map of a step is a
//! symplectic matrix. At the end of a step R₁ = R₀ exp(x̂),
//!
//! ```text
//! ε₁ = D(x) δx + exp(x̂)ᵀ ε₀
//! ```
//!
//! with the differential D of the exponential.

use crate::algebra::{Arena, Expr, Symbol};
use crate::model::chart::Chart;
use crate::model::configuration::{Block, Factor, cross};
use crate::rules::action::Action;
use crate::structure::Scheme;

/// A variable in which a step is differentiated.
pub(super) enum Input {
    Symbol(Symbol),
    /// A rotation that turns in a direction: the rates of the entries of R₀ and of the components
    /// of Π₀.
    Turn(Vec<(Symbol, Expr)>),
}

impl Input {
    /// Returns the derivative of an expression.
    pub(super) fn derivative(&self, expr: Expr, arena: &mut Arena) -> Expr {
        match self {
            Self::Symbol(symbol) => arena.diff(expr, *symbol),
            Self::Turn(rates) => {
                let mut terms = Vec::new();
                for &(symbol, rate) in rates {
                    if arena.contains(expr, symbol) {
                        let slope = arena.diff(expr, symbol);
                        terms.push((1.0, arena.mul(slope, rate)));
                    }
                }
                arena.sum(0.0, &terms)
            }
        }
    }
}

/// Returns the coordinates of the state at the start of a step.
pub(super) fn start(action: &Action, arena: &mut Arena) -> Vec<Input> {
    let mut inputs = Vec::new();
    for block in action.configuration.blocks() {
        let entries = &action.start_q[block.entries.clone()];
        match block.factor {
            Factor::Vector(_) => inputs.extend(entries.iter().map(|&s| Input::Symbol(s))),
            Factor::Rotation => {
                let momenta = &action.start_p[block.directions.clone()];
                inputs.extend((0..3).map(|k| turn(k, entries, momenta, arena)));
            }
        }
    }
    inputs.extend(action.start_p.iter().map(|&s| Input::Symbol(s)));
    inputs
}

/// Returns the turn of a rotation in the direction k: column l of R₀ moves by `R₀ (e_k × e_l)`, and
/// Π₀ by `− ½ e_k × Π₀`.
fn turn(k: usize, entries: &[Symbol], momenta: &[Symbol], arena: &mut Arena) -> Input {
    let (l, m) = ((k + 1) % 3, (k + 2) % 3);
    let mut rates = Vec::new();
    for row in 0..3 {
        let along = |column: usize, arena: &mut Arena| arena.symbol(entries[3 * column + row]);
        let (to_l, to_m) = (along(m, arena), along(l, arena));
        rates.push((entries[3 * l + row], to_l));
        rates.push((entries[3 * m + row], arena.neg(to_m)));
    }
    // e_k × Π has the components − Π_m along l and Π_l along m
    let [along_l, along_m] = [momenta[l], momenta[m]].map(|s| arena.symbol(s));
    rates.push((momenta[l], arena.scale(0.5, along_m)));
    rates.push((momenta[m], arena.scale(-0.5, along_l)));
    Input::Turn(rates)
}

/// Replaces the derivatives of q₁ − q₀ and p₁ − p₀, in rows, by the derivatives of the coordinates
/// at the end minus the coordinates at the start. If `first`, the columns are the coordinates at
/// the start and the parameters; otherwise they are unknowns.
pub(super) fn at_end(
    rows: &mut [Vec<Expr>],
    first: bool,
    scheme: &Scheme<Expr>,
    action: &Action,
    arena: &mut Arena,
) {
    let n = scheme.dq.len();
    for block in action.configuration.blocks() {
        if block.factor == Factor::Rotation {
            let columns = rows.first().map_or(0, Vec::len);
            let frame = Frame::new(&block, scheme, action, arena);
            for column in 0..columns {
                // the direction of the block that the column belongs to
                let turned = first.then(|| block.directions.clone().position(|i| i == column));
                let changes = block.directions.clone().map(|i| rows[i][column]);
                let momenta = block.directions.clone().map(|i| rows[n + i][column]);
                let (changes, momenta): (Vec<_>, Vec<_>) = (changes.collect(), momenta.collect());
                let [q, p] = frame.column(&changes, &momenta, turned.flatten(), arena);
                for (k, i) in block.directions.clone().enumerate() {
                    rows[i][column] = q[k];
                    rows[n + i][column] = p[k];
                }
            }
        }
    }
}

/// The quantities that the coordinates of a rotation at the end of a step depend on.
struct Frame {
    differential: [[Expr; 3]; 3],
    turn: [[Expr; 3]; 3],
    start: Vec<Expr>,
    end: Vec<Expr>,
}

impl Frame {
    fn new(block: &Block, scheme: &Scheme<Expr>, action: &Action, arena: &mut Arena) -> Self {
        let x: Vec<Expr> = block.directions.clone().map(|i| scheme.dq[i]).collect();
        let start: Vec<Expr> = block
            .directions
            .clone()
            .map(|i| arena.symbol(action.start_p[i]))
            .collect();
        let directions = block.directions.clone().zip(&start);
        let end = directions.map(|(i, &p)| arena.add(p, scheme.dp[i]));
        let end = end.collect();
        let chart = Chart::new(&x, arena);
        Self {
            differential: chart.differential(arena),
            turn: chart.transposed(arena),
            start,
            end,
        }
    }

    /// Returns the derivatives of the coordinates at the end minus the coordinates at the start,
    /// from the derivatives of x and of Π₁ − Π₀. `turned` is the direction in which R₀ turns, if it
    /// turns.
    fn column(
        &self,
        dx: &[Expr],
        dp: &[Expr],
        turned: Option<usize>,
        arena: &mut Arena,
    ) -> [Vec<Expr>; 2] {
        let mut angle = Vec::new();
        for row in 0..3 {
            let products = self.differential[row].iter().zip(dx);
            let mut terms: Vec<(f64, Expr)> =
                products.map(|(&a, &x)| (1.0, arena.mul(a, x))).collect();
            terms.extend(turned.map(|k| (1.0, self.turn[row][k])));
            angle.push(arena.sum(0.0, &terms));
        }
        let across = cross(&angle, &self.end, arena);
        let zero = arena.constant(0.0);
        let mut before = vec![zero; 3];
        let mut q = angle;
        if let Some(k) = turned {
            // δΠ₀ = − ½ e_k × Π₀, and the identity of q is added later
            let mut unit = [zero; 3];
            unit[k] = arena.constant(1.0);
            before = cross(&unit, &self.start, arena);
            let one = arena.constant(1.0);
            q[k] = arena.sub(q[k], one);
        }
        let p = (0..3).map(|k| {
            let terms = [(1.0, dp[k]), (0.5, across[k]), (-0.5, before[k])];
            arena.sum(0.0, &terms)
        });
        [q, p.collect()]
    }
}
