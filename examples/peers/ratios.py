"""Prints, for each problem, error and method, how many times longer heyoka takes, from the files that `run.py` wrote in one run.

Each method has one setting. An error counts only if the next two finer settings have it too or less. Between settings the time follows the straight line in
logarithms; where the coarsest setting has the error already, the time is that of this setting. At each error heyoka is taken with or without compensated
sums, whichever takes less time. Of the double pendulum the numbers are geometric means over the starts from which both reach the error, with their number
where that is not all of them.
"""

import argparse
import csv
from itertools import pairwise
from math import exp, log
from pathlib import Path

from problems import PROBLEMS, Problem
from run import ROOT
from uneven import UNEVEN

LEVELS = tuple(range(2, 11))
"""Errors are powers of ten with these exponents, below 1."""
CONFIRMATIONS = 2
HEYOKA = "heyoka"

Points = list[tuple[float, float]]
"""Times and errors, from the coarsest setting to the finest."""


def confirmed(points: Points) -> Points:
    """Times, with the largest error of each setting and the finer ones that confirm it; without settings that none confirm."""
    last = len(points) - CONFIRMATIONS
    return [(points[i][0], max(error for _, error in points[i : i + CONFIRMATIONS + 1])) for i in range(last)]


def least_time(points: Points, error: float) -> float | None:
    """The least time to an error; None where it is not reached."""
    points = confirmed(points)
    times = [time for time, e in points if e <= error]
    for (t0, e0), (t1, e1) in pairwise(points):
        if e1 < error < e0:
            times.append(t0 * exp(log(t1 / t0) * log(error / e0) / log(e1 / e0)))
    return min(times, default=None)


def curves(folder: Path, problem: Problem) -> dict[str, Points]:
    """The points of each method, named after program and method."""
    found: dict[str, Points] = {}
    for file in sorted(folder.glob(f"*_{problem.name}.csv")):
        program = file.name.removesuffix(f"_{problem.name}.csv")
        with file.open(encoding="utf-8") as lines:
            rows = [row for row in csv.DictReader(lines) if row["problem"] == problem.name]
        for row in rows:
            error = float(row["error"]) if row["error"] else float("inf")
            found.setdefault(f"{program} {row['method']}", []).append((float(row["time_to_solution_s"]), error))
    return found


def times(folder: Path, problem: Problem, error: float) -> dict[str, float | None]:
    """The least time to an error of each method, and under `HEYOKA` that of heyoka's faster method."""
    found = {name: least_time(points, error) for name, points in curves(folder, problem).items()}
    series = [time for name, time in found.items() if name.startswith(HEYOKA) and time is not None]
    return {HEYOKA: min(series, default=None)} | found


def line(folder: Path, starts: list[Problem], name: str) -> str:
    """The ratios of a method for a problem, at all errors. In brackets its own time."""
    cells = []
    for level in LEVELS:
        found = [times(folder, start, 10.0**-level) for start in starts]
        both = [(t[HEYOKA], t[name]) for t in found if t[HEYOKA] is not None and t.get(name) is not None]
        if both:
            middle = exp(sum(log(base / own) for base, own in both) / len(both))
            own = 1e6 * exp(sum(log(own) for _, own in both) / len(both))
            fewer = f" of {len(both)}" if len(both) < len(starts) else ""
            cells.append(f"1e-{level} {middle:.2f} ({own:.0f} µs{fewer})")
        else:
            cells.append(f"1e-{level} {'–' if any(t[HEYOKA] is not None for t in found) else 'heyoka –'}")
    return f"{starts[0].name} | {name} | {' | '.join(cells)}"


def main() -> None:
    """Prints all lines."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("folder", type=Path, nargs="?", default=ROOT / "target" / "work-precision" / "turns")
    folder = options.parse_args().folder
    every = PROBLEMS + UNEVEN
    for problem in every:
        names = list(curves(folder, problem))
        if names and problem.name == problem.name.rstrip("_23456"):
            starts = [p for p in every if p.name.rstrip("_23456") == problem.name]
            for name in [HEYOKA, *names]:
                print(line(folder, starts, name))


if __name__ == "__main__":
    main()
