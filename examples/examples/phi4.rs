//! The φ⁴ field on a square lattice in a Langevin bath: its temperature, its correlations, and the
//! growth of its correlation length where the field is nearly ordered.
//!
//! V = Σ ½(∇q)² + ½ r q² + ¼ g q⁴ over the sites of a torus, friction −νv and a Wiener process of
//! strength σ at each site, with σ² = 2νT. The rule of Störmer and Verlet with this friction is the
//! step of Grønbech-Jensen and Farago (Mol. Phys. 111, 983, 2013). For linear forces it has the
//! exact distribution of q for each stable h, and ⟨p²⟩ = T (1 − h²ω²/4) for a mode of frequency ω.
//! In the mean over the sites, ω² is the mean of V″.
//!
//! Without the quartic term the field is Gaussian, and lattice sums give its correlations. With it,
//! ⟨q ∂V/∂q⟩ = T holds for the exact motion. For both, the checks show that what the step adds is
//! below the statistical errors. With two wells, the field orders when it is cold: towards that
//! temperature, the correlation length grows. A page with pictures is written to `target/phi4`.

use std::error::Error;
use std::f64::consts::TAU;
use std::process::ExitCode;

use indicatif::ProgressBar;
use sve_examples::cells::runs;
use sve_examples::check::Check;
use sve_examples::figure::{Axis, Figure, Layer, Panel, Pen, Row};
use sve_examples::hues;
use sve_examples::palette::{BLUE, Color, VERMILION};
use sve_examples::report::report;
use sve_runtime::prelude::*;

/// A field on a torus of `ny` rows and `nx` columns, in a bath.
#[derive(Clone, Copy)]
struct Phi4 {
    nx: usize,
    ny: usize,
    r: f64,
    g: f64,
    nu: f64,
    sigma: f64,
}

