//! The least effort that swings up the pole of a cart, by the gradient of a trajectory with inputs.
//!
//! A cart of 1 kg carries a light pole of 0.5 m with a bob of 0.3 kg. The pole hangs at rest; after
//! two seconds it shall stand upright at rest, one metre to the right. A controller sets the force
//! u on the cart 50 times a second and holds it meanwhile. Single shooting: the 100 forces are the
//! unknowns, and the effort ½ h Σ u² is minimised by L-BFGS with the adjoint gradient of the steps;
//! an augmented Lagrangian enforces the conditions at the end. In gusts the optimal forces alone
//! lose the pole; a time-varying linear-quadratic regulator (LQR) around the optimal path holds it.
//!
//! `cargo run --release --example swing_up` draws `target/swing_up/swing_up.svg` and `.png`, and
//! exits with status 1 if a number is off.

use std::collections::VecDeque;
use std::error::Error;
use std::f64::consts::PI;
use std::iter::{once, repeat_n, zip};
use std::process::ExitCode;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::palette::{BLUE, GREY, ORANGE};
use sve_examples::report::{one_row, report};
use sve_runtime::nalgebra::{DVector, Matrix4, RowVector4, Vector4};
use sve_runtime::prelude::*;
use sve_runtime::{Dual, Gradient};

/// A cart with a pole, in SI units, and the strength of gusts.
#[derive(Clone, Copy, Debug)]
struct CartPole {
    cart: f64,
    bob: f64,
    length: f64,
    g: f64,
    gust: f64,
}

#[variational(midpoint)]
impl CartPole {
    /// The coordinates are the place of the cart and the angle of the pole, 0 where it hangs.
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2], u: f64) -> f64 {
        let [x, angle] = q;
        let across = v[0] + self.length * angle.cos() * v[1];
        let up = self.length * angle.sin() * v[1];
        let kinetic = self.cart * v[0] * v[0] + self.bob * (across * across + up * up);
        0.5 * kinetic + self.bob * self.g * self.length * angle.cos() + u * x
    }
    /// White noise that pushes the bob to the side.
    #[gamma]
    fn wind(&self, q: [f64; 2]) -> f64 {
        self.gust * (q[0] + self.length * q[1].sin())
    }
}

const CALM: CartPole = CartPole {
    cart: 1.0,
    bob: 0.3,
    length: 0.5,
    g: 9.81,
    gust: 0.0,
};

/// A particle that is pushed.
struct DoubleIntegrator;

#[variational(midpoint)]
impl DoubleIntegrator {
    fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64 {
        0.5 * v * v + u * q
    }
}

/// Length of a step, over which a force is held, and number of steps of the swing-up.
const H: f64 = 0.02;
const STEPS: usize = 100;
/// Strength of the gusts in N √s. The root mean square of their mean over a step is 0.35 N.
const GUST: f64 = 0.05;
/// Factor of the squares of the conditions at the end in the augmented Lagrangian. An update of the
/// multipliers then divides the conditions by about six.
const WEIGHT: f64 = 1e4;

const REST: State<[f64; 2]> = State::new([0.0; 2], [0.0; 2]);
type Path = Vec<State<[f64; 2]>>;
type Controls = DVector<f64>;
type Linear = (Matrix4<f64>, Vector4<f64>, Vector4<f64>);
/// A cost with its gradient by the controls.
type Evaluated = Result<(f64, Controls), StepError>;

/// Returns the terms Σ (λ + ½ μ c) c of an augmented Lagrangian for conditions c = 0 at the end.
fn terminal_cost<const C: usize>(multipliers: &[f64; C], conditions: [Dual; C]) -> Dual {
    let terms = zip(multipliers, conditions).map(|(&lambda, c)| (0.5 * WEIGHT * c + lambda) * c);
    terms.sum()
}

