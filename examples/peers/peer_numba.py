"""numba: steps as one writes them by hand, compiled; one path at a time, and for explicit steps all paths at once.

Every method is a function step(z, h, dw) → (z, iterations) of tuples.
"""

import math
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from common import Record, Walk, Walks, set_errors, set_invariant
from compiled import jit, plus, rate
from problems import (
    GRAVITY,
    HENON_HEILES_SIGMA,
    KUBO_A,
    KUBO_SIGMA,
    LANGEVIN_A,
    LANGEVIN_NU,
    LANGEVIN_SIGMA,
    OSCILLATOR_SIGMA,
    SYNCHROTRON_OMEGA,
    SYNCHROTRON_SIGMA,
    Problem,
)
from references import paths

SOURCE = f"numba {numba.__version__}"

Array = np.ndarray
Step = Callable[[tuple, float, Array], tuple]

TOLERANCE = 1e-13
"""Largest last change of an iteration, relative to 1 + |v|."""
MOST = 50
"""Iterations at most."""


@jit
def walk(step: Any, start: tuple, h: float, dw: Array, times: int) -> tuple[Array, int]:
    """Ends (times, 2N) of the paths dw (paths, steps, M), one after another and again from the first, and all iterations."""
    ends = np.empty((times, len(start)))
    iterations = 0
    for k in range(times):
        path = dw[k % dw.shape[0]]
        z = start
        for n in range(path.shape[0]):
            z, more = step(z, h, path[n])
            iterations += more
        for i in range(len(start)):
            ends[k, i] = z[i]
    return ends, iterations


@jit
def record(step: Any, start: tuple, h: float, dw: Array) -> Array:
    """All states (paths, steps + 1, 2N) of the paths dw (paths, steps, M)."""
    states = np.empty((dw.shape[0], dw.shape[1] + 1, len(start)))
    for k in range(dw.shape[0]):
        z = start
        states[k, 0] = z
        for n in range(dw.shape[1]):
            z, _ = step(z, h, dw[k, n])
            states[k, n + 1] = z
    return states


@jit
def together(step: Any, start: tuple, h: float, dw: Array) -> Array:
    """Ends (2, paths) of the paths dw (steps, M, paths), a step of all before the next: a loop that vectorises. For states (q, p)."""
    q, p = np.full(dw.shape[2], start[0]), np.full(dw.shape[2], start[1])
    for n in range(dw.shape[0]):
        increments = dw[n]
        for k in range(dw.shape[2]):
            (q[k], p[k]), _ = step((q[k], p[k]), h, increments[:, k])
    return np.stack((q, p))


def symplectic_euler(impulse: Callable, degrees: int, nu: float = 0.0) -> Step:
    """p₁ = p₀ + impulse(q₀) − h ν p₁, then q₁ = q₀ + h p₁; `impulse(q, h, dw)` is that of all forces and noises."""
    if degrees == 1:

        def step(z, h, dw):
            q, p = z
            p = (p + impulse(q, h, dw)) / (1.0 + h * nu)
            return (q + h * p, p), 0

    else:

        def step(z, h, dw):
            x, y, px, py = z
            ix, iy = impulse((x, y), h, dw)
            px, py = px + ix, py + iy
            return (x + h * px, y + h * py, px, py), 0

    return jit(step)


def midpoint_newton_1(impulse: Callable, slope: Callable, nu: float = 0.0) -> Step:
    """Implicit midpoint in the mean velocity: v (1 + hν/2) = p₀ + impulse(q₀ + h v/2)/2, p₁ = 2v − p₀, by Newton's method; `slope` is d impulse/dq."""

    def step(z, h, dw):
        q, p = z
        v = p
        for i in range(1, MOST):
            middle = q + 0.5 * h * v
            residual = v * (1.0 + 0.5 * h * nu) - p - 0.5 * impulse(middle, h, dw)
            change = residual / (1.0 + 0.5 * h * nu - 0.25 * h * slope(middle, h, dw))
            v -= change
            if abs(change) < TOLERANCE * (1.0 + abs(v)):
                return (q + h * v, 2.0 * v - p), i
        return (math.nan, math.nan), MOST

    return jit(step)


def midpoint_newton_2(impulse: Callable, slopes: Callable) -> Step:
    """The same for two degrees of freedom without friction; `slopes` are xx, xy, yy of the symmetric Jacobian of the impulse."""

    def step(z, h, dw):
        x, y, px, py = z
        u, v = px, py
        for i in range(1, MOST):
            middle = (x + 0.5 * h * u, y + 0.5 * h * v)
            ix, iy = impulse(middle, h, dw)
            xx, xy, yy = slopes(middle, h, dw)
            rx, ry = u - px - 0.5 * ix, v - py - 0.5 * iy
            a, b, d = 1.0 - 0.25 * h * xx, -0.25 * h * xy, 1.0 - 0.25 * h * yy
            det = a * d - b * b
            cx, cy = (d * rx - b * ry) / det, (a * ry - b * rx) / det
            u, v = u - cx, v - cy
            if abs(cx) + abs(cy) < TOLERANCE * (1.0 + abs(u) + abs(v)):
                return (x + h * u, y + h * v, 2.0 * u - px, 2.0 * v - py), i
        return (math.nan, math.nan, math.nan, math.nan), MOST

    return jit(step)


