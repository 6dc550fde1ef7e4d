"""Arguments and options that several commands share."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click

from bsm_mesh.errors import one_line


class _Path(click.Path):
    """A path that the system can look up: one with a NUL, or half a character, is none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return it as a `Path`."""
        if isinstance(value, str) and value.startswith("--"):  # an option's missing word takes the next option
            self.fail(f"{value!a} is an option, not a path; a file of that name is ./{one_line(value)}", param, ctx)
        try:
            if b"\0" not in os.fsencode(value):
                return super().convert(value, param, ctx)
        except UnicodeEncodeError:
            pass
        self.fail(f"{value!a} is no path", param, ctx)


PATH = _Path(path_type=Path)
model_argument = click.argument("model", type=PATH)
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON on stdout and nothing else.")
no_scripts_option = click.option(
    "--no-scripts", is_flag=True, help="Run no geometry script; read and write nothing outside the model's folder."
)
quiet_option = click.option("-q", "--quiet", is_flag=True, help="No progress on stderr.")


class SeveralNames(click.Command):
    """A command whose ``--joints J1 J2`` takes all words up to the next option."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the words, each joint with an option of its own."""
        found: list[str] = []
        joints = False
        for word in args:
            if word.startswith("-"):
                joints = word == "--joints"
                found += [] if joints else [word]
            else:
                found += ["--joints", word] if joints else [word]
        return super().parse_args(ctx, found)
