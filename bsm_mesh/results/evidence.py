"""Evidence: the numbers besides forces that the check of a verdict needs, so that it works without the engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, Portable, show_only
from bsm_mesh.model.joint_laws import BartonBandis, Elastic, JointLaw, LadanyiArchambault, MohrCoulomb, Patton, Weaker
from bsm_mesh.model.strength import Reduced, law_name
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.model.supports import Bars

KINDS = {
    BartonBandis: "barton_bandis",
    Elastic: "elastic",
    LadanyiArchambault: "ladanyi_archambault",
    MohrCoulomb: "mohr_coulomb",
    Patton: "patton",
    Weaker: "weaker",
}
LawTable = tuple[Mapping[str, Any], ...]
STRENGTH_STATE = ("failed", "slip_path")  # state variables of contacts that a strength depends on


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class Evidence(Portable):
    """Strength and stiffness of the contacts, what holds the blocks, and how fast they are; rows as in `StageResult`.

    Attributes
    ----------
    laws : tuple of mapping
        Kind and parameters of the different laws [degrees, Pa] (`law_table`).
    law : (m,) int32
        Number of every contact's law there.
    failed : (m,) bool
        Asperities sheared off, cohesion and tension lost.
    slip_path : (m,) float64 [m]
        How far every contact has slid, elastic part apart.
    tension : (m,) float64 [N/m]
        Greatest tension that the contact carries; infinite: no bound.
    residual_tension : (m,) float64 or None [N/m]
        What of it one that has failed by slip may carry; None: nothing.
    closed_at : (m,) float64 or None [m]
        Opening below which the contact carries pressure, by the in-situ field and the like; dilation comes to it.
    dilation : (m, 2) float64 or None [-, m]
        Tangent of the dilation angle, and the slip path on which it has worn off; None: no joint dilates.
    normal_stiffness, shear_stiffness : (m,) float64 [N/m2]
        Of the contact's springs, per metre of thickness.
    near : (m,) bool
        Open contacts that close before a block moved by a thousandth of its size.
    bar_block : (k,) int32
        Block that each bar of the supports holds.
    bar_point, bar_direction : (k, 2) float64 [m, -]
        Where, and along which unit vector; the vector is zero where the bar holds the rotation.
    bar_turns : (k,) bool
        Whether the bar holds the rotation.
    weight : (n, 2) float64 [N/m]
        Weight of every block.
    bolt_pair : (l, 2) int32
        Row and column of the blocks of the bolts' tangent.
    bolt_tangent : (l, 3, 3) float64
        The blocks: derivatives of minus the bolts' forces by the movements.
    unit_weight : (n,) float64 or None [N/m3]
        Of the rock of every block; None in results of a former version.
    gravity : (2,) float64 or None
        Force over weight: gravity's direction, with an earthquake's part.
    load_block : (q,) int32 or None
        Block of every force that a load represents; None in results of a former version.
    load_point, load_force : (q, 2) float64 or None [m, N/m]
        Where it acts now, and the force.
    water_breaks : (k,) float64 or None [m]
        Where the straight pieces of the water table end; None: water presses otherwise than by a table alone.
    water_pieces : (k + 1, 3) float64 or None [m, -, Pa/m]
        Level at x = 0, slope, and pressure by depth of every piece; a level of -inf: no water.
    load_stiffness : (n, 3, 3) float64 or None
        Derivatives of minus loads and water by the movement of each block, symmetric part; None: all are zero.
    water_plane : (4,) float64 or None [-, -, m, N/m3]
        Of polyhedra: a, b, level and w of the pressure w (level - a x - b y - z) below a plane of head.
    water_face : (p,) int32 or None
        Faces of polyhedra with a pressure of their own.
    water_face_pressure : (p,) float64 or None [Pa]
        That pressure.
    water_part_block : (q, 2) int32 or None
        Blocks a and b that touch on parts of faces with a pressure of their own.
    water_part_corner, water_part_offsets : (k, 3) float64 [m], (q + 1,) int32 or None
        Corners of these parts as given, counter-clockwise from within a; where those of each begin.
    water_part_pressure : (q,) float64 or None [Pa]
        The pressure.
    outline : (q, 2) float64 or None [m]
        Corners of the blocks as they deformed, block after block; None: blocks have their given shapes.
    outline_offsets : (n + 1,) int32 or None
        Where those of each block begin.
    velocity : (n, 3) float64 or None [sqrt(m), sqrt(m), rad / sqrt(m)]
        Of blocks that are followed: its square is twice the height of a free fall to it.
    """

    laws: LawTable
    law: IntArray
    failed: BoolArray
    slip_path: FloatArray
    tension: FloatArray
    normal_stiffness: FloatArray
    shear_stiffness: FloatArray
    near: BoolArray
    bar_block: IntArray
    bar_point: FloatArray
    bar_direction: FloatArray
    bar_turns: BoolArray
    weight: FloatArray
    bolt_pair: IntArray
    bolt_tangent: FloatArray
    unit_weight: FloatArray | None = None
    gravity: FloatArray | None = None
    load_block: IntArray | None = None
    load_point: FloatArray | None = None
    load_force: FloatArray | None = None
    water_breaks: FloatArray | None = None
    water_pieces: FloatArray | None = None
    load_stiffness: FloatArray | None = None
    velocity: FloatArray | None = None
    residual_tension: FloatArray | None = None
    closed_at: FloatArray | None = None
    dilation: FloatArray | None = None
    water_plane: FloatArray | None = None
    outline: FloatArray | None = None
    outline_offsets: IntArray | None = None
    water_face: IntArray | None = None
    water_face_pressure: FloatArray | None = None
    water_part_block: IntArray | None = None
    water_part_corner: FloatArray | None = None
    water_part_offsets: IntArray | None = None
    water_part_pressure: FloatArray | None = None

    def __post_init__(self) -> None:
        show_only(self)

    @classmethod
    def as_given(cls, weight: FloatArray, bars: Bars) -> Evidence:
        """Return that of a model that was not run: weights and supports, no contacts."""
        none, flags = np.zeros(0), np.zeros(0, dtype=bool)
        return cls(
            laws=(),
            law=np.zeros(0, np.int32),
            failed=flags,
            slip_path=none,
            tension=none,
            normal_stiffness=none,
            shear_stiffness=none,
            near=flags,
            weight=weight,
            bolt_pair=np.zeros((0, 2), np.int32),
            bolt_tangent=np.zeros((0, 3, 3)),
            **bar_rows(bars, bars.point),
        )

    def in_whole(self, part: SubModel) -> Evidence:
        """Return a part's evidence in the numbers of the whole."""
        by_block = ("weight", "velocity", "unit_weight", "load_stiffness")
        numbered = ("bar_block", "bolt_pair", "load_block", "water_part_block")
        given = {name: getattr(self, name) for name in (*by_block, *numbered)}
        there = {name: values for name, values in given.items() if values is not None}
        changed: dict[str, Any] = {name: part.in_whole(there[name]) for name in by_block if name in there}
        changed |= {name: part.block[there[name]] for name in numbered if name in there}
        if self.water_face is not None:
            changed["water_face"] = part.corner[self.water_face]
        return replace(self, **changed)


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class Witness(Portable):
    """A mechanism that proves by virtual work that no forces within strength balance the loads where blocks were given.

    Attributes
    ----------
    velocity : (n, 3) float64
        Velocities u, v and theta of the blocks, the greatest of a centroid, or of rotation times radius of gyration, 1.
    loads : (n, 3) float64 [N/m, N/m, N]
        Weights, loads and water on the blocks where they were given.
    laws, law, tension : as in `Evidence`
        Strength of the contacts, none of which has failed.
    block_a, block_b : (m,) int32
        Blocks of the contacts of the given geometry.
    point, normal : (m, 2) float64 [m, -]
        Where the contacts are, and the outward normal of `block_b`.
    length : (m,) float64 [m]
        Of the face, represented by each.
    lines : (m, k, 2) float64 [-, N/m]
        Slope and intercept of the lines that bound the shear by the pressure; infinite intercept: no bound.
    bar_block, bar_point, bar_direction, bar_turns : as in `Evidence`
        The supports.
    node_block : (k,) int32
        Block of every node of the bolts.
    node_point : (k, 2) float64 [m]
        Where the nodes are.
    node_capacity : (k,) float64 [N/m]
        Greatest force on the rock, over the spacing; infinite: no bound.
    node_slip : (k,) float64
        Velocity of the bolt against the rock in the mechanism, towards the tip positive.
    element_node : (e,) int32
        First node of every element; the second is the next one.
    element_yield : (e,) float64 [N/m]
        Greatest tension, over the spacing; infinite: no bound.
    dowel_block : (d, 2) int32
        Blocks on both sides of every crossing that resists shear.
    dowel_point, dowel_across : (d, 2) float64 [m, -]
        Where, and the unit vector across the bolt.
    dowel_strength : (d,) float64 [N/m]
        Greatest shear, over the spacing; infinite: no bound.
    """

    velocity: FloatArray
    loads: FloatArray
    laws: LawTable
    law: IntArray
    tension: FloatArray
    block_a: IntArray
    block_b: IntArray
    point: FloatArray
    normal: FloatArray
    length: FloatArray
    lines: FloatArray
    bar_block: IntArray
    bar_point: FloatArray
    bar_direction: FloatArray
    bar_turns: BoolArray
    node_block: IntArray
    node_point: FloatArray
    node_capacity: FloatArray
    node_slip: FloatArray
    element_node: IntArray
    element_yield: FloatArray
    dowel_block: IntArray
    dowel_point: FloatArray
    dowel_across: FloatArray
    dowel_strength: FloatArray

    def __post_init__(self) -> None:
        show_only(self)

    def in_whole(self, part: SubModel) -> Witness:
        """Return a part's witness in the numbers of the whole; the other blocks do not move in it."""
        numbered = ("block_a", "block_b", "bar_block", "node_block", "dowel_block")
        return replace(
            self,
            velocity=part.in_whole(self.velocity),
            loads=part.in_whole(self.loads),
            **{name: part.block[getattr(self, name)] for name in numbered},
        )


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Proof:
    """Limit analysis of the start of an unstable stage.

    Attributes
    ----------
    text : str
        In words; where there is no witness, why.
    witness : Witness or None
        The mechanism.
    """

    text: str
    witness: Witness | None = None


OF_SHAKEN = Proof(text="no proof was sought: limit analysis is of blocks at rest, and these were shaken")


def law_table(laws: tuple[JointLaw, ...]) -> LawTable:
    """Return kind and parameters of laws; of one of the user's own its name alone."""
    return tuple(_described(law) for law in laws)


def _described(law: JointLaw) -> Mapping[str, Any]:
    kind = KINDS.get(type(law))
    if isinstance(law, Reduced):
        inner = _described(law.law)
        return inner if inner["kind"] == "own" else {"kind": "reduced", "factor": law.factor, "law": inner}
    if isinstance(law, Weaker):
        return {"kind": kind, "laws": [_described(law.one), _described(law.other)]}
    if kind is None:
        return {"kind": "own", "name": law_name(law)}
    return {"kind": kind, **asdict(law)}  # type: ignore[call-overload]


def bar_rows(bars: Bars, point: FloatArray) -> dict[str, Any]:
    """Return the fields of `Evidence` and `Witness` that describe bars, which hold at points (k, 2) [m]."""
    return {
        "bar_block": bars.block,
        "bar_point": point,
        "bar_direction": bars.direction,
        "bar_turns": bars.holds_rotation,
    }
