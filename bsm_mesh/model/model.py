"""The model: everything that is given, checked as a whole."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Literal, get_args

import numpy as np

from bsm_mesh.arrays import FloatArray, content_hash
from bsm_mesh.errors import ModelError, listing, nearest, raise_faults
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolt_layout import label, pass_blocks
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.face_water import FaceWater
from bsm_mesh.model.flow import Flow
from bsm_mesh.model.flow_faults import flow_faults
from bsm_mesh.model.histories import History, history_faults
from bsm_mesh.model.in_situ import InSitu
from bsm_mesh.model.loads import (
    GIVEN_LOADS,
    ActingLoad,
    EdgeTractions,
    InSituTraction,
    Load,
    PointForces,
    PointLoad,
    point_forces_of,
)
from bsm_mesh.model.locate import blocks_at
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.quantities import DIRECTION, GRAVITY_PART
from bsm_mesh.model.stages import Stage, presence
from bsm_mesh.model.strength import strength_faults
from bsm_mesh.model.supports import GIVEN_SUPPORTS, Bars, Support, bars_of, unit_vector
from bsm_mesh.model.values import Rules
from bsm_mesh.model.water import Water

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from bsm_mesh.solve.options import Options

DEEPEST = 1e4  # m: deeper than any mine
ContactPoints = Literal["ends", "gauss"]
DERIVED = (Bars, PointForces)  # what the program itself puts into a part of a model


@dataclass(frozen=True, eq=False, kw_only=True)
class Model:
    """Blocks with their rocks, joints, supports and loads.

    Attributes
    ----------
    blocks : Blocks
        The rigid blocks.
    rocks : tuple of Rock
        A rock for every name in ``blocks.rock_names``; others may be there too.
    joints : tuple of Joint
        A joint for every name in ``blocks.joint_names``.
    default_joint : str or None
        Joint of every face that bears none; None: such faces are unjointed rock.
    supports : tuple of support
        `Fixed`, `Roller`, `NormalRoller`, `PrescribedDisplacement`.
    loads : tuple of load
        `PointLoad`, `Pressure`, `Traction`, `EdgeTractions`, `InSituTraction`.
    bolts : tuple of Bolt
        Rockbolts.
    gravity_direction : float [degrees]
        Direction in which the unit weights pull, from the x axis; -90 is down.
    gravity_horizontal, gravity_vertical : float
        Parts of the unit weights that pull besides, along +x and upwards: a pseudo-static earthquake. Water has none.
    contact_points : {"ends", "gauss"}
        Where the two springs of a shared edge stand: at its ends (the thesis) or at its Gauss points.
    in_situ : InSitu or None
        Stress of the ground before the first stage; displacements then count from there.
    water : Water or None
        Groundwater at the start.
    flow : Flow or None
        Steady flow in the joints at the start, instead of `water`.
    face_water : FaceWater or None
        What flow presses with on edges: a run puts it into the model that it solves.
    stages : tuple of Stage
        What is taken away, put back and changed, in this order.
    histories : tuple of History
        What is recorded at every step; it changes nothing of what comes out.
    options : Options or None
        How `bsm_mesh.run` solves it where it is not told otherwise: of a model file, what its ``[solver]`` says.
    title : str
        For tables and pictures.

    Raises
    ------
    ModelError
        With every fault found: names that do not exist, values out of range, points outside their block.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> model = bsm.Model(
    ...     blocks=bsm.Blocks.from_polygons(
    ...         [[(0, 0), (3, 0), (3, 1), (0, 1)], [(1, 1), (2, 1), (2, 2), (1, 2)]], rock="granite"
    ...     ),
    ...     rocks=[bsm.Rock("granite", unit_weight=26e3)],
    ...     joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=35))],
    ...     default_joint="J1",
    ...     supports=[bsm.Fixed(blocks=[0])],
    ... )
    >>> model.blocks.count, model.rocks[0].name
    (2, 'granite')
    >>> model.replace(gravity_horizontal=0.1).gravity_horizontal
    0.1
    """

    blocks: Blocks
    rocks: tuple[Rock, ...]
    joints: tuple[Joint, ...] = ()
    default_joint: str | None = None
    supports: tuple[Support, ...] = ()
    loads: tuple[Load, ...] = ()
    bolts: tuple[Bolt, ...] = ()
    gravity_direction: Annotated[float, DIRECTION] = -90.0
    gravity_horizontal: Annotated[float, GRAVITY_PART] = 0.0
    gravity_vertical: Annotated[float, GRAVITY_PART] = 0.0
    contact_points: ContactPoints = "ends"
    in_situ: InSitu | None = None
    water: Water | None = None
    flow: Flow | None = None
    face_water: FaceWater | None = None
    stages: tuple[Stage, ...] = ()
    histories: tuple[History, ...] = field(default=(), metadata={"in_hash": False})
    options: Options | None = field(default=None, metadata={"in_hash": False})
    title: str = field(default="", metadata={"in_hash": False})

    def __post_init__(self) -> None:
        self._own_parts()
        raise_faults(_faults(self))

    def _own_parts(self) -> None:
        """Hold every field to its kind; what belongs together is looked at only once these are right."""
        rules = Rules("model")
        rules.a_thing("blocks", self.blocks, Blocks)
        lists: dict[str, tuple[type, ...]] = {
            "rocks": (Rock,),
            "joints": (Joint,),
            "supports": GIVEN_SUPPORTS,
            "loads": GIVEN_LOADS,
            "bolts": (Bolt,),
            "stages": (Stage,),
            "histories": (History,),
        }
        for name, kinds in lists.items():
            object.__setattr__(self, name, rules.things(name, getattr(self, name), *kinds, derived=DERIVED))
        rules.text("default_joint", self.default_joint, optional=True)
        rules.text("title", self.title)
        rules.choice("contact_points", self.contact_points, get_args(ContactPoints))
        rules.a_thing("in_situ", self.in_situ, InSitu, optional=True)
        rules.a_thing("water", self.water, Water, optional=True)
        rules.a_thing("flow", self.flow, Flow, optional=True)
        rules.a_thing("face_water", self.face_water, FaceWater, optional=True)
        if self.options is not None:
            from bsm_mesh.solve.options import Options

            rules.a_thing("options", self.options, Options, optional=True)
        rules.numbers(self)
        raise_faults(rules.faults)

    def __eq__(self, other: object) -> bool:
        """Return whether the two models have the same content, title, histories and options aside."""
        return isinstance(other, Model) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def plot(self, *, window: tuple[float, float, float, float] | None = None, figure: Figure | None = None) -> Figure:
        """Return a picture of the model as it is given: rocks, joints, supports, loads, bolts, water.

        Parameters
        ----------
        window : (x0, y0, x1, y1), optional [m]
            What is seen.
        figure : matplotlib.figure.Figure, optional
            What is drawn on; by default a figure of its own, to be saved (``savefig``) or shown by a notebook.
        """
        from bsm_mesh.app.plotting import plot_model

        return plot_model(self, window, figure)

    def _repr_html_(self) -> str:
        """Return what a notebook shows of it."""
        from bsm_mesh.app.notebook import model_html

        return model_html(self)

    @property
    def digest(self) -> str:
        """SHA-256 of the content: equal models have equal digests."""
        return content_hash(self)

    @property
    def unit_weights(self) -> FloatArray:
        """Unit weight of every block [N/m3]."""
        by_name = {rock.name: rock.unit_weight for rock in self.rocks}
        return np.array([by_name[name] for name in self.blocks.rock_names])[self.blocks.rock]

    @property
    def weights(self) -> FloatArray:
        """Weight of every block, per metre of thickness, (n_blocks,) [N/m] (Wang Eq. 3.36)."""
        weights: FloatArray = self.unit_weights * self.blocks.moments.area
        return weights

    @property
    def gravity_vector(self) -> FloatArray:
        """Force over weight, (2,): the unit vector of the direction, and what an earthquake adds."""
        earthquake = np.array([self.gravity_horizontal, self.gravity_vertical])
        vector: FloatArray = unit_vector(self.gravity_direction) + earthquake
        return vector

    @property
    def gravity_forces(self) -> FloatArray:
        """Weight, with what an earthquake adds, on every block's centroid, (n_blocks, 2) [N/m] (Wang Eq. 3.37)."""
        forces: FloatArray = self.weights[:, None] * self.gravity_vector
        return forces

    @property
    def acting_loads(self) -> tuple[ActingLoad, ...]:
        """The loads, with those that balance the in-situ field worked out."""
        return self.worked_out(self.loads)

    def worked_out(self, loads: Sequence[Load]) -> tuple[ActingLoad, ...]:
        """Return loads with those that balance the in-situ field of this model worked out."""
        derived = [load for load in loads if isinstance(load, InSituTraction)]
        if not derived:
            return tuple(load for load in loads if not isinstance(load, InSituTraction))
        from bsm_mesh.model.stress_field import StressField  # compiled code: not before it is needed

        field = StressField(self)

        def acting(load: Load) -> ActingLoad:
            if not isinstance(load, InSituTraction):
                return load
            values = field.equivalent_tractions(self.blocks.boundary_edges(load.boundary))
            return EdgeTractions(boundary=load.boundary, values=values)

        return tuple(acting(load) for load in loads)

    def replace(self, **changes: object) -> Model:
        """Return a copy with some fields changed, checked anew."""
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]  # checked by __post_init__


