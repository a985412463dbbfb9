//! The Pythagorean problem of three bodies with close encounters.

use sve_runtime::prelude::*;

/// Masses 3, 4 and 5 at the corners of a triangle with these sides, at rest.
struct Bodies {
    m: [f64; 3],
}

#[variational(gauss(8))]
impl Bodies {
    fn lagrangian(&self, q: [[f64; 2]; 3], v: [[f64; 2]; 3]) -> f64 {
        let mut l = 0.0;
        for i in 0..3 {
            l += 0.5 * self.m[i] * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
            for j in 0..i {
                let r = (q[i][0] - q[j][0]).hypot(q[i][1] - q[j][1]);
                l += self.m[i] * self.m[j] / r;
            }
        }
        l
    }

    #[time_scale]
    fn scale(&self, q: [[f64; 2]; 3]) -> f64 {
        let mut rates = 0.0;
        for i in 0..3 {
            for j in 0..i {
                let r = (q[i][0] - q[j][0]).hypot(q[i][1] - q[j][1]);
                rates += (self.m[i] + self.m[j]) / (r * r * r);
            }
        }
        rates.sqrt().recip()
    }
}

fn end(h: f64) -> (State<[[f64; 2]; 3]>, u64) {
    let bodies = Integrator::new(Bodies { m: [3.0, 4.0, 5.0] }, Gauss::<8>);
    let (q, p) = ([[1.0, 3.0], [-2.0, -1.0], [1.0, -1.0]], [[0.0; 2]; 3]);
    let start = TimedState::new(bodies.system(), q, p).expect("a time scale");
    let mut path = bodies.trajectory(start, h, NoNoise).until(20.0);
    let end = path.by_ref().last().expect("a state").expect("a step");
    (end, path.step())
}

/// The places at t = 20, by the same rule in 64-bit mantissas: four step sizes agree to 2·10⁻¹⁵.
const END: [f64; 6] = [
    3.004_292_636_696_399,
    0.511_925_235_024_685_6,
    -1.388_626_537_510_895,
    -0.470_476_050_252_722_1,
    -0.691_674_352_009_123_2,
    0.069_225_699_187_366_2,
];

/// Rounding errors grow by some thousand times in the encounters.
#[test]
fn the_pythagorean_problem_is_solved_through_its_encounters() {
    for h in [0.35, 0.3] {
        let (end, steps) = end(h);
        assert!(steps < 300, "{steps}");
        let q = end.q.as_flattened().iter().zip(END);
        let error = q.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(error < 1e-12, "{h} {error:e}");
    }
}
