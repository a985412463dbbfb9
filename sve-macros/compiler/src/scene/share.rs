//! Forms of derivatives that share their parts: derivatives of one term differ in few factors, and
//! contain the same differences.

use crate::algebra::{Arena, Bits, Expr, Node};

/// `coefficient Π base^exponent`.
type Factors = (f64, Vec<(Expr, i32)>);

/// Takes out the differences and the factors that derivatives of a term share.
pub(super) fn share(mut slopes: Vec<&mut Expr>, arena: &mut Arena) {
    slopes.retain(|slope| arena.constant_value(**slope) != Some(0.0));
    for slope in &mut slopes {
        **slope = with_whole_differences(**slope, arena);
    }
    let factors: Vec<Factors> = slopes.iter().map(|slope| factors(**slope, arena)).collect();
    let common = common(&factors);
    // a single factor is shared as it is
    if factors.len() < 2 || common.len() < 2 {
        return;
    }
    let size = factors[0].0.abs();
    let is_common = factors.iter().all(|of| of.0.abs() == size);
    let size = if is_common { size } else { 1.0 };
    let product = arena.product(&common);
    let product = arena.scale(size, product);
    let product = arena.opaque(product);
    for (slope, (c, own)) in slopes.into_iter().zip(factors) {
        let rest = without(own, &common, arena);
        let rest = arena.scale(c / size, rest);
        *slope = arena.mul(product, rest);
    }
}

/// Writes terms of a sum that are a multiple of a sum within it as this multiple:
/// `−x + y − (x − y)³` is `−(x − y) − (x − y)³`.
fn with_whole_differences(expr: Expr, arena: &mut Arena) -> Expr {
    let Node::Sum(constant, terms) = arena.node(expr).clone() else {
        return expr;
    };
    let is_part = |part: &[(Expr, Bits)]| {
        let coefficient = |e: Expr| terms.iter().find(|t| t.0 == e).map(|t| t.1.get());
        let ratio = coefficient(part[0].0)? / part[0].1.get();
        let is_multiple = part
            .iter()
            .all(|&(e, c)| coefficient(e) == Some(ratio * c.get()));
        (part.len() < terms.len() && is_multiple).then_some(ratio)
    };
    let inner = arena.reachable(&[expr], |_| true).into_iter();
    let found = inner.filter_map(|e| match arena.node(e) {
        Node::Sum(zero, part) if zero.get() == 0.0 => {
            Some((part.len(), e, is_part(part)?, part.clone()))
        }
        _ => None,
    });
    let Some((_, whole, ratio, part)) = found.max_by_key(|found| found.0) else {
        return expr;
    };
    let whole = arena.opaque(whole);
    let others = terms
        .iter()
        .filter(|t| part.iter().all(|other| other.0 != t.0));
    let mut list: Vec<(f64, Expr)> = others.map(|t| (t.1.get(), t.0)).collect();
    list.push((ratio, whole));
    arena.sum(constant.get(), &list)
}

/// Returns the factors of an expression. Those that all terms of a sum have are taken out of it.
fn factors(expr: Expr, arena: &mut Arena) -> Factors {
    match arena.node(expr).clone() {
        Node::Product(list) => {
            let (mut size, mut all) = (1.0, Vec::new());
            for (base, k) in list {
                if k == 1 && matches!(arena.node(base), Node::Sum(..)) {
                    let (c, inner) = factors(base, arena);
                    size *= c;
                    all.extend(inner);
                } else {
                    all.push((base, k));
                }
            }
            (size, all)
        }
        Node::Sum(constant, terms) if constant.get() == 0.0 && terms.len() == 1 => {
            let (c, all) = factors(terms[0].0, arena);
            (c * terms[0].1.get(), all)
        }
        Node::Sum(constant, terms) if constant.get() == 0.0 => {
            let of_terms: Vec<Factors> = terms
                .iter()
                .map(|&(term, c)| match arena.node(term) {
                    Node::Product(factors) => (c.get(), factors.clone()),
                    _ => (c.get(), vec![(term, 1)]),
                })
                .collect();
            let mut all = common(&of_terms);
            let rest: Vec<(f64, Expr)> = of_terms
                .into_iter()
                .map(|(c, own)| (c, without(own, &all, arena)))
                .collect();
            all.push((arena.sum(0.0, &rest), 1));
            (1.0, all)
        }
        _ => (1.0, vec![(expr, 1)]),
    }
}

/// Returns the factors that all products have.
fn common(products: &[Factors]) -> Vec<(Expr, i32)> {
    let Some(((_, first), others)) = products.split_first() else {
        return Vec::new();
    };
    let exponent = |of: &Factors, base: Expr| {
        let factor = of.1.iter().find(|factor| factor.0 == base);
        factor.map_or(0, |factor| factor.1)
    };
    let least = |&(base, k): &(Expr, i32)| {
        let least = others.iter().fold(k, |least, of| {
            let k = exponent(of, base);
            if least.signum() == k.signum() {
                least.signum() * least.abs().min(k.abs())
            } else {
                0
            }
        });
        (least != 0).then_some((base, least))
    };
    first.iter().filter_map(least).collect()
}

/// Returns a product without some of its factors.
fn without(mut own: Vec<(Expr, i32)>, taken: &[(Expr, i32)], arena: &mut Arena) -> Expr {
    own.extend(taken.iter().map(|&(base, k)| (base, -k)));
    arena.product(&own)
}
