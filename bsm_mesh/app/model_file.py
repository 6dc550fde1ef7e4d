"""The model file: its typed schema, and faults told by key and place."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, ValidationError

from bsm_mesh.app.units import (
    Angle,
    Force,
    Length,
    LinearStress,
    LinearStressPair,
    Point,
    Stiffness,
    Stress,
    UnitWeight,
)
from bsm_mesh.errors import ModelError, nearest
from bsm_mesh.model.blocks import MERGE_TOLERANCE
from bsm_mesh.model.materials import RockStiffness
from bsm_mesh.model.model import ContactPoints
from bsm_mesh.solve.options import LinearSolverName, Scheme


def _fix(value: object) -> object:
    if value in ("normal", "all") or (isinstance(value, list) and value in (["x"], ["y"], ["x", "y"], ["y", "x"])):
        return value
    raise ValueError('must be "normal", "all", ["x"], ["y"] or ["x", "y"]')


Fix = Annotated[
    Literal["normal", "all"] | list[Literal["x", "y"]],
    PlainValidator(_fix, json_schema_input_type=Literal["normal", "all"] | list[Literal["x", "y"]]),
]


class Table(BaseModel):
    """A table of the file; a key that it does not know is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class MeshTable(Table):
    """Where the blocks come from."""

    file: str | None = Field(default=None, description="mesh file, any format that meshio reads; relative to this file")
    geometry: str | None = Field(
        default=None, description="a case of `bsm-mesh mesh --list`, or a .py file with build(path)"
    )
    parameters: dict[str, Any] = Field(default_factory=dict, description="parameters of the geometry")
    unit: str = Field(default="m", description="unit of length of the mesh")
    merge_tolerance: Length = Field(default=MERGE_TOLERANCE, description="nodes nearer than this are one")
    contact_points: ContactPoints = "ends"
    blocks: Literal["elements"] = Field(default="elements", description="every element is a rigid block")
    default_joint: str | None = Field(default=None, description="joint of every face that bears none")


class RockTable(Table):
    """A rock."""

    unit_weight: UnitWeight = 0.0
    young: Stress | None = None
    poisson: float | None = None
    cohesion: Stress | None = None
    friction: Angle | None = None
    tensile_strength: Stress | None = None
    stiffness: RockStiffness = "wang"


class FillingTable(Table):
    """A joint's filling."""

    thickness: Length
    young: Stress
    poisson: float


class JointTable(Table):
    """A joint or joint set."""

    normal_stiffness: Stiffness | None = None
    shear_stiffness: Stiffness | None = None
    filling: FillingTable | None = None
    law: Literal["patton", "mohr_coulomb"] | None = Field(
        default=None, description="patton where friction is given without it"
    )
    friction: Angle | None = None
    dilation: Angle | None = None
    cohesion: Stress | None = None
    residual_friction: Angle | None = None
    tensile_strength: Stress = 0.0


class SupportTable(Table):
    """A support: where (one of boundary, blocks, point) and what it holds (fix, or direction)."""

    boundary: str | None = None
    blocks: list[int] | None = None
    point: Point | None = None
    fix: Fix | None = None
    direction: Angle | None = None
    displacement: Length | None = None


class LoadTable(Table):
    """A load: on a boundary (pressure or traction), or a force on a block at a point."""

    boundary: str | None = None
    pressure: LinearStress | None = Field(default=None, description="positive into the blocks")
    traction: LinearStressPair | None = None
    block: int | None = None
    point: Point | None = None
    force: Force | None = None


class GravityTable(Table):
    """Gravity."""

    direction: Angle = -90.0


class SolverTable(Table):
    """How to solve."""

    scheme: Scheme = "linear"
    tolerance: float = 1e-6
    linear_solver: LinearSolverName = "auto"
    threads: int = 0


class OutputTable(Table):
    """Where results go."""

    folder: str = Field(default="out", description="relative to the model file")


