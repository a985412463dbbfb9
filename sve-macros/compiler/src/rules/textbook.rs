//! Actions in their textbook form, with L, γ, H₁ and F as functions of the variables at the nodes.

use crate::model::NodeQuantity;

/// The notation of a node, without components: `q̄`.
#[derive(Clone, Copy)]
pub(crate) struct Point {
    pub(crate) time: &'static str,
    pub(crate) position: &'static str,
    pub(crate) velocity: &'static str,
    /// The definitions of these symbols, if they differ from the notation.
    pub(super) time_is: Option<&'static str>,
    pub(super) others_are: &'static [&'static str],
}

/// The start of the step.
pub(super) const START: Point = Point {
    time: "t₀",
    position: "q₀",
    velocity: "v",
    time_is: None,
    others_are: &[],
};

/// The end of the step.
pub(super) const END: Point = Point {
    time: "t₁",
    position: "q₁",
    time_is: Some("t₁ = t₀ + h"),
    ..START
};

/// The middle of the step.
pub(super) const MIDDLE: Point = Point {
    time: "t̄",
    position: "q̄",
    velocity: "v",
    time_is: Some("t̄ = t₀ + h/2"),
    others_are: &["q̄ = (q₀ + q₁)/2"],
};

impl Point {
    /// Returns whether the position is q₁.
    pub(crate) fn is_end(&self) -> bool {
        self.position == END.position
    }

    /// Returns position and velocity, as the arguments of a force.
    pub(super) fn moving(&self) -> String {
        format!("{}, {}", self.position, self.velocity)
    }

    pub(crate) fn name(&self, quantity: NodeQuantity) -> &'static str {
        match quantity {
            NodeQuantity::Time => self.time,
            NodeQuantity::Position(_) => self.position,
            NodeQuantity::Velocity(_) => self.velocity,
        }
    }
}

/// An action in its textbook form.
pub(crate) struct Textbook {
    /// `S = …`
    pub(crate) action: String,
    /// The meanings of its symbols.
    pub(crate) notation: Vec<String>,
    /// The virtual work of the forces; empty if there are none.
    pub(crate) work: String,
}

/// The properties of a system that show in the textbook form of an action.
#[allow(clippy::struct_excessive_bools)] // properties that do not depend on one another
pub(crate) struct Features {
    pub(crate) degrees_of_freedom: usize,
    /// True if L or a noise Hamiltonian depends on time.
    pub(crate) is_timed: bool,
    /// True if there is a force F.
    pub(crate) is_forced: bool,
    /// True if F or the force of a noise depends on time.
    pub(crate) forces_are_timed: bool,
    /// ½κ of the option `weak2`, if the action has its term.
    pub(crate) potential: Option<f64>,
    /// True if each process has an increment for each stage.
    pub(crate) has_stage_noise: bool,
    /// The number of γ's; `hamiltonians` is the number of H₁'s.
    pub(crate) gammas: usize,
    pub(crate) hamiltonians: usize,
    /// The number of noises that are forces.
    pub(crate) noise_forces: usize,
    /// True if the correction of a rule with one node at an end has a part with forces.
    pub(crate) corrects_forces: bool,
    /// True if some noise moves q and some noise moves p.
    pub(crate) moves_both: bool,
}

/// Returns `Σ ` if there are several terms.
pub(super) fn sum(count: usize) -> &'static str {
    if count > 1 { "Σ " } else { "" }
}

impl Features {
    /// Returns the action of a rule whose nodes have equal weights. `displacement` is the term that
    /// connects the displacement with the velocities.
    pub(super) fn textbook(&self, points: &[Point], displacement: &str) -> Textbook {
        let lagrangian = self.at(points, |t, x| {
            format!("L({t}{}, {})", x.position, x.velocity)
        });
        let part = if points.len() > 1 { "/2" } else { "" };
        let potential = self.at(points, |t, x| format!("K({t}{})", x.position));
        let potential = self.potential("h·|h|", &potential, points.len());
        let mut action = vec![format!(
            "S = h·{lagrangian}{part}{potential} + {displacement}"
        )];
        if self.gammas > 0 {
            let gamma = self.at(points, |t, x| format!("γ({t}{})", x.position));
            action.push(format!(" + {}{gamma}·ΔW{part}", sum(self.gammas)));
        }
        if self.hamiltonians > 0 {
            let hamiltonian = self.at(points, |t, x| format!("H₁({t}{}, p)", x.position));
            let sum = sum(self.hamiltonians);
            action.push(format!(" − {sum}{hamiltonian}·ΔW{part}"));
        }
        let mut notation: Vec<&str> = Vec::new();
        for point in points {
            notation.extend(point.others_are);
            let is_timed = self.is_timed || self.forces_are_timed;
            notation.extend(point.time_is.filter(|_| is_timed));
        }
        Textbook {
            action: action.concat(),
            notation: notation.into_iter().map(ToOwned::to_owned).collect(),
            work: self.works(points, part),
        }
    }

