//! Ends on demand, for programs that compare their own times and errors with them in turn: see
//! `examples/peers/peer_sve.py`.
//!
//! A line of the standard input is a system, a method, its setting, how many times the path is
//! solved, the horizon, and the start (q, p). The answer is the time of the processor in seconds
//! for all times together, the number of steps of a path, and its end (q, p).

use std::error::Error;
use std::fmt::Write as _;
use std::io::{BufRead, Write, stdin, stdout};

use sve_runtime::prelude::*;
use sve_runtime::{Configuration, Mechanics};

use crate::measure::now;
use crate::planets;
use crate::systems::{DoublePendulum, Kepler, OuterSolarSystem, Pendulum, QuietHenonHeiles};
use crate::timed::{
    ThreeBodies, TimedDoublePendulum, TimedKepler, TimedPendulum, TimedThreeBodies,
};

const GRAVITY: f64 = 9.8;

/// The masses of the Pythagorean problem.
const MASSES: [f64; 3] = [3.0, 4.0, 5.0];

/// The size of the first step that a path with a tolerance tries, as a fraction of the horizon.
const FIRST_STEP: f64 = 1e-4;

/// Returns the number of steps of a path and its only saved state.
macro_rules! end {
    ($path:expr) => {{
        let mut path = $path;
        let end = path.next().expect("a state at the horizon")?;
        Ok((path.step(), end))
    }};
}

type Answer = Result<String, Box<dyn Error>>;

/// Answers each line of the standard input, with `failed` and the reason if a path fails.
pub(crate) fn serve() -> Result<(), Box<dyn Error>> {
    for line in stdin().lock().lines() {
        match answer(&line?) {
            Ok(text) => println!("{text}"),
            Err(error) => println!("failed: {error}"),
        }
        stdout().flush()?;
    }
    Ok(())
}

/// Solves a task with equal steps of t, with and without compensated sums, or with a tolerance.
macro_rules! in_t {
    ($task:expr, $system:expr) => {{
        let (task, method) = (&$task, Integrator::new($system, Gauss::<8>));
        let steps = (task.horizon / task.setting).round();
        let (h, count) = (task.horizon / steps, whole(steps));
        let path = |h| method.trajectory(task.state(), h, NoNoise);
        match task.method {
            "fixed" => task.timed(|| Ok((count, *path(h).advance(count)?))),
            "compensated" => task.timed(|| Ok((count, *path(h).compensated().advance(count)?))),
            "tolerance" => task.timed(|| {
                let path = path(FIRST_STEP * task.horizon).tolerance(task.setting);
                end!(path.at([task.horizon]))
            }),
            other => Err(format!("no method {other}").into()),
        }
    }};
}

/// Solves a task with equal steps of the time τ of a time scale, or with a tolerance.
macro_rules! in_tau {
    ($task:expr, $system:expr) => {{
        let (task, method) = (&$task, Integrator::new($system, Gauss::<8>));
        let path = |h| {
            let start = TimedState::of(method.system(), task.state())?;
            Ok::<_, StepError>(method.trajectory(start, h, NoNoise))
        };
        match task.method {
            "time_scale" => task.timed(|| end!(path(task.setting)?.at([task.horizon]))),
            "time_scale_tolerance" => task.timed(|| {
                let path = path(FIRST_STEP * task.horizon)?.tolerance(task.setting);
                end!(path.at([task.horizon]))
            }),
            other => Err(format!("no method {other}").into()),
        }
    }};
}

/// Solves the task of a line, in the time t or in that of the system's time scale.
fn answer(line: &str) -> Answer {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [system, method, numbers @ ..] = &words[..] else {
        return Err("expected a system and a method".into());
    };
    let numbers = numbers.iter().map(|word| word.parse());
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
    let [setting, times, horizon, start @ ..] = &numbers[..] else {
        return Err("expected a setting, a number of times, a horizon and a start".into());
    };
    let task = Task {
        method,
        setting: *setting,
        times: *times,
        horizon: *horizon,
        start: start.to_vec(),
    };
    match (*system, method.starts_with("time_scale")) {
        ("pendulum", false) => in_t!(task, Pendulum { g: GRAVITY }),
        ("pendulum", true) => {
            let energy = Pendulum { g: GRAVITY }.hamiltonian(&task.state())?;
            in_tau!(task, TimedPendulum { g: GRAVITY, energy })
        }
        ("double_pendulum", false) => in_t!(task, DoublePendulum { g: GRAVITY }),
        ("double_pendulum", true) => {
            let energy = DoublePendulum { g: GRAVITY }.hamiltonian(&task.state())?;
            in_tau!(task, TimedDoublePendulum { g: GRAVITY, energy })
        }
        ("kepler", false) => in_t!(task, Kepler { k: 1.0 }),
        ("kepler", true) => in_tau!(task, TimedKepler),
        ("three_bodies", false) => in_t!(task, ThreeBodies { masses: MASSES }),
        ("three_bodies", true) => in_tau!(task, TimedThreeBodies { masses: MASSES }),
        ("quiet_henon_heiles", false) => in_t!(task, QuietHenonHeiles),
        ("outer_solar_system", false) => {
            let (gravity, masses) = (planets::GRAVITY, planets::MASSES);
            in_t!(task, OuterSolarSystem { gravity, masses })
        }
        (other, _) => Err(format!("no system {other} with the method {method}").into()),
    }
}

#[allow(clippy::cast_sign_loss)] // a number of steps or of times is not negative
fn whole(number: f64) -> u64 {
    number.round() as u64
}

/// A path to solve so many times.
struct Task<'a> {
    method: &'a str,
    /// A tolerance, or the size of a step.
    setting: f64,
    times: f64,
    horizon: f64,
    /// Coordinates, then momenta.
    start: Vec<f64>,
}

impl Task<'_> {
    fn state<Q: Configuration<Momentum = Q> + Default>(&self) -> State<Q> {
        let (mut q, mut p) = (Q::default(), Q::default());
        let (places, momenta) = self.start.split_at(self.start.len() / 2);
        q.restore(places);
        p.restore(momenta);
        State::new(q, p)
    }

    /// Solves the path so many times; `solve` returns its number of steps and its end.
    fn timed<Q: Configuration<Momentum = Q>>(
        &self,
        solve: impl Fn() -> Result<(u64, State<Q>), StepError>,
    ) -> Answer {
        let begin = now();
        let mut solved = solve()?;
        for _ in 1..whole(self.times) {
            solved = solve()?;
        }
        let seconds = now() - begin;
        let (steps, end) = solved;
        let mut values = vec![0.0; self.start.len()];
        let (places, momenta) = values.split_at_mut(self.start.len() / 2);
        end.q.store(places);
        end.p.store(momenta);
        let mut text = format!("{seconds:.9} {steps}");
        for value in values {
            write!(text, " {value:.17e}")?;
        }
        Ok(text)
    }
}
