"""The problems of the example `work_precision`, written once for all programs.

A state z is the tuple (q₁ … q_N, p₁ … p_N) with the canonical momenta p = ∂L/∂v. `drift`, `kick`, `invariant` and `observable` take a namespace `f`
with sin, cos and sqrt first (`math`, `numpy`, `jax.numpy`, `heyoka`), and return a function of z; time is in the units of the problem.
Stochastic equations are those of Stratonovich: dz = drift(z) dt + kick(z, ∘dW). Parameters, starts, horizons and numbers of steps are those of
`examples/examples/work_precision`. `uneven.py` has problems for methods that adapt their steps, whose starts and horizons only these scripts know.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import planets

State = tuple[Any, ...]
Field = Callable[[State], State]

GRAVITY = 9.8
OSCILLATOR_SIGMA = 1.0
KUBO_A, KUBO_SIGMA = 1.0, 0.5
SYNCHROTRON_OMEGA, SYNCHROTRON_SIGMA = 1.0, (0.1, 0.1)
HENON_HEILES_SIGMA = 0.02
LANGEVIN_A, LANGEVIN_NU, LANGEVIN_KT = 1.0, 1.0, 0.4
LANGEVIN_SIGMA = sqrt(2.0 * LANGEVIN_NU * LANGEVIN_KT)
ECCENTRICITY = 0.6


@dataclass(frozen=True)
class Problem:
    """A problem: its equations, and what is asked of a program."""

    name: str
    start: tuple[float, ...]
    horizon: float
    steps: tuple[int, ...]
    """Numbers of steps that the horizon is cut into; each divides the last."""
    drift: Callable[[Any], Field]
    kick: Callable[[Any], Callable[[State, Sequence[Any]], State]] | None = None
    """Change of z by the increments of the M Wiener processes."""
    processes: int = 0
    paths: int = 1
    invariant: Callable[[Any], Callable[[State], Any]] | None = None
    """What the exact solution keeps."""
    observable: Callable[[Any], Callable[[State], Any]] | None = None
    """The function of the state at the horizon whose weak error is measured."""
    separable: bool = True
    """Whether dq/dt depends on p alone and dp/dt on q alone."""
    additive: bool = False
    """Whether the noise does not depend on the state."""
    more_steps: tuple[int, ...] = ()
    """More numbers of steps, for methods of order 2 that know the areas of the noise; each is a multiple of those before."""
    extrapolations: int = 0
    """Longest steps of the extrapolation that computes the end of a problem without noise; 0 for Kepler's problem."""
    system: str = ""
    """The name of the problem with the same equations, where this is another one."""

    @property
    def dimension(self) -> int:
        """Number of components of z, 2N."""
        return len(self.start)

    @property
    def compared(self) -> int:
        """Number of components whose errors are measured: without noise those of q."""
        return self.dimension if self.processes > 0 else self.dimension // 2

    @property
    def finest(self) -> int:
        """The largest number of steps."""
        return (self.steps + self.more_steps)[-1] if self.steps else 1

    @property
    def batch_steps(self) -> tuple[int, ...]:
        """Numbers of steps with which many paths at once are timed: with additive noise all, otherwise two, as the time of a step hardly depends on them."""
        return self.steps + self.more_steps if self.additive else self.steps[2:4]


def has_powers(f: Any) -> bool:
    """Whether a power takes less time than a root, a product and a division: for a Taylor series it is one operation."""
    return hasattr(f, "taylor_adaptive")


def powers(first: int, last: int) -> tuple[int, ...]:
    """Powers of two."""
    return tuple(1 << k for k in range(first, last + 1))


def doublings(first: int, times: int) -> tuple[int, ...]:
    """A number and its doubles."""
    return tuple(first << k for k in range(times + 1))


def pendulum(f: Any) -> Field:
    def drift(z):
        q, p = z
        return p, -GRAVITY * f.sin(q)

    return drift


def pendulum_energy(f: Any) -> Callable[[State], Any]:
    return lambda z: 0.5 * z[1] * z[1] - GRAVITY * f.cos(z[0])


def double_pendulum(f: Any) -> Field:
    def drift(z):
        q1, q2, p1, p2 = z
        s, c = f.sin(q1 - q2), f.cos(q1 - q2)
        det = 2.0 - c * c
        v1, v2 = (p1 - c * p2) / det, (2.0 * p2 - c * p1) / det
        twist = v1 * v2 * s
        return v1, v2, -twist - 2.0 * GRAVITY * f.sin(q1), twist - GRAVITY * f.sin(q2)

    return drift


def double_pendulum_energy(f: Any) -> Callable[[State], Any]:
    def energy(z):
        q1, q2, p1, p2 = z
        c = f.cos(q1 - q2)
        kinetic = (0.5 * p1 * p1 + p2 * p2 - c * p1 * p2) / (2.0 - c * c)
        return kinetic - GRAVITY * (2.0 * f.cos(q1) + f.cos(q2))

    return energy


def kepler(f: Any) -> Field:
    power = has_powers(f)

    def drift(z):
        x, y, px, py = z
        r2 = x * x + y * y
        w = r2**-1.5 if power else 1.0 / (r2 * f.sqrt(r2))
        return px, py, -w * x, -w * y

    return drift


def kepler_energy(f: Any) -> Callable[[State], Any]:
    return lambda z: 0.5 * (z[2] * z[2] + z[3] * z[3]) - 1.0 / f.sqrt(z[0] * z[0] + z[1] * z[1])


def perihelion(eccentricity: float) -> State:
    return 1.0 - eccentricity, 0.0, 0.0, sqrt((1.0 + eccentricity) / (1.0 - eccentricity))