def midpoint_fixed_point_4(problem: Problem) -> Step:
    """Implicit midpoint for four components by fixed-point iteration of the whole change of the state."""
    change, add = rate(problem), plus(4)

    def step(z, h, dw):
        k = change(z, h, dw)
        for i in range(1, MOST):
            new = change(add(z, 0.5, k), h, dw)
            distance = abs(new[0] - k[0]) + abs(new[1] - k[1]) + abs(new[2] - k[2]) + abs(new[3] - k[3])
            k = new
            if distance < TOLERANCE * (1.0 + abs(z[2]) + abs(z[3])):
                return add(z, 1.0, k), i
        return (math.nan, math.nan, math.nan, math.nan), MOST

    return jit(step)


def runge_kutta_4(problem: Problem) -> Step:
    """The classical method, for problems without noise."""
    change, add = rate(problem), plus(problem.dimension)

    def step(z, h, dw):
        k1 = change(z, h, dw)
        k2 = change(add(z, 0.5, k1), h, dw)
        k3 = change(add(z, 0.5, k2), h, dw)
        k4 = change(add(z, 1.0, k3), h, dw)
        return add(add(z, 1.0 / 6.0, add(k1, 2.0, k2)), 1.0 / 6.0, add(k4, 2.0, k3)), 0

    return jit(step)


def heun(problem: Problem) -> Step:
    """Heun's method for the equation of Stratonovich."""
    change, add = rate(problem), plus(problem.dimension)

    def step(z, h, dw):
        k1 = change(z, h, dw)
        k2 = change(add(z, 1.0, k1), h, dw)
        return add(add(z, 0.5, k1), 0.5, k2), 0

    return jit(step)


def euler_maruyama(problem: Problem) -> Step:
    """Euler's and Maruyama's method. Only Kubo's equation differs from that of Itô, by the drift −σ² z/2."""
    change, add = rate(problem), plus(problem.dimension)
    rotation = -0.5 * KUBO_SIGMA**2 if problem.name == "kubo" else 0.0

    def step(z, h, dw):
        return add(add(z, 1.0, change(z, h, dw)), h * rotation, z), 0

    return jit(step)


@jit
def oscillator_midpoint(z, h, dw):
    """The midpoint rule, solved by hand."""
    q, p = z
    v = (p + 0.5 * (OSCILLATOR_SIGMA * dw[0] - h * q)) / (1.0 + 0.25 * h * h)
    return (q + h * v, 2.0 * v - p), 0


@jit
def kubo_midpoint(z, h, dw):
    """The midpoint rule, solved by hand: Cayley's form of the rotation by x."""
    q, p = z
    x = KUBO_A * h + KUBO_SIGMA * dw[0]
    r = 0.25 * x * x
    d = 1.0 / (1.0 + r)
    return (((1.0 - r) * q + x * p) * d, ((1.0 - r) * p - x * q) * d), 0


def _pendulum() -> tuple[Callable, Callable]:
    return jit(lambda q, h, dw: -h * GRAVITY * math.sin(q)), jit(lambda q, h, dw: -h * GRAVITY * math.cos(q))


def _synchrotron() -> tuple[Callable, Callable]:
    s1, s2 = SYNCHROTRON_SIGMA

    def impulse(q, h, dw):
        return (s1 * dw[0] - h * SYNCHROTRON_OMEGA**2) * math.sin(q) - s2 * dw[1] * math.cos(q)

    def slope(q, h, dw):
        return (s1 * dw[0] - h * SYNCHROTRON_OMEGA**2) * math.cos(q) + s2 * dw[1] * math.sin(q)

    return jit(impulse), jit(slope)


def _langevin() -> tuple[Callable, Callable]:
    def impulse(q, h, dw):
        return LANGEVIN_SIGMA * dw[0] - h * 4.0 * LANGEVIN_A * q * (q * q - 1.0)

    def slope(q, h, dw):
        return -h * 4.0 * LANGEVIN_A * (3.0 * q * q - 1.0)

    return jit(impulse), jit(slope)


def _henon_heiles() -> tuple[Callable, Callable]:
    def impulse(q, h, dw):
        x, y = q
        return -h * x * (1.0 + 2.0 * y) + HENON_HEILES_SIGMA * dw[0], h * (y * y - y - x * x) + HENON_HEILES_SIGMA * dw[1]

    def slopes(q, h, dw):
        x, y = q
        return -h * (1.0 + 2.0 * y), -h * 2.0 * x, -h * (1.0 - 2.0 * y)

    return jit(impulse), jit(slopes)


