"""The command line: ``bsm-mesh``. Heavy libraries are imported by the command that needs them."""

from __future__ import annotations

import gc
import io
import os
import sys
from functools import partial
from pathlib import Path
from typing import Any

import click

from bsm_mesh.commands.cli_compare import compare
from bsm_mesh.commands.cli_options import (
    PATH,
    SeveralNames,
    json_option,
    model_argument,
    no_scripts_option,
    quiet_option,
)
from bsm_mesh.commands.cli_results import liner, paraview, plot, report, verify, view
from bsm_mesh.commands.cli_safety import back_analysis, newmark, safety, study
from bsm_mesh.errors import ModelError, one_line
from bsm_mesh.reading import as_typed
from bsm_mesh.text.interruption import guarded
from bsm_mesh.text.progress import Progress, early, start_early
from bsm_mesh.text.terminal import complain, mend_streams, plain_warnings, say, say_json
from bsm_mesh.version import __version__

EXIT_BAD_INPUT, EXIT_NOT_CONVERGED = 2, 3
EXIT_BROKEN_PIPE = 1  # as click and rich leave
FEWER_COLLECTIONS = 5000  # new objects; at 700 collecting is a tenth of a short run, which is mostly imports


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="bsm-mesh")
def cli() -> None:
    """Stability of excavations and slopes in jointed rock by the Block-Spring Model.

    Reads a mesh with joints as physical groups, finds the equilibrium of rigid blocks with springs between them,
    and writes VTU files for ParaView.

    Exit code 0: done; 2: bad input; 3: not converged; 130: interrupted.
    """


@cli.command()
@click.option("-o", "--output", type=PATH, default=Path("bsm-mesh-demo"), show_default=True)
def demo(output: Path) -> None:
    """Run the whole chain on a built-in cavern.

    Geometry, mesh, stages, VTU files and pictures, in a folder of their own. Without bolts a wedge falls from the
    roof, with them it is stable.
    """
    start_early("a cavern, without bolts and with them", quiet=False)
    from bsm_mesh.commands.demo import run_demo

    run_demo(output)


@cli.command()
@click.argument("case")
@click.argument("folder", type=PATH)
def new(case: str, folder: Path) -> None:
    """Write a starter CASE into FOLDER.

    A geometry script and model.toml, ready to run and to change. CASE: arch, cavern, dam, slope, tunnel, wall; of three
    dimensions: dome, key_blocks, roof, wedge.
    """
    from bsm_mesh.commands.starters import next_command, write_starter

    files = write_starter(case, folder)
    say(f"{folder}: {', '.join(path.name for path in files)}")
    say(f"next: {as_typed(next_command(case), folder / 'model.toml')}")


@cli.command()
@click.argument("case", required=False)
@click.option("-o", "--output", type=PATH, help="Mesh file to write, CASE.msh by default.")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="A parameter of the geometry; repeatable.")
@click.option("--list", "list_cases", is_flag=True, help="List the cases, or the parameters of CASE.")
def mesh(case: str | None, output: Path | None, settings: tuple[str, ...], list_cases: bool) -> None:
    """Build the mesh of a geometry.

    CASE is a built-in geometry (--list shows them) or a .py file with build(path).
    """
    from bsm_mesh.commands.commands import build_mesh, print_cases

    if case is None or list_cases:
        print_cases(case)
        return
    build_mesh(case, output, settings)


