use sve_runtime::prelude::*;
use sve_runtime::study::Study;

struct Pendulum;

#[variational(gauss(3, stage_noise))]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        q
    }
}

fn main() {
    let pendulum = Integrator::new(Pendulum, StageNoise(Gauss::<3>));
    let study = Study::new("pendulum").start(State::new([1.0], [0.0]));
    let _ = study.method("gauss", &pendulum);
}
