"""Runs the problems of `work_precision` with other programs, and writes a CSV file for each program.

    python run.py [folder] [program …]

The folder is `target/work-precision/peers` of the workspace unless given; `cargo run --release --example work_precision` then draws
the results beside its own.
"""

import importlib
import pathlib
import sys
import time

import common

PROGRAMS = ["numba", "heyoka", "scipy", "diffrax"]


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else root / "target" / "work-precision" / "peers"
    folder.mkdir(parents=True, exist_ok=True)
    exact = importlib.import_module("with_heyoka").exact()
    for program in sys.argv[2:] or PROGRAMS:
        begin = time.perf_counter()
        rows = list(importlib.import_module(f"with_{program}").results(exact))
        common.write(folder / f"{program}.csv", rows)
        print(f"{program}: {len(rows)} lines in {time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
