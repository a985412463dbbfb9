//! The noise sources by what they promise: replay, bounds and errors. Recorded paths are in
//! `recorded`, refined ones in `refined`, the distribution in `distribution`.

use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};
use sve_runtime::noise::{
    DyadicInterval, FromRng, NoNoise, Noise, NoiseError, Recorded, Replayable, ThreePoint,
    Truncated, Wiener,
};

use crate::draw;

#[test]
fn any_order_gives_the_same_bits() -> Result<(), NoiseError> {
    let h = 0.037;
    let mut path = Wiener::new(7).path(3);
    let sequence: Vec<[f64; 3]> = (0..1000)
        .map(|step| draw(&mut path, step, h))
        .collect::<Result<_, _>>()?;
    // 389 and 1000 have no common factor: every step once, in a scattered order
    for step in (0..1000).map(|k| k * 389 % 1000) {
        let expected = sequence[step as usize];
        assert_eq!(draw(&mut path, step, h)?, expected);
        for process in 0..3 {
            assert_eq!(path.increment(step, process, h), expected[process]);
        }
    }
    Ok(())
}

#[test]
fn three_points_are_replayed_too() -> Result<(), NoiseError> {
    let h = 0.037;
    let mut path = ThreePoint::new(7).path(3);
    for step in (0..1000).map(|k| k * 389 % 1000) {
        let expected = [0, 1, 2].map(|process| path.increment(step, process, h));
        assert_eq!(draw(&mut path, step, h)?, expected);
    }
    let other = path.clone().path(4);
    assert!((0..100).any(|step| path.increment(step, 0, h) != other.increment(step, 0, h)));
    Ok(())
}

#[test]
fn fewer_or_more_processes_do_not_change_a_process() -> Result<(), NoiseError> {
    let mut path = Wiener::new(7);
    let [first] = draw(&mut path, 5, 0.1)?;
    let [a, b, c, d, e] = draw(&mut path, 5, 0.1)?;
    assert_eq!(first, a);
    assert_eq!(draw(&mut path, 6, 0.1)?, [path.increment(6, 0, 0.1)]);
    assert_eq!(draw(&mut path, 5, 0.1)?, [a, b, c, d, e]);
    assert_eq!(draw(&mut path, 5, 0.1)?, [a, b]);
    let none: [f64; 0] = draw(&mut path, 5, 0.1)?;
    assert!(none.is_empty());
    Ok(())
}

/// Checks sources around the others with many processes, in numbers that fill no chunk, at steps in
/// any order.
#[test]
fn every_process_of_many_has_its_own_bits() -> Result<(), NoiseError> {
    fn check(mut source: impl Noise, of: impl Fn(u64, usize) -> f64) -> Result<(), NoiseError> {
        for (step, processes) in [
            (5, 1003),
            (1 << 40, 65),
            (4, 2048),
            (7, 999),
            (5, 130),
            (0, 64),
        ] {
            let mut dw = vec![f64::NAN; processes];
            source.increments(step, 0.3, &mut dw)?;
            for (process, dw) in dw.iter().enumerate() {
                assert_eq!(
                    dw.to_bits(),
                    of(step, process).to_bits(),
                    "{step} {process}"
                );
            }
        }
        Ok(())
    }
    let (normal, three) = (Wiener::new(3).path(11), ThreePoint::new(3).path(11));
    check(normal, |step, process| normal.increment(step, process, 0.3))?;
    check(three, |step, process| three.increment(step, process, 0.3))?;
    let truncated = Truncated::new(normal).deviations(1.0)?;
    let largest = truncated.largest(0.3)?;
    check(truncated, |step, process| {
        normal
            .increment(step, process, 0.3)
            .clamp(-largest, largest)
    })?;
    check(normal.from_step(9), |step, process| {
        normal.increment(step + 9, process, 0.3)
    })?;
    check(normal.refine(2)?, |step, process| {
        let whole = DyadicInterval::whole(step / 4);
        let halves = whole.halves().expect("a whole step has halves");
        let (half, quarter) = ((step / 2 % 2) as usize, (step % 2) as usize);
        let increment = normal.increment(step / 4, process, 1.2);
        let increment = normal.halves(whole, process, 1.2, increment)[half];
        normal.halves(halves[half], process, 0.6, increment)[quarter]
    })
}

