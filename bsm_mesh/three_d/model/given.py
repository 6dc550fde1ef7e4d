"""Possible contents of a model of polyhedra: refusals, a sentence each, with the cure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from bsm_mesh.errors import gathered, nearest, raise_faults
from bsm_mesh.model.histories import history_faults
from bsm_mesh.model.loads import InSituTraction
from bsm_mesh.model.model_faults import faults_of_in_situ_load
from bsm_mesh.model.stages import presence
from bsm_mesh.model.strength import strength_faults
from bsm_mesh.model.supports import bars_of, points_down
from bsm_mesh.three_d.model.loads import forces_in_space
from bsm_mesh.three_d.stress_field import in_situ_faults

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model
    from bsm_mesh.model.water import Water

REFUSED = ("flow", "face_water")  # fields that are for the plane


def faults_in_space(model: Model) -> list[str]:
    """Return one sentence for everything in a model of polyhedra that does not fit together."""
    blocks: Any = model.blocks
    faults = [f"{name}: not for polyhedra yet; leave it out" for name in REFUSED if _given(model, name)]
    for kind, used, defined in (
        ("rock", blocks.rock_names, [rock.name for rock in model.rocks]),
        ("joint", (*blocks.joint_names, *filter(None, [model.default_joint])), [joint.name for joint in model.joints]),
    ):
        faults += [
            f"{kind} '{name}' is not defined; define it, [{kind}.{name}] in a model file"
            f"{nearest(name, defined) if defined else ''}"
            for name in used
            if name not in defined
        ]
        faults += [
            f"{kind} '{name}' is defined more than once" for name in dict.fromkeys(defined) if defined.count(name) > 1
        ]
    if not points_down(model.gravity_direction):
        faults.append("gravity_direction: with polyhedra z is up, and weights pull down; turn the blocks instead")
    if model.contact_points == "gauss":
        faults.append('contact_points: polyhedra take "both" (corners and centroids of faces) or "corners"')
    for place, water in (("water", model.water), *((f"stage '{s.name}': water", s.water) for s in model.stages)):
        faults += [f"{place}: {text}" for text in _water_faults(model, water)]
    faults += in_situ_faults(model)
    faults += [f"joint '{joint.name}': {text}" for joint in model.joints for text in _joint_faults(joint)]
    with gathered(faults):
        bars_of(model.supports, model.blocks)
    with gathered(faults):
        presence(model.stages, blocks)
    for where, loads in (("", model.loads), *((f"stage '{s.name}': ", s.loads) for s in model.stages)):
        for number, load in enumerate(loads):
            with gathered(faults, f"{where}load {number + 1} ({type(load).__name__})"):
                if isinstance(load, InSituTraction):
                    raise_faults(faults_of_in_situ_load(load, model))
                else:
                    forces_in_space([load], blocks)
    faults += _history_faults(model)
    faults += [text for stage in model.stages for text in _stage_faults(stage)]
    for stage in model.stages:
        faults += [f"stage '{stage.name}': {text}" for text in strength_faults(model, stage.strength)]
    return faults


def _history_faults(model: Model) -> list[str]:
    """Return a sentence for everything in the histories that polyhedra cannot record."""
    names = [bolt.name or f"bolt {number + 1}" for number, bolt in enumerate(model.bolts)]
    faults = history_faults(model.histories, model.blocks, [joint.name for joint in model.joints], names)
    measured = [history.name for history in model.histories if history.measured]
    return [*faults, *(f"history '{name}': measured is for the plane; leave it out" for name in measured)]


def _given(model: Model, name: str) -> bool:
    value = getattr(model, name)
    return value is not None and value != ()


def _water_faults(model: Model, water: Water | None) -> Iterable[str]:
    if water is None:
        return
    if water.table:
        yield "table is for the plane; give plane = HeadPlane(point=..., dip=..., dip_direction=...)"
    if water.head != "vertical":
        yield "head = 'parallel' is for the plane; leave it out"
    names = [joint.name for joint in model.joints]
    for name in water.joint_pressure:
        if name not in names:
            yield f"joint_pressure: there is no joint '{name}'{nearest(name, names)}"


def _joint_faults(joint: object) -> Iterable[str]:
    if getattr(joint, "shear_curve", None) is not None:
        yield "shear stiffness that grows with pressure is for the plane; give a constant shear_stiffness"


def _stage_faults(stage: object) -> Iterable[str]:
    name = getattr(stage, "name", "")
    for key in ("flow", "shaking"):
        value = getattr(stage, key, None)
        if value is not None and value != () and value != 0:
            yield f"stage '{name}': {key} is for the plane; leave it out"
