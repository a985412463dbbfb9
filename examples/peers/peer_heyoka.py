"""heyoka: Taylor series of an order and with steps that the tolerance asks for, on the problems without noise.

One path at a time, and in batches as wide as the machine's vectors.
"""

from collections.abc import Callable

import heyoka
import numpy as np
from common import Record, Walk, set_errors, set_invariant, set_times
from problems import Problem
from references import paths

SOURCE = f"heyoka {heyoka.__version__}"
METHOD = "Taylor"
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13, 1e-16)


def _equations(problem: Problem) -> list:
    names = [f"z{i}" for i in range(problem.dimension)]
    variables = tuple(heyoka.make_vars(*names))
    return list(zip(variables, problem.drift(heyoka)(variables), strict=True))


def records(problem: Problem) -> tuple[list[Record], list[Record]]:
    """One path at a time, and a batch of equal ones."""
    if problem.processes > 0:
        return [], []
    reference, equations = paths(problem), _equations(problem)
    lanes = heyoka.recommended_simd_size()
    single, batch = [], []
    for tolerance in TOLERANCES:
        one = heyoka.taylor_adaptive(equations, list(problem.start), tol=tolerance)
        states = np.repeat(np.array(problem.start)[:, None], lanes, axis=1)
        many = heyoka.taylor_adaptive_batch(equations, states.copy(), tol=tolerance)
        for lines, integrator, start in ((single, one, np.array(problem.start)), (batch, many, states)):
            times, path = _record(integrator, start, problem.horizon)
            line = Record(problem.name, METHOD, source=SOURCE)
            set_errors(line, problem, path[-1:], reference.ends)
            set_invariant(line, problem, times, path[None])
            width = 1 if lines is single else lanes
            lines.append((line, Walk(_calls(integrator, start, problem.horizon), len(times) - 1, width)))
    set_times(single)
    set_times(batch)
    return [line for line, _ in single], [line for line, _ in batch]


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