@cli.command()
@model_argument
@json_option
@click.option("--picture", type=PATH, help="PNG of the blocks, the poor ones in colour.")
@click.option("--threshold", "settings", multiple=True, metavar="NAME=VALUE", help="Where trouble begins; repeatable.")
@click.option("--repair", type=PATH, metavar="NAME.vtu", help="Merge slivers; write the blocks there, a mesh (VTU).")
@click.option("--snap", type=float, default=0.0, metavar="METRES", help="With --repair: join corners nearer than this.")
@click.option("--across-joints", is_flag=True, help="With --repair: give up joints round slivers.")
@quiet_option
@no_scripts_option
def check(
    model: Path,
    as_json: bool,
    quiet: bool,
    no_scripts: bool,
    repair: Path | None,
    snap: float,
    across_joints: bool,
    **asked: Any,
) -> None:
    """Validate MODEL; report on mesh and blocks.

    Thresholds by name: tiny, thin, short_edged, elongated, deeply_concave, many_edged, gap. Slivers are the tiny
    and thin blocks; --repair lists every change.
    """
    start_early(f"reading {model}", quiet=quiet or as_json)
    from bsm_mesh.commands.check import Repair, check_model

    asked["repair"] = None if repair is None else Repair(file=repair, snap=snap, across_joints=across_joints)
    check_model(model, as_json=as_json, quiet=quiet or as_json, scripts=not no_scripts, **asked)


@cli.command()
@model_argument
@click.option("-o", "--output", type=PATH, help="Folder for the results; the model's by default.")
@click.option("--resume", is_flag=True, help="Continue an interrupted run of MODEL.")
@click.option("--pictures", is_flag=True, help="Draw the pictures too, as `bsm-mesh plot` does.")
@json_option
@quiet_option
@click.option(
    "-v",
    "--verbose",
    is_flag=True,
    help="A line for every step, by which method it was found; the cost of the solution.",
)
@click.option(
    "--spread",
    is_flag=True,
    help="Solve it by other routes too, shaken stages at smaller time steps; report by how much they differ.",
)
@click.option(
    "--tables",
    type=click.Choice(["csv", "parquet"]),
    is_flag=False,
    flag_value="csv",
    help="Write blocks, contacts, supports and joints as tables too; alone: as CSV.",
)
@no_scripts_option
def run(
    model: Path, output: Path | None, as_json: bool, quiet: bool, verbose: bool, no_scripts: bool, **asked: Any
) -> None:
    """Solve MODEL; write VTU, PVD, CSV and JSON.

    At the end of every stage, and every two minutes between, the state of the run is on disk. If it is interrupted, or
    the machine goes down, --resume continues from there, and ends with the same results to the last digit.
    """
    start_early(f"reading {model}", quiet=quiet or as_json)
    from bsm_mesh.commands.commands import run_model

    asked["tables"] = asked["tables"] or False
    progress = Progress(quiet=quiet or (as_json and not verbose), verbose=verbose)
    sys.exit(run_model(model, output, progress, as_json=as_json, scripts=not no_scripts, verbose=verbose, **asked))


@cli.command()
@model_argument
@click.option("--to", "program", required=True, type=click.Choice(["3dgrid", "abaqus", "compas_dem", "lmgc90", "udec"]))
@click.option("-o", "--output", type=PATH, help="The file to write; by default NAME_PROGRAM in the current folder.")
@json_option
@no_scripts_option
def export(model: Path, program: str, output: Path | None, as_json: bool, no_scripts: bool) -> None:
    """Write MODEL for another program, and list the features that it does not support.

    Abaqus input (blocks of elements, joints as cohesive elements); Python scripts that run it in compas_dem or LMGC90;
    data files of UDEC and 3DEC (3dgrid).
    """
    from bsm_mesh.commands.exporting import export_model

    export_model(model, program, output, as_json=as_json, scripts=not no_scripts)


