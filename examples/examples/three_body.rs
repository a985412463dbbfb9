//! Three equal masses that chase one another along a figure eight: a first program with vectors.
//!
//! L = Σ ½mᵢ|vᵢ|² + Σ g mᵢmⱼ/|qᵢ − qⱼ|. The orbit was found by Chenciner and Montgomery (Annals of
//! Mathematics 152, 2000); the initial values are by Simó. After one period the bodies are back
//! where they started, up to the error of the midpoint rule, which is of order 2. The energy error
//! stays bounded, and the momenta are kept to rounding.

use std::error::Error;

use sve_runtime::prelude::*;

struct ThreeBody {
    m: [f64; 3],
    g: f64,
}

#[variational(midpoint)]
impl ThreeBody {
    fn lagrangian(&self, q: [Vector2<f64>; 3], v: [Vector2<f64>; 3]) -> f64 {
        let mut l = 0.0;
        for i in 0..3 {
            l += 0.5 * self.m[i] * v[i].norm_squared();
            for j in 0..i {
                l += self.g * self.m[i] * self.m[j] / (q[i] - q[j]).norm();
            }
        }
        l
    }

    #[symmetry]
    fn rotation(&self, q: [Vector2<f64>; 3]) -> [Vector2<f64>; 3] {
        q.map(|body| Vector2::new(-body.y, body.x))
    }

    #[symmetry]
    fn shift_x(&self, _q: [Vector2<f64>; 3]) -> [Vector2<f64>; 3] {
        [Vector2::x(); 3]
    }

    #[symmetry]
    fn shift_y(&self, _q: [Vector2<f64>; 3]) -> [Vector2<f64>; 3] {
        [Vector2::y(); 3]
    }
}

type Bodies = State<[Vector2<f64>; 3]>;

const PERIOD: f64 = 6.325_913_98;

/// Returns the start of the figure eight for unit masses and g = 1: one body in the centre, the
/// others opposite each other.
fn figure_eight() -> Bodies {
    let q = Vector2::new(0.970_004_36, -0.243_087_53);
    let p = Vector2::new(-0.932_407_37, -0.864_731_46);
    State::new([q, -q, Vector2::zeros()], [-p / 2.0, -p / 2.0, p])
}

/// Returns the largest distance of a body from its place in the other state.
fn distance(a: &Bodies, b: &Bodies) -> f64 {
    let distances = a.q.iter().zip(&b.q).map(|(a, b)| (a - b).norm());
    distances.fold(0.0, f64::max)
}

/// Steps through one period with two step sizes. Returns the order at which the distance from the
/// start vanishes.
fn close_the_orbit(method: &Integrator<ThreeBody, Midpoint>) -> Result<f64, StepError> {
    let start = figure_eight();
    println!("{:>16} {:>20}", "steps a period", "distance from start");
    let mut gaps = [0.0; 2];
    for (gap, steps) in gaps.iter_mut().zip([1000, 2000]) {
        let mut state = start;
        for _ in 0..steps {
            method.step(&mut state, PERIOD / f64::from(steps), &[])?;
        }
        *gap = distance(&state, &start);
        println!("{steps:>16} {gap:>20.2e}");
    }
    let order = (gaps[0] / gaps[1]).log2();
    println!("observed order: {order:.2}\n");
    Ok(order)
}

/// Follows the orbit for 100 periods of 1000 steps. Returns the largest changes of energy, angular
/// momentum and linear momentum.
fn follow(method: &Integrator<ThreeBody, Midpoint>) -> Result<[f64; 3], StepError> {
    let system = method.system();
    let start = figure_eight();
    let first = system.hamiltonian(&start)?;
    println!("largest change so far of");
    println!(
        "{:>8} {:>10} {:>18} {:>17}",
        "periods", "energy", "angular momentum", "linear momentum"
    );
    let mut worst = [0.0_f64; 3];
    let trajectory = method.trajectory(start, PERIOD / 1000.0, NoNoise);
    for (step, state) in (1..=100_000).zip(trajectory) {
        let state = state?;
        let linear = Vector2::new(
            system.shift_x_momentum(&state),
            system.shift_y_momentum(&state),
        );
        // The momenta are zero at the start.
        let changes = [
            (system.hamiltonian(&state)? - first).abs(),
            system.rotation_momentum(&state).abs(),
            linear.norm(),
        ];
        for (worst, change) in worst.iter_mut().zip(changes) {
            *worst = worst.max(change);
        }
        if step % 20_000 == 0 {
            let [energy, angular, linear] = worst;
            println!(
                "{:>8} {energy:>10.1e} {angular:>18.1e} {linear:>17.1e}",
                step / 1000
            );
        }
    }
    Ok(worst)
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = ThreeBody {
        m: [1.0; 3],
        g: 1.0,
    };
    let midpoint = Integrator::new(system, Midpoint);
    println!("{}\n", midpoint.plan());
    let order = close_the_orbit(&midpoint)?;
    let [energy, angular, linear] = follow(&midpoint)?;

    if (order - 2.0).abs() > 0.05 {
        return Err("the orbit was expected to close with order 2".into());
    }
    if energy > 1e-4 {
        return Err("the energy error was expected to stay bounded".into());
    }
    // 100,000 rounding errors of 1e-16, all of one sign, would add up to 1e-11.
    if angular > 1e-11 || linear > 1e-11 {
        return Err("the midpoint rule did not keep the momenta to rounding".into());
    }
    Ok(())
}
