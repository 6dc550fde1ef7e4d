"""Key blocks round an opening or in a slope: mode, factor of safety, weight and support of blocks at free faces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray, IntArray
from bsm_mesh.contact.strength import peak_strength
from bsm_mesh.errors import ModelError, nearest, raise_faults
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.joint_laws.law import JointLaw
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.model import Model
from bsm_mesh.model.values import is_number
from bsm_mesh.three_d.blocks.materials import Materials
from bsm_mesh.three_d.blocks.polygons import sums
from bsm_mesh.three_d.blocks.polyhedra import SLOPE, Polyhedra
from bsm_mesh.three_d.key_blocks.installed import pulls_of
from bsm_mesh.three_d.key_blocks.loads import RockLoads
from bsm_mesh.three_d.key_blocks.modes import FALLS, HELD, NOT_JUDGED, ONE, TWO, Movement, movements, removable
from bsm_mesh.three_d.key_blocks.record import KeyBlocks
from bsm_mesh.three_d.key_blocks.walls import Planes, Wall, planes_of, wall_of

HALVINGS = 40  # of the support pressure: to 1e-12 of where it is sought
MOST_PRESSURE = 10.0  # times the weight over the free face, and times the factor required: no support is sought beyond


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class _Given:
    """Loads on blocks, and the strength of their faces."""

    blocks: Polyhedra
    laws: tuple[JointLaw | None, ...]
    law: IntArray
    bound: BoolArray  # of contact polygons: whether they bear no more than their law
    loads: RockLoads
    weight: FloatArray  # (n,) [N]
    bolts: tuple[Bolt, ...]
    free: Sequence[str]  # boundaries


def key_blocks(
    blocks: Polyhedra | Model,
    *,
    rocks: Sequence[Rock] = (),
    joints: Sequence[Joint] = (),
    free: Sequence[str] | None = None,
    excavated: Sequence[str] | None = None,
    default_joint: str | None = None,
    bolts: Sequence[Bolt] = (),
    gravity: Sequence[float] | None = None,
    joint_pressure: Mapping[str, float] | None = None,
    required: float = 1.0,
    rounds: int = 1,
) -> KeyBlocks:
    """Return how every block at a free face moves by block theory, and its factor of safety by limit equilibrium.

    Blocks translate; stress around them counts for nothing (Goodman & Shi 1985; Hoek & Bray 1981, Appendix 2).

    Parameters
    ----------
    blocks : Polyhedra or Model
        The rock. A model has materials, bolts, and gravity, water and loads before its stages; its supports do nothing.
    rocks, joints : sequence of Rock, of Joint
        Unit weights, and laws of the joints; a joint without a law does not slip.
    free, excavated : sequence of str, optional
        Free boundaries and open excavations, by default ``"slope"`` and all. Other outer faces hold their blocks.
    default_joint : str, optional
        Joint of the faces between blocks that carry none; else they are faces of rock.
    bolts : sequence of Bolt
        Installed bolts, of any stage; each pulls its block towards its tip with all that it carries.
    gravity : (float, float, float), optional
        Force over weight: the model's or straight down by default, with parts to the side for an earthquake.
    joint_pressure : mapping of str to float, optional [Pa]
        Water pressure on the faces of joints, by their names; other joints have that of the model's water.
    required : float
        Factor of safety with the support pressure.
    rounds : int
        Number of analyses; each further one is without the blocks below the required factor and their bolts.

    Raises
    ------
    ModelError
        For names that do not exist, values out of range, and where no block has a free face.

    Examples
    --------
    >>> import bsm_mesh as bsm  # four cubes in a level roof reach no side of the rock: they fall
    >>> from bsm_mesh.geometries import three_d
    >>> sets = [three_d.JointSet(name="J", dip=d, dip_direction=a, spacing=1) for d, a in ((0, 0), (90, 0), (90, 90))]
    >>> cut = three_d.cut_cells(three_d.RockMass(box=((0, 0, 0), (3, 3, 3)), joints=sets))
    >>> joint = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30))
    >>> rock, blocks = bsm.Rock("rock", unit_weight=26e3), bsm.Polyhedra.from_cells(cut)
    >>> bsm.key_blocks(blocks, rocks=[rock], joints=[joint], free=["bottom"]).modes.count("falls")
    4
    """
    if isinstance(blocks, Polyhedra):
        blocks = Model(blocks=blocks, rocks=rocks, joints=joints, default_joint=default_joint, bolts=bolts)
    _check_numbers(required, rounds)
    given, present = _given(blocks, gravity, joint_pressure or {}, *_openings(blocks, free, excavated))
    return _in_rounds(given, present, float(required), rounds)


def _in_rounds(given: _Given, present: BoolArray, required: float, rounds: int) -> KeyBlocks:
    """Return the blocks at free faces, and those that come to lie there as others are taken away."""
    blocks = given.blocks
    found: KeyBlocks | None = None
    for number in range(1, rounds + 1):
        wall = wall_of(blocks, given.free, present)
        if not len(wall.block):
            break
        pull = pulls_of(given.bolts, blocks, present)[wall.block]
        load = given.loads.on_blocks(present)[wall.block, :3]
        now = _analysed(given, wall, planes_of(blocks, wall, present), load, pull, required, number)
        found = now if found is None else found.and_then(now)
        gone = now.block[now.round == number]
        if not len(gone):
            break
        present[gone] = False
    if found is None:
        raise ModelError("key blocks: no block has a free face; name boundaries along openings, or excavations")
    return found


def _openings(
    model: Model, free: Sequence[str] | None, excavated: Sequence[str] | None
) -> tuple[Sequence[str], Sequence[str]]:
    """Return the names of free boundaries and of open excavations, those of the command by default."""
    rock = getattr(model, "blocks", model)
    if not in_space(rock):
        raise ModelError("key blocks: the blocks must be bsm.Polyhedra(...); in the plane run the model")
    slope = [SLOPE] if SLOPE in rock.boundaries else []
    return slope if free is None else free, list(rock.excavations) if excavated is None else excavated


def _check_numbers(required: object, rounds: object) -> None:
    """Raise for a required factor and a number of rounds that are none."""
    faults = []
    if not is_number(required) or required <= 0:  # type: ignore[operator]
        faults.append(f"key blocks: required = {required!r} must be a number above 0")
    if not isinstance(rounds, int) or rounds < 1:
        faults.append(f"key blocks: rounds = {rounds!r} must be a whole number of at least 1")
    raise_faults(faults)


def _given(
    model: Model,
    gravity: Sequence[float] | None,
    joint_pressure: Mapping[str, float],
    free: Sequence[str],
    excavated: Sequence[str],
) -> tuple[_Given, BoolArray]:
    """Return the checked input, and which blocks are present."""
    blocks: Any = model.blocks
    materials = Materials.checked(blocks, model.rocks, model.joints, model.default_joint)
    faults = [
        f"{kind}: there is no {kind} '{name}'{nearest(name, known)}"
        for kind, names, known in (
            ("boundary", free, blocks.boundaries),
            ("excavation", excavated, blocks.excavations),
            ("joint", joint_pressure, blocks.joint_names),
        )
        for name in names
        if name not in known
    ]
    parts = [0.0, 0.0, -1.0] if gravity is None else list(gravity)
    if len(parts) != 3 or not all(is_number(part) for part in parts):
        faults.append(f"key blocks: gravity = {gravity!r} must be three numbers (east, north, up)")
    faults += [
        f"key blocks: joint_pressure of '{name}' = {value!r} must be a number of at least 0 Pa"
        for name, value in joint_pressure.items()
        if not is_number(value) or value < 0
    ]
    raise_faults(faults)
    polygons = blocks.contact_polygons
    laws, law, tension = materials.laws(blocks, np.stack([polygons.block_a, polygons.block_b]), polygons.joint)
    present = np.ones(blocks.count, dtype=bool)
    for name in excavated:
        present[blocks.excavations[name]] = False
    given = _Given(
        blocks=blocks,
        laws=laws,
        law=law,
        bound=np.isfinite(tension),
        loads=RockLoads(model, gravity, joint_pressure),
        weight=blocks.moments.volume * materials.unit_weights(blocks),
        bolts=tuple(model.bolts),
        free=free,
    )
    return given, present


def _analysed(
    given: _Given, wall: Wall, planes: Planes, load: FloatArray, pull: FloatArray, required: float, number: int
) -> KeyBlocks:
    """Return the blocks of a wall, with loads and pulls of bolts on them (n, 3) [N]."""
    blocks = given.blocks
    can = removable(planes.normals) & ~wall.held
    movement, factor = _moved(given, planes, load, can)
    _, bolted = _moved(given, planes, load + pull, can)
    volume = blocks.moments.volume[wall.block]
    sliver = np.zeros(blocks.count, dtype=bool)
    sliver[blocks.slivers] = True
    return KeyBlocks(
        block=wall.block,
        mode=np.where(wall.held, NOT_JUDGED, movement.mode).astype(np.int8),
        held=wall.held,
        round=np.where(bolted < required * (1 - ROUNDING), number, 0).astype(np.int32),
        factor=factor,
        pull=np.linalg.norm(pull, axis=1),
        bolted_factor=bolted,
        bolted_support=_support(given, wall, planes, load + pull, can, bolted, required),
        direction=movement.direction,
        joints=_joints_of(blocks, planes, movement.planes),
        centroid=blocks.moments.centroid[wall.block],
        volume=volume,
        weight=given.weight[wall.block],
        area=wall.area,
        apex=wall.apex,
        trace=wall.trace,
        support=_support(given, wall, planes, load, can, factor, required),
        sliver=sliver[wall.block],
        free_faces=wall.face,
        required=required,
        joint_names=blocks.joint_names,
    )


def _moved(given: _Given, planes: Planes, load: FloatArray, can: BoolArray) -> tuple[Movement, FloatArray]:
    """Return how blocks move under loads (n, 3) [N], and their factors of safety."""
    movement = movements(planes.normals, load)
    mode = np.where(can, movement.mode, HELD).astype(np.int8)
    movement = replace(movement, mode=mode, planes=np.where(can[:, None], movement.planes, -1))
    slides = (mode == ONE) | (mode == TWO)
    factor = np.where(mode == FALLS, 0.0, np.inf)
    factor[slides] = (_strength(given, planes, movement) / np.where(slides, movement.driving, 1.0))[slides]
    movement = replace(movement, direction=np.where((mode == HELD)[:, None], 0.0, movement.direction))
    return movement, factor


def _strength(given: _Given, planes: Planes, movement: Movement) -> FloatArray:
    """Return the shear strength of the planes on which blocks slide, (n,) [N]; the force is shared out by area."""
    total = np.zeros(len(movement.mode))
    area = given.blocks.contact_polygons.area[planes.polygon]
    for slot in (0, 1):
        plane = movement.planes[planes.row, slot]
        face = np.flatnonzero((plane >= 0) & (plane == planes.plane))
        rows, part = planes.row[face], area[face] / planes.area[planes.row[face], planes.plane[face]]
        pressure = movement.normal_force[rows, slot] * part
        number, strength = given.law[planes.polygon[face]], np.full(len(face), np.inf)
        for k, law in enumerate(given.laws):
            chosen = np.flatnonzero((number == k) & given.bound[planes.polygon[face]])
            if law is not None and chosen.size:
                strength[chosen] = peak_strength(law, pressure[chosen], area[face[chosen]])
        total += sums(rows, strength, len(total))
    return total


def _support(
    given: _Given, wall: Wall, planes: Planes, load: FloatArray, can: BoolArray, factor: FloatArray, required: float
) -> FloatArray:
    """Return the least uniform pressure on free faces that gives the required factor, (n,) [Pa], by halving."""
    size = np.linalg.norm(wall.outward, axis=1)
    low = np.zeros(len(load))
    high = MOST_PRESSURE * max(required, 1.0) * np.linalg.norm(load, axis=1) / np.maximum(size, 1e-300)

    def suffices(pressure: FloatArray) -> BoolArray:
        return np.asarray(_moved(given, planes, load - pressure[:, None] * wall.outward, can)[1] >= required)

    needed = factor < required * (1 - ROUNDING)
    if not needed.any():
        return low
    found = suffices(high)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        enough = suffices(middle)
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    return np.where(needed, np.where(found, high, np.nan), 0.0)


def _joints_of(blocks: Polyhedra, planes: Planes, slid: IntArray) -> IntArray:
    """Return the joints of planes (n, 2), each by its largest face; -1 for none."""
    found = np.full(slid.shape, -1, np.int32)
    joint = blocks.contact_polygons.joint[planes.polygon]
    for slot in (0, 1):
        face = np.flatnonzero(slid[planes.row, slot] == planes.plane)[::-1]  # the largest last, so that it stays
        found[planes.row[face], slot] = joint[face]
    return found
