"""Checks that what the programs are compared with is right, and that their steps are those of the methods. Exits with status 1 where one is not.

Takes some three minutes and measures no times. Where the example's own results lie in `target/work-precision`, it compares with them as well.
"""

import csv
import math
import sys
from pathlib import Path

import heyoka
import numpy as np
import peer_diffrax
from common import Record, set_errors
from peer_numba import methods, walk
from problems import OSCILLATOR_SIGMA, PROBLEMS, Problem
from references import Noise, along_cubics, draw, paths
from scipy.integrate import solve_ivp
from uneven import UNEVEN

RESULTS = Path(__file__).resolve().parents[2] / "target" / "work-precision"
"""Where the example writes."""
SAME = {name: name for name in ("midpoint", "Heun", "Euler–Maruyama", "Runge–Kutta 4")} | {"initial point": "symplectic Euler"}
"""Names here of the example's methods."""
LARGEST = 0.3
"""Larger errors are not compared: they are as large as the solution, and have heavy tails."""
EQUAL, ROUNDING = 0.02, 2e-10
"""How far errors may be apart without noise: the example's reference is a fine step, and rounding errors differ."""
SIGMAS = 4.5
"""Statistical bounds, in standard errors; there are some hundred comparisons."""

BY_NAME = {problem.name: problem for problem in PROBLEMS}
BOUNDS = {"pendulum": (2e-7, 3e-10), "double_pendulum": (2e-8, 2e-9), "kepler": (3e-5, 2e-9), "quiet_henon_heiles": (1e-9, 1e-12)}
"""Distances of the ends of scipy and of heyoka, at their least tolerances: rounding grows with the time, and in the double pendulum by its chaos."""
NUMBERS = {"midpoint": 2.0, "symplectic Euler": 1.0, "Runge–Kutta 4": 4.0}
"""Orders without noise."""
UNUSUAL = {
    # noise that depends on the momentum
    ("kubo", "Euler–Maruyama"): 0.5,
    # the energy that is lost is of the fifth order, and shifts the phase ever faster
    ("pendulum", "Runge–Kutta 4"): 5.0,
    ("quiet_henon_heiles", "Runge–Kutta 4"): 4.4,
    ("outer_solar_system", "Runge–Kutta 4"): 5.0,
}
WITH_AREAS = {"SPaRK": (2.0, 0.05), "ShARK": (2.0, 0.05), "ALIGN": (2.0, 0.05), "ShOULD": (3.0, 0.1), "QUICSORT": (3.0, 0.1)}
"""Strong orders of diffrax's methods that know areas, for additive noise, and how far a measured order may be from them.

SPaRK and ShARK have order 1.5 for any additive noise. Here the noise enters the momentum alone and the force depends on the position alone: the local error of
size h², σ² ∂²f ∫ W² ds, vanishes. The next ones have size h^{5/2} and mean zero, and leave order 2. ShOULD and QUICSORT have order 3 by theory for forces with bounded derivatives;
the double well has none, and shows the same order.
"""
ALONG_CUBICS = {"linear_oscillator": 1e-10, "kubo": 1e-4, "henon_heiles": 3e-11, "langevin": 3e-10}
"""Distances of the exact ends from those along cubic polynomials over the finest steps. With additive noise errors have order 3. For Kubo's noise
they are those of a step of order 8 along the polynomial, where powers of the noise above the second are not exact.
"""
ORDER = 0.3
"""How far a measured order may be from the true one, on few paths with few steps."""


def ends() -> dict[str, tuple[float, float]]:
    """Exact ends without noise, against other programs at their least tolerances: distance and bound."""
    found = {}
    for name, (bound, least) in BOUNDS.items():
        problem = BY_NAME[name]
        end, drift = paths(problem).ends[0], problem.drift(np)
        other = solve_ivp(lambda t, z, drift=drift: drift(z), (0.0, problem.horizon), problem.start, method="DOP853", rtol=1e-13, atol=1e-13)
        # of scipy's own error, seen when it is compared with itself at 1e-12
        found[f"{name}: scipy at 1e-13"] = (np.linalg.norm(other.y[:, -1] - end), bound)
        variables = tuple(heyoka.make_vars(*(f"z{i}" for i in range(problem.dimension))))
        series = heyoka.taylor_adaptive(list(zip(variables, problem.drift(heyoka)(variables), strict=True)), list(problem.start), tol=1e-16)
        series.propagate_until(problem.horizon)
        found[f"{name}: heyoka at 1e-16"] = (np.linalg.norm(series.state - end), least)
        energy = problem.invariant(np)
        found[f"{name}: energy at the end"] = (abs(energy(tuple(end)) - energy(problem.start)), 1e-13 * abs(energy(problem.start)) + 1e-13)
    start = np.array(BY_NAME["kepler"].start)
    # the start is rounded, and so is its period
    found["kepler: return to the start"] = (np.linalg.norm(paths(BY_NAME["kepler"]).ends[0] - start), 1e-11)
    return found


