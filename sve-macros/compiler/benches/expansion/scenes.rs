//! The scenes: families of systems of any size, as the text that a user would write.
//!
//! Input: a scene and its degrees of freedom. Output: the `impl` block, and a crate with the block
//! that takes steps and prints the time of one.

use std::fmt::Write as _;

/// A family of systems.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scene {
    /// Masses on a line with anharmonic springs between neighbours, the first tied to a wall.
    Chain,
    /// Rods that hang from one another, in their angles. The mass matrix, too, couples every
    /// coordinate to every other.
    Pendulum,
    /// Bodies that attract one another, and a fixed one at the origin. In the plane each body has
    /// two coordinates; an odd number of coordinates stands for this number of bodies on a line.
    Bodies,
}

impl Scene {
    pub(crate) const ALL: [Self; 3] = [Self::Chain, Self::Pendulum, Self::Bodies];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Chain => "chain",
            Self::Pendulum => "n-pendulum",
            Self::Bodies => "n-body",
        }
    }

    /// The rule to derive.
    pub(crate) const RULE: &'static str = "midpoint";

    /// Returns the `impl` block without its attribute.
    pub(crate) fn block(self, n: usize) -> String {
        let body = match self {
            Self::Chain => {
                "let mut l = -self.potential(q[0]);
                for i in 0..N { l += 0.5 * self.m * v[i].powi(2); }
                for i in 1..N { l -= self.potential(q[i] - q[i - 1]); }
                l"
            }
            Self::Pendulum => {
                "let mut l = 0.0;
                for i in 0..N {
                    let carried = self.m * (N - i) as f64;
                    l += 0.5 * carried * (self.l * v[i]).powi(2) - carried * self.potential(q[i]);
                    for j in 0..i { l += carried * self.l * self.l * v[i] * v[j] * (q[i] - q[j]).cos(); }
                }
                l"
            }
            Self::Bodies if n.is_multiple_of(2) => {
                "let mut l = 0.0;
                for i in 0..N / 2 {
                    let (x, y) = (q[2 * i], q[2 * i + 1]);
                    l += 0.5 * self.m * (v[2 * i].powi(2) + v[2 * i + 1].powi(2)) - self.potential(x.powi(2) + y.powi(2));
                    for j in 0..i { l -= self.potential((x - q[2 * j]).powi(2) + (y - q[2 * j + 1]).powi(2)); }
                }
                l"
            }
            Self::Bodies => {
                "let mut l = 0.0;
                for i in 0..N {
                    l += 0.5 * self.m * v[i].powi(2) - self.potential(q[i].powi(2));
                    for j in 0..i { l -= self.potential((q[i] - q[j]).powi(2)); }
                }
                l"
            }
        };
        let potential = match self {
            Self::Chain => "0.5 * self.k * x.powi(2) + 0.25 * self.l * x.powi(4)",
            // x is the angle
            Self::Pendulum => "-self.k * self.l * x.cos()",
            // x is the square of the distance
            Self::Bodies => "-self.k * self.m * self.m / (x + self.l * self.l).sqrt()",
        };
        format!(
            "impl Scene {{
                fn lagrangian(&self, q: [f64; N], v: [f64; N]) -> f64 {{ {body} }}
                fn potential(&self, x: f64) -> f64 {{ {potential} }}
            }}"
        )
        .replace('N', &n.to_string())
    }

    /// Returns a program that takes steps of the scene and prints the nanoseconds of one.
    pub(crate) fn program(self, n: usize) -> String {
        let mut positions = String::new();
        let mut momenta = String::new();
        for i in 0..n {
            let x = i as f64;
            let (q, p) = match self {
                Self::Chain => (0.3 * x.sin(), 0.2 * x.cos()),
                Self::Pendulum => (0.3 * x.sin(), 0.0),
                // each ring has two bodies, which without the others would move on circular orbits
                // around the origin
                Self::Bodies => {
                    let (radius, angle) = (1.0 + (i / 4) as f64, 2.4 * (i / 2) as f64);
                    let speed = 0.3 / radius.sqrt();
                    if i % 2 == 0 {
                        (radius * angle.cos(), -speed * angle.sin())
                    } else {
                        (radius * angle.sin(), speed * angle.cos())
                    }
                }
            };
            let _ = write!(positions, "{q:?},");
            let _ = write!(momenta, "{p:?},");
        }
        format!(
            "use std::time::Instant;
            use sve_runtime::prelude::*;
            pub struct Scene {{ pub m: f64, pub k: f64, pub l: f64 }}
            #[variational({rule})]
            {block}
            fn main() {{
                let scene = Integrator::new(Scene {{ m: 1.0, k: 1.0, l: 0.5 }}, Midpoint);
                let start = State::new([{positions}], [{momenta}]);
                let mut best = f64::INFINITY;
                for _ in 0..5 {{
                    let (mut state, mut steps, clock) = (start, 0, Instant::now());
                    while clock.elapsed().as_secs_f64() < 0.05 {{
                        for _ in 0..8 {{ scene.step(&mut state, 0.01, &[]).unwrap(); }}
                        steps += 8;
                    }}
                    best = best.min(clock.elapsed().as_secs_f64() / f64::from(steps));
                }}
                println!(\"{{}}\", best * 1e9);
            }}",
            rule = Self::RULE,
            block = self.block(n),
        )
    }
}
