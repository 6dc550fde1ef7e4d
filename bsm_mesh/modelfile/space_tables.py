"""The tables of a model file of three dimensions: rock in a box or a mesh, joints, excavations, a slope, key blocks."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from bsm_mesh.model import quantities as q
from bsm_mesh.model.blocks import MERGE_TOLERANCE
from bsm_mesh.model.histories import History
from bsm_mesh.model.in_situ import InSitu
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.water import Water
from bsm_mesh.modelfile.bolt_tables import SpaceBoltTable
from bsm_mesh.modelfile.class_keys import keys_of
from bsm_mesh.modelfile.material_tables import JointTable, RockTable
from bsm_mesh.modelfile.mesh_tables import PathText, Table, finite
from bsm_mesh.modelfile.model_tables import FallsTable, OutputTable, ReportTable, SolverTable, StressRatio
from bsm_mesh.modelfile.units import Lines, SpaceForce, SpaceRegion, SpaceStress, SpaceStressTriple, Vector

Angle = Annotated[float, q.AZIMUTH]
Dip = Annotated[float, q.DIP]
Length = Annotated[float, q.JOINT_SPACING]


class DistributionTable(Table):
    """A distribution of spacings or radii."""

    law: Literal["normal", "lognormal", "exponential"] = Field(description="kind of distribution")
    mean: Length = Field(description="mean value")
    deviation: Length | None = Field(default=None, description="standard deviation; of normal and lognormal")


class ScatterTable(Table):
    """Scatter of a joint set's orientation."""

    fisher: Annotated[float, q.FISHER] = Field(description="Fisher's constant: 20 is wide, 200 narrow")


class RockBoxTable(Table):
    """The rock: a box that joints cut, or a mesh; x east, y north, z up."""

    box: Annotated[list[Vector], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="lower south-west and upper north-east corner: [[x, y, z], [x, y, z]]"
    )
    file: PathText | None = Field(
        default=None,
        description="instead of it: a mesh of volume elements, MSH 4.1, with the groups of [groups]; convex "
        "polyhedra, VTU; or separate stones, OBJ or STL",
    )
    geometry: PathText | None = Field(
        default=None, description="instead of them: a case of `bsm-mesh mesh --list`, or a .py file with build(path)"
    )
    parameters: dict[str, Annotated[Any, AfterValidator(finite)]] = Field(
        default_factory=dict, description="parameters of the geometry"
    )
    unit: str = Field(default="m", description="unit of length of the mesh")
    merge_tolerance: Annotated[float, q.MERGE_TOLERANCE] = Field(
        default=MERGE_TOLERANCE, description="nodes of the mesh nearer than this are one"
    )
    blocks: Literal["elements", "regions"] = Field(
        default="regions", description="of a mesh: every region between joints is a block, or every element"
    )
    rock: str | None = Field(
        default=None, description="rock of the box, or of elements in no group of one; the only one where there is one"
    )
    default_joint: str | None = Field(default=None, description="joint of faces between blocks that carry none")
    seed: Annotated[int, q.SEED] = Field(default=0, description="of the random numbers")
    allow_unused: bool = Field(
        default=False, description="true: a joint or bolt in the file that has no effect is a note, not an error"
    )
    contact_points: Literal["both", "corners"] = Field(
        default="both", description="of every face: corners and centroid, or corners"
    )


class JointSetTable(Table):
    """A set of joints: planes at a spacing, or discs by their area a volume."""

    name: str = Field(description="of the joint: [joint.NAME] has its properties")
    dip: Dip = Field(description="below the horizontal")
    dip_direction: Angle = Field(description="clockwise from north")
    spacing: Length | DistributionTable | None = Field(
        default=None, description="normal to the planes, or a distribution { law, mean, deviation }"
    )
    density: Annotated[float, q.JOINT_DENSITY] | None = Field(
        default=None, description="instead of spacing: area of joints per volume, with radius"
    )
    radius: Length | DistributionTable | None = Field(default=None, description="of the discs, or a distribution")
    origin: Vector | None = Field(default=None, description="a point on one of the planes")
    scatter: ScatterTable | None = Field(default=None, description="of the orientation; default: none")
    persistence: Annotated[float, q.PART] = Field(
        default=1.0, description="part of the cells crossed by a plane that it cuts, chosen at random"
    )


class JointPlaneTable(Table):
    """A single joint, or a disc."""

    name: str = Field(description="of the joint: [joint.NAME] has its properties")
    dip: Dip = Field(description="below the horizontal")
    dip_direction: Angle = Field(description="clockwise from north")
    point: Vector = Field(description="on the plane; the centre of a disc")
    radius: Length | None = Field(default=None, description="of a disc")


