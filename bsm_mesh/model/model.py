"""The model: everything that is given, checked as a whole."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np

from bsm_mesh import doors, space
from bsm_mesh.arrays import FloatArray, content_hash
from bsm_mesh.errors import counted, raise_faults
from bsm_mesh.given import Given, by_default
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.face_water import FaceWater
from bsm_mesh.model.flow import Flow
from bsm_mesh.model.histories import History
from bsm_mesh.model.in_situ import InSitu
from bsm_mesh.model.kinds import AnyBlocks, in_space
from bsm_mesh.model.loads import (
    GIVEN_LOADS,
    ActingLoad,
    EdgeTractions,
    InSituTraction,
    Load,
    PointForces,
)
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.model_faults import model_faults
from bsm_mesh.model.options import Options
from bsm_mesh.model.quantities import DIRECTION, GRAVITY_PART
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.supports import GIVEN_SUPPORTS, Bars, Support, unit_vector
from bsm_mesh.model.values import Rules
from bsm_mesh.model.water import Water

if TYPE_CHECKING:
    from matplotlib.figure import Figure


PlanePoints = Literal["ends", "gauss"]
ContactPoints = PlanePoints | Literal["both", "corners"]
CONTACT_POINTS = ("ends", "gauss", "both", "corners")
DERIVED = (Bars, PointForces)  # what the program itself puts into a part of a model


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
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
        Joint of every face that carries none; None: such faces are unjointed rock.
    supports : tuple of support
        `Fixed`, `Roller`, `NormalRoller`, `PrescribedDisplacement`.
    loads : tuple of load
        `PointLoad`, `Pressure`, `Traction`, `EarthPressure`, `EdgeTractions`, `InSituTraction`.
    bolts : tuple of Bolt
        Rockbolts.
    gravity_direction : float [degrees]
        Direction in which the unit weights pull, from the x axis; -90 is down.
    gravity_horizontal, gravity_vertical : float
        Parts of the unit weights that pull besides, along +x and upwards: a pseudo-static earthquake. Water has none.
    gravity_trend : float or None [degrees]
        Of polyhedra: where the horizontal part pulls to, clockwise from north (+y); None: to the east, along +x.
    contact_points : {"ends", "gauss", "both", "corners"}
        Places of the two springs of a shared edge: its ends (the thesis) or its Gauss points. Of polyhedra the
        points of a shared face: ``"both"`` (or ``"ends"``), corners and centroid, or ``"corners"`` alone. Ends and
        corners alone are three times as stiff against bending as the edge or face itself.
    in_situ : InSitu or None
        Stress of the ground before the first stage; displacements then count from there.
    water : Water or None
        Groundwater at the start.
    flow : Flow or None
        Steady flow in the joints at the start, instead of `water`.
    face_water : FaceWater or None
        Pressures of flow on edges: a run puts it into the model that it solves.
    stages : tuple of Stage
        Excavation, fill and changes, in this order.
    histories : tuple of History
        The record at every step; it changes nothing of the result.
    options : Options or None
        How `bsm_mesh.run` solves it unless stated otherwise: of a model file, what its ``[solver]`` says.
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

    blocks: Given[Blocks, AnyBlocks] = by_default(field())
    rocks: Sequence[Rock]
    joints: Sequence[Joint] = ()
    default_joint: str | None = None
    supports: Sequence[Support] = ()
    loads: Sequence[Load] = ()
    bolts: Sequence[Bolt] = ()
    gravity_direction: Annotated[float, DIRECTION] = -90.0
    gravity_horizontal: Annotated[float, GRAVITY_PART] = 0.0
    gravity_vertical: Annotated[float, GRAVITY_PART] = 0.0
    gravity_trend: Annotated[float, DIRECTION] | None = field(default=None, metadata={"in_hash": "given"})
    contact_points: ContactPoints = "ends"
    in_situ: InSitu | None = None
    water: Water | None = None
    flow: Flow | None = None
    face_water: FaceWater | None = None
    stages: Sequence[Stage] = ()
    histories: Sequence[History] = field(default=(), metadata={"in_hash": False})
    options: Options | None = field(default=None, metadata={"in_hash": False})
    title: str = field(default="", metadata={"in_hash": False})

    def __post_init__(self) -> None:
        self._own_parts()
        raise_faults(model_faults(self))

    def _own_parts(self) -> None:
        """Hold every field to its kind; what belongs together is looked at only once these are right."""
        rules = Rules("model")
        if not in_space(self.blocks):
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
        rules.text("title", self.title, free=True)
        rules.choice("contact_points", self.contact_points, CONTACT_POINTS)
        rules.a_thing("in_situ", self.in_situ, InSitu, optional=True)
        rules.a_thing("water", self.water, Water, optional=True)
        rules.a_thing("flow", self.flow, Flow, optional=True)
        rules.a_thing("face_water", self.face_water, FaceWater, optional=True)
        if self.options is not None:
            rules.a_thing("options", self.options, Options, optional=True)
        rules.numbers(self)
        raise_faults(rules.faults)

    def __repr__(self) -> str:
        counts = {"support": self.supports, "load": self.loads, "bolt": self.bolts, "stage": self.stages}
        parts = [counted(len(things), noun) for noun, things in counts.items() if things]
        parts += [name for name in ("in_situ", "water", "flow") if getattr(self, name) is not None]
        title = f"Model {self.title!r}" if self.title else "Model"
        return f"{title}: {', '.join(parts) or 'no supports and no loads'}\n{self.blocks!r}"

    def __eq__(self, other: object) -> bool:
        """Return whether the two models have the same content, title, histories and options aside."""
        return isinstance(other, Model) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def plot(
        self,
        *,
        window: tuple[float, float, float, float] | None = None,
        figure: Figure | None = None,
        look: tuple[float, float] | None = None,
    ) -> Figure:
        """Return a picture of the model as it is given: rocks, joints, supports, loads, bolts, water.

        Parameters
        ----------
        window : (x0, y0, x1, y1), optional [m]
            The visible part.
        figure : matplotlib.figure.Figure, optional
            The figure to draw on; by default one of its own, to be saved (``savefig``) or shown by a notebook.
        look : (azimuth, plunge), optional [degrees]
            View of polyhedra: clockwise from north, and downwards from the level.
        """
        return doors.plot_model(self, window, figure, look)

    def _repr_html_(self) -> str | None:
        """Return its table for a notebook; None for polyhedra, which have a text."""
        return None if in_space(self.blocks) else doors.model_html(self)

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
        """Weight of every block, per metre of thickness, (n_blocks,) [N/m] (Wang Eq. 3.36); in space [N]."""
        weights: FloatArray = self.unit_weights * self.blocks.moments.bulk
        return weights

    @property
    def gravity_vector(self) -> FloatArray:
        """Force over weight, (2,): the unit vector of the direction, with an earthquake's part.

        In space (3,): weights pull down, and the horizontal part pulls to its trend.
        """
        horizontal, vertical = self.gravity_horizontal, self.gravity_vertical
        if in_space(self.blocks):
            trend = 90.0 if self.gravity_trend is None else self.gravity_trend
            return np.append(horizontal * unit_vector(90.0 - trend), vertical - 1.0)
        vector: FloatArray = unit_vector(self.gravity_direction) + np.array([horizontal, vertical])
        return vector

    @property
    def gravity_forces(self) -> FloatArray:
        """Weight, with an earthquake's part, on every block's centroid, (n_blocks, 2) [N/m] (Wang Eq. 3.37)."""
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
        if in_space(self.blocks):
            return tuple(
                space.in_situ_forces(self, load.boundary) if isinstance(load, InSituTraction) else load
                for load in loads
            )
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
