"""Allowed but unusual input of a model: reported with the results and by ``bsm-mesh check``, a sentence each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from numbers import Real
from typing import Any

import numpy as np

from bsm_mesh import space
from bsm_mesh.errors import counted
from bsm_mesh.model.bolt_voids import of_bolts_across_voids
from bsm_mesh.model.excavated_water import of_water_on_excavations
from bsm_mesh.model.faces import count_faces
from bsm_mesh.model.faint_strength import of_faint_strength
from bsm_mesh.model.flow import Flow, FlowChange
from bsm_mesh.model.joint_laws import MohrCoulomb
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import Load
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.model import Model
from bsm_mesh.model.open_water import ground_line, of_sloping_open_water
from bsm_mesh.model.options import Options
from bsm_mesh.model.overburden import of_field_and_weights, of_overburden
from bsm_mesh.model.quantities import GRAVITY_PART, STRENGTH_FACTOR, STRESS_RATIO, quantities_of
from bsm_mesh.model.quantity import Quantity
from bsm_mesh.model.signs import of_signs
from bsm_mesh.model.stages import presence
from bsm_mesh.model.supports import Fixed, unit_vector
from bsm_mesh.model.unused import of_single_bolts, unused_in, used_joints, used_rocks
from bsm_mesh.model.water import Water

SIDEWAYS = 0.5  # of gravity, upwards: more than 60 degrees off is most likely another unit, or a sign
LEAST_FRICTION = 2.0  # degrees: clay of smectite keeps 4 to 5; a tangent or radians of a friction angle are below 1.6
IDLE = {  # options that have no meaning for a scheme
    "continuation": ("sliding_stiffness",),
    "linear": ("max_steps", "displacement_limit", "sliding_stiffness", "falls"),
    "wang": (),
}
SMALLEST, GREATEST = 0.1, 2e3  # m: beyond specimens and the greatest slopes (1 km high) the unit is most likely another


def notes_of(model: Model, *, fails: bool = True) -> list[str]:
    """Return notes on a model that limit the trust in its verdict, a sentence each.

    Parameters
    ----------
    model : Model
        The model.
    fails : bool
        Whether its joints may fail when it is solved; then those that cannot are noted.
    """
    if in_space(model.blocks):
        return space.notes_in_space(model)
    rocks, joints = used_rocks(model), used_joints(model)
    found = [
        *of_size(model),
        *of_what_is_held(model),
        *unused_in(model),
        *of_single_bolts(model),
        *of_bolts_across_voids(model),
        *of_weights(rocks),
        *(of_unlimited(model, rocks, joints) if fails else ()),
        *of_strength(rocks, joints),
        *of_idle_rocks(model, rocks),
        *of_idle_apertures(model, joints),
        *of_unusual(model, rocks, joints),
        *of_faint_strength(model, rocks, joints),
        *_of_ground(model),
        *of_overburden(model),
        *of_field_and_weights(model),
        *of_signs(model),
        *_of_levels(model),
        *of_water_on_excavations(model),
        *of_sloping_open_water(model, ground_line),
        *of_stages(model),
        *of_idle_options(model.options),
        *(() if fails else _of_strength_that_does_not_matter(model)),
    ]
    return list(dict.fromkeys(found))


def of_size(model: Model) -> Iterator[str]:
    """Say that a model is smaller than specimens or larger than slopes."""
    sides = np.ptp(model.blocks.vertices, axis=0).tolist()
    if not SMALLEST <= max(sides) <= GREATEST:
        cure = ' (unit = "mm" where it is in mm)' if max(sides) > GREATEST else ""
        measures = " by ".join(f"{side:.4g} m" for side in sides)
        yield f"the model measures {measures}: check the unit of length of its mesh{cure}"


def of_what_is_held(model: Model) -> Iterator[str]:
    """Say that every block is held."""
    held = np.zeros(model.blocks.count, dtype=bool)
    for support in model.supports:
        if isinstance(support, Fixed) and support.blocks is not None:
            held[list(support.blocks)] = True
    if held.all():
        yield "every block is held by supports: nothing can move, whatever acts; hold fewer blocks"


def of_weights(rocks: Iterable[Rock]) -> Iterator[str]:
    """Say which rocks have no weight."""
    for rock in rocks:
        if rock.unit_weight == 0:
            yield f"rock '{rock.name}' has no weight: unit_weight = 0"


def of_strength(rocks: Sequence[Rock], joints: Sequence[Joint]) -> Iterator[str]:
    """Say which numbers of joint laws contradict each other."""
    for joint in joints:
        if isinstance(joint.law, MohrCoulomb):
            yield from _beyond_apex(f"joint '{joint.name}'", joint.tensile_strength, joint.law.cohesion, joint.law)
            yield from _kept_cohesion(f"joint '{joint.name}'", joint.law)
    for rock in rocks:
        if rock.law is not None:
            yield from _beyond_apex(f"rock '{rock.name}'", rock.tensile_strength or 0.0, rock.law.cohesion, rock.law)
            if not rock.yields:  # zones that yield take no residual strength
                yield from _kept_cohesion(f"rock '{rock.name}'", rock.law)


def of_idle_rocks(model: Model, rocks: Sequence[Rock]) -> Iterator[str]:
    """Say which numbers of rocks have no effect in the model, or less than one may expect."""
    for rock in rocks:
        if rock.young is None and rock.poisson is not None:
            yield f"rock '{rock.name}': poisson has no effect without young: the rock is rigid"
        if not rock.has_strength or rock.yields:
            continue
        if model.default_joint is not None:
            yield (
                f"rock '{rock.name}': its cohesion, friction and tensile_strength have no effect: faces without a "
                f"joint of their own have default_joint = '{model.default_joint}'"
            )
        elif rock.zones is not None:
            yield (
                f"rock '{rock.name}': its zones are elastic, and its strength limits only faces without a joint; for "
                'rock that yields give zones = { law = "mohr_coulomb" }'
            )


def of_idle_apertures(model: Model, joints: Sequence[Joint]) -> Iterator[str]:
    """Say which joints give an aperture, and no water flows in them."""
    why = "flow in joints is for the plane" if in_space(model.blocks) else "[flow] is not given"
    for joint in joints:
        if joint.aperture and model.flow is None:
            yield f"joint '{joint.name}': aperture has no effect: {why}"


def of_idle_options(options: Options | None) -> Iterator[str]:
    """Say which options of a solver have no meaning for its scheme."""
    if options is None:
        return
    usual = Options()
    idle = [name for name in IDLE[options.scheme] if getattr(options, name) != getattr(usual, name)]
    if idle:
        verb = "has" if len(idle) == 1 else "have"
        yield f"solver: {' and '.join(idle)} {verb} no effect with scheme = '{options.scheme}'"


def of_unlimited(model: Model, rocks: Sequence[Rock], joints: Sequence[Joint]) -> Iterator[str]:
    """Say which joints, how many faces of rock, and how many bolts have no limit."""
    for joint in joints:
        if joint.law is None:
            yield f"joint '{joint.name}' has no law (friction): it neither slips nor opens, whatever it carries"
    unlimited = _faces_without_strength(model, rocks)
    if unlimited:
        yield (
            f"{counted(unlimited, 'face')} of rock without a joint and without strength: they neither slip nor open, "
            "whatever they carry (default_joint, or cohesion, friction and tensile_strength of the rock, limit them)"
        )
    yield from of_bolts(model)


def of_bolts(model: Model) -> Iterator[str]:
    """Say how many bolts never yield."""
    elastic = sum(math.isinf(bolt.yield_force) for bolt in model.bolts)
    if elastic:
        yield f"{counted(elastic, 'bolt')} without yield_strength: the steel never yields, whatever it carries"


def _kept_cohesion(thing: str, law: MohrCoulomb) -> Iterator[str]:
    """Say that cohesion stays when a joint slips: files of before were solved without it from the first slip on."""
    if law.cohesion > 0 and not law.is_brittle:
        yield f"{thing}: it keeps its cohesion when it slips; if slip destroys the cohesion, give residual_cohesion = 0"


def _beyond_apex(thing: str, tensile_strength: float, cohesion: float, law: MohrCoulomb) -> Iterator[str]:
    """Say where the tension cut-off is beyond the end of Mohr and Coulomb's line, cohesion / tan(friction)."""
    slope = math.tan(math.radians(law.friction))
    if tensile_strength * slope > cohesion * (1 + 1e-9):
        yield (
            f"{thing}: tensile_strength = {tensile_strength:g} Pa is above cohesion / tan(friction) = "
            f"{cohesion / slope:.3g} Pa, where the line of Mohr and Coulomb ends"
        )


