//! Momenta of symmetries: their values, and what is said about them.

use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;

use crate::common::{Numbers, numbers, spread};
use crate::symmetric::{
    centred, charges, pairs, planar, positive, ring, rotors, rows, stars, vectors,
};

/// A site that moves along a direction.
trait Moved: Numbers {
    fn moved(self, by: f64, along: Self) -> Self;
}

impl Moved for f64 {
    fn moved(self, by: f64, along: f64) -> f64 {
        self + by * along
    }
}

impl<const D: usize> Moved for [f64; D] {
    fn moved(self, by: f64, along: Self) -> Self {
        std::array::from_fn(|k| self[k] + by * along[k])
    }
}

impl Moved for Vector3<f64> {
    fn moved(self, by: f64, along: Self) -> Self {
        self + by * along
    }
}

fn moved<Q: Moved>(sites: &[Q], by: f64, along: &[Q]) -> Vec<Q> {
    let pairs = sites.iter().zip(along);
    pairs.map(|(&site, &along)| site.moved(by, along)).collect()
}

/// Checks the momenta of a scene against those of the unrolled system and against the user's own
/// generators; and that the user's own L does not change along them.
macro_rules! assert_momenta {
    (
        $module:ident { $($field:ident: $value:expr),* $(,)? }, $q:expr, $p:expr,
        $($generator:ident $momentum:ident),+
    ) => {{
        let scene = $module::scene::System { $($field: $value),* };
        let unrolled = $module::unrolled::System { $($field: $value),* };
        let (q, p) = ($q, $p);
        let (state, of_unrolled) = (State::at(0.3, q.to_vec(), p.to_vec()), State::at(0.3, q, p));
        $(
            let found = scene.$momentum(&state).expect("a momentum");
            let along = scene.$generator(&state.q);
            let products = numbers(&along).into_iter().zip(numbers(&state.p)).map(|(x, p)| x * p);
            let (sum, size) = products.fold((0.0, 0.0), |(sum, size), x| (sum + x, size + x.abs()));
            let expected = unrolled.$momentum(&of_unrolled);
            assert!((found - expected).abs() <= 1e-14 * size, "{found} {expected}");
            assert!((found - sum).abs() <= 1e-14 * size, "{found} {sum}");
            assert!(found.abs() > 1e-3 * size, "{found} {size}");
            // ξ is affine, so Dξ v is a difference
            let v = state.p.clone();
            let next = scene.$generator(&moved(&state.q, 1.0, &v));
            let along_v = moved(&next, -1.0, &along);
            let l = |by: f64| {
                scene.lagrangian(&moved(&state.q, by, &along), &moved(&v, by, &along_v))
            };
            let (change, l) = ((l(1e-5) - l(-1e-5)) / 2e-5, l(0.0));
            assert!(change.abs() < 1e-9 * (1.0 + l.abs()), "{change}");
        )+
    }};
}

#[test]
fn momenta_are_those_of_unrolled_systems() {
    let (mass, sigma) = (positive(7, 3), 0.2);
    assert_momenta!(
        ring { mass: mass.clone(), beta: 0.4, sigma: sigma },
        rows::<7>(1), rows::<7>(2), shift shift_momentum
    );
    assert_momenta!(
        stars { m: mass.clone(), sigma: sigma },
        vectors::<5>(3), vectors::<5>(4), along along_momentum, turn turn_momentum
    );
    assert_momenta!(planar { k: 0.7 }, pairs::<4>(5), pairs::<4>(6), turn turn_momentum);
    assert_momenta!(
        rotors { j: 0.8, weight: mass.clone() },
        rows::<6>(7), rows::<6>(8), angle angle_momentum
    );
    assert_momenta!(
        centred { k: 0.6 },
        pairs::<4>(11), pairs::<4>(12), turn turn_momentum, shift shift_momentum
    );
    assert_momenta!(
        charges { charge: mass.clone() },
        rows::<4>(9), rows::<4>(10), phase phase_momentum
    );
}

/// A symmetry changes no bit of a step.
#[test]
fn steps_do_not_depend_on_symmetries() {
    macro_rules! bodies {
        ($name:ident $($symmetry:tt)*) => {
            struct $name;
            #[variational(stormer_verlet)]
            impl $name {
                fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
                    let mut l = 0.0;
                    for i in 0..q.len() {
                        l += 0.5 * (v[i][0].powi(2) + v[i][1].powi(2));
                        l -= (q[i][0].powi(2) + q[i][1].powi(2)).powi(2);
                    }
                    for i in 1..q.len() {
                        let (x, y) = (q[i][0] - q[i - 1][0], q[i][1] - q[i - 1][1]);
                        l -= (1.0 + x * x + y * y).ln();
                    }
                    l
                }
                $($symmetry)*
            }
        };
    }
    bodies!(Plain);
    bodies!(Symmetric #[symmetry] fn turn(&self, q: &[[f64; 2]]) -> Vec<[f64; 2]> {
        q.iter().map(|q| [-q[1], q[0]]).collect()
    });
    let start = State::new(pairs::<40>(1).to_vec(), pairs::<40>(2).to_vec());
    let plain = Integrator::new(Plain, StormerVerlet);
    let symmetric = Integrator::new(Symmetric, StormerVerlet);
    let mut path = plain.trajectory(start.clone(), 0.05, NoNoise);
    let expected = path.advance(100).expect("steps").clone();
    let mut path = symmetric.trajectory(start, 0.05, NoNoise);
    assert_eq!(path.advance(100).expect("steps"), &expected);
}

