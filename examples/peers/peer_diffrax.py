"""diffrax (JAX, double precision): its solvers with fixed and with adaptive steps; one path at a time, and all paths at once by `vmap`.

Solvers of stochastic equations are given the increments of the common paths, and the space-time and space-time-time Lévy areas where they ask for them.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import diffrax
import equinox
import jax
import jax.numpy as jnp
import numpy as np
from common import Record, Walk, Walks, set_errors, set_invariant
from problems import LANGEVIN_KT, LANGEVIN_NU, Problem
from references import Noise, Paths, paths

# where it is used, noise depends on q alone, and the equations of Itô and of Stratonovich are the same
warnings.filterwarnings("ignore", "`SemiImplicitEuler` is not marked as converging")
jax.config.update("jax_enable_x64", True)

SOURCE = f"diffrax {diffrax.__version__}"
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)
STIFF_TOLERANCES = (1e-3, 1e-5, 1e-7)
"""For an implicit method; what is more precise takes seconds."""
WATCHED = ("SemiImplicitEuler", "Dopri8")
"""Methods whose energy is watched: to keep all states has to be compiled apart."""
BATCHED = ("Dopri8",)
"""Methods with adaptive steps of which many equal problems are solved at once."""
MOST_STEPS = 1 << 17
"""More steps than this are not taken, for time."""
TAYLOR_THRESHOLD = 0.01
"""Product of friction and step below which the Langevin solvers expand their coefficients: the value that diffrax recommends for 64 bits."""
EQUAL_STARTS = 256
"""Paths at once where nothing is random."""

ADAPTIVE = {
    "Dopri5": (diffrax.Dopri5, TOLERANCES),
    "Dopri8": (diffrax.Dopri8, TOLERANCES),
    "Kvaerno5": (diffrax.Kvaerno5, STIFF_TOLERANCES),
}

Solved = tuple[jax.Array, jax.Array, jax.Array]
"""Times (k,), states (k, 2N) and the number of steps, with those rejected; k is 1, the horizon alone, or has room for all."""
Arrays = tuple[jax.Array, jax.Array, jax.Array]
"""Increments and areas H and K, each (steps, M)."""
Build = Callable[..., tuple]
"""A function of h and the arrays of the noise that returns the terms and the start."""


class Recorded(diffrax.AbstractBrownianPath):
    """A Brownian path with given increments and areas, each (steps, M), over steps of length h."""

    noise: Arrays
    h: jax.Array
    levy_area: type = equinox.field(static=True, default=diffrax.SpaceTimeLevyArea)

    @property
    def t0(self):
        """Where the path begins."""
        return 0.0

    @property
    def t1(self):
        """It has as many steps as it has, whatever their length."""
        return jnp.inf

    def evaluate(self, t0, t1=None, left=True, use_levy=False):
        """The increment over the step that begins at t0; nothing else is asked for with fixed steps."""
        del left
        step = jnp.round(t0 / self.h).astype(int)
        dw, area, third = self.noise
        if not use_levy:
            return dw[step]
        if self.levy_area is diffrax.SpaceTimeTimeLevyArea:
            return diffrax.SpaceTimeTimeLevyArea(dt=t1 - t0, W=dw[step], H=area[step], K=third[step])
        return diffrax.SpaceTimeLevyArea(dt=t1 - t0, W=dw[step], H=area[step])


def _plain(problem: Problem) -> Build:
    """Terms of a problem without noise."""
    drift = problem.drift(jnp)

    def build(h, noise):
        return diffrax.ODETerm(lambda t, z, args: jnp.stack(drift(z))), jnp.array(problem.start)

    return build


def _noisy(problem: Problem) -> Build:
    """Terms of a problem with noise."""
    plain, kick = _plain(problem), problem.kick(jnp)
    units = np.eye(problem.processes)

    def diffusion(t, z, args):
        return jnp.stack([_vector(kick(z, unit)) for unit in units], axis=1)

    def build(h, noise):
        ode, start = plain(h, noise)
        return diffrax.MultiTerm(ode, diffrax.ControlTerm(diffusion, Recorded(noise, h))), start

    return build


def _separable(problem: Problem) -> Build:
    """Terms for a solver that takes dq/dt(p) and dp/dt(q) apart."""
    drift, kick = problem.drift(jnp), problem.kick and problem.kick(jnp)
    n = problem.dimension // 2
    units = np.eye(problem.processes)
    nothing = (0.0,) * n

    def velocity(t, p, args):
        return jnp.stack(drift((*nothing, *p))[:n])

    def force(t, q, args):
        return jnp.stack(drift((*q, *nothing))[n:])

    def diffusion(t, q, args):
        return jnp.stack([_vector(kick((*q, *nothing), unit)[n:]) for unit in units], axis=1)

    def build(h, noise):
        second = diffrax.ODETerm(force)
        if kick:
            second = diffrax.MultiTerm(second, diffrax.ControlTerm(diffusion, Recorded(noise, h)))
        start = jnp.array(problem.start)
        return (diffrax.ODETerm(velocity), second), (start[:n], start[n:])

    return build


def _langevin(problem: Problem, levy_area: type) -> Build:
    """Terms for solvers of dx = v dt, dv = −γ v dt − u ∇f dt + √(2γu) dW: γ is the friction, u the temperature, and u ∇f minus the force at rest."""
    drift = problem.drift(jnp)
    n = problem.dimension // 2

    def gradient(q, args):
        return jnp.stack(drift((*q, *(0.0,) * n))[n:]) / -LANGEVIN_KT

    def build(h, noise):
        diffusion = diffrax.UnderdampedLangevinDiffusionTerm(LANGEVIN_NU, LANGEVIN_KT, Recorded(noise, h, levy_area))
        start = jnp.array(problem.start)
        return diffrax.MultiTerm(diffrax.UnderdampedLangevinDriftTerm(LANGEVIN_NU, LANGEVIN_KT, gradient), diffusion), (start[:n], start[n:])

    return build


def _vector(components: tuple) -> jax.Array:
    return jnp.stack([jnp.asarray(x, float) for x in components])


def _solve(terms, solver, problem: Problem, h, start, all_steps: bool, controller) -> Solved:
    solution = diffrax.diffeqsolve(
        terms,
        solver,
        0.0,
        problem.horizon,
        h,
        start,
        saveat=diffrax.SaveAt(t0=True, steps=True) if all_steps else diffrax.SaveAt(t1=True),
        stepsize_controller=controller,
        max_steps=MOST_STEPS + 1 if all_steps else None,
        throw=False,
    )
    return solution.ts, jnp.concatenate(jax.tree.leaves(solution.ys), axis=-1), solution.stats["num_steps"]


def _fixed(problem: Problem, solver: diffrax.AbstractSolver, build: Build, all_steps: bool = False) -> Callable[..., Solved]:
    """A function of h and the arrays of the noise."""

    def solve(h, noise):
        terms, start = build(h, noise)
        return _solve(terms, solver, problem, h, start, all_steps, diffrax.ConstantStepSize())

    return solve


def _adaptive(problem: Problem, solver: diffrax.AbstractSolver, all_steps: bool = False) -> Callable[..., Solved]:
    """A function of the start (2N,) and the tolerance, relative and absolute."""
    build = _plain(problem)

    def solve(start, tolerance):
        terms, _ = build(None, None)
        return _solve(terms, solver, problem, None, start, all_steps, diffrax.PIDController(rtol=tolerance, atol=tolerance))

    return solve


@dataclass(frozen=True)
class Fixed:
    """A solver with fixed steps, its terms, and whether it is run with `more_steps` too."""

    solver: diffrax.AbstractSolver
    build: Build
    more: bool = False


def methods(problem: Problem) -> dict[str, Fixed]:
    """The solvers with fixed steps."""
    chosen: dict[str, Fixed] = {}
    if problem.separable and problem.name != "kubo":
        chosen["SemiImplicitEuler"] = Fixed(diffrax.SemiImplicitEuler(), _separable(problem))
    if problem.processes == 0:
        return chosen | {"LeapfrogMidpoint": Fixed(diffrax.LeapfrogMidpoint(), _plain(problem))}
    noisy = _noisy(problem)
    chosen |= {"EulerHeun": Fixed(diffrax.EulerHeun(), noisy), "Heun": Fixed(diffrax.Heun(), noisy), "SPaRK": Fixed(diffrax.SPaRK(), noisy, more=True)}
    if not problem.additive:
        return chosen | {"SlowRK": Fixed(diffrax.SlowRK(), noisy)}
    chosen["ShARK"] = Fixed(diffrax.ShARK(), noisy, more=True)
    if problem.name == "langevin":
        first, second = _langevin(problem, diffrax.SpaceTimeLevyArea), _langevin(problem, diffrax.SpaceTimeTimeLevyArea)
        chosen["ALIGN"] = Fixed(diffrax.ALIGN(TAYLOR_THRESHOLD), first, more=True)
        chosen["ShOULD"] = Fixed(diffrax.ShOULD(TAYLOR_THRESHOLD), second)
        chosen["QUICSORT"] = Fixed(diffrax.QUICSORT(TAYLOR_THRESHOLD), second)
    return chosen


def all_ends(problem: Problem, method: Fixed, steps: int) -> np.ndarray:
    """States at the horizon of all paths, shape (paths, 2N)."""
    many = jax.jit(jax.vmap(_fixed(problem, method.solver, method.build), in_axes=(None, 1)))
    return np.asarray(many(problem.horizon / steps, _arrays(paths(problem).coarse(steps)))[1][:, 0])


def walks(problem: Problem) -> tuple[Walks, Walks]:
    """One path at a time, and many at once.

    Not the solar system, which takes seconds a solution, nor Kepler, where a loose tolerance lets Dopri5 fall into the centre with steps that shrink without end; nor uneven motions.
    """
    if problem.name in ("kepler", "outer_solar_system") or not problem.steps:
        return [], []
    reference = paths(problem)
    single: Walks = []
    batch: Walks = []
    for name, method in methods(problem).items():
        if problem.processes > 0:
            _on_paths(problem, reference, name, method, single, batch)
        else:
            _without_noise(problem, reference, name, method, single)
    if problem.processes == 0:
        for name, (solver, tolerances) in ADAPTIVE.items():
            _tolerances(problem, reference, name, solver(), tolerances, single, batch)
    return single, batch


def _on_paths(problem: Problem, reference: Paths, name: str, method: Fixed, single: Walks, batch: Walks) -> None:
    solve = _fixed(problem, method.solver, method.build)
    # paths are the last index but one, so that a step of all of them reads neighbours in memory
    one, many = jax.jit(solve), jax.jit(jax.vmap(solve, in_axes=(None, 1)))
    for steps in problem.steps + problem.more_steps * method.more:
        h = problem.horizon / steps
        noise = _arrays(reference.coarse(steps), problem.finest)
        first = tuple(part[:, 0] for part in noise)
        line = Record(problem.name, name, h, source=SOURCE)
        set_errors(line, problem, np.asarray(many(h, noise)[1][:, 0]), reference.ends)
        single.append((line, Walk(_calls(partial(one, h, first)), steps)))
        jax.block_until_ready(one(h, first))
        if steps in problem.batch_steps:
            batch.append((replace(line), Walk(_calls(partial(many, h, noise)), steps, problem.paths)))


def _arrays(noise: Noise, length: int = 0) -> Arrays:
    """Increments and areas (steps, paths, M), filled up with zeros to this number of steps: one compilation serves all arrays of a shape."""

    def array(part: np.ndarray) -> jax.Array:
        paths, steps, processes = part.shape
        filled = np.zeros((max(length, steps), paths, processes))
        filled[:steps] = np.moveaxis(part, 1, 0)
        return jnp.asarray(filled)

    return array(noise.dw), array(noise.area), array(noise.third)


def _without_noise(problem: Problem, reference: Paths, name: str, method: Fixed, single: Walks) -> None:
    one = jax.jit(_fixed(problem, method.solver, method.build))
    all_steps = jax.jit(_fixed(problem, method.solver, method.build, all_steps=True)) if name in WATCHED else one
    for steps in problem.steps:
        if steps <= MOST_STEPS:
            h = problem.horizon / steps
            jax.block_until_ready(one(h, None))
            line = Record(problem.name, name, h, source=SOURCE)
            _set_all_errors(line, problem, reference, all_steps(h, None))
            single.append((line, Walk(_calls(partial(one, h, None)), steps)))


def _tolerances(problem: Problem, reference: Paths, name: str, solver, tolerances, single: Walks, batch: Walks) -> None:
    one = jax.jit(_adaptive(problem, solver))
    all_steps = jax.jit(_adaptive(problem, solver, all_steps=True)) if name in WATCHED else one
    many = jax.jit(jax.vmap(_adaptive(problem, solver), in_axes=(0, None)))
    start = jnp.array(problem.start)
    starts = jnp.tile(start, (EQUAL_STARTS, 1))
    for number, tolerance in enumerate(tolerances):
        _, _, steps = one(start, tolerance)
        if int(steps) < MOST_STEPS:
            line = Record(problem.name, name, source=SOURCE)
            _set_all_errors(line, problem, reference, all_steps(start, tolerance))
            single.append((line, Walk(_calls(partial(one, start, tolerance)), int(steps))))
            if name in BATCHED and number % 2 == 0:
                jax.block_until_ready(many(starts, tolerance))
                batch.append((replace(line), Walk(_calls(partial(many, starts, tolerance)), int(steps), EQUAL_STARTS)))


def _set_all_errors(line: Record, problem: Problem, reference: Paths, solved: Solved) -> None:
    times, states = np.asarray(solved[0]), np.asarray(solved[1])
    # what was not needed of the arrays is infinite
    used = np.isfinite(times)
    set_errors(line, problem, states[used][-1:], reference.ends)
    if used.sum() > 1:
        set_invariant(line, problem, times[used], states[used][None])


def _calls(call: Callable[[], object]) -> Callable[[int], object]:
    def run(times: int) -> None:
        for _ in range(times):
            jax.block_until_ready(call())

    return run
