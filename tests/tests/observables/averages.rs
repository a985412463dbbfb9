//! Temperatures and other averages: the bias of each rule by exact moments, one long path, many
//! paths.

use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Blocking, Variational};

use super::systems::{Langevin, Oscillator};

/// The stationary moments (⟨q²⟩, ⟨qp⟩, ⟨p²⟩) of a linear step z₁ = A z₀ + b ΔW: the fixed point of
/// the linear map of the moments.
fn stationary<S, R>(integrator: &Integrator<S, R>, h: f64) -> [f64; 3]
where
    S: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let image = |q: f64, p: f64, dw: f64| {
        let mut state = State::new([q], [p]);
        integrator.step(&mut state, h, &[dw]).unwrap();
        [state.q[0], state.p[0]]
    };
    let [[a, c], [b, d]] = [image(1.0, 0.0, 0.0), image(0.0, 1.0, 0.0)];
    let [f, g] = image(0.0, 0.0, 1.0);
    let mut moments = [0.0; 3];
    // the powers of two of the map, applied one after another
    let mut map = [
        [a * a, 2.0 * a * b, b * b],
        [a * c, a * d + b * c, b * d],
        [c * c, 2.0 * c * d, d * d],
    ];
    let mut added = [f * f * h, f * g * h, g * g * h];
    for _ in 0..24 {
        let apply = |v: [f64; 3]| map.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
        let next = apply(added);
        added = [0, 1, 2].map(|i| added[i] + next[i]);
        let squared = [0, 1, 2].map(|j| apply([0, 1, 2].map(|i| map[i][j])));
        map = [0, 1, 2].map(|i| [0, 1, 2].map(|j| squared[j][i]));
        moments = added;
    }
    moments
}

/// The table in the documentation of `temperature`, with kT = 1 and ω = 1.
#[test]
fn the_bias_of_the_temperature_of_each_rule() {
    for nu in [0.2, 1.0] {
        let langevin = Langevin {
            nu,
            sigma: (2.0_f64 * nu).sqrt(),
        };
        for h in [0.4, 0.2, 0.1] {
            let [qq, qp, pp] = stationary(&Integrator::new(langevin, Midpoint), h);
            let worst = (qq - 1.0).abs().max(qp.abs()).max((pp - 1.0).abs());
            assert!(worst < 1e-11, "midpoint {nu} {h}: {qq} {qp} {pp}");
            let [qq, _, pp] = stationary(&Integrator::new(langevin, StormerVerlet), h);
            let expected = 1.0 - 0.25 * h * h;
            assert!((qq - 1.0).abs() < 1e-13, "Verlet {nu} {h}: {qq}");
            assert!((pp - expected).abs() < 1e-13, "Verlet {nu} {h}: {pp}");
            // measured: −½νh + ½h² and +½νh + ½h² up to the next order, and ±½h for ⟨qp⟩
            let one_sided = [
                (
                    stationary(&Integrator::new(langevin, InitialPoint), h),
                    -1.0,
                ),
                (stationary(&Integrator::new(langevin, Endpoint), h), 1.0),
            ];
            for ([qq, qp, pp], sign) in one_sided {
                let error = pp - 1.0 - 0.5 * h * (sign * nu + 0.5 * h);
                assert!(error.abs() < 0.5 * h * h * (1.0 + nu * nu), "{nu} {h} {pp}");
                assert!(
                    (qp + 0.5 * sign * h).abs() < 0.5 * h * h * (1.0 + nu),
                    "{nu} {h} {qp}"
                );
                assert!((qq - 1.0).abs() < 0.6 * h * h, "{nu} {h} {qq}");
            }
        }
    }
}

