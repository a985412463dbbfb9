"""heyoka: Taylor series of an order and with steps that the tolerance asks for, on the problems without noise.

One path at a time, and in batches as wide as the machine's vectors.
"""

from collections.abc import Callable

import heyoka
import numpy as np
import planets
from common import Record, Walk, Walks, set_errors, set_invariant
from problems import Problem
from references import paths

SOURCE = f"heyoka {heyoka.__version__}"
METHOD = "Taylor"
COMPENSATED = "Taylor, compensated"
"""With compensated sums, heyoka's option `high_accuracy`."""
ORDERS = {METHOD: range(5, 23), COMPENSATED: range(12, 23)}
"""heyoka takes the order n from its tolerance, and the length of a step from the order: for n it takes every tolerance between e^(2 − 2n) and e^(4 − 2n)."""


def _equations(problem: Problem) -> tuple[list, np.ndarray, np.ndarray]:
    """The equations, where in their state each component of (q, p) is, and the factor that it has there: of the solar system heyoka has its own, of velocities."""
    if problem.name == "outer_solar_system":
        equations = heyoka.model.nbody(len(planets.MASSES), masses=list(planets.MASSES), Gconst=planets.GRAVITY)
        bodies = 6 * np.repeat(np.arange(len(planets.MASSES)), 3)
        axes = np.tile(np.arange(3), len(planets.MASSES))
        masses = np.repeat(planets.MASSES, 3)
        return equations, np.concatenate([bodies + axes, bodies + axes + 3]), np.concatenate([np.ones_like(masses), 1.0 / masses])
    names = [f"z{i}" for i in range(problem.dimension)]
    variables = tuple(heyoka.make_vars(*names))
    equations = list(zip(variables, problem.drift(heyoka)(variables), strict=True))
    return equations, np.arange(problem.dimension), np.ones(problem.dimension)


def walks(problem: Problem) -> tuple[Walks, Walks]:
    """One path at a time, and a batch of equal ones."""
    if problem.processes > 0:
        return [], []
    reference, (equations, places, factors) = paths(problem), _equations(problem)
    own = np.empty(problem.dimension)
    own[places] = np.array(problem.start) * factors
    lanes = heyoka.recommended_simd_size()
    single: Walks = []
    batch: Walks = []
    for method, orders in ORDERS.items():
        for order in orders:
            options = {"tol": float(np.exp(3.0 - 2.0 * order)), "high_accuracy": method == COMPENSATED}
            one = heyoka.taylor_adaptive(equations, own.copy(), **options)
            kinds = [(single, one, own)]
            if method == METHOD and problem.dimension <= 4:
                states = np.repeat(own[:, None], lanes, axis=1)
                kinds.append((batch, heyoka.taylor_adaptive_batch(equations, states.copy(), **options), states))
            for lines, integrator, start in kinds:
                times, path = _record(integrator, start, problem.horizon)
                path = path[:, places] / factors
                line = Record(problem.name, method, source=SOURCE)
                set_errors(line, problem, path[-1:], reference.ends)
                set_invariant(line, problem, times, path[None])
                width = 1 if lines is single else lanes
                lines.append((line, Walk(_calls(integrator, start, problem.horizon), len(times) - 1, width)))
    return single, batch


def _restart(integrator, start: np.ndarray) -> None:
    if start.ndim == 1:
        integrator.time = 0.0
    else:
        integrator.set_time(0.0)
    integrator.state[:] = start


def _record(integrator, start: np.ndarray, horizon: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (steps + 1,) and states (steps + 1, 2N); of a batch, those of its first lane."""
    _restart(integrator, start)
    times, states = [0.0], [start.reshape(len(start), -1)[:, 0].copy()]

    def note(at) -> bool:
        times.append(float(np.atleast_1d(at.time)[0]))
        states.append(at.state.reshape(len(start), -1)[:, 0].copy())
        return True

    integrator.propagate_until(horizon, callback=note)
    return np.array(times), np.array(states)


def _calls(integrator, start: np.ndarray, horizon: float) -> Callable[[int], object]:
    def run(times: int) -> None:
        for _ in range(times):
            _restart(integrator, start)
            integrator.propagate_until(horizon)

    return run
