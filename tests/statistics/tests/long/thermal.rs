//! Friction and noise on the manifold of constraints sample exp(−H/kT), with the volume of the
//! metric of the masses and no other weight.

use sve_models::models::Thermal;
use sve_runtime::prelude::*;

const PATHS: u64 = 100;

/// A double pendulum of rods without gravity in a heat bath: friction −ν v on each coordinate.
struct Rods {
    m: [f64; 2],
    nu: f64,
    temperature: f64,
}

#[variational(midpoint)]
impl Rods {
    fn lagrangian(&self, _q: [f64; 4], v: [f64; 4]) -> f64 {
        let [m1, m2] = self.m;
        0.5 * m1 * (v[0] * v[0] + v[1] * v[1]) + 0.5 * m2 * (v[2] * v[2] + v[3] * v[3])
    }

    #[force]
    fn friction(&self, _q: [f64; 4], v: [f64; 4]) -> [f64; 4] {
        [
            -self.nu * v[0],
            -self.nu * v[1],
            -self.nu * v[2],
            -self.nu * v[3],
        ]
    }

    #[gamma]
    fn bath(&self, q: [f64; 4]) -> [f64; 4] {
        let size = (2.0 * self.nu * self.temperature).sqrt();
        [size * q[0], size * q[1], size * q[2], size * q[3]]
    }

    #[constraint]
    fn rods(&self, q: [f64; 4]) -> [f64; 2] {
        let [x, y] = [q[2] - q[0], q[3] - q[1]];
        [
            0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0),
            0.5 * (x * x + y * y - 1.0),
        ]
    }
}

/// The mean over paths with its standard error.
fn mean(of_paths: &[f64]) -> [f64; 2] {
    let n = of_paths.len() as f64;
    let mean = of_paths.iter().sum::<f64>() / n;
    let squares: f64 = of_paths.iter().map(|x| (x - mean).powi(2)).sum();
    [mean, (squares / (n * (n - 1.0))).sqrt()]
}

fn check(what: &str, of_paths: &[f64], expected: f64, bias: f64) {
    let [mean, error] = mean(of_paths);
    println!("{what}: {mean:.4} ± {error:.4}, exact {expected:.4}");
    assert!(
        (mean - expected).abs() < bias + 3.0 * error,
        "{what}: {mean} ± {error}, {expected}"
    );
}

/// The height on the sphere: E z = 1/β − coth β; |p|² has two degrees of freedom.
#[test]
fn a_particle_on_the_sphere() {
    fn sample<R>(rule: R, bias: f64)
    where
        Thermal: sve_runtime::Variational<R>,
    {
        let thermal = Thermal {
            g: 1.0,
            nu: 1.0,
            temperature: 1.0,
        };
        let integrator = Integrator::new(thermal, rule);
        let start = State::new(Vector3::new(1.0, 0.0, 0.0), Vector3::zeros());
        let (mut heights, mut squares) = (Vec::new(), Vec::new());
        for path in 0..PATHS {
            let states = integrator.trajectory(start, 0.05, Wiener::new(8).path(path));
            let (mut height, mut square, count) = (0.0, 0.0, 3000);
            for state in states.skip(200).take(count) {
                let state = state.unwrap();
                height += state.q.z / count as f64;
                square += state.p.norm_squared() / count as f64;
            }
            heights.push(height);
            squares.push(square);
        }
        check("E z", &heights, 1.0 - 1.0 / 1.0_f64.tanh(), 0.2 * bias);
        check("E |p|²", &squares, 2.0, bias);
    }
    // h² of the symmetric rules, h of the others
    sample(Midpoint, 0.01);
    sample(StormerVerlet, 0.01);
    sample(InitialPoint, 0.06);
    sample(Endpoint, 0.06);
}

/// The angle between the rods has the density √det M of the masses: with masses 1 and 5 the mean of
/// cos 2(θ₁ − θ₂) is `∫ cos 2x √(1 + 5 sin² x) dx / ∫ √(1 + 5 sin² x) dx`, and 0 without that
/// weight.
#[test]
fn the_angle_between_two_rods() {
    let rods = Rods {
        m: [1.0, 5.0],
        nu: 2.0,
        temperature: 1.0,
    };
    let integrator = Integrator::new(rods, Midpoint);
    let start = State::new([0.0, -1.0, 0.6, -1.8], [0.0; 4]);
    let (mut angles, mut energies) = (Vec::new(), Vec::new());
    for path in 0..PATHS {
        let states = integrator.trajectory(start, 0.02, Wiener::new(9).path(path));
        let (mut angle, mut energy, count) = (0.0, 0.0, 10_000);
        for state in states.skip(1000).take(count) {
            let state = state.unwrap();
            let [x, y] = [state.q[2] - state.q[0], state.q[3] - state.q[1]];
            let cos = state.q[0] * x + state.q[1] * y;
            angle += (2.0 * cos * cos - 1.0) / count as f64;
            energy += 2.0 * integrator.system().hamiltonian(&state).unwrap() / count as f64;
        }
        angles.push(angle);
        energies.push(energy);
    }
    let weight = |x: f64| (1.0 + 5.0 * x.sin().powi(2)).sqrt();
    let points = (0..1000).map(|k| f64::from(k) * std::f64::consts::PI / 1000.0);
    let (mut above, mut below) = (0.0, 0.0);
    for x in points {
        above += (2.0 * x).cos() * weight(x);
        below += weight(x);
    }
    assert!((above / below + 0.1966).abs() < 1e-4, "{}", above / below);
    check("E cos 2(θ₁ − θ₂)", &angles, above / below, 0.004);
    check("2 E K", &energies, 2.0, 0.02);
}
