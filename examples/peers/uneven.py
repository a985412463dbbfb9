"""Problems without noise whose motion changes its pace, for methods that adapt their steps or have a time scale."""

from collections.abc import Callable
from math import pi, sqrt
from typing import Any

from problems import (
    GRAVITY,
    Field,
    Problem,
    State,
    double_pendulum,
    double_pendulum_energy,
    has_powers,
    kepler,
    kepler_energy,
    pendulum,
    pendulum_energy,
    perihelion,
)

MASSES = (3.0, 4.0, 5.0)
"""Of the Pythagorean problem: the bodies are at rest in the corners of a triangle with the sides 3, 4 and 5, each opposite the side of its number."""


def _three_bodies(f: Any) -> Field:
    m0, m1, m2 = MASSES
    power = has_powers(f)

    def drift(z):
        x0, y0, x1, y1, x2, y2, px0, py0, px1, py1, px2, py2 = z
        r01 = (x0 - x1) * (x0 - x1) + (y0 - y1) * (y0 - y1)
        r02 = (x0 - x2) * (x0 - x2) + (y0 - y2) * (y0 - y2)
        r12 = (x1 - x2) * (x1 - x2) + (y1 - y2) * (y1 - y2)
        w01 = m0 * m1 * (r01**-1.5 if power else 1.0 / (r01 * f.sqrt(r01)))
        w02 = m0 * m2 * (r02**-1.5 if power else 1.0 / (r02 * f.sqrt(r02)))
        w12 = m1 * m2 * (r12**-1.5 if power else 1.0 / (r12 * f.sqrt(r12)))
        a, b = w01 * (x1 - x0), w01 * (y1 - y0)
        c, d = w02 * (x2 - x0), w02 * (y2 - y0)
        e, g = w12 * (x2 - x1), w12 * (y2 - y1)
        return px0 / m0, py0 / m0, px1 / m1, py1 / m1, px2 / m2, py2 / m2, a + c, b + d, e - a, g - b, -c - e, -d - g

    return drift


def _three_bodies_energy(f: Any) -> Callable[[State], Any]:
    def energy(z):
        total = sum((z[6 + 2 * i] ** 2 + z[7 + 2 * i] ** 2) / (2.0 * MASSES[i]) for i in range(3))
        for i in range(3):
            for j in range(i):
                x, y = z[2 * i] - z[2 * j], z[2 * i + 1] - z[2 * j + 1]
                total = total - MASSES[i] * MASSES[j] / f.sqrt(x * x + y * y)
        return total

    return energy


UNEVEN = (
    Problem("kepler_90", perihelion(0.9), 200.0 * pi, (), kepler, invariant=kepler_energy, system="kepler"),
    Problem("kepler_99", perihelion(0.99), 200.0 * pi, (), kepler, invariant=kepler_energy, system="kepler"),
    Problem(
        "three_bodies",
        start=(1.0, 3.0, -2.0, -1.0, 1.0, -1.0, *(0.0,) * 6),
        horizon=20.0,
        steps=(),
        drift=_three_bodies,
        invariant=_three_bodies_energy,
        extrapolations=200,
    ),
    # 1e-6 slower than what reaches the top
    Problem(
        "separatrix",
        start=(0.0, 2.0 * sqrt(GRAVITY) * (1.0 - 1e-6)),
        horizon=50.0,
        steps=(),
        drift=pendulum,
        invariant=pendulum_energy,
        extrapolations=400,
        system="pendulum",
    ),
    *(
        Problem(
            f"double_pendulum_{k}",
            start=(*angles, 0.0, 0.0),
            horizon=10.0,
            steps=(),
            drift=double_pendulum,
            invariant=double_pendulum_energy,
            separable=False,
            extrapolations=400,
            system="double_pendulum",
        )
        for k, angles in enumerate(((2.2, 0.5), (1.5, 2.5), (2.5, -1.0), (1.0, 2.0), (3.0, 0.1)), 2)
    ),
)
"""With `double_pendulum` the double pendulum has six starts."""
