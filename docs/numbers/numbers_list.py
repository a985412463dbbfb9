"""The published numbers: for each its name, the command that prints it, and how it is found in what the command prints or writes."""

import csv
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import exp, log
from pathlib import Path
from statistics import median


@dataclass(frozen=True)
class Output:
    """What a command printed, and the root of the project with the folder of the files that it wrote."""

    text: str
    root: Path
    folder: str = "target/work-precision"

    def records(self, path: str, **wanted: str) -> list[dict[str, str]]:
        """The lines of a CSV file in which the columns have these values."""
        with (self.root / self.folder / path).open(encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if all(row[k] == v for k, v in wanted.items())]
        if not rows:
            raise LookupError(f"no {wanted} in {path}")
        return rows


Extract = Callable[[Output], str]


@dataclass(frozen=True)
class Number:
    """A published number."""

    name: str
    what: str
    extract: Extract


@dataclass(frozen=True)
class Command:
    """A command, about how long it runs on a quiet machine once compiled, and its numbers."""

    name: str
    line: str
    seconds: int
    numbers: list[Number]


def short(x: float, digits: int = 2) -> str:
    """A number with so many digits: 0.97, 5.4, 57, 1126."""
    if x == 0.0:
        return "0"
    if not 1e-2 <= abs(x) < 1e5:
        return f"{x:.{digits - 1}e}".replace("e-0", "e-").replace("e+0", "e")
    decimals = max(0, digits - 1 - int(f"{x:e}".split("e")[1]))
    return f"{x:.{decimals}f}"


def time(seconds: float) -> str:
    """A time with a unit."""
    for unit, size in (("ns", 1e-9), ("µs", 1e-6), ("ms", 1e-3)):
        if seconds < 999.5 * size:
            return f"{short(seconds / size)} {unit}"
    return f"{short(seconds)} s"


def find(output: Output, pattern: str) -> re.Match[str]:
    """The first match."""
    match = re.search(pattern, output.text, re.M)
    if match is None:
        raise LookupError(pattern)
    return match


def text(pattern: str) -> Extract:
    """The group of a pattern as it is printed."""
    return lambda output: find(output, pattern).group(1)


def value(pattern: str, digits: int = 2) -> Extract:
    """The group of a pattern as a number with so many digits."""
    return lambda output: short(float(find(output, pattern).group(1)), digits)


def radius(output: Output) -> str:
    """The radius that corrected Euler–Maruyama ends at, as a power of ten."""
    exponent = f"{float(find(output, r'ln radius at the horizon +([0-9.]+)').group(1)) / log(10.0):.0f}"
    return "10" + exponent.translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))


# tables of the two benchmarks: task, by, ns, …


def nanoseconds(task: str, by: str) -> Callable[[Output], float]:
    """The median time of a side of a task."""
    pattern = rf"^{re.escape(task)} +{re.escape(by)} +([\d.]+)"
    return lambda output: float(find(output, pattern).group(1))


def side(task: str, by: str) -> Extract:
    """That time."""
    return lambda output: short(nanoseconds(task, by)(output))


def over(task: str, by: str, other: str) -> Extract:
    """The ratio of the times of two sides."""
    return lambda output: f"{nanoseconds(task, by)(output) / nanoseconds(task, other)(output):.2f}"


# the example `work_precision`


def fastest(problem: str, what: str, method: str, group: int) -> Extract:
    """Where a method is the fastest: 1 the largest error, 2 the smallest, 3 the time for the largest, 4 for the smallest."""
    pattern = rf"^{problem} \| For {what}[^:]*:.*?from (\S+) to (\S+) (?:{method}) \((.*?) to (.*?)\)"
    return lambda output: find(output, pattern).group(group)


def time_to(problem: str, method: str, error: float) -> Extract:
    """The time to an error on the straight line, in logarithms, between the measured points beside it."""

    def extract(output: Output) -> str:
        rows = output.records(f"{problem}.csv", method=method)
        points = [(float(r["error"]), float(r["time_to_solution_s"])) for r in rows]
        for (e0, t0), (e1, t1) in zip(points, points[1:], strict=False):
            if min(e0, e1) <= error <= max(e0, e1):
                return time(exp(log(t0) + log(t1 / t0) * log(error / e0) / log(e1 / e0)))
        raise LookupError(f"{method} does not reach {error} for {problem}")

    return extract