def _faces_without_strength(model: Model, rocks: Sequence[Rock]) -> int:
    """Return how many faces carry neither a joint nor, on either side, a rock with strength.

    Those on the outline of a stage's excavation do not count: the rock is whole there until then.
    """
    if model.default_joint is not None:
        return 0
    blocks = model.blocks
    limited = {rock.name for rock in rocks if rock.can_fail}
    unlimited = np.array([name not in limited for name in blocks.rock_names])[blocks.rock]
    stays = np.logical_and.reduce(presence(model.stages, blocks))
    if in_space(blocks):
        one, other = blocks.face_blocks[blocks.face_joint < 0].T
        return int(((one != other) & (other >= 0) & (unlimited & stays)[one] & (unlimited & stays)[other]).sum())
    return count_faces(blocks, (blocks.edge_joint < 0) & (unlimited & stays)[blocks.owner])


def _of_small_angles(thing: str, owner: Any) -> Iterator[str]:
    """Say which friction angles are so small that they are most likely tangents or radians."""
    for name in ("friction", "residual_friction"):
        angle = getattr(owner, name, None)
        if isinstance(angle, Real):
            yield from of_small_angle(f"{thing}: {name}", float(angle))


def of_small_angle(thing: str, angle: float) -> Iterator[str]:
    """Say that a friction angle [degrees] is so small that it is most likely a tangent or in radians."""
    if 0 < angle < LEAST_FRICTION:
        of_tangent, of_radians = math.degrees(math.atan(angle)), math.degrees(angle)
        yield (
            f"{thing} = {angle:g} degrees is less than that of any rock or clay. It is an angle in "
            f"degrees: {of_tangent:.3g} if {angle:g} is its tangent, {of_radians:.3g} if it is in radians"
        )


