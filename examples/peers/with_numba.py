"""Numba: loops written by hand, compiled; one path, and all paths in the inner loop, which LLVM vectorises. One thread."""

import math

import numba
import numpy as np

from common import (
    KUBO, OSCILLATOR, PATHS, PENDULUM, conserved, coarsened, kubo_paths, kubo_position, measure,
    oscillator_energy, oscillator_paths, row, strong, timed, weak,
)

SOURCE = f"numba {numba.__version__}"
# Without the check for division by zero, which keeps loops from being vectorised.
compiled = numba.njit(error_model="numpy")


@compiled
def oscillator_endpoint(q, p, h, sigma, dw):
    for k in range(dw.shape[0]):
        for i in range(dw.shape[1]):
            q[i] += h * p[i]
            p[i] += sigma * dw[k, i] - h * q[i]


@compiled
def oscillator_midpoint(q, p, h, sigma, dw):
    d = 1.0 / (1.0 + 0.25 * h * h)
    for k in range(dw.shape[0]):
        for i in range(dw.shape[1]):
            kick = sigma * dw[k, i]
            v = (p[i] - 0.5 * h * q[i] + 0.5 * kick) * d
            middle = q[i] + 0.5 * h * v
            q[i] += h * v
            p[i] += kick - h * middle


@compiled
def kubo_midpoint(q, p, h, sigma, dw):
    for k in range(dw.shape[0]):
        for i in range(dw.shape[1]):
            x = h + sigma * dw[k, i]
            d = 1.0 / (1.0 + 0.25 * x * x)
            c, s = (1.0 - 0.25 * x * x) * d, x * d
            q[i], p[i] = c * q[i] + s * p[i], c * p[i] - s * q[i]


@compiled
def kubo_heun(q, p, h, sigma, dw):
    for k in range(dw.shape[0]):
        for i in range(dw.shape[1]):
            x = h + sigma * dw[k, i]
            c = 1.0 - 0.5 * x * x
            q[i], p[i] = c * q[i] + x * p[i], c * p[i] - x * q[i]


def noisy(name, horizon, sigma, numbers, paths, of, methods):
    fine, exact = paths(horizon, sigma, max(numbers))
    for method, step in methods:
        for steps in numbers:
            h = horizon / steps
            all_dw = np.ascontiguousarray(coarsened(fine, steps).T)
            one_dw = np.ascontiguousarray(all_dw[:, :1])
            q, p = np.empty(PATHS), np.empty(PATHS)

            def run(dw, q, p):
                q[:], p[:] = 1.0, 0.0
                step(q, p, h, sigma, dw)

            run(all_dw, q, p)
            line = row(name, f"{method}, batch of {PATHS}", SOURCE, h)
            weak(strong(line, [q, p], exact), of, [q, p], exact)
            seconds, spread = measure(lambda: run(all_dw, q, p))
            one_q, one_p = np.empty(1), np.empty(1)
            yield timed(line, seconds / PATHS, spread / PATHS, steps)
            line = dict(line, method=method)
            yield timed(line, *measure(lambda: run(one_dw, one_q, one_p)), steps)


@compiled
def pendulum_midpoint(q, p, h, steps, states):
    for k in range(steps):
        # Newton's method in the velocity, to the rounding level
        v = p
        for _ in range(50):
            s = q + 0.5 * h * v
            residual = v - p + 0.5 * h * 9.8 * math.sin(s)
            update = residual / (1.0 + 0.25 * h * h * 9.8 * math.cos(s))
            v -= update
            if abs(update) <= 1e-8 * abs(v) + 1e-300:
                break
        s = q + 0.5 * h * v
        q += h * v
        p -= h * 9.8 * math.sin(s)
        if states.shape[1] > 0:
            states[0, k], states[1, k] = q, p
    return q, p


@compiled
def pendulum_verlet(q, p, h, steps, states):
    force = -9.8 * math.sin(q)
    for k in range(steps):
        half = p + 0.5 * h * force
        q += h * half
        force = -9.8 * math.sin(q)
        p = half + 0.5 * h * force
        if states.shape[1] > 0:
            states[0, k], states[1, k] = q, p
    return q, p


@compiled
def pendulum_runge_kutta(q, p, h, steps, states):
    for k in range(steps):
        q1, p1 = p, -9.8 * math.sin(q)
        q2, p2 = p + 0.5 * h * p1, -9.8 * math.sin(q + 0.5 * h * q1)
        q3, p3 = p + 0.5 * h * p2, -9.8 * math.sin(q + 0.5 * h * q2)
        q4, p4 = p + h * p3, -9.8 * math.sin(q + h * q3)
        q += h / 6.0 * (q1 + 2.0 * q2 + 2.0 * q3 + q4)
        p += h / 6.0 * (p1 + 2.0 * p2 + 2.0 * p3 + p4)
        if states.shape[1] > 0:
            states[0, k], states[1, k] = q, p
    return q, p


def results(exact):
    name, horizon, sigma, numbers = OSCILLATOR
    methods = [("endpoint", oscillator_endpoint), ("midpoint", oscillator_midpoint)]
    yield from noisy(name, horizon, sigma, numbers, oscillator_paths, oscillator_energy, methods)
    name, horizon, sigma, numbers = KUBO
    methods = [("midpoint", kubo_midpoint), ("Heun", kubo_heun)]
    yield from noisy(name, horizon, sigma, numbers, kubo_paths, kubo_position, methods)
    nothing = np.empty((2, 0))
    for method, step in [
        ("midpoint", pendulum_midpoint), ("Störmer–Verlet", pendulum_verlet), ("Runge–Kutta 4", pendulum_runge_kutta),
    ]:
        for steps in [2**k for k in range(11, 19)]:
            h = PENDULUM.horizon / steps
            states = np.empty((2, steps))
            end = step(1.0, 0.0, h, steps, states)
            line = row(PENDULUM.name, method, SOURCE, h)
            line["error"] = np.linalg.norm(np.array(end) - exact[PENDULUM.name])
            conserved(line, PENDULUM, h * np.arange(1, steps + 1), states)
            yield timed(line, *measure(lambda: step(1.0, 0.0, h, steps, nothing)), steps)
