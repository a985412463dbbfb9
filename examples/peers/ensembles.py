"""Many paths by other programs: tasks A and B of `cargo bench -p sve-runtime --features ensemble --bench ensemble`.

A: the linear oscillator, q₁ = q₀ + h p₀, p₁ = p₀ − h q₁ + σ ΔW, from (1, 0), its energy. B: the Kubo oscillator by the midpoint rule in
its closed form (diffrax: Heun, as it has no such rule), from (1, 0), its q. 1,000 paths of 1,000 steps of 0.1, increments drawn on the way, on one core. Means
over the paths are recorded every 100 steps (diffrax: at the end). Prints nanoseconds a trajectory-step, compiled and warm: the median
of alternating runs. Each mean is compared with its expectation; status 1 where one is off. `ensembles.py numba` runs one program.
"""

import sys
from collections.abc import Callable
from importlib.metadata import version
from statistics import median
from time import process_time

import numpy as np
from run import one_core

PATHS, STEPS, EVERY = 1000, 1000, 100
H, SIGMA, A = 0.1, 1.0, 1.0
ROUNDS = 15

Run = Callable[[int], tuple[float, float]]
"""From a seed to the mean and the standard error at the end."""


def numba_tasks() -> dict[tuple[str, str], Run]:
    """Paths in the inner loop, both generators."""
    import numba

    def task(oscillator: bool, generator: bool) -> Run:
        @numba.njit(error_model="numpy")
        def steps(rng, q, p, sums):
            scale = np.sqrt(H)
            for step in range(STEPS):
                for k in range(PATHS):
                    z = rng.standard_normal() if generator else np.random.standard_normal()
                    dw = scale * z
                    if oscillator:
                        q[k] += H * p[k]
                        p[k] += SIGMA * dw - H * q[k]
                    else:
                        half = 0.5 * (A * H + SIGMA * dw)
                        turn = 1.0 / (1.0 + half * half)
                        c, s = (1.0 - half * half) * turn, 2.0 * half * turn
                        q[k], p[k] = c * q[k] + s * p[k], c * p[k] - s * q[k]
                if (step + 1) % EVERY == 0:
                    for k in range(PATHS):
                        value = 0.5 * (q[k] * q[k] + p[k] * p[k]) if oscillator else q[k]
                        sums[(step + 1) // EVERY - 1, 0] += value
                        sums[(step + 1) // EVERY - 1, 1] += value * value

        def run(seed: int) -> tuple[float, float]:
            sums = np.zeros((STEPS // EVERY, 2))
            rng = np.random.Generator(np.random.SFC64(seed))
            steps(rng, np.ones(PATHS), np.zeros(PATHS), sums)
            mean, square = sums[-1] / PATHS
            return mean, np.sqrt((square - mean * mean) / (PATHS - 1))

        return run

    names = {True: "Generator(SFC64)", False: "np.random"}
    return {(task_name, names[g]): task(task_name == "A", g) for g in (True, False) for task_name in "AB"}


def jax_tasks() -> dict[tuple[str, str], Run]:
    """`lax.scan` over the steps, all paths in one array, 64 bits."""
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    def oscillator(z, dw):
        q = z[0] + H * z[1]
        return q, z[1] - H * q + SIGMA * dw

    def kubo(z, dw):
        half = 0.5 * (A * H + SIGMA * dw)
        turn = 1.0 / (1.0 + half * half)
        c, s = (1.0 - half * half) * turn, 2.0 * half * turn
        return c * z[0] + s * z[1], c * z[1] - s * z[0]

    def task(step, observe) -> Run:
        def one(carry, _):
            key, z = carry
            key, draw = jax.random.split(key)
            dw = jnp.sqrt(H) * jax.random.normal(draw, (PATHS,), dtype=jnp.float64)
            return (key, step(z, dw)), None

        def block(carry, _):
            carry, _ = jax.lax.scan(one, carry, None, length=EVERY)
            values = observe(*carry[1])
            return carry, (values.mean(), values.std(ddof=1) / np.sqrt(PATHS))

        @jax.jit
        def solve(key):
            start = (jnp.ones(PATHS), jnp.zeros(PATHS))
            _, (means, errors) = jax.lax.scan(block, (key, start), None, length=STEPS // EVERY)
            return means[-1], errors[-1]

        def run(seed: int) -> tuple[float, float]:
            mean, error = solve(jax.random.key(seed))
            return float(mean), float(error)

        return run

    energy = task(oscillator, lambda q, p: 0.5 * (q * q + p * p))
    return {("A", "lax.scan"): energy, ("B", "lax.scan"): task(kubo, lambda q, p: q)}


def diffrax_tasks() -> dict[tuple[str, str], Run]:
    """`vmap` of `diffeqsolve` with fixed steps: SemiImplicitEuler (A), Heun (B), increments by `UnsafeBrownianPath`, its fastest."""
    import warnings

    import diffrax
    import jax
    import jax.numpy as jnp

    # its noise depends on q alone, so that the equations of Itô and of Stratonovich are the same
    warnings.filterwarnings("ignore", "`SemiImplicitEuler` is not marked as converging")
    jax.config.update("jax_enable_x64", True)

    def solve(terms, solver, start):
        solution = diffrax.diffeqsolve(
            terms,
            solver,
            0.0,
            STEPS * H,
            H,
            start,
            saveat=diffrax.SaveAt(t1=True),
            max_steps=None,
            throw=False,
            # the only one that such a path allows; nothing is differentiated
            adjoint=diffrax.ForwardMode(),
        )
        return solution.ys

    def oscillator(key):
        path = diffrax.UnsafeBrownianPath((), key)
        push = diffrax.ControlTerm(lambda t, q, args: jnp.asarray(SIGMA), path)
        force = diffrax.MultiTerm(diffrax.ODETerm(lambda t, q, args: -q), push)
        terms = (diffrax.ODETerm(lambda t, p, args: p), force)
        # the pair is stepped q first
        q, p = solve(terms, diffrax.SemiImplicitEuler(), (jnp.asarray(1.0), jnp.asarray(0.0)))
        return 0.5 * (q[0] ** 2 + p[0] ** 2)

    def kubo(key):
        path = diffrax.UnsafeBrownianPath((), key, levy_area=diffrax.BrownianIncrement)
        turn = lambda t, z, args: jnp.stack([z[1], -z[0]])  # noqa: E731
        noise = diffrax.ControlTerm(lambda t, z, args: SIGMA * turn(t, z, args), path)
        terms = diffrax.MultiTerm(diffrax.ODETerm(lambda t, z, args: A * turn(t, z, args)), noise)
        return solve(terms, diffrax.Heun(), jnp.array([1.0, 0.0]))[0, 0]

    def task(one) -> Run:
        many = jax.jit(jax.vmap(one))

        def run(seed: int) -> tuple[float, float]:
            values = np.asarray(many(jax.random.split(jax.random.key(seed), PATHS)))
            return float(values.mean()), float(values.std(ddof=1) / np.sqrt(PATHS))

        return run

    return {("A", "SemiImplicitEuler"): task(oscillator), ("B", "Heun"): task(kubo)}


PROGRAMS = {"numba": numba_tasks, "jax": jax_tasks, "diffrax": diffrax_tasks}


def expected(task: str) -> float:
    """A: H₀ + σ²t/2, from which the rule's mean energy differs by less than 0.2. B: nothing is left of the phase."""
    return 0.5 + 0.5 * SIGMA**2 * STEPS * H if task == "A" else 0.0


def main() -> int:
    """Runs all programs in turns; 1 where a mean is off."""
    one_core()
    chosen = sys.argv[1:] or list(PROGRAMS)
    runs = {(program, *key): run for program in chosen for key, run in PROGRAMS[program]().items()}
    off = 0
    for (program, task, how), run in runs.items():
        mean, error = run(0)
        if abs(mean - expected(task)) > 5.0 * error + 0.2 * (task == "A"):
            print(f"{task} {program} {how}: mean {mean:.4g} ± {error:.2g}, expected {expected(task):.4g}")
            off = 1
    times = {key: [] for key in runs}
    for seed in range(1, ROUNDS + 1):
        for key, run in runs.items():
            begin = process_time()
            run(seed)
            times[key].append(1e9 * (process_time() - begin) / (PATHS * STEPS))
    for (program, task, how), values in times.items():
        print(f"{task} | {program} {version(program)} | {how} | {median(values):.2f} ns a step")
    return off


if __name__ == "__main__":
    sys.exit(main())
