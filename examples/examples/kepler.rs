//! Two bodies in a plane whose attraction fluctuates: energy wanders, angular and linear momentum stay.
//!
//! L = ½m₁|v₁|² + ½m₂|v₂|² + k/r, γ = σ/r. The rotation and the two shifts are declared as symmetries, so the macro proves that L and
//! the noise have them and gives their momenta. The midpoint rule keeps all of them to rounding, whatever the path; Heun’s
//! method, of the same order, loses angular momentum.

use std::error::Error;

use sve_runtime::baseline::Heun;
use sve_runtime::prelude::*;

type Plane = [[f64; 2]; 2];

#[derive(Clone, Copy, Debug)]
struct Kepler {
    m: [f64; 2],
    k: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Kepler {
    fn inverse_distance(&self, q: [[f64; 2]; 2]) -> f64 {
        let [[x1, y1], [x2, y2]] = q;
        (x2 - x1).hypot(y2 - y1).recip()
    }

    fn lagrangian(&self, q: [[f64; 2]; 2], v: [[f64; 2]; 2]) -> f64 {
        let mut kinetic = 0.0;
        for i in 0..2 {
            for k in 0..2 {
                kinetic += 0.5 * self.m[i] * v[i][k].powi(2);
            }
        }
        kinetic + self.k * self.inverse_distance(q)
    }

    #[gamma]
    fn attraction(&self, q: [[f64; 2]; 2]) -> f64 {
        self.sigma * self.inverse_distance(q)
    }

    #[symmetry]
    fn rotation(&self, q: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
        [[-q[0][1], q[0][0]], [-q[1][1], q[1][0]]]
    }

    #[symmetry]
    fn shift_x(&self, _q: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
        [[1.0, 0.0]; 2]
    }

    #[symmetry]
    fn shift_y(&self, _q: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
        [[0.0, 1.0]; 2]
    }
}

const H: f64 = 0.01;

impl Kepler {
    /// At the far end of an orbit of eccentricity `e` and semi-major axis 1, the centre of mass moving slowly.
    fn start(&self, e: f64) -> State<Plane> {
        let [m1, m2] = self.m;
        let (total, reduced) = (m1 + m2, m1 * m2 / (m1 + m2));
        let (distance, speed) = (1.0 + e, (self.k / reduced * (1.0 - e) / (1.0 + e)).sqrt());
        let place = |x: f64| [x, 0.0];
        let drift = 0.05;
        let momentum = reduced * speed;
        let q: Plane = [place(-distance * m2 / total), place(distance * m1 / total)];
        let p: Plane = [[m1 * drift, -momentum], [m2 * drift, momentum]];
        State::new(q, p)
    }
}

/// Energy and largest changes of the momenta after each tenth of the time.
fn report<I: Method<System = Kepler>>(name: &str, method: &I) -> Result<(), StepError> {
    let system = method.system();
    let momenta = |state: &State<Plane>| {
        [
            system.rotation_momentum(state),
            system.shift_x_momentum(state),
            system.shift_y_momentum(state),
        ]
    };
    let start = system.start(0.6);
    let first = momenta(&start);
    println!("{name}");
    println!(
        "{:>6} {:>10} {:>18} {:>12} {:>12}",
        "t", "energy", "angular momentum", "momentum x", "momentum y"
    );
    let mut worst = [0.0_f64; 3];
    let trajectory = method.trajectory(start, H, Wiener::new(42));
    for (step, state) in (1..=20_000).zip(trajectory) {
        let state = state?;
        for (worst, (now, first)) in worst.iter_mut().zip(momenta(&state).iter().zip(first)) {
            *worst = worst.max((now - first).abs());
        }
        if step % 4000 == 0 {
            println!(
                "{:>6.0} {:>10.5} {:>18.1e} {:>12.1e} {:>12.1e}",
                state.t,
                system.hamiltonian(&state)?,
                worst[0],
                worst[1],
                worst[2]
            );
        }
    }
    println!();
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let system = Kepler {
        m: [1.0, 0.5],
        k: 1.0,
        sigma: 0.01,
    };
    let midpoint = Integrator::new(system, Midpoint);
    println!("{}\n", midpoint.plan());
    println!("largest change of each momentum so far, h = {H}\n");
    report("midpoint rule", &midpoint)?;
    report("Heun's method", &Heun::new(system))?;
    Ok(())
}
