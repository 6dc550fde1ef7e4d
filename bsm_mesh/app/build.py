"""From the model file's tables to the model: mesh, rocks, joints, supports, loads."""

from __future__ import annotations

import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from bsm_mesh.app.build_bolts import make_bolts, unused_curves
from bsm_mesh.app.model_file import (
    InSituTable,
    JointTable,
    LoadTable,
    MeshTable,
    ModelFile,
    RockTable,
    StageTable,
    SupportTable,
    WaterTable,
    read_model_file,
)
from bsm_mesh.app.units import convert
from bsm_mesh.errors import MeshWarning, ModelError, counted, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.in_situ import InSitu
from bsm_mesh.model.joint_laws import JointLaw, MohrCoulomb, Patton
from bsm_mesh.model.loads import InSituTraction, Load, PointLoad, Pressure, Traction
from bsm_mesh.model.materials import Filling, Joint, Rock
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import Stage, blocks_in
from bsm_mesh.model.supports import Fixed, NormalRoller, PrescribedDisplacement, Roller, Support
from bsm_mesh.model.water import Water
from bsm_mesh.solve.options import Options

if TYPE_CHECKING:
    from converters import MeshReport

Reporter = Callable[[str], None]
Made = TypeVar("Made")


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadedModel:
    """A model as its file describes it.

    Attributes
    ----------
    path : Path
        The model file.
    file : ModelFile
        Its content.
    model : Model
        What it builds.
    options : Options
        How it is to be solved.
    notes : tuple of str
        What was mended or left out of the mesh, a line each.
    mesh_lines : tuple of str
        What was found in the mesh, a line each, the notes included.
    dangling : mapping of str to int
        Pieces of the mesh's joints that bound no block.
    """

    path: Path
    file: ModelFile
    model: Model
    options: Options
    notes: tuple[str, ...]
    mesh_lines: tuple[str, ...]
    dangling: Mapping[str, int]

    @property
    def output_folder(self) -> Path:
        """Where the file says that results go."""
        return self.path.parent / self.file.output.folder


def load(path: str | os.PathLike[str]) -> Model:
    """Return the model of a model file; what was mended in its mesh is warned of (`MeshWarning`).

    Raises
    ------
    ModelError
        With every fault found in the file, its mesh or the model as a whole.
    """
    loaded = load_model_file(Path(path))
    for note in loaded.notes:
        warnings.warn(note, MeshWarning, stacklevel=2)
    return loaded.model


def load_model_file(path: Path, report: Reporter = lambda text: None) -> LoadedModel:
    """Return the model of a model file together with its options and the notes on its mesh."""
    file = read_model_file(path)
    faults: list[str] = []
    rocks = _collect(faults, [partial(_rock, name, table) for name, table in file.rock.items()])
    joints = _collect(faults, [partial(_joint, name, table) for name, table in file.joint.items()])
    supports = _collect(
        faults, [partial(_supports, table, f"[[support]] number {k + 1}") for k, table in enumerate(file.support)]
    )
    loads = _collect(faults, [partial(_load, table, f"[[load]] number {k + 1}") for k, table in enumerate(file.load)])
    ground = _collect(faults, [] if file.in_situ is None else [partial(_in_situ, file.in_situ)])
    water = _collect(faults, [] if file.water is None else [partial(_water, file.water, "[water]")])
    stages = _collect(faults, [partial(_stage, table) for table in file.stage])
    options = _collect(faults, [partial(Options, **file.solver.model_dump())])
    raise_faults([f"{path.name}: {fault}" for fault in faults])
    report("mesh")
    blocks, mesh_report = _blocks(file.mesh, file.groups, path)
    bolts = _collect(
        faults,
        [
            partial(make_bolts, table, f"[[bolt]] number {k + 1}", blocks, mesh_report.bolts, path.parent)
            for k, table in enumerate(file.bolt)
        ],
    )
    raise_faults([f"{path.name}: {fault}" for fault in faults])
    with _placed(path.name):
        model = Model(
            blocks=blocks,
            rocks=tuple(rocks),
            joints=tuple(joints),
            default_joint=file.mesh.default_joint,
            supports=tuple(support for group in supports for support in group),
            loads=tuple(loads),
            bolts=tuple(bolt for group in bolts for bolt in group),
            gravity_direction=file.gravity.direction,
            contact_points=file.mesh.contact_points,
            in_situ=ground[0] if ground else None,
            water=water[0] if water else None,
            stages=tuple(stages),
            title=file.title,
        )
    return LoadedModel(
        path=path,
        file=file,
        model=model,
        options=options[0],
        notes=(
            *(note.text for note in mesh_report.notes),
            *_unused_excavations(blocks, stages),
            *unused_curves(mesh_report.bolts, file.bolt),
        ),
        mesh_lines=tuple(mesh_report.lines()[1:]),
        dangling=_dangling(mesh_report),
    )