/// Adds the effort to a cost of the end and to its gradient.
fn with_effort<V>(u: &Controls, end: &Gradient<V>) -> (f64, Controls) {
    let by_inputs = end.inputs().map(|by_input| by_input[0]);
    let gradient = H * u + DVector::from_iterator(u.len(), by_inputs);
    (0.5 * H * u.norm_squared() + end.loss(), gradient)
}

/// Returns the augmented Lagrangian of the swing-up with its gradient.
fn swing_up(u: &Controls, multipliers: &[f64; 4]) -> Evaluated {
    let cart_pole = Integrator::new(CALM, Midpoint);
    let path = cart_pole.trajectory(REST, H, NoNoise);
    let path = path.inputs(|k, _| u[k as usize]);
    let end = path.gradient(STEPS as u64, |k, state| {
        let conditions = [state.q[0] - 1.0, state.q[1] - PI, state.p[0], state.p[1]];
        (k == STEPS as u64).then(|| terminal_cost(multipliers, conditions))
    })?;
    Ok(with_effort(u, &end))
}

/// Returns the first and all other states without gusts, each force held over `repeats` steps.
fn path(u: &Controls, repeats: usize) -> Result<Path, StepError> {
    let cart_pole = Integrator::new(CALM, Midpoint);
    let path = cart_pole.trajectory(REST, H / repeats as f64, NoNoise);
    let path = path.inputs(|k, _| u[k as usize / repeats]);
    let others = path.take(repeats * u.len());
    once(Ok(REST)).chain(others).collect()
}

/// Returns the conditions of the swing-up, the deviation of the last state from the upright rest.
fn deviation(u: &Controls, repeats: usize) -> Result<Vector4<f64>, StepError> {
    let states = path(u, repeats)?;
    let end = states[states.len() - 1];
    Ok(vector(end.q, end.p) - Vector4::new(1.0, PI, 0.0, 0.0))
}

fn vector(q: [f64; 2], p: [f64; 2]) -> Vector4<f64> {
    Vector4::new(q[0], q[1], p[0], p[1])
}

/// Returns random controls up to 20 N.
fn random(seed: u64) -> Controls {
    let mut rng = StdRng::seed_from_u64(seed);
    DVector::from_fn(STEPS, |_, _| 40.0 * (rng.random::<f64>() - 0.5))
}

/// Returns controls of least effort under conditions at the end, by the method of multipliers, and
/// the multipliers.
fn optimum<const C: usize>(
    mut u: Controls,
    cost: impl Fn(&Controls, &[f64; C]) -> Evaluated,
    conditions: impl Fn(&Controls) -> Result<[f64; C], StepError>,
) -> Result<(Controls, [f64; C]), StepError> {
    let mut multipliers = [0.0; C];
    for _ in 0..30 {
        u = minimise(u, |u| cost(u, &multipliers))?;
        let conditions = conditions(&u)?;
        if conditions.iter().all(|c| c.abs() < 1e-10) {
            break;
        }
        for (lambda, c) in zip(&mut multipliers, conditions) {
            *lambda += WEIGHT * c;
        }
    }
    Ok((u, multipliers))
}

/// Minimises by L-BFGS (J. Nocedal, S. Wright, Numerical Optimization, algorithm 7.5) with a
/// backtracking line search.
fn minimise(mut u: Controls, cost: impl Fn(&Controls) -> Evaluated) -> Result<Controls, StepError> {
    let mut memory = VecDeque::new();
    let (mut value, mut gradient) = cost(&u)?;
    for _ in 0..2000 {
        let mut step = direction(&memory, &gradient);
        let next = loop {
            if gradient.amax() <= 1e-9 || step.amax() < 1e-13 {
                return Ok(u);
            }
            // near the minimum the decrease is smaller than the rounding error of the cost
            let highest = value + 1e-4 * gradient.dot(&step) + 1e-13 * value.abs();
            match cost(&(&u + &step)) {
                Ok(next) if next.0 <= highest => break next,
                // the cost is too high, or a step has no solution with these controls
                _ => step *= 0.5,
            }
        };
        u += &step;
        let change = &next.1 - gradient;
        (value, gradient) = next;
        if step.dot(&change) > 0.0 {
            memory.push_front([step, change]);
            memory.truncate(40);
        }
    }
    Ok(u)
}

