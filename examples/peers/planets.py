"""The outer solar system: the same masses and start as in `examples/examples/work_precision/planets.rs`, and its equations.

In order: the Sun with the inner planets, Jupiter, Saturn, Uranus, Neptune, Pluto.
"""

from typing import Any

GRAVITY = 2.95912208286e-4
MASSES = (1.00000597682, 0.000954786104043, 0.000285583733151, 0.0000437273164546, 0.0000517759138449, 1.0 / 1.3e8)
POSITIONS = (
    -0.0002047098298789105, 0.006550139855052495, 0.002824833990245127,
    -3.502570009829879, -3.810434560144947, -1.547971466009755,
    9.07532669017012, -3.039285160144947, -1.645545966009755,
    8.309937290170122, -16.28355846014495, -7.249302966009755,
    11.47056189017012, -25.72293276014495, -10.814120766009756,
    -15.538940409829879, -25.21600926014495, -3.187413366009755,
)
MOMENTA = (
    -6.175566546254882e-6, 2.435040255532255e-6, 1.2238468856011928e-6,
    5.39274121034752e-6, -3.936072271863883e-6, -1.818548782818609e-6,
    4.789251971574021e-7, 1.3815641494486178e-6, 5.499896731705224e-7,
    1.5460249553389518e-7, 6.005750254502434e-8, 2.411622019200966e-8,
    1.4927640418167772e-7, 5.942347653009628e-8, 2.060649474842555e-8,
    2.123903438741365e-11, -1.3112192109985985e-11, -1.049089354176206e-11,
)

BODIES = range(len(MASSES))
AXES = "xyz"


def source() -> str:
    """The function `drift` as straight-line code: numba has no loops that make tuples."""
    q = [f"q{b}{a}" for b in BODIES for a in AXES]
    p = [f"p{b}{a}" for b in BODIES for a in AXES]
    lines = ["def drift(z):", f"    {', '.join(q + p)} = z"]
    terms = {(b, a): [] for b in BODIES for a in AXES}
    for b in BODIES:
        for c in range(b):
            lines += [f"    d{a} = q{b}{a} - q{c}{a}" for a in AXES]
            lines += ["    r2 = dx * dx + dy * dy + dz * dz", f"    w = {GRAVITY * MASSES[b] * MASSES[c]!r} / (r2 * sqrt(r2))"]
            for a in AXES:
                lines.append(f"    f{b}_{c}{a} = w * d{a}")
                terms[b, a].append(f"- f{b}_{c}{a}")
                terms[c, a].append(f"+ f{b}_{c}{a}")
    rates = [f"p{b}{a} / {MASSES[b]!r}" for b in BODIES for a in AXES]
    forces = [" ".join(terms[b, a]).removeprefix("+ ") for b in BODIES for a in AXES]
    lines.append(f"    return {', '.join(rates + forces)}")
    return "\n".join(lines)


def drift(f: Any) -> Any:
    """The equations of motion of (q, p)."""
    names = {"sqrt": f.sqrt}
    exec(source(), names)  # noqa: S102
    return names["drift"]


def energy(f: Any) -> Any:
    """The energy of (q, p)."""

    def value(z):
        q, p = z[:18], z[18:]
        total = 0.0
        for b in BODIES:
            total = total + sum(x * x for x in p[3 * b : 3 * b + 3]) / (2.0 * MASSES[b])
            for c in range(b):
                r2 = sum((q[3 * b + a] - q[3 * c + a]) * (q[3 * b + a] - q[3 * c + a]) for a in range(3))
                total = total - GRAVITY * MASSES[b] * MASSES[c] / f.sqrt(r2)
        return total

    return value
