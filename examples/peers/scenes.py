"""Steps of systems of many coordinates by other programs, in turn with those of sve, on one thread in 64 bits.

A chain with springs of the force d + 0.7 d³ and free ends, and the φ⁴ field on a square lattice with open borders, of 10², 10⁴ and 10⁶ coordinates, by
the rule of Störmer and Verlet with h = 0.05: as half a kick, drifts and kicks in turn, and half a kick less at the end, which are two loops over the
coordinates a step and one pass over the forces. numba compiles the loops, JAX the same formulas for whole arrays. Starts and steps are those of
`cargo run --release --example cost_per_coordinate -- serve`, which makes sve's steps in the same turns. First the energy and a coordinate after 200 steps
are compared; status 1 where they differ. Then each turn measures the processor time of all programs, one after the other.

heyoka has no such rule: its Taylor series with the tolerance 1e-9 solve the chain of 100 to the same time. This compares times, not methods.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from statistics import median
from time import process_time

import numpy as np
from run import one_core
from served import Served

BETA, H = 0.7, 0.05
SIZES = (100, 10_000, 1_000_000)
COMPARED = 200
TURNS = 11
SLICE = 0.05
"""The least time of a program in a turn, in seconds."""

Array = np.ndarray
Steps = Callable[[Array, Array, int], tuple[Array, Array]]
"""From positions, momenta at the same time and a number of steps to those after the steps."""


def start(n: int) -> tuple[Array, Array]:
    """Displacements without order, at rest."""
    return 0.5 * np.sin(np.arange(n) * 12.9898), np.zeros(n)


def sides(n: int) -> tuple[int, int]:
    """Rows and columns of a lattice, which is nearly square."""
    rows = max(r for r in range(1, int(n**0.5) + 1) if n % r == 0)
    return rows, n // rows


def energy(system: str, q: Array, p: Array) -> float:
    """The energy by numpy."""
    kinetic = 0.5 * np.sum(p * p)
    if system == "chain":
        d = np.diff(q)
        return kinetic + np.sum(0.5 * d * d + 0.25 * BETA * d**4)
    x = q.reshape(sides(len(q)))
    springs = np.sum(np.diff(x, axis=0) ** 2) + np.sum(np.diff(x, axis=1) ** 2)
    return kinetic + 0.25 * np.sum((q * q - 1.0) ** 2) + 0.5 * springs


def numba_steps(system: str, n: int) -> Steps:
    """Loops over the coordinates, of which the ends and borders are apart."""
    import numba

    jit = numba.njit(error_model="numpy")

    @jit
    def spring(d):
        return d + BETA * d * d * d

    @jit
    def kick_chain(q, p, h):
        p[0] += h * spring(q[1] - q[0])
        for i in range(1, len(q) - 1):
            p[i] += h * (spring(q[i + 1] - q[i]) - spring(q[i] - q[i - 1]))
        p[-1] -= h * spring(q[-1] - q[-2])

    rows, columns = sides(n)

    @jit
    def site(q, p, h, i, j):
        c = i * columns + j
        x = q[c]
        f = -x * (x * x - 1.0)
        if i > 0:
            f += q[c - columns] - x
        if i + 1 < rows:
            f += q[c + columns] - x
        if j > 0:
            f += q[c - 1] - x
        if j + 1 < columns:
            f += q[c + 1] - x
        p[c] += h * f

    @jit
    def kick_lattice(q, p, h):
        for j in range(columns):
            site(q, p, h, 0, j)
            site(q, p, h, rows - 1, j)
        for i in range(1, rows - 1):
            site(q, p, h, i, 0)
            site(q, p, h, i, columns - 1)
            for c in range(i * columns + 1, (i + 1) * columns - 1):
                x = q[c]
                f = -x * (x * x - 1.0) + (q[c + columns] - x) + (q[c - columns] - x) + (q[c + 1] - x) + (q[c - 1] - x)
                p[c] += h * f

    kick = kick_chain if system == "chain" else kick_lattice

    @jit
    def steps(q, p, count):
        kick(q, p, 0.5 * H)
        for step in range(count):
            for i in range(len(q)):
                q[i] += H * p[i]
            kick(q, p, H if step + 1 < count else 0.5 * H)

    def run(q: Array, p: Array, count: int) -> tuple[Array, Array]:
        steps(q, p, count)
        return q, p

    return run


def jax_steps(system: str, n: int) -> Steps:
    """Formulas for whole arrays in a compiled loop, which XLA turns into loops over the coordinates."""
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    def between(differences, axis):
        """What springs give to both of their ends."""
        pad = lambda ends: jnp.pad(differences, [ends if k == axis else (0, 0) for k in range(differences.ndim)])  # noqa: E731
        return pad((0, 1)) - pad((1, 0))

    def chain(q):
        d = q[1:] - q[:-1]
        return between(d + BETA * d * d * d, 0)

    def lattice(q):
        x = q.reshape(sides(n))
        f = -x * (x * x - 1.0) + between(x[1:] - x[:-1], 0) + between(x[:, 1:] - x[:, :-1], 1)
        return f.reshape(n)

    force = chain if system == "chain" else lattice

    @jax.jit
    def steps(q, p, count):
        def step(_, state):
            q, p = state
            q = q + H * p
            return q, p + H * force(q)

        q, p = jax.lax.fori_loop(0, count, step, (q, p + 0.5 * H * force(q)))
        return q, p - 0.5 * H * force(q)

    def run(q: Array, p: Array, count: int) -> tuple[Array, Array]:
        return jax.block_until_ready(steps(q, p, count))

    return run


PROGRAMS = {"numba": numba_steps, "jax": jax_steps}


class Sve(Served):
    """The steps of sve, in a process of its own."""

    def run(self, steps: int) -> tuple[float, float, float]:
        """Seconds of the processor for the steps, the energy after them, and a coordinate."""
        seconds, *values = map(float, self.ask(steps))
        return seconds, *values


@dataclass
class Peer:
    """A program with its state."""

    steps: Steps
    q: Array
    p: Array

    def run(self, count: int) -> float:
        """Makes steps; seconds of the processor, of all threads."""
        begin = process_time()
        self.q, self.p = self.steps(self.q, self.p, count)
        return process_time() - begin


def enough(run: Callable[[int], float], n: int) -> int:
    """A number of steps that takes long enough for a turn; what is compiled was called before."""
    count = max(1, 1_000_000 // n)
    while run(count) < SLICE:
        count *= 2
    return count


def compare(system: str, n: int) -> bool:
    """Compares results, then measures. Prints a line for each program; false, without times, where a result is off."""
    sve = Sve("cost_per_coordinate", "serve", system, n, H)
    _, expected, coordinate = sve.run(COMPARED)
    peers, good = {}, True
    for name, make in PROGRAMS.items():
        peer = Peer(make(system, n), *start(n))
        peer.run(COMPARED)
        q, p = np.asarray(peer.q), np.asarray(peer.p)
        off = (abs(energy(system, q, p) / expected - 1.0), abs(q[n // 3] - coordinate))
        if not max(off) < 1e-10:
            print(f"{system} of {n}, {name}: energy and coordinate differ by {off}")
            good = False
        peers[name] = peer
    if not good:
        sve.close()
        return False
    runs = {"sve": lambda count: sve.run(count)[0]} | {name: peer.run for name, peer in peers.items()}
    counts = {name: enough(run, n) for name, run in runs.items()}
    times = {name: [] for name in runs}
    for _ in range(TURNS):
        for name, run in runs.items():
            times[name].append(1e9 * run(counts[name]) / (counts[name] * n))
    for name, own in times.items():
        label = name if name == "sve" else f"{name} {version(name)}"
        ratios = sorted(time / base for time, base in zip(own, times["sve"], strict=True))
        print(
            f"{system} | {n} | {label} | {median(own):.3f} ns a coordinate and step"
            f" | over sve {median(ratios):.2f}, from {ratios[0]:.2f} to {ratios[-1]:.2f}",
            flush=True,
        )
    sve.close()
    return True


def heyoka_chain(n: int = 100, until: float = 100.0) -> None:
    """The chain by Taylor series, in turn with sve's steps to the same time."""
    import heyoka as hy

    names = [hy.make_vars(f"q{i}", f"p{i}") for i in range(n)]
    springs = [b - a for (a, _), (b, _) in zip(names, names[1:], strict=False)]
    springs = [d + BETA * d**3 for d in springs]
    equations = []
    for i, (q, p) in enumerate(names):
        right = springs[i] if i + 1 < n else 0.0
        left = springs[i - 1] if i > 0 else 0.0
        equations += [(q, p), (p, right - left)]
    q, p = start(n)
    series = hy.taylor_adaptive(equations, np.stack([q, p], axis=1).ravel(), tol=1e-9, compact_mode=True)
    sve, ratios, own = Sve("cost_per_coordinate", "serve", "chain", n, H), [], []
    for turn in range(1, TURNS + 1):
        begin = process_time()
        series.propagate_until(turn * until)
        own.append(process_time() - begin)
        ratios.append(own[-1] / sve.run(round(until / H))[0])
    q, p = series.state.reshape(n, 2).T
    error = abs(energy("chain", q, p) / energy("chain", *start(n)) - 1.0)
    ratios.sort()
    print(
        f"chain | {n} | heyoka {version('heyoka')}, Taylor series, not the same rule | {1e3 * median(own):.1f} ms to t = {until:g}"
        f" | over sve {median(ratios):.0f}, from {ratios[0]:.0f} to {ratios[-1]:.0f} | energy error {error:.0e}"
    )
    sve.close()


def main() -> int:
    """Runs all; 1 where a result is off."""
    one_core()
    good = [compare(system, n) for system in ("chain", "lattice") for n in SIZES]
    heyoka_chain()
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