def _faults(model: Model) -> list[str]:
    """Return one sentence for everything in the model that does not fit together."""
    blocks = model.blocks
    faults: list[str] = []
    rock_names = [rock.name for rock in model.rocks]
    joint_names = [joint.name for joint in model.joints]
    for kind, names in (("rock", rock_names), ("joint", joint_names)):
        twice = [name for name, count in Counter(names).items() if count > 1]
        faults.extend(f"{kind} '{name}' is defined more than once; remove all but one" for name in twice)
    faults.extend(_missing("rock", blocks.rock_names, rock_names, blocks.rock, "block", "blocks"))
    faults.extend(_missing("joint", blocks.joint_names, joint_names, blocks.edge_joint, "edge", "edges"))
    if model.default_joint is not None and model.default_joint not in joint_names:
        faults.append(
            f"default_joint: there is no joint '{model.default_joint}'{nearest(model.default_joint, joint_names)}"
        )
    try:
        bars_of(model.supports, blocks)
    except ModelError as error:
        faults.extend(error.faults)
    for number, load in enumerate(model.loads):
        faults.extend(f"load {number + 1} ({type(load).__name__}): {text}" for text in _load_faults(load, model))
    faults.extend(_ground_faults(model, joint_names))
    faults.extend(flow_faults(model))
    bolt_names = [bolt.name or f"bolt {number + 1}" for number, bolt in enumerate(model.bolts)]
    faults.extend(history_faults(model.histories, blocks, joint_names, bolt_names))
    stage_faults = list(_stage_faults(model, joint_names))
    return [*faults, *stage_faults, *([] if stage_faults else _bolt_faults(model))]