#[test]
fn a_new_path_or_step_size_does_not_reuse_the_old() -> Result<(), NoiseError> {
    let mut path = Wiener::new(7);
    let at_small: [f64; 1] = draw(&mut path, 0, 0.01)?;
    assert_eq!(draw(&mut path, 0, 0.04)?, [path.increment(0, 0, 0.04)]);
    assert_eq!(draw(&mut path, 0, 0.01)?, at_small);
    let mut other = path.clone().path(1);
    assert_eq!(draw(&mut other, 0, 0.01)?, [other.increment(0, 0, 0.01)]);
    assert_ne!(draw(&mut other, 0, 0.01)?, at_small);
    assert_eq!(draw(&mut other.path(0), 0, 0.01)?, at_small);
    Ok(())
}

#[test]
fn the_last_steps_exist() -> Result<(), NoiseError> {
    let mut path = Wiener::new(u64::MAX).path(u64::MAX);
    for step in [u64::MAX, u64::MAX - 1, u64::MAX - 3, u64::MAX - 4, 1 << 63] {
        let [dw] = draw(&mut path, step, 1.0)?;
        assert!(dw.is_finite() && dw == path.increment(step, 0, 1.0));
    }
    assert!(path.increment(0, usize::MAX, 1.0).is_finite());
    Ok(())
}

/// Published results depend on these numbers. Computed from the layout independently, at 50 digits.
#[test]
fn wiener_values_are_a_contract() {
    for (seed, number, step, process, expected) in CONTRACT {
        let got = Wiener::new(seed).path(number).increment(step, process, 1.0);
        assert_close(
            got,
            expected,
            &format!("{seed}, {number}, {step}, {process}"),
        );
    }
}

/// Results of checkpoints and other machines are merged with new ones, so the bits are a contract
/// too. The hash is FNV-1a on words, over both kinds of blocks. A change of the bits also changes
/// the version of the increments, which fingerprints of ensembles contain.
#[test]
fn the_bits_of_increments_are_a_contract() -> Result<(), NoiseError> {
    fn hash(mut source: impl Noise) -> Result<u64, NoiseError> {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        for step in 0..100 {
            for dw in draw::<40>(&mut source, step, 0.04)? {
                hash = (hash ^ dw.to_bits()).wrapping_mul(0x0100_0000_01b3);
            }
        }
        Ok(hash)
    }
    assert_eq!(hash(Wiener::new(42).path(7))?, 0xeb93_d5c5_51f4_c346);
    assert_eq!(hash(ThreePoint::new(42).path(7))?, 0x4d12_5625_8c70_1715);
    Ok(())
}

#[test]
fn three_point_values_are_a_contract() {
    let path = ThreePoint::new(42).path(7);
    for (process, signs) in THREE_POINT.into_iter().enumerate() {
        for (step, sign) in (0..).zip(signs) {
            let expected = f64::from(sign) * (3.0_f64 * 0.04).sqrt();
            let got = path.increment(step, process, 0.04);
            assert_close(got, expected, &format!("{step}, {process}"));
        }
    }
}

#[test]
fn bridge_values_are_a_contract() {
    let path = Wiener::new(42).path(7);
    for (step, process, level, index, expected) in BRIDGE {
        let mut part = DyadicInterval::whole(step);
        for bit in (0..level).rev() {
            part = part.halves().unwrap()[(index >> bit & 1) as usize];
        }
        assert_eq!((part.level(), part.index()), (level, index));
        // half the square root of 4 is the scale of the normal
        let [left, right] = path.halves(part, process, 4.0, 0.0);
        assert_close(left, expected, &format!("{part:?}, {process}"));
        assert_eq!(right, -left);
    }
}

fn assert_close(got: f64, expected: f64, of: &str) {
    assert!(
        (got - expected).abs() <= 4e-15,
        "{of}: {got:?} for {expected:?}"
    );
}

const CONTRACT: [(u64, u64, u64, usize, f64); 15] = [
    (42, 7, 0, 0, -0.511_627_064_737_852_9),
    (42, 7, 1, 0, 0.810_305_703_597_274_4),
    (42, 7, 2, 0, 0.990_485_368_886_923_7),
    (42, 7, 3, 0, 0.753_473_268_642_748_8),
    (42, 7, 4, 1, -0.498_460_019_189_818_97),
    (42, 7, 1 << 40, 2, 0.442_222_040_231_201_93),
    (42, 7, u64::MAX, 0, 1.452_766_668_954_912_4),
    (0, 0, 0, 0, 1.034_498_353_413_817_2),
    (u64::MAX, u64::MAX, 5, 3, -2.002_571_168_216_320_5),
    (1, 0, 6, 1, 2.176_883_016_688_059),
    (42, 7, 0, 15, -1.258_217_152_290_380_2),
    (42, 7, 0, 16, -0.008_502_431_397_063_082),
    (42, 7, 1, 17, 0.834_733_491_711_746_3),
    (42, 7, 5, 18, -2.446_904_482_726_561),
    (42, 7, 5, 1_000_003, 1.262_839_379_657_022),
];

