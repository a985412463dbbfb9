//! A chain of twenty rods that hangs from one end and is shaken at the other, with the tension of
//! each rod.
//!
//! The bodies have Cartesian coordinates, and each rod is a constraint. The rule of Störmer and
//! Verlet is RATTLE: Newton's method has one unknown for each rod, with a tridiagonal Jacobian, so
//! the cost grows linearly with the chain. The tensions are the mean forces of the constraints in a
//! step. The picture is written to `target/chain_of_rods/`.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row};
use sve_examples::report::report;
use sve_examples::shades::shade;
use sve_examples::{hues, palette};
use sve_runtime::plan::BlockKind;
use sve_runtime::prelude::*;

const RODS: usize = 20;

/// Equal masses on rods of length `l`; noise pulls the last one to the side.
#[derive(Clone, Copy, Debug)]
struct Chain {
    m: f64,
    l: f64,
    g: f64,
    sigma: f64,
}

#[variational(stormer_verlet)]
impl Chain {
    const RODS: usize = 20;

    fn lagrangian(&self, q: [Vector2<f64>; 20], v: [Vector2<f64>; 20]) -> f64 {
        let mut energy = 0.0;
        for i in 0..Self::RODS {
            energy += 0.5 * self.m * v[i].norm_squared() - self.m * self.g * q[i].y;
        }
        energy
    }

    #[gamma]
    fn shake(&self, q: [Vector2<f64>; 20]) -> f64 {
        self.sigma * q[19].x
    }

    #[constraint]
    fn rods(&self, q: [Vector2<f64>; 20]) -> [f64; 20] {
        let mut rods = [0.5 * (q[0].norm_squared() - self.l * self.l); 20];
        for i in 1..Self::RODS {
            rods[i] = 0.5 * ((q[i] - q[i - 1]).norm_squared() - self.l * self.l);
        }
        rods
    }
}

type ChainState = State<[Vector2<f64>; RODS]>;

const CHAIN: Chain = Chain {
    m: 0.05,
    l: 0.05,
    g: 9.81,
    sigma: 0.25,
};
const H: f64 = 5e-4;

fn hanging() -> ChainState {
    let place = |i: usize| Vector2::new(0.0, -CHAIN.l * (i + 1) as f64);
    State::new(core::array::from_fn(place), [Vector2::zeros(); RODS])
}

/// Returns the tensions of the rods in a step.
fn tensions(
    chain: &Integrator<Chain, StormerVerlet>,
    state: &ChainState,
    h: f64,
    dw: f64,
) -> Result<([f64; RODS], Vector2<f64>), StepError> {
    let forces = chain.constraint_forces(state, h, &[dw])?;
    // If a rod is under tension, the force on the body at its lower end points to its upper end.
    let tension = |k: usize| {
        let force = forces.constraints[k].mean[k];
        let upper = if k == 0 {
            Vector2::zeros()
        } else {
            state.q[k - 1]
        };
        force.norm() * force.dot(&(upper - state.q[k])).signum()
    };
    let at_pivot = forces.constraints[0].mean[0];
    Ok((core::array::from_fn(tension), at_pivot))
}

/// Checks the chain at rest: each rod bears the weight below it.
fn at_rest(chain: &Integrator<Chain, StormerVerlet>) -> Result<Check, StepError> {
    let (tensions, _) = tensions(chain, &hanging(), H, 0.0)?;
    let off = tensions.iter().enumerate().map(|(k, tension)| {
        let weight = CHAIN.m * CHAIN.g * (RODS - k) as f64;
        (tension / weight - 1.0).abs()
    });
    let worst = off.fold(0.0, f64::max);
    Ok(
        Check::new("at rest: tension over the weight below, less 1", worst).near(
            0.0,
            1e-10,
            "rounding over h²",
        ),
    )
}

/// Checks that with noise the forces of a step have a part that grows like h^(−1/2).
fn noise_in_forces(chain: &Integrator<Chain, StormerVerlet>) -> Result<Check, StepError> {
    let bent = chain.consistent({
        let mut state = hanging();
        for (i, q) in state.q.iter_mut().enumerate() {
            q.x = 0.02 * i as f64;
        }
        state
    })?;
    let spread = |h: f64| -> Result<f64, StepError> {
        let [up, down] = [1.0, -1.0].map(|sign| tensions(chain, &bent, h, sign * h.sqrt()));
        Ok((up?.0[RODS - 1] - down?.0[RODS - 1]).abs())
    };
    let ratio = spread(1e-5)? / spread(1e-3)?;
    Ok(Check::new(
        "spread of the last rod's tension, h = 10⁻⁵ over 10⁻³",
        ratio,
    )
    .near(10.0, 0.5, "h^(−1/2)"))
}

