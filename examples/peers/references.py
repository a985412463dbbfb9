"""What errors are measured against: exact ends, and Brownian paths with the ends that belong to them.

Deterministic problems: extrapolation in numbers of 113 bits, which no program under test uses; Kepler's by his equation. Problems with noise: the exact solution where there is one,
otherwise steps that are shorter than the finest ones, driven by a cubic polynomial in each (Foster, Lyons, Oberhauser 2020): it has the increment and the areas of
the Brownian path there. The areas of a step, with u from 0 to 1 and the bridge B(u) = W(uh) − W(0) − u ΔW, are H = ∫ B(u) du and K = ∫ (½ − u) B(u) du.
With the Legendre polynomials Pₖ(2u − 1) they are −½ ∫ P₁ dW and 1/12 ∫ P₂ dW. Solvers of stochastic equations take them in this form, and they are drawn with the increments.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from compiled import jit, plus, rate
from problems import KUBO_A, KUBO_SIGMA, OSCILLATOR_SIGMA, Problem
from heyoka import real128
from scipy.integrate import DOP853

SEED = 42
FINER = 8
"""Steps of a reference in one of the finest steps."""

SETTLED = 1e-20
"""Difference of the two highest orders of an extrapolation, over the largest component of the state, above which the extrapolation is repeated for half of the time."""

LEGENDRE = 6
"""Legendre coefficients of the noise in a step of the linear oscillator. The first that is left out is of the size of h⁶ in the impulse, 1e-15 of the noise for the longest of the finest steps."""

Array = np.ndarray


@dataclass(frozen=True)
class Noise:
    """Increments and areas of Brownian paths over equal steps, each of shape (paths, steps, processes)."""

    dw: Array
    """Increments."""
    area: Array
    """Space-time Lévy areas H."""
    third: Array
    """Space-time-time Lévy areas K."""

    def coarse(self, steps: int) -> "Noise":
        """Returns increments and areas of the same paths over fewer steps.

        A step is cut into n parts. With y in [−1, 1] in part i, 2u − 1 = m + y/n, where m = (2i + 1)/n − 1. The Legendre polynomials of the step are therefore
        P₁ = m + P₁(y)/n and P₂ = (3m² − 1 + 1/n²)/2 + 3m/n P₁(y) + P₂(y)/n², and the integrals of the parts add up.
        """
        paths, fine, processes = self.dw.shape
        n = fine // steps
        m = ((2.0 * np.arange(n) + 1.0) / n - 1.0)[:, None]
        dw, area, third = (parts.reshape(paths, steps, n, processes) for parts in (self.dw, self.area, self.third))
        return Noise(
            dw.sum(axis=2),
            (area / n - 0.5 * m * dw).sum(axis=2),
            ((3.0 * m * m - 1.0 + 1.0 / n**2) / 24.0 * dw - 0.5 * m / n * area + third / n**2).sum(axis=2),
        )


@dataclass(frozen=True)
class Paths:
    """Brownian paths and exact ends. A problem without noise has one path and no processes."""

    noise: Noise
    ends: Array
    """States at the horizon, shape (paths, 2N)."""

    def coarse(self, steps: int) -> Noise:
        """Returns increments and areas of the same paths over fewer steps."""
        return self.noise.coarse(steps)


@cache
def paths(problem: Problem) -> Paths:
    """The paths of a problem with `problem.finest` steps; the same at each call."""
    if problem.processes == 0:
        none = np.zeros((1, problem.finest, 0))
        return Paths(Noise(none, none, none), deterministic_end(problem)[None, :])
    if problem.name == "linear_oscillator":
        return _oscillator(problem)
    if problem.name == "kubo":
        noise = draw(problem.horizon, problem.paths, problem.finest, problem.processes, np.random.default_rng(SEED))
        angle = KUBO_A * problem.horizon + KUBO_SIGMA * noise.dw.sum(axis=(1, 2))
        return Paths(noise, np.stack([np.cos(angle), -np.sin(angle)], axis=1))
    return by_cubics(problem, FINER)


def draw(horizon: float, paths: int, steps: int, processes: int, rng: np.random.Generator) -> Noise:
    """Draws increments and areas: independent, of variance h, h/12 and h/720."""
    h = horizon / steps
    dw, area, third = (math.sqrt(h / part) * rng.standard_normal((paths, steps, processes)) for part in (1.0, 12.0, 720.0))
    return Noise(dw, area, third)


def _oscillator(problem: Problem) -> Paths:
    """The exact solution: a rotation by h plus σ ∫ (sin(h−s), cos(h−s)) dW.

    The noise of a step is drawn by its coefficients ξₖ = √((2k + 1)/h) ∫ Pₖ dW, which are independent normals, and the integrals are sums over them.
    """
    steps = problem.finest
    h = problem.horizon / steps
    nodes, weights = np.polynomial.legendre.leggauss(16)
    basis = np.sqrt(2.0 * np.arange(LEGENDRE) + 1.0) * np.polynomial.legendre.legvander(nodes, LEGENDRE - 1)
    remaining = 0.5 * h * (1.0 - nodes)
    in_q, in_p = (OSCILLATOR_SIGMA * math.sqrt(h) * 0.5 * (weights * f(remaining)) @ basis for f in (np.sin, np.cos))
    sin, cos = math.sin(h), math.cos(h)
    xi = np.random.default_rng(SEED).standard_normal((LEGENDRE, problem.paths, steps))
    q, p = (np.full(problem.paths, component) for component in problem.start)
    for n in range(steps):
        q, p = cos * q + sin * p + in_q @ xi[:, :, n], cos * p - sin * q + in_p @ xi[:, :, n]
    dw, area, third = (math.sqrt(h) * factor * xi[k][:, :, None] for k, factor in enumerate((1.0, -math.sqrt(1.0 / 12.0), math.sqrt(1.0 / 720.0))))
    return Paths(Noise(dw, area, third), np.stack([q, p], axis=1))


def by_cubics(problem: Problem, finer: int) -> Paths:
    """Paths whose ends are those of steps `finer` times shorter."""
    steps = problem.finest * finer
    walk = along_cubics(problem)
    coarse, ends = [], []
    for path in range(problem.paths):
        # a path at a time, as the fine ones would fill the memory
        fine = draw(problem.horizon, 1, steps, problem.processes, np.random.default_rng([SEED, path]))
        ends.append(walk(problem.start, problem.horizon / steps, fine.dw[0], fine.area[0], fine.third[0]))
        coarse.append(fine.coarse(problem.finest))
    dw, area, third = (np.concatenate([getattr(noise, name) for noise in coarse]) for name in ("dw", "area", "third"))
    return Paths(Noise(dw, area, third), np.array(ends))


def along_cubics(problem: Problem) -> Callable:
    """A compiled function of start, h, increments and areas H and K (steps, M) that returns the end.

    In each step W is the cubic polynomial with these integrals, and the ordinary differential equation along it is solved by a step of Dormand and Prince's method of order 8.
    A method of order 4 would not do: its weight of ∫∫∫ P₂, by which K enters a position, is wrong.
    """
    change, add = rate(problem), plus(problem.dimension)
    a, b, c = DOP853.A[: DOP853.n_stages, : DOP853.n_stages], DOP853.B, DOP853.C[: DOP853.n_stages]
    stages, zero = DOP853.n_stages, (0.0,) * problem.dimension

    @jit
    def walk(start, h, dw, area, third):
        z = start
        rates = [zero] * stages
        for n in range(dw.shape[0]):
            for i in range(stages):
                y = 2.0 * c[i] - 1.0
                stage = z
                for j in range(i):
                    stage = add(stage, a[i, j], rates[j])
                rates[i] = change(stage, h, dw[n] - 6.0 * y * area[n] + 30.0 * (3.0 * y * y - 1.0) * third[n])
            for i in range(stages):
                z = add(z, b[i], rates[i])
        return z

    return walk


def deterministic_end(problem: Problem) -> Array:
    """The state at the horizon, shape (2N,), by Gragg's method with extrapolation to order 16 in 113-bit numbers."""
    if problem.extrapolations == 0:
        return kepler_end(problem)
    drift = problem.drift(np)

    def rate(z: Array) -> Array:
        return np.array(drift(tuple(z)), dtype=real128)

    z, t = np.array(problem.start, dtype=real128), real128(0.0)
    longest = real128(problem.horizon) / problem.extrapolations
    length = longest
    while t < problem.horizon:
        length = min(length, problem.horizon - t)
        before, best = extrapolated(rate, z, length)
        difference = np.abs(best - before).max() / np.abs(best).max()
        if difference > SETTLED:
            length /= 2
            continue
        z, t = best, t + length
        if difference < SETTLED / 2**16:
            length = min(2 * length, longest)
    return z.astype(np.float64)