def _bolt_faults(model: Model) -> Sequence[str]:
    names = [stage.name for stage in model.stages]
    unknown = [
        f"{label(model.bolts, k)}: there is no stage '{bolt.stage}'{nearest(bolt.stage, names)}"
        for k, bolt in enumerate(model.bolts)
        if bolt.stage is not None and bolt.stage not in names
    ]
    if unknown or not model.bolts:
        return unknown
    try:
        pass_blocks(model.bolts, model.blocks, model.stages)
    except ModelError as error:
        return error.faults
    return []


def _ground_faults(model: Model, joint_names: Sequence[str]) -> Iterable[str]:
    in_situ = model.in_situ
    if in_situ is not None and in_situ.surface is not None and model.gravity_direction != -90:
        yield (
            f"in_situ: surface means ground under gravity straight down; gravity.direction is "
            f"{model.gravity_direction:g} degrees: give the field as stress = {{xx, yy, xy}}"
        )
    elif in_situ is not None and in_situ.surface is not None:
        yield from _surface_faults(in_situ, model.blocks)
    if model.water is not None:
        yield from _water_faults("water", model.water, model.blocks, joint_names)


def _surface_faults(in_situ: InSitu, blocks: Blocks) -> Iterable[str]:
    """Say where the ground's surface is too far from the model, or the horizontal stress below it would pull."""
    depth = in_situ.level(blocks.vertices[:, 0]) - blocks.vertices[:, 1]
    low, high = blocks.vertices[:, 1].min(), blocks.vertices[:, 1].max()
    where = f"the model reaches from y = {low:.6g} m to {high:.6g} m; check the level and its unit"
    if depth.max() <= 0:
        yield f"in_situ: the whole model lies above the surface, where the ground has no stress: {where}"
    elif depth.min() > DEEPEST:
        yield f"in_situ: the surface lies {depth.min():.6g} m above the model, at most {DEEPEST:g} m are taken: {where}"
    a, b, c = in_situ.k0
    if depth.max() > 0 > a / depth.max() + b + c * depth.max():
        yield (
            f"in_situ: k0 = {a:g} / h + {b:g} {c:+g} h makes the horizontal stress a tension at the depth "
            f"{depth.max():.6g} m; raise c"
        )


