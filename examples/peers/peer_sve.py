"""sve: `gauss(8)` with equal steps, with a tolerance, and both in the time of a time scale, on the problems without noise.

The paths are those of `cargo run --release --example work_precision -- serve`, which has to be built before. Each method has one setting: the number of equal
steps, the tolerance, or the length of a step in the time τ.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from common import Record, Walk, Walks, set_errors
from problems import Problem
from references import paths
from served import Served

SOURCE = "sve"
TOLERANCES = tuple(10.0 ** (-0.5 * k) for k in range(4, 31))
"""The largest and the least tolerance that `.tolerance` takes are 1e-2 and 1e-15."""
FEWEST_STEPS = {"pendulum": 2100, "double_pendulum": 40, "kepler": 9000, "quiet_henon_heiles": 300, "outer_solar_system": 500, "separatrix": 40}
"""The least number of equal steps. The problems without an entry would need steps as short as the closest encounter asks for."""
LONGEST_STEP = {"kepler": 1.5, "pendulum": 2.4, "double_pendulum": 1.2, "three_bodies": 0.7}
"""The longest step in τ, by the system."""
IN_EACH_DOUBLING = 4
DOUBLINGS = 4


@dataclass(frozen=True)
class Path(Walk):
    """A path that the other process solves: it measures its own processor time."""

    words: tuple[object, ...] = ()

    def elapsed(self, times: int) -> float:
        """Processor time of the other process."""
        return float(ask(self.words, times)[0])


@cache
def server() -> Served:
    """The process that solves all paths."""
    return Served("work_precision", "serve")


def ask(words: tuple[object, ...], times: int) -> list[str]:
    """Has a path solved so many times."""
    system, method, setting, *rest = words
    return server().ask(system, method, setting, times, *rest)


def settings(problem: Problem) -> dict[str, tuple[float, ...]]:
    """The settings of each method, from the coarsest to the finest."""
    system = problem.system or problem.name
    finer = 2.0 ** (np.arange(DOUBLINGS * IN_EACH_DOUBLING + 1) / IN_EACH_DOUBLING)
    found = {"tolerance": TOLERANCES}
    first = FEWEST_STEPS.get(problem.name.rstrip("_23456"))
    if first:
        found["fixed"] = found["compensated"] = tuple(problem.horizon / np.round(first * finer))
    if system in LONGEST_STEP:
        found["time_scale"] = tuple(LONGEST_STEP[system] / finer)
        found["time_scale_tolerance"] = TOLERANCES
    return found


def walks(problem: Problem) -> tuple[Walks, Walks]:
    """One path at a time. A setting with which a path fails is left out, and told."""
    if problem.processes > 0:
        return [], []
    lines: Walks = []
    for method, values in settings(problem).items():
        for setting in values:
            words = (problem.system or problem.name, method, repr(float(setting)), repr(problem.horizon), *map(repr, problem.start))
            _, *answer = first = ask(words, 1)
            if first[0] == "failed:":
                print(f"{problem.name}, {method}, {setting:.3g}:", *answer)
                continue
            steps, *end = answer
            line = Record(problem.name, method, setting, source=SOURCE)
            set_errors(line, problem, np.array(end, float)[None], paths(problem).ends)
            lines.append((line, Path(lambda _: None, int(steps), words=words)))
    return lines, []
