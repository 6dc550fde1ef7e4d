"""From the model file's tables to rocks, joints, supports, loads, water and stages."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, fields
from typing import Any, TypeVar

from pydantic import ValidationError

from bsm_mesh.errors import ModelError, gathered, placed, raise_faults
from bsm_mesh.model.beside import unknown_stages
from bsm_mesh.model.earth_pressure import EarthPressure
from bsm_mesh.model.falls import Falls
from bsm_mesh.model.histories import History
from bsm_mesh.model.hoek_brown import HoekBrown
from bsm_mesh.model.in_situ import InSitu
from bsm_mesh.model.joint_laws import LAWS, JointLaw
from bsm_mesh.model.loads import InSituTraction, Load, PointLoad, Pressure, Traction
from bsm_mesh.model.materials import Filling, Joint, Rock
from bsm_mesh.model.options import Options
from bsm_mesh.model.quantities import quantities_of
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.supports import Fixed, NormalRoller, PrescribedDisplacement, Roller, Support
from bsm_mesh.model.water import Water
from bsm_mesh.model.zones import Zones
from bsm_mesh.modelfile.class_keys import given_in
from bsm_mesh.modelfile.flow_tables import FlowTable, make_flow, make_flow_change
from bsm_mesh.modelfile.material_tables import JointTable, RockTable
from bsm_mesh.modelfile.mesh_tables import Table
from bsm_mesh.modelfile.model_tables import (
    FallsTable,
    HistoryTable,
    InSituTable,
    LoadTable,
    ShakingTable,
    SolverTable,
    StageTable,
    SupportTable,
    WaterTable,
)
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.record_files import read_record
from bsm_mesh.modelfile.space_tables import SpaceInSituTable, SpaceLoadTable

NEEDS_LAW = (
    "a joint with {} needs the key 'law'. "
    'The usual one is "mohr_coulomb": friction and cohesion carry shear from the start. '
    'Others are "patton" (cohesion is that of its second line: asperities that shear off, with dilation), '
    '"barton_bandis" (jrc, jcs, residual_friction) and "ladanyi_archambault" (friction, dilation, jcs)'
)
Made = TypeVar("Made")
REASONS = {("patton", "residual_cohesion"): ": the part that shears off is its cohesion"}


def make_rock(name: str, table: RockTable) -> Rock:
    """Return a rock."""
    with placed(f"rock '{name}'"):
        zones = None if table.zones is None else Zones(**table.zones.model_dump())
        curve = None if table.hoek_brown is None else HoekBrown(**table.hoek_brown.model_dump())
    return Rock(name, **table.model_dump(exclude={"zones", "hoek_brown"}), zones=zones, hoek_brown=curve)


def make_joint(name: str, table: JointTable) -> Joint:
    """Return a joint or joint set."""
    with placed(f"joint '{name}'"):
        filling = None if table.filling is None else Filling(**table.filling.model_dump())
        law = _law(table)
    own = given_in(table, Joint, without=("filling", "law", "tensile_strength"))
    return Joint(name, **own, filling=filling, law=law, tensile_strength=table.tensile_strength or 0.0)


def _law(table: JointTable) -> JointLaw | None:
    """Return the law of a joint; None where it gives no key of one."""
    keys = dict.fromkeys(field.name for kind in LAWS.values() for field in fields(kind))
    given = {key: value for key in keys if (value := getattr(table, key)) is not None}
    if not given and table.law is None:
        if table.tensile_strength is not None:
            raise ModelError(
                "tensile_strength never acts: a joint without a law carries any tension and shear; give friction, "
                "or leave tensile_strength out"
            )
        return None
    name = table.law or "patton"
    faults = [
        f"a joint with a strength needs the key '{key}'{unit}"
        if key == "friction"
        else f"law '{name}' needs the key '{key}'{unit}"
        for key, unit in _missing(name, given)
    ]
    own = {field.name for field in fields(LAWS[name])}
    if table.law is None:
        named = [key for key in given if (given[key] and key not in ("friction", "dilation")) or key not in own]
        faults += [NEEDS_LAW.format(" and ".join(named))] if named else []
    else:
        faults += [_foreign(name, key) for key in given if key not in own]
    raise_faults(faults)
    law: JointLaw = LAWS[name](**given)
    return law


def _missing(name: str, given: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Return the keys that a law lacks, each with its unit in brackets."""
    kind: type = LAWS[name]
    quantities = quantities_of(kind)
    for field in fields(kind):
        if field.default is MISSING and field.name not in given:
            unit = quantities[field.name][0].unit
            yield field.name, f" [{unit}]" if unit else ""


