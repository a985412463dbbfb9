//! The chain in a heat bath of temperature T: each mode has the energy of equipartition.
//!
//! With a friction −νv and a Wiener process of strength σ at each mass, σ² = 2νT, a step of Störmer
//! and Verlet is that of Grønbech-Jensen and Farago (Mol. Phys. 111, 983, 2013). For linear springs
//! it has ⟨ω²Q²⟩ = T of each mode for each stable h, and ⟨P²⟩ = T (1 − h²ω²/4).
//!
//! Springs with terms of higher degree couple the modes. ⟨Q ∂V/∂Q⟩ = T holds for each mode, and ⟨q
//! ∂V/∂q⟩ = T for each mass. The lengths of all springs have the same distribution, under the
//! condition that their sum is 0, so that ⟨ω²Q²⟩ has the same value for all modes: of N springs
//! with the density w it is ⟨d²⟩ N/(N − 1), with ⟨d²⟩ = ∫ W₂ Wᴺ⁻¹ dk / ∫ Wᴺ dk where W and W₂ are
//! the Fourier transforms of w and d²w.

use indicatif::ProgressBar;
use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Layer, Panel, Pen, Shape};
use sve_examples::hues;
use sve_examples::palette::{BLUE, Color, ORANGE, PURPLE};
use sve_runtime::prelude::*;

use crate::{ALPHA, MASSES, Mode};

/// Masses of 1 between walls in a bath, with springs of the force d + α d² + β d³.
struct Heated {
    alpha: f64,
    beta: f64,
    nu: f64,
    sigma: f64,
}

#[variational(stormer_verlet)]
impl Heated {
    fn spring(&self, d: f64) -> f64 {
        0.5 * d * d + self.alpha * d.powi(3) / 3.0 + 0.25 * self.beta * d.powi(4)
    }

    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for i in 0..n {
            // the left spring of each mass, and the right one of the last
            if i == 0 {
                l -= self.spring(q[i]);
            } else {
                l -= self.spring(q[i] - q[i - 1]);
            }
            if i == n - 1 {
                l -= self.spring(-q[i]);
            }
        }
        l
    }

    #[gamma]
    fn bath(&self, q: &[f64]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * q).collect()
    }

    #[force]
    fn friction(&self, _q: &[f64], v: &[f64]) -> Vec<f64> {
        v.iter().map(|v| -self.nu * v).collect()
    }
}

/// Temperature and friction.
const TEMPERATURE: f64 = 1.0;
const NU: f64 = 0.2;

/// Steps of the chains, each with the number of steps from one sample to the next. With linear
/// springs a long one is exact too, but for the factor of ⟨P²⟩.
const LONG: (f64, u64) = (0.4, 3);
const SHORT: (f64, u64) = (0.1, 12);

/// The fourth-degree term of the springs that are not linear. With the cubic term alone, the energy
/// of a spring would have no minimum.
const BETA: f64 = 1.0;

/// Independent paths, and of each the numbers of samples that are left out at first and taken.
const PATHS: u64 = 600;
const BEFORE: u64 = 125;
const SAMPLES: u64 = 500;

impl Heated {
    fn new([alpha, beta]: [f64; 2]) -> Self {
        Self {
            alpha,
            beta,
            nu: NU,
            sigma: (2.0 * NU * TEMPERATURE).sqrt(),
        }
    }

    /// Returns ∂V/∂q, and the mean of ∂²V/∂q² over the masses.
    fn slope(&self, q: &[f64]) -> (Vec<f64>, f64) {
        let n = q.len();
        let at = |i: usize| if i == 0 || i > n { 0.0 } else { q[i - 1] };
        let lengths: Vec<f64> = (0..=n).map(|i| at(i + 1) - at(i)).collect();
        let force = |d: f64| d + self.alpha * d * d + self.beta * d.powi(3);
        let stiffness = |d: f64| 1.0 + 2.0 * self.alpha * d + 3.0 * self.beta * d * d;
        let slope = lengths.windows(2).map(|d| force(d[0]) - force(d[1]));
        let curvature = lengths
            .windows(2)
            .map(|d| stiffness(d[0]) + stiffness(d[1]));
        (slope.collect(), curvature.sum::<f64>() / n as f64)
    }
}

/// Averages over the time along one path, in parts of T.
struct Averages {
    /// ω²Q², P² and Q ∂V/∂Q of each mode, and q ∂V/∂q of each mass.
    parts: [Vec<f64>; 4],
    /// P² in the mean over the modes, less T (1 − h² ⟨∂²V/∂q²⟩ / 4).
    kinetic: f64,
}

/// Averages of independent paths of one chain with steps of length `h`.
struct Sampled {
    h: f64,
    modes: Vec<Mode>,
    paths: Vec<Averages>,
}