/// The temperature of a state is ⟨p, v⟩/n for any mass matrix.
#[test]
fn the_temperature_of_a_state() {
    let bodies = Bodies { m: [2.0, 0.5] };
    let state = State::new([0.3, 1.0], [4.0, 1.0]);
    // v = (2, 2)
    assert!((bodies.temperature(&state).unwrap() - 5.0).abs() < 1e-14);
    let nowhere = State::new([0.0, 0.0], [f64::NAN, 0.0]);
    assert!(bodies.temperature(&nowhere).is_err());
}

/// Two bodies on a line.
struct Bodies {
    m: [f64; 2],
}

#[variational(midpoint)]
impl Bodies {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = 0.5 * (self.m[0] * v[0] * v[0] + self.m[1] * v[1] * v[1]);
        kinetic - 0.5 * (q[1] - q[0]).powi(2)
    }
}

/// One long path: the mean of p² is within its error, which blocking finds, and the error of
/// independent values is far too small.
#[test]
fn one_long_path() {
    let langevin = Langevin {
        nu: 0.2,
        sigma: 0.4_f64.sqrt(),
    };
    let (h, steps) = (0.2, 200_000);
    let motion = Integrator::new(langevin, Midpoint);
    let mut temperature = Blocking::new();
    let path = motion.trajectory(State::new([0.0], [0.0]), h, Wiener::new(3));
    for state in path.skip(500).take(steps) {
        temperature.push(langevin.temperature(&state.unwrap()).unwrap());
    }
    let error = temperature.standard_error().unwrap();
    assert!((temperature.mean() - 1.0).abs() < 4.0 * error);
    let naive = temperature.estimates().next().unwrap().standard_error;
    assert!(error > 3.0 * naive, "{error} {naive}");
    // for a Gaussian process the autocorrelation of p² is the square of that of p
    let time = h * temperature.correlation_time().unwrap();
    let exact = exact_correlation_time(langevin.nu);
    assert!((time / exact - 1.0).abs() < 0.15, "{time} {exact}");
}

/// The integral of ρ(t)² over t ≥ 0, where ρ is the autocorrelation of p.
fn exact_correlation_time(nu: f64) -> f64 {
    let omega = (1.0 - 0.25 * nu * nu).sqrt();
    let step = 1e-3;
    (0..200_000)
        .map(|k| step * (f64::from(k) + 0.5))
        .map(|t| {
            let (sin, cos) = (omega * t).sin_cos();
            let rho = (-0.5 * nu * t).exp() * (cos - 0.5 * nu / omega * sin);
            step * rho * rho
        })
        .sum()
}

fn averages(
    motion: &Integrator<Langevin, Midpoint>,
    record: u64,
) -> Ensemble<'_, Integrator<Langevin, Midpoint>> {
    Ensemble::new(motion)
        .paths(200)
        .seed(5)
        .steps(0.25, 400)
        .every(record)
        .settle(40)
        .start(State::new([1.0], [0.5]))
        .average("kT", Langevin::temperature)
        .observe("q", |_, state| state.q[0])
        .average("q²", |_, state| state.q[0].powi(2))
}

/// The average of a path is the trapezoidal sum along it, and the statistics are those of the
/// averages.
#[test]
fn averages_along_paths_are_trapezoidal_sums() {
    let motion = Integrator::new(
        Langevin {
            nu: 0.5,
            sigma: 1.0,
        },
        Midpoint,
    );
    let ensemble = averages(&motion, 100);
    let summary = ensemble.run().unwrap();
    let mut sums = [0.0; 5];
    for path in 0..200 {
        let states: Vec<_> = std::iter::once(State::new([1.0], [0.5]))
            .chain(ensemble.replay(path).unwrap().map(Result::unwrap))
            .collect();
        let value = |k: usize| states[k].q[0].powi(2);
        for (record, sum) in sums.iter_mut().enumerate() {
            let end = 100 * record;
            *sum += if end <= 40 {
                value(end)
            } else {
                let inner: f64 = (41..end).map(value).sum();
                (inner + 0.5 * (value(40) + value(end))) / (end - 40) as f64
            };
        }
    }
    for (mean, sum) in summary["q²"].mean().iter().zip(sums) {
        assert!((mean - sum / 200.0).abs() < 1e-13, "{mean} {sum}");
    }
    // kT = σ²/2ν = 1, exact for the midpoint rule: within the error between paths
    let kt = &summary["kT"];
    let error = kt.standard_error()[4];
    assert!((kt.mean()[4] - 1.0).abs() < 4.0 * error && error < 0.03);
    // the other observables have the bits that they have without integrals
    let plain = Ensemble::new(&motion)
        .paths(200)
        .seed(5)
        .steps(0.25, 400)
        .every(100)
        .start(State::new([1.0], [0.5]))
        .observe("q", |_, state| state.q[0])
        .run()
        .unwrap();
    assert_eq!(plain["q"].mean(), summary["q"].mean());
}