    /// Returns the virtual work of all forces at nodes of equal weights.
    fn works(&self, points: &[Point], part: &str) -> String {
        let at = |force: &str, arguments: fn(&Point) -> String| {
            let works = points.iter().map(|x| self.work(force, &arguments(x), x));
            joined(&works.collect::<Vec<_>>())
        };
        let mut works = Vec::new();
        if self.is_forced {
            works.push(format!("h·{}{part}", at("F", Point::moving)));
        }
        if self.noise_forces > 0 {
            let work = at("f", Point::moving);
            works.push(format!("{}{work}·ΔW{part}", sum(self.noise_forces)));
        }
        let push = at("D", |x| x.position.to_owned());
        works.join(" + ") + &self.push("h·|h|", &push, points.len())
    }

    /// Returns the work or the impulse of the option `weak2` for noises that are forces, in the
    /// form of [`potential`](Self::potential).
    pub(crate) fn push(&self, factor: &str, sum: &str, nodes: usize) -> String {
        match self.potential {
            // κ is twice the factor of the potential
            Some(half) if self.noise_forces > 0 => {
                format!(
                    " − {factor}·{sum}/{}",
                    (nodes as f64 / (2.0 * half)).round()
                )
            }
            _ => String::new(),
        }
    }

    /// Returns a function at the nodes, `f(q̄)` or `(f(q₀) + f(q₁))`. The function is printed from
    /// the leading time argument and a node.
    fn at(&self, points: &[Point], function: impl Fn(&str, &Point) -> String) -> String {
        let values = points.iter().map(|x| function(&self.time(x.time), x));
        joined(&values.collect::<Vec<_>>())
    }

    /// Returns the leading time argument of L and the noises, `t̄, `; empty if they do not depend
    /// on time.
    pub(crate) fn time(&self, t: &str) -> String {
        leading(self.is_timed, t)
    }

    /// Returns `p·(x)`, or `⟨p, x⟩` for vectors.
    pub(super) fn pairing(&self, p: &str, x: &str) -> String {
        if self.degrees_of_freedom == 1 {
            format!("{p}·({x})")
        } else {
            format!("⟨{p}, {x}⟩")
        }
    }

    /// Returns the term of the option `weak2` in an action, ` − h·|h|·(K(q₀) + K(q₁))/16` for the
    /// factor `h·|h|` and the sum `K(q₀) + K(q₁)` over two nodes of equal weight.
    pub(crate) fn potential(&self, factor: &str, sum: &str, nodes: usize) -> String {
        match self.potential {
            // 1/κ is an integer
            Some(half) if self.gammas + self.hamiltonians > 0 => {
                format!(" − {factor}·{sum}/{}", (nodes as f64 / half).round())
            }
            _ => String::new(),
        }
    }

    /// Returns the weight and the increment of a stage. Their product is the increment at the
    /// stage.
    pub(crate) fn increment_at_stage(&self) -> (&'static str, &'static str) {
        if self.has_stage_noise {
            ("", "ωᵢ")
        } else {
            ("bᵢ·", "ΔW")
        }
    }

    /// Returns the leading time argument of forces.
    pub(crate) fn time_of_forces(&self, t: &str) -> String {
        leading(self.forces_are_timed, t)
    }

    /// Returns the virtual work at a node of a force with these arguments beside time.
    pub(super) fn work(&self, force: &str, arguments: &str, point: &Point) -> String {
        let (t, q) = (self.time_of_forces(point.time), point.position);
        if self.degrees_of_freedom == 1 {
            format!("{force}({t}{arguments})·δ{q}")
        } else {
            format!("⟨{force}({t}{arguments}), δ{q}⟩")
        }
    }
}

/// Returns the time argument of a function before others, `t̄, `, if it has one.
fn leading(is_timed: bool, t: &str) -> String {
    if is_timed {
        format!("{t}, ")
    } else {
        String::new()
    }
}

/// Joins terms to a sum, in brackets if there are several.
fn joined(terms: &[String]) -> String {
    match terms {
        [term] => term.clone(),
        terms => format!("({})", terms.join(" + ")),
    }
}
