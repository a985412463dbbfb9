"""scipy: `solve_ivp` with DOP853 on the problems without noise, the equations compiled by numba."""

import math
from collections.abc import Callable
from functools import partial

import scipy
from compiled import as_array, jit
from common import Record, Walk, Walks, set_errors, set_invariant
from problems import Problem
from references import paths
from scipy.integrate import solve_ivp

SOURCE = f"scipy {scipy.__version__}"
TOLERANCES = {
    "DOP853": (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13),
}


def _rate(problem: Problem) -> Callable:
    return as_array(jit(problem.drift(math)), problem.dimension)


def walks(problem: Problem) -> tuple[Walks, Walks]:
    """One path at a time; there is no batch."""
    if problem.processes > 0:
        return [], []
    reference, rate = paths(problem), _rate(problem)
    lines: Walks = []
    for method, tolerances in TOLERANCES.items():
        for tolerance in tolerances:
            solve = partial(solve_ivp, rate, (0.0, problem.horizon), problem.start, method=method, rtol=tolerance, atol=tolerance)
            solution = solve()
            line = Record(problem.name, method, failures=int(not solution.success), source=SOURCE)
            if solution.success:
                set_errors(line, problem, solution.y.T[-1:], reference.ends)
                set_invariant(line, problem, solution.t, solution.y.T[None])
            lines.append((line, Walk(_calls(solve), len(solution.t) - 1)))
    return lines, []


def _calls(solve: Callable[[], object]) -> Callable[[int], object]:
    def run(times: int) -> None:
        for _ in range(times):
            solve()

    return run
