//! Solutions of M w = b: the residuals vanish, for blocks of all sizes.

use super::{NoFormula, solve};
use crate::algebra::tests::recipe::Random;
use crate::algebra::{Arena, Expr, Symbol};

/// Returns a symmetric matrix with blocks of these sizes, and a right-hand side. The coordinates of
/// the blocks are mixed; entries are symbols or numbers.
fn system(
    sizes: &[usize],
    is_symbol: bool,
    random: &mut Random,
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
            arena.constant(random.uniform(-1.0, 1.0))
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
    let random = &mut Random(3);
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
            let (matrix, b) = system(sizes, is_symbol, random, &mut arena);
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
        let (mut matrix, mut b) = system(&[size], false, &mut Random(5), &mut arena);
        matrix[0][0] = arena.symbol(q);
        assert_eq!(solve(&matrix, &b, &[q], &mut arena).err(), refused);
        // a coordinate without force is not solved for
        b.fill(arena.constant(0.0));
        assert_eq!(solve(&matrix, &b, &[q], &mut arena), Ok(b.clone()));
    }
}