/// Returns the step of L-BFGS by the two-loop recursion, from the last steps s and the changes y of
/// the gradient in them, the latest first.
fn direction(memory: &VecDeque<[Controls; 2]>, gradient: &Controls) -> Controls {
    let Some([s, y]) = memory.front() else {
        return -gradient.normalize();
    };
    let scale = s.dot(y) / y.norm_squared();
    let (mut d, mut weights) = (-gradient, Vec::new());
    for [s, y] in memory {
        let weight = s.dot(&d) / s.dot(y);
        d -= weight * y;
        weights.push(weight);
    }
    d *= scale;
    for ([s, y], weight) in zip(memory, weights).rev() {
        d += (weight - y.dot(&d) / s.dot(y)) * s;
    }
    d
}

/// Returns the relative error of the gradient along a random direction by central differences.
fn gradient_error() -> Result<f64, StepError> {
    let (u, along, multipliers) = (random(0), random(1), [1.0; 4]);
    // with ∛ε times the size of the controls, the errors of rounding and of truncation are equal
    let moved = |by: f64| swing_up(&(&u + by * &along), &multipliers);
    let slope = (moved(6e-6)?.0 - moved(-6e-6)?.0) / 12e-6;
    Ok((slope / moved(0.0)?.1.dot(&along) - 1.0).abs())
}

/// Returns the relative error of the optimum for a particle that is brought to q = 1, which is
/// u ∝ N − k − ½.
fn particle_error() -> Result<f64, StepError> {
    let particle = Integrator::new(DoubleIntegrator, Midpoint);
    let cost = |u: &Controls, multipliers: &[f64; 1]| {
        let path = particle.trajectory(State::new([0.0], [0.0]), H, NoNoise);
        let path = path.inputs(|k, _| u[k as usize]);
        let end = path.gradient(STEPS as u64, |k, state| {
            (k == STEPS as u64).then(|| terminal_cost(multipliers, [state.q[0] - 1.0]))
        })?;
        Ok(with_effort(u, &end))
    };
    let left = DVector::from_fn(STEPS, |k, _| (STEPS - k) as f64 - 0.5);
    let condition = |u: &Controls| Ok([H * H * u.dot(&left) - 1.0]);
    let (found, _) = optimum(random(0), cost, condition)?;
    let known = &left / (H * H * left.norm_squared());
    Ok((found - &known).amax() / known.amax())
}

/// The optimal path and its forces, followed by two seconds upright without force.
struct Plan {
    states: Path,
    controls: Controls,
    /// Gains of the regulator.
    gains: Vec<RowVector4<f64>>,
    /// Mean square deviation of the angle at the end of the swing-up, for weak gusts.
    mean_square: f64,
}

/// Returns the derivatives of a step: by the state, by the control, and by the strength of the
/// gusts for an increment of √h.
fn linearise(mut state: State<[f64; 2]>, u: f64) -> Result<Linear, StepError> {
    let cart_pole = Integrator::new(CALM, Midpoint);
    let held = cart_pole.holding(&u);
    let (tangent, slopes) = held.step_with_derivatives(&mut state, H, &[H.sqrt()])?;
    let by = |name| {
        let slope = slopes.get(name);
        slope.map_or(Vector4::repeat(f64::NAN), |z| vector(z.q, z.p))
    };
    let by_state = Matrix4::from_fn(|i, j| tangent[i][j]);
    Ok((by_state, by("u[0]"), by("gust")))
}