def in_113_bits() -> dict[str, tuple[float, float]]:
    """Exact ends of the uneven motions, against Taylor series in numbers of 113 bits."""
    found = {}
    for problem in UNEVEN:
        variables = tuple(heyoka.make_vars(*(f"z{i}" for i in range(problem.dimension))))
        equations = list(zip(variables, problem.drift(heyoka)(variables), strict=True))
        start = [heyoka.real128(value) for value in problem.start]
        series = heyoka.taylor_adaptive(equations, start, tol=heyoka.real128("1e-30"), fp_type=heyoka.real128)
        series.propagate_until(heyoka.real128(problem.horizon))
        end = np.array([float(value) for value in series.state])
        difference = (end - paths(problem).ends[0])[: problem.compared]
        found[f"{problem.name}: Taylor series in 113 bits"] = (np.linalg.norm(difference), 2e-12)
    return found


def moments() -> dict[str, tuple[float, float]]:
    """Mean and covariance of the oscillator at the horizon against the exact ones, in standard errors."""
    problem = BY_NAME["linear_oscillator"]
    z, t = paths(problem).ends, problem.horizon
    s, c = math.sin(t), math.cos(t)
    mean = np.array([c, -s])
    variance = OSCILLATOR_SIGMA**2 / 2.0 * np.array([t - s * c, t + s * c, s * s])
    deviations = z - mean
    samples = {"q²": deviations[:, 0] ** 2, "p²": deviations[:, 1] ** 2, "qp": deviations[:, 0] * deviations[:, 1]}
    count = math.sqrt(len(z))
    found = {}
    for name, values, exact in zip("qp", deviations.T, (0.0, 0.0), strict=True):
        found[f"oscillator: mean of {name}"] = (abs(values.mean() - exact) / (values.std() / count), SIGMAS)
    for (name, values), exact in zip(samples.items(), variance, strict=True):
        found[f"oscillator: mean of {name}, centred"] = (abs(values.mean() - exact) / (values.std() / count), SIGMAS)
    return found


def areas() -> dict[str, tuple[float, float]]:
    """Steps along cubic polynomials reach the exact ends only if increments and areas belong to them; and the areas of coarse steps."""
    found = {}
    for name, bound in ALONG_CUBICS.items():
        problem, reference = BY_NAME[name], paths(BY_NAME[name])
        h, noise = problem.horizon / problem.finest, reference.noise
        step = along_cubics(problem)
        reached = [step(problem.start, h, noise.dw[path], noise.area[path], noise.third[path]) for path in range(100)]
        found[f"{name}: along cubics"] = (np.sqrt(((np.array(reached) - reference.ends[:100]) ** 2).sum(axis=1).mean()), bound)
    return found | _coarse_polynomials() | _coarse_law()


def _coarse_polynomials() -> dict[str, tuple[float, float]]:
    """Areas of long steps from those of their parts, for a path that is a polynomial of degree 5, with areas by Gauss quadrature."""
    path = np.polynomial.Polynomial([0.3, -1.0, 2.0, 0.7, -1.5, 0.4])
    nodes, weights = np.polynomial.legendre.leggauss(8)
    u = 0.5 * (nodes + 1.0)

    def exact(steps: int) -> Noise:
        h = 1.0 / steps
        starts = h * np.arange(steps)[:, None]
        dw = path(starts + h) - path(starts)
        bridge = path(starts + h * u) - path(starts) - u * dw
        columns = dw[:, 0], 0.5 * bridge @ weights, 0.5 * (bridge * (0.5 - u)) @ weights
        return Noise(*(column[None, :, None] for column in columns))

    found = {}
    for parts in (2, 3, 8):
        summed, whole = exact(4 * parts).coarse(4), exact(4)
        for what in ("dw", "area", "third"):
            distance = np.abs(getattr(summed, what) - getattr(whole, what)).max()
            found[f"coarse steps of {parts} parts of a polynomial: {what}"] = (distance, 1e-14)
    return found


def _coarse_law() -> dict[str, tuple[float, float]]:
    """Variances and independence of coarse increments and areas, in standard errors."""
    n, fine = 20_000, 8
    noise = draw(float(fine), n, fine, 1, np.random.default_rng(7)).coarse(1)
    found = {}
    for what, values, exact in (
        ("of ΔW", noise.dw**2, float(fine)),
        ("of H", noise.area**2, fine / 12.0),
        ("of K", noise.third**2, fine / 720.0),
        ("of ΔW and H", noise.dw * noise.area, 0.0),
        ("of ΔW and K", noise.dw * noise.third, 0.0),
        ("of H and K", noise.area * noise.third, 0.0),
    ):
        found[f"coarse steps: covariance {what}"] = (abs(values.mean() - exact) / (values.std() / math.sqrt(n)), SIGMAS)
    return found


