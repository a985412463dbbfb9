//! The equations of motion, coordinate by coordinate, and the momenta, in the first-order
//! Stratonovich form.
//!
//! The equations of a degenerate Lagrangian are `ω dq = ∇H dt − ∇γ ∘ dW` for massless coordinates
//! and `0 = ∂L/∂q` for algebraic ones.

use super::names::Names;
use super::page::Page;
use super::shown;
use crate::algebra::{Arena, Expr, Sum};
use crate::system::classify::Classified;
use crate::system::degeneracy::{Degeneracy, Role};
use crate::system::mechanics::{Mechanics, NoiseJet};

/// The equations of motion that are complete so far.
struct Motion<'a> {
    page: Page<'a>,
    mechanics: &'a Mechanics,
}

/// Prints the equations of motion.
pub(super) fn motion(system: &Classified, arena: &Arena) -> Vec<String> {
    let (model, mechanics) = (&system.model, &system.mechanics);
    let jet = &mechanics.lagrangian;
    let n = model.dof();
    let count = shown(n);
    let mut roots: Vec<Expr> = match &system.degeneracy {
        Some(degeneracy) => {
            let rows = degeneracy.two_form[..count].iter();
            let slopes = degeneracy.rest_slopes[..count].iter();
            slopes.chain(rows.flatten()).copied().collect()
        }
        None => jet.dq[..count].to_vec(),
    };
    roots.extend(&jet.dv[..count]);
    for noise in &mechanics.noises {
        roots.extend(noise.dq[..count].iter().chain(&noise.dp[..count]));
        let force = noise.force.iter().flat_map(|force| &force.value[..count]);
        roots.extend(force);
    }
    if let Some(force) = &mechanics.force {
        roots.extend(&force.value[..count]);
    }
    for constraint in &mechanics.constraints {
        roots.extend(&constraint.dq[..count]);
    }
    let mut page = Page::new(arena, Names::new(&model.symbols, None));
    page.name_parts(&roots);
    let mut motion = Motion { page, mechanics };
    let mut lines = Vec::new();
    if let Some(degeneracy) = &system.degeneracy {
        lines.extend((0..count).flat_map(|i| motion.of_role(i, degeneracy)));
        if count < n {
            lines.push(format!("… ({} more coordinates)", n - count));
        }
    } else {
        let moved: Vec<String> = (0..count).map(|i| motion.moved(i)).collect();
        lines.extend(Page::list(moved, n, "coordinates"));
        let pushed: Vec<String> = (0..count).map(|i| motion.pushed(i)).collect();
        lines.extend(Page::list(pushed, n, "momenta"));
    }
    let page = &mut motion.page;
    let momenta = (0..count).map(|i| {
        let name = page.names.symbols.component("p", i);
        format!("{name} = {}", page.formula(jet.dv[i]))
    });
    let momenta: Vec<String> = momenta.collect();
    lines.extend(Page::list(momenta, n, "momenta"));
    lines.extend(page.explanations(|_| false));
    lines
}

