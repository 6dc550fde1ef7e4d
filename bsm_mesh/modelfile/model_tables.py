"""The model file's tables: a typed schema of their keys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, PlainValidator, WithJsonSchema, model_validator

from bsm_mesh.model import quantities as q
from bsm_mesh.model.earth_pressure import EarthPressure
from bsm_mesh.model.falls import Falls
from bsm_mesh.model.histories import History
from bsm_mesh.model.in_situ import PARTS_OF_RATIO, STRESS_RATIOS, InSitu
from bsm_mesh.model.options import Options
from bsm_mesh.model.quantity import convert, schema_of
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.water import Water
from bsm_mesh.modelfile.bolt_tables import BoltTable
from bsm_mesh.modelfile.class_keys import keys_of
from bsm_mesh.modelfile.flow_tables import FlowChangeTable, FlowTable
from bsm_mesh.modelfile.material_tables import JointTable, RockTable
from bsm_mesh.modelfile.mesh_tables import BoundaryTable, MeshTable, PathText, Table
from bsm_mesh.modelfile.record_files import UNITS, amplitude_of
from bsm_mesh.modelfile.units import Force, Level, LinearStress, LinearStressPair, Lines, Point, Region


def _fix(value: object) -> object:
    if value in ("normal", "all") or (isinstance(value, list) and value in (["x"], ["y"], ["x", "y"], ["y", "x"])):
        return value
    raise ValueError('must be "normal", "all", ["x"], ["y"] or ["x", "y"]')


Fix = Annotated[
    Literal["normal", "all"] | list[Literal["x", "y"]],
    PlainValidator(_fix, json_schema_input_type=Literal["normal", "all"] | list[Literal["x", "y"]]),
]


class SupportTable(Table):
    """A support: where (one of boundary, blocks, point) and its content (fix, or direction)."""

    boundary: str | None = Field(default=None, description="NAME of the boundary that is supported")
    blocks: list[Annotated[int, q.BLOCK]] | None = Field(
        default=None, min_length=1, description="numbers of blocks that are supported at their centroids"
    )
    point: Point | None = Field(default=None, description="x and y; the block there is supported at this point")
    fix: Fix | None = Field(
        default=None,
        description='"all": x and y, of blocks rotation too; "normal": across the boundary; ["x"], ["y"] or both',
    )
    direction: Annotated[float, q.DIRECTION] | None = Field(
        default=None, description="instead of fix: of the supported component, from x, counter-clockwise"
    )
    displacement: Annotated[float, q.DISPLACEMENT] | None = Field(
        default=None, description="prescribed along the direction; default: 0"
    )


@keys_of(EarthPressure, without=("boundary",))
class EarthPressureTable(Table):
    """Pressure of soil or backfill."""

    surface: Level = Field(description="level of the ground, or two points of its straight line")


class LoadTable(Table):
    """A load: on a boundary (one of pressure, traction, earth_pressure, in_situ), or a force on a block at a point."""

    boundary: str | None = Field(default=None, description="NAME of the boundary that is loaded")
    in_situ: bool | None = Field(default=None, description="true: the traction that balances the field of [in_situ]")
    pressure: LinearStress | None = Field(default=None, description="positive into the blocks")
    traction: LinearStressPair | None = Field(
        default=None, description="force per area [t_x, t_y], positive along x and y; each constant or [c, a_x, a_y]"
    )
    earth_pressure: EarthPressureTable | None = Field(default=None, description="of soil or backfill on the boundary")
    block: Annotated[int, q.BLOCK] | None = Field(default=None, description="number of the block with the force")
    point: Point | None = Field(default=None, description="x and y of the force")
    force: Force | None = Field(default=None, description="[f_x, f_y] per metre of thickness")


class GravityTable(Table):
    """Gravity."""

    direction: Annotated[float, q.DIRECTION] = Field(
        default=-90.0, description="of the weights, from x, counter-clockwise; -90: downwards"
    )
    horizontal: Annotated[float, q.GRAVITY_PART] = Field(
        default=0.0, description="part of the unit weights that pulls along +x besides: a pseudo-static earthquake"
    )
    vertical: Annotated[float, q.GRAVITY_PART] = Field(default=0.0, description="the same, upwards")


class StageGravityTable(Table):
    """Pseudo-static forces from a stage on, in parts of the weights."""

    horizontal: Annotated[float, q.GRAVITY_PART] = Field(default=0.0, description="along +x")
    vertical: Annotated[float, q.GRAVITY_PART] = Field(default=0.0, description="upwards")


RATIO_PARTS = dict(zip("abc", PARTS_OF_RATIO, strict=True))


def _stress_ratio(value: object) -> object:
    if isinstance(value, str) and value in STRESS_RATIOS:
        return value
    if isinstance(value, int | float) and not isinstance(value, bool):
        return convert(value, q.STRESS_RATIO)
    if isinstance(value, dict) and value and set(value) <= set(RATIO_PARTS):
        return {key: _part_of_ratio(key, part) for key, part in value.items()}
    names = ", ".join(f'"{name}"' for name in STRESS_RATIOS)
    raise ValueError(f"must be a number, {{a, b, c}} for K = a / h + b + c h at the depth h, or one of {names}")


def _part_of_ratio(key: str, part: object) -> object:
    try:
        return convert(part, RATIO_PARTS[key])
    except ValueError as error:
        raise ValueError(f"{key} {error}") from None


StressRatio = Annotated[
    Any,
    PlainValidator(_stress_ratio),
    WithJsonSchema(
        {
            "anyOf": [
                schema_of(q.STRESS_RATIO),
                {"enum": list(STRESS_RATIOS)},
                {
                    "type": "object",
                    "properties": {key: schema_of(part) for key, part in RATIO_PARTS.items()},
                    "additionalProperties": False,
                },
            ]
        }
    ),
]


class StressTable(Table):
    """Components of the total stress, tension positive."""

    xx: LinearStress = Field(default=0.0, description="horizontal; constant or [c, a_x, a_y]: c + a_x x + a_y y")
    yy: LinearStress = Field(default=0.0, description="vertical, likewise")
    xy: LinearStress = Field(default=0.0, description="shear, likewise")


@keys_of(InSitu, without=("k0_across", "trend"))
class InSituTable(Table):
    """The ground's stress before anything is dug: a surface with k0, or a stress."""

    surface: Level | None = Field(default=None, description="level of the ground, or its line from left to right")
    k0: StressRatio = Field(default=1.0, description="horizontal over vertical total stress")
    stress: StressTable | None = None


