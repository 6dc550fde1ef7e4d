"""What the README shows: the lines that a reader types, and its Python."""

from __future__ import annotations

import re
from pathlib import Path

README = Path(__file__).parents[2] / "README.md"
TEXT = README.read_text(encoding="utf-8") if README.is_file() else ""
FENCED = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def typed(text: str = TEXT) -> list[str]:
    """Return the lines that are typed into a shell, those of the indented blocks; without what installs."""
    lines = [line.removeprefix("    ") for line in FENCED.sub("", text).splitlines() if line.startswith("    ")]
    return [line for line in lines if not line.startswith("sh bootstrap.sh ")]


def python_blocks(text: str = TEXT) -> list[str]:
    """Return the blocks of Python."""
    return [block for language, block in FENCED.findall(text) if language == "python"]
