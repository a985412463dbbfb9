"""The equations of a problem as functions that numba has compiled: for the program `numba`, and for the references."""

import math
from collections.abc import Callable

import numba
import numpy as np
from problems import Problem

jit = numba.njit(error_model="numpy")
"""As compiled languages have it, x/0 is no exception: the test for one would keep loops from being vectorised."""


def plus(dimension: int) -> Callable:
    """A compiled function of tuples z, k and a number a: z + a k. Numba has no loop over the components of a tuple that makes a tuple."""
    components = ", ".join(f"z[{i}] + a * k[{i}]" for i in range(dimension))
    return jit(eval(f"lambda z, a, k: ({components})"))  # noqa: S307


def as_array(drift: Callable, dimension: int) -> Callable:
    """A compiled function of time and an array z that returns the rate as an array."""
    components = ", ".join(f"z[{i}]" for i in range(dimension))
    return jit(eval(f"lambda t, z: array(drift(({components})))", {"array": np.array, "drift": drift}))  # noqa: S307


def rate(problem: Problem) -> Callable:
    """A compiled function of z, h and the increments (M,): drift h + kick, as a tuple."""
    drift = jit(problem.drift(math))
    if problem.kick is None:
        zero, scaled = (0.0,) * problem.dimension, plus(problem.dimension)
        return jit(lambda z, h, dw: scaled(zero, h, drift(z)))
    kick, add = jit(problem.kick(math)), plus(problem.dimension)
    return jit(lambda z, h, dw: add(kick(z, dw), h, drift(z)))
