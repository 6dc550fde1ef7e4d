"""The problems of docs/first_problems.md from nothing to a verdict, as typed: ``python -m benchmarks.first_problems``.

Prints blocks, verdict and processor time of each.
"""

from __future__ import annotations

import json
import resource
import shlex
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from docs.code_blocks import files_of, typed

PAGE = Path(__file__).parents[1] / "docs/first_problems.md"


def processor_time() -> float:
    """Return the processor time of all processes that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Run every problem in a folder of its own and print its row."""
    for section in PAGE.read_text(encoding="utf-8").split("\n## ")[1:]:
        with TemporaryDirectory() as folder:
            for name, content in files_of(section).items():
                (Path(folder) / name).write_text(content, encoding="utf-8")
            begun = processor_time()
            for line in typed(section):
                program, *arguments = shlex.split(line)
                module = ["-m", "bsm_mesh"] if program == "bsm-mesh" else []
                subprocess.run([sys.executable, *module, *arguments], cwd=folder, check=True, capture_output=True)
            seconds = processor_time() - begun
            (told,) = Path(folder).glob("out/*/summary.json")
            end = json.loads(told.read_text(encoding="utf-8"))
            print(section.splitlines()[0], end["blocks"], end["status"], f"{seconds:.0f} s", sep=" | ", flush=True)


if __name__ == "__main__":
    main()