/// Returns the LQR around the optimal path by the Riccati recursion, and its covariance in gusts.
fn regulate(forces: &Controls) -> Result<Plan, StepError> {
    let controls = forces.clone().resize_vertically(2 * STEPS, 0.0);
    let states = path(&controls, 1)?;
    let steps = zip(&states, &controls).map(|(state, &u)| linearise(*state, u));
    let steps = steps.collect::<Result<Vec<_>, _>>()?;
    // in a second, a deviation by an SI unit costs 1, and a correction by 1 N costs 0.01
    let (deviation, correction) = (Matrix4::identity() * H, 0.01 * H);
    let (mut gains, mut cost) = (vec![RowVector4::zeros(); steps.len()], deviation);
    // the last step, many times, gives the cost of holding the pole for ever
    for k in repeat_n(steps.len() - 1, 1000).chain((0..steps.len()).rev()) {
        let (a, b, _) = &steps[k];
        gains[k] = -(b.transpose() * cost * a) / (correction + b.dot(&(cost * b)));
        cost = deviation + a.transpose() * cost * (a + b * gains[k]);
    }
    let mut covariance = Matrix4::zeros();
    for ((a, b, noise), gain) in zip(&steps[..STEPS], &gains) {
        let (closed, kick) = (a + b * gain, GUST * noise);
        covariance = closed * covariance * closed.transpose() + kick * kick.transpose();
    }
    Ok(Plan {
        states,
        controls,
        gains,
        mean_square: covariance[(1, 1)],
    })
}

/// Returns a path in gusts, with the corrections of the regulator times a factor.
fn in_gusts(plan: &Plan, seed: u64, factor: f64) -> Result<Path, StepError> {
    let windy = Integrator::new(CartPole { gust: GUST, ..CALM }, Midpoint);
    let path = windy.trajectory(REST, H, Wiener::new(7).path(seed));
    let path = path.inputs(|k, state| {
        let (k, planned) = (k as usize, &plan.states[k as usize]);
        let off = vector(state.q, state.p) - vector(planned.q, planned.p);
        plan.controls[k] + factor * plan.gains[k].dot(&off.transpose())
    });
    let others = path.take(plan.controls.len());
    once(Ok(REST)).chain(others).collect()
}

/// Returns the fraction of the poles that fall after the swing-up, and the mean square deviation of
/// the angle at its end.
fn fate(plan: &Plan, factor: f64) -> Result<[f64; 2], StepError> {
    let (paths, mut sums) = (4000, [0.0; 2]);
    for seed in 0..paths {
        let path = in_gusts(plan, seed, factor)?;
        let falls = path[STEPS..].iter().any(|state| state.q[1].cos() > 0.0);
        sums[0] += f64::from(u8::from(falls));
        sums[1] += (path[STEPS].q[1] - PI).powi(2);
    }
    Ok(sums.map(|sum| sum / paths as f64))
}

fn checks(u: &Controls, multipliers: &[f64; 4], plan: &Plan) -> Result<Vec<Check>, StepError> {
    let ends = [deviation(u, 1)?, deviation(u, 2)?, deviation(u, 4)?];
    let ratio = (ends[0] - ends[1]).norm() / (ends[1] - ends[2]).norm();
    let [[alone, _], [regulated, found]] = [fate(plan, 0.0)?, fate(plan, 1.0)?];
    let (slope, particle) = (gradient_error()?, particle_error()?);
    let residual = swing_up(u, multipliers)?.1.amax() / (H * u.amax());
    let square = found / plan.mean_square;
    let new = Check::new;
    Ok(vec![
        new("gradient from central differences", slope).near(0.0, 1e-9, "relative"),
        new("u from ∝ N − k − ½, double integrator", particle).near(0.0, 1e-8, "relative"),
        new("deviation from upright rest", ends[0].amax()).near(0.0, 1e-9, "SI units"),
        new("gradient of the Lagrangian", residual).near(0.0, 1e-7, "over that of the effort"),
        new("effort ½ h Σ u² in N² s", 0.5 * H * u.norm_squared()).reported("a local optimum"),
        new("deviation with steps h/2", ends[1].norm()).near(0.0, 0.05, "error of order h²"),
        new("change to h/2 over that to h/4", ratio).near(4.0, 0.05, "order 2"),
        new("poles that fall, optimal forces alone", alone).near(1.0, 0.01, "unstable"),
        new("poles that fall, regulated", regulated).near(0.0, 0.0, "60 standard deviations"),
        new("mean square angle over linear theory", square).near(1.0, 0.09, "4 standard errors"),
    ])
}

