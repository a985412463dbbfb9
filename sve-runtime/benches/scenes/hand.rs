//! The same steps by hand: in place, each node gathers its impulse, in blocks that stay in the
//! cache, compiled for the vectors of the machine.

/// A computation that is compiled for several widths of vectors.
pub(crate) trait Kernel {
    fn run(self);
}

/// Runs a kernel with the widest vectors of this machine.
pub(crate) fn dispatch(kernel: impl Kernel) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected as has;
        if has!("avx512f") && has!("avx512dq") && has!("avx512vl") && has!("avx512bw") {
            // Safety: the machine has the instructions.
            return unsafe { avx512(kernel) };
        }
        if has!("avx2") && has!("fma") {
            // Safety: as above.
            return unsafe { avx2(kernel) };
        }
    }
    kernel.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]
fn avx512(kernel: impl Kernel) {
    kernel.run();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn avx2(kernel: impl Kernel) {
    kernel.run();
}

pub(crate) const TILE: usize = 512;

#[inline(always)]
pub(crate) fn drift(q: &mut [f64], p: &[f64], h: f64) {
    let p = &p[..q.len()];
    for i in 0..q.len() {
        q[i] += h * p[i];
    }
}

/// A chain with free ends.
pub(crate) struct Chain<'a> {
    pub q: &'a mut [f64],
    pub p: &'a mut [f64],
    pub h: f64,
    pub beta: f64,
}

#[inline(always)]
pub(crate) fn bond(beta: f64, d: f64) -> f64 {
    d + beta * d * d * d
}

#[inline(always)]
fn kick_chain(q: &[f64], p: &mut [f64], h: f64, beta: f64) {
    let m = p.len();
    let (a, b, c) = (&q[..m], &q[1..=m], &q[2..m + 2]);
    for i in 0..m {
        p[i] += h * (bond(beta, c[i] - b[i]) - bond(beta, b[i] - a[i]));
    }
}

impl Kernel for Chain<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { q, p, h, beta } = self;
        let n = q.len();
        let (mut done, mut from) = (0, 0);
        while from < n {
            let to = (from + TILE).min(n);
            drift(&mut q[from..to], &p[from..to], h);
            if from == 0 {
                p[0] += h * bond(beta, q[1] - q[0]);
                done = 1;
            }
            kick_chain(&q[done - 1..to], &mut p[done..to - 1], h, beta);
            done = to - 1;
            from = to;
        }
        p[n - 1] -= h * bond(beta, q[n - 1] - q[n - 2]);
    }
}

/// The chain in two plain loops.
#[inline(never)]
pub(crate) fn plain_chain(q: &mut [f64], p: &mut [f64], h: f64, beta: f64) {
    let n = q.len();
    for i in 0..n {
        q[i] += h * p[i];
    }
    p[0] += h * bond(beta, q[1] - q[0]);
    for i in 1..n - 1 {
        p[i] += h * (bond(beta, q[i + 1] - q[i]) - bond(beta, q[i] - q[i - 1]));
    }
    p[n - 1] -= h * bond(beta, q[n - 1] - q[n - 2]);
}

/// A lattice with open borders; two dimensions have a first side of 1.
pub(crate) struct Lattice<'a> {
    pub sides: [usize; 3],
    pub q: &'a mut [f64],
    pub p: &'a mut [f64],
    pub h: f64,
}

#[inline(always)]
fn site(q: f64) -> f64 {
    -q * (q * q - 1.0)
}

#[inline(always)]
fn row_of_2(x: [&[f64]; 5], p: &mut [f64], h: f64) {
    let m = p.len();
    let [own, a, b, c, d] = x.map(|x| &x[..m]);
    for k in 0..m {
        let x = own[k];
        let f = site(x) + (a[k] - x) - (x - b[k]) + (c[k] - x) - (x - d[k]);
        p[k] += h * f;
    }
}

#[inline(always)]
fn row_of_3(x: [&[f64]; 7], p: &mut [f64], h: f64) {
    let m = p.len();
    let [own, a, b, c, d, e, f] = x.map(|x| &x[..m]);
    for k in 0..m {
        let x = own[k];
        let g =
            site(x) + (a[k] - x) - (x - b[k]) + (c[k] - x) - (x - d[k]) + (e[k] - x) - (x - f[k]);
        p[k] += h * g;
    }
}