/// The results of a path.
struct Run {
    snapshots: Vec<(ChainState, [f64; RODS])>,
    /// Time, and the mean force at the pivot over some steps.
    pivot: Vec<(f64, f64)>,
    checks: Vec<Check>,
}

fn run(chain: &Integrator<Chain, StormerVerlet>) -> Result<Run, StepError> {
    let (steps, window, every) = (20_000, 50, 2_500);
    let noise = Recorded::record(Wiener::new(11), H, 1, steps)
        .map_err(|source| StepError::Noise { t: 0.0, source })?;
    let mut state = hanging();
    let mut run = Run {
        snapshots: Vec::new(),
        pivot: Vec::new(),
        checks: Vec::new(),
    };
    let (mut mean, mut length) = ([0.0; RODS], 0.0f64);
    let (mut impulse, mut part, mut kicks) = (Vector2::zeros(), 0.0, 0.0);
    for k in 0..steps {
        let dw = noise.get(k).map_or(0.0, |dw| dw[0]);
        let (tensions, at_pivot) = tensions(chain, &state, H, dw)?;
        for (mean, tension) in mean.iter_mut().zip(tensions) {
            *mean += tension / window as f64;
        }
        part += at_pivot.y / window as f64;
        impulse += H * at_pivot;
        kicks += CHAIN.sigma * dw;
        chain.step(&mut state, H, &[dw])?;
        if (k + 1) % window == 0 {
            run.pivot.push((state.t, part));
            if (k + 1) % every == 0 {
                run.snapshots.push((state, mean));
            }
            (mean, part) = ([0.0; RODS], 0.0);
        }
        for i in 0..RODS {
            let upper = if i == 0 {
                Vector2::zeros()
            } else {
                state.q[i - 1]
            };
            length = length.max(((state.q[i] - upper).norm() / CHAIN.l - 1.0).abs());
        }
    }
    let total: Vector2<f64> = state.p.iter().sum();
    let weight = CHAIN.m * CHAIN.g * RODS as f64;
    let expected = total - Vector2::new(kicks, -weight * state.t);
    run.checks = vec![
        Check::new("largest change of a rod's length", length).near(
            0.0,
            2e-14,
            "rounding of the coordinates over the length",
        ),
        Check::new(
            "impulse at the pivot less the change of momentum",
            (impulse - expected).norm(),
        )
        .near(0.0, 1e-10, "the momentum balance of each step"),
        Check::new(
            "mean force at the pivot over the weight",
            impulse.y / state.t / weight,
        )
        .near(1.0, 0.02, "the momentum stays bounded"),
    ];
    Ok(run)
}

/// Checks that without noise the energy does not drift.
fn energy() -> Result<Check, StepError> {
    let chain = Integrator::new(
        Chain {
            sigma: 0.0,
            ..CHAIN
        },
        StormerVerlet,
    );
    let mut state = hanging();
    for (i, q) in state.q.iter_mut().enumerate() {
        let angle = 0.9_f64;
        *q = CHAIN.l * (i + 1) as f64 * Vector2::new(angle.sin(), -angle.cos());
    }
    let mut state = chain.consistent(state)?;
    let start = chain.system().hamiltonian(&state)?;
    let mut halves = [0.0f64; 2];
    for half in &mut halves {
        for _ in 0..20_000 {
            chain.step(&mut state, H, &[0.0])?;
            *half = half.max((chain.system().hamiltonian(&state)? - start).abs());
        }
    }
    let lift = CHAIN.m * CHAIN.g * CHAIN.l * (RODS * (RODS + 1) / 2) as f64 * (1.0 - 0.9f64.cos());
    let worst = halves[0].max(halves[1]) / lift;
    Ok(
        Check::new("energy error of a free swing, over its energy", worst).near(
            0.0,
            5e-3,
            "no drift over 20 s",
        ),
    )
}

/// Draws the colours of tensions above the chains.
fn with_scale(mut panel: Panel) -> Panel {
    let (left, width, height) = (0.75, 1.6, 0.35);
    for k in 0..40 {
        let ends = [k, k + 1].map(|k| (left + width * f64::from(k) / 40.0, height));
        let pen = Pen::line(shade((f64::from(k) + 0.5) / 40.0), 8.0);
        panel = panel.with(Layer::new("scale", ends.to_vec(), pen).unlisted());
    }
    panel
        .note((0.0, height), "tension: none", palette::BLACK)
        .note(
            (left + width + 0.1, height),
            "the weight of the chain",
            palette::BLACK,
        )
}