def of_unusual_rocks(rocks: Sequence[Rock]) -> Iterator[str]:
    """Say which numbers of rocks are allowed but not usual."""
    for rock in rocks:
        yield from unusual(f"rock '{rock.name}'", rock, without=("unit_weight",) if rock.unit_weight == 0 else ())
        yield from unusual(f"rock '{rock.name}': hoek_brown", rock.hoek_brown)
        yield from _of_small_angles(f"rock '{rock.name}'", rock)


def of_unusual(model: Model, rocks: Sequence[Rock], joints: Sequence[Joint]) -> Iterator[str]:
    """Say which numbers of a model are allowed but not usual."""
    yield from of_unusual_rocks(rocks)
    for joint in joints:
        for part in (joint, joint.filling, joint.law):
            yield from unusual(f"joint '{joint.name}'", part)
        yield from _of_small_angles(f"joint '{joint.name}'", joint.law)
    for bolt in model.bolts:
        yield from unusual("bolts", bolt)
    for support in model.supports:
        yield from unusual(f"support {type(support).__name__}", support)
    if model.in_situ is not None:
        yield from unusual("in_situ", model.in_situ)
        yield from beyond_usual("in_situ", "k0", model.in_situ.k0[1], STRESS_RATIO)
    for place, water in _waters(model):
        yield from unusual(place, water)
    for place, flow in _flows(model):
        yield from unusual(place, flow)
        for given in (*flow.drains, *flow.wells, *flow.grout):
            yield from unusual(f"{place}: {type(given).__name__.lower()}", given)
    yield from _of_unusual_loads(model.loads)
    yield from _of_unusual_gravity("gravity", (model.gravity_horizontal, model.gravity_vertical))
    for stage in model.stages:
        place = f"stage '{stage.name}'"
        yield from unusual(place, stage)
        yield from _of_unusual_loads(stage.loads, f"{place}: ")
        for name, share in stage.strength.items():
            yield from beyond_usual(place, f"strength of '{name}'", share, STRENGTH_FACTOR)
        if stage.shaking is not None:
            yield from unusual(f"{place}: shaking", stage.shaking)
        yield from _of_unusual_gravity(f"stage '{stage.name}': gravity", stage.gravity or (0.0, 0.0))