impl Lattice<'_> {
    #[inline(always)]
    fn node(&mut self, c: usize) {
        let [a, b, d] = self.sides;
        let (i, j, k) = (c / (b * d), c / d % b, c % d);
        let q = &*self.q;
        let x = q[c];
        let mut f = site(x);
        for (at, side, stride) in [(i, a, b * d), (j, b, d), (k, d, 1)] {
            if at + 1 < side {
                f += q[c + stride] - x;
            }
            if at > 0 {
                f -= x - q[c - stride];
            }
        }
        self.p[c] += self.h * f;
    }
}

impl Kernel for Lattice<'_> {
    /// Rows drift one plane ahead; a row at a face takes itself for the missing neighbour.
    #[inline(always)]
    fn run(mut self) {
        let [a, b, d] = self.sides;
        let is_flat = a == 1;
        let ahead = if is_flat { 1 } else { b };
        let rows = a * b;
        drift(&mut self.q[..ahead * d], &self.p[..ahead * d], self.h);
        for row in 0..rows {
            let z = row * d;
            if row + ahead < rows {
                let next = z + ahead * d..z + (ahead + 1) * d;
                drift(&mut self.q[next.clone()], &self.p[next], self.h);
            }
            self.node(z);
            self.node(z + d - 1);
            let inner = z + 1..z + d - 1;
            let q = &*self.q;
            let near = |is_there: bool, at: usize| {
                if is_there {
                    &q[at + 1..at + d - 1]
                } else {
                    &q[inner.clone()]
                }
            };
            let (i, j) = (row / b, row % b);
            let own = &q[inner.clone()];
            let right = near(j + 1 < b, if j + 1 < b { z + d } else { 0 });
            let left = near(j > 0, z.saturating_sub(d));
            let p = &mut self.p[inner.clone()];
            let ends = [&q[z + 2..z + d], &q[z..z + d - 2]];
            if is_flat {
                row_of_2([own, right, left, ends[0], ends[1]], p, self.h);
            } else {
                let up = near(i + 1 < a, if i + 1 < a { z + b * d } else { 0 });
                let down = near(i > 0, z.saturating_sub(b * d));
                row_of_3([own, up, down, right, left, ends[0], ends[1]], p, self.h);
            }
        }
    }
}

/// Drift of all bodies; zeros in `f`.
fn move_bodies(x: &mut [[f64; 3]], p: &mut [[f64; 3]], f: &mut [[f64; 3]], h: f64) {
    let (x, p, f) = (
        x.as_flattened_mut(),
        p.as_flattened_mut(),
        f.as_flattened_mut(),
    );
    for (x, (p, f)) in x.iter_mut().zip(p.iter_mut().zip(f)) {
        *p += 0.5 * h * *f;
        *x += h * *p;
        *f = 0.0;
    }
}

/// A step of the rule of Störmer and Verlet; `f` has the forces at `x`.
pub(crate) fn verlet(
    [x, p, f]: [&mut [[f64; 3]]; 3],
    h: f64,
    force: impl FnOnce(&[[f64; 3]], &mut [[f64; 3]]),
) {
    move_bodies(x, p, f, h);
    force(x, f);
    for (p, f) in p.as_flattened_mut().iter_mut().zip(f.as_flattened()) {
        *p += 0.5 * h * f;
    }
}

/// Forces of Lennard and Jones from a half list by rows.
pub(crate) fn argon(start: &[u32], list: &[u32], x: &[[f64; 3]], f: &mut [[f64; 3]]) {
    for i in 0..x.len() {
        let p = x[i];
        let mut a = [0.0; 3];
        for &j in &list[start[i] as usize..start[i + 1] as usize] {
            let q = &x[j as usize];
            let d = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
            let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            let c = 1.0 / r2;
            let s = c * c * c;
            let w = if r2 < 6.25 {
                24.0 * c * s * (1.0 - 2.0 * s)
            } else {
                0.0
            };
            let g = &mut f[j as usize];
            for k in 0..3 {
                let t = w * d[k];
                a[k] += t;
                g[k] -= t;
            }
        }
        for k in 0..3 {
            f[i][k] += a[k];
        }
    }
}

/// Forces of bonds from a list.
pub(crate) fn bonds(list: &[[u32; 2]], x: &[[f64; 3]], f: &mut [[f64; 3]]) {
    for &[i, j] in list {
        let (i, j) = (i as usize, j as usize);
        let d = [x[j][0] - x[i][0], x[j][1] - x[i][1], x[j][2] - x[i][2]];
        let r = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        let w = 100.0 * (r - 1.0) / r;
        for k in 0..3 {
            let t = w * d[k];
            f[i][k] += t;
            f[j][k] -= t;
        }
    }
}

