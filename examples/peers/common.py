"""The problems, the clock, and the file of results, the same for all programs.

The problems and their numbers are those of `examples/examples/work_precision`; the columns are those of `sve_runtime::study::COLUMNS`.
"""

import csv
import math
import time

import numpy as np

COLUMNS = [
    "problem", "method", "h", "error", "error_se", "weak_error", "weak_error_se", "energy_error", "energy_drift",
    "ns_per_step", "ns_spread", "time_to_solution_s", "newton_iterations", "failures", "source",
]
PATHS = 1000
SEED = 42
# How often a time is measured: at least, and at most, and for how long in all, in seconds.
LEAST, REPEATS, LONGEST = 3, 9, 0.3
# The least time that is measured at once, in seconds.
SLICE = 1e-3


class Problem:
    """A problem without noise, with functions of NumPy's arrays."""

    def __init__(self, name, start, horizon, field, energy):
        self.name, self.horizon = name, horizon
        self.start = np.array(start, dtype=float)
        self.field, self.energy = field, energy


def pendulum_field(t, z):
    return np.array([z[1], -9.8 * np.sin(z[0])])


def pendulum_energy(z):
    return 0.5 * z[1] ** 2 - 9.8 * np.cos(z[0])


def kepler_field(t, z):
    r3 = (z[0] * z[0] + z[1] * z[1]) ** 1.5
    return np.array([z[2], z[3], -z[0] / r3, -z[1] / r3])


def kepler_energy(z):
    return 0.5 * (z[2] ** 2 + z[3] ** 2) - 1.0 / np.sqrt(z[0] ** 2 + z[1] ** 2)


def double_pendulum_velocities(z):
    """The velocities: the momenta are M v with M = [[2, c], [c, 1]], c = cos(q0 - q1)."""
    c = np.cos(z[0] - z[1])
    det = 2.0 - c * c
    return (z[2] - c * z[3]) / det, (2.0 * z[3] - c * z[2]) / det


def double_pendulum_field(t, z):
    v0, v1 = double_pendulum_velocities(z)
    turn = v0 * v1 * np.sin(z[0] - z[1])
    return np.array([v0, v1, -turn - 19.6 * np.sin(z[0]), turn - 9.8 * np.sin(z[1])])


def double_pendulum_energy(z):
    v0, v1 = double_pendulum_velocities(z)
    return 0.5 * (z[2] * v0 + z[3] * v1) - 9.8 * (2.0 * np.cos(z[0]) + np.cos(z[1]))


PENDULUM = Problem("pendulum", [1.0, 0.0], 500.0, pendulum_field, pendulum_energy)
KEPLER = Problem("kepler", [0.4, 0.0, 0.0, 2.0], 20.0 * math.pi, kepler_field, kepler_energy)
DOUBLE = Problem("double_pendulum", [2.0, 1.0, 0.0, 0.0], 4.0, double_pendulum_field, double_pendulum_energy)
DETERMINISTIC = [PENDULUM, KEPLER, DOUBLE]

# Problems with noise: horizon, strength, numbers of steps.
OSCILLATOR = ("linear_oscillator", 10.0, 1.0, [2**k for k in range(5, 11)])
KUBO = ("kubo", 4.0, 0.5, [2**k for k in range(4, 12)])


def oscillator_paths(horizon, sigma, steps):
    """Increments of PATHS paths and their exact ends (q, p), drawn jointly: see `noisy.rs`."""
    h = horizon / steps
    normals = np.random.default_rng(SEED).standard_normal((PATHS, steps, 3))
    s, c, w = math.sin(h), math.cos(h), math.sqrt(h)
    xw, yw = 2.0 * math.sin(h / 2.0) ** 2 / w, s / w
    x = math.sqrt(0.5 * (h - s * c) - xw * xw)
    yx = (0.5 * s * s - xw * yw) / x
    y = math.sqrt(max(0.0, 0.5 * (h + s * c) - yw * yw - yx * yx))
    q, p = np.ones(PATHS), np.zeros(PATHS)
    for k in range(steps):
        z0, z1, z2 = normals[:, k, 0], normals[:, k, 1], normals[:, k, 2]
        q, p = (
            c * q + s * p + sigma * (xw * z0 + x * z1),
            c * p - s * q + sigma * (yw * z0 + yx * z1 + y * z2),
        )
    return w * normals[:, :, 0], np.stack([q, p])


def kubo_paths(horizon, sigma, steps):
    """Increments of PATHS paths and their exact ends: rotations by t + σ W(t)."""
    h = horizon / steps
    dw = math.sqrt(h) * np.random.default_rng(SEED).standard_normal((PATHS, steps))
    angle = horizon + sigma * dw.sum(axis=1)
    return dw, np.stack([np.cos(angle), -np.sin(angle)])


def coarsened(dw, steps):
    """The same paths in fewer steps."""
    return dw.reshape(PATHS, steps, -1).sum(axis=2)


def measure(run):
    """Median and half the distance of the quartiles of the processor's time of a call, in seconds; the first calls are not counted.

    The processor's time, of all threads together, does not count what else the machine does meanwhile.
    """
    run()
    times, begin = 1, time.process_time()
    run()
    while time.process_time() - begin < SLICE:
        times, begin = 2 * times, time.process_time()
        for _ in range(times):
            run()
    measured = []
    while len(measured) < LEAST or (len(measured) < REPEATS and sum(measured) * times < LONGEST):
        begin = time.process_time()
        for _ in range(times):
            run()
        measured.append((time.process_time() - begin) / times)
    low, median, high = np.quantile(measured, [0.25, 0.5, 0.75])
    return median, 0.5 * (high - low)


def timed(row, seconds, spread, steps):
    """Adds the times of one path to a row."""
    row["time_to_solution_s"] = seconds
    row["ns_per_step"] = 1e9 * seconds / steps
    row["ns_spread"] = 1e9 * spread / steps
    return row


def strong(row, ends, exact):
    """Adds the root of the mean square of the distance to a row."""
    squares = ((np.asarray(ends) - exact) ** 2).sum(axis=0)
    error = math.sqrt(squares.mean())
    row["error"] = error
    row["error_se"] = squares.std(ddof=1) / math.sqrt(len(squares)) / (2.0 * error)
    return row


def weak(row, of, ends, exact):
    """Adds the difference of the means of a function on the same paths to a row."""
    differences = of(np.asarray(ends)) - of(exact)
    row["weak_error"] = differences.mean()
    row["weak_error_se"] = differences.std(ddof=1) / math.sqrt(len(differences))
    return row


def oscillator_energy(z):
    return 0.5 * (z[0] ** 2 + z[1] ** 2)


def kubo_position(z):
    return z[0]


def conserved(row, problem, times, states):
    """Adds largest error and drift of the energy along states, one a column, to a row."""
    energy = problem.energy(states) - problem.energy(problem.start)
    row["energy_error"] = np.abs(energy).max()
    row["energy_drift"] = np.polyfit(times, energy, 1)[0]
    return row


def row(problem, method, source, h=None):
    return {"problem": problem, "method": method, "h": h, "failures": 0, "source": source}


def write(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for line in rows:
            writer.writerow({name: "" if line.get(name) is None else line[name] for name in COLUMNS})