class AxisTable(Table):
    """Direction of an axis."""

    trend: Angle = Field(default=0.0, description="clockwise from north")
    plunge: Angle = Field(default=0.0, description="downwards from the level")


class BodyTable(Table):
    """A tunnel, cavern or shaft: a profile along an axis."""

    name: str = Field(description="stages excavate by it")
    polygon: Lines | None = Field(
        default=None, description="outline across the axis: to the right as one looks along it, and up"
    )
    profile: PathText | None = Field(default=None, description="instead of it: a CSV file with the columns x and z")
    axis: AxisTable = Field(default_factory=AxisTable, description="direction; default: level, to the north")
    origin: Vector = Field(default=(0.0, 0.0, 0.0), description="a point of the axis")
    start: Annotated[float, q.COORDINATE] | None = Field(
        default=None,
        alias="from",
        description="where it begins along the axis; without from and to it goes through",
    )
    end: Annotated[float, q.COORDINATE] | None = Field(default=None, alias="to", description="where it ends")


class SlopeFaceTable(Table):
    """Dip and dip direction of a slope's face or top."""

    dip: Dip = Field(description="below the horizontal")
    dip_direction: Angle | None = Field(default=None, description="clockwise from north")


class SlopeTable(Table):
    """A rock slope: the air in front of it and above it is taken away."""

    toe: Vector = Field(description="a point at the foot of the face; the ground before it is level")
    face: SlopeFaceTable = Field(description="dip and dip direction of the face")
    height: Length = Field(description="of the crest over the toe, straight up the face")
    top: SlopeFaceTable | None = Field(default=None, description="of the ground above the crest; level by default")


class KeyBlocksTable(Table):
    """Settings of the analysis of key blocks."""

    required: Annotated[float, q.REQUIRED_FACTOR] = Field(
        default=1.0, description="factor that the support pressure brings"
    )
    rounds: Annotated[int, q.ROUNDS] = Field(
        default=1, description="rounds; every unstable block is taken away in each"
    )
    free: list[str] = Field(
        default_factory=list,
        description="boundaries that are free: sides of the box (top, east, ...), groups of a mesh",
    )
    gravity: Annotated[list[Annotated[float, q.GRAVITY_PART]], Field(min_length=3, max_length=3)] | None = Field(
        default=None, description="force over weight [east, north, up], instead of that of [gravity]"
    )
    joint_pressure: dict[str, Annotated[float, q.PRESSURE]] = Field(
        default_factory=dict,
        description="water pressure on the faces of joints, by their names, instead of that of [water]",
    )


class SpaceSupportTable(Table):
    """A support: blocks or a boundary, held in all directions or across the boundary alone."""

    boundary: str | None = Field(default=None, description="NAME of the boundary that is supported")
    blocks: list[Annotated[int, q.BLOCK]] | None = Field(
        default=None, min_length=1, description="numbers of blocks that are supported"
    )
    fix: Literal["all", "normal"] = Field(description='"all": displacement and rotation; "normal": across the boundary')


class SpaceLoadTable(Table):
    """A load: on a boundary (one of pressure, traction, in_situ), or a force on a block at a point."""

    boundary: str | None = Field(default=None, description="NAME of the boundary that is loaded")
    in_situ: bool | None = Field(default=None, description="true: the traction that balances the field of [in_situ]")
    pressure: SpaceStress | None = Field(
        default=None, description="positive into the blocks; constant or [c, a_x, a_y, a_z]"
    )
    traction: SpaceStressTriple | None = Field(
        default=None,
        description="force per area [t_x, t_y, t_z], towards east, north, up; each constant or [c, a_x, a_y, a_z]",
    )
    block: Annotated[int, q.BLOCK] | None = Field(default=None, description="number of the block with the force")
    point: Vector | None = Field(default=None, description="of the force: east, north, up")
    force: SpaceForce | None = Field(default=None, description="towards east, north, up")


class SpaceGravityTable(Table):
    """Pseudo-static forces of an earthquake, in parts of the weights."""

    horizontal: Annotated[float, q.GRAVITY_PART] = Field(default=0.0, description="towards the trend")
    vertical: Annotated[float, q.GRAVITY_PART] = Field(default=0.0, description="upwards")
    trend: Angle | None = Field(
        default=None,
        description="of the horizontal part, clockwise from north; to the east by default; of a stage: the model's",
    )


class SpaceStressTable(Table):
    """Components of the total stress, tension positive."""

    xx: SpaceStress = Field(default=0.0, description="east; constant or [c, a_x, a_y, a_z]")
    yy: SpaceStress = Field(default=0.0, description="north, likewise")
    zz: SpaceStress = Field(default=0.0, description="vertical, likewise")
    xy: SpaceStress = Field(default=0.0, description="shear, likewise")
    yz: SpaceStress = Field(default=0.0, description="shear, likewise")
    xz: SpaceStress = Field(default=0.0, description="shear, likewise")


