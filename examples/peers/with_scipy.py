"""SciPy: `solve_ivp` with its best explicit method of high order and LSODA. Python calls the field, so it cannot be compiled."""

import numpy as np
import scipy
from scipy.integrate import solve_ivp

from common import DETERMINISTIC, conserved, measure, row, timed

SOURCE = f"scipy {scipy.__version__}"
TOLERANCES = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]


def results(exact):
    for problem in DETERMINISTIC:
        for method in ["DOP853", "LSODA"]:
            for tolerance in TOLERANCES:
                def run(times=None):
                    return solve_ivp(
                        problem.field, (0.0, problem.horizon), problem.start, method,
                        t_eval=times, rtol=tolerance, atol=tolerance,
                    )

                solution = run([problem.horizon])
                line = row(problem.name, method, SOURCE)
                line["error"] = np.linalg.norm(solution.y[:, -1] - exact[problem.name])
                times = np.linspace(0.0, problem.horizon, 1000)
                conserved(line, problem, times, run(times).y)
                steps = len(run().t) - 1
                yield timed(line, *measure(lambda: run([problem.horizon])), steps)
