"""What errors are measured against: exact ends, and Brownian paths with the ends that belong to them.

Deterministic problems: extrapolation in 80-bit numbers, which no program under test uses. Problems with noise: the exact solution where there is one,
otherwise steps that are shorter than the finest ones, driven by a parabola in each (Foster, Lyons, Oberhauser 2020): it has the increment and the area of the
Brownian path there. The areas, H = 1/h ∫ (W(s) − W(0) − s/h ΔW) ds over a step, are drawn with the increments, as some solvers take them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from compiled import jit, plus, rate
from problems import KUBO_A, KUBO_SIGMA, OSCILLATOR_SIGMA, Problem

SEED = 42
FINER = 8
"""Steps of a reference in one of the finest steps."""

Array = np.ndarray


@dataclass(frozen=True)
class Paths:
    """Brownian paths over equal steps, and exact ends. A problem without noise has one path and no processes."""

    dw: Array
    """Increments, shape (paths, steps, processes)."""
    area: Array
    """Space-time Lévy areas H, the same shape."""
    ends: Array
    """States at the horizon, shape (paths, 2N)."""

    def coarse(self, steps: int) -> tuple[Array, Array]:
        """Increments and areas of the same paths over fewer steps."""
        return coarsen(self.dw, self.area, self.dw.shape[1] // steps)


def coarsen(dw: Array, area: Array, factor: int) -> tuple[Array, Array]:
    """Increments and areas over `factor` steps at once, by Chen's relation; shapes (paths, steps, processes)."""
    paths, steps, processes = dw.shape
    shape = (paths, steps // factor, factor, processes)
    parts = dw.reshape(shape)
    whole = parts.sum(axis=2)
    # mean of W − W(0) over each part: where it begins, half its increment, its own area
    means = np.cumsum(parts, axis=2) - 0.5 * parts + area.reshape(shape)
    return whole, means.mean(axis=2) - 0.5 * whole


@cache
def paths(problem: Problem) -> Paths:
    """The paths of a problem with `problem.steps[-1]` steps; the same at each call."""
    if problem.processes == 0:
        none = np.zeros((1, problem.steps[-1], 0))
        return Paths(none, none, deterministic_end(problem)[None, :])
    if problem.name == "linear_oscillator":
        return _oscillator(problem)
    if problem.name == "kubo":
        dw, area = _draw(problem, problem.paths, problem.steps[-1], np.random.default_rng(SEED))
        angle = KUBO_A * problem.horizon + KUBO_SIGMA * dw.sum(axis=(1, 2))
        return Paths(dw, area, np.stack([np.cos(angle), -np.sin(angle)], axis=1))
    return by_parabolas(problem, FINER)


def _draw(problem: Problem, paths: int, steps: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Increments and areas: independent, of variance h and h/12."""
    h = problem.horizon / steps
    shape = (paths, steps, problem.processes)
    return math.sqrt(h) * rng.standard_normal(shape), math.sqrt(h / 12.0) * rng.standard_normal(shape)


def _oscillator(problem: Problem) -> Paths:
    """The exact solution: a rotation by h plus σ ∫ (sin(h−s), cos(h−s)) dW, drawn jointly with the increment by Cholesky's factor of the covariance.

    The area is that of the first two normals; what it has of others is of the size of h⁴ of it.
    """
    steps = problem.steps[-1]
    h = problem.horizon / steps
    sin, cos, w = math.sin(h), math.cos(h), math.sqrt(h)
    # 1 − cos h = 2 sin²(h/2), as the difference would cancel
    xw, yw = 2.0 * math.sin(0.5 * h) ** 2 / w, sin / w
    x = math.sqrt(0.5 * (h - sin * cos) - xw * xw)
    yx = (0.5 * sin * sin - xw * yw) / x
    y = math.sqrt(max(0.0, 0.5 * (h + sin * cos) - yw * yw - yx * yx))
    # covariance of ∫ (h−s) dW with the first integral is sin h − h cos h
    a = (sin - h * cos - 0.5 * h * w * xw) / x
    z = np.random.default_rng(SEED).standard_normal((3, problem.paths, steps))
    q, p = (np.full(problem.paths, component) for component in problem.start)
    for z0, z1, z2 in zip(*(part.T for part in z), strict=True):
        q, p = (
            cos * q + sin * p + OSCILLATOR_SIGMA * (xw * z0 + x * z1),
            cos * p - sin * q + OSCILLATOR_SIGMA * (yw * z0 + yx * z1 + y * z2),
        )
    return Paths(w * z[0][:, :, None], a / h * z[1][:, :, None], np.stack([q, p], axis=1))


def by_parabolas(problem: Problem, finer: int) -> Paths:
    """Paths whose ends are those of steps `finer` times shorter."""
    steps = problem.steps[-1] * finer
    walk = along_parabolas(problem)
    dw, area, ends = [], [], []
    for path in range(problem.paths):
        # a path at a time, as the fine ones would fill the memory
        fine = _draw(problem, 1, steps, np.random.default_rng([SEED, path]))
        ends.append(walk(problem.start, problem.horizon / steps, fine[0][0], fine[1][0]))
        coarse = coarsen(*fine, finer)
        dw.append(coarse[0])
        area.append(coarse[1])
    return Paths(np.concatenate(dw), np.concatenate(area), np.array(ends))


def along_parabolas(problem: Problem) -> Callable:
    """A compiled function of start, h, increments and areas (steps, M) that returns the end: in each step one of Runge and Kutta's along the parabola."""
    change, add = rate(problem), plus(problem.dimension)

    @jit
    def walk(start, h, dw, area):
        z = start
        for n in range(dw.shape[0]):
            # the parabola u ΔW + 6 u (1 − u) H has the derivative ΔW + 6 (1 − 2 u) H
            first, last = dw[n] + 6.0 * area[n], dw[n] - 6.0 * area[n]
            k1 = change(z, h, first)
            k2 = change(add(z, 0.5, k1), h, dw[n])
            k3 = change(add(z, 0.5, k2), h, dw[n])
            k4 = change(add(z, 1.0, k3), h, last)
            z = add(add(z, 1.0 / 6.0, add(k1, 2.0, k2)), 1.0 / 6.0, add(k4, 2.0, k3))
        return z

    return walk


def deterministic_end(problem: Problem) -> Array:
    """The state at the horizon, shape (2N,), by Gragg's method with extrapolation to order 16 in 80-bit numbers."""
    if problem.extrapolations == 0:
        return np.array(problem.start)
    drift = problem.drift(np)
    numbers = range(2, 18, 2)
    z = np.array(problem.start, dtype=np.longdouble)

    def rate(z: Array) -> Array:
        return np.array(drift(tuple(z)), dtype=np.longdouble)

    def midpoints(z: Array, length: np.longdouble, number: int) -> Array:
        h = length / number
        before, now = z, z + h * rate(z)
        for _ in range(number - 1):
            before, now = now, before + 2 * h * rate(now)
        return (before + now + h * rate(now)) / 2

    length = np.longdouble(problem.horizon) / problem.extrapolations
    for _ in range(problem.extrapolations):
        table: list[Array] = []
        for i, number in enumerate(numbers):
            new = [midpoints(z, length, number)]
            for j in range(i):
                ratio = np.longdouble(number) / numbers[i - j - 1]
                new.append(new[j] + (new[j] - table[j]) / (ratio * ratio - 1))
            table = new
        z = table[-1]
    return z.astype(np.float64)