def reduced(problem: str, method: str, column: str, reduce: Callable[[list[float]], float], digits: int = 1) -> Extract:
    """The largest, the last … of a column over the step sizes."""
    return lambda output: short(
        reduce([float(r[column]) for r in output.records(f"{problem}.csv", method=method) if r[column]]), digits
    )


Points = list[tuple[float, float]]

BASELINES = ("Heun", "Runge–Kutta 4", "Taylor series 2", "Euler", "Euler–Maruyama", "backward Euler–Maruyama")
"""The methods of the example that are not derived."""
PROGRAMS = ("numba", "heyoka", "scipy", "diffrax")


def lasting(points: Points) -> Points:
    """Times, with the larger error of each point and the next finer one: an error that is small by chance does not count."""
    return [(t, max(e, finer)) for (t, e), (_, finer) in zip(points, points[1:] + points[-1:], strict=True)]


def least_time(points: Points, error: float) -> float | None:
    """The least time to an error, on straight lines in logarithms between the points."""
    points = lasting(points)
    times = [t for t, e in points if e <= error]
    for (t0, e0), (t1, e1) in zip(points, points[1:], strict=False):
        if min(e0, e1) < error <= max(e0, e1):
            times.append(exp(log(t0) + log(t1 / t0) * log(error / e0) / log(e1 / e0)))
    return min(times, default=None)


def strong_error(row: dict[str, str]) -> float | None:
    """The error at the end."""
    return float(row["error"]) if row["error"] else None


def weak_error(row: dict[str, str]) -> float | None:
    """The error of the mean, or two standard errors where they are more."""
    return max(abs(float(row["weak_error"])), 2.0 * float(row["weak_error_se"])) if row["weak_error"] and row["weak_error_se"] else None


def curves(output: Output, problem: str, error: Callable = strong_error) -> dict[tuple[str, str], Points]:
    """Times and errors by program and method; of programs that were run."""
    found: dict[tuple[str, str], Points] = {}
    for program in ("sve", *PROGRAMS):
        path = f"{problem}.csv" if program == "sve" else f"peers/{program}_{problem}.csv"
        try:
            rows = output.records(path)
        except (OSError, LookupError):
            continue
        for row in rows:
            if (e := error(row)) is not None and row["time_to_solution_s"]:
                found.setdefault((program, row["method"]), []).append((float(row["time_to_solution_s"]), e))
    return found


def contest(output: Output, problem: str, at: float, error: Callable = strong_error) -> tuple:
    """The fastest derived rule and the fastest of all else to an error: (time, program, method) of each, or nothing."""
    best: list = [None, None]
    for (program, method), points in curves(output, problem, error).items():
        is_rule = program == "sve" and method not in BASELINES and not method.endswith("uncorrected")
        needed = least_time(points, at)
        place = 0 if is_rule else 1
        if needed is not None and (best[place] is None or needed < best[place][0]):
            best[place] = (needed, program, method)
    return tuple(best)


def winner(problem: str, at: float, error: Callable = strong_error) -> Extract:
    """The fastest rule with its time, and how many times longer the fastest of all else takes, or that nothing else gets there."""

    def extract(output: Output) -> str:
        own, other = contest(output, problem, at, error)
        if own is None:
            return "–"
        factor = f"{other[0] / own[0]:.1f}" if other else "–"
        return f"{own[2]} {time(own[0])} ({factor})"

    return extract


def rival(problem: str, at: float, error: Callable = strong_error) -> Extract:
    """The fastest of all else with its time."""

    def extract(output: Output) -> str:
        _, other = contest(output, problem, at, error)
        return f"{other[2]} of {other[1]}, {time(other[0])}" if other else "–"

    return extract


def ratio_to(problem: str, method: str, program: str, at: float) -> Extract:
    """The least time of a program over that of a method."""

    def extract(output: Output) -> str:
        all_curves = curves(output, problem)
        own = least_time(all_curves["sve", method], at)
        others = [least_time(points, at) for (by, _), points in all_curves.items() if by == program]
        return f"{min(t for t in others if t is not None) / own:.1f}"

    return extract


def floor(problem: str, method: str) -> Extract:
    """The smallest error of a method."""
    return lambda output: short(min(e for _, e in lasting(curves(output, problem)["sve", method])), 1)


