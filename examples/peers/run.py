"""Runs the problems of `work_precision` with other programs and writes what it reads.

Writes `<out>/<program>_<problem>.csv`, one path at a time, which the example draws into its figures, and `<out>/batch/<program>_<problem>.csv`,
many paths at once, per path, which it does not.
"""

import argparse
import importlib
import os
from pathlib import Path
from time import perf_counter

from common import Record, write
from problems import PROBLEMS

PROGRAMS = ("numba", "diffrax", "heyoka", "scipy")
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
    options.add_argument("--program", choices=PROGRAMS, help="only this one")
    options.add_argument("--only", choices=[p.name for p in PROBLEMS], help="only this problem")
    options.add_argument("--out", type=Path, default=ROOT / "target" / "work-precision" / "peers", help="folder for the files")
    options = options.parse_args()
    one_core()
    begin = perf_counter()
    for program in [options.program] if options.program else PROGRAMS:
        peer = importlib.import_module(f"peer_{program}")
        for problem in PROBLEMS:
            if options.only not in (None, problem.name):
                continue
            single, batch = peer.records(problem)
            for folder, records in ((options.out, single), (options.out / "batch", batch)):
                if records:
                    print(f"{problem.name}, {records[0].source}, {folder.name}")
                    show(records)
                    write(folder / f"{program}_{problem.name}.csv", records)
        print(f"{program}: {perf_counter() - begin:.0f} s since the beginning")


if __name__ == "__main__":
    main()
