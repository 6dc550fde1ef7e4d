"""Keyword blocks of Abaqus input, and what of them is refused: keywords that make, copy or move the mesh."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError

DEPTH = 20  # of files that include files
REFUSED = {  # what the keyword does
    "SYSTEM": "moves or turns the nodes below it",
    "NGEN": "makes nodes",
    "NFILL": "makes nodes",
    "NCOPY": "copies nodes",
    "NMAP": "moves nodes",
    "IMPERFECTION": "moves nodes",
    "ELGEN": "makes elements",
    "ELCOPY": "copies elements",
    "SYMMETRIC MODEL GENERATION": "makes nodes and elements",
    "IMPORT": "takes nodes and elements from another analysis",
}
REFUSED_OPTIONS = {  # (keyword, option): what is not read, and the cure
    ("NODE", "SYSTEM"): ("coordinates of another system", "write x, y and z"),
    **{
        (keyword, "INPUT"): ("data lines in another file", f"write *{keyword} into that file, and *INCLUDE here")
        for keyword in ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE")
    },
    ("ELEMENT", "FILE"): ("a substructure", "write its nodes and elements"),
    ("SURFACE", "COMBINE"): ("a surface made of others", "list its elements and sides"),
    ("SURFACE", "CROP"): ("a surface cut by a box", "list its elements and sides"),
}
HARMLESS = {("NODE", "SYSTEM"): ("", "R")}  # values of an option that change nothing
IN_FULL = "write all nodes and elements out: import the file as a model in Abaqus/CAE, and write its input again"


@dataclass(frozen=True, slots=True)
class Block:
    """A keyword with its options and the data lines below it.

    Attributes
    ----------
    keyword : str
        In capitals.
    options : mapping of str to str
        By their names in capitals.
    lines : sequence of str
        The data lines, without comments.
    where : str
        File and line, for messages.
    """

    keyword: str
    options: Mapping[str, str]
    lines: Sequence[str]
    where: str

    def fault(self, text: str) -> ModelError:
        """Return the error that says where the block is."""
        return ModelError(f"{self.where}: *{self.keyword}: {text}")

    def numbers(self) -> FloatArray:
        """Return all numbers of the data lines, one after the other."""
        try:
            values = np.array([c for line in self.lines for c in line.split(",") if c.strip()], dtype=np.float64)
        except ValueError as error:
            raise self.fault(f"{error}; numbers are needed") from None
        if not np.isfinite(values).all():
            raise self.fault("holds infinite or undefined values; numbers are needed")
        return values

    def words(self) -> list[str]:
        """Return all words of the data lines, without quotation marks."""
        return [word.strip().strip('"') for line in self.lines for word in line.split(",") if word.strip()]

    def refused(self) -> list[str]:
        """Return a fault if the block changes the mesh in a way that is not read here."""
        if self.keyword in REFUSED and (self.keyword != "SYSTEM" or self.lines):  # without data: back to x, y, z
            return [f"{self.where}: *{self.keyword} {REFUSED[self.keyword]}, and is not read; {IN_FULL}"]
        return [
            f"{self.where}: *{self.keyword}, {option}={value}: {what}, not read; {cure}"
            for option, value in self.options.items()
            for what, cure in [REFUSED_OPTIONS.get((self.keyword, option), ("", ""))]
            if what and value.upper() not in HARMLESS.get((self.keyword, option), ())
        ]


def read_blocks(path: Path, depth: int = 0) -> Iterator[Block]:
    """Give the keyword blocks of a file, and of those that it includes.

    Raises
    ------
    ModelError
        If a file cannot be read, includes itself, or begins with data lines.
    """
    if depth > DEPTH:
        raise ModelError(f"{path}: files include each other without end")
    keyword, where = "", ""
    options: dict[str, str] = {}
    lines: list[str] = []
    for number, line in _lines(path):
        if not line.startswith("*"):
            if not keyword:
                raise ModelError(
                    f"{path}, line {number}: data without a keyword above: cannot read it as Abaqus input; write the "
                    "keyword in this file, or it is damaged"
                )
            lines.append(line)
            continue
        if keyword:
            yield Block(keyword, options, lines, where)
        words = [word.strip() for word in line[1:].split(",")]
        keyword, lines, where = " ".join(words[0].upper().split()), [], f"{path}, line {number}"
        options = {k.strip().upper(): v.strip().strip('"') for k, _, v in (w.partition("=") for w in words[1:])}
        if keyword == "INCLUDE":
            yield from read_blocks(path.parent / options.get("INPUT", ""), depth + 1)
    if keyword:
        yield Block(keyword, options, lines, where)


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Give the lines of a file without comments, with their numbers; options that continue in the next line joined."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            continued = ""
            for number, raw in enumerate(file, start=1):
                line = continued + raw.strip()
                continued = ""
                if not line or line.startswith("**"):
                    continue
                if line.startswith("*") and line.endswith(","):
                    continued = line
                else:
                    yield number, line
    except OSError as error:
        raise ModelError(f"{path}: cannot be read ({error.strerror or error})") from None