impl Motion<'_> {
    /// Returns `dq = v dt + ∂G/∂p ∘ dW`.
    fn moved(&mut self, i: usize) -> String {
        let symbols = &self.page.names.symbols;
        let mut line = Line::new(&symbols.component("dq", i));
        line.push(false, &format!("{} dt", symbols.component("v", i)));
        self.kicks(&mut line, |noise| vec![(1.0, noise.dp[i])]);
        line.text
    }

    /// Returns `dp = (∂L/∂q + F) dt + Σ ∂φ/∂q ∘ dΛ + (f − ∂G/∂q) ∘ dW`.
    fn pushed(&mut self, i: usize) -> String {
        let mut line = Line::new(&self.page.names.symbols.component("dp", i));
        // in the body frame the momentum is rotated against the rotation of the body
        if let Some(turned) = self.page.names.symbols.transport(i) {
            line.push(false, &turned);
        }
        let force = self.mechanics.force.as_ref();
        let forces = force.map(|force| (1.0, force.value[i]));
        let forces = [(1.0, self.mechanics.lagrangian.dq[i])]
            .into_iter()
            .chain(forces);
        self.add(&mut line, forces, "dt");
        let constraints = &self.mechanics.constraints;
        for (k, constraint) in constraints.iter().enumerate() {
            let differential = numbered("∘ dΛ", k, constraints.len());
            self.add(&mut line, [(1.0, constraint.dq[i])], &differential);
        }
        self.kicks(&mut line, |noise| {
            let force = noise.force.iter().map(|force| (1.0, force.value[i]));
            [(-1.0, noise.dq[i])].into_iter().chain(force).collect()
        });
        line.text
    }

    /// Returns the equations of a coordinate of a degenerate Lagrangian.
    fn of_role(&mut self, i: usize, degeneracy: &Degeneracy) -> Vec<String> {
        let slope = degeneracy.rest_slopes[i];
        match degeneracy.roles[i] {
            // `dp = ∂L₀/∂q dt + Σ ∂α_k/∂q ∘ dq_k − ∂G/∂q ∘ dW`
            Role::Massive => {
                let moved = self.moved(i);
                let mut line = Line::new(&self.page.names.symbols.component("dp", i));
                self.add(&mut line, [(1.0, slope)], "dt");
                self.moving(&mut line, &degeneracy.slopes[i]);
                self.kicks(&mut line, |noise| vec![(-1.0, noise.dq[i])]);
                vec![moved, line.text]
            }
            // `Σ_k ω_ik dq_k = −∂L₀/∂q_i dt + ∂G/∂q_i ∘ dW`
            Role::Massless => {
                let mut left = Line::new("");
                self.moving(&mut left, &degeneracy.two_form[i]);
                let left = left.text;
                let mut line = Line::new(left.strip_prefix(" = ").unwrap_or(&left));
                self.add(&mut line, [(-1.0, slope)], "dt");
                self.kicks(&mut line, |noise| vec![(1.0, noise.dq[i])]);
                vec![line.text]
            }
            Role::Algebraic => {
                let mut sum = Sum::default();
                sum.add(1.0, slope, self.page.arena);
                vec![format!("0 = {}", self.page.sum(&sum))]
            }
        }
    }

    /// Adds a sum times a differential.
    fn add(
        &mut self,
        line: &mut Line,
        terms: impl IntoIterator<Item = (f64, Expr)>,
        differential: &str,
    ) {
        let mut sum = Sum::default();
        for (c, term) in terms {
            sum.add(c, term, self.page.arena);
        }
        if !sum.is_zero() {
            let (negative, factor) = self.page.factor(&sum);
            line.push(negative, &format!("{factor} {differential}"));
        }
    }

    /// Adds the coefficients of the differentials of the coordinates.
    fn moving(&mut self, line: &mut Line, coefficients: &[Expr]) {
        for (of, &coefficient) in coefficients.iter().enumerate() {
            let mut term = Sum::default();
            term.add(1.0, coefficient, self.page.arena);
            if term.is_zero() {
                continue;
            }
            let (negative, factor) = self.page.factor(&term);
            let differential = self.page.names.symbols.component("dq", of);
            match factor.as_str() {
                "1" => line.push(negative, &differential),
                factor => line.push(negative, &format!("{factor} ∘ {differential}")),
            }
        }
    }

    /// Adds the noises.
    fn kicks(&mut self, line: &mut Line, of: impl Fn(&NoiseJet) -> Vec<(f64, Expr)>) {
        let noises = &self.mechanics.noises;
        for (at, noise) in noises.iter().enumerate() {
            self.add(line, of(noise), &numbered("∘ dW", at, noises.len()));
        }
    }
}

/// Returns a differential, with its index if there are several.
fn numbered(differential: &str, at: usize, count: usize) -> String {
    if count == 1 {
        differential.to_owned()
    } else {
        format!("{differential}[{at}]")
    }
}

/// An equation `dx = a dt + b ∘ dW` whose terms are being added.
struct Line {
    text: String,
    empty: bool,
}

impl Line {
    fn new(left: &str) -> Self {
        Self {
            text: format!("{left} = 0"),
            empty: true,
        }
    }

    fn push(&mut self, negative: bool, term: &str) {
        let sign = match (self.empty, negative) {
            (true, true) => "−",
            (true, false) => "",
            (false, true) => " − ",
            (false, false) => " + ",
        };
        if self.empty {
            self.text.truncate(self.text.len() - 1);
            self.empty = false;
        }
        self.text.push_str(sign);
        self.text.push_str(term);
    }
}
