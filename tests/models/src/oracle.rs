//! The users' own functions of every model, against which the generated code is compared, and the
//! list of all models and rules.

use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::case::{Case, case};
use crate::configured::Configured;
use crate::models::{
    Actions, Central, Chain, Charges, Clashing, Damped, DoublePendulum, Driven, HenonHeiles, Kubo,
    Magnetic, Mixed, OneMomentum, Oscillator, Pendulum, PlanarDoublePendulum, Polar, Quartic,
    Rails, Relativistic, Rubbed, Sail, SphericalPendulum, Stirred, Stretched, Synchrotron, Towed,
};
use crate::random::Random;

/// Two charges, in a row of six coordinates.
type FlatCharges = Configured<Charges, [f64; 6]>;

/// A system whose functions can be called.
pub trait Model<const N: usize, const M: usize>:
    System<Dims = Dims<N, M>> + std::fmt::Debug
{
    /// Returns L as the user wrote it.
    fn l(&self, t: f64, q: [f64; N], v: [f64; N]) -> f64;
    /// Returns the noise Hamiltonians, −γ and H₁, in the order of the processes; zero for forces.
    fn g(&self, t: f64, q: [f64; N], p: [f64; N]) -> [f64; M];
    /// Returns the force; zero for a system without a force.
    fn f(&self, t: f64, q: [f64; N], v: [f64; N]) -> [f64; N] {
        let _ = (t, q, v);
        [0.0; N]
    }
    /// Returns the force of each noise, in the order of the processes; zero for Hamiltonians.
    fn w(&self, t: f64, q: [f64; N], v: [f64; N]) -> [[f64; N]; M] {
        let _ = (t, q, v);
        [[0.0; N]; M]
    }
    /// Returns a point in whose neighbourhood, of the size of a step, all functions are regular.
    fn point(random: &mut Random) -> State<[f64; N]>;
}

/// The points at which a rule evaluates L.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nodes {
    /// At one node, at this fraction of the step.
    One(f64),
    /// At both ends, with one velocity.
    Ends,
    /// At both ends of a path of second order.
    Predicted,
}

/// A rule of a test.
pub trait Rule {
    /// Name in the attribute.
    const NAME: &'static str;
    /// The quadrature nodes of the rule.
    const NODES: Nodes;
}

macro_rules! rules {
    ($($rule:ident $name:literal $node:expr;)*) => {$(
        impl Rule for $rule {
            const NAME: &'static str = $name;
            const NODES: Nodes = $node;
        }
    )*};
}

rules! {
    InitialPoint "initial_point" Nodes::One(0.0);
    Endpoint "endpoint" Nodes::One(1.0);
    Midpoint "midpoint" Nodes::One(0.5);
    StormerVerlet "stormer_verlet" Nodes::Ends;
    Taylor2 "taylor2" Nodes::Predicted;
}

/// Returns a name such as `Pendulum by midpoint`, for messages.
pub fn name<S: System, R: sve_runtime::Rule<S::Itself>>(integrator: &Integrator<S, R>) -> String {
    let plan = integrator.plan();
    format!("{} by {}", plan.system, plan.rule)
}

/// Returns every model with each of its rules.
pub fn cases() -> Vec<Box<dyn Case>> {
    let mut cases = Vec::new();
    macro_rules! add {
        ($($model:expr),* ; $rules:tt) => {$(add!(one $model; $rules);)*};
        (one $model:expr; ($($rule:ident),*)) => {$(
            cases.push(case($model, $rule));
        )*};
    }
    add!(
        pendulum(), planar_double_pendulum(), magnetic(), spherical_pendulum(), relativistic(), HenonHeiles, quartic(), stirred(), stretched();
        (InitialPoint, Endpoint, Midpoint, StormerVerlet, Taylor2)
    );
    add!(
        oscillator(), kubo(), double_pendulum(), mixed(), polar(), driven(), synchrotron(), actions(), clashing(),
        chain(), one_momentum(), central(), damped(), towed(), charges(), rails(), sail(), rubbed();
        (InitialPoint, Endpoint, Midpoint, StormerVerlet)
    );
    cases
}

macro_rules! models {
    ($(
        $make:ident: $model:ident<$n:literal, $m:literal> = $value:expr;
        l($lt:ident, $lq:ident, $lv:ident, $ls:ident) = $l:expr;
        g($t:ident, $q:ident, $p:ident, $s:ident) = $g:expr;
        $(f($ft:ident, $fq:ident, $fv:ident, $fs:ident) = $f:expr;)?
        $(w($wt:ident, $wq:ident, $wv:ident, $ws:ident) = $w:expr;)?
        point($random:ident) = $point:expr;
    )*) => {$(
        #[doc = concat!("`", stringify!($model), "` with generic parameters.")]
        pub fn $make() -> $model {
            $value
        }

        impl Model<$n, $m> for $model {
            fn l(&self, $lt: f64, $lq: [f64; $n], $lv: [f64; $n]) -> f64 {
                let $ls = self;
                $l
            }
            fn g(&self, $t: f64, $q: [f64; $n], $p: [f64; $n]) -> [f64; $m] {
                let $s = self;
                $g
            }
            $(fn f(&self, $ft: f64, $fq: [f64; $n], $fv: [f64; $n]) -> [f64; $n] {
                let $fs = self;
                $f
            })?
            $(fn w(&self, $wt: f64, $wq: [f64; $n], $wv: [f64; $n]) -> [[f64; $n]; $m] {
                let $ws = self;
                $w
            })?
            fn point($random: &mut Random) -> State<[f64; $n]> {
                let (q, p) = $point;
                State::at($random.uniform(0.2, 1.0), q, p)
            }
        }
    )*};
}