def _water_faults(place: str, water: Water, blocks: Blocks, joint_names: Sequence[str]) -> Iterable[str]:
    for name in water.joint_pressure:
        if name not in joint_names:
            yield f"{place}: joint_pressure: there is no joint '{name}'{nearest(name, joint_names)}"
    left, right = blocks.extent
    for line in water.table:
        if len(line) > 1 and (line[-1][0] < left or line[0][0] > right):
            yield (
                f"{place}: the table runs from x = {line[0][0]:g} m to {line[-1][0]:g} m, outside the model "
                f"({left:g} m to {right:g} m); check its coordinates and units (one point alone is a level everywhere)"
            )
    depth = water.surface().at(blocks.vertices[:, 0]) - blocks.vertices[:, 1]
    if depth.min() > DEEPEST:
        low, high = blocks.vertices[:, 1].min(), blocks.vertices[:, 1].max()
        yield (
            f"{place}: the table lies {depth.min():.6g} m above the model, at most {DEEPEST:g} m are taken: the model "
            f"reaches from y = {low:.6g} m to {high:.6g} m; check the levels and their unit"
        )


def _stage_faults(model: Model, joint_names: Sequence[str]) -> Iterable[str]:
    names = [stage.name for stage in model.stages]
    yield from (
        f"stage '{name}' is defined more than once; rename all but one" for name, k in Counter(names).items() if k > 1
    )
    try:
        presence(model.stages, model.blocks)
    except ModelError as error:
        yield from error.faults
    for stage in model.stages:
        for number, load in enumerate(stage.loads):
            for text in _load_faults(load, model):
                yield f"stage '{stage.name}': load {number + 1} ({type(load).__name__}): {text}"
        if stage.water is not None:
            yield from _water_faults(f"stage '{stage.name}': water", stage.water, model.blocks, joint_names)
        yield from (f"stage '{stage.name}': {text}" for text in strength_faults(model, stage.strength))


def _missing(
    kind: str, used: Sequence[str], defined: Sequence[str], index: np.ndarray, thing: str, things: str
) -> Iterable[str]:
    for number, name in enumerate(used):
        where = np.flatnonzero(index == number)
        if name not in defined and where.size:
            hint = nearest(name, defined) if defined else ""
            yield (
                f"{kind} '{name}' of {where.size} {thing if where.size == 1 else things} ({listing(where, 4)}) is not "
                f"defined; define it, [{kind}.{name}] in a model file{hint}"
            )


def _load_faults(load: Load, model: Model) -> list[str]:
    blocks = model.blocks
    if isinstance(load, InSituTraction):
        if load.boundary not in blocks.boundaries:
            return [f"there is no boundary '{load.boundary}'{nearest(load.boundary, blocks.boundaries)}"]
        if model.in_situ is None or not model.in_situ.describes_field:
            return ["in_situ = true needs the field: give [in_situ] with surface and k0, or stress = {xx, yy, xy}"]
        return []
    if not isinstance(load, PointLoad):
        try:
            point_forces_of([load], blocks)
        except ModelError as error:
            return list(error.faults)
        return []
    if not 0 <= load.block < blocks.count:
        return [f"there is no block {load.block}; blocks are numbered 0 to {blocks.count - 1}"]
    if load.block not in blocks_at(blocks, load.point):
        centre = blocks.moments.centroid[load.block]
        return [
            f"the point ({load.point[0]:g}, {load.point[1]:g}) is not in block {load.block}, "
            f"whose centroid is ({centre[0]:g}, {centre[1]:g})"
        ]
    return []