#[variational(stormer_verlet)]
impl Phi4 {
    fn well(&self, x: f64) -> f64 {
        0.5 * self.r * x * x + 0.25 * self.g * x.powi(4)
    }

    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..self.ny {
            for j in 0..self.nx {
                let here = i * self.nx + j;
                let right = q[i * self.nx + (j + 1) % self.nx];
                let below = q[(i + 1) % self.ny * self.nx + j];
                l += 0.5 * v[here] * v[here] - self.well(q[here]);
                l -= 0.5 * ((right - q[here]).powi(2) + (below - q[here]).powi(2));
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

impl Phi4 {
    fn new(side: usize, [r, g]: [f64; 2], temperature: f64) -> Self {
        Self {
            nx: side,
            ny: side,
            r,
            g,
            nu: NU,
            sigma: (2.0 * NU * temperature).sqrt(),
        }
    }

    /// Returns the means over the sites of p², q ∂V/∂q, ∂²V/∂q² and, for distances from 0, of the
    /// correlations of sites and of the means of rows and columns.
    fn means(&self, State { q, p, .. }: &State<Vec<f64>>) -> Vec<f64> {
        let n = q.len() as f64;
        let squares = shifted(q, 0);
        let quartic = self.g * q.iter().map(|q| q.powi(4)).sum::<f64>() / n;
        // over each bond, the product of a difference with itself
        let mut bonds = 2.0 * (squares - shifted(q, self.nx));
        for row in q.chunks(self.nx) {
            bonds += 2.0 * (shifted(row, 0) - shifted(row, 1)) / self.ny as f64;
        }
        let virial = bonds + self.r * squares + quartic;
        let curvature = 4.0 + self.r + 3.0 * self.g * squares;
        let mut means = vec![shifted(p, 0), virial, curvature];
        means.extend((0..REACH).map(|d| shifted(q, d * self.nx)));
        let rows: Vec<f64> = q.chunks(self.nx).map(|row| row.iter().sum()).collect();
        let mut columns = vec![0.0; self.nx];
        for row in q.chunks(self.nx) {
            columns.iter_mut().zip(row).for_each(|(c, q)| *c += q);
        }
        means.extend((0..REACH).map(|d| shifted(&rows, d) + shifted(&columns, d)));
        means
    }
}

/// Returns the mean of `x[k] x[k + by]` around a ring.
fn shifted(x: &[f64], by: usize) -> f64 {
    let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (head, tail) = x.split_at(by);
    let (start, end) = x.split_at(x.len() - by);
    (product(start, tail) + product(end, head)) / x.len() as f64
}

/// Step, friction, and the greatest distance of correlations.
const H: f64 = 0.2;
const NU: f64 = 0.5;
const REACH: usize = 40;

/// The time from one sample to the next, and the number of samples in a batch and of batches.
const APART: u64 = 50;
const BATCH: usize = 2;
const BATCHES: usize = 48;
/// Steps before the first sample.
const BEFORE: u64 = 1000;

/// The Gaussian field: its lattice, and the square of its mass.
const FREE_SIDE: usize = 512;
const MASS2: f64 = 0.1;

/// The φ⁴ field: r and g, the lattice of the averages and of the pictures, and temperatures.
const WELLS: [f64; 2] = [-1.27, 1.0];
const SIDE: usize = 400;
const PICTURE: usize = 512;
const TEMPERATURES: [f64; 6] = [1.1, 1.2, 1.35, 1.6, 2.0, 2.6];

/// Means of batches.
struct Batches(Vec<Vec<f64>>);

impl Batches {
    /// Returns a function of the means, and its standard error by the jackknife over the batches.
    fn estimate(&self, f: impl Fn(&[f64]) -> f64) -> (f64, f64) {
        let n = self.0.len() as f64;
        let sum = |k: usize| self.0.iter().map(|batch| batch[k]).sum::<f64>();
        let sums: Vec<f64> = (0..self.0[0].len()).map(sum).collect();
        let means: Vec<f64> = sums.iter().map(|sum| sum / n).collect();
        let without = |batch: &Vec<f64>| {
            let rest = sums.iter().zip(batch).map(|(sum, x)| (sum - x) / (n - 1.0));
            f(&rest.collect::<Vec<f64>>())
        };
        let parts: Vec<f64> = self.0.iter().map(without).collect();
        let mean = parts.iter().sum::<f64>() / n;
        let spread: f64 = parts.iter().map(|x| (x - mean).powi(2)).sum();
        (f(&means), ((n - 1.0) / n * spread).sqrt())
    }
}

/// Runs a field from rest at zero, and returns the means of its batches.
fn sampled(field: Phi4, seed: u64, bar: &ProgressBar) -> Result<Batches, StepError> {
    let n = field.nx * field.ny;
    let field = Integrator::new(field, StormerVerlet);
    let start = State::new(vec![0.0; n], vec![0.0; n]);
    let mut path = field.trajectory(start, H, Wiener::new(seed));
    path.advance(BEFORE)?;
    let mut batches = Vec::new();
    for _ in 0..BATCHES {
        let mut batch: Vec<f64> = Vec::new();
        for _ in 0..BATCH {
            let means = field.system().means(path.advance(APART)?);
            batch.resize(means.len(), 0.0);
            let parts = means.iter().map(|mean| mean / BATCH as f64);
            batch
                .iter_mut()
                .zip(parts)
                .for_each(|(sum, part)| *sum += part);
        }
        batches.push(batch);
        bar.inc(1);
    }
    Ok(Batches(batches))
}

/// Returns the distance in which the correlation of means of lines decays by e: they are those of a
/// chain, with one exponential for the Gaussian field, and nearly so for φ⁴.
fn length(means: &[f64]) -> f64 {
    let lines: Vec<f64> = means[3 + REACH..].iter().map(|c| c.ln()).collect();
    let end = lines[1] - 1.0;
    // a logarithm of a negative correlation is NaN, and the first value below the end comes before
    let Some(d) = (2..REACH).find(|&d| lines[d] <= end) else {
        return f64::NAN;
    };
    (d - 2) as f64 + (lines[d - 1] - end) / (lines[d - 1] - lines[d])
}

/// Returns the correlations of the Gaussian field at temperature 1.
fn exact_correlations() -> Vec<f64> {
    let n = FREE_SIDE;
    let wave = |k: usize| TAU * k as f64 / n as f64;
    let part = |k: usize| 2.0 - 2.0 * wave(k).cos();
    let over = |k: usize| {
        (0..n)
            .map(|l| 1.0 / (MASS2 + part(k) + part(l)))
            .sum::<f64>()
    };
    let sums: Vec<f64> = (0..n).map(over).collect();
    let at = |d: usize| (0..n).map(|k| sums[k] * wave(k * d % n).cos()).sum::<f64>();
    (0..REACH).map(|d| at(d) / (n * n) as f64).collect()
}

/// Returns a field that starts at rest at zero, after some steps.
fn pictured(temperature: f64, steps: u64) -> Result<Vec<f64>, StepError> {
    let field = Integrator::new(Phi4::new(PICTURE, WELLS, temperature), StormerVerlet);
    let zero = vec![0.0; PICTURE * PICTURE];
    let mut path = field.trajectory(State::new(zero.clone(), zero), H, Wiener::new(99));
    Ok(path.advance(steps)?.q.clone())
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let field = Integrator::new(Phi4::new(PICTURE, WELLS, 1.0), StormerVerlet);
    println!("{}\n", field.plan());
    let zeros = vec![0.0; PICTURE * PICTURE];
    println!("{}\n", field.layout(&State::new(zeros.clone(), zeros), H)?);
    let bar = ProgressBar::new((BATCHES * (1 + TEMPERATURES.len())) as u64);
    let free = sampled(Phi4::new(FREE_SIDE, [MASS2, 0.0], 1.0), 1, &bar)?;
    let (mut hot, mut virial, mut inverse) = (0.0f64, 0.0f64, Vec::new());
    for (t, seed) in TEMPERATURES.into_iter().zip(2..) {
        let batches = sampled(Phi4::new(SIDE, WELLS, t), seed, &bar)?;
        let squared = |(value, error): (f64, f64)| (value / error).powi(2);
        let kinetic = batches.estimate(|m| m[0] / t - 1.0 + H * H * m[2] / 4.0);
        hot += squared(kinetic);
        virial += squared(batches.estimate(|m| m[1] / t - 1.0));
        let (value, error) = batches.estimate(|m| 1.0 / length(m));
        inverse.push((t, value, error));
    }
    bar.finish_and_clear();

    let exact = exact_correlations();
    let measured: Vec<_> = (0..REACH).map(|d| free.estimate(|m| m[3 + d])).collect();
    let far = measured
        .iter()
        .zip(&exact)
        .map(|((c, error), exact)| ((c - exact) / error).abs());
    let (kinetic, kinetic_error) = free.estimate(|m| m[0]);
    let (xi, xi_error) = free.estimate(length);
    let rises = |pair: &&[(f64, f64, f64)]| {
        let [(_, near, a), (_, far, b)] = [pair[0], pair[1]];
        far - near > 3.0 * a.hypot(b)
    };
    let rising = inverse.windows(2).filter(rises).count();
    let chi = "6 temperatures: one run in 1000 has more";
    let three = "3 standard errors";
    let checks = [
        Check::new("Gaussian field: ⟨p²⟩ / T", kinetic).near(
            1.0 - H * H * (4.0 + MASS2) / 4.0,
            3.0 * kinetic_error,
            three,
        ),
        Check::new("Gaussian field: ⟨q²⟩", measured[0].0).near(
            exact[0],
            3.0 * measured[0].1,
            three,
        ),
        Check::new(
            "its farthest correlation, in standard errors",
            far.fold(0.0, f64::max),
        )
        .near(0.0, 4.0, "the largest of 40: one run in 400 has more"),
        // lines have a chain's mass: 2 sinh(1/2ξ) = m
        Check::new("its correlation length", xi).near(
            0.5 / (0.5 * MASS2.sqrt()).asinh(),
            3.0 * xi_error,
            three,
        ),
        Check::new("φ⁴: χ² of ⟨p²⟩ = T (1 − h²⟨V″⟩/4)", hot).near(0.0, 22.5, chi),
        Check::new("φ⁴: χ² of ⟨q ∂V/∂q⟩ = T", virial).near(0.0, 22.5, chi),
        Check::new("steps of 1/ξ that rise with T, of 5", rising as f64).near(
            5.0,
            0.0,
            "each by 3 standard errors and more",
        ),
    ];
    let caption = "Above: the φ⁴ field with r = −1.27 and g = 1 on 512 × 512 sites, from rest at zero, seed 99. At T = 0.5 the field orders. Colours are means over blocks of 8 × 8 sites: blue below −0.6, light blue to 0, light orange to 0.6, orange above. Below: correlations of the Gaussian field on 512 × 512 sites, seed 1, against lattice sums, and the inverse correlation length of φ⁴ on 400 × 400 sites, seeds 2 to 7. Bars are ± 2 standard errors. h = 0.2, ν = 0.5.";
    let fields = [pictured(0.5, 300)?, pictured(1.1, 1500)?];
    let rows = vec![
        Row {
            height: 440,
            panels: vec![
                image("Field at T = 0.5, t = 60", &fields[0]),
                image("Field at T = 1.1, t = 300", &fields[1]),
            ],
        },
        Row {
            height: 360,
            panels: vec![correlations(&measured, &exact), lengths(&inverse)],
        },
    ];
    let figure = Figure {
        name: "phi4",
        width: 900,
        rows,
    };
    report("The φ⁴ field in a bath", &figure, caption, &checks)
}

/// Draws the means of blocks of sites in four colours.
fn image(title: &str, field: &[f64]) -> Panel {
    const CELL: usize = 8;
    let side = 0.0..PICTURE as f64;
    let axis = |name| Axis::new(name, side.clone());
    let light = |(r, g, b): Color| [r, g, b].map(|c: u8| c / 2 + 127).into();
    let colors = [BLUE, light(BLUE), light(VERMILION), VERMILION];
    let mut cells = Vec::new();
    for rows in field.chunks(CELL * PICTURE) {
        for j in (0..PICTURE).step_by(CELL) {
            let sum: f64 = rows.chunks(PICTURE).flat_map(|row| &row[j..j + CELL]).sum();
            let mean = sum / (CELL * CELL) as f64;
            cells.push(Some([-0.6, 0.0, 0.6].iter().filter(|&&x| mean > x).count()));
        }
    }
    let panel = Panel::new(title, axis("column"), axis("row")).equal();
    // a row of cells is nearly 6 pixels high; lines that overlap by a pixel leave no seams
    let lines = runs::<4>(&cells, PICTURE / CELL, &side, &side);
    let layers = lines.into_iter().zip(colors);
    layers.fold(panel, |panel, (line, color)| {
        panel.with(Layer::new("", line, Pen::line(color, 6.75)))
    })
}

fn correlations(measured: &[(f64, f64)], exact: &[f64]) -> Panel {
    let near = 13;
    let (mut dots, mut ends) = (Vec::new(), Vec::new());
    for (d, ((c, error), exact)) in measured.iter().zip(exact).take(near).enumerate() {
        dots.push((d as f64, c / exact - 1.0));
        ends.push((
            (c - 2.0 * error) / exact - 1.0,
            (c + 2.0 * error) / exact - 1.0,
        ));
    }
    let zero = vec![(0.0, 0.0), (near as f64, 0.0)];
    Panel::new(
        "Correlations of the Gaussian field, m² = 0.1",
        Axis::new("distance along an axis", 0.0..near as f64),
        Axis::new("sampled / exact − 1", -0.2..0.2),
    )
    .with(Layer::new("exact", zero, Pen::line(hues::EXACT, 1.2)))
    .with(Layer::new("sampled", dots, Pen::dots(BLUE, 2.6)).bars(ends))
}

fn lengths(inverse: &[(f64, f64, f64)]) -> Panel {
    let ends = inverse
        .iter()
        .map(|(_, y, error)| (y - 2.0 * error, y + 2.0 * error));
    let dots = inverse.iter().map(|p| (p.0, p.1)).collect();
    Panel::new(
        "Inverse correlation length of φ⁴",
        Axis::new("temperature T", 1.0..2.7),
        Axis::new("1/ξ (1/site)", 0.0..0.8),
    )
    .with(Layer::new("sampled", dots, Pen::dots(VERMILION, 2.6)).bars(ends.collect()))
}
