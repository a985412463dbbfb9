//! Steps on demand, for programs that compare their own steps with them in turn: see
//! `examples/peers/scenes.py`.

use std::error::Error;
use std::io::{BufRead, Write, stdin, stdout};

use sve_runtime::Trajectory;
use sve_runtime::prelude::*;
use sve_runtime::system::AnySystem;

use crate::measure::now;
use crate::scenes::{self, BETA, Chain};

/// Makes as many steps as each line of the standard input says. Answers with the time of the
/// processor in seconds, the energy, and the coordinate a third of the way along.
///
/// # Errors
/// If `words`, which are the system, the number of coordinates and the step, have another form, or
/// a step fails.
pub(crate) fn serve(words: &[String]) -> Result<(), Box<dyn Error>> {
    let [system, n, h] = words else {
        return Err("expected a system, a number of coordinates and a step".into());
    };
    let (n, h): (usize, f64) = (n.parse()?, h.parse()?);
    let start = scenes::sites(n);
    match system.as_str() {
        "chain" => {
            let chain = Integrator::new(Chain { beta: BETA }, StormerVerlet);
            let path = chain.trajectory(start, h, NoNoise);
            answer(path, |state| chain.system().hamiltonian(state))
        }
        "lattice" => {
            let lattice = Integrator::new(scenes::lattice(n), StormerVerlet);
            let path = lattice.trajectory(start, h, NoNoise);
            answer(path, |state| lattice.system().hamiltonian(state))
        }
        other => Err(format!("no system {other}: chain, lattice").into()),
    }
}

fn answer<M>(
    mut path: Trajectory<'_, M, NoNoise>,
    energy: impl Fn(&State<Vec<f64>>) -> Result<f64, StepError>,
) -> Result<(), Box<dyn Error>>
where
    M: OneStepMethod,
    M::System: AnySystem<Configuration = Vec<f64>>,
{
    for line in stdin().lock().lines() {
        let steps = line?.trim().parse()?;
        let start = now();
        let state = path.advance(steps)?;
        let seconds = now() - start;
        let (energy, q) = (energy(state)?, state.q[state.q.len() / 3]);
        println!("{seconds:.9} {energy:.17e} {q:.17e}");
        stdout().flush()?;
    }
    Ok(())
}
