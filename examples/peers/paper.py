"""Numbers that `cargo run --release --example paper` compares with, computed apart from it: `python3 examples/peers/paper.py`.

Needs Python alone. The text whose figures that example draws prints no numbers for them; these follow from its schemes.
"""

from math import cos, sin

G, H, STEPS = 9.8, 0.1, 20_000
"""Gravity, the step size, and the steps to t = 2000."""


def taylor_rule(q: float, p: float) -> tuple[float, float]:
    """A step of the second-order Taylor variational integrator for L = v²/2 + g cos q.

    S_d = ½h [L(q₀, v) + L(q₀ + hv, v + ha)] with a = −g sin q₀ and v from q₁ = q₀ + hv + ½h²a; p₀ = −∂S_d/∂q₀, p₁ = ∂S_d/∂q₁.
    """
    a, slope = -G * sin(q), -G * cos(q)
    # ∂v/∂q₀, ∂v/∂q₁, ∂(v + ha)/∂q₀
    v0, v1 = -1 / H - 0.5 * H * slope, 1 / H
    w0 = v0 + H * slope
    end = q + H * p
    for _ in range(50):
        v = (end - q) / H - 0.5 * H * a
        x = q + H * v
        residual = p + 0.5 * H * (v * v0 - G * sin(q) + (v + H * a) * w0 - G * sin(x) * (1 + H * v0))
        derivative = 0.5 * H * (v1 * v0 + v1 * w0 - G * cos(x) * H * v1 * (1 + H * v0))
        change = residual / derivative
        end -= change
        if abs(change) < 1e-14:
            break
    v = (end - q) / H - 0.5 * H * a
    return end, 0.5 * H * (v * v1 + (v + H * a) * v1 - G * sin(q + H * v) * H * v1)


def taylor_method(q: float, p: float) -> tuple[float, float]:
    """A step of the second-order Taylor series of the pendulum."""
    return q + H * p - 0.5 * H * H * G * sin(q), p - H * G * sin(q) - 0.5 * H * H * G * cos(q) * p


def pendulum(q: float, p: float) -> float:
    """The pendulum's energy."""
    return 0.5 * p * p - G * cos(q)


def mean_energies(matrix: tuple, kick: tuple) -> list[float]:
    """E[(q² + p²)/2] at t = 10, 100, 2000 for z₁ = A z₀ + b ΔW from (1, 0): M₁ = A M₀ Aᵀ + h b bᵀ."""
    (a, b), (c, d) = matrix
    m = (1.0, 0.0, 0.0)
    energies = []
    for step in range(1, STEPS + 1):
        qq, qp, pp = m
        m = (
            a * a * qq + 2 * a * b * qp + b * b * pp + H * kick[0] ** 2,
            a * c * qq + (a * d + b * c) * qp + b * d * pp + H * kick[0] * kick[1],
            c * c * qq + 2 * c * d * qp + d * d * pp + H * kick[1] ** 2,
        )
        if step in (100, 1000, STEPS):
            energies.append(0.5 * (m[0] + m[2]))
    return energies


def main() -> None:
    """Prints the numbers."""
    for start in (0.5, 1.5, 2.5):
        z, largest = (start, 0.0), 0.0
        for _ in range(STEPS):
            z = taylor_rule(*z)
            largest = max(largest, abs(pendulum(*z) - pendulum(start, 0.0)))
        print(f"Taylor rule from q = {start}: largest energy deviation {largest:.6g}")
    z = (1.0, 0.0)
    for step in range(1, STEPS + 1):
        z = taylor_method(*z)
        if step in (2000, STEPS):
            print(f"Taylor method from q = 1: energy at t = {step * H:g}: {pendulum(*z):.6g}")
    backward, middle = 1 / (1 + H * H), 1 / (1 + H * H / 4)
    turn = (1 - H * H / 4) * middle
    schemes = {
        "forward Euler–Maruyama": (((1, H), (-H, 1)), (0, 1)),
        "backward Euler–Maruyama": (((backward, H * backward), (-H * backward, backward)), (H * backward, backward)),
        "midpoint rule": (((turn, H * middle), (-H * middle, turn)), (H / 2 * middle, middle)),
        "initial-point rule": (((1 - H * H, H), (-H, 1)), (H, 1)),
        "endpoint rule": (((1, H), (-H, 1 - H * H)), (0, 1)),
    }
    for name, scheme in schemes.items():
        print(f"{name}: mean energy at t = 10, 100, 2000:", *(f"{energy:.15g}" for energy in mean_energies(*scheme)))


if __name__ == "__main__":
    main()
