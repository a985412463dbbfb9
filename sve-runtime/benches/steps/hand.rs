//! The steps that a careful user would write by hand, and the steps that a hurried user would
//! write.

/// Makes a step of the linear oscillator by the endpoint rule: the three-line loop.
#[inline]
pub(crate) fn oscillator_endpoint(z: &mut [f64; 2], h: f64, sigma: f64, dw: f64) {
    z[0] += h * z[1];
    z[1] = z[1] - h * z[0] + sigma * dw;
}

/// Makes a step of the Kubo oscillator by the midpoint rule in its Cayley form: a rotation with
/// `tan(θ/2) = x/2`.
#[inline]
pub(crate) fn kubo_cayley(z: &mut [f64; 2], h: f64, a: f64, sigma: f64, dw: f64) {
    let half = 0.5 * (a * h + sigma * dw);
    let scale = 1.0 / (1.0 + half * half);
    let (c, s) = ((1.0 - half * half) * scale, 2.0 * half * scale);
    *z = [c * z[0] + s * z[1], c * z[1] - s * z[0]];
}

/// Makes a step of the pendulum by the midpoint rule: Newton's method on `(q₁, p₁)` from the old
/// state, until the update is at rounding.
#[inline]
pub(crate) fn pendulum_naive(z: &mut [f64; 2], h: f64, g: f64) {
    let [q0, p0] = *z;
    let (mut q1, mut p1) = (q0, p0);
    for _ in 0..50 {
        let (qm, pm) = (0.5 * (q0 + q1), 0.5 * (p0 + p1));
        let r = [q1 - q0 - h * pm, p1 - p0 + h * g * qm.sin()];
        let (a, b, c, d) = (1.0, -0.5 * h, 0.5 * h * g * qm.cos(), 1.0);
        let det = a * d - b * c;
        let (dq, dp) = ((r[0] * d - r[1] * b) / det, (a * r[1] - c * r[0]) / det);
        q1 -= dq;
        p1 -= dp;
        if dq.abs() <= 1e-14 * (1.0 + q1.abs()) && dp.abs() <= 1e-14 * (1.0 + p1.abs()) {
            break;
        }
    }
    *z = [q1, p1];
}

/// Makes a step of the pendulum by the midpoint rule: one unknown, a guess extrapolated from the
/// step before, no confirming iteration.
#[inline]
pub(crate) fn pendulum_best(z: &mut [f64; 2], last: &mut f64, h: f64, g: f64) {
    let [q0, p0] = *z;
    let (half, kick) = (0.5 * h, 0.5 * h * g);
    let mut v = p0 + *last;
    for _ in 0..50 {
        let (s, c) = (q0 + half * v).sin_cos();
        let r = v - p0 + kick * s;
        let dv = r / (1.0 + kick * half * c);
        v -= dv;
        if dv.abs() <= 1e-7 * (v.abs() + p0.abs()) {
            break;
        }
    }
    *last = v - p0;
    *z = [q0 + h * v, 2.0 * v - p0];
}

/// Parameters of the double pendulum.
pub(crate) struct Double {
    pub(crate) m: [f64; 2],
    pub(crate) l: [f64; 2],
    pub(crate) g: f64,
}