def against_numba(problem: str) -> Callable[[Output], float]:
    """A derived midpoint step over one written by hand in numba: the medians over the step sizes."""

    def ratio(output: Output) -> float:
        ns = [
            median(float(r["ns_per_step"]) for r in output.records(path, method="midpoint"))
            for path in (f"{problem}.csv", f"peers/numba_{problem}.csv")
        ]
        return ns[0] / ns[1]

    return ratio


PROBLEMS = ("linear_oscillator", "kubo", "synchrotron", "henon_heiles", "langevin", "pendulum", "double_pendulum", "kepler")


def numba_range(reduce: Callable, output: Output) -> str:
    """Over the problems but Kubo's."""
    return f"{reduce(against_numba(problem)(output) for problem in PROBLEMS if problem != 'kubo'):.2f}"


QUIET = {
    "pendulum": "pendulum",
    "double": "double_pendulum",
    "kepler": "kepler",
    "henon": "quiet_henon_heiles",
    "planets": "outer_solar_system",
}
"""Problems without noise, by the names of their numbers."""
NOISY = {"synchrotron": "synchrotron", "henon": "henon_heiles", "langevin": "langevin"}


def contests() -> list[Number]:
    """The fastest rules, and by how much."""
    numbers = []
    for key, problem in QUIET.items():
        for k in (2, 4, 6, 8, 10):
            at = 10.0**-k
            what = f"{problem}, error 1e-{k}: the fastest rule"
            numbers.append(Number(f"wp.{key}.{k}", f"{what}, its time, and the time of the fastest of all else over it", winner(problem, at)))
            numbers.append(Number(f"wp.{key}.{k}.other", f"{problem}, error 1e-{k}: the fastest of all else", rival(problem, at)))
        numbers.append(Number(f"wp.{key}.floor", f"{problem}: smallest error of Gauss 8 with compensated sums", floor(problem, "Gauss 8, compensated")))
    for key, problem in NOISY.items():
        for name, error, levels in (("strong", strong_error, (2, 3)), ("weak", weak_error, (2, 3))):
            for k in levels:
                what = f"{problem}, {name} error 1e-{k}: the fastest"
                numbers.append(Number(f"wp.noisy.{key}.{name}.{k}", f"{what} rule, likewise", winner(problem, 10.0**-k, error)))
                numbers.append(Number(f"wp.noisy.{key}.{name}.{k}.other", f"{what} of all else", rival(problem, 10.0**-k, error)))
    return numbers


ORDER_3 = {"oscillator": "linear_oscillator", "henon": "henon_heiles", "langevin": "langevin"}
"""Problems with additive noise, by the names of their numbers."""
ORDER_3_FOLDER = "target/order-3"
STAGE_NOISE = tuple(f"Gauss {stages}, stage noise" for stages in (2, 3, 4))
WITH_AREAS, LANGEVIN = ("SPaRK", "ShARK"), ("ALIGN", "ShOULD", "QUICSORT")
"""Methods of diffrax that know areas of the noise: for any additive noise, and for Langevin dynamics."""
ONE, MANY = "peers/diffrax_{}.csv", "peers/batch/diffrax_{}.csv"


def ordered(output: Output, path: str, chosen: Callable[[str], bool]) -> dict[str, list[dict[str, str]]]:
    """The lines of the chosen methods, from the longest step to the shortest."""
    found: dict[str, list[dict[str, str]]] = {}
    for row in replace(output, folder=ORDER_3_FOLDER).records(path):
        if chosen(row["method"]) and row["error"] and row["time_to_solution_s"]:
            found.setdefault(row["method"], []).append(row)
    return {method: sorted(rows, key=lambda row: -float(row["h"])) for method, rows in found.items()}


def first_to(path: str, chosen: Callable[[str], bool], at: float) -> Extract:
    """The fastest of the chosen methods to a strong error, with its time."""

    def extract(output: Output) -> str:
        methods = ordered(output, path, chosen)
        points = {method: [(float(row["time_to_solution_s"]), float(row["error"])) for row in rows] for method, rows in methods.items()}
        times = {method: needed for method, ps in points.items() if (needed := least_time(ps, at)) is not None}
        if not times:
            return "–"
        method = min(times, key=times.__getitem__)
        return f"{method.removesuffix(', stage noise')} {time(times[method])}"

    return extract


