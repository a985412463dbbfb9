//! The numbers of a Rust program that the tests of the Python module compare, bit for bit.
//!
//! The system is that of the module, written again. A line has a name and the bits of numbers as
//! hexadecimal digits; the last lines have the seconds that a million steps took.

use std::time::Instant;

use sve_runtime::prelude::*;

struct Pendulum {
    g: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
    #[gamma]
    fn shaking(&self, q: f64) -> f64 {
        self.sigma * q.sin()
    }
}

fn print(name: &str, numbers: impl IntoIterator<Item = f64>) {
    let bits = numbers
        .into_iter()
        .map(|x| format!(" {:016x}", x.to_bits()));
    println!("{name}{}", bits.collect::<String>());
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let system = Pendulum {
        g: 9.81,
        sigma: 0.5,
    };
    let pendulum = Integrator::new(system, Midpoint);
    let start = State::new([1.0], [0.0]);

    let mut state = start;
    for dw in [0.02, -0.1, 0.3] {
        pendulum.step(&mut state, 0.01, &[dw])?;
    }
    print("step", [state.t, state.q[0], state.p[0]]);

    let noise = Wiener::new(42).path(7);
    let path = pendulum.trajectory(start, 0.01, noise).take(1000);
    let states = path.collect::<Result<Vec<_>, _>>()?;
    let rows = states
        .iter()
        .flat_map(|state| [state.t, state.q[0], state.p[0]]);
    print("path", rows);

    let summary = Ensemble::new(&pendulum)
        .paths(1000)
        .seed(42)
        .steps(0.01, 200)
        .every(50)
        .start(start)
        .observe("q", |_, state| state.q[0])
        .observe("p", |_, state| state.p[0])
        .observe_energy("energy")
        .keep_final_states(true)
        .run()?;
    print("times", summary.times().iter().copied());
    for statistics in summary.statistics() {
        let name = statistics.name();
        print(&format!("{name}.mean"), statistics.mean().iter().copied());
        print(
            &format!("{name}.standard_error"),
            statistics.standard_error(),
        );
    }
    print("ends", summary.final_states().map(|(_, end)| end.q[0]));

    let begun = Instant::now();
    let end = *pendulum
        .trajectory(start, 0.01, Wiener::new(42))
        .advance(1_000_000)?;
    println!("seconds {}", begun.elapsed().as_secs_f64());
    print("end", [end.q[0], end.p[0]]);
    Ok(())
}
