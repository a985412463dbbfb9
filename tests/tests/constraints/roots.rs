//! Roots of random long steps against a continuation of their own ([`path`](super::path)), in
//! single steps and in lanes: a step is the end of its path from h → 0 without noise, and beyond
//! the end of the path it is an error.

use sve_models::is_thorough;
use sve_models::random::Random;
use sve_runtime::__private::{ConstraintImpulses, LANES, VectorCoordinates};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::path::{Followed, Scheme, follow};
use super::systems::{Check, conservative, random_states, stepped_in_lanes};

/// Largest distance of a step from the end of its path, which is found with differenced Jacobians.
const ERROR: f64 = 1e-6;

/// Steps of a size, and what became of them.
struct Sampled {
    random: Random,
    /// Largest length of a step without constraints, in lengths of the system, and largest
    /// increment in standard deviations.
    length: f64,
    deviations: f64,
    /// Blocks of lanes for each system and rule, and the lanes of each that are followed.
    blocks: usize,
    followed: usize,
    made: u32,
    in_lanes: u32,
    beyond: u32,
    refused: Vec<String>,
    wrong: Vec<String>,
}

fn scheme(name: &str) -> Scheme {
    match name.split(' ').next_back() {
        Some("initial_point") => Scheme::OneNode(0.0),
        Some("endpoint") => Scheme::OneNode(1.0),
        Some("midpoint") => Scheme::OneNode(0.5),
        Some("stormer_verlet") => Scheme::Trapezoidal,
        _ => panic!("{name}"),
    }
}

impl Check for Sampled {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        for _ in 0..self.blocks {
            let states = random_states(integrator, start, [0.5, 2.0], &mut self.random);
            let speeds = states.iter().map(|state| {
                let v = Q::components(&integrator.system().drift(state).unwrap().q);
                v.iter().map(|v| v * v).sum::<f64>().sqrt()
            });
            let speed = speeds.fold(1.0, f64::max);
            let h = self.random.uniform(0.2, 1.0) * self.length / speed;
            let size = self.deviations * h.sqrt();
            let dw: [[f64; LANES]; M] = core::array::from_fn(|_| {
                core::array::from_fn(|_| self.random.uniform(-size, size))
            });
            let (ends, left) = stepped_in_lanes(integrator, &states, h, &dw);
            for (lane, state) in states.iter().enumerate().take(self.followed) {
                let dw = dw.map(|row| row[lane]);
                let mut end = *state;
                let single = integrator.step(&mut end, h, &dw);
                let lane_end = (left >> lane & 1 == 0).then(|| ends[lane]);
                let what = || format!("{name}: h = {h}, dw = {dw:?} from {state:?}");
                match follow(integrator.system(), scheme(name), state, h, &dw) {
                    Followed::Whole(d) => {
                        let q = state.q.coordinates();
                        let is_end = |end: &State<Q>| {
                            let end = end.q.coordinates();
                            (0..N).all(|i| (end[i] - q[i] - d[i]).abs() < ERROR)
                        };
                        match single {
                            Ok(()) if is_end(&end) => self.made += 1,
                            Ok(()) => self.wrong.push(what()),
                            Err(error) => self.refused.push(format!("{}: {error}", what())),
                        }
                        if let Some(end) = lane_end {
                            self.in_lanes += 1;
                            if !is_end(&end) {
                                self.wrong.push(format!("in a lane, {}", what()));
                            }
                        }
                    }
                    Followed::Ends(at) => {
                        self.beyond += 1;
                        if single.is_ok() || lane_end.is_some() {
                            self.wrong.push(format!("beyond {at:?}, {}", what()));
                        }
                    }
                    Followed::Unknown => panic!("{}", what()),
                }
            }
        }
    }
}

fn sampled(seed: u64, length: f64, deviations: f64) -> Sampled {
    let (blocks, followed) = if is_thorough() { (250, LANES) } else { (1, 2) };
    let mut sampled = Sampled {
        random: Random::new(seed),
        length,
        deviations,
        blocks,
        followed,
        made: 0,
        in_lanes: 0,
        beyond: 0,
        refused: Vec::new(),
        wrong: Vec::new(),
    };
    conservative(&mut sampled);
    println!(
        "lengths up to {length}, {deviations} deviations: {} steps made, {} in lanes, {} beyond the end of their paths, {} refused",
        sampled.made,
        sampled.in_lanes,
        sampled.beyond,
        sampled.refused.len()
    );
    for refused in sampled.refused.iter().take(5) {
        println!("{refused}");
    }
    assert!(sampled.wrong.is_empty(), "{:#?}", sampled.wrong);
    sampled
}

/// Steps up to a third of the lengths of the systems, with increments of three standard deviations.
#[test]
fn ordinary_steps_have_the_root_of_their_path() {
    let sampled = sampled(31, 0.3, 3.0);
    let refused = sampled.refused.len() as u32;
    assert!(20 * (refused + sampled.beyond) < sampled.made, "{refused}");
    assert!(2 * sampled.in_lanes > sampled.made, "{}", sampled.in_lanes);
}

/// Steps up to twice the lengths of the systems, in which the fastest path of each block moves that
/// far: many are beyond the ends of their paths.
#[test]
fn long_steps_have_the_root_of_their_path_or_none() {
    let sampled = sampled(32, 2.0, 3.0);
    assert!(50 * sampled.beyond > sampled.made, "{}", sampled.beyond);
    let refused = sampled.refused.len() as u32;
    assert!(10 * refused < sampled.made, "{refused}");
}
