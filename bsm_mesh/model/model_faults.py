"""Contradictions within a model: one sentence for every fault, with its cure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh import space
from bsm_mesh.errors import ModelError, counted, gathered, nearest, place
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolt_layout import label, pass_blocks
from bsm_mesh.model.flow_faults import flow_faults, water_weight_faults
from bsm_mesh.model.histories import history_faults
from bsm_mesh.model.in_situ import IN_PLANE, InSitu
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import InSituTraction, Load, PointLoad, point_forces_of
from bsm_mesh.model.locate import blocks_at
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.stages import presence
from bsm_mesh.model.strength import strength_faults
from bsm_mesh.model.supports import Fixed, Target, bars_of, points_down
from bsm_mesh.model.water import Water
from bsm_mesh.model.zones import zone_faults, zones_in_space

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model

DEEPEST = 1e4  # m: deeper than any mine


def model_faults(model: Model) -> list[str]:
    """Return one sentence for everything in the model that does not fit together."""
    blocks = model.blocks
    if in_space(blocks):
        found = [*space.faults_in_space(model), *zones_in_space(model)]
        return [*found, *([] if found else _bolt_faults(model))]
    faults: list[str] = []
    if model.contact_points not in ("ends", "gauss"):
        faults.append(
            f'contact_points = "{model.contact_points}" is for polyhedra; in the plane give "ends" or "gauss"'
        )
    trends = {"model": model.gravity_trend} | {f"stage '{s.name}'": s.gravity_trend for s in model.stages}
    faults += [f"{place}: gravity_trend is for polyhedra; leave it out" for place, t in trends.items() if t is not None]
    rock_names = [rock.name for rock in model.rocks]
    joint_names = [joint.name for joint in model.joints]
    for kind, names in (("rock", rock_names), ("joint", joint_names)):
        twice = [name for name, count in Counter(names).items() if count > 1]
        faults.extend(f"{kind} '{name}' is defined more than once; remove all but one" for name in twice)
    middle = (blocks.vertices + blocks.vertices[blocks.following]) / 2
    centroid = blocks.moments.centroid
    faults.extend(_missing("rock", blocks.rock_names, rock_names, blocks.rock, "block", centroid))
    faults.extend(_missing("joint", blocks.joint_names, joint_names, blocks.edge_joint, "block edge", middle))
    if model.default_joint is not None and model.default_joint not in joint_names:
        faults.append(
            f"default_joint: there is no joint '{model.default_joint}'{nearest(model.default_joint, joint_names)}"
        )
    with gathered(faults):
        bars_of(model.supports, blocks)
    for number, load in enumerate(model.loads):
        faults.extend(f"load {number + 1} ({type(load).__name__}): {text}" for text in _load_faults(load, model))
    faults.extend(_ground_faults(model, joint_names))
    faults.extend(flow_faults(model))
    faults.extend(zone_faults(model))
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
    with gathered(unknown):
        pass_blocks(model.bolts, model.blocks, model.stages)
    return unknown


def _ground_faults(model: Model, joint_names: Sequence[str]) -> Iterable[str]:
    in_situ = model.in_situ
    if in_situ is not None and (
        in_situ.k0_across is not None or in_situ.trend is not None or len(in_situ.stress or IN_PLANE) > len(IN_PLANE)
    ):
        yield "in_situ: k0_across, trend and the components zz, yz, xz are for polyhedra; leave them out"
    elif in_situ is not None and in_situ.surface is not None and not points_down(model.gravity_direction):
        yield (
            f"in_situ: surface means ground under gravity straight down; gravity_direction is "
            f"{model.gravity_direction!r} degrees: give -90, or the field as stress = {{xx, yy, xy}}"
        )
    elif in_situ is not None and in_situ.surface is not None:
        yield from _surface_faults(in_situ, model.blocks)
    if model.water is not None:
        yield from _water_faults("water", model.water, model, joint_names)


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


def _water_faults(place: str, water: Water, model: Model, joint_names: Sequence[str]) -> Iterable[str]:
    blocks = model.blocks
    if water.plane is not None:
        yield f"{place}: plane is for polyhedra; in the plane give table"
    yield from water_weight_faults(place, water.unit_weight, model)
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
            yield from _water_faults(f"stage '{stage.name}': water", stage.water, model, joint_names)
        yield from (f"stage '{stage.name}': {text}" for text in strength_faults(model, stage.strength))
        if stage.shaking is not None:
            yield from (f"stage '{stage.name}': shaking: {text}" for text in _shaking_faults(model, stage.shaking))


def _shaking_faults(model: Model, shaking: Shaking) -> Iterable[str]:
    """Return a sentence for everything with which blocks cannot be shaken."""
    yield from _quiet_faults(model, shaking)
    if model.flow is not None:
        yield "flow in joints is not followed in time; give [water] with a still table instead of [flow]"
    if shaking.integrator == "implicit" and shaking.dashpots > 0:
        for joint in model.joints:
            if joint.max_closure is not None or joint.dilation_angle > 0 or joint.reference_stress is not None:
                yield (
                    f"contact_damping with integrator = 'implicit' needs linear springs, and joint '{joint.name}' has "
                    "max_closure, dilation_angle or reference_stress; set integrator = 'explicit'"
                )
    used = {model.blocks.rock_names[number] for number in np.unique(model.blocks.rock)}
    for rock in model.rocks:
        if rock.unit_weight == 0 and rock.name in used:
            yield f"rock '{rock.name}' has unit_weight 0, so no mass; give its unit weight"


def _quiet_faults(model: Model, shaking: Shaking) -> Iterable[str]:
    """Return a sentence for every quiet boundary that cannot be one."""
    blocks = model.blocks
    supported = {support.boundary for support in model.supports if isinstance(support, Target)}
    fixed = np.zeros(blocks.count, dtype=bool)
    for support in model.supports:
        if isinstance(support, Fixed) and support.blocks:
            fixed[[block for block in support.blocks if block < blocks.count]] = True
        elif isinstance(support, Fixed) and support.boundary in {*blocks.boundaries}.difference(shaking.quiet):
            fixed[blocks.owner[blocks.boundary_edges(support.boundary)]] = True
    for name in shaking.quiet:
        if name not in blocks.boundaries:
            yield f"quiet: there is no boundary '{name}'{nearest(name, blocks.boundaries)}"
        elif name not in supported:
            yield f"quiet: boundary '{name}' has no support; give it one, which holds it before it is shaken"
        elif len(edges := blocks.boundary_edges(name)) and fixed[blocks.owner[edges]].all():
            yield f"quiet: other supports fix all blocks at boundary '{name}', so no wave passes; remove these supports"


def _missing(
    kind: str, used: Sequence[str], defined: Sequence[str], index: np.ndarray, thing: str, point: np.ndarray
) -> Iterable[str]:
    """Report names in use without a definition, with the places of the first things; `point` (n, 2): of each [m]."""
    for number, name in enumerate(used):
        where = np.flatnonzero(index == number)
        if name not in defined and where.size:
            hint = nearest(name, defined) if defined else ""
            at = list(dict.fromkeys(place(one.round(3)) for one in point[where[:8]]))  # both sides of a joint are once
            few = ", ".join(at[:3]) + (", ..." if len(at) > 3 else "")
            yield (
                f"{kind} '{name}' of {counted(where.size, thing)} (at {few}) is not defined; "
                f"define it, [{kind}.{name}] in a model file{hint}"
            )


def faults_of_in_situ_load(load: InSituTraction, model: Model) -> list[str]:
    """Return a sentence where a load that balances the in-situ stress has no boundary, or no stress is given."""
    known = model.blocks.boundaries
    if load.boundary not in known:
        return [f"there is no boundary '{load.boundary}'{nearest(load.boundary, known)}"]
    if model.in_situ is None or not model.in_situ.describes_field:
        components = "xx, yy, zz, xy, yz, xz" if in_space(model.blocks) else "xx, yy, xy"
        return [f"in_situ = true needs the field: give [in_situ] with surface and k0, or stress = {{{components}}}"]
    return []


def _load_faults(load: Load, model: Model) -> list[str]:
    blocks = model.blocks
    if isinstance(load, InSituTraction):
        return faults_of_in_situ_load(load, model)
    if not isinstance(load, PointLoad):
        faults: list[str] = []
        with gathered(faults):
            point_forces_of([load], blocks)
        return faults
    if not 0 <= load.block < blocks.count:
        return [f"there is no block {load.block}; blocks are numbered 0 to {blocks.count - 1}"]
    if len(load.point) != 2:
        return ["point and force have three numbers, and blocks are in the plane; give two, (x, y)"]
    if load.block not in blocks_at(blocks, load.point):
        centre = blocks.moments.centroid[load.block]
        return [f"the point {place(load.point)} is not in block {load.block}, whose centroid is {place(centre)}"]
    return []