/// Signs of the first 16 steps of two processes.
const THREE_POINT: [[i8; 16]; 2] = [
    [0, -1, 1, 1, 0, -1, 0, 0, -1, 0, -1, 0, 0, 0, 1, 0],
    [0, 0, 0, 0, -1, 0, -1, 0, 1, 0, 0, 0, 0, -1, 0, 0],
];

/// Step, process, level, index.
const BRIDGE: [(u64, usize, u32, u64, f64); 4] = [
    (10, 0, 0, 0, 1.578_011_737_334_267),
    (10, 5, 0, 0, 1.373_978_218_005_563_5),
    (10, 2, 3, 7, -0.458_176_330_099_574_76),
    (u64::MAX, 3, 63, (1 << 63) - 1, -2.044_413_788_731_174_6),
];

#[test]
fn every_source_refuses_impossible_steps() -> Result<(), NoiseError> {
    for h in [0.0, -0.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut sources: [Box<dyn Noise>; 5] = [
            Box::new(Wiener::new(1)),
            Box::new(ThreePoint::new(1)),
            Box::new(Wiener::new(1).refine(2)?),
            Box::new(Truncated::new(Wiener::new(1))),
            Box::new(FromRng::new(StdRng::seed_from_u64(1))),
        ];
        for source in &mut sources {
            draw::<1>(source, 0, 0.1)?;
            let error = draw::<1>(source, 0, h).unwrap_err();
            // a NaN is not equal to itself
            assert!(
                matches!(error, NoiseError::InvalidStep { h: given } if given.to_bits() == h.to_bits())
            );
            draw::<1>(source, 0, 0.1)?;
        }
        assert!(matches!(
            Recorded::new(h, [[0.1]]),
            Err(NoiseError::InvalidStep { .. })
        ));
        assert!(matches!(
            Recorded::record(NoNoise, h, 1, 1),
            Err(NoiseError::InvalidStep { .. })
        ));
        assert!(matches!(
            Recorded::new(0.1, [[0.1]])?.increments(0, h, &mut [0.0]),
            Err(NoiseError::StepSize { .. })
        ));
    }
    Ok(())
}

/// Against the untouched increments: `largest` is exact where nothing but a product and a root is
/// computed.
fn clips_at(mut truncated: Truncated<Wiener>, deviations: f64, h: f64) -> Result<(), NoiseError> {
    let mut plain = Wiener::new(5);
    let largest = f64::sqrt(h) * deviations;
    assert!((truncated.largest(h)? / largest - 1.0).abs() < 1e-14);
    let mut clipped = 0;
    for step in 0..4000 {
        let [free] = draw(&mut plain, step, h)?;
        let [dw] = draw(&mut truncated, step, h)?;
        if free.abs() <= largest * (1.0 - 1e-14) {
            assert_eq!(dw, free);
        } else {
            assert_eq!(dw, truncated.largest(h)?.copysign(free));
            clipped += 1;
        }
    }
    let expected = 4000.0 * libm::erfc(deviations / 2.0_f64.sqrt());
    assert!((f64::from(clipped) - expected).abs() <= 5.0 * expected.sqrt());
    Ok(())
}

