"""The commands ``safety``, ``newmark``, ``back-analysis`` and ``study``."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Any

import click

from bsm_mesh.commands.cli_options import (
    PATH,
    SeveralNames,
    json_option,
    model_argument,
    no_scripts_option,
    quiet_option,
)
from bsm_mesh.text.progress import Progress, start_early

vary_option = partial(click.option, "--vary", type=(str, str, str), metavar="KEY GOOD BAD")
movement_option = click.option(
    "--movement",
    type=float,
    default=0.05,
    show_default=True,
    help="A block that moves by more than this part of its size has failed.",
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


@click.command(cls=SeveralNames)
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
    help="Reduced as the stage begins; once it is at rest; in all stages before as well.",
)
@vary_option(help="Find the limit of this number instead: stable at GOOD, failing towards BAD, with units or without.")
@movement_option
@_search_options
@click.option("--spread", is_flag=True, help="Try the other starts and stiffer joints too.")
@click.option(
    "-o",
    "--output",
    type=PATH,
    help="Folder for the answer; by default that of the results with -safety, or -limit-KEY of --vary, and -STAGE.",
)
@json_option
@quiet_option
@no_scripts_option
def safety(model: Path, output: Path | None, as_json: bool, quiet: bool, no_scripts: bool, **asked: Any) -> None:
    """Find the factor of safety of MODEL by strength reduction, or the limit of any of its numbers.

    tan(friction), cohesion and tensile strength are divided by a factor until blocks fall, or move too far. Limit
    analysis gives an upper bound with proof first. A trial without a verdict is never counted as a failure. Exit code
    3 where such trials keep the bracket open.

    --vary takes a key of the model file (gravity.horizontal, joint.J1.friction), as a study does. It also takes
    load.N.factor, stage.NAME.load.N.factor, water.rise, tilt.left and tilt.right. Values may have units.
    """
    start_early(f"reading {model}", quiet=quiet or as_json)
    from bsm_mesh.commands.safety import ask_safety

    asked["joints"] = asked["joints"] or None
    progress = Progress(quiet=quiet or as_json)
    sys.exit(ask_safety(model, output, progress, as_json=as_json, scripts=not no_scripts, **asked))


@click.command()
@model_argument
@click.option("--record", type=PATH, help="Record (CSV or .at2) instead of that of the model's shaken stage.")
@click.option(
    "--quantity",
    type=click.Choice(["acceleration", "velocity"]),
    default="acceleration",
    show_default=True,
    help="With --record: its quantity.",
)
@click.option("--scale", type=float, default=1.0, show_default=True, help="With --record: factor on it.")
@click.option("--stage", metavar="NAME", help="The stage whose blocks are shaken; the one before the shaken stage.")
@click.option(
    "--side",
    "sides",
    type=click.Choice(["left", "right"]),
    multiple=True,
    default=("left", "right"),
    help="Where blocks may go; repeatable, both by default.",
)
@click.option("--alone", is_flag=True, help="Do not run the model's shaken stage for comparison.")
@movement_option
@click.option("--tolerance", type=float, default=0.001, show_default=True, help="Width of the bracket [g].")
@click.option("--trials", type=int, default=40, show_default=True, help="Most trials a side.")
@click.option("--processes", type=int, default=1, show_default=True, help="Trials that run at the same time.")
@click.option("-o", "--output", type=PATH, help="Folder for the answer; that of the results with -newmark by default.")
@json_option
@quiet_option
@no_scripts_option
def newmark(model: Path, output: Path | None, as_json: bool, quiet: bool, no_scripts: bool, **asked: Any) -> None:
    """Find how far MODEL slides in an earthquake by Newmark's method.

    The yield acceleration is the greatest horizontal part of the weights that the blocks carry; the record is
    integrated twice where it exceeds it, as given and turned over. The displacement of the model's shaken stage is
    compared with it. Exit code 3 where trials without a verdict keep a bracket open.
    """
    start_early(f"reading {model}", quiet=quiet or as_json)
    from bsm_mesh.commands.newmark import ask_newmark

    asked["shaken"] = not asked.pop("alone")
    progress = Progress(quiet=quiet or as_json)
    sys.exit(ask_newmark(model, output, progress, as_json=as_json, scripts=not no_scripts, **asked))


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
    start_early(f"reading {model}", quiet=quiet or as_json)
    from bsm_mesh.commands.back_analysis import analyse_back

    progress = Progress(quiet=quiet or as_json)
    sys.exit(analyse_back(model, progress, as_json=as_json, scripts=not no_scripts, **asked))


@click.command()
@click.argument("study", type=PATH)
@click.option("-o", "--output", type=PATH, help="Folder for the study; out/NAME next to NAME.toml by default.")
@click.option("--processes", type=click.IntRange(1), metavar="N", help="Runs at a time; as many as cores by default.")
@click.option("--scheduler", metavar="ADDRESS", help="Have a Dask cluster do the runs instead.")
@json_option
@quiet_option
@no_scripts_option
def study(study: Path, output: Path | None, as_json: bool, quiet: bool, no_scripts: bool, **asked: Any) -> None:
    """Run a model many times with other values.

    STUDY is a file that says which keys of a model vary, and how: a grid, a list, Latin hypercube or Monte Carlo. The
    runs become a table (study.parquet), a summary (probability of failure, which key decides) and pictures.
    Interrupted or killed, the same command continues: no finished run is done again.
    """
    start_early(f"reading {study}", quiet=quiet or as_json)
    from bsm_mesh.commands.study import study_command

    study_command(study, output, as_json=as_json, quiet=quiet, scripts=not no_scripts, **asked)