def _foreign(name: str, key: str) -> str:
    """Return the sentence on a key that belongs to other laws."""
    others = " or ".join(f"'{other}'" for other, kind in LAWS.items() if key in {field.name for field in fields(kind)})
    why = REASONS.get((name, key), "")
    return f"law '{name}' has no {key}{why}; remove it or choose {others}"


def make_history(table: HistoryTable, reach: Reach, stage_names: Sequence[str]) -> History:
    """Return the record, and the values compared with it; stages by their names."""
    from bsm_mesh.converters.beside_files import read_beside

    values = [read_beside(reach.path(name, "measured"), table.name) for name in table.measured]
    measured = tuple(one for found in values for one in found[table.name])
    raise_faults(list(unknown_stages(table.name, measured, stage_names)))
    return History(**table.model_dump(exclude={"measured"}), measured=measured)


def make_supports(table: SupportTable, place: str) -> list[Support]:
    """Return the supports of one table: a fix of x and y may be two."""
    where: dict[str, Any] = {
        "blocks": None if table.blocks is None else tuple(table.blocks),
        "boundary": table.boundary,
        "point": table.point,
    }
    if sum(value is not None for value in where.values()) != 1:
        raise ModelError(f"{place}: say where it holds: exactly one of boundary, blocks, point")
    if (table.fix is None) == (table.direction is None):
        raise ModelError(f"{place}: say its content: fix, or direction (with displacement for a given movement)")
    if table.direction is not None:
        if table.displacement is None:
            return [Roller(**where, direction=table.direction)]
        return [PrescribedDisplacement(**where, direction=table.direction, displacement=table.displacement)]
    if table.displacement is not None:
        raise ModelError(f"{place}: displacement needs a direction [degrees] instead of fix")
    if table.fix == "normal":
        if table.boundary is None:
            raise ModelError(f'{place}: fix = "normal" needs a boundary; blocks and points have no normal')
        return [NormalRoller(boundary=table.boundary)]
    if table.fix == "all" or (len(table.fix or []) == 2 and table.blocks is None):
        return [Fixed(**where)]  # of an edge or a point both components are all there is
    axes = {"x": 0.0, "y": 90.0}
    return [Roller(**where, direction=axes[axis]) for axis in sorted(table.fix or [])]


def collected(faults: list[str], makers: Iterable[Callable[[], Made]]) -> list[Made]:
    """Return the objects of the makers; add the faults of those that fail."""
    made = []
    for maker in makers:
        with gathered(faults):
            made.append(maker())
    return made


def make_load(table: LoadTable | SpaceLoadTable, place: str) -> Load:
    """Return a load of the plane or of space."""
    given = table.model_dump(exclude_none=True)
    if set(given) == {"boundary", "pressure"}:
        return Pressure(**given)
    if set(given) == {"boundary", "in_situ"} and table.in_situ:
        return InSituTraction(boundary=given["boundary"])
    if set(given) == {"boundary", "traction"}:
        return Traction(**given)
    if set(given) == {"boundary", "earth_pressure"}:
        return EarthPressure(boundary=given["boundary"], **given["earth_pressure"])
    if set(given) == {"block", "point", "force"}:
        with placed(place):
            return PointLoad(**given)
    on_boundary = [key for key in ("pressure", "traction", "earth_pressure") if key in type(table).model_fields]
    raise ModelError(
        f"{place}: give boundary with {', '.join(on_boundary)} or in_situ = true, or block with point and "
        f"force; given: {', '.join(sorted(given)) or 'nothing'}"
    )