/// Forces of angles from a list, with the potential 10 (cos + ½)².
pub(crate) fn angles(list: &[[u32; 3]], x: &[[f64; 3]], f: &mut [[f64; 3]]) {
    for &angle in list {
        let [i, j, k] = angle.map(|i| i as usize);
        let a: [f64; 3] = std::array::from_fn(|axis| x[i][axis] - x[j][axis]);
        let b: [f64; 3] = std::array::from_fn(|axis| x[k][axis] - x[j][axis]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (a2, b2) = (dot(a, a), dot(b, b));
        let inverse = 1.0 / (a2 * b2).sqrt();
        let cos = dot(a, b) * inverse;
        let slope = -20.0 * (cos + 0.5);
        for axis in 0..3 {
            let on_i = slope * (b[axis] * inverse - a[axis] * cos / a2);
            let on_k = slope * (a[axis] * inverse - b[axis] * cos / b2);
            f[i][axis] += on_i;
            f[k][axis] += on_k;
            f[j][axis] -= on_i + on_k;
        }
    }
}

/// Forces of all pairs of bodies, from arrays of coordinates, in blocks of 16.
pub(crate) struct AllPairs<'a> {
    pub x: &'a [[f64; 3]],
    pub f: &'a mut [[f64; 3]],
    pub arrays: &'a mut [Vec<f64>; 6],
    pub softening: f64,
}

#[inline(always)]
fn block(
    a: [f64; 3],
    softening: f64,
    x: [&[f64; 16]; 3],
    f: [&mut [f64; 16]; 3],
    own: &mut [[f64; 16]; 3],
) {
    let [fx, fy, fz] = f;
    for k in 0..16 {
        let (u, v, w) = (x[0][k] - a[0], x[1][k] - a[1], x[2][k] - a[2]);
        let r2 = u * u + v * v + w * w + softening;
        let c = 1.0 / (r2 * r2.sqrt());
        own[0][k] += c * u;
        own[1][k] += c * v;
        own[2][k] += c * w;
        fx[k] -= c * u;
        fy[k] -= c * v;
        fz[k] -= c * w;
    }
}

impl Kernel for AllPairs<'_> {
    #[inline(always)]
    fn run(self) {
        let Self {
            x,
            f,
            arrays: [x0, x1, x2, f0, f1, f2],
            softening,
        } = self;
        let n = x.len();
        for (i, x) in x.iter().enumerate() {
            [x0[i], x1[i], x2[i]] = *x;
        }
        for f in [&mut *f0, f1, f2] {
            f.fill(0.0);
        }
        for i in 0..n {
            let a = [x0[i], x1[i], x2[i]];
            let mut own = [[0.0; 16]; 3];
            let mut j = i + 1;
            let mut sum = [0.0; 3];
            let aligned = n.min(j.next_multiple_of(16));
            let mut single = |j: usize, f: [&mut Vec<f64>; 3]| {
                let d = [x0[j] - a[0], x1[j] - a[1], x2[j] - a[2]];
                let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + softening;
                let c = 1.0 / (r2 * r2.sqrt());
                for (k, f) in f.into_iter().enumerate() {
                    sum[k] += c * d[k];
                    f[j] -= c * d[k];
                }
            };
            while j < aligned {
                single(j, [f0, f1, f2]);
                j += 1;
            }
            let [c0, c1, c2] = [&x0[j..], &x1[j..], &x2[j..]].map(|x| x.as_chunks::<16>());
            let [g0, g1, g2] =
                [&mut f0[j..], &mut f1[j..], &mut f2[j..]].map(|f| f.as_chunks_mut::<16>().0);
            let blocks = c0.0.iter().zip(c1.0).zip(c2.0);
            for (((x, y), z), ((f, g), h)) in blocks.zip(g0.iter_mut().zip(g1).zip(g2)) {
                block(a, softening, [x, y, z], [f, g, h], &mut own);
            }
            let rest = j + 16 * c0.0.len();
            for j in rest..n {
                single(j, [f0, f1, f2]);
            }
            f0[i] += sum[0] + own[0].iter().sum::<f64>();
            f1[i] += sum[1] + own[1].iter().sum::<f64>();
            f2[i] += sum[2] + own[2].iter().sum::<f64>();
        }
        for (i, f) in f.iter_mut().enumerate() {
            f[0] += f0[i];
            f[1] += f1[i];
            f[2] += f2[i];
        }
    }
}
