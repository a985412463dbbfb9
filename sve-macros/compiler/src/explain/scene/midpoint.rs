//! A step of the midpoint rule of a scene as text.

use super::SceneTexts;

impl SceneTexts {
    /// Returns the discrete action and the step of the midpoint rule.
    pub(super) fn implicit_step(&self) -> [String; 2] {
        let mut action = "S_d = h L(t̄, q̄, v) + ⟨p, q₁ − q₀ − h v⟩".to_owned();
        for (is_there, noise) in [
            (self.has_gamma, " + Σ γ(t̄, q̄) ΔW"),
            (self.has_h1(), " − Σ H₁(t̄, q̄, p) ΔW"),
        ] {
            action.push_str(if is_there { noise } else { "" });
        }
        action.push_str(",  q̄ = (q₀ + q₁)/2");
        if self.has_forces {
            action.push_str("\nwith the virtual work h F(q̄, v)·δq̄ beside δS");
        }
        if self.has_noise_forces {
            action.push_str("\nwith the virtual work Σ f(q̄)·δq̄ ΔW beside δS");
        }
        let mut step = if self.has_h1() {
            self.step_of_velocities()
        } else {
            self.step_of_displacements()
        };
        self.push_impulses(&mut step);
        [action, step.join("\n")]
    }

    /// Returns how a step of the midpoint rule without H₁ is solved.
    fn step_of_displacements(&self) -> Vec<String> {
        let (mass, friction) = if self.friction.is_empty() {
            ("M", "")
        } else {
            ("(M + h N/2)", " − N d")
        };
        let [at_node, impulse, slope] = if self.in_drifts[0].is_empty() {
            ["I(q₀ + d/2)", "I", ""]
        } else {
            [
                "(I(q₀ + d/2) + D(q₀ + d/2, d/h))",
                "I + D",
                " − M⁻¹ (h ∂D/∂q + 2 ∂D/∂v) / 4",
            ]
        };
        vec![
            format!(
                "solve: d = h {mass}⁻¹ (p₀ + {at_node}/2), sweeps of {}'s iteration",
                self.iteration
            ),
            format!("end: q₁ = q₀ + d, p₁ = p₀ + {impulse}{friction}"),
            format!(
                "the root is unique within boxes around the motion: Gershgorin's bounds of 1 − h M⁻¹ ∂I/∂q / 4{slope} are positive there"
            ),
        ]
    }

    /// Returns how a step of the midpoint rule with H₁ is solved.
    fn step_of_velocities(&self) -> Vec<String> {
        let [drags, kicks, shifts] = self.in_drifts.each_ref().map(|lines| !lines.is_empty());
        let text = |is_there, text: &str| {
            if is_there {
                text.to_owned()
            } else {
                String::new()
            }
        };
        let at = |node: &str| {
            let parts = [
                text(drags, &format!(" + D{node}")),
                text(kicks, &format!(" + K{}", node.replace(", v)", ", M v)"))),
                text(!self.friction.is_empty(), " − h N v"),
            ];
            parts.concat()
        };
        let (shift, end) = (text(shifts, " + X(q̄, M v)"), text(shifts, " + X"));
        let centre = if shifts {
            format!("(h v{shift})")
        } else {
            "h v".to_owned()
        };
        vec![
            format!("solve: M v = p₀ + (I(q̄){})/2, q̄ = q₀ + {centre}/2, by fixed-point sweeps", at("(q̄, v)")),
            format!("end: q₁ = q₀ + h v{end}, p₁ = p₀ + I{}", at("")),
            "the root is unique within boxes around the motion: a sweep contracts there, by bounds of its derivatives".to_owned(),
        ]
    }
}