/// Makes a step of the double pendulum by the midpoint rule: Newton's method on the velocity at the
/// midpoint with a hand-derived Jacobian, from the explicit velocity, until the update is at
/// rounding.
#[inline]
pub(crate) fn double_naive(q: &mut [f64; 2], p: &mut [f64; 2], h: f64, s: &Double) {
    let (m11, m22) = (
        (s.m[0] + s.m[1]) * s.l[0] * s.l[0],
        s.m[1] * s.l[1] * s.l[1],
    );
    let k = s.m[1] * s.l[0] * s.l[1];
    let (g1, g2) = ((s.m[0] + s.m[1]) * s.g * s.l[0], s.m[1] * s.g * s.l[1]);
    let solve = |a: f64, b: f64, c: f64, d: f64, r: [f64; 2]| {
        let det = a * d - b * c;
        [(r[0] * d - r[1] * b) / det, (a * r[1] - c * r[0]) / det]
    };
    let c0 = k * (q[0] - q[1]).cos();
    let mut v = solve(m11, c0, c0, m22, *p);
    for _ in 0..50 {
        let x = [q[0] + 0.5 * h * v[0], q[1] + 0.5 * h * v[1]];
        let (sin, cos) = ((x[0] - x[1]).sin(), (x[0] - x[1]).cos());
        let f = [
            -k * v[0] * v[1] * sin - g1 * x[0].sin(),
            k * v[0] * v[1] * sin - g2 * x[1].sin(),
        ];
        let r = [
            m11 * v[0] + k * cos * v[1] - 0.5 * h * f[0] - p[0],
            m22 * v[1] + k * cos * v[0] - 0.5 * h * f[1] - p[1],
        ];
        // ∂f/∂v and ∂f/∂x, with ∂x/∂v = h/2
        let (fv0, fv1) = (-k * v[1] * sin, -k * v[0] * sin);
        let w = k * v[0] * v[1] * cos;
        let (f00, f01) = (-w - g1 * x[0].cos(), w);
        let (f10, f11) = (w, -w - g2 * x[1].cos());
        let hh = 0.25 * h * h;
        let a = m11 - 0.5 * h * k * sin * v[1] - 0.5 * h * fv0 - hh * f00;
        let b = k * cos + 0.5 * h * k * sin * v[1] - 0.5 * h * fv1 - hh * f01;
        let c = k * cos - 0.5 * h * k * sin * v[0] + 0.5 * h * fv0 - hh * f10;
        let d = m22 + 0.5 * h * k * sin * v[0] + 0.5 * h * fv1 - hh * f11;
        let dv = solve(a, b, c, d, r);
        v = [v[0] - dv[0], v[1] - dv[1]];
        if dv[0].abs() <= 1e-14 * (1.0 + v[0].abs()) && dv[1].abs() <= 1e-14 * (1.0 + v[1].abs()) {
            break;
        }
    }
    let x = [q[0] + 0.5 * h * v[0], q[1] + 0.5 * h * v[1]];
    let cos = (x[0] - x[1]).cos();
    let pm = [m11 * v[0] + k * cos * v[1], m22 * v[1] + k * cos * v[0]];
    *q = [q[0] + h * v[0], q[1] + h * v[1]];
    *p = [2.0 * pm[0] - p[0], 2.0 * pm[1] - p[1]];
}

/// Makes a variational step of the free rigid body in Cayley's chart, whose error is some 14 times
/// that of the exponential chart: Newton's method with the analytic
/// Jacobian for the body velocity, from the velocity at the start, until the update is at rounding;
/// then updates the quaternion and the momentum.
#[inline]
pub(crate) fn rigid_body_cayley(q: &mut [f64; 4], p: &mut [f64; 3], h: f64, i: &[f64; 3]) {
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let mut w = [p[0] / i[0], p[1] / i[1], p[2] / i[2]];
    let (mut x, mut m) = ([0.0; 3], [0.0; 3]);
    for _ in 0..50 {
        x = w.map(|w| h * w);
        m = [i[0] * w[0], i[1] * w[1], i[2] * w[2]];
        let along = x[0] * m[0] + x[1] * m[1] + x[2] * m[2];
        let across = cross(x, m);
        // the residual m + ½ x × m + ¼ x (x·m) − Π and its Jacobian by w
        let mut r = [0.0; 3];
        let mut a = [[0.0; 3]; 3];
        for k in 0..3 {
            r[k] = m[k] + 0.5 * across[k] + 0.25 * x[k] * along - p[k];
            for j in 0..3 {
                a[k][j] = 0.5 * h * x[k] * m[j];
            }
            a[k][k] += i[k] + 0.25 * h * along;
        }
        for (k, j, l) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            // ½ (x × m)_k = ½ (x_j m_l − x_l m_j)
            a[k][j] += 0.5 * h * (m[l] - w[l] * i[j]);
            a[k][l] += 0.5 * h * (w[j] * i[l] - m[j]);
        }
        let columns: [[f64; 3]; 3] = std::array::from_fn(|j| [a[0][j], a[1][j], a[2][j]]);
        let minors = [
            cross(columns[1], columns[2]),
            cross(columns[2], columns[0]),
            cross(columns[0], columns[1]),
        ];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let inverse = 1.0 / dot(columns[0], minors[0]);
        let mut is_done = true;
        for k in 0..3 {
            let update = inverse * dot(minors[k], r);
            w[k] -= update;
            is_done &= update.abs() <= 1e-14 * (1.0 + w[k].abs());
        }
        if is_done {
            break;
        }
    }
    let turned = cross(x, m);
    for k in 0..3 {
        p[k] -= turned[k];
    }
    let half = x.map(|x| 0.5 * x);
    let vector = [q[1], q[2], q[3]];
    let across = cross(vector, half);
    let mut next = [
        q[0] - (vector[0] * half[0] + vector[1] * half[1] + vector[2] * half[2]),
        0.0,
        0.0,
        0.0,
    ];
    for k in 0..3 {
        next[k + 1] = vector[k] + q[0] * half[k] + across[k];
    }
    let square: f64 = next.iter().map(|c| c * c).sum();
    let scale = 1.0 / square.sqrt();
    *q = next.map(|c| scale * c);
}