def measured_order(path: str, method: str) -> Extract:
    """The strong order between the last but two and the last number of steps."""

    def extract(output: Output) -> str:
        (rows,) = ordered(output, path, method.__eq__).values()
        (e0, h0), (e1, h1) = ((float(row["error"]), float(row["h"])) for row in (rows[-3], rows[-1]))
        return f"{log(e0 / e1) / log(h0 / h1):.2f}"

    return extract


def step_time(path: str, method: str) -> Extract:
    """The time of a step, with the shortest one."""

    def extract(output: Output) -> str:
        (rows,) = ordered(output, path, method.__eq__).values()
        return time(1e-9 * float(rows[-1]["ns_per_step"]))

    return extract


def order_3() -> list[Number]:
    """Times to strong errors with additive noise, measured orders, and times of a step."""
    numbers = []
    for key, problem in ORDER_3.items():
        own, one, many = f"{problem}.csv", ONE.format(problem), MANY.format(problem)
        sides = [
            ("plain", "the fastest rule without stage noise", own, lambda m: m not in BASELINES and m not in STAGE_NOISE),
            ("stages", "the fastest rule with stage noise", own, STAGE_NOISE.__contains__),
            ("areas", "the faster of SPaRK and ShARK of diffrax, one path", one, WITH_AREAS.__contains__),
            ("areas.many", "the faster of SPaRK and ShARK of diffrax, many paths at once, a path", many, WITH_AREAS.__contains__),
        ]
        if problem == "langevin":
            sides += [
                ("special", "the fastest of ALIGN, ShOULD and QUICSORT of diffrax, one path", one, LANGEVIN.__contains__),
                ("special.many", "the fastest of ALIGN, ShOULD and QUICSORT of diffrax, many paths at once, a path", many, LANGEVIN.__contains__),
            ]
        for k in (3, 5, 7):
            numbers += [Number(f"order3.{key}.{k}.{name}", f"{problem}, strong error 1e-{k}: {what}", first_to(path, chosen, 10.0**-k)) for name, what, path, chosen in sides]
        methods = [(method, own) for method in STAGE_NOISE]
        methods += [(method, one) for method in WITH_AREAS + (LANGEVIN if problem == "langevin" else ())]
        for method, path in methods:
            name = method.removesuffix(", stage noise").replace(" ", "").lower()
            numbers.append(Number(f"order3.{key}.order.{name}", f"{problem}: measured strong order of {method}", measured_order(path, method)))
            numbers.append(Number(f"order3.{key}.step.{name}", f"{problem}: time of a step of {method}, one path", step_time(path, method)))
            if path == one:
                numbers.append(Number(f"order3.{key}.step.{name}.many", f"{problem}: time of a step of {method}, many paths at once, a path", step_time(many, method)))
    return numbers


def cells(row: str, column: int) -> Extract:
    """A cell of the table of `structure`: blocks 1, operations 2, calls 3, angle additions 4, times 8."""

    def extract(output: Output) -> str:
        line = find(output, rf"^\| {re.escape(row)} +\| (.*) \|$").group(1)
        return line.split(" | ")[column - 1].strip().replace("+ 1 n", "+ n").replace("→ 1 n", "→ n")

    return extract


def rounded_cells(row: str, column: int) -> Extract:
    """The same with its times rounded to two digits, or to whole nanoseconds."""
    plain = cells(row, column)
    return lambda output: " → ".join(
        f"{float(x):.0f}" if float(x) >= 9.95 else short(float(x)) for x in plain(output).split(" → ")
    )


STRUCTURE = {
    "pendulum": "pendulum, `midpoint`",
    "oscillator": "linear oscillator, `endpoint`",
    "kubo": "Kubo, `midpoint`",
    "double": "double pendulum, `midpoint`",
    "kepler": "Kepler, `midpoint`",
    "chain": "chain of 12, `midpoint`",
}


def structure() -> list[Number]:
    """The rows that the documents have."""
    numbers = []
    for key, row in STRUCTURE.items():
        columns = ((1, "blocks", "blocks"), (2, "operations", "operations"), (3, "calls", "calls"), (4, "additions", "angle additions"))
        for column, name, what in columns:
            numbers.append(Number(f"structure.{key}.{name}", f"{row}: {what}, without structure → with it", cells(row, column)))
        numbers.append(Number(f"structure.{key}.times", f"{row}: ns a step, likewise", rounded_cells(row, 8)))
        numbers.append(Number(f"structure.{key}.ratio", f"{row}: ratio of the times", rounded_cells(row, 9)))
    return numbers