def _dangling(report: MeshReport) -> dict[str, int]:
    from converters import NoteKind

    found: dict[str, int] = {}
    for kind in (NoteKind.LOOSE, NoteKind.DEAD_END):
        for name, count in report.about(kind).items():
            if name.startswith("joint:"):
                found[name] = found.get(name, 0) + count
    return found


def _unused_excavations(blocks: Blocks, stages: list[Stage]) -> list[str]:
    gone = np.zeros(blocks.count, dtype=bool)
    for region in (region for stage in stages for region in stage.excavate):
        gone |= blocks_in(region, blocks)
    return [
        f"excavation '{name}' ({counted(len(ids), 'block')}) is left in place: no stage excavates it"
        for name, ids in blocks.excavations.items()
        if not gone[ids].any()
    ]


@contextmanager
def _placed(place: str) -> Iterator[None]:
    """Say of every fault where it is."""
    try:
        yield
    except ModelError as error:
        raise ModelError([f"{place}: {fault}" for fault in error.faults]) from error


def _collect(faults: list[str], makers: Iterable[Callable[[], Made]]) -> list[Made]:
    """Return what the makers make; add the faults of those that cannot."""
    made = []
    for maker in makers:
        try:
            made.append(maker())
        except ModelError as error:
            faults.extend(error.faults)
    return made


def _rock(name: str, table: RockTable) -> Rock:
    return Rock(name, **table.model_dump())


def _joint(name: str, table: JointTable) -> Joint:
    with _placed(f"joint '{name}'"):
        filling = None if table.filling is None else Filling(**table.filling.model_dump())
        law = _law(table)
    return Joint(
        name,
        normal_stiffness=table.normal_stiffness,
        shear_stiffness=table.shear_stiffness,
        filling=filling,
        law=law,
        tensile_strength=table.tensile_strength,
    )


def _law(table: JointTable) -> JointLaw | None:
    given = {key: getattr(table, key) for key in ("friction", "dilation", "cohesion", "residual_friction")}
    given = {key: value for key, value in given.items() if value is not None}
    if not given and table.law is None:
        return None
    if "friction" not in given:
        raise ModelError("a joint with a strength needs the key 'friction' [degrees]")
    if table.law == "mohr_coulomb":
        if "dilation" in given:
            raise ModelError("law 'mohr_coulomb' has no dilation; remove it or choose 'patton'")
        return MohrCoulomb(**given)
    return Patton(**given)


def _supports(table: SupportTable, place: str) -> list[Support]:
    where: dict[str, Any] = {
        "blocks": None if table.blocks is None else tuple(table.blocks),
        "boundary": table.boundary,
        "point": table.point,
    }
    if sum(value is not None for value in where.values()) != 1:
        raise ModelError(f"{place}: say where it holds: exactly one of boundary, blocks, point")
    if (table.fix is None) == (table.direction is None):
        raise ModelError(f"{place}: say what it holds: fix, or direction (with displacement for a given movement)")
    if table.direction is not None:
        if table.displacement is None:
            return [Roller(**where, direction=table.direction)]
        return [PrescribedDisplacement(**where, direction=table.direction, displacement=table.displacement)]
    if table.displacement is not None:
        raise ModelError(f"{place}: displacement needs a direction [degrees] instead of fix")
    if table.fix == "normal":
        if table.boundary is None:
            raise ModelError(f'{place}: fix = "normal" needs a boundary; blocks and points have no normal')
        return [NormalRoller(boundary=table.boundary)]
    if table.fix == "all" or (len(table.fix or []) == 2 and table.blocks is None):
        return [Fixed(**where)]  # of an edge or a point both components are all there is
    axes = {"x": 0.0, "y": 90.0}
    return [Roller(**where, direction=axes[axis]) for axis in sorted(table.fix or [])]


def _load(table: LoadTable, place: str) -> Load:
    given = table.model_dump(exclude_none=True)
    if set(given) == {"boundary", "pressure"}:
        return Pressure(**given)
    if set(given) == {"boundary", "in_situ"} and table.in_situ:
        return InSituTraction(boundary=given["boundary"])
    if set(given) == {"boundary", "traction"}:
        return Traction(**given)
    if set(given) == {"block", "point", "force"}:
        return PointLoad(**given)
    raise ModelError(
        f"{place}: give boundary with pressure, traction or in_situ = true, or block with point and force; "
        f"given: {', '.join(sorted(given)) or 'nothing'}"
    )