/// Returns the panel of poses at equal times.
fn stroboscope(states: &[State<[f64; 2]>]) -> Panel {
    let title = "Cart and pole every tenth of a second, later ones darker";
    let height = Axis::new("height in m", -0.6..0.6);
    let mut panel = Panel::new(title, Axis::new("x in m", -0.3..1.5), height).equal();
    let bob = |state: &State<[f64; 2]>| {
        let (sin, cos) = state.q[1].sin_cos();
        (state.q[0] + CALM.length * sin, -CALM.length * cos)
    };
    let trace = states.iter().map(bob).collect();
    panel = panel.with(Layer::new("bob", trace, Pen::line(GREY, 0.7)));
    for (age, state) in zip(5_u16.., states.iter().step_by(5)) {
        let fade = |part: u8| 255 - (u16::from(255 - part) * age / 25) as u8;
        let color = (fade(BLUE.0), fade(BLUE.1), fade(BLUE.2));
        let [left, pivot, right] = [-0.03, 0.0, 0.03].map(|by| (state.q[0] + by, 0.0));
        for (points, pen) in [
            (vec![left, right], Pen::line(color, 7.0)),
            (vec![pivot, bob(state)], Pen::line(color, 2.0)),
            (vec![bob(state)], Pen::dots(color, 5.0)),
        ] {
            panel = panel.with(Layer::new("cart and pole", points, pen));
        }
    }
    panel
}

fn figure(plan: &Plan) -> Result<Figure, StepError> {
    let time = |last| Axis::new("time in s", 0.0..last);
    let held = zip(&plan.controls, plan.states[..=STEPS].windows(2));
    let held = held.flat_map(|(&u, ends)| [(ends[0].t, u), (ends[1].t, u)]);
    let force = Panel::new("Optimal force", time(2.0), Axis::new("u in N", -15.0..10.0))
        .with(Layer::new("force", held.collect(), Pen::line(BLUE, 1.6)));
    let axis = Axis::angle("angle of the pole", -PI..4.0 * PI);
    let mut angle = Panel::new("Three paths in gusts", time(4.0), axis).legend(Corner::TopLeft);
    let pens = [Pen::dashed(ORANGE, 1.6, (6.0, 3.0)), Pen::line(BLUE, 1.6)];
    let labels = ["optimal force alone", "with the regulator"];
    for ((label, pen), factor) in zip(zip(labels, pens), [0.0, 1.0]) {
        for seed in 0..3 {
            let path = in_gusts(plan, seed, factor)?;
            let line = path.iter().map(|state| (state.t, state.q[1]));
            let layer = Layer::new(label, line.collect(), pen);
            angle = angle.with(if seed == 0 { layer } else { layer.unlisted() });
        }
    }
    let poses = stroboscope(&plan.states[..=STEPS]);
    let mut figure = one_row("swing_up", [1000, 640], vec![poses]);
    figure
        .rows
        .extend(one_row("", [1000, 400], vec![force, angle]).rows);
    Ok(figure)
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let (u, multipliers) = optimum(random(0), swing_up, |u| Ok(deviation(u, 1)?.into()))?;
    let plan = regulate(&u)?;
    let checks = checks(&u, &multipliers, &plan)?;
    let caption = "Top: the swing-up of least effort. Bottom: its force, which is held over steps of 0.02 s, and the angle of the pole on three paths in gusts, with the optimal force alone and with a regulator around the optimal path.";
    report("Swing-up of a cart-pole", &figure(&plan)?, caption, &checks)
}
