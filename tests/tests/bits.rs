//! The bits of steps, lanes, tangent maps, noise and ensembles: every rule of every model against
//! `tests/data/bits.txt`.
//!
//! The file changes only with a change that is meant to change numbers. Such a change writes the
//! file again, with the environment variable `WRITE_BITS` set, and gives its reason in the
//! changelog. Models that call functions of the platform's library are compared only if these
//! functions have the bits of the platform on which the file was written. Noise and lanes have the
//! same bits everywhere.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use sve_models::case::{Case, Derivatives};
use sve_models::functions::Point;
use sve_models::oracle::{cases, kubo, pendulum};
use sve_models::random::Random;
use sve_runtime::__private::LANES;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// FNV-1a of 64 bits.
struct Hash(u64);

impl Hash {
    const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn number(&mut self, x: f64) {
        for byte in x.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn numbers<'a>(&mut self, all: impl IntoIterator<Item = &'a f64>) {
        all.into_iter().for_each(|&x| self.number(x));
    }

    fn state(&mut self, state: &Point) {
        self.number(state.t);
        self.numbers(state.entries());
    }
}

/// Steps of several sizes along short paths; their tangent maps and sensitivities; trajectories,
/// which may carry numbers from step to step.
fn single(case: &dyn Case) -> [u64; 3] {
    let mut random = Random::new(5);
    let (mut hash, mut tangents, mut along) = (Hash::new(), Hash::new(), Hash::new());
    let (model, noises) = (case.model(), case.dimensions().1);
    for h in [1e-3, 0.05, 0.2] {
        for _ in 0..8 {
            let mut state = model.point(&mut random);
            for _ in 0..4 {
                let dw = random.vector(noises, -0.3, 0.3);
                match case.differentiated(&mut state, h, &dw) {
                    Ok(Derivatives {
                        tangent,
                        sensitivity,
                        ..
                    }) => {
                        for row in &tangent {
                            tangents.numbers(row);
                        }
                        for (_, derivative) in &sensitivity {
                            tangents.numbers(derivative);
                        }
                    }
                    Err(_) => tangents.number(f64::NAN),
                }
                hash.state(&state);
            }
            let path = case.trajectory(&state, h, Box::new(Wiener::new(3)));
            for state in path.take(10) {
                match state {
                    Ok(state) => along.state(&state),
                    Err(_) => along.number(f64::NAN),
                }
            }
        }
    }
    [hash.0, tangents.0, along.0]
}

/// Steps of all lanes at once.
fn lanes(case: &dyn Case) -> u64 {
    let (mut random, mut hash) = (Random::new(6), Hash::new());
    let (model, noises) = (case.model(), case.dimensions().1);
    for h in [1e-3, 0.05, 0.2] {
        let lane = |_| (model.point(&mut random), random.vector(noises, -0.3, 0.3));
        let (states, dw): (Vec<_>, Vec<_>) = (0..LANES).map(lane).unzip();
        let Ok((next, left)) = case.step_lanes(&states, h, &dw) else {
            continue;
        };
        hash.number(f64::from_bits(u64::from(left)));
        for state in &next {
            hash.numbers(state.entries());
        }
    }
    hash.0
}

/// Increments of every source.
fn noise() -> BTreeMap<String, u64> {
    fn draws<W: Noise>(mut source: W) -> u64 {
        let mut hash = Hash::new();
        let mut dw = [0.0; 3];
        for step in 0..200 {
            source.increments(step, 0.01, &mut dw).expect("increments");
            hash.numbers(&dw);
        }
        hash.0
    }
    BTreeMap::from([
        ("noise, Wiener".to_owned(), draws(Wiener::new(9))),
        (
            "noise, path 7 of Wiener".to_owned(),
            draws(Wiener::new(9).path(7)),
        ),
        (
            "noise, refined Wiener".to_owned(),
            draws(Wiener::new(9).refine(2).expect("a refinement")),
        ),
        ("noise, ThreePoint".to_owned(), draws(ThreePoint::new(9))),
        (
            "noise, Truncated".to_owned(),
            draws(Truncated::new(Wiener::new(9))),
        ),
    ])
}

/// Statistics of ensembles, with their final states.
fn ensembles() -> BTreeMap<String, u64> {
    fn hashed<S, R, const N: usize, const M: usize>(integrator: &Integrator<S, R>) -> u64
    where
        S: System<Dims = Dims<N, M>> + Variational<R> + Sync,
        R: Sync,
    {
        let summary = Ensemble::new(integrator)
            .paths(150)
            .seed(4)
            .steps(0.02, 60)
            .every(20)
            .start(State::new([0.7; N], [0.2; N]))
            .observe("q", |_: &S, state: &State<[f64; N]>| state.q[0])
            .keep_final_states(true)
            .run()
            .expect("an ensemble");
        let mut hash = Hash::new();
        for s in summary.statistics() {
            hash.numbers(
                s.mean()
                    .iter()
                    .chain(&s.variance())
                    .chain(s.min())
                    .chain(s.max()),
            );
        }
        for (_, state) in summary.final_states() {
            hash.numbers(state.q.iter().chain(state.p));
        }
        hash.0
    }
    BTreeMap::from([
        (
            "ensemble, Kubo by midpoint".to_owned(),
            hashed(&Integrator::new(kubo(), Midpoint)),
        ),
        (
            "ensemble, Pendulum by midpoint".to_owned(),
            hashed(&Integrator::new(pendulum(), Midpoint)),
        ),
    ])
}