def orders() -> dict[str, tuple[float, float]]:
    """Measured orders of the steps written by hand: those without noise, and mostly 1 with noise, as all of it commutes."""
    found = {}
    for problem in PROBLEMS:
        for name, step in methods(problem).items():
            if (problem.name, name) == ("langevin", "Euler–Maruyama"):
                # with these steps its errors are as large as the solution, and have no order
                continue
            usual = 1.0 if problem.processes > 0 else NUMBERS[name]
            expected = UNUSUAL.get((problem.name, name), usual)
            if name == "midpoint":
                found |= _iterations(problem, step)
            coarse, fine = (_error(problem, step, steps) for steps in problem.steps[-3::2])
            if problem.processes == 0 and coarse > LARGEST:
                # the phase is lost
                continue
            measured = math.log(coarse / fine) / math.log(problem.steps[-1] / problem.steps[-3])
            found[f"{problem.name}: order of {name}, {measured:.2f}"] = (abs(measured - expected), ORDER)
    return found


def orders_with_areas() -> dict[str, tuple[float, float]]:
    """Measured strong orders of diffrax's methods that know areas, for additive noise."""
    found = {}
    for problem in PROBLEMS:
        if not problem.additive:
            continue
        exact = paths(problem).ends
        for name, method in peer_diffrax.methods(problem).items():
            if name in WITH_AREAS:
                expected, bound = WITH_AREAS[name]
                counts = problem.steps[-3::2]
                coarse, fine = (np.sqrt(((peer_diffrax.all_ends(problem, method, n) - exact) ** 2).sum(axis=1).mean()) for n in counts)
                measured = math.log(coarse / fine) / math.log(counts[1] / counts[0])
                found[f"{problem.name}: order of {name} of diffrax, {measured:.3f}"] = (abs(measured - expected), bound)
    return found


def _iterations(problem: Problem, step) -> dict[str, tuple[float, float]]:
    """Newton's method with the right derivative needs few iterations, even for the longest steps."""
    steps = problem.steps[0]
    dw = paths(problem).coarse(steps).dw
    _, iterations = walk(step, problem.start, problem.horizon / steps, dw, len(dw))
    fixed_point = problem.name == "double_pendulum"
    return {} if fixed_point else {f"{problem.name}: iterations": (iterations / (len(dw) * steps), 5.0)}


def against_sve() -> dict[str, tuple[float, float]]:
    """Errors of the same methods with the same steps as the example found them: equal without noise, else within their standard errors."""
    found = {}
    for problem in PROBLEMS:
        file = RESULTS / f"{problem.name}.csv"
        if not file.exists():
            print(f"{file} is missing: not compared; the example `work_precision` writes it")
            continue
        chosen = methods(problem)
        with file.open(encoding="utf-8") as lines:
            for line in csv.DictReader(lines):
                method = SAME.get(line["method"])
                if method in chosen and line["error"] and float(line["error"]) < LARGEST:
                    steps = round(problem.horizon / float(line["h"]))
                    mine = Record(problem.name, method)
                    dw = paths(problem).coarse(steps).dw
                    reached, _ = walk(chosen[method], problem.start, problem.horizon / steps, dw, len(dw))
                    set_errors(mine, problem, reached, paths(problem).ends)
                    theirs = float(line["error"])
                    spread = math.hypot(mine.error_se, float(line["error_se"])) if problem.processes > 0 else EQUAL * theirs + ROUNDING
                    found[f"{problem.name}: {method}, {steps} steps, {mine.error:.4e} and {theirs:.4e}, in spreads"] = (
                        abs(mine.error - theirs) / spread,
                        SIGMAS if problem.processes > 0 else 1.0,
                    )
    return found


def _error(problem: Problem, step, steps: int) -> float:
    reference = paths(problem)
    dw = reference.coarse(steps).dw
    reached, _ = walk(step, problem.start, problem.horizon / steps, dw, len(dw))
    return float(np.sqrt(((reached - reference.ends) ** 2).sum(axis=1).mean()))


def main() -> None:
    """Runs all checks and prints them."""
    failed = 0
    for check in (ends, in_113_bits, moments, areas, orders, orders_with_areas, against_sve):
        for name, (value, bound) in check().items():
            # not a number is a failure too
            good = value <= bound
            failed += not good
            print(f"{'' if good else 'FAILED: '}{name}: {value:.2e}, at most {bound:.0e}")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