@keys_of(InSitu)
class SpaceInSituTable(Table):
    """The ground's stress before anything is dug: a level with k0 along a trend, or a stress."""

    surface: Annotated[float, q.COORDINATE] | None = Field(default=None, description="level of the ground")
    k0: StressRatio = Field(default=1.0, description="horizontal over vertical total stress, along the trend")
    k0_across: StressRatio | None = Field(default=None, description="the same across the trend; as k0 by default")
    trend: Angle | None = Field(default=None, description="where k0 acts, clockwise from north; default: to the north")
    stress: SpaceStressTable | None = None


class HeadPlaneTable(Table):
    """A plane of groundwater."""

    point: Vector = Field(description="on it")
    dip: Annotated[float, q.HEAD_DIP] = Field(default=0.0, description="its fall from the level")
    dip_direction: Angle = Field(default=0.0, description="clockwise from north")


@keys_of(Water, without=("table", "head", "plane"))
class SpaceWaterTable(Table):
    """Groundwater."""

    plane: HeadPlaneTable | None = Field(default=None, description="pressure grows with the vertical depth below it")
    joint_pressure: dict[str, Annotated[float, q.PRESSURE]] = Field(
        default_factory=dict, description="pressure in all faces of a joint between blocks, instead of the plane's"
    )


@keys_of(Stage, without=("loads", "water", "flow", "gravity", "gravity_trend", "shaking"))
class SpaceStageTable(Table):
    """A stage: excavation, fill and changes."""

    name: str = Field(description="in results and on the command line; each stage has its own")
    excavate: list[SpaceRegion] = Field(default_factory=list, description="names of excavations, block numbers")
    fill: list[SpaceRegion] = Field(
        default_factory=list, description="names of excavations or block numbers, taken away before"
    )
    relaxation: list[Annotated[float, q.RELAXATION]] = Field(
        default=[1.0], description="parts of the former forces released, one by one"
    )
    water: SpaceWaterTable | None = Field(default=None, description="the water from here on")
    load: list[SpaceLoadTable] = Field(default_factory=list)
    gravity: SpaceGravityTable | None = Field(
        default=None, description="pseudo-static earthquake from here on; default: as before"
    )
    strength: dict[str, Annotated[float, q.STRENGTH_FACTOR]] = Field(
        default_factory=dict,
        description='part of the given strength from here on, by joint; "*": all others; "rock:NAME": faces of a rock',
    )


@keys_of(History, without=("measured",))
class SpaceHistoryTable(Table):
    """The record at every step: exactly one of point, line, block, joint, bolt."""

    name: str = Field(description="the file is history_NAME.csv: letters, digits and _ . + -")
    point: Vector | None = Field(default=None, description="displacement of a point")
    line: list[Vector] | None = Field(
        default=None, description="extensometer: growth of the distance of each further point from the first"
    )
    block: Annotated[int, q.BLOCK] | None = Field(default=None, description="displacement and rotation of a block")


class SpaceFile(Table):
    """A model file of three dimensions. Numbers are SI, angles in degrees; a text has its unit."""

    schema_version: Literal[1] = Field(default=1, description="form of this file; one that is newer is refused")
    dimensions: Literal[3] = Field(description="3: blocks are polyhedra")
    title: str = Field(default="", description="in results, pictures and reports")
    mesh: RockBoxTable
    groups: dict[str, str] = Field(default_factory=dict, description='group of the mesh = "kind:name"')
    rock: dict[str, RockTable] = Field(min_length=1)
    joint: dict[str, JointTable] = Field(default_factory=dict)
    joint_set: list[JointSetTable] = Field(default_factory=list)
    joint_plane: list[JointPlaneTable] = Field(default_factory=list)
    excavation: list[BodyTable] = Field(default_factory=list)
    slope: SlopeTable | None = None
    key_blocks: KeyBlocksTable = Field(default_factory=KeyBlocksTable)
    support: list[SpaceSupportTable] = Field(default_factory=list)
    load: list[SpaceLoadTable] = Field(default_factory=list)
    bolt: list[SpaceBoltTable] = Field(default_factory=list)
    in_situ: SpaceInSituTable | None = None
    water: SpaceWaterTable | None = None
    gravity: SpaceGravityTable = Field(default_factory=SpaceGravityTable)
    stage: list[SpaceStageTable] = Field(default_factory=list)
    history: list[SpaceHistoryTable] = Field(default_factory=list)
    solver: SolverTable = Field(default_factory=SolverTable)
    falls: FallsTable = Field(default_factory=FallsTable)
    output: OutputTable = Field(default_factory=OutputTable)
    report: ReportTable = Field(default_factory=ReportTable)
