"""diffrax (JAX, double precision): its solvers with fixed and with adaptive steps; one path at a time, and all paths at once by `vmap`.

Solvers of stochastic equations are given the increments of the common paths, and the space-time Lévy areas where they ask for them.
"""

import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import diffrax
import equinox
import jax
import jax.numpy as jnp
import numpy as np
from common import Record, Walk, set_errors, set_invariant, set_times
from problems import Problem
from references import Paths, paths

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
EQUAL_STARTS = 256
"""Paths at once where nothing is random."""

ADAPTIVE = {
    "Dopri5": (diffrax.Dopri5, TOLERANCES),
    "Dopri8": (diffrax.Dopri8, TOLERANCES),
    "Kvaerno5": (diffrax.Kvaerno5, STIFF_TOLERANCES),
}

Lines = list[tuple[Record, Walk]]
Solved = tuple[jax.Array, jax.Array, jax.Array]
"""Times (k,), states (k, 2N) and the number of steps, with those rejected; k is 1, the horizon alone, or has room for all."""
Build = Callable[..., tuple]
"""A function of h, dw and area (steps, M) that returns the terms and the start."""


class Recorded(diffrax.AbstractBrownianPath):
    """A Brownian path with given increments and areas, both (steps, M), over steps of length h."""

    dw: jax.Array
    area: jax.Array
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
        if use_levy:
            return diffrax.SpaceTimeLevyArea(dt=t1 - t0, W=self.dw[step], H=self.area[step])
        return self.dw[step]


def _plain(problem: Problem) -> Build:
    """Terms of a problem without noise."""
    drift = problem.drift(jnp)

    def build(h, dw, area):
        return diffrax.ODETerm(lambda t, z, args: jnp.stack(drift(z))), jnp.array(problem.start)

    return build


def _noisy(problem: Problem) -> Build:
    """Terms of a problem with noise."""
    plain, kick = _plain(problem), problem.kick(jnp)
    units = np.eye(problem.processes)

    def diffusion(t, z, args):
        return jnp.stack([_vector(kick(z, unit)) for unit in units], axis=1)

    def build(h, dw, area):
        ode, start = plain(h, dw, area)
        return diffrax.MultiTerm(ode, diffrax.ControlTerm(diffusion, Recorded(dw, area, h))), start

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

    def build(h, dw, area):
        second = diffrax.ODETerm(force)
        if kick:
            second = diffrax.MultiTerm(second, diffrax.ControlTerm(diffusion, Recorded(dw, area, h)))
        start = jnp.array(problem.start)
        return (diffrax.ODETerm(velocity), second), (start[:n], start[n:])

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
    """A function of h, dw and area (steps, M)."""

    def solve(h, dw, area):
        terms, start = build(h, dw, area)
        return _solve(terms, solver, problem, h, start, all_steps, diffrax.ConstantStepSize())

    return solve


def _adaptive(problem: Problem, solver: diffrax.AbstractSolver, all_steps: bool = False) -> Callable[..., Solved]:
    """A function of the start (2N,) and the tolerance, relative and absolute."""
    build = _plain(problem)

    def solve(start, tolerance):
        terms, _ = build(None, None, None)
        return _solve(terms, solver, problem, None, start, all_steps, diffrax.PIDController(rtol=tolerance, atol=tolerance))

    return solve


def _methods(problem: Problem) -> dict[str, tuple[diffrax.AbstractSolver, Build]]:
    """The solvers with fixed steps."""
    chosen: dict[str, tuple[diffrax.AbstractSolver, Build]] = {}
    if problem.separable and problem.name != "kubo":
        chosen["SemiImplicitEuler"] = (diffrax.SemiImplicitEuler(), _separable(problem))
    if problem.processes == 0:
        return chosen | {"LeapfrogMidpoint": (diffrax.LeapfrogMidpoint(), _plain(problem))}
    best = {"ShARK": diffrax.ShARK()} if problem.additive else {"SlowRK": diffrax.SlowRK()}
    solvers = {"EulerHeun": diffrax.EulerHeun(), "Heun": diffrax.Heun(), "SPaRK": diffrax.SPaRK()} | best
    return chosen | {name: (solver, _noisy(problem)) for name, solver in solvers.items()}


def records(problem: Problem) -> tuple[list[Record], list[Record]]:
    """One path at a time, and many at once.

    Not the solar system, which takes seconds a solution, nor Kepler, where a loose tolerance lets Dopri5 fall into the centre with steps that shrink without end.
    """
    if problem.name in ("kepler", "outer_solar_system"):
        return [], []
    reference = paths(problem)
    single: Lines = []
    batch: Lines = []
    for name, (solver, build) in _methods(problem).items():
        if problem.processes > 0:
            _on_paths(problem, reference, name, _fixed(problem, solver, build), single, batch)
        else:
            _without_noise(problem, reference, name, solver, build, single)
    if problem.processes == 0:
        for name, (solver, tolerances) in ADAPTIVE.items():
            _tolerances(problem, reference, name, solver(), tolerances, single, batch)
    set_times(single)
    set_times(batch)
    return [line for line, _ in single], [line for line, _ in batch]


def _on_paths(problem: Problem, reference: Paths, name: str, solve: Callable[..., Solved], single: Lines, batch: Lines) -> None:
    one, many = jax.jit(solve), jax.jit(jax.vmap(solve, in_axes=(None, 0, 0)))
    # the same shape for all numbers of steps, so that one compilation serves all
    shape = reference.dw.shape
    for steps in problem.steps:
        h = problem.horizon / steps
        dw, area = np.zeros(shape), np.zeros(shape)
        dw[:, :steps], area[:, :steps] = reference.coarse(steps)
        dw, area = jnp.asarray(dw), jnp.asarray(area)
        line = Record(problem.name, name, h, source=SOURCE)
        set_errors(line, problem, np.asarray(many(h, dw, area)[1][:, 0]), reference.ends)
        single.append((line, Walk(_calls(partial(one, h, dw[0], area[0])), steps)))
        jax.block_until_ready(one(h, dw[0], area[0]))
        if steps in problem.batch_steps:
            batch.append((replace(line), Walk(_calls(partial(many, h, dw, area)), steps, len(dw))))


def _without_noise(problem: Problem, reference: Paths, name: str, solver, build: Build, single: Lines) -> None:
    one = jax.jit(_fixed(problem, solver, build))
    all_steps = jax.jit(_fixed(problem, solver, build, all_steps=True)) if name in WATCHED else one
    for steps in problem.steps:
        if steps <= MOST_STEPS:
            h = problem.horizon / steps
            jax.block_until_ready(one(h, None, None))
            line = Record(problem.name, name, h, source=SOURCE)
            _set_all_errors(line, problem, reference, all_steps(h, None, None))
            single.append((line, Walk(_calls(partial(one, h, None, None)), steps)))


def _tolerances(problem: Problem, reference: Paths, name: str, solver, tolerances, single: Lines, batch: Lines) -> None:
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