impl Sampled {
    /// Runs the paths of a chain with these coefficients of its springs.
    fn new(
        springs: [f64; 2],
        (h, apart): (f64, u64),
        bar: &ProgressBar,
    ) -> Result<Self, StepError> {
        let modes: Vec<Mode> = (1..=MASSES).map(|k| Mode::new(k, MASSES)).collect();
        let chain = Integrator::new(Heated::new(springs), StormerVerlet);
        let mut paths = Vec::new();
        for path in 0..PATHS {
            let start = State::new(vec![0.0; MASSES], vec![0.0; MASSES]);
            let mut path = chain.trajectory(start, h, Wiener::new(4).path(path));
            path.advance(BEFORE * apart)?;
            let mut mean = Averages {
                parts: [(); 4].map(|()| vec![0.0; MASSES]),
                kinetic: 0.0,
            };
            for _ in 0..SAMPLES {
                mean.add(chain.system(), (&modes, h), path.advance(apart)?);
            }
            paths.push(mean);
            bar.inc(1);
        }
        Ok(Self { h, modes, paths })
    }

    /// Returns the mean over the paths and its standard error.
    fn mean(&self, of: impl Fn(&Averages) -> f64) -> (f64, f64) {
        let n = self.paths.len() as f64;
        let mean = self.paths.iter().map(&of).sum::<f64>() / n;
        let squares = self.paths.iter().map(|path| (of(path) - mean).powi(2));
        (mean, (squares.sum::<f64>() / (n * (n - 1.0))).sqrt())
    }

    /// Returns a part of the averages for each mode or mass, with its standard error.
    fn part(&self, part: usize) -> Vec<(f64, f64)> {
        (0..MASSES)
            .map(|k| self.mean(|path| path.parts[part][k]))
            .collect()
    }

    /// Returns the exact ⟨P²⟩/T of a mode of linear springs.
    fn of_step(&self, mode: &Mode) -> f64 {
        1.0 - (self.h * mode.frequency).powi(2) / 4.0
    }

    /// Returns the largest difference from an expected value, in standard errors.
    fn farthest(&self, part: usize, expected: impl Fn(&Mode) -> f64) -> f64 {
        let parts = self.part(part).into_iter().zip(&self.modes);
        let far = parts.map(|((mean, error), mode)| ((mean - expected(mode)) / error).abs());
        far.fold(0.0, f64::max)
    }
}

impl Averages {
    fn add(&mut self, chain: &Heated, (modes, h): (&[Mode], f64), state: &State<Vec<f64>>) {
        let State { q, p, .. } = state;
        let (slope, curvature) = chain.slope(q);
        let part = 1.0 / (TEMPERATURE * SAMPLES as f64);
        for (k, mode) in modes.iter().enumerate() {
            let [x, y, z] = [q, p, &slope].map(|of| mode.part(of));
            self.parts[0][k] += part * (mode.frequency * x).powi(2);
            self.parts[1][k] += part * y * y;
            self.parts[2][k] += part * x * z;
            self.parts[3][k] += part * q[k] * slope[k];
        }
        let squares = p.iter().map(|p| p * p).sum::<f64>() / p.len() as f64;
        self.kinetic += part * squares - (1.0 - h * h * curvature / 4.0) / SAMPLES as f64;
    }
}

/// Returns the exact ⟨ω²Q²⟩/T of the modes of the chain with springs that are not linear.
fn exact() -> f64 {
    let chain = Heated::new([ALPHA, BETA]);
    let (count, step) = (MASSES + 1, 0.01);
    // trapezoidal sums converge exponentially for functions that vanish at both ends
    let lengths: Vec<(f64, f64)> = (-600..=600)
        .map(|i| step * f64::from(i))
        .map(|d| (d, (-chain.spring(d) / TEMPERATURE).exp()))
        .collect();
    let all: f64 = lengths.iter().map(|(_, w)| w).sum();
    let (mut above, mut below) = (0.0, 0.0);
    for k in (-400..=400).map(|k| 0.02 * f64::from(k)) {
        // with a cubic term the density is not even: real and imaginary parts
        let over = |power: i32| {
            let part = |angle: fn(f64) -> f64| {
                let terms = lengths
                    .iter()
                    .map(|(d, w)| d.powi(power) * w * angle(k * d));
                terms.sum::<f64>() / all
            };
            (part(f64::cos), part(f64::sin))
        };
        let (of_one, of_square) = (over(0), over(2));
        let (size, angle) = (of_one.0.hypot(of_one.1), of_one.1.atan2(of_one.0));
        let rest = size.powi(count as i32 - 1);
        let turned = angle * (count - 1) as f64;
        above += rest * (of_square.0 * turned.cos() - of_square.1 * turned.sin());
        below += rest * size * (turned + angle).cos();
    }
    above / below * count as f64 / (count - 1) as f64 / TEMPERATURE
}

/// The chains with linear and with other springs.
pub(crate) struct Heats {
    linear: Sampled,
    other: Sampled,
    /// The exact ⟨ω²Q²⟩/T of the other springs.
    exact: f64,
}

impl Heats {
    pub(crate) fn new() -> Result<Self, StepError> {
        let bar = ProgressBar::new(2 * PATHS);
        let linear = Sampled::new([0.0, 0.0], LONG, &bar)?;
        let other = Sampled::new([ALPHA, BETA], SHORT, &bar)?;
        bar.finish_and_clear();
        let exact = exact();
        Ok(Self {
            linear,
            other,
            exact,
        })
    }

