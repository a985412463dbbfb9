//! Rules with stage noise: each path is the trajectory with the same noise, bit for bit, and what
//! divides steps is refused.

use sve_models::assert_matches;
use sve_models::checks::{assert_close, assert_says};
use sve_runtime::ensemble::By;
use sve_runtime::noise::Recorded;
use sve_runtime::prelude::*;

/// Two coupled pendula on a table that shakes and turns.
struct Pendula {
    g: f64,
    sigma: f64,
}

#[variational(gauss(2, stage_noise), gauss(3, stage_noise), gauss(3))]
impl Pendula {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + self.g * (q[0].cos() + q[1].cos()) - q[0] * q[1]
    }
    #[gamma]
    fn shake(&self, q: [f64; 2]) -> f64 {
        self.sigma * q[0].sin() * q[1].cos()
    }
    #[gamma]
    fn turn(&self, q: [f64; 2]) -> f64 {
        0.5 * q[1] * q[1]
    }
}

const PATHS: u64 = 70;
const H: f64 = 0.1;
const STEPS: u64 = 40;
const SEED: u64 = 11;

type Staged = Integrator<Pendula, StageNoise<Gauss<3>>>;

fn staged<R>(rule: R) -> Integrator<Pendula, R>
where
    R: sve_runtime::Rule<Pendula>,
{
    Integrator::new(Pendula { g: 2.0, sigma: 0.7 }, rule)
}

fn start() -> State<[f64; 2]> {
    State::at(0.5, [0.4, -0.3], [0.2, 0.1])
}

/// An ensemble of Pendula.
macro_rules! ensemble {
    ($method:expr) => {
        Ensemble::new($method)
            .paths(PATHS)
            .seed(SEED)
            .steps(H, STEPS)
            .start(start())
            .observe("q", |_, state| state.q[0])
            .keep_final_states(true)
    };
}

/// The increments of a path with the other sign.
struct Mirrored<W>(W);

impl<W: Noise> Noise for Mirrored<W> {
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.0.increments(step, h, dw)?;
        for dw in dw.iter_mut() {
            *dw = -*dw;
        }
        Ok(())
    }

    fn stage_increments(
        &mut self,
        step: u64,
        h: f64,
        stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        self.0.stage_increments(step, h, stages, dw)?;
        for dw in dw.iter_mut() {
            *dw = -*dw;
        }
        Ok(())
    }
}

/// Asserts that so many paths end where trajectories with these sources end.
macro_rules! assert_equal_paths {
    ($method:expr, $summary:expr, $paths:expr, $noise:expr) => {{
        let summary: Summary = $summary;
        assert_eq!(
            (summary.failed(), summary.final_states().count()),
            (0, $paths)
        );
        for (path, end) in summary.final_states() {
            let noise: Box<dyn Noise> = $noise(path);
            let mut states = $method.trajectory(start(), H, noise);
            let expected = states.nth(STEPS as usize - 1).unwrap().unwrap();
            assert_eq!(end, expected, "{path}");
        }
    }};
}

macro_rules! check_rule {
    ($rule:expr) => {{
        let method = staged($rule);
        let all = PATHS as usize;
        let wiener = |path| Wiener::new(SEED).path(path);
        let plain = |path| Box::new(wiener(path)) as Box<dyn Noise>;
        assert_equal_paths!(method, ensemble!(&method).run().unwrap(), all, plain);
        let shard = ensemble!(&method).shard(1, 2).run().unwrap();
        assert_equal_paths!(method, shard, 6, plain);

        let later = ensemble!(&method).noise(wiener(5)).run().unwrap();
        assert_equal_paths!(method, later, all, |path| plain(path + 5));

        let pairs = ensemble!(&method).antithetic(true).run().unwrap();
        assert_equal_paths!(method, pairs, all, |path| match path % 2 {
            0 => plain(path / 2),
            _ => Box::new(Mirrored(wiener(path / 2))),
        });

        let clipped = |path| Truncated::new(wiener(path)).deviations(0.8).unwrap();
        let truncated = ensemble!(&method).noise(clipped(0)).run().unwrap();
        assert_equal_paths!(method, truncated, all, |path| Box::new(clipped(path)));

        let still = ensemble!(&method).noise(NoNoise).run().unwrap();
        assert_equal_paths!(method, still, all, |_| Box::new(NoNoise));
    }};
}

#[test]
fn paths_are_trajectories_bit_for_bit() {
    check_rule!(StageNoise(Gauss::<2>));
    check_rule!(StageNoise(Gauss::<3>));
}

#[test]
fn a_replayed_path_has_the_same_bits() {
    let method = staged(StageNoise(Gauss::<3>));
    let ensemble = ensemble!(&method);
    let summary = ensemble.run().unwrap();
    for (path, end) in summary.final_states().step_by(23) {
        let again = ensemble.replay(path).unwrap().last().unwrap().unwrap();
        assert_eq!(end, again);
    }
}

