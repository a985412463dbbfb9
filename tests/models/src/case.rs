//! Every model with every rule behind one object-safe trait. A test over all of them is compiled
//! once instead of once for each model, and each step is compiled once for all tests.

use sve_runtime::__private::Unstructured;
use sve_runtime::__private::lane::{LaneDirections, TangentLanes};
use sve_runtime::__private::{Differentiable, LANES, Lane, Mask, StateLanes};
use sve_runtime::noise::Noise;
use sve_runtime::prelude::*;
use sve_runtime::{Dual, Plan, Variational};

use crate::functions::{Functions, Matrix, Point, TypedModel, Vector, array};
use crate::oracle::{Model, Nodes, Rule};

/// The derivatives of a step.
pub struct Derivatives {
    /// The tangent map.
    pub tangent: Matrix,
    /// Largest entry of `MᵀΩM − Ω`, from the tangent map.
    pub defect: f64,
    /// The derivatives of (q, p) by each parameter.
    pub sensitivity: Vec<(&'static str, Vector)>,
}

/// The states after a step in lanes with tangent vectors.
pub struct LaneTangents {
    /// The states.
    pub states: Vec<Point>,
    /// The lanes that were not solved.
    pub unsolved: Mask,
    /// The lanes whose vectors are invalid.
    pub unfinished: Mask,
    /// The vectors of each lane: along each coordinate, each momentum and each parameter.
    pub vectors: Vec<Matrix>,
}

/// A loss as a function of the number of a state, its coordinates and its momenta.
pub type Loss<'a> = dyn Fn(u64, &[Dual], &[Dual]) -> Option<Dual> + 'a;

/// A loss with its derivatives by (q, p) at the start and by each parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct LossGradient {
    /// The loss.
    pub loss: f64,
    /// Derivatives by (q, p) at the start.
    pub start: Vector,
    /// Derivatives by each parameter.
    pub parameters: Vector,
}

/// Runs some steps without allocating; see [`Case::watched`].
pub type Watch<'a> = dyn FnMut(&mut dyn FnMut()) + 'a;

/// A path of states or its first error.
pub type Path<'a> = Box<dyn Iterator<Item = Result<Point, StepError>> + 'a>;

/// Advances a state by increments.
pub type Step<'a> = Box<dyn Fn(&mut Point, &[f64]) -> Result<(), StepError> + 'a>;

/// A model with a rule.
pub trait Case {
    /// Returns the plan of the step.
    fn plan(&self) -> &'static Plan;
    /// Returns the plan of the step without structure.
    fn plan_without_structure(&self) -> &'static Plan;
    /// Returns the name of the rule in the attribute.
    fn rule(&self) -> &'static str;
    /// Returns the nodes of the rule.
    fn nodes(&self) -> Nodes;
    /// Returns the numbers of coordinates and of noises.
    fn dimensions(&self) -> (usize, usize);
    /// Returns the model.
    fn model(&self) -> Box<dyn Functions + '_>;
    /// Makes one step.
    ///
    /// # Errors
    /// The error of the step.
    fn step(&self, state: &mut Point, h: f64, dw: &[f64]) -> Result<(), StepError>;
    /// Makes one step of the rule derived without its structure.
    ///
    /// # Errors
    /// The error of the step.
    fn step_without_structure(
        &self,
        state: &mut Point,
        h: f64,
        dw: &[f64],
    ) -> Result<(), StepError>;
    /// Returns steps of one size that was prepared once.
    ///
    /// # Errors
    /// The error of the step size.
    fn prepared(&self, h: f64) -> Result<Step<'_>, StepError>;
    /// Makes one step and returns its derivatives.
    ///
    /// # Errors
    /// The error of the step.
    fn differentiated(
        &self,
        state: &mut Point,
        h: f64,
        dw: &[f64],
    ) -> Result<Derivatives, StepError>;
    /// Returns the derivatives of a loss along so many steps with the noise of a seed, by the
    /// discrete adjoint with so many checkpoints.
    ///
    /// # Errors
    /// The error of a step.
    fn gradient(
        &self,
        start: &Point,
        h: f64,
        steps: [u64; 2],
        seed: u64,
        loss: &Loss<'_>,
    ) -> Result<LossGradient, StepError>;
    /// Steps a state in each lane. Returns the mask of the lanes that were not solved.
    ///
    /// # Errors
    /// The error of the step size.
    fn step_lanes(
        &self,
        states: &[Point],
        h: f64,
        dw: &[Vector],
    ) -> Result<(Vec<Point>, Mask), StepError>;
    /// Steps a state in each lane, with the tangent vectors along each coordinate, each momentum
    /// and each parameter.
    ///
    /// # Errors
    /// The error of the step size.
    fn tangents_in_lanes(
        &self,
        states: &[Point],
        h: f64,
        dw: &[Vector],
    ) -> Result<LaneTangents, StepError>;
    /// Returns the energy of a state in each lane, from the loop over lanes and from the function
    /// of a single state.
    fn energies(&self, states: &[Point]) -> Vec<[f64; 2]>;
    /// Returns the states of a trajectory.
    fn trajectory<'a>(&'a self, start: &Point, h: f64, noise: Box<dyn Noise + 'a>) -> Path<'a>;
    /// Returns a trajectory after some steps as JSON. Reads it back once.
    fn stored(&self, start: &Point, h: f64, noise: Wiener, steps: usize) -> String;
    /// Reads a stored trajectory. Returns the number of its steps, and its continuation.
    fn continued<'a>(&'a self, stored: &str, noise: Wiener) -> (u64, Path<'a>);
    /// Makes steps with the same increments inside of `watch`.
    fn watched(&self, start: &Point, h: f64, dw: &[f64], steps: usize, watch: &mut Watch<'_>);

    /// Returns a name such as `Pendulum by midpoint`, for messages.
    fn name(&self) -> String {
        let plan = self.plan();
        format!("{} by {}", plan.system, plan.rule)
    }

    /// Makes one step from a copy of a state.
    ///
    /// # Panics
    /// If the step fails.
    fn stepped(&self, start: &Point, h: f64, dw: &[f64]) -> Point {
        let mut state = start.clone();
        if let Err(error) = self.step(&mut state, h, dw) {
            panic!("{} from {start:?}: {error}", self.name());
        }
        state
    }
}

/// An integrator with its numbers of coordinates and of noises.
struct TypedCase<S: sve_runtime::system::System, R, const N: usize, const M: usize>(
    Integrator<S, R>,
);

/// Returns the case of a model and a rule.
pub(crate) fn case<S, R, const N: usize, const M: usize>(system: S, rule: R) -> Box<dyn Case>
where
    S: Model<N, M> + Variational<R> + Variational<Unstructured<R>> + Clone + 'static,
    R: Rule + Copy + 'static,
{
    Box::new(TypedCase(Integrator::new(system, rule)))
}

/// Returns states and increments in lanes.
fn in_lanes<const N: usize, const M: usize>(
    states: &[Point],
    dw: &[Vector],
) -> (StateLanes<N>, [Lane; M]) {
    let mut typed = StateLanes::splat(&State::new([0.0; N], [0.0; N]));
    let mut increments: [Lane; M] = [[0.0; LANES]; M];
    for lane in 0..LANES {
        typed.set(lane, &states[lane].state());
        for i in 0..M {
            increments[i][lane] = dw[lane][i];
        }
    }
    (typed, increments)
}

fn path<'a, const N: usize>(
    states: impl Iterator<Item = Result<State<[f64; N]>, StepError>> + 'a,
) -> Path<'a> {
    Box::new(states.map(|state| state.map(|state| Point::of(&state))))
}

