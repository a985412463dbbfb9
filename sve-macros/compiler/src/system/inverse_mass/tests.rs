//! Solutions of M w = b: the residuals vanish, for blocks of all sizes.

use super::{NoFormula, solve};
use crate::algebra::{Arena, Expr, Symbol};

/// Returns a uniform number in [−1, 1), by the finaliser of splitmix64.
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Returns a symmetric matrix with blocks of these sizes, and a right-hand side. The coordinates of
/// the blocks are mixed; entries are symbols or numbers.
fn system(
    sizes: &[usize],
    is_symbol: bool,
    state: &mut u64,
    arena: &mut Arena,
) -> (Vec<Vec<Expr>>, Vec<Expr>) {
    let n: usize = sizes.iter().sum();
    let blocks: Vec<usize> = sizes
        .iter()
        .enumerate()
        .flat_map(|(k, &size)| vec![k; size])
        .collect();
    // 7 is coprime to all n in the test
    let block = |i: usize| blocks[i * 7 % n];
    let zero = arena.constant(0.0);
    let mut next = 0;
    let mut entry = |arena: &mut Arena| {
        next += 1;
        if is_symbol {
            arena.symbol(Symbol(next))
        } else {
            arena.constant(uniform(state))
        }
    };
    let mut matrix = vec![vec![zero; n]; n];
    for i in 0..n {
        for j in 0..=i {
            if block(i) == block(j) {
                let value = entry(arena);
                matrix[i][j] = value;
                matrix[j][i] = value;
            }
        }
    }
    let b = (0..n).map(|_| entry(arena)).collect();
    (matrix, b)
}

#[test]
fn residuals_vanish() {
    let mut state = 3;
    for sizes in [
        &[1][..],
        &[2],
        &[3],
        &[1, 2, 3],
        &[4],
        &[5, 1],
        &[3, 3, 2, 1, 2],
    ] {
        for is_symbol in [false, true] {
            let mut arena = Arena::new();
            let (matrix, b) = system(sizes, is_symbol, &mut state, &mut arena);
            let w = solve(&matrix, &b, &[], &mut arena).expect("a solution");
            for (row, &b) in matrix.iter().zip(&b) {
                let mut terms = vec![(-1.0, b)];
                for (&m, &w) in row.iter().zip(&w) {
                    terms.push((1.0, arena.mul(m, w)));
                }
                let residual = arena.sum(0.0, &terms);
                match arena.constant_value(residual) {
                    Some(value) => assert!(value.abs() < 1e-12, "{sizes:?}: {value:e}"),
                    None => assert!(arena.is_zero(residual), "{sizes:?}"),
                }
            }
        }
    }
}

#[test]
fn large_blocks_must_not_depend_on_the_configuration() {
    let q = Symbol(0);
    for (size, refused) in [(3, None), (4, Some(NoFormula::TooManyCoupled(4)))] {
        let mut arena = Arena::new();
        let (mut matrix, mut b) = system(&[size], false, &mut 5, &mut arena);
        matrix[0][0] = arena.symbol(q);
        assert_eq!(solve(&matrix, &b, &[q], &mut arena).err(), refused);
        // a coordinate without force is not solved for
        b.fill(arena.constant(0.0));
        assert_eq!(solve(&matrix, &b, &[q], &mut arena), Ok(b.clone()));
    }
}