@keys_of(Water, without=("plane",))
class WaterTable(Table):
    """Groundwater."""

    table: Lines = Field(default=(), description="the water table from left to right, or several tables")
    joint_pressure: dict[str, Annotated[float, q.PRESSURE]] = Field(
        default_factory=dict, description="pressure in all faces of a joint"
    )


class MassDampingTable(Table):
    """Drag on all blocks by their masses: part of critical damping at a frequency."""

    ratio: Annotated[float, q.DAMPING] = Field(description="part of critical damping")
    frequency: Annotated[float, q.FREQUENCY] = Field(description="at which a block has this part")


@keys_of(Shaking, without=("record", "mass_damping"))
class ShakingTable(Table):
    """Shaking of all supports together or of a quiet boundary, by a record or a waveform."""

    meant: ClassVar[Mapping[str, str]] = {
        name: f'write record, or waveform with frequency and amplitude, and quantity = "{name}"' for name in UNITS
    }
    record: PathText | list[list[Annotated[float, q.MOTION]]] | None = Field(
        default=None,
        description="table (CSV) of time and acceleration, velocity or stress, units in its header, or a file of PEER "
        "(.at2), relative to the model file; or [times, values] in s and m/s^2, m/s or Pa",
    )
    amplitude: (
        Annotated[float, q.MOTION, WithJsonSchema({"anyOf": [schema_of(q.MOTION), {"type": "string"}]})] | None
    ) = Field(
        default=None,
        description="of the waveform, by quantity: [m/s^2] of an acceleration, [m/s] of a velocity, [Pa] of a stress; "
        'or a text with its unit, such as "0.15 g"',
    )
    mass_damping: MassDampingTable | None = Field(default=None, description="drag on all blocks; default: none")

    @model_validator(mode="before")
    @classmethod
    def _read_amplitude(cls, given: Any) -> Any:
        """Read an amplitude with its unit, which depends on the quantity."""
        quantity = given.get("quantity", "acceleration") if isinstance(given, dict) else None
        if quantity not in UNITS or not isinstance(given.get("amplitude"), str):
            return given
        return {**given, "amplitude": amplitude_of(given["amplitude"], quantity)}


