//! A kind of systems by hand, whose number of sites is that of the state: what the macro prints for
//! scenes can be written, with increments whose number the compiler does not know.

use std::cell::Cell;
use std::sync::OnceLock;

use sve_runtime::__private::{
    AnySystem, Kind, Mode, Names, Plan, Shear, StepShear, Steps, Walker, shears,
};
use sve_runtime::Rule;
use sve_runtime::noise::NoiseError;
use sve_runtime::prelude::*;

use super::scenes::Chain;

/// Tables that are made at the first step.
type Tables = OnceLock<()>;

/// Oscillators of the stiffness `k`, each pushed by a noise of its own.
struct Oscillators {
    k: f64,
    /// The numbers of tables, of single steps, of steps in blocks and of blocks that were made.
    counts: [Cell<u64>; 4],
}

impl AnySystem for Oscillators {
    type Configuration = Vec<f64>;
    type Target = Self;
    type Stepped = Self;
    type Kind = Counted;
    type StateLanes = ();
    const NAMES: Names = Names {
        parameters: &["k"],
        coordinates: &["q"],
        momenta: &["p"],
    };
    const FORMULAS_HASH: u64 = 1;

    fn target(&self) -> &Self {
        self
    }

    fn visit_parameters(&self, visit: &mut dyn FnMut(f64)) {
        visit(self.k);
    }
}

impl Rule<Oscillators> for Endpoint {
    type Increments = [f64];
    type Prepared = ();
    type Memory = ();
    const STAGES: usize = 1;
    const SUBSTEPS: usize = 1;
    const PLAN: &'static Plan = <Endpoint as Rule<Chain>>::PLAN;
    const HAS_INCREMENTS: bool = false;

    fn prepare(_: &Oscillators, _: f64) {}

    fn walk<M: Mode<Oscillators, [f64]>>(
        _: Walker<'_, Oscillators, Self>,
        (): &(),
        (): &mut (),
        h: f64,
        dw: &M::Increments,
        mode: &mut M,
    ) -> Result<(), M::Failure> {
        mode.shears(&[Shear::Drift(1.0), Shear::Kick(1.0)], h, dw)
    }
}

impl Oscillators {
    fn count(&self, of: usize, number: u64) {
        self.counts[of].update(|count| count + number);
    }

    fn make_tables(&self, tables: &Tables) {
        tables.get_or_init(|| self.count(0, 1));
    }

    fn step(&self, shears: &[StepShear], state: &mut State<Vec<f64>>, dw: &[f64]) {
        for shear in shears {
            for ((q, p), dw) in state.q.iter_mut().zip(&mut state.p).zip(dw) {
                match shear {
                    StepShear::Drift { h, .. } => *q += h * *p,
                    StepShear::Kick { h, part, .. } => *p += part * dw - h * self.k * *q,
                    StepShear::Midpoint { .. } => unreachable!("the rule is a list of shears"),
                }
            }
        }
    }
}

/// The kind of systems that count what is made.
struct Counted;

impl Kind for Counted {
    type Cache = Tables;
}

impl<R: Rule<Oscillators, Increments = [f64]>> Steps<Oscillators, R> for Counted {
    type Prepared = Vec<StepShear>;

    fn prepare(walker: Walker<'_, Oscillators, R>, _: &Tables, h: f64) -> Vec<StepShear> {
        let mut all = Vec::new();
        shears(walker, &R::prepare(walker.system, h), h, &mut all);
        all
    }

    fn step(
        walker: Walker<'_, Oscillators, R>,
        tables: &Tables,
        prepared: &Vec<StepShear>,
        state: &mut State<Vec<f64>>,
        h: f64,
        dw: &[f64],
    ) -> Result<(), StepError> {
        walker.system.make_tables(tables);
        walker.system.count(1, 1);
        walker.system.step(prepared, state, dw);
        state.t += h;
        Ok(())
    }

    fn next_step(
        walker: Walker<'_, Oscillators, R>,
        tables: &Tables,
        prepared: &mut Vec<StepShear>,
        state: &mut State<Vec<f64>>,
        h: f64,
        dw: &[f64],
    ) -> Result<(), StepError> {
        Self::step(walker, tables, prepared, state, h, dw)
    }

    /// Makes blocks of up to 16 steps.
    fn next_steps(
        walker: Walker<'_, Oscillators, R>,
        tables: &Tables,
        prepared: &mut Vec<StepShear>,
        state: &mut State<Vec<f64>>,
        _: f64,
        dw: &mut [f64],
        steps: u64,
        draw: &mut dyn FnMut(u64, &mut [f64]) -> Option<f64>,
    ) -> u64 {
        walker.system.make_tables(tables);
        let mut made = 0;
        while made < steps.min(16)
            && let Some(end) = draw(made, dw)
        {
            walker.system.step(prepared, state, dw);
            state.t = end;
            made += 1;
        }
        walker.system.count(2, made);
        walker.system.count(3, 1);
        made
    }

    fn processes(
        _: Walker<'_, Oscillators, R>,
        _: &Tables,
        state: &State<Vec<f64>>,
    ) -> Result<usize, StepError> {
        Ok(state.q.len())
    }
}

/// Draws that follow one another, so that no step can be repeated.
struct Draws(f64);

impl Noise for Draws {
    fn increments(&mut self, _: u64, _: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        for dw in dw {
            self.0 = (self.0 * 1.7 + 0.1).fract();
            *dw = 0.1 * (self.0 - 0.5);
        }
        Ok(())
    }
}

fn oscillators() -> Integrator<Oscillators, Endpoint> {
    let counts = [const { Cell::new(0) }; 4];
    Integrator::new(Oscillators { k: 2.0, counts }, Endpoint)
}

fn start() -> State<Vec<f64>> {
    State::new(vec![1.0, 2.0, -0.5], vec![0.5, -1.0, 0.25])
}

#[test]
fn a_step_by_hand() {
    let mut state = start();
    oscillators()
        .step(&mut state, 0.5, &[0.25, -0.5, 0.0])
        .unwrap();
    let end = State::at(0.5, vec![1.25, 1.5, -0.375], vec![-0.5, -3.0, 0.625]);
    assert_eq!(state, end);
}

#[test]
fn only_replayable_increments_are_drawn_for_many_steps() {
    fn end(integrator: &Integrator<Oscillators, Endpoint>, noise: impl Noise) -> State<Vec<f64>> {
        let mut path = integrator.trajectory(start(), 0.05, noise);
        path.advance(50).unwrap().clone()
    }
    let single = oscillators();
    let last = end(&single, Draws(0.3));
    let counts = |of: &Integrator<Oscillators, _>| of.system().counts.each_ref().map(Cell::take);
    assert_eq!(counts(&single), [1, 50, 0, 0]);
    let states = single.trajectory(start(), 0.05, Draws(0.3));
    assert_eq!(states.take(50).last().unwrap().unwrap(), last);
    // four blocks of 16, 16, 16 and 2 steps
    let mut integrator = oscillators();
    end(&integrator, NoNoise);
    assert_eq!(counts(&integrator), [1, 0, 50, 4]);
    // tables stay until the system changes
    end(&integrator, NoNoise);
    assert_eq!(counts(&integrator), [0, 0, 50, 4]);
    integrator.system_mut().k = 1.0;
    end(&integrator, NoNoise);
    assert_eq!(counts(&integrator), [1, 0, 50, 4]);
}
