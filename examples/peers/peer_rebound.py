"""REBOUND: IAS15, a Gauss–Radau rule of order 15 whose steps its parameter ε adapts, on the problems of bodies that attract one another."""

from dataclasses import dataclass
from importlib.metadata import version
from time import process_time

import numpy as np
import planets
import rebound
from common import Record, Walk, Walks, set_errors
from problems import Problem
from references import paths
from uneven import MASSES

SOURCE = f"rebound {version('rebound')}"
EPSILONS = tuple(10.0 ** (-0.5 * k) for k in range(8, 21))
"""The parameter that REBOUND recommends is 1e-9."""


@dataclass(frozen=True)
class Simulation(Walk):
    """A simulation of a problem, made anew each time; making it is not timed."""

    problem: Problem | None = None
    epsilon: float = 1e-9

    def elapsed(self, times: int) -> float:
        """Processor time of the integrations alone."""
        simulations = [simulation(self.problem, self.epsilon) for _ in range(times)]
        begin = process_time()
        for one in simulations:
            one.integrate(self.problem.horizon)
        return process_time() - begin


def bodies(problem: Problem) -> tuple[float, tuple[float, ...], int] | None:
    """The constant of gravitation, the masses and the dimension; a mass of 0 for the planet of Kepler's problem, before which a body at rest stands."""
    match problem.system or problem.name:
        case "kepler":
            return 1.0, (0.0,), 2
        case "three_bodies":
            return 1.0, MASSES, 2
        case "outer_solar_system":
            return planets.GRAVITY, planets.MASSES, 3
    return None


def simulation(problem: Problem, epsilon: float) -> rebound.Simulation:
    """The problem at its start."""
    gravity, masses, dimension = bodies(problem)
    q, p = np.array(problem.start).reshape(2, len(masses), dimension)
    made = rebound.Simulation()
    made.integrator, made.G = "ias15", gravity
    made.integrator.epsilon = epsilon
    if masses == (0.0,):
        made.add(m=1.0)
    for m, place, momentum in zip(masses, q, p, strict=True):
        velocity = momentum / m if m > 0.0 else momentum
        made.add(m=m, **dict(zip("xyz", place, strict=False)), **dict(zip(("vx", "vy", "vz"), velocity, strict=False)))
    return made


def walks(problem: Problem) -> tuple[Walks, Walks]:
    """One path at a time. The errors are those of the positions."""
    if bodies(problem) is None:
        return [], []
    dimension, lines = bodies(problem)[2], []
    for epsilon in EPSILONS:
        made = simulation(problem, epsilon)
        made.integrate(problem.horizon)
        moving = made.particles[made.N - len(bodies(problem)[1]) :]
        q = np.array([body.xyz[:dimension] for body in moving]).ravel()
        line = Record(problem.name, "IAS15", source=SOURCE)
        set_errors(line, problem, np.concatenate([q, np.zeros_like(q)])[None], paths(problem).ends)
        lines.append((line, Simulation(lambda _: None, made.steps_done, problem=problem, epsilon=epsilon)))
    return lines, []
