//! Studies of rules with stage noise, on the paths of all other methods.

use sve_runtime::baseline::Heun;
use sve_runtime::noise::Recorded;
use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;
use sve_runtime::study::{Report, Study, StudyError};

/// A double well with additive noise and a friction of strength ν.
#[derive(Clone, Copy)]
struct Well {
    nu: f64,
}

#[variational(midpoint, gauss(2, stage_noise), gauss(3, stage_noise))]
impl Well {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.25 * (q * q - 1.0).powi(2)
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.7 * q
    }
    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }
}

const START: State<[f64; 1]> = State::new([1.0], [0.2]);

fn study(nu: f64, paths: u64) -> Report {
    let well = Well { nu };
    let three = Integrator::new(well, StageNoise(Gauss::<3>));
    Study::new("well")
        .start(START)
        .horizon(1.0)
        .step_counts([4, 8, 16, 32])
        .paths(paths)
        .seed(17)
        .method("midpoint", &Integrator::new(well, Midpoint))
        .method("two", &Integrator::new(well, StageNoise(Gauss::<2>)))
        .method("three", &three)
        .method("Heun", &Heun::new(well))
        .fine(&three, 4)
        .repeats(1)
        .run()
        .unwrap()
}

/// One path serves rules of two and of three stages, and of none.
#[test]
fn errors_are_those_of_trajectories_on_the_same_paths() {
    let paths = 20;
    let report = study(0.0, paths);
    println!("{report}");
    let well = Well { nu: 0.0 };
    let [midpoint, two] = [0, 1].map(|_| well);
    let midpoint = Integrator::new(midpoint, Midpoint);
    let two = Integrator::new(two, StageNoise(Gauss::<2>));
    let three = Integrator::new(well, StageNoise(Gauss::<3>));
    let mut squares = [0.0; 3];
    for number in 0..paths {
        // paths of two and of three stages have the same coefficients in Legendre polynomials
        let record = |stages| {
            let noise = Wiener::new(17).path(number);
            Recorded::record_stages(noise, 1.0 / 128.0, 1, stages, 128).unwrap()
        };
        let [of_two, of_three] = [2, 3].map(record);
        let exact = three.trajectory(START, 1.0 / 128.0, &of_three).last();
        let exact = exact.unwrap().unwrap();
        let [of_two, of_three] = [of_two, of_three].map(|path| path.coarsen(16).unwrap());
        let ends = [
            midpoint.trajectory(START, 0.125, &of_three).last(),
            two.trajectory(START, 0.125, &of_two).last(),
            three.trajectory(START, 0.125, &of_three).last(),
        ];
        for (square, end) in squares.iter_mut().zip(ends) {
            let end = end.unwrap().unwrap();
            *square += (end.q[0] - exact.q[0]).powi(2) + (end.p[0] - exact.p[0]).powi(2);
        }
    }
    for (method, square) in ["midpoint", "two", "three"].into_iter().zip(squares) {
        let error = report.row(method, 8).unwrap().error.unwrap().value;
        let expected = (square / paths as f64).sqrt();
        // the error of three stages is 1e-6, of ends with rounding errors of 1e-16
        assert!((error / expected - 1.0).abs() < 1e-9, "{method}");
        assert!(report.row(method, 8).unwrap().timing.is_some());
    }
}

/// A friction that is linear in the velocity leaves the orders as they are.
#[test]
fn orders_of_additive_noise_are_those_of_the_stages() {
    let report = study(0.5, 600);
    println!("{report}");
    for (method, order) in [("two", 2.0), ("three", 3.0)] {
        check(&report, method, order);
    }
}

/// Checks the order that a method states, and measures.
fn check(report: &Report, method: &str, order: f64) {
    let found = report.orders().iter().find(|order| order.method == method);
    let found = found.unwrap_or_else(|| panic!("{method}: {report}"));
    assert_eq!(found.of_method, Some(order));
    let error = (found.order.value - order).abs();
    assert!(error <= 2.0 * found.order.standard_error, "{found}");
}

