//! The procedural macro of [sve](https://docs.rs/sve-runtime): from a Lagrangian to a specialised
//! variational step.
//!
//! Use it through `sve-runtime`, which re-exports it and has runnable examples. Generated code
//! refers to that crate. The package `sve-compiler` does the work.

use proc_macro::TokenStream;
use sve_compiler::Settings;

/// Derives variational integrators from the Lagrangian and the noise terms of an `impl` block.
///
/// # Arguments
///
/// `#[variational(rule, …)]` lists the rules to derive, each once; `crate = path` may stand among
/// them. Options of a rule stand in parentheses. A rule with an option is another rule and may
/// stand beside the rule without the option: `#[variational(midpoint, midpoint(weak2))]`.
///
/// | argument | type in the runtime | node of the discrete action | deterministic order |
/// | --- | --- | --- | --- |
/// | `initial_point` | `InitialPoint` | start of the step | 1 |
/// | `endpoint` | `Endpoint` | end of the step | 1 |
/// | `midpoint` | `Midpoint` | middle of the step | 2 |
/// | `stormer_verlet` | `StormerVerlet` | start and end, with one velocity | 2 |
/// | `gauss(2)` … `gauss(8)` | `Gauss::<2>` … `Gauss::<8>` | 2 to 8 nodes of Gauss quadrature | 4, 6, …, 16 |
/// | `taylor2` | `Taylor2` | start and end, with the Taylor expansion of the flow; for blocks without noise | 2 |
/// | `midpoint(weak2)`, `stormer_verlet(weak2)` | `Weak2<Midpoint>`, `Weak2<StormerVerlet>` | as without the option, with a potential that makes the weak order 2; for commuting noises in q alone | 2 |
/// | `gauss(2, weak2)` … | `Weak2<Gauss<2>>` … | as without the option, with a term that makes the weak order 2; for commuting noises, which may move the position where no force acts | 4, 6, …, 16 |
/// | `gauss(2, stage_noise)` … | `StageNoise<Gauss<2>>` … | as without the option, with an increment of each process for each stage | 4, 6, …, 16 |
/// | `gauss(2, stage_noise, weak2)` … | `Weak2<StageNoise<Gauss<2>>>` … | both; strong order 1.5 and weak order 2; for noises in q alone | 4, 6, …, 16 |
/// | `crate = path` | | path of the runtime crate; `::sve_runtime` if not given | |
///
/// # Items of the block
///
/// The order of the arguments decides their meaning. An argument called `t`, `q`, `v` or `p` in the
/// place of another quantity is an error; other names are not interpreted.
///
/// | item | signature (`t: f64` may come first, after `&self`) | meaning |
/// | --- | --- | --- |
/// | `fn lagrangian` | `(&self, q: [f64; N], v: [f64; N]) -> f64` | L, required |
/// | `#[gamma] fn …` | `(&self, q: [f64; N]) -> f64` or `-> [f64; M]` | γ: one Wiener process a component; the result may have any shape that `q` may have, such as `[[f64; D]; B]` |
/// | `#[h1] fn …` | `(&self, q: [f64; N], p: [f64; N]) -> f64` or `-> [f64; M]` | H₁: one Wiener process a component |
/// | `#[force] fn …` | `(&self, q: [f64; N], v: [f64; N]) -> [f64; N]` | F, a force that no potential has (Lagrange–d'Alembert); several add up |
/// | `#[force(noise)] fn …` | `(&self, q: [f64; N], v: [f64; N]) -> [f64; N]` | f, a force that acts with a Wiener process of its own: dp = … + f ∘ dW; each function is a process, numbered after those of γ and H₁ |
/// | `#[symmetry] fn …` | `(&self, q: [f64; N]) -> [f64; N]` | ξ, the generator of a symmetry of everything else in the block |
/// | `#[constraint] fn …` | `(&self, q: [f64; N]) -> f64` or `-> [f64; K]` | φ, a holonomic constraint φ = 0 a component |
/// | `u`, the last argument of a Lagrangian, a noise or a force | `f64`, `[f64; K]` or a vector | inputs: values that are held over a step and given to it, `step_with(&mut state, h, &dw, &u)` |
/// | other `fn` | anything in the language below | helpers, inlined |
/// | `const` | a number, an array, a vector or a matrix | written `Self::NAME` |
///
/// The equations are, with Stratonovich integrals and an independent Wiener process for each γ and
/// each H₁ in source order, then for each noise force f,
///
/// ```text
/// dq =  v dt          + Σ ∂H₁/∂p ∘ dW
/// dp = (∂L/∂q + F) dt + Σ ∂γ/∂q ∘ dW − Σ ∂H₁/∂q ∘ dW + Σ f ∘ dW        p = ∂L/∂v
/// ```
///
/// With constraints, `dp` also has the term `Σ ∂φ/∂q ∘ dΛ`, where Λ is such that φ = 0. The rules
/// `initial_point`, `endpoint`, `midpoint` and `stormer_verlet` take constraints: the action gets
/// the terms `⟨λ, φ(t₀,q₀)⟩ + ⟨μ, φ(t₁,q₁)⟩`, so the forces of constraints act at both ends of a
/// step, and the momentum at the end is along the constraints. `stormer_verlet` is then RATTLE. If
/// masses are constant and forces explicit, or frictions `−ν(t, q) v` of coordinates by their own
/// velocities, Newton's method has one unknown for each constraint.
///
/// An H₁ must move q along the constraints: `⟨∂φ/∂q, ∂H₁/∂p⟩ = 0` where `φ = 0` and the momentum is
/// along the constraints. `#[h1(tangent)]` evaluates H₁ at the momentum along the constraints,
/// `Πp = p − Dφᵀ(Dφ M⁻¹ Dφᵀ)⁻¹ Dφ M⁻¹ p`, and then always satisfies this condition; it is for at
/// most three coupled constraints.
///
/// A Lagrangian may be linear in some velocities, or not contain them at all. The macro finds this,
/// and the plan says which case holds:
///
/// | L | the step | preserved |
/// | --- | --- | --- |
/// | ⟨α(q), v⟩ − H(q) with an affine α | `midpoint`: the implicit midpoint rule | ω = Dαᵀ − Dα, to rounding |
/// | half of the velocities do not occur, up to the total derivative of a quadratic function | `midpoint`, `initial_point`, `endpoint`; these coordinates are variables of the node | ω, to rounding |
/// | other α | `midpoint`, with a symmetric projection to p = α(q) | ω, up to O(h⁵) a step |
/// | linear in some velocities, with mass in the others | `midpoint`, with the projection of the linear ones; none where α is affine | as above |
/// | without some velocities, whose coordinates 0 = ∂L/∂q determine | `midpoint`, `initial_point`, `endpoint`; the coordinates are eliminated | the symplectic form of the others |
///
/// In these cases p = α(q) is not a free variable: states start from `State::from_configuration`. A
/// γ moves these coordinates, ω dq = ∇H dt − ∇γ ∘ dW, so γ's need not commute. An H₁ is written as
/// γ = −H₁(q, α(q)). Adding a total derivative to L changes no equation of motion, but it changes
/// the step of the third case, in which energies may drift. If you can, write L so that half of the
/// velocities do not occur.
///
/// A symmetry is refused, with the name of the function that it changes, unless these expressions
/// vanish:
///
/// ```text
/// ⟨∂L/∂q, ξ⟩ + ⟨∂L/∂v, Dξ v⟩ = 0     ⟨∂H₁/∂q, ξ⟩ − ⟨p, Dξ ∂H₁/∂p⟩ = 0
/// ⟨∂γ/∂q, ξ⟩ = 0     ⟨F, ξ⟩ = 0     ⟨∂φ/∂q, ξ⟩ = 0
/// ```
///
/// Then ⟨p, ξ⟩ is conserved by the motion, also with noise, and by the steps if ξ is affine in q.
///
/// If the algebra leaves 0, the expression is proved to vanish. Otherwise it is evaluated in 106
/// bits, at random points near 1 and of scales from 1e-15 to 1e15, and compared with the sum of the
/// magnitudes of its terms: a breaking term is refused down to some 1e-26 of the other terms at any
/// of these points, and a smaller one goes unnoticed. Decimal constants are rounded, and like terms
/// are collected in `f64`: an expression smaller than this rounding, 1e-15 of the terms with such
/// constants, cannot be decided and is accepted. The documentation of the momentum and the plan say
/// which of the three cases holds: they add nothing after a proof, else "checked, not proved" or
/// "not decided". The commutation of noises is decided in the same way, after each noise is scaled
/// to the order of 1.
///
/// `N = 1` may be written `q: f64`. Instead of `[f64; N]` the coordinates may be `[[f64; D]; B]`, a
/// vector of nalgebra, `Vector1<f64>` to `Vector6<f64>` or `SVector<f64, N>`, or an array of these,
/// `[Vector3<f64>; B]`; the paths of these types may be written out, as in `na::Vector3<f64>`. All
/// coordinates, velocities and momenta of a block have the same type, and so have forces and
/// generators, unless there is a rotation. The `M` noises and `K` constraints of a function may
/// have any of these shapes. The increments stay a row of numbers, `[f64; M]`, in which the noises
/// of a function are numbered in the order of its memory, row by row; the plan names them as it
/// names coordinates, `bath[1][0]` or `bath[0].z`. `N` and `M` are literals or constants of the
/// block, `Self::N`, and `{ Self::N }` among generic arguments.
///
/// # Rotations
///
/// A rotation `r: Rotation3<f64>` has its angular velocity in the body frame, `w: Vector3<f64>`, in
/// place of the velocity, and its angular momentum in the body frame, `pi: Vector3<f64>`, in place
/// of the momentum: `lagrangian(&self, r, w)`, `#[gamma]` of `(&self, r)`, `#[h1]` of
/// `(&self, r, pi)`. Several rotations are `[Rotation3<f64>; K]` with `[Vector3<f64>; K]`. If there
/// are a vector and a rotation, each quantity has two arguments, `lagrangian(&self, q, r, v, w)`,
/// `(&self, q, r)`, `(&self, q, r, p, pi)`; forces and symmetries then return a tuple. A `#[force]`
/// is a torque in the body frame, a `#[symmetry]` the body vector ξ with `δR = R ξ̂`. The language
/// of a body has `r * a`, `r.inverse() * a`, `r.transpose()`, `r.inverse_transform_vector(&a)`,
/// `r * s`, `r.matrix()`, `r[(i, j)]`.
///
/// The increment of a rotation is the rotation vector of `R₀ᵀR₁`, the node the middle of the
/// geodesic. Momenta are the momenta of the discrete action on the group, so steps are symplectic
/// on T*SO(3). Whether noises commute is decided by the bracket
/// `⟨f_R, g_Π⟩ − ⟨g_R, f_Π⟩ − Π·(f_Π × g_Π)` with left-trivialised `f_R`. Only `midpoint`,
/// `stormer_verlet` and their compositions take rotations; constraints, baselines, compensated sums
/// and lanes do not.
///
/// If L does not depend on the attitude, `#[variational(midpoint, reduced)]` derives the step of
/// the body momentum alone: `lagrangian(&self, w: Vector3<f64>)`, `#[h1]` of
/// `(&self, pi: Vector3<f64>)`, `#[force]` of `(&self, w: Vector3<f64>)`. The state,
/// `State<Reduced>`, is the body momentum (Euler–Poincaré, Lie–Poisson);
/// `Integrator::step_with_attitude` gives the attitude along a path.
///
/// # Parameters
///
/// The values that the functions read from `self` are the parameters: fields `f64`, arrays
/// `[f64; K]`, vectors, matrices and rotations of nalgebra and arrays of these, also in fields of
/// nested structs. The macro does not see the types of fields. The length of an array need not be
/// known. The type of a vector, matrix or rotation follows from its use:
///
/// - in a sum, the other operand has the same type: `q - self.anchor`;
/// - in a call, the receiver or an argument has it: `self.gravity.dot(&q)`, `a.cross(&self.b)`,
///   `self.f(self.gravity)`;
/// - entries are numbers: `self.gravity.z`, `self.inertia[(0, 1)]`;
/// - in a product or a quotient the field is a number: `self.mass * v`. If it is a vector or a
///   matrix, its type must be known from another use in the block, or be written once, as in
///   `let inertia: Matrix3<f64> = self.inertia;` or as the result of a function. Otherwise the
///   compiler finds another type than `f64` and reports it at the field.
///
/// A type that follows from one use holds for the whole block. If the type does not follow from a
/// use, the error at the token asks for `let g: Vector3<f64> = self.g;`.
///
/// # Language of a body
///
/// Straight-line Rust over `f64`:
///
/// - `let` with patterns (names, tuples, arrays, `_`), shadowing, `let mut`
///   with `=`, `+=`, `-=`, `*=`, `/=`; blocks;
/// - `+ − * /`, parentheses, `f64` literals, and integers where Rust wants them: indices, bounds,
///   exponents of `powi`;
/// - `for` over a range with bounds known at compile time, an array or an iterator; loops are
///   unrolled;
/// - `if`, `continue` and `break` by conditions on integers known at compile time, such as
///   `i != j`;
/// - arrays, tuples, slices, `[x; N]`, indices that are known at compile time, `len()` of an array;
/// - of the methods of arrays and iterators: `iter`, `into_iter`, `copied`, `map`, `zip`,
///   `enumerate`, `rev`, `step_by`, `skip`, `take`, `chain`, `filter` (on indices), `flatten`,
///   `flat_map`, `fold`, `for_each`, `sum`, `product`, `windows`, `chunks`, `chunks_exact`, with
///   closures that are written in place;
/// - calls of functions of the block, `self.f(…)` or `Self::f(…)`; constants `Self::NAME`,
///   constants of `std::f64::consts`, and constants from outside the block whose names are in
///   capitals, which are read like parameters;
/// - integers known at compile time, with the types of Rust: `as` wraps (`300i32 as u8` is 44),
///   arithmetic that overflows is an error; `as f64`, `f64::from`, `into` if the type is written;
/// - `std::array::from_fn` with its length in the type of the variable, of the result or in
///   `from_fn::<_, N, _>`; `iter_mut` and `for x in &mut a` of local arrays;
/// - of nalgebra, with `&` where its functions take references:
///   - `+ − * /` and `+= −= *= /=` of vectors, matrices, rotations and numbers; products of
///     matrices, vectors and rotations;
///   - `.x`, `.y`, `.z`, `.w`, `.m21`, `v[i]`, `m[(i, j)]`, read and assigned to; `len`, `nrows`,
///     `ncols`;
///   - `dot`, `cross`, `perp`, `norm`, `norm_squared`, `magnitude`, `magnitude_squared`,
///     `metric_distance`, `normalize`, `component_mul`, `component_div`, `scale`, `unscale`,
///     `add_scalar`, `lerp`, `sum`, `product`, `mean`, `transpose`, `tr_mul`, `trace`,
///     `determinant` of up to 6 rows, `diagonal`, `cross_matrix`, `to_scalar`, `inverse`,
///     `transform_vector`, `inverse_transform_vector` and `matrix` of rotations, `into_inner`;
///   - parts: `row`, `column`, `rows`, `columns`, `fixed_rows::<K>`, `fixed_columns::<K>`,
///     `fixed_view::<R, C>`, `xy`, `xyz` and their like; iterators: `iter`, `iter_mut`, `row_iter`,
///     `column_iter`; closures: `map`, `zip_map`, `fold`; sums of vectors,
///     `.sum::<Vector3<f64>>()`;
///   - `new`, `zeros`, `identity`, `repeat`, `from_element`, `from_diagonal`,
///     `from_diagonal_element`, `from_columns`, `from_rows`, `from_row_slice`, `from_column_slice`,
///     `from` an array, `from_fn`, `x()` and `x_axis()` and their like; `into` between arrays and
///     vectors where the type is written; `Rotation2::new`, `Rotation3::from_euler_angles`,
///     `Rotation3::from_axis_angle`, `Unit::new_normalize`. Constants of the block need functions
///     that are `const` in nalgebra, which are `new` of vectors and matrices;
/// - of the methods of `f64`: `powi`, `powf`, `sqrt`, `cbrt`, `exp`, `exp2`, `exp_m1`, `ln`,
///   `ln_1p`, `log`, `log2`, `log10`, `sin`, `cos`, `sin_cos`, `tan`, `asin`, `acos`, `atan`,
///   `atan2`, `sinh`, `cosh`, `tanh`, `asinh`, `acosh`, `atanh`, `hypot`, `recip`, `mul_add`,
///   `to_radians`, `to_degrees`.
///
/// # What is refused
///
/// Each of the following is an error at its token. The message says what to write instead;
/// independent mistakes are reported together.
///
/// | refused | why |
/// | --- | --- |
/// | `abs`, `signum`, `min`, `max`, `clamp`, `floor`, `round`, …, `%` of numbers | not smooth: there is no derivative to take |
/// | `abs`, `max`, `amax`, `argmax`, `angle`, … of vectors | not smooth |
/// | `lu`, `try_inverse`, `svd` and other factorisations of matrices | they are algorithms, not formulas: their results can be parameters |
/// | methods that change a vector in place, `normalize_mut`, `copy_from`, … | assignments say the same |
/// | `if` on numbers, `match` | a Lagrangian is one formula everywhere |
/// | `while`, bounds of loops and indices that are not known at compile time, recursion | nothing could be unrolled |
/// | functions outside the block, lengths, bounds and indices by constants outside it, macro calls | the macro sees the tokens of this block alone |
/// | closures bound to a name | a function of the block is as short |
/// | generic blocks, blocks of a trait, `cfg` on an item of the block | the macro does not know the types or items |
/// | `&mut self`, `self`, coordinates by reference | functions of a system have no effects |
/// | a noise with derivative zero | it would move nothing |
/// | a Lagrangian whose `∂²L/∂v²` is singular everywhere, to 106 bits or to the rounding of its constants, and which is none of the degenerate ones above: null directions that are no coordinates, singular ω, α(t, q) | nothing determines the velocities, or no step is derived |
/// | degenerate Lagrangians with an H₁ of massless coordinates, with a force, with a noise of an algebraic coordinate; by other rules; by the one-sided rules without the form with half of the velocities | the equation would have no solution, or the step would integrate another equation |
/// | `taylor2` with noise | the rule is defined for deterministic systems |
/// | `weak2` with noises that do not commute, an H₁ that depends on p, a force that is not affine in v, no noise; `gauss(s, weak2)` takes an H₁ that depends on p where there is no force | the term would not raise the weak order |
/// | `weak2` with a `#[force(noise)]` that depends on v, or with masses that depend on the position or time | its term is not derived |
/// | `initial_point` and `endpoint` with a `#[force(noise)]` of velocities and more than three coordinates coupled by masses that depend on the configuration | the correction needs the inverse of the mass matrix as a formula |
/// | constraints with a `#[force(noise)]` of velocities beside other noises, or by `initial_point` and `endpoint`; with any `#[force(noise)]` beside an H₁ that depends on p | whether projected noises commute, and their correction, are not derived |
/// | `weak2` with ∂²L/∂v² that depends on v | the term would not be a function of time and configuration |
/// | `weak2` with more than three coordinates coupled by masses that depend on the configuration | the inverse of the mass matrix is a formula, which would grow too long |
/// | a `#[symmetry]` that changes L, a noise, or on which a force does work | its momentum would not be conserved |
/// | constraints of which one depends on the others where they hold, or whose gradient vanishes there | their forces would not be determined |
/// | an H₁ that moves q off the constraints | its constraint force would be infinite |
/// | an H₁ curved in p with `initial_point` or `endpoint`, whose correction moves q off the constraints | the step has no solution |
/// | constraints with `gauss(s)`, `taylor2`, `weak2`, or with ∂²L/∂v² that depends on v | not derived: compose a symmetric rule for a higher order |
/// | bodies that unroll to more than 30 000 expressions or 2 000 000 steps of evaluation; more than 200 000 second derivatives; derivatives that take the macro too much work | compile time: accepted are 48 coordinates of bodies that all attract one another, and 33 of an n-pendulum, whose mass matrix couples all coordinates |
///
/// # What is generated
///
/// The expansion is the block itself without the role attributes, so that its functions remain
/// ordinary functions, and:
///
/// - `impl System`: the type `Q` of configurations, which is the type of `q` in the signature
///   (`[f64; 1]` for `f64`); L and the noise Hamiltonians with their first and second derivatives,
///   on which energy, Legendre transform, drift and the baseline methods rest; differences such as
///   `1 − cos x` or `√(1 + x) − 1` are computed in forms that do not cancel;
/// - `impl StartOfStep`: the test whether exactly one velocity has the momentum at the start of a
///   step, as far as L does not decide this;
/// - for each `#[symmetry] fn name` a function `name_momentum(&self, &State<Q>) -> f64`, the
///   momentum ⟨p, ξ⟩, of the same visibility; in a system whose coordinates are slices a `Result`;
/// - for each rule `impl StepEquations<Rule>`: `prepare`, the values that depend on parameters and
///   step size alone; `increment`, the step; and `PLAN`, the description of the derived step.
///
/// Their documentation shows L, the noise terms, the equations of motion, the discrete action and
/// the equations of the step as mathematics; `PLAN` has the same texts, of bounded length.
///
/// The step solves `p₀ = −∂S/∂q₀`, `p₁ = ∂S/∂q₁`, `0 = ∂S/∂(internal variables)` for the discrete
/// action S of the rule, which includes the Stratonovich correction. It is straight-line code with
/// one `let` an operation around its linear solves and Newton iterations, and it does not allocate.
/// After an error the implementations are emitted without bodies, so that uses of the system give
/// no errors of their own.
#[proc_macro_attribute]
pub fn variational(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let settings = Settings {
        lanes: cfg!(feature = "lanes"),
        ..Settings::default()
    };
    sve_compiler::expand(&attribute.into(), &item.into(), settings).into()
}
