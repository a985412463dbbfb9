//! `impl System`: the derivatives of L and of the noises.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use super::{attributes, private};
use crate::mechanics::{LagrangianJet, Mechanics, NoiseJet};
use crate::model::{Model, Symbols};
use crate::parse::Annotated;
use crate::schedule::{Scheduler, Tier, Tiers};
use crate::symbolic::{Arena, Expr};

pub(crate) fn system(
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    arena: &Arena,
) -> TokenStream {
    let (private, attributes) = (private(block), attributes());
    let self_ty = &block.item.self_ty;
    let n = Literal::usize_unsuffixed(model.dof());
    let m = Literal::usize_unsuffixed(model.noises.len());
    let Mechanics {
        lagrangian,
        noises,
        affine_momentum,
        clash: _,
    } = mechanics;
    let lagrangian_body = lagrangian_jet(&private, lagrangian, &model.symbols, arena);
    let noise_body = noise_jets(&private, noises, &model.symbols, arena);
    quote! {
        #attributes
        impl #private::System for #self_ty {
            type Dims = #private::Dims<#n, #m>;
            const AFFINE_MOMENTUM: bool = #affine_momentum;
            #[inline]
            fn lagrangian_jet(&self, time: f64, q: &[f64; #n], v: &[f64; #n]) -> #private::LagrangianJet<#n> {
                #lagrangian_body
            }
            #[inline]
            fn noise_jets(&self, time: f64, q: &[f64; #n], p: &[f64; #n]) -> [#private::NoiseJet<#n>; #m] {
                #noise_body
            }
        }
    }
}

/// Code of one tier: everything in it is computed where it is called.
struct Straight<'a> {
    scheduler: Scheduler<'a>,
    symbols: &'a Symbols,
}

impl<'a> Straight<'a> {
    fn new(arena: &'a Arena, symbols: &'a Symbols, roots: &[Expr]) -> Self {
        let tiers: Tiers = roots
            .iter()
            .flat_map(|&e| arena.symbols_of(e))
            .map(|s| (s, Tier::State))
            .collect();
        Self {
            scheduler: Scheduler::new(arena, symbols, tiers, roots),
            symbols,
        }
    }

    /// The statements, and each array of expressions as tokens.
    fn finish(mut self, matrices: &[&[Vec<Expr>]]) -> (TokenStream, Vec<TokenStream>) {
        let values: Vec<Vec<Vec<_>>> = matrices
            .iter()
            .map(|rows| rows.iter().map(|row| self.scheduler.values(row)).collect())
            .collect();
        let results: Vec<_> = values.iter().flatten().flatten().copied().collect();
        let program = self.scheduler.finish(&results);
        let mut printer = Printer::new(&program, self.symbols, &TokenStream::new());
        printer.split_prepared(&[]);
        let constants = printer.prepare();
        let statements = printer.statements(Tier::State);
        (
            quote!(#constants #statements),
            values.iter().map(|rows| printer.matrix(rows)).collect(),
        )
    }
}

fn lagrangian_jet(
    private: &TokenStream,
    jet: &LagrangianJet,
    symbols: &Symbols,
    arena: &Arena,
) -> TokenStream {
    let LagrangianJet {
        value,
        dq,
        dv,
        dqq,
        dqv,
        dvv,
        dqt,
        dvt,
    } = jet;
    let value = [vec![*value]];
    let vectors = [dq.clone(), dv.clone(), dqt.clone(), dvt.clone()];
    let roots: Vec<Expr> = [&value[..], &vectors[..], &dqq[..], &dqv[..], &dvv[..]]
        .concat()
        .concat();
    let (statements, arrays) =
        Straight::new(arena, symbols, &roots).finish(&[&value, &vectors, dqq, dqv, dvv]);
    let [value, vectors, dqq, dqv, dvv] = arrays.as_slice() else {
        return TokenStream::new();
    };
    quote! {
        #statements
        let [[value]] = #value;
        let [dq, dv, dqt, dvt] = #vectors;
        #private::LagrangianJet { value, dq, dv, dqq: #dqq, dqv: #dqv, dvv: #dvv, dqt, dvt }
    }
}

fn noise_jets(
    private: &TokenStream,
    jets: &[NoiseJet],
    symbols: &Symbols,
    arena: &Arena,
) -> TokenStream {
    let mut roots: Vec<Expr> = Vec::new();
    let mut blocks: Vec<Vec<Vec<Expr>>> = Vec::new();
    for NoiseJet {
        dq,
        dp,
        dqq,
        dqp,
        dpp,
    } in jets
    {
        let vectors = vec![dq.clone(), dp.clone()];
        for block in [&vectors, dqq, dqp, dpp] {
            roots.extend(block.iter().flatten());
            blocks.push(block.clone());
        }
    }
    let views: Vec<&[Vec<Expr>]> = blocks.iter().map(Vec::as_slice).collect();
    let (statements, arrays) = Straight::new(arena, symbols, &roots).finish(&views);
    let jets = arrays.chunks(4).map(|chunk| {
        let (vectors, dqq, dqp, dpp) = (&chunk[0], &chunk[1], &chunk[2], &chunk[3]);
        quote! {{
            let [dq, dp] = #vectors;
            #private::NoiseJet { dq, dp, dqq: #dqq, dqp: #dqp, dpp: #dpp }
        }}
    });
    quote!(#statements [#(#jets),*])
}