def _quiet_henon_heiles() -> tuple[Callable, Callable]:
    def impulse(q, h, dw):
        x, y = q
        return -h * x * (1.0 + 2.0 * y), h * (y * y - y - x * x)

    def slopes(q, h, dw):
        x, y = q
        return -h * (1.0 + 2.0 * y), -h * 2.0 * x, -h * (1.0 - 2.0 * y)

    return jit(impulse), jit(slopes)


def _kepler() -> tuple[Callable, Callable]:
    def impulse(q, h, dw):
        x, y = q
        r2 = x * x + y * y
        w = -h / (r2 * math.sqrt(r2))
        return w * x, w * y

    def slopes(q, h, dw):
        x, y = q
        r2 = x * x + y * y
        w = h / (r2 * math.sqrt(r2))
        u = 3.0 * w / r2
        return u * x * x - w, u * x * y, u * y * y - w

    return jit(impulse), jit(slopes)


def methods(problem: Problem) -> dict[str, Step]:
    """The steps for a problem, by the name of the method."""
    match problem.name:
        case "linear_oscillator":
            push = jit(lambda q, h, dw: OSCILLATOR_SIGMA * dw[0] - h * q)
            chosen = {"midpoint": oscillator_midpoint, "symplectic Euler": symplectic_euler(push, 1)}
        case "kubo":
            chosen = {"midpoint": kubo_midpoint}
        case "double_pendulum":
            chosen = {"midpoint": midpoint_fixed_point_4(problem)}
        case "outer_solar_system":
            chosen = {}
        case "kepler" | "henon_heiles" | "quiet_henon_heiles":
            fields = {"kepler": _kepler, "henon_heiles": _henon_heiles, "quiet_henon_heiles": _quiet_henon_heiles}
            impulse, slopes = fields[problem.name]()
            chosen = {"midpoint": midpoint_newton_2(impulse, slopes), "symplectic Euler": symplectic_euler(impulse, 2)}
        case "langevin":
            impulse, slope = _langevin()
            chosen = {
                "midpoint": midpoint_newton_1(impulse, slope, LANGEVIN_NU),
                "symplectic Euler": symplectic_euler(impulse, 1, LANGEVIN_NU),
            }
        case "pendulum" | "synchrotron":
            impulse, slope = _pendulum() if problem.name == "pendulum" else _synchrotron()
            chosen = {"midpoint": midpoint_newton_1(impulse, slope), "symplectic Euler": symplectic_euler(impulse, 1)}
        case name:
            raise ValueError(f"no steps were written for the problem {name}")
    if problem.processes == 0:
        return chosen | {"Runge–Kutta 4": runge_kutta_4(problem)}
    return chosen | {"Heun": heun(problem), "Euler–Maruyama": euler_maruyama(problem)}


def walks(problem: Problem) -> tuple[Walks, Walks]:
    """One path at a time; and all paths at once, by methods without an iteration."""
    if not problem.steps:
        return [], []
    reference = paths(problem)
    single: Walks = []
    batch: Walks = []
    for name, step in methods(problem).items():
        explicit = name != "midpoint" or step in (oscillator_midpoint, kubo_midpoint)
        for steps in problem.steps:
            h = problem.horizon / steps
            dw = reference.coarse(steps).dw
            ends, iterations = walk(step, problem.start, h, dw, len(dw))
            line = Record(problem.name, name, h, source=SOURCE)
            set_errors(line, problem, ends, reference.ends)
            if iterations:
                line.newton_iterations = iterations / (len(dw) * steps)
            if problem.invariant is not None:
                set_invariant(line, problem, np.linspace(0.0, problem.horizon, steps + 1), record(step, problem.start, h, dw))
            single.append((line, Walk(_one_path(step, problem.start, h, dw), steps)))
            if steps in problem.batch_steps and problem.processes > 0 and problem.dimension == 2 and explicit:
                line = Record(problem.name, name, h, source=SOURCE)
                turned = np.ascontiguousarray(np.moveaxis(dw, 0, 2))
                set_errors(line, problem, together(step, problem.start, h, turned).T, reference.ends)
                batch.append((line, Walk(_all_paths(step, problem.start, h, turned), steps, len(dw))))
    return single, batch


def _one_path(step: Step, start: tuple, h: float, dw: Array) -> Callable[[int], object]:
    path = dw[:1].copy()
    return lambda times: walk(step, start, h, path, times)


def _all_paths(step: Step, start: tuple, h: float, dw: Array) -> Callable[[int], object]:
    def run(times: int) -> None:
        for _ in range(times):
            together(step, start, h, dw)

    return run
