"""heyoka: adaptive Taylor series, compiled just in time; single paths, and batches of as many as the processor's vectors hold."""

import heyoka as hy
import numpy as np

from common import DETERMINISTIC, DOUBLE, KEPLER, PENDULUM, conserved, measure, row, timed

SOURCE = f"heyoka {hy.__version__}"
TOLERANCES = [1e-3, 1e-6, 1e-9, 1e-12, 1e-15]


def system(problem):
    if problem is PENDULUM:
        q, p = hy.make_vars("q", "p")
        return [(q, p), (p, -9.8 * hy.sin(q))]
    if problem is KEPLER:
        x, y, u, v = hy.make_vars("x", "y", "u", "v")
        r3 = (x * x + y * y) ** -1.5
        return [(x, u), (y, v), (u, -x * r3), (v, -y * r3)]
    assert problem is DOUBLE
    a, b, k, l = hy.make_vars("a", "b", "k", "l")
    c = hy.cos(a - b)
    det = 2.0 - c * c
    v0, v1 = (k - c * l) / det, (2.0 * l - c * k) / det
    turn = v0 * v1 * hy.sin(a - b)
    return [(a, v0), (b, v1), (k, -turn - 19.6 * hy.sin(a)), (l, turn - 9.8 * hy.sin(b))]


def exact():
    """The ends in extended precision."""
    ends = {}
    for problem in DETERMINISTIC:
        real = np.longdouble
        start = problem.start.astype(real)
        if problem is KEPLER:
            ends[problem.name] = problem.start
            continue
        integrator = hy.taylor_adaptive(system(problem), start, fp_type=real, tol=real(1e-18))
        integrator.propagate_until(real(problem.horizon))
        ends[problem.name] = integrator.state.astype(float)
    return ends


def results(exact):
    width = hy.recommended_simd_size()
    for problem in DETERMINISTIC:
        for tolerance in TOLERANCES:
            single = hy.taylor_adaptive(system(problem), problem.start, tol=tolerance)
            steps = 0

            def run():
                nonlocal steps
                single.time, single.state[:] = 0.0, problem.start
                steps = single.propagate_until(problem.horizon)[3]

            run()
            line = row(problem.name, "Taylor, adaptive", SOURCE)
            line["error"] = np.linalg.norm(single.state - exact[problem.name])
            timed(line, *measure(run), steps)
            single.time, single.state[:] = 0.0, problem.start
            times = np.linspace(0.0, problem.horizon, 1000)
            states = single.propagate_grid(times)[5].T
            yield conserved(line, problem, times, states)

            starts = np.repeat(problem.start[:, None], width, axis=1)
            batch = hy.taylor_adaptive_batch(system(problem), starts, tol=tolerance)

            def run_batch():
                batch.set_time(0.0)
                batch.state[:] = starts
                batch.propagate_until(problem.horizon)

            line = dict(line, method=f"Taylor, adaptive, batch of {width}")
            seconds, spread = measure(run_batch)
            yield timed(line, seconds / width, spread / width, steps)
