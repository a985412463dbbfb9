//! Paths in smaller steps: sums, replay, agreement of depths, and the law of a bridge. Paths that
//! are entered at a step.

use sve_runtime::noise::{
    DyadicInterval, Halves, NoNoise, Noise, NoiseError, Recorded, Refined, Replayable, ThreePoint,
    Truncated, Wiener,
};

use crate::draw;

const H: f64 = 0.3;

fn refined(seed: u64, depth: u32) -> Refined {
    Wiener::new(seed).refine(depth).unwrap()
}

fn fine_h(depth: u32) -> f64 {
    H / (1_u64 << depth) as f64
}

#[test]
fn fine_steps_sum_to_the_coarse_one() -> Result<(), NoiseError> {
    let (processes, steps) = (6, 20);
    let mut coarse = vec![0.0; processes];
    for depth in [0, 1, 2, 5, 8] {
        let parts = 1 << depth;
        let path = Recorded::record(refined(3, depth), fine_h(depth), processes, steps * parts)?;
        let sums = path.coarsen(parts)?;
        for step in 0..steps {
            Wiener::new(3).increments(step as u64, H, &mut coarse)?;
            for (sum, whole) in sums.get(step).unwrap().iter().zip(&coarse) {
                // each of the sums rounds, at the size of the path
                let tolerance = parts as f64 * f64::EPSILON * H.sqrt();
                assert!(
                    (sum - whole).abs() <= tolerance,
                    "{depth} {step}: {sum} {whole}"
                );
                assert!(depth > 0 || sum == whole);
            }
        }
    }
    Ok(())
}

#[test]
fn a_deeper_refinement_agrees_with_a_shallow_one() -> Result<(), NoiseError> {
    let fine = Recorded::record(refined(4, 7), fine_h(7), 3, 10 << 7)?;
    for depth in 1..7 {
        let shallow = Recorded::record(refined(4, depth), fine_h(depth), 3, 10 << depth)?;
        let sums = fine.coarsen(1 << (7 - depth))?;
        for step in 0..shallow.len() {
            let pairs = sums
                .get(step)
                .unwrap()
                .iter()
                .zip(shallow.get(step).unwrap());
            for (sum, dw) in pairs {
                assert!((sum - dw).abs() < 1e-14, "{depth} {step}: {sum} {dw}");
            }
        }
    }
    Ok(())
}

/// `refine` gives the numbers of repeated `halves`, bit for bit, in any order and for any number of
/// processes.
#[test]
fn steps_are_leaves_of_the_tree() -> Result<(), NoiseError> {
    fn leaves(
        path: &Wiener,
        part: DyadicInterval,
        process: usize,
        whole: f64,
        depth: u32,
        out: &mut Vec<f64>,
    ) {
        if part.level() == depth {
            out.push(whole);
            return;
        }
        let halves = part.halves().unwrap();
        let dw = path.halves(part, process, fine_h(part.level()), whole);
        for (half, dw) in halves.into_iter().zip(dw) {
            leaves(path, half, process, dw, depth, out);
        }
    }
    let path = Wiener::new(5).path(9);
    let depth = 4;
    let processes = 6;
    let expected: Vec<Vec<f64>> = (0..processes)
        .map(|process| {
            let mut out = Vec::new();
            for step in 0..7 {
                let whole = path.increment(step, process, H);
                leaves(
                    &path,
                    DyadicInterval::whole(step),
                    process,
                    whole,
                    depth,
                    &mut out,
                );
            }
            out
        })
        .collect();
    let mut fine = path.refine(depth)?;
    let mut dw = [0.0; 6];
    // in order, then scattered, some with fewer processes: 112 and 45 have no common factor
    let order = (0..112).chain((0..1120).map(|k| k * 45 % 112));
    for (k, step) in order.enumerate() {
        let asked = if k % 5 == 3 { 1 + k % 6 } else { 6 };
        fine.increments(step, fine_h(depth), &mut dw[..asked])?;
        for process in 0..asked {
            assert_eq!(
                dw[process], expected[process][step as usize],
                "{step} {process}"
            );
        }
    }
    // another step size is not mixed up with the last
    fine.increments(3, 4.0 * fine_h(depth), &mut dw)?;
    assert!((dw[0] - 2.0 * expected[0][3]).abs() < 1e-15);
    fine.increments(3, fine_h(depth), &mut dw)?;
    assert_eq!(dw[0], expected[0][3]);
    Ok(())
}

