"""Examples of sve that answer lines: processes of their own, on the core of the caller."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class Served:
    """A process of an example, with the words after its name."""

    def __init__(self, example: str, *words: object) -> None:
        program = ROOT / "target" / "release" / "examples" / example
        self.process = subprocess.Popen([str(program), *map(str, words)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, *words: object) -> list[str]:
        """Sends a line and returns the words of the answer."""
        self.process.stdin.write(" ".join(map(str, words)) + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline().split()

    def close(self) -> None:
        """Ends the process."""
        self.process.stdin.close()
        self.process.wait()
