//! Proof that a solution of the stages is connected with the limit of no noise and h → 0.
//!
//! Input: a step with its solution, and bounds of derivatives over a box. Output: true if the proof
//! succeeds. If it fails, continuation follows the solution.
//!
//! Write `z_i = (Q_i, V_i)` for positions and velocities of the stages, `z₀` for the start. Let σ
//! scale the step size and s the increments. The equations of a step, with the impulses `F_j`
//! without noise and `Γ_j` of the noise, are a fixed point `z = T(z)` of
//!
//! ```text
//! Q_i ← q₀ + σ h Σ_j a_ij V_j + s Σ_j μ_ij Σ_a ω_aj ∂G_a/∂p
//! V_i ← V_i − B (∂L/∂v(Q_i, V_i) − p₀ − Σ_j μ_ij (σ F_j + s Γ_j))
//! ```
//!
//! with the inverse `B` of a mass matrix. Let z be the solution, and split its distance from the
//! limit into `z − z₀ = d + g`, where `g` is the part due to noise. On the way from the limit to
//! the solution σ and then s grow from 0 to 1. The point `y = z₀ + σ d + s g` follows a polygon to
//! z. At both ends of each side, y satisfies the equations, exactly if there is no noise. Hence
//! `T(y) − y` is bounded by a quarter of the change of T along a side plus the change of T by
//! noise. If a vector of radii r, one for each coordinate, satisfies
//!
//! ```text
//! |T(y) − y| + K r < r
//! ```
//!
//! with a matrix K of Lipschitz constants of T in the box of all balls of radius r around these y,
//! then T is a contraction of each ball into itself. Each ball has one fixed point, which depends
//! continuously on σ and s (Banach). The fixed point is z₀ at the start and z at the end, so z is
//! the connected solution. The inequality holds for steps that are short for the system, since K is
//! about h times its frequency.
//!
//! Distances at stage i are in units of `w_i`, the eigenvector of `|a_ij|` for which the norm is
//! smallest.
//!
//! Source: Ortega, Rheinboldt, *Iterative Solution of Nonlinear Equations in Several Variables*
//! (1970), sections 12.1 and 13.1, for componentwise contractions.

use super::bounds::{NodeBounds, Radii, StageBounds};
use super::jacobian::moves_position;
use super::room::{Distances, Extent, Needed, Room, magnitudes, momentum};
use super::stages::Rows;
use super::step::Step;
use super::tableau::Tableau;
use crate::lanes::solve::inverse;
use crate::phase::configuration::VectorCoordinates;
use crate::system::Dims;

/// Number of rooms that are tried (`room.rs`).
const TRIALS: u32 = 4;

/// Least size of a room, so that a system at rest has a room.
const LEAST: f64 = 1e-150;

/// A solution of the stages, a row for each coordinate.
pub(super) struct Solution<const S: usize, const N: usize> {
    /// The velocity at the start.
    pub(super) start: [f64; N],
    /// Positions, velocities and momenta, relative to the values at the start.
    pub(super) moves: Rows<S, N>,
    pub(super) changes: Rows<S, N>,
    pub(super) kicks: Rows<S, N>,
}

/// Returns whether the bounds prove that the solution is connected with the limit.
#[inline]
pub(super) fn is_connected<Sys, Q, const S: usize, const N: usize, const M: usize, const K: usize>(
    step: &Step<'_, Sys, S, N, M>,
    solution: &Solution<S, N>,
) -> bool
where
    Sys: StageBounds<N, M, Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let path = Path {
        step,
        start: &solution.start,
        q: Extent::of(&solution.moves),
        v: Extent::of(&solution.changes),
        p: Extent::of(&solution.kicks),
        moves_position: moves_position::<S, N, K>(),
    };
    let mut room = path.first_room();
    for _ in 0..TRIALS {
        match path.needed(&room) {
            Some(more) if more.is_enough => return true,
            Some(more) => room = more.room,
            None => return false,
        }
    }
    false
}

/// The path of a solution from the limit.
struct Path<'a, Sys, const S: usize, const N: usize, const M: usize> {
    step: &'a Step<'a, Sys, S, N, M>,
    /// The velocity at the start.
    start: &'a [f64; N],
    q: Extent<N>,
    v: Extent<N>,
    p: Extent<N>,
    /// True if a noise depends on momenta.
    moves_position: bool,
}