#[test]
fn the_ends_of_depth_and_of_time() -> Result<(), NoiseError> {
    assert_eq!(
        Wiener::new(1).refine(64).unwrap_err(),
        NoiseError::Depth { depth: 64 }
    );
    let mut dw = [f64::NAN; 2];
    let mut deepest = Wiener::new(1).refine(63)?;
    for step in [0, 1, u64::MAX, u64::MAX - 1, 1 << 63] {
        deepest.increments(step, 1e-15, &mut dw)?;
        assert!(
            dw.iter().all(|dw| dw.is_finite() && dw.abs() < 1e-6),
            "{dw:?}"
        );
    }
    let too_long = deepest.increments(0, 1e300, &mut dw).unwrap_err();
    assert!(matches!(too_long, NoiseError::InvalidStep { h } if h.is_infinite()));
    let mut part = DyadicInterval::whole(u64::MAX);
    for level in 0..63 {
        assert_eq!(part.level(), level);
        part = part.halves().unwrap()[1];
    }
    assert_eq!(part.index(), (1 << 63) - 1);
    assert_eq!(part.halves(), None);
    let mut none = [];
    refined(1, 3).increments(5, 0.1, &mut none)?;
    Ok(())
}

/// Standardised increments of fine steps are independent standard normals: variances, the
/// correlations of neighbours, of squares, across the borders of parts, and of a part with its
/// whole given the other half.
#[test]
fn fine_increments_are_independent() -> Result<(), NoiseError> {
    let (depth, coarse) = (5, 4_000);
    let parts = 1 << depth;
    let path = Recorded::record(refined(6, depth), fine_h(depth), 2, coarse * parts)?;
    let scale = fine_h(depth).sqrt();
    let z: Vec<[f64; 2]> = (0..path.len())
        .map(|step| {
            let dw = path.get(step).unwrap();
            [dw[0] / scale, dw[1] / scale]
        })
        .collect();
    let n = z.len() as f64;
    for process in 0..2 {
        let moment = |k| z.iter().map(|z| z[process].powi(k)).sum::<f64>() / n;
        for (k, exact, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)] {
            let error = (moment(k) - exact) / f64::sqrt(variance / n);
            assert!(error.abs() < 5.0, "process {process}, moment {k}: {error}");
        }
    }
    let assert_none =
        |of: &str, a: &dyn Fn(usize) -> f64, b: &dyn Fn(usize) -> f64, steps: &[usize]| {
            let (mut values, mut squares) = (0.0, 0.0);
            for &step in steps {
                let (a, b) = (a(step), b(step));
                values += a * b;
                squares += (a * a - 1.0) * (b * b - 1.0) / 2.0;
            }
            for sum in [values, squares] {
                let error = sum / (steps.len() as f64).sqrt();
                assert!(error.abs() < 5.0, "{of}: {error}");
            }
        };
    let all: Vec<usize> = (0..z.len() - parts).collect();
    for lag in [1, 2, 3, 4, 8, 16, 31, 32] {
        assert_none(
            &format!("lag {lag}"),
            &|k| z[k][0],
            &|k| z[k + lag][0],
            &all,
        );
        assert_none(
            &format!("processes, lag {lag}"),
            &|k| z[k][0],
            &|k| z[k + lag][1],
            &all,
        );
    }
    assert_none("processes", &|k| z[k][0], &|k| z[k][1], &all);
    // each place within a step on its own: siblings, and neighbours that part at each level
    for place in 0..parts - 1 {
        let steps: Vec<usize> = (0..coarse).map(|step| step * parts + place).collect();
        assert_none(
            &format!("place {place}"),
            &|k| z[k][0],
            &|k| z[k + 1][0],
            &steps,
        );
    }
    Ok(())
}