#[test]
fn truncation_clips_and_nothing_else() -> Result<(), NoiseError> {
    // any step size, long ones too
    for (deviations, h) in [(6.0, 0.1), (1.5, 1.0), (2.5, 1e6), (0.5, 1e-300)] {
        let truncated = Truncated::new(Wiener::new(5)).deviations(deviations)?;
        clips_at(truncated, deviations, h)?;
    }
    assert_eq!(
        Truncated::new(NoNoise),
        Truncated::new(NoNoise).deviations(6.0)?
    );
    // as Milstein, Repin and Tretyakov propose, in two units of time: ten times h and τ are the
    // same path, √10 times as large
    for (k, h) in [
        (1.0, 0.1),
        (2.0, 0.1),
        (2.0, 0.5),
        (4.0, 0.001),
        (2.0, 1e-300),
    ] {
        let deviations = (2.0 * k * f64::ln(h).abs()).sqrt();
        clips_at(
            Truncated::new(Wiener::new(5)).exponent(k, 1.0)?,
            deviations,
            h,
        )?;
        clips_at(
            Truncated::new(Wiener::new(5)).exponent(k, 10.0)?,
            deviations,
            10.0 * h,
        )?;
    }
    for h in [2.0, 2.5] {
        assert_eq!(
            draw::<1>(&mut Truncated::new(NoNoise).exponent(2.0, 2.0)?, 0, h),
            Err(NoiseError::TruncationStep { h, tau: 2.0 })
        );
    }
    for (k, tau) in [
        (0.5, 1.0),
        (f64::INFINITY, 1.0),
        (f64::NAN, 1.0),
        (2.0, 0.0),
        (2.0, f64::NAN),
    ] {
        assert!(matches!(
            Truncated::new(NoNoise).exponent(k, tau),
            Err(NoiseError::TruncationExponent { .. })
        ));
    }
    for deviations in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        assert!(matches!(
            Truncated::new(NoNoise).deviations(deviations),
            Err(NoiseError::TruncationDeviations { .. })
        ));
    }
    // what the inner source says comes through
    let mut short = Truncated::new(Recorded::new(0.1, [[5.0]])?);
    assert!(draw::<1>(&mut short, 0, 0.1)?[0] < 2.0);
    let (step, recorded) = (1, 1);
    assert_eq!(
        draw::<1>(&mut short, step, 0.1),
        Err(NoiseError::Exhausted { step, recorded })
    );
    Ok(())
}

#[test]
fn a_foreign_generator_is_read_in_order() -> Result<(), NoiseError> {
    let mut rng = StdRng::seed_from_u64(9);
    let mut one_by_one = FromRng::new(StdRng::seed_from_u64(9));
    let mut by_reference = FromRng::new(&mut rng);
    for step in 0..10 {
        let three: [f64; 3] = draw(&mut by_reference, step, 0.1)?;
        for dw in three {
            assert_eq!(draw(&mut one_by_one, 0, 0.1)?, [dw]);
        }
    }
    // 30 normals from 30 words
    let mut words = StdRng::seed_from_u64(9);
    for _ in 0..30 {
        words.next_u64();
    }
    assert_eq!(rng.next_u64(), words.next_u64());
    Ok(())
}

#[test]
fn no_noise_is_zero() -> Result<(), NoiseError> {
    assert_eq!(draw(&mut NoNoise, 3, 0.1)?, [0.0, 0.0]);
    Ok(())
}

#[test]
fn messages_have_the_numbers_and_the_remedy() {
    let errors = [
        NoiseError::Exhausted {
            step: 10,
            recorded: 9,
        },
        NoiseError::Processes {
            asked: 3,
            recorded: 1,
        },
        NoiseError::Coarsen {
            recorded: 10,
            factor: 3,
        },
        NoiseError::TruncationStep { h: 1.5, tau: 1.0 },
        NoiseError::TruncationExponent { k: 0.5, tau: 1.0 },
        NoiseError::TruncationDeviations { deviations: -1.0 },
        NoiseError::StepNumber {
            step: 1,
            first: u64::MAX,
        },
        NoiseError::Depth { depth: 64 },
    ];
    let expected = [
        "the recorded path has 9 steps and step 10 (from 0) was asked for; record more steps",
        "the path was recorded with 1 Wiener processes, and the system has 3; record 3",
        "a path of 10 steps cannot be coarsened by 3; take a divisor of 10, or record a multiple of the factor",
        "increments truncated at √(2k ln(τ/h)) standard deviations need h < τ, and h = 1.5, τ = 1; \
         give their number with `deviations`, which has no such limit, or take a smaller step",
        "the truncation exponent k = 0.5 must be finite and at least 1, where 2 keeps strong order 1, \
         and the time τ = 1 positive and finite",
        "increments cannot be truncated at -1 standard deviations: the bound must be positive and finite, for example 6",
        "step 1 of a path that was entered at its step 18446744073709551615 has a number above 2^64 − 1: enter it earlier",
        "a step can be halved at most 63 times, and a refinement of depth 64 was asked for",
    ];
    assert_eq!(errors.map(|error| error.to_string()), expected);
}