@cli.command(cls=SeveralNames)
@model_argument
@click.option("--stage", metavar="NAME", help="The stage in question; the last by default, `initial` is the first.")
@click.option(
    "--load", "numbers", type=int, multiple=True, metavar="K", help="Find the factor on [[load]] number K, from 1."
)
@click.option("--tilt", type=click.Choice(["left", "right"]), help="Find the greatest tilt of the model to that side.")
@click.option("--strength", is_flag=True, help="Find the greatest factor by which strength may be divided.")
@click.option("--joints", multiple=True, metavar="J1 J2 ...", help="With --strength: that of these joints only.")
@click.option("--rocks/--no-rocks", default=None, help="With --strength: of rock faces too; where all joints are.")
@click.option("--bolts", is_flag=True, help="With --strength: divide the limits of bolt forces too.")
@click.option("-o", "--output", type=PATH, help="Folder for limit.vtu; the model's by default.")
@json_option
@quiet_option
@no_scripts_option
def limit(model: Path, output: Path | None, as_json: bool, quiet: bool, no_scripts: bool, **asked: Any) -> None:
    """Ask statics alone whether a stage of MODEL can be at rest, its blocks where they were given.

    A linear program over the contact forces, in space a conic one, without stiffness or movement. "Inadmissible"
    proves that the blocks must move; "admissible" proves nothing. With --load or --tilt it finds the greatest factor or
    angle; with --strength the factor beyond which the blocks must move: an upper bound of every factor of safety.
    """
    start_early(f"reading {model}", quiet=quiet or as_json)
    from bsm_mesh.commands.limit import analyse_limit

    progress = Progress(quiet=quiet or as_json)
    analyse_limit(model, output, progress, as_json=as_json, scripts=not no_scripts, **asked)


@cli.command("key-blocks")
@model_argument
@click.option(
    "-o", "--output", type=PATH, help="Folder for the files; that of the results with -key-blocks by default."
)
@click.option("--picture/--no-picture", default=True, help="Draw key_blocks.png.")
@click.option(
    "--proof", is_flag=True, help="Ask limit analysis too whether the whole rock can be at rest, and the rest."
)
@json_option
@quiet_option
@no_scripts_option
def key_blocks(
    model: Path, output: Path | None, picture: bool, proof: bool, as_json: bool, quiet: bool, no_scripts: bool
) -> None:
    """Find the blocks at the free faces of MODEL that can fall or slide, by block theory.

    MODEL is a file of three dimensions (dimensions = 3): rock in a box with joints by dip and dip direction, and
    excavations or a slope. Of every block: whether it is removable, how it moves, factor, weight, support pressure.
    """
    start_early(f"reading {model}", quiet=quiet or as_json)
    from bsm_mesh.commands.key_blocks import find_key_blocks

    progress = Progress(quiet=quiet or as_json)
    find_key_blocks(model, output, progress, as_json=as_json, picture=picture, proof=proof, scripts=not no_scripts)


@cli.command()
@click.argument("table", type=PATH)
@click.option("--face", type=(float, float), required=True, metavar="DIP DIRECTION", help="Of the slope [degrees].")
@click.option("--friction", type=float, required=True, help="Friction angle of the joints [degrees].")
@click.option(
    "--lateral-limit",
    type=float,
    default=20.0,
    show_default=True,
    help="Greatest angle between the dip direction of the slope and planar sliding or direct toppling [degrees].",
)
@click.option(
    "--toppling-limit", type=float, default=30.0, show_default=True, help="The same for flexural toppling [degrees]."
)
@click.option("-o", "--output", type=PATH, help="Folder for the files; out/NAME next to NAME.csv by default.")
@click.option("--picture/--no-picture", default=True, help="Draw kinematics.png.")
@json_option
def kinematics(table: Path, output: Path | None, as_json: bool, picture: bool, **asked: Any) -> None:
    """Screen the joints of TABLE against a slope: sliding and toppling by orientation alone.

    TABLE is a CSV file with the columns dip, dip_direction and set. Planar and wedge sliding (Markland), flexural
    toppling (Goodman and Bray) and direct toppling (Hudson and Harrison), for all planes and lines of intersection.
    """
    from bsm_mesh.commands.kinematics import screen_slope

    screen_slope(table, output, as_json=as_json, picture=picture, **asked)