/// The same bits on any number of threads and shards, and from a checkpoint; another function or
/// beginning is another run.
#[test]
fn averages_keep_their_bits() {
    let motion = Integrator::new(
        Langevin {
            nu: 0.5,
            sigma: 1.0,
        },
        Midpoint,
    );
    let whole = averages(&motion, 100).threads(1).run().unwrap();
    assert_eq!(whole, averages(&motion, 100).threads(3).run().unwrap());
    let shard = |k| averages(&motion, 100).shard(k, 3).run().unwrap();
    let mut merged = shard(2);
    merged.merge(shard(0)).unwrap();
    merged.merge(shard(1)).unwrap();
    assert_eq!(merged, whole);
    // averages that are recorded at other times are the same
    let often = averages(&motion, 50).run().unwrap();
    assert_eq!(often["kT"].mean()[8], whole["kT"].mean()[4]);
    let mut first = shard(0);
    assert!(
        first
            .merge(averages(&motion, 100).settle(41).shard(1, 3).run().unwrap())
            .is_err()
    );
    let other = averages(&motion, 100)
        .weight(|_, _| 0.0)
        .shard(1, 3)
        .run()
        .unwrap();
    assert!(first.merge(other).is_err());

    let folder = std::env::temp_dir().join(format!("sve-averages-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("averages");
    let every = std::time::Duration::ZERO;
    let blocks = std::sync::atomic::AtomicU32::new(0);
    let stopped = averages(&motion, 100)
        .threads(1)
        .checkpoint(&file, every)
        .stop_when(|| blocks.fetch_add(1, std::sync::atomic::Ordering::Relaxed) >= 2)
        .run()
        .unwrap();
    assert!(!stopped.is_complete());
    let continued = averages(&motion, 100)
        .checkpoint(&file, every)
        .resume(true)
        .run()
        .unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(continued, whole);
}

/// An integrand that is not finite between two recorded times fails the path with its name and
/// place.
#[test]
fn integrands_that_are_not_finite_fail_the_path() {
    let motion = Integrator::new(Oscillator, Midpoint);
    let summary = Ensemble::new(&motion)
        .paths(10)
        .steps(0.1, 100)
        .start(State::new([1.0], [0.0]))
        .average("root", |_, state| (state.q[0] - 0.5).sqrt())
        .run()
        .unwrap();
    // cos t < ½ from t = π/3 on
    assert_eq!((summary.failed(), summary.failures()[3].step), (10, 11));
    assert!(summary.failures()[3].to_string().contains("`root` is NaN"));
    let summary = Ensemble::new(&motion)
        .paths(10)
        .steps(0.1, 100)
        .start(State::new([1.0], [0.0]))
        .weight(|_, state| (state.q[0] - 2.0).ln())
        .terminal("u", |_, _| 1.0)
        .run()
        .unwrap();
    assert_eq!((summary.failed(), summary.failures()[0].step), (10, 0));
    assert!(
        summary.failures()[0]
            .to_string()
            .contains("`weight` is NaN")
    );
}
