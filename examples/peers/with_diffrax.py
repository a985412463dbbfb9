"""diffrax on JAX, compiled by XLA, 64 bits: adaptive explicit Runge–Kutta methods, and fixed steps on given Brownian paths; batched by `vmap`."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

from common import (
    DETERMINISTIC, DOUBLE, KEPLER, KUBO, OSCILLATOR, PATHS, coarsened, kubo_paths, kubo_position, measure,
    oscillator_energy, oscillator_paths, row, strong, timed, weak,
)

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_platforms", "cpu")
SOURCE = f"diffrax {diffrax.__version__}"
TOLERANCES = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
BATCH = 256


def field(problem):
    if problem is KEPLER:
        def kepler(t, z, args):
            r3 = (z[0] * z[0] + z[1] * z[1]) ** 1.5
            return jnp.stack([z[2], z[3], -z[0] / r3, -z[1] / r3])
        return kepler
    if problem is DOUBLE:
        def double(t, z, args):
            c = jnp.cos(z[0] - z[1])
            det = 2.0 - c * c
            v0, v1 = (z[2] - c * z[3]) / det, (2.0 * z[3] - c * z[2]) / det
            turn = v0 * v1 * jnp.sin(z[0] - z[1])
            return jnp.stack([v0, v1, -turn - 19.6 * jnp.sin(z[0]), turn - 9.8 * jnp.sin(z[1])])
        return double
    return lambda t, z, args: jnp.stack([z[1], -9.8 * jnp.sin(z[0])])


def deterministic(exact):
    for problem in DETERMINISTIC:
        for name, solver in [("Tsit5", diffrax.Tsit5()), ("Dopri8", diffrax.Dopri8())]:
            for tolerance in TOLERANCES:
                def solve(start):
                    solution = diffrax.diffeqsolve(
                        diffrax.ODETerm(field(problem)), solver, 0.0, problem.horizon, None, start,
                        saveat=diffrax.SaveAt(t1=True), max_steps=None,
                        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
                    )
                    return solution.ys[0], solution.stats["num_accepted_steps"]

                single = jax.jit(solve)
                start = jnp.asarray(problem.start)
                end, steps = single(start)
                line = row(problem.name, name, SOURCE)
                line["error"] = np.linalg.norm(np.asarray(end) - exact[problem.name])
                yield timed(line, *measure(lambda: jax.block_until_ready(single(start))), int(steps))
                batch = jax.jit(jax.vmap(solve))
                starts = jnp.tile(start, (BATCH, 1))
                seconds, spread = measure(lambda: jax.block_until_ready(batch(starts)))
                line = dict(line, method=f"{name}, batch of {BATCH}")
                yield timed(line, seconds / BATCH, spread / BATCH, int(steps))


class Recorded(diffrax.AbstractPath):
    """A Brownian path of which the values at the ends of steps are given."""

    values: jax.Array
    h: float
    t0: float = 0.0
    t1: float = 1.0

    def evaluate(self, t0, t1=None, left=True, use_levy=False):
        def at(t):
            return self.values[jnp.round(t / self.h).astype(int)]

        return at(t0) if t1 is None else at(t1) - at(t0)


def noisy(name, horizon, sigma, numbers, paths, of, drift, diffusion, solvers):
    fine, exact = paths(horizon, sigma, max(numbers))
    for method, solver in solvers:
        for steps in numbers:
            h = horizon / steps
            dw = coarsened(fine, steps)
            values = jnp.asarray(np.concatenate([np.zeros((PATHS, 1)), dw.cumsum(axis=1)], axis=1))

            def solve(values):
                control = diffrax.ControlTerm(diffusion(sigma), Recorded(values, h))
                solution = diffrax.diffeqsolve(
                    diffrax.MultiTerm(diffrax.ODETerm(drift), control), solver, 0.0, horizon, h,
                    jnp.array([1.0, 0.0]), saveat=diffrax.SaveAt(t1=True), max_steps=None,
                    stepsize_controller=diffrax.ConstantStepSize(),
                )
                return solution.ys[0]

            batch = jax.jit(jax.vmap(solve))
            ends = np.asarray(batch(values)).T
            line = row(name, f"{method}, batch of {PATHS}", SOURCE, h)
            weak(strong(line, ends, exact), of, ends, exact)
            seconds, spread = measure(lambda: jax.block_until_ready(batch(values)))
            yield timed(line, seconds / PATHS, spread / PATHS, steps)


def results(exact):
    def turn(t, z, args):
        return jnp.stack([z[1], -z[0]])

    def push(sigma):
        return lambda t, z, args: sigma * jnp.array([0.0, 1.0])

    def jitter(sigma):
        return lambda t, z, args: sigma * jnp.stack([z[1], -z[0]])

    name, horizon, sigma, numbers = OSCILLATOR
    solvers = [("Heun", diffrax.Heun())]
    yield from noisy(name, horizon, sigma, numbers, oscillator_paths, oscillator_energy, turn, push, solvers)
    name, horizon, sigma, numbers = KUBO
    yield from noisy(name, horizon, sigma, numbers, kubo_paths, kubo_position, turn, jitter, solvers)
    yield from deterministic(exact)
