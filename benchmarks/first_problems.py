"""The problems of docs/first_problems.md from nothing to a verdict, as typed: ``python -m benchmarks.first_problems``.

Blocks, verdict and processor time of each. With ``--into PAGE`` the table takes the place of what is between that
page's marks.
"""

from __future__ import annotations

import argparse
import json
import resource
import shlex
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.pages import add_into, tell
from docs.code_blocks import files_of, typed
from examples.numbers.pages import markdown

PAGE = Path(__file__).parents[1] / "docs/first_problems.md"
COMMAND = "python -m benchmarks.first_problems"


def processor_time() -> float:
    """Return the processor time of all processes that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def table() -> str:
    """Run every problem in a folder of its own and return the table."""
    rows = []
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
            title = section.splitlines()[0]
            rows.append((title[0].lower() + title[1:], str(end["blocks"]), end["status"], f"{seconds:.0f}"))
    return markdown(("problem", "blocks", "verdict", "processor time, s"), rows) + "\n"


def main() -> None:
    """Make the table, and print it or put it into a page."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    add_into(parser, COMMAND)
    page = parser.parse_args().into
    tell(table(), COMMAND, page)


if __name__ == "__main__":
    main()
