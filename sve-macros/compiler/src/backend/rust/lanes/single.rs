//! Iterations in lanes in a single unknown whose root is accepted by bounds.
//!
//! The loop in which an iteration starts evaluates the equation at the guess and makes the first
//! update. If only the iteration needs the sine and cosine of an angle, these are computed at the
//! guess; later points add the distance of their angle from there. Invariant: the distance counts
//! from the rounded angle at the guess, so rounding that angle changes the start of the addition
//! and not its result.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::super::axis::Axis;
use super::super::ident;
use super::super::solve::names;
use super::{Operation, Residual, Tier, Value, Writer, course, is_single};
use crate::structure::Iteration;

/// Numbers that are kept of an angle: sine and cosine at the guess, and the distance of the angle
/// from its base.
const KEPT: usize = 3;

impl Writer<'_> {
    pub(super) fn is_single(&self, at: usize) -> bool {
        is_single(&self.step.scheme.blocks[at].solution)
    }

    /// The start of an iteration: its guess, the evaluation there, and the first update.
    pub(super) fn start_single(
        &self,
        at: usize,
        iteration: &Iteration<Value, Residual>,
    ) -> TokenStream {
        let course = course(at);
        let (guess, limit) = (self.guess(at, iteration), self.limit(at, iteration));
        let iterates = names(&iteration.iterates, self.symbols);
        let statements = self.statements_of(at, true);
        let evaluation = self.evaluation(at, iteration);
        quote! {
            let limit = #limit;
            let guess = #guess;
            let #iterates = guess;
            #statements
            #course.start(lane, guess, limit, &#evaluation);
        }
    }

    /// The statements of an iteration after the evaluation at its guess.
    pub(super) fn statements_from_guess(&self, at: usize) -> TokenStream {
        self.statements_of(at, false)
    }

    fn statements_of(&self, at: usize, is_at_guess: bool) -> TokenStream {
        let (program, printer, private) = (&self.step.program, self.printer, self.private);
        let angles = angles(at);
        let mut place = 0;
        let statement = |(value, operation)| {
            let (Operation::AngleAddition(_, _, by), Some(&base)) =
                (operation, self.loops.moved.get(&value))
            else {
                return printer.statement(value, operation);
            };
            let rows = quote!(#angles.0);
            let kept = [0, 1, 2].map(|k| Axis::Lanes.entry(&rows, place + k));
            let [at_sin, at_cos, distance] = kept;
            place += KEPT;
            let [sin, cos] = printer.pair(value).map(|name| ident(&name));
            let (base, by) = (printer.operand(base), printer.operand(by));
            if is_at_guess {
                quote! {
                    let angle = #base + #by;
                    let (#sin, #cos) = #private::lane::sin_cos(angle);
                    #at_sin = #sin;
                    #at_cos = #cos;
                    #distance = angle - #base;
                }
            } else {
                quote! {
                    let (#sin, #cos) = #private::lane::sin_cos_of_sum(
                        #at_sin,
                        #at_cos,
                        #by - #distance,
                    );
                }
            }
        };
        program.of_tier(Tier::Iterate(at)).map(statement).collect()
    }

    /// The rows for the angles at the guess.
    pub(super) fn angles_at_guess(&self, at: usize) -> Option<TokenStream> {
        let of_block = |value: &&Value| self.step.program.get(**value).tier == Tier::Iterate(at);
        let count = self.loops.moved.keys().filter(of_block).count();
        let (private, angles) = (self.private, angles(at));
        let rows = Literal::usize_unsuffixed(KEPT * count);
        (count > 0).then(|| quote!(let mut #angles = #private::lane::rows::<#rows>();))
    }
}

/// Sines, cosines and distances of the angles at the guess of a block.
fn angles(at: usize) -> Ident {
    format_ident!("angles_{at}")
}
