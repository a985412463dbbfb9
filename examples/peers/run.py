"""Runs the problems of `work_precision` with other programs and writes what it reads.

Writes `<out>/<program>_<problem>.csv`, one path at a time, which the example draws into its figures, and `<out>/batch/<program>_<problem>.csv`,
many paths at once, per path, which it does not.
"""

import argparse
import importlib
import os
from pathlib import Path
from time import perf_counter

from common import Record, Walks, set_times, write
from problems import PROBLEMS, Problem
from uneven import UNEVEN

PROGRAMS = ("numba", "diffrax", "heyoka", "scipy", "rebound")
ROOT = Path(__file__).resolve().parents[2]


def one_core() -> None:
    """Keeps the programs on one core, as the example times one thread."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def show(records: list[Record]) -> None:
    """Prints the main numbers."""
    for r in records:
        cells = [f"{value:9.2e}" if value is not None else " " * 9 for value in (r.h, r.error, r.weak_error, r.energy_error)]
        time = f"{r.ns_per_step:10.1f} ± {r.ns_spread:8.1f} ns/step  {r.time_to_solution_s:9.2e} s"
        print(f"  {r.method:28}", *cells, time, f"{r.failures} failures" if r.failures else "")


def main() -> None:
    """Reads the options and runs."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--program", choices=(*PROGRAMS, "sve"), nargs="+", default=PROGRAMS, help="these programs, in turns; sve only if it is named")
    options.add_argument("--only", choices=[p.name for p in PROBLEMS + UNEVEN], nargs="+", help="only these problems")
    options.add_argument("--out", type=Path, default=ROOT / "target" / "work-precision" / "peers", help="folder for the files")
    options = options.parse_args()
    one_core()
    begin = perf_counter()
    peers = {program: importlib.import_module(f"peer_{program}") for program in options.program}
    for problem in PROBLEMS + UNEVEN:
        if options.only and problem.name not in options.only:
            continue
        found = {program: peer.walks(problem) for program, peer in peers.items()}
        for kind, folder in enumerate((options.out, options.out / "batch")):
            in_turns(problem, {program: lines[kind] for program, lines in found.items()}, folder)
        print(f"{problem.name}: {perf_counter() - begin:.0f} s since the beginning", flush=True)


def in_turns(problem: Problem, lines: dict[str, Walks], folder: Path) -> None:
    """Measures the times of all programs in turns, prints and writes them."""
    set_times([line for walks in lines.values() for line in walks])
    for program, walks in lines.items():
        if walks:
            records = [record for record, _ in walks]
            print(f"{problem.name}, {records[0].source}, {folder.name}")
            show(records)
            write(folder / f"{program}_{problem.name}.csv", records)


if __name__ == "__main__":
    main()
