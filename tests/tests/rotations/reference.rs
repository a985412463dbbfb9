//! Steps of a rigid body computed elsewhere with 40-digit arithmetic, independently of this project.

use serde::Deserialize;
use sve_runtime::nalgebra::Quaternion;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

use crate::systems::{FreeBody, NoisyBody};

#[derive(Deserialize)]
struct Path {
    params: Parameters,
    h: f64,
    dw: Vec<Vec<f64>>,
    states: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Parameters {
    #[serde(rename = "I")]
    i: [f64; 3],
    chi: Option<[f64; 3]>,
    #[serde(rename = "K")]
    k: Option<[f64; 3]>,
}

fn state(values: &[f64]) -> State<UnitQuaternion<f64>> {
    let q = Quaternion::new(values[0], values[1], values[2], values[3]);
    State::new(
        UnitQuaternion::new_unchecked(q),
        Vector3::new(values[4], values[5], values[6]),
    )
}

/// Returns the largest error along a run, relative to the largest component.
fn error<S, const M: usize>(system: S, run: &Path) -> f64
where
    S: Variational<Midpoint> + System<Dims = Dims<3, M, UnitQuaternion<f64>>>,
{
    let integrator = Integrator::new(system, Midpoint);
    let mut found = state(&run.states[0]);
    let mut worst: f64 = 0.0;
    for (dw, values) in run.dw.iter().zip(&run.states[1..]) {
        let dw: &[f64; M] = dw.as_slice().try_into().unwrap();
        integrator.step(&mut found, run.h, dw).unwrap();
        let size = values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let expected = state(values);
        let q = (found.q.coords - expected.q.coords).amax();
        worst = worst.max(q.max((found.p - expected.p).amax()) / size);
    }
    worst
}

#[test]
fn steps_of_a_rigid_body_agree_with_forty_digits() {
    let path = format!("{}/data/rigid_body.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let runs: Vec<Path> = serde_json::from_str(&text).unwrap();
    let mut noisy = 0;
    for run in &runs {
        assert!(run.dw.len() == 60 && run.states.len() == 61);
        let i = Vector3::from(run.params.i);
        let worst = match (run.params.chi, run.params.k) {
            (Some(chi), Some(k)) => {
                noisy += 1;
                let (chi, k) = (Vector3::from(chi), Vector3::from(k));
                error(NoisyBody { i, chi, k }, run)
            }
            _ => error(FreeBody { i }, run),
        };
        println!("{worst:e}");
        assert!(worst < 1e-12, "{worst:e}");
    }
    assert_eq!((runs.len(), noisy), (2, 1));
}