def case(row: str, method: str, pattern: str) -> Extract:
    """A number of a row of `hard_cases`."""
    return text(rf"^{row} +{method}  +(?:holds|blows up|stops|unresolved) +.*?{pattern}")


WALK = r"within ([\d.]+) ε√n/2"
LAST = r"first tenth, (\S+) in the last"


def long_rows() -> list[Number]:
    """The long runs: envelope of the last tenth, and block means in units of the random walk."""
    numbers = []
    for h in ("0.01", "0.02", "0.03", "0.1"):
        row = rf"pendulum +10⁷ steps of {h}: rounding errors"
        what = f"pendulum, midpoint, 10⁷ steps of {h}: largest "
        numbers.append(Number(f"hard.pendulum.{h}.energy", what + "energy error in the last tenth", case(row, "midpoint", LAST)))
        numbers.append(Number(f"hard.pendulum.{h}.walk", what + "change of a block mean of the energy, in ε√n/2", case(row, "midpoint", WALK)))
    for h in ("0.01", "0.03"):
        row = rf"Kepler, circle +3·10⁶ steps of {h}: rounding errors"
        what = f"circular orbit, midpoint, 3·10⁶ steps of {h}: largest change of a block mean of the angular momentum, in ε√n/2"
        numbers.append(Number(f"hard.circle.{h}.walk", what, case(row, "midpoint", WALK)))
    for h in ("0.01", "0.1"):
        for key, method in (("plain", "endpoint"), ("compensated", "endpoint, compensated")):
            row = rf"linear oscillator +10⁷ steps of {h}: rounding errors"
            what = f"linear oscillator, {method}, 10⁷ steps of {h}: largest change of a block mean of q² + p² + hqp, in ε√n/2"
            numbers.append(Number(f"hard.oscillator.{h}.{key}", what, case(row, method, WALK)))
    for n, title in ((2500, "2,500"), (5000, "5,000"), (10000, "10,000")):
        row = rf"Kepler, e = 0\.9 +1,000 periods of {title} steps"
        what = f"Kepler, e = 0.9, 1,000 periods of {title} steps: largest energy error over the whole run"
        numbers.append(Number(f"hard.kepler.{n}", what, case(row, "midpoint", r"energy within (\S+) ")))
    return numbers


def stiff(row: str, method: str, long: bool) -> Number:
    """The first ωh of a scan at which an oscillator blows up."""
    pattern = r"steps, ([\d.]+) within 10⁵" if long else r"from ωh = ([\d.]+) within 5,000"
    steps = "10⁵" if long else "5,000"
    name = f"hard.{row.split()[0]}.{method.replace(' ', '-')}.{'long' if long else 'short'}"
    return Number(name, f"{row}, {method}: blows up within {steps} steps from ωh", case(rf"{row} +stiff: ωh to 1000", method, pattern))


def truncated(h: str) -> Number:
    """Failing paths of the rotor, plain and truncated."""
    what = f"rotor with H₁ of degree 4, h = {h}: failing paths of 20, plain and truncated"
    return Number(f"hard.truncated.{h}", what, text(rf"plain and truncated:.*?h = {re.escape(h)}: (\d+, \d+)"))


def built(scene: str, column: int, scale: float, digits: int = 2) -> Extract:
    """A column of the only row of a scene's table: macro 2, release 6, R/L 10, ns 11; the macro unoptimised."""
    pattern = rf"^{scene} by the rule midpoint\n.*\n +(.*)$"
    return lambda output: short(scale * float(find(output, pattern).group(1).split()[column]), digits)


SCENES = {"pendulum": ("n-pendulum", 6), "bodies": ("n-body", 24), "chain": ("chain", 48)}


def expansion() -> list[Number]:
    """What a system costs to compile."""
    numbers = []
    for key, (scene, n) in SCENES.items():
        for what, column, scale, meaning in (
            ("build", 6, 1e-3, "seconds of `cargo build --release`"),
            ("macro", 2, 1e-3, "of which the macro, not optimised"),
            ("operations", 10, 1.0, "operations of the residual over those of L"),
            ("step", 11, 1e-3, "microseconds a step"),
        ):
            numbers.append(Number(f"build.{key}.{what}", f"{scene} of {n}: {meaning}", built(scene, column, scale)))
    return numbers


