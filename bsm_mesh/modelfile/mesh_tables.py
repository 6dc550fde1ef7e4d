"""The mesh in the model file: its source, boundaries by place, lines laid over it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PlainValidator
from pydantic.fields import FieldInfo

from bsm_mesh.model import quantities as q
from bsm_mesh.model.blocks import MERGE_TOLERANCE
from bsm_mesh.model.model import PlanePoints
from bsm_mesh.modelfile.units import LINES_SCHEMA, Point, lines_of


def _path_text(value: str) -> str:
    if not value or "\0" in value:
        raise ValueError("must be the name of a file or folder")
    return value


PathText = Annotated[str, AfterValidator(_path_text)]


def finite(value: Any) -> Any:
    """Refuse numbers in a value that are infinite or none: no size of a geometry is."""
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError("must be a finite number")
    for part in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        finite(part)
    return value


class Table(BaseModel):
    """A table of the file; a key that it does not know is an error.

    `meant` has the cure for names that users write for another key.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)
    meant: ClassVar[Mapping[str, str]] = {}

    @classmethod
    def by_key(cls) -> dict[str, FieldInfo]:
        """Return the fields by their keys; one whose key is a word of Python's has another name."""
        return {field.alias or name: field for name, field in cls.model_fields.items()}


class MeshTable(Table):
    """Where the blocks come from."""

    file: PathText | None = Field(
        default=None, description="mesh file, any format that meshio reads; relative to this file"
    )
    geometry: PathText | None = Field(
        default=None, description="a case of `bsm-mesh mesh --list`, or a .py file with build(path)"
    )
    parameters: dict[str, Annotated[Any, AfterValidator(finite)]] = Field(
        default_factory=dict, description="parameters of the geometry"
    )
    unit: str = Field(default="m", description="unit of length of the mesh")
    merge_tolerance: Annotated[float, q.MERGE_TOLERANCE] = Field(
        default=MERGE_TOLERANCE, description="nodes nearer than this are one"
    )
    contact_points: PlanePoints = Field(
        default="ends", description="contact points of a face: its two ends, or two Gauss points"
    )
    blocks: Literal["elements", "regions"] = Field(
        default="elements", description="every element is a rigid block, or every region between joints is one"
    )
    default_joint: str | None = Field(default=None, description="joint of every face without one")
    allow_unused: bool = Field(
        default=False, description="true: a name in the file that the mesh does not have is a note, not an error"
    )


class LineFile(Table):
    """A file of lines: CSV, DXF, GeoJSON, shapefile or GeoPackage."""

    file: PathText = Field(description="relative to the model file")
    set: str | None = Field(default=None, description="the set, or layer, of these lines; left out: all")
    scale: Annotated[float, q.UNIT_OF_LENGTH] | None = Field(
        default=None, description="the file's unit of length in m; left out: the one that the file names, else 1 m"
    )


def _along(value: object) -> object:
    if isinstance(value, str):
        value = {"file": value}
    return LineFile.model_validate(value) if isinstance(value, dict) else lines_of(value)


class _AlongSchema:
    """The JSON Schema of `Along`, made where it is asked for: the table of a file needs time."""

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        return {"anyOf": [{"type": "string"}, LineFile.model_json_schema(), LINES_SCHEMA]}


Along = Annotated[Any, PlainValidator(_along), _AlongSchema()]
Border = Annotated[tuple[str, str], Field(min_length=2, max_length=2)]


class BoundaryTable(Table):
    """A boundary by place: edges of the rim both of whose ends are where all that is given holds."""

    below: Annotated[float, q.COORDINATE] | None = Field(default=None, description="greatest y")
    above: Annotated[float, q.COORDINATE] | None = Field(default=None, description="least y")
    left_of: Annotated[float, q.COORDINATE] | None = Field(default=None, description="greatest x")
    right_of: Annotated[float, q.COORDINATE] | None = Field(default=None, description="least x")
    along: list[Point] | None = Field(
        default=None, description="a line along which they lie; of faces of excavations too"
    )