def make_in_situ(table: InSituTable | SpaceInSituTable) -> InSitu:
    """Return the in-situ stress."""
    return InSitu(**{key: value for key, value in table.model_dump().items() if value is not None})


def make_water(table: WaterTable, place: str) -> Water:
    """Return the groundwater."""
    with placed(place):
        return Water(**table.model_dump())


def make_options(solver: SolverTable, falls: FallsTable) -> Options:
    """Return how the model is solved."""
    return Options(**solver.model_dump(), falls=Falls(**falls.model_dump()))


def make_shaking(table: ShakingTable, place: str, reach: Reach | None) -> Shaking:
    """Return how the ground is shaken; without a reach the record of a file is not read, and nothing shakes."""
    given = given_in(table, Shaking, without=("record", "mass_damping"))
    record: Any = table.record
    if isinstance(record, str):
        still = ([0.0, 1.0], [0.0, 0.0])
        record = still if reach is None else read_record(reach.path(record, "record"), given["quantity"])
    damping = None if table.mass_damping is None else (table.mass_damping.ratio, table.mass_damping.frequency)
    with placed(place):
        return Shaking(**given, record=record, mass_damping=damping)


def make_stage(table: StageTable, reach: Reach | None = None) -> Stage:
    """Return a stage."""
    place = f"stage '{table.name}'"
    return Stage(
        **given_in(table, Stage, without=("water", "flow", "gravity", "shaking")),
        shaking=None if table.shaking is None else make_shaking(table.shaking, place, reach),
        water=None if table.water is None else make_water(table.water, place),
        flow=None if table.flow is None else make_flow_change(table.flow, f"{place}: flow"),
        loads=tuple(make_load(load, f"{place}: load {k + 1}") for k, load in enumerate(table.load)),
        gravity=None if table.gravity is None else (table.gravity.horizontal, table.gravity.vertical),
    )


Maker = Callable[[Any, Any], object]  # of a table's name or number in its list, and the table
NAMED: dict[str, tuple[type[Table], Maker]] = {"rock": (RockTable, make_rock), "joint": (JointTable, make_joint)}
LISTED: dict[str, tuple[type[Table], Maker]] = {
    "support": (SupportTable, lambda k, table: make_supports(table, f"[[support]] number {k + 1}")),
    "load": (LoadTable, lambda k, table: make_load(table, f"[[load]] number {k + 1}")),
    "stage": (StageTable, lambda _, table: make_stage(table)),
}
SINGLE: dict[str, tuple[type[Table], Maker]] = {
    "in_situ": (InSituTable, lambda _, table: make_in_situ(table)),
    "water": (WaterTable, lambda _, table: make_water(table, "[water]")),
    "flow": (FlowTable, lambda _, table: make_flow(table)),
}


def faults_of_parts(content: Mapping[str, Any]) -> Iterator[str]:
    """Say what does not fit together in the well-formed tables of a file in which others are not."""
    parts = [
        *((make, key, content.get(key)) for key, make in SINGLE.items()),
        *((make, k, part) for key, make in LISTED.items() for k, part in enumerate(_given(content, key, list))),
        *((make, k, part) for key, make in NAMED.items() for k, part in _given(content, key, dict).items()),
    ]
    for (kind, make), name, part in parts:
        try:
            make(name, kind.model_validate(part))
        except ValidationError:  # told of already
            continue
        except ModelError as error:
            yield from error.faults


def _given(content: Mapping[str, Any], key: str, kind: type) -> Any:
    """Return the list or table under a key; an empty one where there is none."""
    given = content.get(key)
    return given if isinstance(given, kind) else kind()