def _in_situ(table: InSituTable) -> InSitu:
    return InSitu(**{key: value for key, value in table.model_dump().items() if value is not None})


def _water(table: WaterTable, place: str) -> Water:
    with _placed(place):
        return Water(**table.model_dump())


def _stage(table: StageTable) -> Stage:
    place = f"stage '{table.name}'"
    return Stage(
        name=table.name,
        excavate=tuple(table.excavate),
        fill=tuple(table.fill),
        relaxation=tuple(table.relaxation),
        pressure=table.pressure,
        water=None if table.water is None else _water(table.water, place),
        loads=tuple(_load(load, f"{place}: load {k + 1}") for k, load in enumerate(table.load)),
    )


def _blocks(mesh: MeshTable, groups: dict[str, str], path: Path) -> tuple[Blocks, MeshReport]:
    """Return the blocks of the mesh file, or of the geometry, which is built in a temporary folder."""
    if (mesh.file is None) == (mesh.geometry is None):
        given = "neither is" if mesh.file is None else "both are"
        raise ModelError(f"{path.name}: [mesh] needs one of the keys 'file' and 'geometry'; {given} given")
    if mesh.file is not None:
        if mesh.file.endswith(".py"):
            raise ModelError(f'{path.name}: [mesh] file is a script; write geometry = "{mesh.file}"')
        if mesh.parameters:
            raise ModelError(f"{path.name}: [mesh.parameters] belong to a geometry; [mesh] has a file")
        return _read(path.parent / mesh.file, mesh, groups, path.name)
    name = str(mesh.geometry)
    with tempfile.TemporaryDirectory(prefix="bsm-mesh-") as folder:
        target = Path(folder) / "mesh.msh"
        try:
            build_geometry(path.parent / name if name.endswith(".py") else name, target, mesh.parameters)
            return _read(target, mesh, groups, path.name)
        except ModelError as error:  # the name of the temporary file says nothing to the user
            raise ModelError([fault.replace(str(target), f"mesh.msh of {name}") for fault in error.faults]) from error


def _read(path: Path, mesh: MeshTable, groups: dict[str, str], model_file: str) -> tuple[Blocks, MeshReport]:
    from converters import read_mesh

    try:
        scale = convert(f"1 {mesh.unit}", "m")
    except ValueError as error:
        raise ModelError(f'{model_file}: [mesh] unit = "{mesh.unit}": {error}') from None
    return read_mesh(path, groups=groups, merge_tolerance=mesh.merge_tolerance, unit_scale=scale, blocks=mesh.blocks)


def build_geometry(case: str | os.PathLike[str], path: Path, parameters: Mapping[str, object]) -> None:
    """Write the mesh of a geometry; what it prints goes to stderr, since stdout is the results'.

    Raises
    ------
    ModelError
        For an unknown geometry or parameter, and for whatever a user's script raises.
    """
    from geometries.cases import find_case

    with geometry_faults(), stdout_to_stderr():
        found = find_case(case)
        if "path" in parameters:
            raise ModelError(f"{found.name}: there is no parameter 'path': the mesh is written where it is needed")
        found.build(path, **parameters)


@contextmanager
def stdout_to_stderr() -> Iterator[None]:
    """Lead what is printed on stdout to stderr, also what Gmsh prints past Python, its hundreds of Info lines aside."""
    sys.stdout.flush()
    with tempfile.TemporaryFile() as printed:
        try:
            kept = os.dup(1)
        except OSError:  # no such thing as stdout
            kept = None
        if kept is not None:
            os.dup2(printed.fileno(), 1)
        try:
            with redirect_stdout(sys.stderr):
                yield
        finally:
            if kept is not None:
                os.dup2(kept, 1)
                os.close(kept)
            printed.seek(0)
            lines = printed.read().decode(errors="replace").splitlines()
            sys.stderr.writelines(f"{line}\n" for line in lines if not line.startswith("Info "))


@contextmanager
def geometry_faults() -> Iterator[None]:
    """Raise what is wrong with a geometry as a `ModelError`, as all bad input is."""
    from geometries.errors import GeometryError

    try:
        yield
    except GeometryError as error:
        raise ModelError(error.faults) from error
