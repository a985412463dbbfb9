//! Stage noise: sources, symplecticity, what does not go.

use sve_models::checks::assert_close;
use sve_models::orders::end;
use sve_models::steps::{check_return, check_tangent};
use sve_runtime::noise;
use sve_runtime::noise::NoiseError;
use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;

use crate::systems::{Kubo, double_pendulum};

const START: State<[f64; 2]> = State {
    t: 0.0,
    q: [0.8, -0.3],
    p: [0.2, 0.5],
};

/// Kubo's exact rotation conserves q² + p² scaled, whatever the increments at the stages are.
#[test]
fn increments_at_the_stages_conserve_what_the_noise_conserves() {
    let kubo = Integrator::new(Kubo { a: 1.0, sigma: 0.7 }, StageNoise(Gauss::<3>));
    let mut state = State::new([1.0], [0.0]);
    for _ in 0..50 {
        kubo.step(&mut state, 0.1, &[0.3, -0.2, 0.1]).unwrap();
    }
    assert!((state.q[0].hypot(state.p[0]) - 1.0).abs() < 1e-14);
}

/// A step back takes the increments of the stages from the last to the first.
#[test]
fn steps_are_symplectic_and_return() {
    let method = Integrator::new(double_pendulum(), StageNoise(Gauss::<3>));
    let dw = [0.1, -0.2, 0.3, 0.05, 0.1, -0.1];
    check_tangent(&method, &START, 0.1, &dw, Some(1e-13));
    let back = [-0.3, 0.2, -0.1, 0.1, -0.1, -0.05];
    check_return(&method, &START, 0.1, [&dw, &back], 1e-14);
}

/// Equal parts are the rule without stage noise.
#[test]
fn parts_in_proportion_to_the_weights_are_the_plain_rule() {
    let plain = Integrator::new(double_pendulum(), Gauss::<2>);
    let staged = Integrator::new(double_pendulum(), StageNoise(Gauss::<2>));
    let (mut a, mut b) = (START, START);
    plain.step(&mut a, 0.1, &[0.2, -0.3]).unwrap();
    staged.step(&mut b, 0.1, &[0.1, 0.1, -0.15, -0.15]).unwrap();
    assert_eq!(a, b);
}

/// Every source gives increments that add up to those of a plain rule, or says that it has none.
#[test]
fn sources_draw_details_of_the_same_path() {
    fn adds_up(mut source: impl Noise + Clone, stages: usize) {
        let (mut whole, mut parts) = ([0.0; 2], vec![0.0; 2 * stages]);
        for step in [0, 1, 5, 1000] {
            source.clone().increments(step, 0.01, &mut whole).unwrap();
            source
                .stage_increments(step, 0.01, stages, &mut parts)
                .unwrap();
            for (whole, parts) in whole.iter().zip(parts.chunks(stages)) {
                let sum: f64 = parts.iter().sum();
                assert!((sum - whole).abs() < 1e-15, "{sum} {whole}");
            }
        }
    }
    for stages in 2..=8 {
        adds_up(Wiener::new(7), stages);
        adds_up(Wiener::new(7).path(3).from_step(11), stages);
        adds_up(NoNoise, stages);
    }
    let mut parts = [0.0; 6];
    let mut refined = Wiener::new(7).refine(1).unwrap();
    let none = Err(NoiseError::NoStages { stages: 3 });
    assert_eq!(refined.stage_increments(0, 0.01, 3, &mut parts), none);
    let drawn = noise::ThreePoint::new(7).stage_increments(0, 0.01, 3, &mut parts);
    assert_eq!(drawn, none);
    // clipped to as many standard deviations of their own
    let mut clipped = Truncated::new(Wiener::new(7)).deviations(0.5).unwrap();
    let b = [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0_f64];
    let mut reached = 0;
    for step in 0..100 {
        clipped.stage_increments(step, 0.01, 3, &mut parts).unwrap();
        for (part, b) in parts.iter().zip(b.iter().cycle()) {
            let bound = 0.5 * (b * 0.01).sqrt();
            assert!(part.abs() <= bound * (1.0 + 1e-12));
            reached += u32::from(part.abs() > bound * (1.0 - 1e-12));
        }
    }
    assert!(reached > 200, "{reached}");
}

#[test]
fn recorded_stages_are_coarsened_exactly_and_serve_plain_rules() {
    let fine = Recorded::record_stages(Wiener::new(5), 0.01, 2, 3, 40).unwrap();
    assert_eq!((fine.processes(), fine.stages(), fine.len()), (2, 3, 40));
    let coarse = fine.coarsen(4).unwrap();
    let plain = Recorded::record(&fine, 0.01, 2, 40)
        .unwrap()
        .coarsen(4)
        .unwrap();
    for step in 0..10 {
        let (parts, whole) = (coarse.get(step).unwrap(), plain.get(step).unwrap());
        for (parts, whole) in parts.chunks(3).zip(whole) {
            let sum: f64 = parts.iter().sum();
            assert!((sum - whole).abs() < 1e-15);
        }
    }
    let twice = fine.coarsen(2).unwrap().coarsen(2).unwrap();
    for step in 0..10 {
        let [a, b] = [&twice, &coarse].map(|path| path.get(step).unwrap());
        assert_close(a, b, 1e-15, "coarsened twice");
    }
    // along the path, by both rules
    let staged = Integrator::new(double_pendulum(), StageNoise(Gauss::<3>));
    let plain = Integrator::new(double_pendulum(), Gauss::<3>);
    let [a, b] = [end(&staged, START, &fine), end(&plain, START, &fine)];
    assert!((a[0] - b[0]).abs() < 0.05);
    // fewer stages are those of the same path, more are an error
    let two = Integrator::new(double_pendulum(), StageNoise(Gauss::<2>));
    let own = Recorded::record_stages(Wiener::new(5), 0.01, 2, 2, 40).unwrap();
    assert_close(
        &end(&two, START, &fine),
        &end(&two, START, &own),
        1e-13,
        "fewer stages",
    );
    let four = Recorded::record_stages(Wiener::new(5), 0.01, 2, 2, 1).unwrap();
    let error = staged.trajectory(START, 0.01, &four).next().unwrap();
    let source = NoiseError::Stages {
        asked: 3,
        recorded: 2,
    };
    assert_eq!(error, Err(StepError::Noise { t: 0.0, source }));
    let rows = Recorded::new(0.01, [[0.1, 0.2, 0.3, 0.4]]).unwrap();
    assert_eq!(rows.clone().with_stages(2).unwrap().processes(), 2);
    assert!(rows.with_stages(3).is_err());
}

#[test]
fn a_source_without_stages_is_an_error_of_the_first_step() {
    let method = Integrator::new(double_pendulum(), StageNoise(Gauss::<3>));
    let mut path = method.trajectory(START, 0.01, ThreePoint::new(3));
    let error = path.next().unwrap().unwrap_err();
    assert!(
        error.to_string().contains("no increments of stages"),
        "{error}"
    );
    assert_eq!(*path.state(), START);
}

#[test]
fn plans_say_the_order() {
    let plan = Integrator::new(double_pendulum(), StageNoise(Gauss::<3>)).plan();
    assert_eq!(plan.rule, "gauss(3, stage_noise)");
    // masses depend on the position
    assert_eq!(plan.strong_order, StrongOrder::One);
}