/// Given the whole, the left half has mean ΔW/2 and variance h/4, whatever ΔW is, and is no
/// function of it.
#[test]
fn halves_have_the_conditional_law() {
    let n: u64 = 100_000;
    let path = Wiener::new(8);
    let (mut mean, mut square, mut with_whole) = (0.0, 0.0, 0.0);
    for step in 0..n {
        let whole = path.increment(step, 0, H);
        let [left, right] = path.halves(DyadicInterval::whole(step), 0, H, whole);
        assert!((left + right - whole).abs() <= 2.0 * f64::EPSILON * (left.abs() + right.abs()));
        let z = (left - 0.5 * whole) / (0.5 * H.sqrt());
        mean += z;
        square += z * z;
        with_whole += z * whole / H.sqrt();
    }
    let root = (n as f64).sqrt();
    assert!((mean / root).abs() < 5.0, "{mean}");
    assert!(
        ((square - n as f64) / (2.0_f64.sqrt() * root)).abs() < 5.0,
        "{square}"
    );
    assert!((with_whole / root).abs() < 5.0, "{with_whole}");
    // the same node with another whole: the same deviation
    let part = DyadicInterval::whole(3);
    let [a, _] = path.halves(part, 0, H, 0.0);
    let [b, _] = path.halves(part, 0, H, 1.0);
    assert!((b - a - 0.5).abs() < 1e-15);
}

/// Every source whose increments are a function of the step, entered at steps that share a block of
/// the generator and that do not.
#[test]
fn a_path_is_entered_at_a_step() -> Result<(), NoiseError> {
    fn check<W: Replayable + Clone>(source: &W, h: f64, steps: u64) -> Result<(), NoiseError> {
        for first in [0, 1, 3, 4, 17, 40] {
            let (mut whole, mut entered) = (source.clone(), source.clone().from_step(first));
            for step in (0..steps - first).rev().chain(0..steps - first) {
                let expected: [f64; 3] = draw(&mut whole, first + step, h)?;
                assert_eq!(draw(&mut entered, step, h)?, expected, "{first} + {step}");
            }
            // entered twice
            let mut twice = source.clone().from_step(first).from_step(2);
            assert_eq!(
                draw::<3>(&mut twice, 5, h)?,
                draw::<3>(&mut whole, first + 7, h)?
            );
        }
        Ok(())
    }
    let wiener = Wiener::new(11).path(5);
    check(&wiener, 0.1, 50)?;
    check(&wiener.refine(3)?, 0.1, 50)?;
    check(&ThreePoint::new(11).path(5), 0.1, 50)?;
    check(&Truncated::new(wiener).deviations(1.0)?, 0.1, 50)?;
    check(&NoNoise, 0.1, 50)?;
    let recorded = Recorded::record(wiener, 0.1, 3, 50)?;
    check(&recorded, 0.1, 50)?;
    check(&&recorded, 0.1, 50)?;
    assert_eq!(
        draw::<3>(&mut recorded.clone().from_step(48), 2, 0.1),
        Err(NoiseError::Exhausted {
            step: 50,
            recorded: 50
        })
    );
    // the halves of a step are those of the step of the path
    let part = DyadicInterval::whole(2);
    let ([mut left, mut right], [mut other_left, mut other_right]) = ([[0.0; 1]; 2], [[0.0; 1]; 2]);
    let entered = wiener.from_step(7);
    entered.halves_of(part, 0.1, &[0.3], &mut left, &mut right);
    wiener.halves_of(
        DyadicInterval::whole(9),
        0.1,
        &[0.3],
        &mut other_left,
        &mut other_right,
    );
    assert_eq!((left, right), (other_left, other_right));
    // beyond the last step there is none
    let mut last = wiener.from_step(u64::MAX);
    draw::<1>(&mut last, 0, 0.1)?;
    let (step, first) = (1, u64::MAX);
    assert_eq!(
        draw::<1>(&mut last, 1, 0.1),
        Err(NoiseError::StepNumber { step, first })
    );
    Ok(())
}