/// A path that is drawn has to have the stages of the methods.
#[test]
fn drawn_paths_without_stages_are_an_error() {
    let three = Integrator::new(Well { nu: 0.0 }, StageNoise(Gauss::<3>));
    let study = |stages: usize| {
        Study::new("well")
            .start(START)
            .horizon(1.0)
            .step_counts([4, 8])
            .method("three", &three)
            .exact_paths(move |path, steps| {
                let (noise, h) = (Wiener::new(1).path(path), 1.0 / steps as f64);
                let recorded = Recorded::record_stages(noise, h, 1, stages, steps);
                (recorded.unwrap(), START)
            })
            .repeats(0)
            .run()
    };
    assert!(study(3).is_ok() && study(4).is_ok());
    let error = study(1).unwrap_err();
    assert!(matches!(error, StudyError::Noise { path: 0, .. }));
    assert!(error.to_string().contains("record 3 or more"), "{error}");
}

macro_rules! plane {
    ($($(#[$doc:meta])* $name:ident, $q:ident, $v:ident, $field:expr, $friction:expr;)*) => {$(
        $(#[$doc])*
        struct $name;

        #[variational(gauss(2, stage_noise), gauss(3, stage_noise), gauss(4, stage_noise))]
        impl $name {
            fn lagrangian(&self, $q: [f64; 2], $v: [f64; 2]) -> f64 {
                0.5 * ($v[0] * $v[0] + $v[1] * $v[1]) + $field * $v[1]
                    - ($q[0] * $q[0] + $q[1] * $q[1]).powi(2)
            }
            #[gamma]
            fn push(&self, $q: [f64; 2]) -> [f64; 2] {
                $q
            }
            #[force]
            fn friction(&self, $q: [f64; 2], $v: [f64; 2]) -> [f64; 2] {
                $friction
            }
        }
    )*};
}

plane! {
    /// A constant magnetic field, and a constant friction that joins both velocities.
    Constant, q, v, 2.0 * q[0] * (1.0 + 0.0 * q[1]), [
        -v[0] - 0.5 * v[1] + 0.0 * q[0],
        -v[1] - 0.5 * v[0],
    ];
    /// A magnetic field that grows with the place.
    Magnetic, q, v, 2.0 * q[0] * q[0], [0.0 * v[0], 0.0 * q[0]];
    /// A friction that depends on the other coordinate.
    OfPlace, q, v, 0.0 * q[0], [-2.0 * q[1] * v[0], -2.0 * q[0] * v[1]];
    /// A friction that is not linear.
    Cubic, q, v, 0.0 * q[0], [-0.5 * v[0].powi(3) + 0.0 * q[0], -0.5 * v[1].powi(3)];
}

/// Studies three stages.
macro_rules! in_plane {
    ($system:expr) => {{
        let three = Integrator::new($system, StageNoise(Gauss::<3>));
        let report = Study::new(stringify!($system))
            .start(State::new([0.2, 0.1], [0.1, 0.3]))
            .horizon(0.5)
            .step_counts([8, 16, 32, 64])
            .paths(400)
            .seed(17)
            .method("three", &three)
            .fine(&three, 4)
            .repeats(0)
            .run()
            .unwrap();
        println!("{report}");
        report
    }};
}

#[test]
fn forces_that_are_linear_in_velocities_keep_an_order_above_one() {
    check(&in_plane!(Constant), "three", 3.0);
    check(&in_plane!(Magnetic), "three", 2.5);
    // the errors of the reference are a tenth of the smallest ones here
    let report = in_plane!(Cubic);
    let error = |steps| report.row("three", steps).unwrap().error.unwrap().value;
    assert!(error(8) < 16.0 * error(64), "{report}");
    let stated = Integrator::new(Cubic, StageNoise(Gauss::<3>)).plan();
    assert_eq!(stated.strong_order, StrongOrder::One);
    let stated = Integrator::new(OfPlace, StageNoise(Gauss::<3>)).plan();
    assert_eq!(stated.strong_order, StrongOrder::TwoAndAHalf);
    let stated = Integrator::new(OfPlace, StageNoise(Gauss::<2>)).plan();
    assert_eq!(stated.strong_order, StrongOrder::Two);
}
