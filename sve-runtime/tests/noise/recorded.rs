//! Recorded paths: what they keep, what coarsening makes of them, and what they refuse.

use sve_runtime::noise::{NoNoise, NoiseError, Recorded, Wiener};

use crate::draw;

#[test]
fn recording_keeps_the_path() -> Result<(), NoiseError> {
    let mut path = Wiener::new(3);
    let recorded = Recorded::record(&mut path, 0.1, 2, 50)?;
    assert_eq!((recorded.len(), recorded.processes()), (50, 2));
    assert!(recorded.h() == 0.1 && !recorded.is_empty());
    for step in (0..50).rev() {
        let dw: [f64; 2] = draw(&mut &recorded, step, 0.1)?;
        assert_eq!(dw, draw(&mut path, step, 0.1)?);
        assert_eq!(recorded.get(step as usize), Some(&dw[..]));
    }
    let arrays = (0..50).map(|step| draw(&mut path, step, 0.1));
    let arrays: Vec<[f64; 2]> = arrays.collect::<Result<_, _>>()?;
    assert_eq!(Recorded::new(0.1, arrays)?, recorded);
    assert_eq!(recorded.get(50), None);
    assert_eq!(recorded.get(usize::MAX), None);
    Ok(())
}

#[test]
fn a_coarse_path_is_the_sum_of_the_fine_one() -> Result<(), NoiseError> {
    let h = 0.1 / 3.0;
    let fine = Recorded::record(Wiener::new(3).path(9), h, 2, 60)?;
    for k in [1, 2, 3, 5, 60] {
        let coarse = fine.coarsen(k)?;
        assert_eq!((coarse.len(), coarse.processes()), (60 / k, 2));
        assert_eq!(coarse.h(), k as f64 * h);
        for step in 0..coarse.len() {
            let mut sum = [0.0; 2];
            for dw in (step * k..(step + 1) * k).filter_map(|step| fine.get(step)) {
                sum = [sum[0] + dw[0], sum[1] + dw[1]];
            }
            assert_eq!(coarse.get(step), Some(&sum[..]));
        }
    }
    assert_eq!(fine.coarsen(1)?, fine);
    // 3 h and the 0.1 that was meant may differ by a rounding
    draw::<2>(&mut fine.coarsen(3)?, 0, 0.1)?;
    // by another way to the same path, up to the order of the sums
    let [once, twice] = [fine.coarsen(6)?, fine.coarsen(2)?.coarsen(3)?];
    for step in 0..10 {
        for (a, b) in once.get(step).into_iter().zip(twice.get(step)) {
            assert!((a[0] - b[0]).abs() < 1e-15 && (a[1] - b[1]).abs() < 1e-15);
        }
    }
    Ok(())
}

#[test]
fn recorded_paths_say_what_does_not_fit() -> Result<(), NoiseError> {
    let mut path = Recorded::record(Wiener::new(3), 0.1, 2, 10)?;
    for step in [10, 11, u64::MAX] {
        let recorded = 10;
        assert_eq!(
            draw::<2>(&mut path, step, 0.1),
            Err(NoiseError::Exhausted { step, recorded })
        );
    }
    let (asked, recorded) = (1, 2);
    assert_eq!(
        draw::<1>(&mut path, 0, 0.1),
        Err(NoiseError::Processes { asked, recorded })
    );
    for h in [0.2, 0.1 * (1.0 + 1e-14), 0.1 * (1.0 - 1e-14), 0.0] {
        let recorded = 0.1;
        assert_eq!(
            draw::<2>(&mut path, 0, h),
            Err(NoiseError::StepSize { h, recorded })
        );
    }
    draw::<2>(&mut path, 0, 0.1 * (1.0 + f64::EPSILON))?;
    for factor in [0, 3, 20] {
        let recorded = 10;
        assert_eq!(
            path.coarsen(factor as usize),
            Err(NoiseError::Coarsen { recorded, factor })
        );
    }
    Ok(())
}

#[test]
fn recordings_are_finite() -> Result<(), NoiseError> {
    assert_eq!(
        Recorded::new(0.1, [[0.1, 0.2], [0.3, f64::INFINITY]]),
        Err(NoiseError::NonFinite {
            step: 1,
            process: 1,
            value: f64::INFINITY
        })
    );
    assert!(matches!(
        Recorded::new(0.1, [[0.1], [0.1], [f64::NAN]]),
        Err(NoiseError::NonFinite { step: 2, process: 0, value }) if value.is_nan()
    ));
    // sums and step sizes can overflow as well
    let huge = Recorded::new(0.1, [[f64::MAX], [f64::MAX]])?;
    assert!(matches!(huge.coarsen(2), Err(NoiseError::NonFinite { .. })));
    let long = Recorded::new(f64::MAX, [[1.0], [1.0]])?;
    assert!(matches!(
        long.coarsen(2),
        Err(NoiseError::InvalidStep { .. })
    ));
    for (length, processes) in [(usize::MAX, 2), (usize::MAX / 8, 1)] {
        let steps = length as u64;
        assert_eq!(
            Recorded::record(NoNoise, 0.1, processes, length),
            Err(NoiseError::TooLong { steps, processes })
        );
    }
    Ok(())
}

#[test]
fn paths_without_processes_or_steps() -> Result<(), NoiseError> {
    let mut silent = Recorded::new(0.1, [[], [], []])?;
    assert_eq!((silent.len(), silent.processes()), (3, 0));
    draw::<0>(&mut silent, 2, 0.1)?;
    assert!(matches!(
        draw::<0>(&mut silent, 3, 0.1),
        Err(NoiseError::Exhausted { .. })
    ));
    assert_eq!(silent.coarsen(3)?.len(), 1);
    let empty = Recorded::new(0.1, Vec::<[f64; 2]>::new())?;
    assert!(empty.is_empty() && empty.coarsen(2)?.is_empty());
    assert!(matches!(empty.coarsen(0), Err(NoiseError::Coarsen { .. })));
    Ok(())
}
