#!/usr/bin/env bash
# Builds the wheel, installs it in a virtual environment and runs its tests. Needs Rust, Python 3.9 or later with
# venv, and PyPI, whose packages are installed in the environment `target/venv` alone.
set -euo pipefail
cd "$(dirname "$0")"

venv=target/venv
[ -x "$venv/bin/python" ] || python3 -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check 'maturin>=1.9.4,<2' numpy matplotlib

# What maturin sets: a module does not link to the library of Python. With all of it, cargo does not build pyo3 again.
export PYO3_BUILD_EXTENSION_MODULE=1 PYO3_PYTHON="$PWD/$venv/bin/python" PYTHON_SYS_EXECUTABLE="$PWD/$venv/bin/python"
PYO3_ENVIRONMENT_SIGNATURE=$("$PYO3_PYTHON" -c 'import sys, struct; v = sys.version_info; bits = 8 * struct.calcsize("P"); print(f"cpython-{v[0]}.{v[1]}-{bits}bit")')
export PYO3_ENVIRONMENT_SIGNATURE

rm -rf target/wheels
"$venv/bin/maturin" build --release --locked --interpreter "$PYO3_PYTHON"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps target/wheels/*.whl
cargo build --release --locked --example bits
BITS="$PWD/target/release/examples/bits" "$venv/bin/python" -W error -m unittest discover --start-directory tests "$@"

# the page of the guide, followed in a copy of this folder
"$venv/bin/python" tests/page.py