models! {
    pendulum: Pendulum<1, 0> = Pendulum { g: 9.8 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, _q, _p, _s) = [];
    point(r) = (r.array(-3.0, 3.0), r.array(-2.0, 2.0));

    planar_double_pendulum: PlanarDoublePendulum<2, 0> = PlanarDoublePendulum { m: [1.0, 0.7], l: [0.8, 1.1], g: 2.0 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, _q, _p, _s) = [];
    point(r) = (r.array(-3.0, 3.0), r.array(-1.0, 1.0));

    magnetic: Magnetic<2, 0> = Magnetic { m: 1.3, b: 2.0, c: 0.4, k: 0.8 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, _q, _p, _s) = [];
    point(r) = (r.array(-1.0, 1.0), r.array(-1.0, 1.0));

    spherical_pendulum: SphericalPendulum<2, 0> = SphericalPendulum { m: 1.2, l: 0.9, g: 2.0 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, _q, _p, _s) = [];
    point(r) = (r.array(0.8, 2.2), r.array(-1.0, 1.0));

    relativistic: Relativistic<2, 0> = Relativistic { m: 1.1, c: 1.5, k: 0.7 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, _q, _p, _s) = [];
    point(r) = (r.array(-1.0, 1.0), r.array(-0.5, 0.5));

    henon_heiles: HenonHeiles<2, 0> = HenonHeiles;
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, _q, _p, _s) = [];
    point(r) = (r.array(-0.5, 0.5), r.array(-0.5, 0.5));

    quartic: Quartic<1, 0> = Quartic { m: 1.3, k: 0.9 };
    l(_t, q, v, s) = s.lagrangian(q[0], v[0]);
    g(_t, _q, _p, _s) = [];
    point(r) = (r.array(-1.5, 1.5), r.array(-1.5, 1.5));

    oscillator: Oscillator<1, 1> = Oscillator { sigma: 0.7 };
    l(_t, q, v, s) = s.lagrangian(q[0], v[0]);
    g(_t, q, _p, s) = [-s.push(q[0])];
    point(r) = (r.array(-2.0, 2.0), r.array(-2.0, 2.0));

    kubo: Kubo<1, 1> = Kubo { a: 1.3, sigma: 0.6 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, q, p, s) = [s.jitter(q, p)];
    point(r) = (r.array(-2.0, 2.0), r.array(-2.0, 2.0));

    double_pendulum: DoublePendulum<2, 2> = DoublePendulum { m: [1.0, 0.7], l: [0.8, 1.1], g: 2.0, s: 0.4 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, q, _p, s) = s.shake(q).map(|x| -x);
    point(r) = (r.array(-3.0, 3.0), r.array(-1.0, 1.0));

    mixed: Mixed<2, 3> = Mixed { c: 0.3, s: [0.4, 0.3, 0.5] };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, q, p, s) = {
        let [a, b] = s.drag(q, p);
        [a, b, -s.push(q)]
    };
    point(r) = (r.array(-1.0, 1.0), r.array(-1.0, 1.0));

    polar: Polar<2, 2> = Polar { m: 1.2, k: 1.5, sigma: [0.3, 0.2] };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, q, p, s) = [-s.push(q), s.turn(q, p)];
    point(r) = ([r.uniform(1.0, 2.0), r.uniform(-3.0, 3.0)], r.array(-1.0, 1.0));

    driven: Driven<1, 2> = Driven { c: 0.3, k: 1.4, b: 0.5, sigma: [0.6, 0.4] };
    l(t, q, v, s) = s.lagrangian(t, q[0], v[0]);
    g(t, q, p, s) = [-s.push(t, q[0]), s.jitter(t, q[0], p[0])];
    point(r) = (r.array(-1.0, 1.0), r.array(-1.0, 1.0));

    synchrotron: Synchrotron<1, 2> = Synchrotron { omega: 1.4, sigma: [0.3, 0.5] };
    l(_t, q, v, s) = s.lagrangian(q[0], v[0]);
    g(_t, q, _p, s) = [-s.phase(q[0]), -s.amplitude(q[0])];
    point(r) = (r.array(-3.0, 3.0), r.array(-2.0, 2.0));

    actions: Actions<1, 2> = Actions { a: 1.0, sigma: [0.5, 0.2] };
    l(_t, q, v, s) = s.lagrangian(q[0], v[0]);
    g(_t, q, p, s) = s.jitter(q[0], p[0]);
    point(r) = (r.array(-1.0, 1.0), r.array(-1.0, 1.0));

    clashing: Clashing<1, 2> = Clashing { sigma: [0.5, 0.5] };
    l(_t, q, v, s) = s.lagrangian(q[0], v[0]);
    g(_t, q, p, s) = [-s.push(q[0]), s.stretch(q[0], p[0])];
    point(r) = (r.array(-2.0, 2.0), r.array(-2.0, 2.0));

    chain: Chain<6, 1> = Chain { m: [1.0, 0.5, 2.0, 1.5, 0.7, 1.2], k: 1.1, s: 0.6 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, q, _p, s) = [-s.shake(q)];
    point(r) = (r.array(-0.5, 0.5), r.array(-1.0, 1.0));

    one_momentum: OneMomentum<3, 2> = OneMomentum { s: [0.5, 0.4] };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, q, p, s) = [s.drag(q, p), -s.push(q)];
    point(r) = (r.array(-1.0, 1.0), r.array(-1.0, 1.0));

    central: Central<2, 1> = Central { m: 0.9, s: 0.5 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, q, _p, s) = [-s.shake(q)];
    point(r) = ([r.uniform(0.7, 1.5), r.uniform(-1.0, 1.0)], r.array(-1.0, 1.0));

    damped: Damped<1, 1> = Damped { m: 1.3, k: 0.8, nu: 0.7, sigma: 0.4 };
    l(_t, q, v, s) = s.lagrangian(q[0], v[0]);
    g(_t, q, _p, s) = [-s.bath(q[0])];
    f(_t, q, v, s) = [s.friction(q[0], v[0])];
    point(r) = (r.array(-1.5, 1.5), r.array(-1.0, 1.0));

    stirred: Stirred<2, 0> = Stirred { c: 0.6, w: 0.9 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, _q, _p, _s) = [];
    f(t, q, v, s) = {
        let (a, b) = (s.drag(q, v), s.stir(t, q, v));
        [a[0] + b[0], a[1] + b[1]]
    };
    point(r) = (r.array(-1.0, 1.0), r.array(-1.0, 1.0));

    towed: Towed<2, 2> = Towed { c: [0.5, 0.8], s: [0.4, 0.3] };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, q, p, s) = [s.jitter(q, p), -s.push(q)];
    f(_t, q, v, s) = s.tow(q, v);
    point(r) = (r.array(-1.0, 1.0), r.array(-1.0, 1.0));

    sail: Sail<2, 3> = Sail { c: 0.5, s: [0.4, 0.3, 0.6] };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, q, p, s) = [s.jitter(q, p), -s.push(q), 0.0];
    f(_t, q, v, s) = s.drag(q, v);
    w(t, q, v, s) = [[0.0; 2], [0.0; 2], s.gust(t, q, v)];
    point(r) = (r.array(-1.0, 1.0), r.array(-1.0, 1.0));

    rubbed: Rubbed<1, 2> = Rubbed { m: 1.3, s: [0.5, 0.3] };
    l(_t, q, v, s) = s.lagrangian(q[0], v[0]);
    g(_t, _q, _p, _s) = [0.0; 2];
    w(_t, q, v, s) = [[s.rub(q[0], v[0])], [s.grind(q[0], v[0])]];
    point(r) = (r.array(-1.5, 1.5), r.array(-1.0, 1.0));

    charges: FlatCharges<6, 3> = Configured::new(Charges { m: [1.0, 0.6], b: 0.7, s: [0.3, 0.2, 0.4] });
    l(_t, q, v, s) = s.0.lagrangian(pair(q), pair(v));
    g(_t, q, p, s) = {
        let [a, b] = s.0.jitter(pair(q), pair(p));
        [a, b, -s.0.pull(pair(q))]
    };
    point(r) = (r.array(-1.0, 1.0), r.array(-0.5, 0.5));

    stretched: Stretched<1, 0> = Stretched { m: 1.2 };
    l(_t, q, v, s) = s.lagrangian(q[0], v[0]);
    g(_t, _q, _p, _s) = [];
    point(r) = (r.array(-0.5, 0.5), r.array(-0.5, 0.5));

    rails: Rails<8, 1> = Rails { m: 1.2, r: 0.4, k: [1.1, 0.6], s: 0.5 };
    l(_t, q, v, s) = s.lagrangian(q, v);
    g(_t, q, _p, s) = [-s.shake(q)];
    point(r) = (r.array(-0.5, 0.5), r.array(-1.0, 1.0));
}

/// Returns the coordinates of two bodies.
fn pair([a, b, c, d, e, f]: [f64; 6]) -> [[f64; 3]; 2] {
    [[a, b, c], [d, e, f]]
}