/// Functions of the platform's library.
fn library() -> u64 {
    let mut hash = Hash::new();
    for i in 1..2000 {
        let x = f64::from(i) * 0.001_37;
        hash.numbers(&[
            x.sin(),
            x.cos(),
            x.exp(),
            x.ln(),
            x.tan(),
            x.atan(),
            x.tanh(),
            x.cbrt(),
        ]);
        hash.numbers(&[
            x.sinh(),
            x.cosh(),
            x.ln_1p(),
            x.exp_m1(),
            x.powf(1.3),
            (x * 30.0).sin(),
            (x * 30.0).cos(),
        ]);
    }
    hash.0
}

/// A pendulum, with steps of second order.
struct Swing {
    g: f64,
}

#[variational(gauss(2), gauss(4), gauss(8))]
impl Swing {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// Two pendula, one at the other, with masses that depend on the angles.
struct Arms {
    g: f64,
}

#[variational(gauss(2), gauss(4), gauss(8))]
impl Arms {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + self.g * (2.0 * q[0].cos() + q[1].cos())
    }
}

/// A pendulum with noises in its momentum and in its position.
struct Shaken {
    s: f64,
}

#[variational(gauss(2), gauss(4), gauss(8))]
impl Shaken {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.s * q.sin()
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        self.s * (q * q + p * p)
    }
}

/// Steps, tangent maps and trajectories of a system by a Gauss rule.
fn gauss<S, R, const N: usize, const M: usize>(system: S, rule: R) -> [(String, u64); 3]
where
    S: System<Dims = Dims<N, M>> + Variational<R>,
    R: Copy,
{
    let integrator = Integrator::new(system, rule);
    let mut random = Random::new(5);
    let mut hashes = [const { Hash::new() }; 3];
    let [steps, tangents, along] = &mut hashes;
    for h in [1e-3, 0.05, 0.2] {
        let mut state = State::at(0.3, random.array(-1.0, 1.0), random.array(-1.0, 1.0));
        for _ in 0..4 {
            let dw = random.array(-0.3, 0.3);
            let derivatives = integrator.step_with_derivatives(&mut state.clone(), h, &dw);
            let (tangent, sensitivity) = derivatives.expect("derivatives");
            (0..2 * N).for_each(|row| tangents.numbers(&tangent[row]));
            for (_, derivative) in sensitivity.iter() {
                tangents.numbers(derivative.q.iter().chain(&derivative.p));
            }
            integrator.step(&mut state, h, &dw).expect("a step");
            steps.numbers(state.q.iter().chain(&state.p));
        }
        let path = integrator.trajectory(state, h, Wiener::new(3));
        for state in path.take(10) {
            let state = state.expect("a step");
            along.numbers(state.q.iter().chain(&state.p));
        }
    }
    let plan = integrator.plan();
    let name = |what: &str| format!("{} by {}, {what}", plan.system, plan.rule);
    let names = ["single steps", "tangent maps", "trajectories"].map(name);
    std::array::from_fn(|k| (names[k].clone(), hashes[k].0))
}

const LIBRARY: &str = "functions of the platform's library";

fn measured() -> BTreeMap<String, u64> {
    let mut lines = BTreeMap::new();
    for case in cases() {
        let name = case.name();
        let [steps, tangents, along] = single(&*case);
        lines.insert(format!("{name}, single steps"), steps);
        lines.insert(format!("{name}, tangent maps"), tangents);
        lines.insert(format!("{name}, trajectories"), along);
        lines.insert(format!("{name}, lanes"), lanes(&*case));
    }
    macro_rules! add {
        ($system:expr) => {
            lines.extend(gauss($system, Gauss::<2>));
            lines.extend(gauss($system, Gauss::<4>));
            lines.extend(gauss($system, Gauss::<8>));
        };
    }
    add!(Swing { g: 9.8 });
    add!(Arms { g: 9.8 });
    add!(Shaken { s: 0.2 });
    lines.extend(noise());
    lines.extend(ensembles());
    lines.insert(LIBRARY.to_owned(), library());
    lines
}

#[test]
fn bits_are_those_of_the_file() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/bits.txt");
    let measured = measured();
    if std::env::var_os("WRITE_BITS").is_some() {
        let mut text = String::new();
        for (name, hash) in &measured {
            writeln!(text, "{hash:016x} {name}").expect("a line");
        }
        std::fs::write(&path, text).expect("the file is written");
    }
    let text = std::fs::read_to_string(&path).expect("the file of bits");
    let lines = text
        .lines()
        .map(|line| line.split_once(' ').expect("a hash and a name"));
    let stored: BTreeMap<&str, u64> = lines
        .map(|(hash, name)| (name, u64::from_str_radix(hash, 16).expect("a hash")))
        .collect();
    let same_library = stored[LIBRARY] == measured[LIBRARY];
    for (name, hash) in &measured {
        if name.starts_with("noise") || same_library {
            assert_eq!(
                stored.get(name.as_str()),
                Some(hash),
                "the bits of {name} changed"
            );
        }
    }
}