def peer(task: str, program: str, how: str) -> Number:
    """A line of `ensembles.py`."""
    pattern = rf"^{task} \| {program} \S+ \| {re.escape(how)} \| ([\d.]+) ns"
    key = how.split("(")[0].replace(".", "-").lower()
    return Number(f"peers.{program}.{key}.{task}", f"task {task} by {program}, {how}: ns a trajectory-step", value(pattern))


def cost(kind: str, key: str, size: int, way: int, what: str) -> Number:
    """The ratio of a way to make steps in the table of `cost_per_coordinate`, in the line of a system and a size."""
    pattern = rf"^{kind} +\d+ +[\d.]+" + r" +[\d.]+ \( *([\d.]+)\)" * 3
    at = SCENE_SIZES.index(size)
    return Number(
        f"cost.{key}.{size}.{what}",
        f"{kind}, {size} coordinates: a step of a trajectory over {what.replace('-', ' ')}",
        lambda output: re.findall(pattern, output.text, re.M)[at][way],
    )


def scene_peer(system: str, size: int, program: str) -> Number:
    """A line of `scenes.py`: the median ratio to sve with its range."""
    pattern = rf"^{system} \| {size} \| {program} [^|]*\|[^|]*\| over sve ([\d.]+), from ([\d.]+) to ([\d.]+)"

    def extract(output: Output) -> str:
        middle, low, high = find(output, pattern).groups()
        return f"{middle} ({low} – {high})"

    return Number(f"scenes.{system}.{size}.{program}", f"{system} of {size}: time of {program} over that of sve, median and range", extract)


# the comparison in turns, of `examples/peers/ratios.py`

TURNS = {
    "double_pendulum": ("sve tolerance", "sve fixed", "sve time_scale", "sve time_scale_tolerance"),
    "kepler": ("sve tolerance", "sve fixed", "sve time_scale", "sve time_scale_tolerance"),
    "kepler_90": ("sve tolerance", "sve time_scale", "sve time_scale_tolerance", "rebound IAS15"),
    "kepler_99": ("sve tolerance", "sve time_scale", "sve time_scale_tolerance", "rebound IAS15"),
    "three_bodies": ("sve tolerance", "sve time_scale", "sve time_scale_tolerance", "rebound IAS15"),
    "separatrix": ("sve tolerance", "sve fixed", "sve time_scale", "sve time_scale_tolerance"),
    "pendulum": ("sve tolerance", "sve fixed"),
    "outer_solar_system": ("sve tolerance", "sve compensated"),
    "quiet_henon_heiles": ("sve tolerance", "sve compensated"),
}
TURN_PROBLEMS = [*TURNS, *(f"double_pendulum_{k}" for k in range(2, 7))]
WITH_IAS15 = [problem for problem, methods in TURNS.items() if "rebound IAS15" in methods]


def turn_run(programs: str, problems: list[str]) -> str:
    """The command that runs problems in turns."""
    return f"target/peers/bin/python examples/peers/run.py --program {programs} --only {' '.join(problems)} --out target/work-precision/turns"


def turn_cell(problem: str, method: str, level: int) -> str:
    """The cell of an error in the line of a method."""
    return rf"^{problem} \| {method} \|.*?\| 1e-{level} " if level > 2 else rf"^{problem} \| {method} \| 1e-2 "


def turn_ratio(problem: str, method: str, level: int) -> Number:
    """The time of heyoka over that of a method; empty where heyoka does not reach the error."""

    def extract(output: Output) -> str:
        found = find(output, turn_cell(problem, method, level) + r"([\d.]+|–|heyoka –)").group(1)
        return "" if found == "heyoka –" else found

    name = f"turns.{problem}.{method.split()[1]}.{level}"
    return Number(name, f"{problem}, error 1e-{level}: time of heyoka over that of {method}", extract)


def turn_time(problem: str, level: int) -> Number:
    """The time of heyoka to an error."""

    def extract(output: Output) -> str:
        found = find(output, turn_cell(problem, "heyoka", level) + r"(?:[\d.]+ \((\d+) µs|heyoka –)").group(1)
        return time(1e-6 * float(found)) if found else "–"

    return Number(f"turns.{problem}.heyoka.{level}", f"{problem}, error 1e-{level}: time of heyoka", extract)