@keys_of(Stage, without=("loads", "gravity_trend", "shaking"))
class StageTable(Table):
    """A stage: excavation, fill and changes."""

    name: str = Field(description="in results and on the command line; each stage has its own")
    excavate: list[Region] = Field(default_factory=list, description="groups, block numbers, polygons")
    fill: list[Region] = Field(default_factory=list, description="blocks taken away before")
    relaxation: list[Annotated[float, q.RELAXATION]] = Field(
        default=[1.0], description="parts of the former forces released, one by one"
    )
    water: WaterTable | None = None
    flow: FlowChangeTable | None = Field(default=None, description="changes of the flow in the joints")
    load: list[LoadTable] = Field(default_factory=list)
    strength: dict[str, Annotated[float, q.STRENGTH_FACTOR]] = Field(
        default_factory=dict,
        description='part of the given strength from here on, by joint; "*": all others; "rock:NAME": faces of a rock',
    )
    gravity: StageGravityTable | None = Field(
        default=None, description="pseudo-static earthquake from here on; default: as before"
    )
    shaking: ShakingTable | None = Field(default=None, description="how the ground is shaken; nothing else changes")


OneOrSeveral = Annotated[
    list[PathText],
    BeforeValidator(
        lambda value: [value] if isinstance(value, str) else value, json_schema_input_type=str | list[PathText]
    ),
]


@keys_of(History)
class HistoryTable(Table):
    """The record at every step: exactly one of point, line, block, joint, bolt."""

    name: str = Field(description="the file is history_NAME.csv: letters, digits and _ . + -")
    point: Point | None = Field(default=None, description="displacement of a point")
    line: list[Point] | None = Field(
        default=None, description="extensometer: growth of the distance of each further point from the first"
    )
    block: Annotated[int, q.BLOCK] | None = Field(default=None, description="displacement and rotation of a block")
    measured: OneOrSeveral = Field(
        default_factory=list, description="tables (CSV) of values to be compared with it, relative to the model file"
    )


@keys_of(Options, without=("falls",))
class SolverTable(Table):
    """How to solve."""


@keys_of(Falls)
class FallsTable(Table):
    """The treatment of unstable blocks."""


class OutputTable(Table):
    """Where results go."""

    folder: PathText | None = Field(
        default=None, description="relative to the model file; default: out/NAME for the model file NAME.toml"
    )
    snapshots: Literal["stages", "steps"] = Field(
        default="stages", description="contents of the PVD files: the end of every stage, or all steps as well"
    )
    tables: bool | Literal["csv", "parquet"] = Field(
        default=False, description="blocks, contacts, supports and joints as tables too: as CSV (true) or Parquet"
    )
    compression: Literal["zlib", "lz4"] = Field(
        default="zlib", description="of the VTU files: zlib is read by everything, lz4 is quicker and read by VTK only"
    )


class ReportTable(Table):
    """The head of reports."""

    project: str = Field(default="", description="name of the project")
    author: str = Field(default="", description="author of the report")
    date: str = Field(default="", description="as it is to be there")


class ModelFile(Table):
    """A bsm-mesh model file. Numbers are SI, angles in degrees; a text has its unit: "6.89 GPa"."""

    schema_version: Literal[1] = Field(default=1, description="form of this file; one that is newer is refused")
    title: str = Field(default="", description="in results, pictures and reports")
    mesh: MeshTable
    groups: dict[str, str] = Field(default_factory=dict, description='mesh group = "kind:name"; "*": all others')
    rock: dict[str, RockTable] = Field(min_length=1)
    joint: dict[str, JointTable] = Field(default_factory=dict)
    boundary: dict[str, BoundaryTable] = Field(default_factory=dict, description="boundaries by place")
    support: list[SupportTable] = Field(default_factory=list)
    load: list[LoadTable] = Field(default_factory=list)
    bolt: list[BoltTable] = Field(default_factory=list)
    gravity: GravityTable = Field(default_factory=GravityTable)
    in_situ: InSituTable | None = None
    water: WaterTable | None = None
    flow: FlowTable | None = Field(default=None, description="steady flow in the joints, instead of water")
    stage: list[StageTable] = Field(default_factory=list)
    history: list[HistoryTable] = Field(default_factory=list)
    solver: SolverTable = Field(default_factory=SolverTable)
    falls: FallsTable = Field(default_factory=FallsTable)
    output: OutputTable = Field(default_factory=OutputTable)
    report: ReportTable = Field(default_factory=ReportTable)
