"""The commands ``safety`` and ``back-analysis``."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Any

import click

from bsm_mesh.app.cli_options import PATH, json_option, model_argument, no_scripts_option, quiet_option

vary_option = partial(
    click.option,
    "--vary",
    type=(str, float, float),
    metavar="KEY GOOD BAD",
)
search_options = (
    click.option(
        "--tolerance", type=float, default=0.005, show_default=True, help="Width of the bracket over the value."
    ),
    click.option("--trials", type=int, default=40, show_default=True, help="Most trials."),
    click.option("--processes", type=int, default=1, show_default=True, help="Trials that run at the same time."),
)


def _search_options(command: Any) -> Any:
    """Give a command the options of a search."""
    for option in reversed(search_options):
        command = option(command)
    return command


class _SeveralNames(click.Command):
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


@click.command(cls=_SeveralNames)
@model_argument
@click.option("--stage", metavar="NAME", help="The stage in question; the last by default, `initial` is the first.")
@click.option("--joints", multiple=True, metavar="J1 J2 ...", help="Reduce the strength of these joints only.")
@click.option("--rocks/--no-rocks", default=None, help="Reduce the strength of rock faces too; where all joints are.")
@click.option("--bolts", is_flag=True, help="Reduce the capacities of bolts too.")
@click.option(
    "--start",
    type=click.Choice(["stage", "after", "throughout"]),
    default="stage",
    show_default=True,
    help="Reduced as the stage begins; once it has come to rest; in all stages before as well.",
)
@vary_option(help="Find the limit of this number instead: stable at GOOD, failing towards BAD.")
@click.option(
    "--movement",
    type=float,
    default=0.05,
    show_default=True,
    help="A block that moves by more than this part of its size has failed.",
)
@_search_options
@click.option("--spread", is_flag=True, help="Try the other starts and stiffer joints too.")
@click.option("-o", "--output", type=PATH, help="Folder for the answer; that of the results with -safety by default.")
@json_option
@quiet_option
@no_scripts_option
def safety(model: Path, output: Path | None, as_json: bool, quiet: bool, no_scripts: bool, **asked: Any) -> None:
    """Find the factor of safety of MODEL by strength reduction, or the limit of any of its numbers.

    tan(friction), cohesion and tensile strength are divided by a factor until blocks come down, or move too far. Limit
    analysis gives an upper bound with proof first. A trial without a verdict is never counted as a failure. Exit code
    3 where such trials keep the bracket open.

    --vary takes a key of the model file (gravity.horizontal, joint.J1.friction), or load.N.factor, water.rise,
    tilt.left, tilt.right.
    """
    from bsm_mesh.app.progress import Progress
    from bsm_mesh.app.safety import ask_safety

    asked["joints"] = asked["joints"] or None
    progress = Progress(quiet=quiet or as_json)
    sys.exit(ask_safety(model, output, progress, as_json=as_json, scripts=not no_scripts, **asked))


@click.command("back-analysis")
@model_argument
@vary_option(required=True, help="The number that is looked for; movements grow from GOOD to BAD.")
@click.option(
    "--measured",
    type=(float, float, click.Choice(["x", "y", "total"]), float, float),
    multiple=True,
    required=True,
    metavar="X Y x|y|total MOVEMENT DEVIATION",
    help="A movement of a point, and its standard deviation, all in m; repeatable.",
)
@click.option("--stage", metavar="NAME", help="The stage of the movements; the last by default.")
@_search_options
@json_option
@quiet_option
@no_scripts_option
def back_analysis(model: Path, as_json: bool, quiet: bool, no_scripts: bool, **asked: Any) -> None:
    """Find the value of a number of MODEL that gives measured movements, and how sure it is.

    The number is a key of the model file, or one of those that `safety --vary` takes.
    """
    from bsm_mesh.app.back_analysis import analyse_back
    from bsm_mesh.app.progress import Progress

    progress = Progress(quiet=quiet or as_json)
    sys.exit(analyse_back(model, progress, as_json=as_json, scripts=not no_scripts, **asked))