/// The increments at the stages belong to the rule: a shard of the rule without them is of another
/// run.
#[test]
fn shards_know_whether_the_rule_has_stage_noise() {
    let (method, other) = (staged(StageNoise(Gauss::<3>)), staged(Gauss::<3>));
    let [first, second] = [0, 1].map(|k| ensemble!(&method).shard(k, 2).run().unwrap());
    let foreign = ensemble!(&other).shard(1, 2).run().unwrap();
    let mut merged = first;
    assert_says(merged.merge(foreign).unwrap_err(), &["method"]);
    merged.merge(second).unwrap();
    assert_eq!(merged, ensemble!(&method).run().unwrap());
}

/// Level l has the paths from l 2⁴⁸ on. Its coarse steps have the increments at the stages of the
/// same path.
#[test]
fn levels_are_differences_along_common_paths() {
    let method = staged(StageNoise(Gauss::<2>));
    let (h, steps) = (0.4, 3);
    let ensemble = Ensemble::new(&method)
        .paths(64)
        .seed(SEED)
        .steps(h, steps)
        .start(start())
        .observe("q", |_, state| state.q[0]);
    let estimate = ensemble.multilevel("q").run(0.2).unwrap();
    for (level, found) in (0_u32..).zip(estimate.levels()) {
        let (h, steps) = (h / f64::from(1 << level), steps << level);
        let end = |noise: &Recorded, h| {
            let states = method.trajectory(start(), h, noise.clone());
            states.last().unwrap().unwrap().q[0]
        };
        let differences = (0..found.paths).map(|path| {
            let path = Wiener::new(SEED).path((u64::from(level) << 48) + path);
            let fine = Recorded::record_stages(path, h, 2, 2, steps as usize).unwrap();
            let coarse = (level > 0).then(|| end(&fine.coarsen(2).unwrap(), 2.0 * h));
            end(&fine, h) - coarse.unwrap_or(0.0)
        });
        let mean = differences.sum::<f64>() / found.paths as f64;
        assert!(
            (found.mean - mean).abs() < 1e-12,
            "{level} {} {mean}",
            found.mean
        );
    }
}

/// With common noise the differences of means have the error of the differences alone.
#[test]
fn gradients_of_means_are_differences() {
    let mean = |g: f64, sigma: f64, push: f64| {
        let method = Integrator::new(Pendula { g, sigma }, StageNoise(Gauss::<3>));
        let mut start = start();
        start.p[1] += push;
        let summary = ensemble!(&method).start(start).run().unwrap();
        summary["q"].mean()[1]
    };
    let (g, sigma, step) = (2.0, 0.7, 1e-5);
    let slope = |high: f64, low: f64| (high - low) / (2.0 * step);
    let differences = [
        slope(mean(g + step, sigma, 0.0), mean(g - step, sigma, 0.0)),
        slope(mean(g, sigma + step, 0.0), mean(g, sigma - step, 0.0)),
        slope(mean(g, sigma, step), mean(g, sigma, -step)),
    ];
    let method = staged(StageNoise(Gauss::<3>));
    let by = ["g".into(), "sigma".into(), By::p(1)];
    let summary = ensemble!(&method)
        .gradient("end", by.clone(), |state| state.q[0])
        .run()
        .unwrap();
    let slopes = by.map(|by| summary.derivative("end", by).unwrap().mean()[1]);
    assert_close(&slopes, &differences, 1e-7, "gradient");
    assert!(slopes.iter().all(|slope| slope.abs() > 1e-3), "{slopes:?}");
    for (path, end) in summary.final_states() {
        let mut states = method.trajectory(start(), H, Wiener::new(SEED).path(path));
        assert_eq!(end, states.nth(STEPS as usize - 1).unwrap().unwrap());
    }
}

#[test]
fn what_has_no_increments_at_stages_is_refused_before_the_run() {
    let method = staged(StageNoise(Gauss::<3>));
    let refused = |ensemble: Ensemble<'_, Staged>, words: &[&str]| {
        assert_says(ensemble.run().unwrap_err(), words);
    };
    let three = ensemble!(&method).noise(ThreePoint::new(SEED));
    assert_matches!(three.run(), Err(EnsembleError::NoStages { stages: 3, .. }));
    refused(
        three,
        &["increments of three values", "take `Wiener`", "3 stages"],
    );
    let refined = Wiener::new(SEED).refine(2).unwrap();
    refused(
        ensemble!(&method).noise(refined),
        &["a refined path", "take `Wiener`, not refined"],
    );
    let whole = "increments at stages belong to whole steps";
    refused(
        ensemble!(&method).refine(4),
        &["`refine`", "`stage_noise`", whole],
    );
    refused(
        ensemble!(&method).stop_at("low", |_, state| state.q[0]),
        &["`stop_at`", "`stage_noise`", whole],
    );
    refused(
        ensemble!(&method).first_passage("low", |_, state| state.q[0]),
        &["`first_passage`", "`stage_noise`", whole],
    );
}
