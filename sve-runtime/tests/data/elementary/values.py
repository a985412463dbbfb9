#!/usr/bin/env python3
"""Values of elementary functions at fixed arguments, for the tests of `lanes/elementary`.

Input: optionally a number of random arguments a function and a directory. Output: a file a function beside this one. A record
is the arguments and the rounded value (doubles, little endian) and a signed byte, what is missing to the true value in units of
1/256 of the last place. Values come from mpmath with 50 digits or more where the argument is far from zero.
"""

import math
import random
import struct
import sys
from pathlib import Path

from mpmath import mp, mpf
import mpmath as m

mp.dps = 60
COUNT = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
FOLDER = Path(sys.argv[2] if len(sys.argv) > 2 else Path(__file__).parent)


def near(x, n=2):
    """A number and its neighbours."""
    out = [x]
    up = down = x
    for _ in range(n):
        up, down = math.nextafter(up, math.inf), math.nextafter(down, -math.inf)
        out += [up, down]
    return out


def uniform(a, b):
    return lambda r: r.uniform(a, b)


def scaled(low, high, signed=True):
    """Of any size between two powers of 2."""
    def draw(r):
        x = 2.0 ** r.uniform(low, high)
        return -x if signed and r.random() < 0.5 else x
    return draw


QUARTERS = [x for k in list(range(1, 40)) + [100, 12345, 65536, 160001] for x in near(float(k * mp.pi / 4))]
HALVES = [x for k in range(1, 30) for x in near(float((k + mpf(1) / 2) * m.log(2)), 1)]
ANGLES = ([uniform(-4, 4), uniform(-100, 100), scaled(-40, 17), uniform(-131072, 131072)], QUARTERS + [1e-300, 131072.0])
POWERS = ([uniform(-2, 2), uniform(-708, 708), scaled(-60, 9)], [0.0] + HALVES + [-x for x in HALVES])
LOGS = ([uniform(0.5, 2), scaled(-1021, 1023, False), uniform(0.0001, 30)],
        near(1.0, 4) + near(math.sqrt(2)) + near(math.sqrt(0.5)) + [2.0**k for k in range(-5, 6)]
        + [10.0**k for k in range(0, 23)] + [1 + 2.0**-k for k in range(2, 50)] + [1 - 2.0**-k for k in range(2, 50)])
UNIT = ([uniform(-1, 1), scaled(-60, 0), lambda r: 1 - 2.0 ** r.uniform(-50, -1)], near(0.5) + near(-0.5) + [-1 + 2.0**-k for k in range(1, 50)])
ARCS = ([uniform(-1, 1), uniform(-1, 1), scaled(-60, 0), lambda r: 1 - 2.0 ** r.uniform(-50, -1)], UNIT[1] + [1.0, -1.0])


def power_arguments(r):
    x = 2.0 ** r.uniform(-30, 30)
    return x, r.uniform(-1, 1) * min(700 / abs(math.log(x)), 1e6)


FUNCTIONS = {
    "sin": (m.sin, *ANGLES),
    "cos": (m.cos, *ANGLES),
    "tan": (m.tan, *ANGLES),
    "exp": (m.exp, *POWERS),
    "exp_m1": (m.expm1, *POWERS),
    "exp2": (lambda x: m.power(2, x), [uniform(-2, 2), uniform(-1021, 1021), scaled(-60, 9)],
             [float(k) for k in range(-10, 11)] + [x for k in range(-9, 9) for x in near(k + 0.5)]),
    "ln": (m.log, *LOGS),
    "log2": (lambda x: m.log(x, 2), *LOGS),
    "log10": (lambda x: m.log(x, 10), *LOGS),
    "ln_1p": (m.log1p, [uniform(-0.99, 2), scaled(-60, 0), scaled(0, 1023, False), lambda r: -1 + 2.0 ** r.uniform(-50, 0)],
              near(math.sqrt(2) - 1) + near(math.sqrt(0.5) - 1) + near(1.0) + [1e-300, -1e-300]),
    "sinh": (m.sinh, *POWERS),
    "cosh": (m.cosh, *POWERS),
    "tanh": (m.tanh, [uniform(-2, 2), uniform(-25, 25), scaled(-60, 4)], [0.0, 100.0, -1e300]),
    "asinh": (m.asinh, [uniform(-2, 2), uniform(-50, 50), scaled(-60, 490)], [1.0, -1.0]),
    "acosh": (m.acosh, [uniform(1, 2), uniform(1, 50), scaled(0, 490, False), lambda r: 1 + 2.0 ** r.uniform(-50, 0)], [1.0]),
    "atanh": (m.atanh, *UNIT),
    "asin": (m.asin, *ARCS),
    "acos": (m.acos, *ARCS),
    "atan": (m.atan, [uniform(-3, 3), uniform(-50, 50), scaled(-60, 300)],
             [x for s in (-1, 1) for y in (math.sqrt(2) - 1, 1.0, math.sqrt(2) + 1) for x in near(s * y)]),
    "cbrt": (lambda x: m.sign(x) * m.cbrt(abs(x)), [uniform(-8, 8), scaled(-1021, 1023)], [float(k**3) for k in range(-6, 7) if k]),
}


def pair(a, b):
    return lambda r: (a(r), b(r))


PAIRS = {
    "atan2": (lambda y, x: m.atan2(y, x), [pair(uniform(-2, 2), uniform(-2, 2)), pair(scaled(-300, 300), scaled(-300, 300))],
              [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (0.0, 2.0), (0.0, -2.0), (3.0, 0.0), (-3.0, 0.0)]),
    "hypot": (m.hypot, [pair(uniform(-2, 2), uniform(-2, 2)), pair(scaled(-300, 300), scaled(-300, 300))],
              [(3.0, 4.0), (0.0, 2.0), (-3.0, 0.0)]),
    "powf": (m.power, [pair(uniform(0.5, 2), uniform(-3, 3)), pair(uniform(0, 10), uniform(-10, 10)), power_arguments],
             [(1.0, 1e300), (2.0, 0.5), (4.0, 1.5), (9.0, -0.5), (8.0, 1 / 3), (3.0, 0.0), (1.5, 1.0)]
             + [(x, y) for x in near(1.0, 4) for y in (1e15, -1e15)]),
}


def record(function, arguments):
    mp.dps = 60
    exact = function(*map(mpf, arguments))
    value = float(exact)
    if value == 0:
        assert exact == 0, arguments
        rest = 0
    else:
        unit = mpf(2) ** (math.frexp(value)[1] - 53)
        rest = max(-128, min(127, int(m.nint((exact - mpf(value)) / unit * 256))))
    return struct.pack(f"<{len(arguments) + 1}db", *arguments, value, rest)


def main():
    for name, (function, draws, fixed) in {**FUNCTIONS, **PAIRS}.items():
        r = random.Random(name)
        drawn = [draws[i % len(draws)](r) for i in range(COUNT)]
        tuples = [a if isinstance(a, tuple) else (a,) for a in fixed + drawn]
        (FOLDER / f"{name}.bin").write_bytes(b"".join(record(function, a) for a in tuples))


main()
