//! The functions of the exponential chart with their derivatives, and their leading terms.

use std::collections::HashMap;

use super::super::nodes::OTHERS;
use super::polynomial;
use crate::algebra::{Arena, Expr, Identity, Node};

/// The functions of the chart that have their own rules of differentiation.
#[derive(Clone, Copy)]
pub(super) enum Part {
    Square,
    U2,
    U,
    T,
    B,
    B2,
    /// B, as `1/12 + s B₂`.
    BOfB2,
    /// `sin(θ/2)/θ`.
    Sine,
    /// `1 − cos(θ/2)`.
    Versine,
}

impl Part {
    fn identity(self) -> Identity {
        Identity(OTHERS | self as u64)
    }

    /// Returns an intermediate result with the identity of this part, and lets the arena know the
    /// rule of its derivative:
    ///
    /// ```text
    /// u′ = u/16 + s u²/32 − 3 u₂/2        T′ = (T² − u)/8
    /// B′ = (u′ + 2 T T′ − 4 T′ B)/(4T)   = (B² − 3 B₂)/2
    /// (sin(θ/2)/θ)′ = −(u + T²)/(4T) sin(θ/2)/(2θ)        (1 − cos(θ/2))′ = sin(θ/2)/(4θ)
    /// ```
    pub(super) fn named(self, value: Expr, arena: &mut Arena) -> Expr {
        match self {
            Self::Square | Self::U2 | Self::B2 => {}
            Self::U => arena.differentiate_by(self.identity(), |arena, u| {
                let s = Self::Square.within(u, arena)?;
                Some([s, slope_of_u(s, u, arena)?])
            }),
            Self::T => arena.differentiate_by(self.identity(), |arena, t| {
                let s = Self::Square.within(t, arena)?;
                Some([s, slope_of_t(t, arena)?])
            }),
            Self::B => arena.differentiate_by(self.identity(), |arena, b| {
                let s = Self::Square.within(b, arena)?;
                let [t, u] = [Self::T.within(b, arena)?, Self::U.within(b, arena)?];
                let (du, dt) = (slope_of_u(s, u, arena)?, slope_of_t(t, arena)?);
                let (twice, less) = (arena.mul(t, dt), arena.mul(dt, b));
                let sum = arena.sum(0.0, &[(0.25, du), (0.5, twice), (-1.0, less)]);
                Some([s, arena.div(sum, t)])
            }),
            Self::BOfB2 => arena.differentiate_by(self.identity(), |arena, b| {
                let s = Self::Square.within(b, arena)?;
                let b2 = Self::B2.within(b, arena)?;
                let square = arena.pow(b, 2);
                Some([s, arena.sum(0.0, &[(0.5, square), (-1.5, b2)])])
            }),
            Self::Sine => arena.differentiate_by(self.identity(), |arena, sine| {
                let s = Self::Square.within(sine, arena)?;
                let [t, u] = [Self::T.within(sine, arena)?, Self::U.within(sine, arena)?];
                let b = b_of(t, u, arena);
                let slope = arena.mul(b, sine);
                Some([s, arena.scale(-0.5, slope)])
            }),
            Self::Versine => arena.differentiate_by(self.identity(), |arena, versine| {
                let s = Self::Square.within(versine, arena)?;
                let sine = Self::Sine.within(versine, arena)?;
                Some([s, arena.scale(0.25, sine)])
            }),
        }
        arena.intermediate(value, Some(self.identity()))
    }

    fn is(self, expr: Expr, arena: &Arena) -> bool {
        matches!(arena.node(expr), Node::Opaque(_, Some(identity)) if *identity == self.identity())
    }

    /// Returns this part of the chart that a part of it belongs to. Other charts may occur in its
    /// argument s alone: an increment can depend on the attitudes of other bodies.
    fn within(self, part: Expr, arena: &Arena) -> Option<Expr> {
        let operands: Vec<Expr> = arena.operands_of(part).collect();
        let own = operands.iter().copied().find(|&e| self.is(e, arena));
        own.or_else(|| {
            let mut others = operands.iter().filter(|&&e| !Self::Square.is(e, arena));
            others.find_map(|&e| self.within(e, arena))
        })
    }
}

/// Returns expressions in which the functions of all charts are polynomials of first degree in s,
/// or of second degree where they vanish at 0.
pub(crate) fn of_small_angles(exprs: &[Expr], arena: &mut Arena) -> Vec<Expr> {
    const OF_S: [(Part, [f64; 3]); 5] = [
        (Part::T, [0.25, 1.0 / 192.0, 0.0]),
        (Part::B, [1.0 / 12.0, 1.0 / 720.0, 0.0]),
        (Part::BOfB2, [1.0 / 12.0, 1.0 / 720.0, 0.0]),
        (Part::Sine, [0.5, -1.0 / 48.0, 0.0]),
        (Part::Versine, [0.0, 1.0 / 8.0, -1.0 / 384.0]),
    ];
    let mut by = HashMap::new();
    for e in arena.reachable(exprs, |_| true) {
        let of_part = OF_S.iter().find(|(part, _)| part.is(e, arena));
        if let Some((_, coefficients)) = of_part
            && let Some(s) = Part::Square.within(e, arena)
        {
            by.insert(e, polynomial(coefficients, s, arena));
        }
    }
    arena.replace_all(exprs, &by)
}

/// Returns `B = (u + T²)/(4T)`.
pub(super) fn b_of(t: Expr, u: Expr, arena: &mut Arena) -> Expr {
    let t2 = arena.pow(t, 2);
    let dividend = arena.sum(0.0, &[(0.25, u), (0.25, t2)]);
    let b = arena.product(&[(dividend, 1), (t, -1)]);
    Part::B.named(b, arena)
}

fn slope_of_u(s: Expr, u: Expr, arena: &mut Arena) -> Option<Expr> {
    let u2 = Part::U2.within(u, arena)?;
    let square = arena.product(&[(s, 1), (u, 2)]);
    let slope = arena.sum(0.0, &[(1.0 / 16.0, u), (1.0 / 32.0, square), (-1.5, u2)]);
    Some(arena.opaque(slope))
}

fn slope_of_t(t: Expr, arena: &mut Arena) -> Option<Expr> {
    let u = Part::U.within(t, arena)?;
    let square = arena.pow(t, 2);
    let slope = arena.sum(0.0, &[(0.125, square), (-0.125, u)]);
    Some(arena.opaque(slope))
}