    pub(crate) fn checks(&self) -> Vec<Check> {
        let (linear, other) = (&self.linear, &self.other);
        let far = |name: &str, value: f64| {
            let many = "the largest of 31: one run in 500 has more";
            Check::new(name, value).near(0.0, 4.0, many)
        };
        let near = |name: &str, (value, error): (f64, f64), expected: f64| {
            Check::new(name, value).near(expected, 3.0 * error, "3 standard errors")
        };
        // the mean over the modes
        let over =
            |path: &Averages, part: usize| path.parts[part].iter().sum::<f64>() / MASSES as f64;
        let energy = linear.mean(|path| 0.5 * (over(path, 0) + over(path, 1)));
        // the mean of ω² over the modes is 2
        let expected = 1.0 - LONG.0 * LONG.0 / 4.0;
        vec![
            near("bath, linear: energy of a mode / T", energy, expected),
            far(
                "bath, linear: ω²⟨Q²⟩ = T, in standard errors",
                linear.farthest(0, |_| 1.0),
            ),
            far(
                "bath, linear: ⟨P²⟩ = T (1 − h²ω²/4), likewise",
                linear.farthest(1, |mode| linear.of_step(mode)),
            ),
            far(
                "bath, α and β: ⟨Q ∂V/∂Q⟩ = T of modes, likewise",
                other.farthest(2, |_| 1.0),
            ),
            far(
                "bath, α and β: ⟨q ∂V/∂q⟩ = T of masses, likewise",
                other.farthest(3, |_| 1.0),
            ),
            far(
                "bath, α and β: exact ω²⟨Q²⟩, likewise",
                other.farthest(0, |_| self.exact),
            ),
            near(
                "bath, α and β: ⟨Q ∂V/∂Q⟩/T, mean of the modes",
                other.mean(|path| over(path, 2)),
                1.0,
            ),
            near(
                "bath, α and β: ω²⟨Q²⟩/T, mean of the modes",
                other.mean(|path| over(path, 0)),
                self.exact,
            ),
            near(
                "bath, α and β: ⟨P²⟩/T − 1 + h²⟨V″⟩/4",
                other.mean(|path| path.kinetic),
                0.0,
            ),
        ]
    }

    /// Draws the parts of the energies of the modes.
    pub(crate) fn panels(&self) -> Vec<Panel> {
        let (linear, other) = (&self.linear, &self.other);
        let of_step = linear.modes.iter().map(|mode| linear.of_step(mode));
        let errors = |part: usize, exact: f64| -> Vec<(f64, f64)> {
            let parts = other.part(part).into_iter();
            parts
                .map(|(mean, error)| (mean / exact - 1.0, error / exact))
                .collect()
        };
        vec![
            panel(
                &format!("Linear springs in a bath, h = {}", LONG.0),
                Axis::new("in parts of T", 0.8..1.05),
            )
            .with(line(vec![1.0; MASSES]))
            .with(line(of_step.collect()))
            .with(dots("ω²⟨Q²⟩", (&linear.part(0), 0.0), BLUE, Shape::Disc))
            .with(dots("⟨P²⟩", (&linear.part(1), 0.0), ORANGE, Shape::Square)),
            panel(
                &format!("Springs with α and β in a bath, h = {}", SHORT.0),
                Axis::new("mean / exact − 1", -0.03..0.03),
            )
            .with(line(vec![0.0; MASSES]))
            .with(dots(
                "ω²⟨Q²⟩",
                (&errors(0, self.exact), -0.15),
                BLUE,
                Shape::Disc,
            ))
            .with(dots(
                "⟨Q ∂V/∂Q⟩",
                (&errors(2, 1.0), 0.15),
                PURPLE,
                Shape::Diamond,
            )),
        ]
    }
}

fn panel(title: &str, means: Axis) -> Panel {
    let modes = Axis::new("mode", 0.0..(MASSES + 1) as f64);
    Panel::new(title, modes, means).legend(Corner::Below)
}

fn numbered(parts: Vec<f64>) -> Vec<(f64, f64)> {
    let number = |(k, part)| ((k + 1) as f64, part);
    parts.into_iter().enumerate().map(number).collect()
}

fn line(parts: Vec<f64>) -> Layer {
    Layer::new("exact", numbered(parts), Pen::line(hues::EXACT, 1.2)).unlisted()
}

/// Returns means as symbols with bars of two standard errors to each side.
/// Returns means with their bars, moved to the right of their modes.
fn dots(name: &str, (parts, moved): (&[(f64, f64)], f64), color: Color, shape: Shape) -> Layer {
    let pen = Pen {
        line: None,
        ..Pen::line(color, 1.2).symbols(shape, MASSES)
    };
    let ends = parts
        .iter()
        .map(|(mean, error)| (mean - 2.0 * error, mean + 2.0 * error));
    let means = numbered(parts.iter().map(|part| part.0).collect());
    let points = means.into_iter().map(|(mode, mean)| (mode + moved, mean));
    Layer::new(name, points.collect(), pen).bars(ends.collect())
}
