"""The command ``compare``."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from bsm_mesh.commands.cli_options import PATH, json_option, model_argument, no_scripts_option, quiet_option
from bsm_mesh.text.progress import start_early


@click.command()
@model_argument
@click.option("-o", "--output", type=PATH, help="Folder for the VTU files; the model's by default.")
@click.option(
    "--order",
    type=click.IntRange(1, 2),
    help="Order of the elements; by default 1 with joints, which then act at the blocks' contact points, else 2.",
)
@click.option(
    "--joints/--no-joints",
    default=None,
    help="Joints as interfaces that slip and part as the model's do (the default), or ignored.",
)
@click.option(
    "--refine",
    type=click.IntRange(1, 6),
    metavar="N",
    help="Halve elements and interfaces 1 to N times, extrapolate, and say where contact points are too coarse.",
)
@click.option(
    "--size", type=float, metavar="METRES", help="Mesh the inside of the blocks by Gmsh, sides so long at most."
)
@click.option(
    "--with",
    "others",
    type=PATH,
    multiple=True,
    metavar="FILE",
    help="A result of another program instead: VTU, CSV of nodes, what meshio reads; PVD or several: a series.",
)
@click.option(
    "--field",
    "fields",
    multiple=True,
    metavar="KEY=ARRAY[:UNIT]",
    help="With --with: which array is displacement, stress, ux, uy, sxx, syy or sxy; several may be given.",
)
@click.option("--length", metavar="UNIT", help="With --with: unit of length of its mesh, for example mm.")
@click.option("--compression-positive", is_flag=True, help="With --with: its stresses are positive in compression.")
@click.option(
    "--stage",
    "stages",
    multiple=True,
    metavar="NAME",
    help="With --with: the stage that each is compared with; by default the last, or of a series all in order.",
)
@click.option("--pictures", is_flag=True, help="Draw both sides and the difference as PNG too.")
@json_option
@quiet_option
@no_scripts_option
def compare(
    model: Path,
    output: Path | None,
    order: int | None,
    joints: bool | None,
    refine: int | None,
    size: float | None,
    others: tuple[Path, ...],
    fields: tuple[str, ...],
    length: str | None,
    compression_positive: bool,
    stages: tuple[str, ...],
    pictures: bool,
    as_json: bool,
    quiet: bool,
    no_scripts: bool,
) -> None:
    """Compare MODEL with a continuum (scikit-fem), stage by stage, or its stages with results of another program.

    Same mesh, loads, stress, water and joints. Says of every stage whether it is comparable, with interfaces at the
    joints, or not comparable and why; then how far both differ, in a sentence, a table and a VTU file.

    Exit code 0 where every stage was compared, 3 where one could not be.
    """
    start_early(f"reading {model}", quiet=quiet or as_json)
    from bsm_mesh.commands.comparing import Asked, compare_model
    from bsm_mesh.commands.comparing_with import Others, compare_with_files, field_names

    shown = {"as_json": as_json, "quiet": quiet, "scripts": not no_scripts}
    if others:
        if refine or size or order or joints is not None:
            raise click.UsageError("--order, --joints, --refine and --size are of our own elements; leave out --with")
        names = field_names(fields, length, compression_positive)
        given = Others(files=others, names=names, stages=stages)
        sys.exit(compare_with_files(model, output, given, pictures=pictures, **shown))
    if fields or length or compression_positive or stages:
        raise click.UsageError("--field, --length, --compression-positive and --stage belong to --with FILE")
    asked = Asked(order=order, joints=joints, refinements=refine or 0, size=size, pictures=pictures)
    sys.exit(compare_model(model, output, asked, **shown))