def kepler_end(problem: Problem) -> Array:
    """The state at the horizon of a planet that starts at the perihelion (x, 0) with the momentum (0, p), by Kepler's equation in 113-bit numbers.

    The start is rounded, so it is not reached again to rounding after whole periods of 2π: a planet of eccentricity 0.99 is 1e-10 away from it after a hundred.
    """
    x, _, _, p = np.array(problem.start, dtype=real128)
    axis = 1 / (2 / x - p * p)
    eccentricity, rate = 1 - x / axis, 1 / (axis * np.sqrt(axis))
    anomaly = real128(problem.horizon) * rate
    # to the nearest perihelion
    turn = 8 * np.arctan(real128(1.0))
    anomaly -= turn * round(float(anomaly / turn))
    angle = anomaly
    for _ in range(100):
        angle -= (angle - eccentricity * np.sin(angle) - anomaly) / (1 - eccentricity * np.cos(angle))
    cos, sin, root = np.cos(angle), np.sin(angle), np.sqrt(1 - eccentricity * eccentricity)
    speed = axis * rate / (1 - eccentricity * cos)
    return np.array([axis * (cos - eccentricity), axis * root * sin, -speed * sin, speed * root * cos]).astype(np.float64)


def extrapolated(rate: Callable[[Array], Array], z: Array, length: real128) -> tuple[Array, Array]:
    """The state after a time, by the orders 14 and 16."""

    def midpoints(number: int) -> Array:
        h = length / number
        before, now = z, z + h * rate(z)
        for _ in range(number - 1):
            before, now = now, before + 2 * h * rate(now)
        return (before + now + h * rate(now)) / 2

    numbers = range(2, 18, 2)
    table: list[Array] = []
    for i, number in enumerate(numbers):
        new = [midpoints(number)]
        for j in range(i):
            ratio = real128(number) / numbers[i - j - 1]
            new.append(new[j] + (new[j] - table[j]) / (ratio * ratio - 1))
        table = new
    return table[-2], table[-1]