impl<Sys, Q, const S: usize, const N: usize, const M: usize> Path<'_, Sys, S, N, M>
where
    Sys: StageBounds<N, M, Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    /// Returns a room that is large enough for most short steps.
    #[inline(always)]
    fn first_room(&self) -> Room<N> {
        let mut room = Room {
            q: [LEAST; N],
            v: [LEAST; N],
            p: [LEAST; N],
        };
        for n in 0..N {
            room.q[n] += 0.125 * self.q.far[n] + 0.4 * self.step.h.abs() * self.v.far[n];
            room.v[n] += 0.6 * self.v.far[n];
            room.p[n] += 2.0 * self.p.far[n];
        }
        room
    }

    /// Returns the bounds over the box with this room.
    #[inline(always)]
    fn bounds(&self, room: &Room<N>) -> NodeBounds<N, M> {
        let Step { state, h, .. } = *self.step;
        let (mut q, mut v, mut p) = (state.q, *self.start, state.p);
        let mut radii = Radii {
            t: 0.5 * h.abs(),
            q: room.q,
            v: room.v,
            p: room.p,
        };
        for n in 0..N {
            q[n] += self.q.middle[n];
            v[n] += self.v.middle[n];
            p[n] += self.p.middle[n];
            radii.q[n] += self.q.half[n];
            radii.v[n] += self.v.half[n];
            radii.p[n] += self.p.half[n];
        }
        let time = state.t + 0.5 * h;
        self.step.system.bounds(time, [&q, &v, &p], &radii)
    }

    /// Returns the room that the bounds over a room require; `None` if there are no bounds.
    #[inline(always)]
    fn needed(&self, room: &Room<N>) -> Option<Needed<N>> {
        let bounds = self.bounds(room);
        if !bounds.hold {
            return None;
        }
        let inverse = inverse(&bounds.mass);
        let increments = self.increments();
        let noise = self.moved_by_noise(&bounds, &inverse, &increments);
        let needed_q = self.needed_of_positions(&bounds, &increments, room, &noise);
        let mut pushed = self.impulses(&bounds, &increments, &self.near(room, &noise));
        self.add_momenta(&bounds, room, &noise, &mut pushed);
        let needed_v = magnitudes(&inverse, &pushed);
        let mut more = Needed {
            is_enough: true,
            room: *room,
        };
        more.grow(|room| &mut room.q, &needed_q, &noise.q);
        more.grow(|room| &mut room.v, &needed_v, &noise.v);
        if self.moves_position {
            let far = self.distances(1.0, 0.0, room, &noise);
            let needed_p = momentum(&bounds, &far, self.latest());
            more.grow(|room| &mut room.p, &needed_p, &[0.0; N]);
        }
        Some(more)
    }

    /// Returns g, the distances that noise moves the stages.
    #[inline(always)]
    fn moved_by_noise(
        &self,
        bounds: &NodeBounds<N, M>,
        inverse: &[[f64; N]; N],
        increments: &[f64; M],
    ) -> Distances<N> {
        let tableau = const { &Tableau::<S>::VALUES };
        let (mut impulse, mut shift) = ([0.0; N], [0.0; N]);
        for a in 0..M {
            let reach = tableau.reach * increments[a];
            for n in 0..N {
                impulse[n] += reach * bounds.noises[a].against[n];
                shift[n] += reach * bounds.noises[a].dp[n];
            }
        }
        let v = magnitudes(inverse, &impulse);
        for n in 0..N {
            shift[n] += tableau.norm * self.step.h.abs() * v[n];
        }
        Distances { q: shift, v }
    }

    /// Returns `room + part (|d| + |g|) + more |g|`.
    #[inline(always)]
    fn distances(
        &self,
        part: f64,
        more: f64,
        room: &Room<N>,
        noise: &Distances<N>,
    ) -> Distances<N> {
        let mut all = Distances {
            q: room.q,
            v: room.v,
        };
        for n in 0..N {
            all.q[n] += part * (self.q.far[n] + noise.q[n]) + more * noise.q[n];
            all.v[n] += part * (self.v.far[n] + noise.v[n]) + more * noise.v[n];
        }
        all
    }

    /// Returns the distances over which T varies: the radii, and a quarter of the chord and of the
    /// noise.
    #[inline(always)]
    fn near(&self, room: &Room<N>, noise: &Distances<N>) -> Distances<N> {
        self.distances(0.25, 0.0, room, noise)
    }

    /// Returns the longest time to a stage, in units of the stage.
    #[inline(always)]
    fn latest(&self) -> f64 {
        self.step.h.abs() * const { Tableau::<S>::VALUES.latest }
    }

    #[inline(always)]
    fn needed_of_positions(
        &self,
        bounds: &NodeBounds<N, M>,
        increments: &[f64; M],
        room: &Room<N>,
        noise: &Distances<N>,
    ) -> [f64; N] {
        let (near, time) = (self.near(room, noise), 0.25 * self.latest());
        let mut needed = [0.0; N];
        for n in 0..N {
            needed[n] = self.step.h.abs() * (near.v[n] - noise.v[n]);
        }
        if self.moves_position {
            let p = momentum(bounds, &near, time);
            for a in 0..M {
                let of = &bounds.noises[a];
                for n in 0..N {
                    let mut flow = of.dpt[n] * time;
                    for k in 0..N {
                        flow += of.dqp[k][n] * near.q[k] + of.dpp[n][k] * p[k];
                    }
                    needed[n] += increments[a] * flow;
                }
            }
        }
        needed.map(|x| const { Tableau::<S>::VALUES.norm } * x)
    }

    /// Returns how much the impulses vary within `near`.
    #[inline(always)]
    fn impulses(
        &self,
        bounds: &NodeBounds<N, M>,
        increments: &[f64; M],
        near: &Distances<N>,
    ) -> [f64; N] {
        let time = 0.25 * self.latest();
        let mut impulses = [0.0; N];
        for n in 0..N {
            let mut force = bounds.force_by_time[n] * time;
            for k in 0..N {
                force += bounds.force_by_position[n][k] * near.q[k];
                force += bounds.force_by_velocity[n][k] * near.v[k];
            }
            impulses[n] = self.step.h.abs() * force;
        }
        let p = momentum(bounds, near, time);
        for a in 0..M {
            let of = &bounds.noises[a];
            for n in 0..N {
                let mut force = of.against_t[n] * time;
                for k in 0..N {
                    force += of.against_q[n][k] * near.q[k] + of.dqp[n][k] * p[k];
                    if Sys::NOISE_FORCED {
                        force += of.force_v[n][k] * near.v[k];
                    }
                }
                impulses[n] += increments[a] * force;
            }
        }
        impulses.map(|x| const { Tableau::<S>::VALUES.norm } * x)
    }

    /// Adds the difference between `∂L/∂v` and its linearisation by velocities, which the inverse
    /// of the mass matrix does not solve.
    #[inline(always)]
    fn add_momenta(
        &self,
        bounds: &NodeBounds<N, M>,
        room: &Room<N>,
        noise: &Distances<N>,
        pushed: &mut [f64; N],
    ) {
        // Half of the chord, the noise, and the radii, which the room has beside the noise.
        let chord = self.distances(0.5, 1.0, room, noise);
        for n in 0..N {
            pushed[n] += 0.5 * self.latest() * bounds.momentum_by_time_radius[n];
            for k in 0..N {
                pushed[n] += bounds.momentum_by_position[n][k] * room.q[k];
                pushed[n] += bounds.momentum_by_position_radius[n][k] * (chord.q[k] - room.q[k]);
                pushed[n] += bounds.mass_radius[n][k] * chord.v[k];
            }
        }
    }

    /// Returns the largest increment of each process at a stage, in units of the weights.
    #[inline(always)]
    fn increments(&self) -> [f64; M] {
        let inverse_b = const { &Tableau::<S>::VALUES.inverse_b };
        let mut largest = [0.0_f64; M];
        for a in 0..M {
            for i in 0..S {
                largest[a] = largest[a].max(self.step.noise[a][i].abs() * inverse_b[i]);
            }
        }
        largest
    }
}