fn figure(run: &Run) -> Figure {
    let weight = CHAIN.m * CHAIN.g * RODS as f64;
    let mut chain = Panel::new(
        "The chain each 1.25 s, coloured by its tension",
        Axis {
            labels: 0,
            ..Axis::new(
                "x, in the scale of y; snapshots are side by side",
                -0.4..7.9,
            )
        },
        Axis::new("y (m)", -1.12..0.5),
    )
    .equal();
    chain = with_scale(chain);
    for (number, (state, tensions)) in run.snapshots.iter().enumerate() {
        let shift = Vector2::new(1.05 * number as f64, 0.0);
        let time = format!("t = {:.2} s", state.t);
        chain = chain.note((shift.x - 0.15, 0.1), time, palette::BLACK);
        for k in 0..RODS {
            let upper = if k == 0 {
                Vector2::zeros()
            } else {
                state.q[k - 1]
            };
            let ends = [upper + shift, state.q[k] + shift].map(|q| (q.x, q.y));
            let pen = Pen::line(shade(tensions[k] / weight), 4.0);
            chain = chain.with(Layer::new("rod", ends.to_vec(), pen).unlisted());
        }
    }
    let forces = |part: &[(f64, f64)]| -> [f64; 3] {
        let forces = part.iter().map(|(_, force)| force / weight);
        let mean = forces.clone().sum::<f64>() / part.len() as f64;
        [
            mean,
            forces.clone().fold(f64::MAX, f64::min),
            forces.fold(f64::MIN, f64::max),
        ]
    };
    let parts = run
        .pivot
        .chunks(10)
        .map(|part| (part[part.len() / 2].0, forces(part)));
    let (means, ends): (Vec<_>, Vec<_>) = parts
        .map(|(t, [mean, least, most])| ((t, mean), (least, most)))
        .unzip();
    let highest = ends.iter().fold(0.0, |high: f64, end| high.max(end.1));
    let lowest = ends.iter().fold(0.0, |low: f64, end| low.min(end.0));
    let line = vec![(0.0, 1.0), (10.0, 1.0)];
    let force = Panel::new(
        "Upward force at the pivot over the weight of the chain",
        Axis::new("time t (s)", 0.0..10.0),
        Axis::new("force/weight", 1.05 * lowest..1.05 * highest),
    )
    .legend(Corner::Below)
    .with(
        Layer::new(
            "mean of 0.25 s, and extremes of means of 0.025 s",
            means,
            Pen::line(hues::STORMER_VERLET, 1.2),
        )
        .band(ends),
    )
    .with(Layer::new(
        "weight",
        line,
        Pen::dashed(hues::EXACT, 1.2, (5.0, 3.0)),
    ));
    Figure {
        name: "chain_of_rods",
        width: 1100,
        rows: vec![
            Row {
                height: 320,
                panels: vec![chain],
            },
            Row {
                height: 240,
                panels: vec![force],
            },
        ],
    }
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let chain = Integrator::new(CHAIN, StormerVerlet);
    let newton = chain
        .plan()
        .blocks
        .iter()
        .find(|b| b.kind == BlockKind::Newton);
    let unknowns = newton.map_or(0, |block| block.unknowns.len());
    let nonzeros = newton.map_or(0, |block| block.nonzeros);
    let run = run(&chain)?;
    let mut checks = vec![
        Check::new("unknowns of Newton's method", unknowns as f64).near(
            RODS as f64,
            0.0,
            "one for each rod",
        ),
        Check::new("entries of its Jacobian", nonzeros as f64).near(
            (3 * RODS - 2) as f64,
            0.0,
            "a tridiagonal matrix",
        ),
        at_rest(&chain)?,
    ];
    checks.extend(run.checks.iter().cloned());
    checks.push(noise_in_forces(&chain)?);
    checks.push(energy()?);
    let figure = figure(&run);
    let caption = "Twenty rods by the rule of Störmer and Verlet, h = 5·10⁻⁴; noise pulls the lowest mass to the side, seed 11. Above: the chain at eight times, moved to the right by 1.05 from one to the next. Below: means of the force at the pivot over a quarter of a second, and the least and largest means over 0.025 s in it.";
    report("Chain of rods", &figure, caption, &checks)
}
