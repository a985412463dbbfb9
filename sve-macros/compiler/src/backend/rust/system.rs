//! `impl System`: the derivatives of L and of the noises.

use proc_macro2::{Literal, Span, TokenStream};
use quote::{quote, quote_spanned};

use super::configuration::{Received, received, written};
use super::energy::energy_lanes;
use super::euler::{euler_increment, no_euler};
use super::identity::identity;
use super::straight::{Straight, rows};
use super::{Context, attributes, documented, private};
use crate::algebra::{Arena, Expr};
use crate::explain::SystemTexts;
use crate::model::{Model, Symbols};
use crate::system::degeneracy::{Degeneracy, Role};
use crate::system::functions::Functions;
use crate::system::mechanics::{ConstraintJet, ForceJet, LagrangianJet, Mechanics, NoiseJet};

pub(crate) fn system(context: &Context<'_>, functions: &Functions) -> TokenStream {
    let Context {
        settings,
        block,
        model,
        about,
        arena,
        ..
    } = *context;
    let (private, attributes) = (private(block), attributes());
    let self_ty = &block.item.self_ty;
    let n = Literal::usize_unsuffixed(model.dof());
    let m = Literal::usize_unsuffixed(model.noises.len());
    let Mechanics {
        lagrangian,
        noises,
        force,
        affine_momentum,
        ..
    } = &functions.mechanics;
    let markers = markers(context, &functions.mechanics, &private);
    let [doc, jet_doc, noise_doc] = documentation(about, !noises.is_empty());
    let configuration = written(block, &private).map(|ty| quote!(, #ty));
    let received = received(block, model, &private);
    let Received {
        flat,
        open,
        open_state: _,
        reopen_state: _,
    } = &received;
    let lagrangian_body = lagrangian_jet(&private, lagrangian, &model.symbols, arena);
    let noise_body = noise_jets(&private, noises, &model.symbols, arena);
    let force = force
        .as_ref()
        .map(|jet| force_jet(&private, jet, &received, &model.symbols, arena));
    let energy = functions.energy.as_ref();
    let energy = energy.and_then(|energy| energy_lanes(energy, model, &private, arena));
    let euler = functions.euler.as_ref();
    let euler = euler
        .and_then(|euler| euler_increment(euler, settings.lanes, model, &private, arena))
        .unwrap_or_else(no_euler);
    let constraint_jets = constraint_jets(&private, model, functions, arena);
    let identity = identity(model, arena, &private);
    let roles = context.degeneracy.map(|d| roles(d, &private));
    let parameters = model.symbols.parameters().map(|s| model.symbols.source(s));
    let (coordinates, momenta) = (&model.names.configuration, &model.names.momenta);
    // the user's functions are not called by what is derived from them, and yet are not dead
    let parts = [
        &block.noises,
        &block.forces,
        &block.symmetries,
        &block.constraints,
    ];
    let functions = parts.into_iter().flatten().chain([&block.lagrangian]);
    let functions = functions.map(|part| &part.name);
    let constants = model
        .constants
        .iter()
        .map(|(path, value)| constant_check(path, *value));
    quote! {
        #attributes
        const _: () = { #(let _ = <#self_ty>::#functions;)* };
        #(#constants)*
        #doc
        #attributes
        impl #private::System for #self_ty {
            type Dims = #private::Dims<#n, #m #configuration>;
            type Itself = Self;
            const AFFINE_MOMENTUM: bool = #affine_momentum;
            #roles
            const PARAMETERS: &'static [&'static str] = &[#(#parameters),*];
            const COORDINATES: &'static [&'static str] = &[#(#coordinates),*];
            const MOMENTA: &'static [&'static str] = &[#(#momenta),*];
            #identity
            #[inline]
            fn itself(&self) -> &Self { self }
            #jet_doc
            #[inline]
            fn lagrangian_jet(&self, time: f64, q: &#flat, v: &[f64; #n]) -> #private::LagrangianJet<#n> {
                #open
                #lagrangian_body
            }
            #noise_doc
            #[inline]
            fn noise_jets(&self, time: f64, q: &#flat, p: &[f64; #n]) -> [#private::NoiseJet<#n>; #m] {
                #open
                #noise_body
            }
            #force
            #constraint_jets
            #energy
            #euler
        }
        #markers
    }
}

/// Which splittings the structure of L allows.
fn markers(
    context: &Context<'_>,
    mechanics: &Mechanics,
    private: &TokenStream,
) -> Option<TokenStream> {
    let self_ty = &context.block.item.self_ty;
    if !mechanics.is_separable || context.degeneracy.is_some() {
        return None;
    }
    // conditions of order for the splitting of a quadratic kinetic energy do not hold for steps that constraints couple
    let is_quadratic = mechanics.affine_momentum && mechanics.constraints.is_empty();
    let quadratic =
        is_quadratic.then(|| quote!(impl #private::QuadraticKineticEnergy for #self_ty {}));
    Some(quote!(impl #private::Separable for #self_ty {} #quadratic))
}

/// `ROLES`, how the velocity of each coordinate occurs in a degenerate L.
fn roles(degeneracy: &Degeneracy, private: &TokenStream) -> TokenStream {
    let roles = degeneracy.roles.iter().map(|role| match role {
        Role::Massive => quote!(#private::CoordinateRole::Massive),
        Role::Massless => quote!(#private::CoordinateRole::Massless),
        Role::Algebraic => quote!(#private::CoordinateRole::Algebraic),
    });
    quote!(const ROLES: &'static [#private::CoordinateRole] = &[#(#roles),*];)
}

/// Of the implementation, and of its functions for L and the noises.
fn documentation(about: &SystemTexts, is_noisy: bool) -> [TokenStream; 3] {
    let of_motion = if is_noisy {
        "Equations of motion (Stratonovich):"
    } else {
        "Equations of motion:"
    };
    let of_lagrangian = "L with its first and second derivatives.";
    let of_noises = "The noise Hamiltonians, −γ and H₁, with their first and second derivatives.";
    [
        documented(&[("The system:", &about.system()), (of_motion, &about.motion)]),
        documented(&[(of_lagrangian, &about.lagrangian)]),
        documented(&[(of_noises, &about.noises)]),
    ]
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
    let n = dq.len();
    let matrices: [(&[Vec<Expr>], Vec<String>); 5] = [
        (&value, vec!["lagrangian".to_owned()]),
        (
            &vectors,
            ["dq", "dv", "dqt", "dvt"].map(ToOwned::to_owned).to_vec(),
        ),
        (dqq, rows("dqq", n)),
        (dqv, rows("dqv", n)),
        (dvv, rows("dvv", n)),
    ];
    let (statements, arrays) = Straight::new(arena, symbols, &roots).finish(private, &matrices);
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

/// `FORCED` and `force_jet`.
fn force_jet(
    private: &TokenStream,
    jet: &ForceJet,
    received: &Received,
    symbols: &Symbols,
    arena: &Arena,
) -> TokenStream {
    let ForceJet { value, dq, dv, dt } = jet;
    let vectors = [value.clone(), dt.clone()];
    let roots: Vec<Expr> = [&vectors[..], &dq[..], &dv[..]].concat().concat();
    let size = value.len();
    let matrices: [(&[Vec<Expr>], Vec<String>); 3] = [
        (&vectors, ["force", "dt"].map(ToOwned::to_owned).to_vec()),
        (dq, rows("dq", size)),
        (dv, rows("dv", size)),
    ];
    let (statements, arrays) = Straight::new(arena, symbols, &roots).finish(private, &matrices);
    let [vectors, dq, dv] = arrays.as_slice() else {
        return TokenStream::new();
    };
    let n = Literal::usize_unsuffixed(size);
    let Received {
        flat,
        open,
        open_state: _,
        reopen_state: _,
    } = received;
    quote! {
        const FORCED: bool = true;
        #[inline]
        fn force_jet(&self, time: f64, q: &#flat, v: &[f64; #n]) -> #private::ForceJet<#n> {
            #open
            #statements
            let [value, dt] = #vectors;
            #private::ForceJet { value, dq: #dq, dv: #dv, dt }
        }
    }
}

/// `CONSTRAINTS`, `constraint_jets` and `constraint_curvatures`; nothing where there are none.
fn constraint_jets(
    private: &TokenStream,
    model: &Model,
    functions: &Functions,
    arena: &Arena,
) -> Option<TokenStream> {
    let jets = &functions.mechanics.constraints;
    if jets.is_empty() {
        return None;
    }
    let curvatures = [functions.constraint_curvatures.clone()];
    let straight = Straight::new(arena, &model.symbols, &curvatures[0]);
    let (of_curvatures, array) =
        straight.finish(private, &[(&curvatures, vec!["curvature".to_owned()])]);
    let row = |of: fn(&ConstraintJet) -> Expr| jets.iter().map(of).collect::<Vec<Expr>>();
    let vectors = [row(|j| j.value), row(|j| j.magnitude), row(|j| j.dt)];
    let slopes: Vec<Vec<Expr>> = jets.iter().map(|jet| jet.dq.clone()).collect();
    let roots: Vec<Expr> = [&vectors[..], &slopes[..]].concat().concat();
    let parts: [(&[Vec<Expr>], Vec<String>); 2] = [
        (
            &vectors,
            ["value", "magnitude", "dt"].map(ToOwned::to_owned).to_vec(),
        ),
        (&slopes, rows("dq", jets.len())),
    ];
    let (statements, arrays) = Straight::new(arena, &model.symbols, &roots).finish(private, &parts);
    let [vectors, slopes] = arrays.as_slice() else {
        return None;
    };
    let names = model.constraints.iter().map(|constraint| &constraint.name);
    let n = Literal::usize_unsuffixed(model.dof());
    let count = Literal::usize_unsuffixed(jets.len());
    Some(quote! {
        const CONSTRAINTS: &'static [&'static str] = &[#(#names),*];
        fn constraint_jets(
            &self,
            time: f64,
            q: &[f64; #n],
            visit: &mut dyn ::core::ops::FnMut(#private::ConstraintJet<#n>),
        ) {
            #statements
            let [values, magnitudes, dt] = #vectors;
            let dq = #slopes;
            for k in 0..#count {
                visit(#private::ConstraintJet {
                    value: values[k],
                    magnitude: magnitudes[k],
                    dt: dt[k],
                    dq: dq[k],
                });
            }
        }
        fn constraint_curvatures(
            &self,
            time: f64,
            q: &[f64; #n],
            v: &[f64; #n],
            visit: &mut dyn ::core::ops::FnMut(f64),
        ) {
            #of_curvatures
            let [curvatures] = #(#array)*;
            for curvature in curvatures {
                visit(curvature);
            }
        }
    })
}

fn noise_jets(
    private: &TokenStream,
    jets: &[NoiseJet],
    symbols: &Symbols,
    arena: &Arena,
) -> TokenStream {
    let mut roots: Vec<Expr> = Vec::new();
    let mut blocks: Vec<(Vec<Vec<Expr>>, Vec<String>)> = Vec::new();
    for (at, jet) in jets.iter().enumerate() {
        let NoiseJet {
            dq,
            dp,
            dqq,
            dqp,
            dpp,
        } = jet;
        let name = |part: &str| format!("noise_{at}_{part}");
        let matrix = |part: &str| rows(&name(part), dq.len());
        blocks.push((vec![dq.clone(), dp.clone()], vec![name("dq"), name("dp")]));
        blocks.push((dqq.clone(), matrix("dqq")));
        blocks.push((dqp.clone(), matrix("dqp")));
        blocks.push((dpp.clone(), matrix("dpp")));
    }
    for (block, _) in &blocks {
        roots.extend(block.iter().flatten());
    }
    let views = blocks
        .iter()
        .map(|(block, names)| (block.as_slice(), names.clone()));
    let views: Vec<(&[Vec<Expr>], Vec<String>)> = views.collect();
    let (statements, arrays) = Straight::new(arena, symbols, &roots).finish(private, &views);
    let jets = arrays.chunks(4).map(|chunk| {
        let (vectors, dqq, dqp, dpp) = (&chunk[0], &chunk[1], &chunk[2], &chunk[3]);
        quote! {{
            let [dq, dp] = #vectors;
            #private::NoiseJet { dq, dp, dqq: #dqq, dqp: #dqp, dpp: #dpp }
        }}
    });
    quote!(#statements [#(#jets),*])
}

/// `impl WithPotential`, of a context whose last noise is the potential of the option `weak2`.
pub(super) fn with_potential(context: &Context<'_>, private: &TokenStream) -> TokenStream {
    let (model, noises, attributes) = (context.model, &context.mechanics.noises, attributes());
    let self_ty = &context.block.item.self_ty;
    let [n, m] = [model.dof(), noises.len()].map(Literal::usize_unsuffixed);
    let jets = noise_jets(private, noises, &model.symbols, context.arena);
    quote! {
        #attributes
        impl #private::gauss::WithPotential<#n, #m> for #self_ty {
            fn noise_jets(&self, time: f64, q: &[f64; #n], p: &[f64; #n]) -> [#private::NoiseJet<#n>; #m] {
                #jets
            }
        }
    }
}

/// A check, when the user's program is compiled, that a path leads to the constant of the standard library that it is read as.
fn constant_check(path: &TokenStream, value: f64) -> TokenStream {
    let at = path.clone().into_iter().next();
    let at = at.map_or_else(Span::call_site, |token| token.span());
    let written = path.to_string().replace(' ', "");
    let name = written.rsplit("::").next().unwrap_or_default();
    let message = format!(
        "`{written}` is read as `std::f64::consts::{name}`, and it has another value here: write the full path of the constant, as in `crate::{written}`"
    );
    let bits = Literal::u64_suffixed(value.to_bits());
    quote_spanned!(at=>
        const _: () = {
            let value: f64 = #path;
            ::core::assert!(value.to_bits() == #bits, #message);
        };
    )
}