impl<S, R, const N: usize, const M: usize> Case for TypedCase<S, R, N, M>
where
    S: Model<N, M> + Variational<R> + Variational<Unstructured<R>> + Clone + 'static,
    R: Rule + Copy + 'static,
{
    fn plan(&self) -> &'static Plan {
        self.0.plan()
    }

    fn plan_without_structure(&self) -> &'static Plan {
        <Unstructured<R> as sve_runtime::Rule<S::Itself>>::PLAN
    }

    fn rule(&self) -> &'static str {
        R::NAME
    }

    fn nodes(&self) -> Nodes {
        R::NODES
    }

    fn dimensions(&self) -> (usize, usize) {
        (N, M)
    }

    fn model(&self) -> Box<dyn Functions + '_> {
        Box::new(TypedModel::<S, N, M>(self.0.system()))
    }

    fn step(&self, state: &mut Point, h: f64, dw: &[f64]) -> Result<(), StepError> {
        let mut typed = state.state();
        let result = self.0.step(&mut typed, h, &array(dw));
        *state = Point::of(&typed);
        result
    }

    fn step_without_structure(
        &self,
        state: &mut Point,
        h: f64,
        dw: &[f64],
    ) -> Result<(), StepError> {
        let integrator = Integrator::new(self.0.system().clone(), Unstructured(*self.0.rule()));
        let mut typed = state.state();
        let result = integrator.step(&mut typed, h, &array(dw));
        *state = Point::of(&typed);
        result
    }

    fn prepared(&self, h: f64) -> Result<Step<'_>, StepError> {
        let prepared = OneStepMethod::prepare(&self.0, h)?;
        Ok(Box::new(move |state, dw| {
            let mut typed = state.state();
            let result = self.0.step_prepared(&prepared, &mut typed, h, &array(dw));
            *state = Point::of(&typed);
            result
        }))
    }

    fn differentiated(
        &self,
        state: &mut Point,
        h: f64,
        dw: &[f64],
    ) -> Result<Derivatives, StepError> {
        let mut typed = state.state();
        let result = self.0.step_with_derivatives(&mut typed, h, &array(dw));
        *state = Point::of(&typed);
        let (tangent, sensitivity) = result?;
        let fields = sensitivity.iter().map(|(name, field)| {
            let entries = field.q.iter().chain(&field.p);
            (name, entries.copied().collect())
        });
        Ok(Derivatives {
            tangent: (0..2 * N).map(|row| tangent[row].to_vec()).collect(),
            defect: tangent.symplectic_defect(),
            sensitivity: fields.collect(),
        })
    }

    fn gradient(
        &self,
        start: &Point,
        h: f64,
        steps: [u64; 2],
        seed: u64,
        loss: &Loss<'_>,
    ) -> Result<LossGradient, StepError> {
        let path = self.0.trajectory(start.state(), h, Wiener::new(seed));
        let adjoint = path.adjoint(steps[0]).checkpoints(steps[1] as usize);
        let gradient = adjoint.gradient(|number, state| loss(number, &state.q, &state.p))?;
        Ok(LossGradient {
            loss: gradient.loss(),
            start: [gradient.start().q, gradient.start().p].concat(),
            parameters: gradient.iter().map(|(_, derivative)| derivative).collect(),
        })
    }

    fn step_lanes(
        &self,
        states: &[Point],
        h: f64,
        dw: &[Vector],
    ) -> Result<(Vec<Point>, Mask), StepError> {
        let (typed, increments) = in_lanes::<N, M>(states, dw);
        let mut next = typed;
        let prepared = OneStepMethod::prepare(&self.0, h)?;
        let left = OneStepMethod::step_lanes(&self.0, &prepared, &typed, &mut next, h, &increments);
        let points = (0..LANES).map(|lane| Point::of(&next.get(lane))).collect();
        Ok((points, left))
    }

    fn tangents_in_lanes(
        &self,
        states: &[Point],
        h: f64,
        dw: &[Vector],
    ) -> Result<LaneTangents, StepError> {
        let (typed, increments) = in_lanes::<N, M>(states, dw);
        let mut next = typed;
        let prepared = OneStepMethod::prepare(&self.0, h)?;
        let parameters = (0..S::PARAMETERS.len()).map(Some);
        let parameters: Vec<_> = std::iter::repeat_n(None, 2 * N).chain(parameters).collect();
        let start = TangentLanes {
            q: [[0.0; LANES]; N],
            p: [[0.0; LANES]; N],
        };
        let mut start = vec![start; parameters.len()];
        for i in 0..N {
            start[i].q[i] = [1.0; LANES];
            start[N + i].p[i] = [1.0; LANES];
        }
        let mut end = start.clone();
        let directions = LaneDirections {
            start: &start,
            next: &mut end,
            parameters: &parameters,
        };
        let [unsolved, unfinished] =
            (self.0).push_forward_lanes(&prepared, &typed, &mut next, h, &increments, directions);
        let vector = |field: &TangentLanes<N>, lane: usize| {
            let entries = field.q.iter().chain(&field.p);
            entries.map(|row| row[lane]).collect()
        };
        let of_lane = |lane| end.iter().map(|field| vector(field, lane)).collect();
        Ok(LaneTangents {
            states: (0..LANES).map(|lane| Point::of(&next.get(lane))).collect(),
            unsolved,
            unfinished,
            vectors: (0..LANES).map(of_lane).collect(),
        })
    }

    fn energies(&self, states: &[Point]) -> Vec<[f64; 2]> {
        let system = self.0.system();
        let mut typed = StateLanes::splat(&State::new([0.0; N], [0.0; N]));
        for (lane, state) in states.iter().enumerate() {
            typed.set(lane, &state.state());
        }
        let mut energies = [0.0; LANES];
        system.energy_lanes(&typed, &mut energies);
        let alone = |state: &Point| system.hamiltonian(&state.state()).unwrap_or(f64::NAN);
        energies
            .into_iter()
            .zip(states)
            .map(|(e, state)| [e, alone(state)])
            .collect()
    }

    fn trajectory<'a>(&'a self, start: &Point, h: f64, noise: Box<dyn Noise + 'a>) -> Path<'a> {
        path(self.0.trajectory(start.state(), h, noise))
    }

    fn stored(&self, start: &Point, h: f64, noise: Wiener, steps: usize) -> String {
        let noise: Box<dyn Noise> = Box::new(noise);
        let mut path = self.0.trajectory(start.state(), h, noise);
        (0..steps).for_each(|_| drop(path.next()));
        let text = serde_json::to_string(&path.snapshot()).expect("JSON");
        let snapshot: Snapshot<State<[f64; N]>> = serde_json::from_str(&text).expect("a snapshot");
        assert_eq!(snapshot, path.snapshot(), "{}", self.name());
        text
    }

    fn continued<'a>(&'a self, stored: &str, noise: Wiener) -> (u64, Path<'a>) {
        let snapshot: Snapshot<State<[f64; N]>> = serde_json::from_str(stored).expect("a snapshot");
        let noise: Box<dyn Noise> = Box::new(noise);
        let rest = self.0.resume(snapshot, noise).expect("a trajectory");
        (rest.step(), path(rest))
    }

    fn watched(&self, start: &Point, h: f64, dw: &[f64], steps: usize, watch: &mut Watch<'_>) {
        let (mut state, dw) = (start.state(), array(dw));
        watch(&mut || {
            for _ in 0..steps {
                self.0.step(&mut state, h, &dw).expect("a step");
            }
        });
    }
}
