"""What all programs share: lines of results, measures of errors, times.

The columns and the meaning of the numbers are those of `sve_runtime::study::Record`.
"""

import csv
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from time import process_time

import numpy as np
from problems import Problem

Array = np.ndarray

REPEATS = 9
"""Repeats of each time, at most."""
LEAST_REPEATS = 3
PATIENCE = 0.2
"""Seconds for the repeats of one time, unless that makes fewer than the least number of them."""
SLICE = 1e-3
"""The least time that is measured at once, in seconds."""


@dataclass
class Record:
    """One line: a method with one step size or tolerance on one problem; None is what is not known."""

    problem: str
    method: str
    h: float | None = None
    error: float | None = None
    error_se: float | None = None
    weak_error: float | None = None
    weak_error_se: float | None = None
    energy_error: float | None = None
    energy_drift: float | None = None
    ns_per_step: float | None = None
    ns_spread: float | None = None
    time_to_solution_s: float | None = None
    newton_iterations: float | None = None
    failures: int = 0
    source: str = ""


@dataclass(frozen=True)
class Walk:
    """What is timed: `run(times)` solves the problem so many times, each time `paths` paths of `steps` steps."""

    run: Callable[[int], object]
    steps: int
    paths: int = 1

    def elapsed(self, times: int) -> float:
        """Processor time of all threads: on one core with nothing else to do, that which passes; other load does not count."""
        begin = process_time()
        self.run(times)
        return process_time() - begin


Walks = list[tuple["Record", Walk]]
"""Lines with what is timed for them."""


def write(path: Path, records: Sequence[Record]) -> None:
    """Writes records under a line with the names of the columns; an empty field is a number that is not known."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(field.name for field in fields(Record))
        for record in records:
            lines.writerow("" if value is None else value for value in astuple(record))


def set_errors(record: Record, problem: Problem, ends: Array, exact: Array) -> None:
    """Strong and weak errors from states at the horizon, both of shape (paths, 2N); errors without noise are those of q. A path whose error overflows is a failure."""
    with np.errstate(over="ignore", invalid="ignore"):
        squares = ((ends - exact)[:, : problem.compared] ** 2).sum(axis=1)
        differences = np.zeros(len(ends))
        if problem.observable is not None:
            observed = problem.observable(np)
            differences = observed(tuple(ends.T)) - observed(tuple(exact.T))
        alive = np.isfinite(squares) & np.isfinite(differences)
    record.failures = int((~alive).sum())
    if not alive.any():
        return
    squares, differences = squares[alive], differences[alive]
    record.error = float(np.sqrt(squares.mean()))
    record.error_se = standard_error(problem, squares) / (2.0 * record.error) if record.error > 0.0 else 0.0
    if problem.observable is not None:
        record.weak_error = float(differences.mean())
        record.weak_error_se = standard_error(problem, differences)


def standard_error(problem: Problem, values: Array) -> float:
    """Standard error of a mean over paths; 0 where nothing is random."""
    if problem.processes == 0:
        return 0.0
    return float(np.std(values, ddof=1) / np.sqrt(len(values)))


def set_invariant(record: Record, problem: Problem, times: Array, states: Array) -> None:
    """Errors of the invariant: `times` of shape (steps + 1,), `states` of shape (paths, steps + 1, 2N), both with the start.

    The drift is the slope of the least-squares line through the values, averaged over the paths.
    """
    if problem.invariant is None:
        return
    values = problem.invariant(np)(tuple(np.moveaxis(states, -1, 0)))
    changes = values - values[:, :1]
    centred = times - times.mean()
    slopes = changes @ centred / (centred @ centred)
    if np.isfinite(slopes).all():
        record.energy_error = float(np.abs(changes).max())
        record.energy_drift = float(slopes.mean())


def set_times(walks: Walks) -> None:
    """Medians and spreads of the times of a step and of a path. All walks take turns, so that what disturbs the machine disturbs all."""
    times: list[int] = []
    seconds: list[list[float]] = []
    for _, walk in walks:
        # all that is compiled was called before
        number = 1
        while (elapsed := walk.elapsed(number)) < SLICE:
            number *= 2
        times.append(number)
        seconds.append([elapsed / number])
    for turn in range(1, REPEATS):
        for (_, walk), number, measured in zip(walks, times, seconds, strict=True):
            if turn < LEAST_REPEATS or sum(measured) * number < PATIENCE:
                measured.append(walk.elapsed(number) / number)
    for (record, walk), measured in zip(walks, seconds, strict=True):
        low, middle, high = np.percentile(np.array(measured) / walk.paths, [25, 50, 75])
        record.time_to_solution_s = float(middle)
        record.ns_per_step = float(1e9 * middle / walk.steps)
        record.ns_spread = float(1e9 * 0.5 * (high - low) / walk.steps)