class ModelFile(Table):
    """A bsm-mesh model file. Numbers are SI, angles in degrees; a text bears its unit: "6.89 GPa"."""

    title: str = ""
    mesh: MeshTable
    groups: dict[str, str] = Field(default_factory=dict, description='mesh group = "kind:name"; "*": all others')
    rock: dict[str, RockTable] = Field(min_length=1)
    joint: dict[str, JointTable] = Field(default_factory=dict)
    support: list[SupportTable] = Field(default_factory=list)
    load: list[LoadTable] = Field(default_factory=list)
    gravity: GravityTable = Field(default_factory=GravityTable)
    solver: SolverTable = Field(default_factory=SolverTable)
    output: OutputTable = Field(default_factory=OutputTable)


def read_model_file(path: Path) -> ModelFile:
    """Return the content of a model file.

    Raises
    ------
    ModelError
        If the file is missing or no TOML, or with every key and value that is wrong.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ModelError(f"{path}: there is no such file") from None
    except IsADirectoryError:
        raise ModelError(f"{path} is a folder; give the model file in it (model.toml)") from None
    except UnicodeDecodeError:
        raise ModelError(f"{path}: not a text file; a model file is TOML") from None
    except OSError as error:
        raise ModelError(f"{path}: cannot be read: {error.strerror}") from None
    except tomllib.TOMLDecodeError as error:
        raise ModelError(f"{path}: not valid TOML: {error}") from None
    try:
        return ModelFile.model_validate(content)
    except ValidationError as error:
        raise ModelError([f"{path.name}: {text}" for text in dict.fromkeys(_sentences(error))]) from None


def _sentences(error: ValidationError) -> Iterator[str]:
    for fault in error.errors(include_url=False):
        path = list(_path(fault["loc"]))
        message = fault["msg"].removeprefix("Value error, ")
        if fault["type"] == "extra_forbidden":
            yield f"{_place(path[:-1])}: unknown key '{path[-1]}'{nearest(str(path[-1]), _known_keys(path[:-1]))}"
        elif fault["type"] == "missing":
            yield f"{_place(path[:-1])}: needs the key '{path[-1]}'"
        elif fault["type"] in ("model_type", "model_attributes_type", "dict_type"):
            yield f"{_place(path)}: must be a table of keys, not {fault['input']!r}"
        else:
            yield f"{_place(path)} = {_shown(fault['input'])}: {message[0].lower()}{message[1:]}"


def _shown(value: object) -> str:
    text = f'"{value}"' if isinstance(value, str) else f"{value}"
    return text if len(text) < 60 else f"{text[:57]}..."


def _path(loc: tuple[int | str, ...]) -> Iterator[int | str]:
    """Return the keys of pydantic's location, without its names for the members of a union."""
    table: type[BaseModel] | None = ModelFile
    free = False  # the next part is a user's own name or a number
    for part in loc:
        if free or isinstance(part, int):
            free = False
            yield part
        elif table is not None and part in table.model_fields:
            annotation = table.model_fields[part].annotation
            table, free = _table_in(annotation), "dict[" in str(annotation)
            yield part
        elif table is not None:
            yield part  # unknown to the table: the fault itself
            table = None


def _table_in(annotation: Any) -> type[Table] | None:
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return annotation
    found = (_table_in(part) for part in get_args(annotation))
    return next((table for table in found if table is not None), None)


def _known_keys(path: list[int | str]) -> list[str]:
    table: type[Table] | None = ModelFile
    for part in path:
        if table is not None and part in table.model_fields:
            table = _table_in(table.model_fields[str(part)].annotation)
    return list(table.model_fields) if table is not None else []


def _place(path: list[int | str]) -> str:
    """Return ``[rock.gneiss] young`` or ``[[support]] number 2, fix``."""
    if not path:
        return "top level"
    field = ModelFile.model_fields.get(str(path[0]))
    if field is not None and len(path) > 1 and isinstance(path[1], int):
        rest = ".".join(str(part) for part in path[2:])
        return f"[[{path[0]}]] number {path[1] + 1}" + (f", {rest}" if rest else "")
    if field is None or _table_in(field.annotation) is None:
        return ".".join(str(part) for part in path)
    depth = 2 if "dict[" in str(field.annotation) else 1
    table, rest = ".".join(str(p) for p in path[:depth]), ".".join(str(p) for p in path[depth:])
    return f"[{table}]" + (f" {rest}" if rest else "")