def _oscillator(_: Any) -> Field:
    def drift(z):
        q, p = z
        return p, -q

    return drift


def _oscillator_kick(_: Any) -> Callable[[State, Sequence[Any]], State]:
    return lambda z, dw: (0.0, OSCILLATOR_SIGMA * dw[0])


def _oscillator_energy(_: Any) -> Callable[[State], Any]:
    return lambda z: 0.5 * (z[0] * z[0] + z[1] * z[1])


def _kubo(_: Any) -> Field:
    def drift(z):
        q, p = z
        return KUBO_A * p, -KUBO_A * q

    return drift


def _kubo_kick(_: Any) -> Callable[[State, Sequence[Any]], State]:
    return lambda z, dw: (KUBO_SIGMA * z[1] * dw[0], -KUBO_SIGMA * z[0] * dw[0])


def _square(_: Any) -> Callable[[State], Any]:
    return lambda z: z[0] * z[0] + z[1] * z[1]


def _position(_: Any) -> Callable[[State], Any]:
    return lambda z: z[0]


def _position_squared(_: Any) -> Callable[[State], Any]:
    return lambda z: z[0] * z[0]


def _synchrotron(f: Any) -> Field:
    def drift(z):
        q, p = z
        return p, -(SYNCHROTRON_OMEGA**2) * f.sin(q)

    return drift


def _synchrotron_kick(f: Any) -> Callable[[State, Sequence[Any]], State]:
    s1, s2 = SYNCHROTRON_SIGMA
    return lambda z, dw: (0.0, s1 * f.sin(z[0]) * dw[0] - s2 * f.cos(z[0]) * dw[1])


def _synchrotron_energy(f: Any) -> Callable[[State], Any]:
    return lambda z: 0.5 * z[1] * z[1] - SYNCHROTRON_OMEGA**2 * f.cos(z[0])


def _henon_heiles(_: Any) -> Field:
    def drift(z):
        x, y, px, py = z
        return px, py, -x - 2.0 * x * y, -y - x * x + y * y

    return drift


def _henon_heiles_kick(_: Any) -> Callable[[State, Sequence[Any]], State]:
    return lambda z, dw: (0.0, 0.0, HENON_HEILES_SIGMA * dw[0], HENON_HEILES_SIGMA * dw[1])


def _henon_heiles_energy(_: Any) -> Callable[[State], Any]:
    def energy(z):
        x, y, px, py = z
        return 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y * y * y / 3.0

    return energy


def _langevin(_: Any) -> Field:
    def drift(z):
        q, p = z
        return p, -4.0 * LANGEVIN_A * q * (q * q - 1.0) - LANGEVIN_NU * p

    return drift


def _langevin_kick(_: Any) -> Callable[[State, Sequence[Any]], State]:
    return lambda z, dw: (0.0, LANGEVIN_SIGMA * dw[0])


PROBLEMS = (
    Problem(
        "linear_oscillator",
        start=(1.0, 0.0),
        horizon=10.0,
        steps=powers(5, 10),
        drift=_oscillator,
        kick=_oscillator_kick,
        processes=1,
        paths=1000,
        observable=_oscillator_energy,
        additive=True,
        more_steps=powers(11, 13),
    ),
    Problem(
        "kubo",
        start=(1.0, 0.0),
        horizon=4.0,
        steps=powers(4, 11),
        drift=_kubo,
        kick=_kubo_kick,
        processes=1,
        paths=1000,
        invariant=_square,
        observable=_position,
    ),
    Problem(
        "synchrotron",
        start=(0.5, 0.0),
        horizon=8.0,
        steps=powers(4, 10),
        drift=_synchrotron,
        kick=_synchrotron_kick,
        processes=2,
        paths=300,
        observable=_synchrotron_energy,
    ),
    Problem(
        "henon_heiles",
        start=(0.0, 0.1, 0.35, 0.1),
        horizon=16.0,
        steps=powers(6, 11),
        drift=_henon_heiles,
        kick=_henon_heiles_kick,
        processes=2,
        paths=200,
        observable=_henon_heiles_energy,
        additive=True,
        more_steps=powers(12, 13),
    ),
    Problem(
        "langevin",
        start=(-1.0, 0.0),
        horizon=2.0,
        steps=powers(3, 9),
        drift=_langevin,
        kick=_langevin_kick,
        processes=1,
        paths=2000,
        observable=_position_squared,
        separable=False,
        additive=True,
        more_steps=powers(10, 11),
    ),
    Problem(
        "pendulum",
        start=(2.0, 0.0),
        horizon=2000.0,
        steps=doublings(24_000, 5),
        drift=pendulum,
        invariant=pendulum_energy,
        extrapolations=24_000,
    ),
    Problem(
        "double_pendulum",
        start=(2.0, 1.0, 0.0, 0.0),
        horizon=10.0,
        steps=doublings(544, 5),
        drift=double_pendulum,
        invariant=double_pendulum_energy,
        separable=False,
        extrapolations=400,
    ),
    Problem(
        "kepler",
        start=perihelion(ECCENTRICITY),
        horizon=2000.0 * pi,
        steps=doublings(98_760, 3),
        drift=kepler,
        invariant=kepler_energy,
    ),
    Problem(
        "quiet_henon_heiles",
        start=(0.0, 0.1, 0.35, 0.1),
        horizon=1000.0,
        steps=doublings(3440, 6),
        drift=_henon_heiles,
        invariant=_henon_heiles_energy,
        extrapolations=2000,
    ),
    Problem(
        "outer_solar_system",
        start=planets.POSITIONS + planets.MOMENTA,
        horizon=1e6,
        steps=doublings(4400, 4),
        drift=planets.drift,
        invariant=planets.energy,
        extrapolations=5000,
    ),
)