@cli.command("joint-test")
@model_argument
@click.option("--joint", required=True, metavar="NAME", help="The joint to test.")
@click.option("--normal-stress", multiple=True, metavar="STRESS", help='Constant, such as "1 MPa"; repeatable.')
@click.option(
    "--normal-stiffness", metavar="STIFFNESS", help="By which that stress grows as the joint opens; constant without."
)
@click.option("--displacement", default="10 mm", show_default=True, help="Greatest shear displacement, or opening.")
@click.option(
    "--cycles", type=int, default=0, show_default=True, help="Shear cycles to both sides; 0: to one side once."
)
@click.option("--bolt", metavar="NAME", help="A bolt to be pulled out and sheared across the joint.")
@click.option(
    "--inclination", type=float, default=0.0, show_default=True, help="Of the bolt to the joint's normal [degrees]."
)
@click.option("--laboratory", multiple=True, type=PATH, help="CSV file of a measured curve to lay over; repeatable.")
@click.option("-o", "--output", type=PATH, help="Folder for tables and pictures; the model's by default.")
@json_option
@no_scripts_option
def joint_test(model: Path, output: Path | None, as_json: bool, no_scripts: bool, **asked: Any) -> None:
    """Test a joint of MODEL as a laboratory does.

    Direct shear under constant normal stresses or stiffness, once or back and forth; closure and unloading; a bolt
    pulled out and sheared. By the contacts, laws and bolts of a run; tables (CSV) and pictures.
    """
    from bsm_mesh.commands.joint_test import run_joint_test

    run_joint_test(model, output, as_json=as_json, scripts=not no_scripts, **asked)


@cli.command()
@click.option("--dimensions", type=click.Choice(["2", "3"]), default="2", show_default=True, help="Of the blocks.")
def schema(dimensions: str) -> None:
    """Print the JSON Schema of the model file."""
    from bsm_mesh.modelfile.model_tables import ModelFile
    from bsm_mesh.modelfile.space_tables import SpaceFile

    say_json((ModelFile if dimensions == "2" else SpaceFile).model_json_schema())


for command in (compare, safety, newmark, back_analysis, study, plot, view, liner, paraview, report, verify):
    cli.add_command(command)


def main(arguments: list[str] | None = None) -> Any:
    """Run a command; bad input is one message and exit code 2, an interruption one and 130, never a traceback."""
    return guarded(partial(_run, arguments))


def _run(arguments: list[str] | None) -> Any:
    gc.set_threshold(FEWER_COLLECTIONS)
    mend_streams()
    try:
        with plain_warnings(), early():
            result = cli.main(arguments, standalone_mode=False)
        sys.stdout.flush()
        return result
    except ModelError as error:
        _fail("\n".join([f"error: {error}", *getattr(error, "__notes__", [])]), EXIT_BAD_INPUT)
    except click.ClickException as error:
        shown = io.StringIO()
        error.show(shown)
        _fail(shown.getvalue().rstrip(), EXIT_BAD_INPUT)
    except click.Abort as error:  # what click makes of an interruption
        raise error.__cause__ if isinstance(error.__cause__, KeyboardInterrupt) else KeyboardInterrupt() from None
    except BrokenPipeError:  # whoever read our output has seen enough, as in `bsm-mesh schema | head`
        _close_stdout()
        sys.exit(EXIT_BROKEN_PIPE)
    except OSError as error:
        where = f"{one_line(str(error.filename))}: " if error.filename else ""
        _close_stdout()
        _fail(f"error: {where}{error.strerror or error}", EXIT_BAD_INPUT)
    except MemoryError:
        _fail("error: not enough memory for this model; take a coarser mesh", EXIT_BAD_INPUT)


def _close_stdout() -> None:
    """Send what stdout still holds nowhere: Python would try to write it on leaving, and complain."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError):  # stdout is no file
        return


def _fail(message: str, code: int) -> None:
    complain(message)
    sys.exit(code)


if __name__ == "__main__":
    main()