SCENE_SIZES = [100, 1000, 10_000, 100_000, 1_000_000]
SCENES_MEASURED = {"chain": "chain", "lattice": "φ⁴ lattice", "bonds": "bonds of polymers", "atoms": "atoms with lists"}

WORK = " && ".join([
    *(f"target/peers/bin/python examples/peers/run.py --program {program}" for program in ("heyoka", "numba", "scipy")),
    "cargo run --release --example work_precision",
])

ORDER_3_WORK = (
    "for problem in linear_oscillator henon_heiles langevin; do"
    f" target/peers/bin/python examples/peers/run.py --program diffrax --only $problem --out {ORDER_3_FOLDER}/peers"
    f" && cargo run --release --example work_precision -- --only $problem --out {ORDER_3_FOLDER} || exit 1; done"
)

FIRST = (
    "rm -rf target/first && begin=$(date +%s) && cargo build -q --release --example paper --target-dir target/first"
    " && echo built in $(($(date +%s) - begin)) s, $(du -sm target/first | cut -f1) MB; rm -rf target/first"
)

COMMANDS = [
    Command("paper", "cargo run --release --example paper", 6, [
        Number("paper.overflow", "Kubo, Euler–Maruyama uncorrected: overflow at t", text(r"overflow at t +([\d.]+)")),
        Number(
            "paper.radius",
            "Kubo, Euler–Maruyama corrected: order of magnitude of the radius at t = 2000",
            radius,
        ),
    ]),
    Command("first-build", FIRST, 100, [
        Number("first.minutes", "first build of the example `paper`: minutes", lambda output: f"{float(find(output, r'built in ([0-9]+) s').group(1)) / 60:.1f}"),
        Number("first.size", "the folder `target` after it: MB", text(r"built in \d+ s, (\d+) MB")),
    ]),
    Command("hard-cases", "cargo run --release --example hard_cases", 25, [
        *(stiff(row, m, long) for row in ("linear oscillator", "quartic oscillator") for m in ("endpoint", "initial point") for long in (False, True)),
        *long_rows(),
        *(truncated(h) for h in ("0.3", "0.1", "0.05", "0.02")),
    ]),
    Command("structure", "cargo run --release --example structure", 15, structure()),
    Command("work-precision", WORK, 600, [
        Number("wp.kubo.low", "Kubo: of the rules and baselines of this project, midpoint is the fastest for strong errors down to", fastest("kubo", "an error at the end", "midpoint", 2)),
        Number("wp.kubo.midpoint", "Kubo: midpoint's time to an error of 2e-3", time_to("kubo", "midpoint", 2e-3)),
        Number("wp.kubo.heun", "Kubo: Heun's time to an error of 2e-3", time_to("kubo", "Heun", 2e-3)),
        Number("wp.kubo.circle", "Kubo, midpoint: largest change of q² + p², all step sizes", reduced("kubo", "midpoint", "energy_error", max)),
        Number("wp.kubo.endpoint", "Kubo, endpoint without the correction: error with the finest step", reduced("kubo", "endpoint, uncorrected", "error", lambda x: x[-1], 2)),
        Number("wp.kubo.initial", "Kubo, initial point without the correction: likewise", reduced("kubo", "initial point, uncorrected", "error", lambda x: x[-1], 2)),
        Number("wp.oscillator.low", "linear oscillator: of the rules and baselines of this project with one increment a step, midpoint is the fastest down to", fastest("linear_oscillator", "an error at the end", "midpoint", 2)),
        *contests(),
        Number("peers.steps.least", "midpoint steps over those by hand in numba, problems but Kubo: the least ratio", partial(numba_range, min)),
        Number("peers.steps.most", "the same: the largest ratio", partial(numba_range, max)),
        Number("peers.steps.kubo", "Kubo, midpoint step over its closed form by hand in numba", lambda output: f"{against_numba('kubo')(output):.2f}"),
    ]),
    Command("order-3", ORDER_3_WORK, 400, order_3()),
    Command("steps", "cargo bench -p sve-runtime --bench steps -- nomatch", 5, [
        Number("steps.oscillator", "linear oscillator, endpoint, over a three-line loop", over("oscillator endpoint", "sve", "three-line loop")),
        Number("steps.kubo", "Kubo, midpoint, over its Cayley form", over("Kubo midpoint", "sve", "Cayley form")),
        Number("steps.pendulum", "pendulum, midpoint, over naive Newton in two unknowns", over("pendulum midpoint", "sve", "naive Newton")),
        Number("steps.pendulum.best", "pendulum, midpoint, over the best by hand", over("pendulum midpoint", "sve", "best by hand")),
        Number("steps.pendulum.trajectory", "pendulum, midpoint, in a trajectory over naive Newton", over("pendulum midpoint", "sve trajectory", "naive Newton")),
        Number("steps.pendulum.ns", "pendulum, midpoint: ns a step", side("pendulum midpoint", "sve")),
        Number("steps.double", "double pendulum, midpoint, over naive Newton", over("double pendulum midpoint", "sve", "naive Newton")),
        Number("steps.double.trajectory", "double pendulum, midpoint, in a trajectory over naive Newton", over("double pendulum midpoint", "sve trajectory", "naive Newton")),
    ]),
    Command("ensembles", "cargo bench -p sve-runtime --features ensemble --bench ensemble", 15, [
        *(
            Number(f"ensembles.{key}.{name}", f"{task}: ns a trajectory-step, {by}", side(task, by))
            for key, task in (("A", "A oscillator endpoint"), ("B", "B Kubo midpoint"), ("pendulum", "pendulum midpoint"))
            for name, by in (("sve", "sve"), ("hand", "by hand"), ("plain", "by hand, plain"))
        ),
        Number("ensembles.A.threads", "task A: two threads are so many times as fast as one", over("A, 2 threads against 1", "sve", "sve, 2 threads")),
        Number("ensembles.B.threads", "task B: likewise", over("B, 2 threads against 1", "sve", "sve, 2 threads")),
        Number("ensembles.double.sve", "double pendulum: ns a trajectory-step", side("double pendulum", "sve")),
        Number("ensembles.double.single", "double pendulum: ns a step of a single one", side("double pendulum", "sve, scalar steps")),
        Number("ensembles.vectors", "vectors of the machine", text(r"^with (.*?), medians")),
    ]),
    Command(
        "expansion",
        " && ".join(f"cargo bench -p sve-compiler --bench expansion -- {scene} {n}" for scene, n in SCENES.values()),
        60,
        expansion(),
    ),
    Command("peer-ensembles", "target/peers/bin/python examples/peers/ensembles.py", 40, [
        *(peer(task, program, how) for program, how in (("numba", "Generator(SFC64)"), ("numba", "np.random"), ("jax", "lax.scan")) for task in "AB"),
        peer("A", "diffrax", "SemiImplicitEuler"),
        peer("B", "diffrax", "Heun"),
    ]),
    Command("cost", "cargo run --release --example cost_per_coordinate", 150, [
        cost(kind, key, size, way, what)
        for key, kind in SCENES_MEASURED.items()
        for way, what in enumerate(("single-steps", "plain-loops", "best-loops"))
        for size in SCENE_SIZES
    ]),
    Command("peer-scenes", "cargo build --release --example cost_per_coordinate && target/peers/bin/python examples/peers/scenes.py", 60, [
        *(
            scene_peer(system, size, program)
            for system in ("chain", "lattice")
            for size in (100, 10_000, 1_000_000)
            for program in ("numba", "jax")
        ),
        scene_peer("chain", 100, "heyoka"),
    ]),
    Command(
        "turns",
        " && ".join([
            "cargo build --release --example work_precision",
            turn_run("heyoka rebound sve", WITH_IAS15),
            turn_run("heyoka sve", [problem for problem in TURN_PROBLEMS if problem not in WITH_IAS15]),
            "target/peers/bin/python examples/peers/ratios.py",
            "cargo run --release --example work_precision -- turns target/work-precision/turns",
        ]),
        900,
        [
            number
            for problem, methods in TURNS.items()
            for number in (
                *(turn_time(problem, level) for level in range(2, 11)),
                *(turn_ratio(problem, method, level) for method in methods for level in range(2, 11)),
            )
        ],
    ),
]

FILES = {
    "paper": [("target/paper/figure4.png", "docs/figure4.png")],
    "work-precision": [("target/work-precision/synchrotron-errors.svg", "docs/work-precision-synchrotron.svg")],
    "turns": [
        (f"target/work-precision/turns-{problem}.svg", f"docs/turns-{problem}.svg")
        for problem in ("pendulum", "double_pendulum", "kepler_90")
    ],
}
"""Figures of the documents: from where a command writes them to where they are shown."""
