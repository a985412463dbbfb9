"""Writes rigid_body.json: steps of rigid bodies, from the discrete action alone.

The action of a step from R0 to R1 = R0 exp(x) is, with a mean over the nodes Rm,

    S(R0, R1) = h L(Rm, w) + <m, x - h w> + sum g(Rm) dW - sum H1(m) dW,

stationary in w and m. The midpoint rule has the node R0 exp(x/2), that of Stoermer and Verlet the
nodes R0 and R1. The momenta are its derivatives by the ends, Pi0 = -dS/de0 for R0 exp(e0) and
Pi1 = dS/de1 for R1 exp(e1), by central differences: no formula of the equations of a step is used.
All is computed with 80 digits, where differences keep 40; the result is rounded to f64.

    python3 rigid_body.py > rigid_body.json
"""

import json

from mpmath import cos, matrix, mp, mpf, sin, sqrt

mp.dps = 80
DELTA = mpf(10) ** -20


def cross(a, b):
    return matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def product(a, b):
    """The product of two quaternions."""
    u, v = matrix(a[1:]), matrix(b[1:])
    vector = a[0] * v + b[0] * u + cross(u, v)
    return [a[0] * b[0] - dot(u, v), *vector]


def exponential(x):
    """The quaternion of a rotation vector."""
    angle = sqrt(dot(x, x))
    if angle == 0:
        return [mpf(1), mpf(0), mpf(0), mpf(0)]
    return [cos(angle / 2), *(sin(angle / 2) / angle * x)]


def logarithm(q):
    """The rotation vector of a quaternion with a positive first number."""
    sine = sqrt(dot(q[1:], q[1:]))
    angle = 2 * mp.atan2(sine, q[0])
    return matrix(q[1:]) * (2 if sine == 0 else angle / sine)


def inverse(q):
    return [q[0], -q[1], -q[2], -q[3]]


def turned(q, a):
    """The image of a vector of the body."""
    return matrix(product(product(q, [0, *a]), inverse(q))[1:])


class Body:
    """L = sum I w^2/2 - V, noises g(R) and H1(R, m)."""

    def __init__(self, inertia, weight=0, chi=None, k=None, lean=0):
        self.inertia, self.weight = [mpf(i) for i in inertia], mpf(weight)
        self.chi = chi and [mpf(c) for c in chi]
        self.k = k and [mpf(c) for c in k]
        self.lean = mpf(lean)

    def potential(self, r):
        return self.weight * turned(r, [0, 0, 1])[2]

    def gammas(self, r):
        return [self.lean * turned(r, [1, 0, 0])[0]] if self.lean else []

    def h1(self, m):
        if not self.chi:
            return []
        return [dot(self.chi, m), sum(k * x * x for k, x in zip(self.k, m)) / 2]

    def d_h1(self, m):
        if not self.chi:
            return []
        return [matrix(self.chi), matrix([k * x for k, x in zip(self.k, m)])]


def action(body, rule, r0, r1, h, dw):
    """S, at the w and m in which it is stationary: w = m/I and x = h m/I + sum dH1/dm dW."""
    x = logarithm(product(inverse(r0), r1))
    count = len(body.gammas(r0))
    shifts = dw[count:]
    if shifts:
        m = [(x[i] - body.chi[i] * shifts[0]) / (h / body.inertia[i] + body.k[i] * shifts[1]) for i in range(3)]
    else:
        m = [x[i] * body.inertia[i] / h for i in range(3)]
    w = [m[i] / body.inertia[i] for i in range(3)]
    nodes = [product(r0, exponential(x / 2))] if rule == "midpoint" else [r0, r1]
    potential = sum(body.potential(node) for node in nodes) / len(nodes)
    value = h * (sum(i * a * a for i, a in zip(body.inertia, w)) / 2 - potential)
    value += sum(m[i] * (x[i] - h * w[i]) for i in range(3))
    for node in nodes:
        value += sum(g * d for g, d in zip(body.gammas(node), dw)) / len(nodes)
    value -= sum(g * d for g, d in zip(body.h1(m), shifts))
    return value


def momentum(body, rule, r0, r1, h, dw, end):
    """The derivative of S by a turn of one end, from differences of order six."""
    result = []
    for k in range(3):
        total = mpf(0)
        for j, weight in ((1, mpf(3) / 4), (2, mpf(-3) / 20), (3, mpf(1) / 60)):
            for sign in (1, -1):
                e = matrix([0, 0, 0])
                e[k] = sign * j * DELTA
                turn = exponential(e)
                ends = [product(r0, turn), r1] if end == 0 else [r0, product(r1, turn)]
                total += sign * weight * action(body, rule, *ends, h, dw)
        result.append(total / DELTA)
    return matrix(result)


def step(body, rule, r, p, h, dw):
    def residual(x):
        return -momentum(body, rule, r, product(r, exponential(x)), h, dw, 0) - p

    x = matrix([h * p[i] / body.inertia[i] for i in range(3)])
    if body.chi:
        x += sum((d * w for d, w in zip(body.d_h1(p), dw[len(body.gammas(r)) :])), matrix([0, 0, 0]))
    # Newton's method with differences: the error falls by their size in each iteration
    for _ in range(20):
        f = residual(x)
        if mp.norm(f) < mpf(10) ** -42:
            break
        jacobian = matrix(3, 3)
        for k in range(3):
            moved = x.copy()
            moved[k] += mpf(10) ** -20
            column = (residual(moved) - f) * mpf(10) ** 20
            for i in range(3):
                jacobian[i, k] = column[i]
        x -= mp.lu_solve(jacobian, f)
    else:
        raise ValueError("no convergence")
    end = product(r, exponential(x))
    return end, momentum(body, rule, r, end, h, dw, 1)


def run(params, start, h, dw, body, rule="midpoint"):
    r, p = [mpf(a) for a in start[:4]], matrix(start[4:])
    states = [[float(a) for a in (*r, *p)]]
    for increments in dw:
        r, p = step(body, rule, r, p, mpf(h), [mpf(w) for w in increments])
        states.append([float(a) for a in (*r, *p)])
    return {
        "system": "rigid_body",
        "rule": rule,
        "params": params,
        "h": h,
        "n": 3,
        "noises": len(dw[0]),
        "dw": dw,
        "states": states,
    }


def increments(count, size, steps=40):
    """Fixed numbers between -size and size."""
    return [[size * ((7919 * (2 * k + 3 * i + 1) % 1009) / 504.5 - 1) for i in range(count)] for k in range(steps)]


def main():
    start = [1.0, 0.0, 0.0, 0.0, 0.7, 1.1, -0.4]
    free, chi, k = [1.0, 2.0, 3.0], [0.3, -0.2, 0.5], [0.5, 0.2, -0.3]
    top, weight, lean = [0.8, 1.1, 0.6], 2.0, 0.5
    runs = [
        run({"I": free}, start, 0.05, increments(0, 0), Body(free)),
        run({"I": free, "chi": chi, "K": k}, start, 0.05, increments(2, 0.4), Body(free, chi=chi, k=k)),
        run({"I": free}, start, 2.0, increments(0, 0, 12), Body(free)),
        run({"I": top, "weight": weight, "s": lean}, start, 0.1, increments(1, 0.3), Body(top, weight, lean=lean)),
        run({"I": free}, start, 0.3, increments(0, 0, 20), Body(free), "stormer_verlet"),
        run(
            {"I": top, "weight": weight, "s": lean},
            start,
            0.1,
            increments(1, 0.3),
            Body(top, weight, lean=lean),
            "stormer_verlet",
        ),
    ]
    print(json.dumps(runs))


main()
