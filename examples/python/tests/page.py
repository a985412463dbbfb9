"""Follows the page "Call your system from Python" of the guide in a copy of this folder.

The copy gets the name and the system of the page. Its module is built and installed into the environment that
runs this program, and the Python programs of the page are run one after the other, as one program.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent
REPOSITORY = PACKAGE.parent.parent
PAGE = (REPOSITORY / "sve-runtime/docs/guide/python_module.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def make_copy(copy):
    """Copies the package, with the name and the system of the page."""
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("target", "__pycache__"))
    (rename,) = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("sed ")]
    subprocess.run(rename, shell=True, check=True, cwd=copy)
    manifest = copy / "Cargo.toml"
    runtime = (REPOSITORY / "sve-runtime").as_posix()
    manifest.write_text(manifest.read_text().replace("../../sve-runtime", runtime))
    (system,) = blocks("rust,ignore")
    source = copy / "src/lib.rs"
    above, pendulum, _ = source.read_text().partition("/// A pendulum")
    assert pendulum, "the system of the example begins with its comment"
    source.write_text(above + system)


def main():
    copy = PACKAGE / "target/page"
    make_copy(copy)
    os.environ["CARGO_TARGET_DIR"] = str(PACKAGE / "target")
    wheels = copy / "wheels"
    maturin = [sys.executable, "-m", "maturin", "build", "--release", "--offline", "--interpreter", sys.executable]
    subprocess.run([*maturin, "--out", wheels], check=True, cwd=copy)
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--force-reinstall"]
    subprocess.run([*pip, "--no-deps", *wheels.glob("*.whl")], check=True)
    subprocess.run([sys.executable, "-c", "\n".join(blocks("python"))], check=True, cwd=copy)


main()