def _of_unusual_loads(loads: Sequence[Load], place: str = "") -> Iterator[str]:
    for number, load in enumerate(loads, 1):
        yield from unusual(f"{place}load {number} ({type(load).__name__})", load)


def _of_unusual_gravity(place: str, parts: tuple[float, float]) -> Iterator[str]:
    for name, part in zip(("horizontal", "vertical"), parts, strict=True):
        yield from beyond_usual(place, name, part, GRAVITY_PART)


def unusual(thing: str, owner: Any, *, without: Sequence[str] = ()) -> Iterator[str]:
    """Say which numbers of a dataclass are allowed but not usual."""
    kind: type = type(owner)
    for name, (quantity, _) in quantities_of(kind).items():
        value = getattr(owner, name)
        if isinstance(value, Real) and name not in without:
            yield from beyond_usual(thing, name, float(value), quantity)


def beyond_usual(thing: str, name: str, value: float, quantity: Quantity) -> Iterator[str]:
    """Say that a number is allowed but not usual, where it is."""
    if quantity.usual is not None and not quantity.usual[0] <= value <= quantity.usual[1] and math.isfinite(value):
        given = f"{f'{thing}: ' if thing else ''}{name} = {value:g} {quantity.unit}".rstrip()
        why = f": {quantity.usual_why}" if quantity.usual_why else ""
        yield f"{given} is unusual ({quantity.usual_span} is usual){why}; check the number and its unit"


def _of_ground(model: Model) -> Iterator[str]:
    up = unit_vector(model.gravity_direction)[1]
    if up > -SIDEWAYS:
        where = "upwards" if up > SIDEWAYS else "sideways"
        yield f"gravity pulls {where}: its direction is {model.gravity_direction:g} degrees (-90 is down)"
    low, high = model.blocks.vertices[:, 1].min(), model.blocks.vertices[:, 1].max()
    for place, water in _waters(model):
        lowest = min((y for table in water.table for _, y in table), default=-math.inf)
        if lowest > high + (high - low):
            yield f"{place}: the table lies {lowest - high:.6g} m above the top of the model (y = {high:.6g} m)"


def _waters(model: Model) -> Iterator[tuple[str, Water]]:
    """Return the groundwater of the start and of the stages, and where it is stable."""
    if model.water is not None:
        yield "water", model.water
    for stage in model.stages:
        if stage.water is not None:
            yield f"stage '{stage.name}': water", stage.water


def _flows(model: Model) -> Iterator[tuple[str, Flow | FlowChange]]:
    """Return the flow of the start and what stages change of it, and where it is stable."""
    if model.flow is not None:
        yield "flow", model.flow
    for stage in model.stages:
        if stage.flow is not None:
            yield f"stage '{stage.name}': flow", stage.flow


def _of_levels(model: Model) -> Iterator[str]:
    """Say at which boundaries the water's level lets none in."""
    blocks = model.blocks
    for place, flow in _flows(model):
        for name, level in flow.head.items():
            edges = blocks.boundary_edges(name)
            lowest = float(blocks.vertices[[*edges, *blocks.following[edges]], 1].min())
            if level < lowest:
                yield (
                    f"{place}: head of '{name}' is {lowest - level:.6g} m below all of it: no water enters "
                    "there, and it is open to the air"
                )


def of_stages(model: Model) -> Iterator[str]:
    """Say that the first stage changes nothing, and which stages have a relaxation without effect."""
    installs = {bolt.stage for bolt in model.bolts}
    held = False
    for stage in model.stages:
        if stage.relaxation != (1.0,) and not (stage.excavate or held):
            why = "nothing is excavated, and no stage before holds forces"
            yield f"stage '{stage.name}': relaxation has no effect: {why}"
        held = stage.relaxation[-1] < 1
    for stage in model.stages[:1]:  # a later one may release what the former held
        grounds = stage.excavate or stage.fill or stage.loads or stage.water is not None or stage.flow is not None
        acts = stage.gravity is not None or stage.shaking is not None
        if not (grounds or stage.strength or acts or stage.name in installs):
            yield f"stage '{stage.name}' changes nothing"


def _of_strength_that_does_not_matter(model: Model) -> Iterator[str]:
    for stage in model.stages:
        if stage.strength:
            yield (
                f"stage '{stage.name}': strength changes nothing in this scheme but utilisation: nothing slips or opens"
            )