#[test]
fn the_plan_lists_what_steps_conserve() {
    let stars = stars::scene::System {
        m: vec![1.0; 3],
        sigma: 0.1,
    };
    let plan = Integrator::new(&stars, StormerVerlet).plan();
    assert_eq!(plan.conserved, ["along_momentum", "turn_momentum"]);
    let text = plan.to_string();
    let line = "conserved turn_momentum += −2·p[i][0]·(q[i][1] + q[i][2]/4) for i in 0..q.len()";
    assert!(text.contains(line), "{text}");
    assert!(
        text.contains("the symmetry turn is checked, not proved"),
        "{text}"
    );
    assert!(!text.contains("the symmetry along is"), "{text}");
    let composed = Integrator::new(&stars, Split::new(BlanesMoan4)).plan();
    assert_eq!(composed.conserved, ["along_momentum", "turn_momentum"]);
}

/// The sum of numbers that are added to eight partial sums in turn, and these in pairs.
fn in_eight_parts(numbers: &[f64]) -> f64 {
    let mut parts = [0.0; 8];
    for (at, x) in numbers.iter().enumerate() {
        parts[at % 8] += x;
    }
    let [a, b, c, d, e, f, g, h] = parts;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// Scenes of which one has the energy Σq and the other (Σq)².
mod weights {
    use sve_runtime::prelude::*;

    pub(crate) struct Alone;

    #[variational(endpoint)]
    impl Alone {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            (0..q.len()).map(|i| 0.5 * v[i] * v[i] - q[i]).sum()
        }
    }

    pub(crate) struct Squared;

    #[variational(endpoint)]
    impl Squared {
        fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
            let kinetic: f64 = (0..q.len()).map(|i| 0.5 * v[i] * v[i]).sum();
            let total: f64 = q.iter().sum();
            kinetic - total * total
        }
    }
}

/// The energy, and a sum that enters a formula.
#[test]
fn sums_over_sites_have_the_bits_of_eight_partial_sums() {
    let n = 1003;
    let state = State::new(spread(n, 1), vec![0.0; n]);
    let (sum, plain) = (in_eight_parts(&state.q), state.q.iter().sum::<f64>());
    assert_ne!(sum.to_bits(), plain.to_bits());
    let alone = weights::Alone.hamiltonian(&state).expect("an energy");
    assert_eq!(alone.to_bits(), sum.to_bits());
    let squared = weights::Squared.hamiltonian(&state).expect("an energy");
    assert_eq!(squared.to_bits(), (sum * sum).to_bits());
    let flow = Integrator::new(weights::Squared, Endpoint);
    let mut after = state.clone();
    flow.step(&mut after, 0.5, &[]).expect("a step");
    assert_eq!(after.p[7].to_bits(), (-0.5 * (2.0 * sum)).to_bits());
}

#[test]
fn a_momentum_has_the_bits_of_eight_partial_sums() {
    let n = 1003;
    let ring = ring::scene::System {
        mass: vec![1.0; n],
        beta: 0.0,
        sigma: 0.0,
    };
    let state = State::new(spread(n, 1), spread(n, 2));
    let expected = in_eight_parts(&state.p);
    let found: f64 = ring.shift_momentum(&state).expect("a momentum");
    assert_eq!(found.to_bits(), expected.to_bits());
    let plain: f64 = state.p.iter().sum();
    assert_ne!(found.to_bits(), plain.to_bits());
}

/// A generator with as many entries as `charge` says, and at other places.
struct Short {
    charge: Vec<f64>,
}

#[variational(endpoint)]
impl Short {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        (0..q.len()).map(|i| 0.5 * v[i] * v[i]).sum()
    }

    #[symmetry]
    fn phase(&self, _q: &[f64]) -> Vec<f64> {
        self.charge.clone()
    }

    #[symmetry]
    fn shift(&self, q: &[f64]) -> Vec<f64> {
        (2..q.len() + 2)
            .map(|i| {
                if i < 4 {
                    self.charge[i - 2]
                } else {
                    self.charge[i]
                }
            })
            .collect()
    }
}

#[test]
fn a_generator_has_an_entry_for_each_site() {
    let at = |length: usize| Short {
        charge: positive(length, 1),
    };
    let state = State::at(0.5, vec![0.0; 3], vec![1.0, 2.0, 4.0]);
    let sum = at(3).phase_momentum(&state).expect("a momentum");
    let charge = positive(3, 1);
    assert_eq!(sum, (charge[0] + charge[2] * 4.0) + charge[1] * 2.0);
    for length in [0, 2, 4] {
        let error = at(length)
            .phase_momentum(&state)
            .expect_err("another length");
        let what = "the result of `phase`".into();
        let expected = StepError::Length {
            t: 0.5,
            what,
            found: length,
            expected: 3,
        };
        assert_eq!(error, expected);
    }
    let shifted = at(5).shift_momentum(&state).expect("a momentum");
    let charge = positive(5, 1);
    assert_eq!(shifted, (charge[0] + charge[4] * 4.0) + charge[1] * 2.0);
    let error = at(4).shift_momentum(&state).expect_err("an index");
    let text = "`self.charge[i]` in `shift` (i = 4)".into();
    assert_eq!(
        error,
        StepError::Index {
            t: 0.5,
            text,
            index: 4,
            length: 4
        }
    );
    let unequal = State::new(vec![0.0; 3], vec![1.0; 2]);
    let error = at(3)
        .phase_momentum(&unequal)
        .expect_err("momenta are missing");
    assert!(
        matches!(
            error,
            StepError::Length {
                found: 2,
                expected: 3,
                ..
            }
        ),
        "{error}"
    );
}
