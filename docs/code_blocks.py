"""What a page of the documentation shows: files, lines that a reader types, Python, parts of model files.

A fenced block after a line that ends in the name of a file in backticks and a colon is that file. Other blocks are by
their language: ``sh`` is typed, as are indented lines that begin like a command; ``python`` is run; ``toml`` is a part
of a model file. Blocks without a language, or ``text``, are no code.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
TEXT = README.read_text(encoding="utf-8") if README.is_file() else ""
BLOCK = re.compile(r"(?:`([\w./]+\.\w+)`:\n\n)?^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
PROGRAMS = (
    "bsm-mesh ",
    "python ",
    "sh ",
    ". ",
    "pip ",
    "sudo ",
    "dask ",
    "mpiexec ",
    "gmsh ",
    "python3 ",
    ".venv/",
    "cat ",
)


@dataclass(frozen=True)
class Block:
    """A piece of code of a page: the file that it is, if any; its language; its text; the line where it begins."""

    file: str
    language: str
    text: str
    line: int

    @property
    def lines(self) -> list[str]:
        """Lines that are typed: without comments, a continued one as one."""
        joined = self.text.replace("\\\n", " ")
        bare = (re.sub(r"(^|\s)#.*$", "", line).strip() for line in joined.splitlines())
        return [line for line in bare if line]


def blocks_of(text: str) -> list[Block]:
    """Return the code of a page in its order."""
    found = [Block(m[1] or "", m[2], m[3], _line(text, m.start(2))) for m in BLOCK.finditer(text)]
    rest = BLOCK.sub(lambda m: re.sub(r"[^\n]", "", m[0]), text)  # the same lines, empty where a block was
    typed = [
        Block("", "sh", line.removeprefix("    ") + "\n", number)
        for number, line in enumerate(rest.splitlines(), start=1)
        if line.startswith(tuple("    " + program for program in PROGRAMS))
    ]
    return sorted([*found, *typed], key=lambda block: block.line)


def _line(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


def files_of(text: str) -> dict[str, str]:
    """Return the files that a page shows."""
    return {block.file: block.text for block in blocks_of(text) if block.file}


def typed(text: str = TEXT) -> list[str]:
    """Return the lines that are typed into a shell; without what installs."""
    shell = [block for block in blocks_of(text) if block.language == "sh"]
    lines = [line for block in shell for line in block.lines]
    return [line for line in lines if not line.startswith("sh bootstrap.sh ")]


def python_blocks(text: str = TEXT) -> list[str]:
    """Return the blocks of Python."""
    return [block.text for block in blocks_of(text) if block.language == "python"]
