"""A model as the text of a model file: as it was read and run, or as it was built in Python.

The text is not read back as a check: for 100 000 blocks that would double the time of saving. The summary has the
model's hash.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.errors import ModelError, counted
from bsm_mesh.files import write_text
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.earth_pressure import EarthPressure
from bsm_mesh.model.histories import History
from bsm_mesh.model.in_situ import IN_PLANE, IN_SPACE, InSitu
from bsm_mesh.model.joint_laws import LAWS
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.loads import InSituTraction, LinearField, PointLoad, Pressure, Traction
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.quantities import quantities_of
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.strength import Reduced, law_name
from bsm_mesh.model.supports import Fixed, NormalRoller, PrescribedDisplacement, Roller
from bsm_mesh.model.unused import unused_bolts, unused_in
from bsm_mesh.model.water import Water
from bsm_mesh.modelfile.flow_tables import flow_content
from bsm_mesh.text.beside_tables import NAME, table_of
from bsm_mesh.three_d.model.notes import unused_joints

if TYPE_CHECKING:
    from bsm_mesh.model.model import Model
    from bsm_mesh.model.options import Options

MODEL, MESH = "model.toml", "mesh.vtu"
AS_RUN = "# The model as run by bsm-mesh: every default, SI units. The next run into this folder replaces it.\n"
NAMES = {kind: name for name, kind in LAWS.items()}

Content = dict[str, Any]
Given = Mapping[str, Callable[[Path], object]]
"""Input files of a run: their names, and the writer of each."""


class NoFormError(Exception):
    """Something of a model has no form in a model file; the text says what."""


def as_run(content: Content, notes: tuple[str, ...] = ()) -> str:
    """Return the text of a model file, notes first."""
    import tomli_w

    told = "".join(f"# {note}\n" for note in notes)
    return AS_RUN + told + tomli_w.dumps({key: value for key, value in content.items() if value not in ({}, [])})


def files_of_model(model: Model, options: Options) -> Given:
    """Return the files of the input of a run: the model, and its blocks as a mesh of polygons or polyhedra.

    Raises
    ------
    ModelError
        With everything that has no form in a model file.
    """
    text = as_run(content_of(model, options), tuple(_notes(model.blocks)))
    try:
        text.encode()
    except UnicodeEncodeError as error:
        line = text[text.rfind("\n", 0, error.start) + 1 :].partition("\n")[0]
        raise ModelError(f"{line!a}: half a character, which no text file can hold; give it anew") from None
    files: dict[str, Callable[[Path], object]] = {
        MESH: partial(_write_mesh, model.blocks),
        MODEL: lambda path: write_text(path, text),
    }
    if beside := {history.name: history.measured for history in model.histories if history.measured}:
        files[NAME] = lambda path: write_text(path, table_of(beside))
    return files


def _write_mesh(blocks: Any, path: Path) -> None:
    from bsm_mesh.converters.meshes.block_files import write_polygons
    from bsm_mesh.converters.three_d.polyhedra_files import write_polyhedra

    write = write_polyhedra if in_space(blocks) else write_polygons
    write(blocks, path)


def content_of(model: Model, options: Options) -> Content:
    """Return the content of the model file that builds a model of these blocks in ``mesh.vtu``.

    Raises
    ------
    ModelError
        With everything that has no form in a model file.
    """
    from pydantic import ValidationError

    from bsm_mesh.modelfile.model_file import sentences
    from bsm_mesh.modelfile.model_tables import ModelFile
    from bsm_mesh.modelfile.space_tables import SpaceFile

    spatial, form = (True, SpaceFile) if in_space(model.blocks) else (False, ModelFile)
    faults: list[str] = list(_unnamable(model.blocks))

    def tables(what: str, things: Sequence[Any], form: Any) -> list[Content]:
        made = []
        for number, thing in enumerate(things):
            try:
                made.append(form(thing))
            except NoFormError as error:
                name = f"'{thing.name}'" if getattr(thing, "name", "") else str(number + 1)
                faults.append(f"{what} {name}: {error}")
        return made

    unused = any(unused_joints(model) if spatial else unused_in(model)) or bool(unused_bolts(model).any())
    mesh = _given(
        file=MESH,
        contact_points="both" if spatial and model.contact_points == "ends" else model.contact_points,
        default_joint=model.default_joint,
        allow_unused=unused or None,
    )
    content = {
        **({"dimensions": 3} if spatial else {}),
        "title": model.title,
        "mesh": mesh,
        "rock": dict(zip((rock.name for rock in model.rocks), map(_rock, model.rocks), strict=True)),
        "joint": dict(zip((j.name for j in model.joints), tables("joint", model.joints, _joint), strict=False)),
        "support": tables("support", model.supports, _support),
        "load": tables("load", model.loads, _load),
        "bolt": tables("bolt", model.bolts, _bolt),
        "gravity": _given(
            direction=None if spatial else model.gravity_direction,
            horizontal=model.gravity_horizontal,
            vertical=model.gravity_vertical,
            trend=model.gravity_trend,
        ),
        "in_situ": {} if model.in_situ is None else _in_situ(model.in_situ),
        "water": {} if model.water is None else _water(model.water, spatial),
        "flow": {} if model.flow is None else flow_content(model.flow),
        "stage": tables("stage", model.stages, partial(_stage, spatial=spatial)),
        "history": tables("history", model.histories, _history),
        **tables_of(options),
        "output": {"folder": "."},
    }
    if not faults:
        try:
            form.model_validate({key: value for key, value in content.items() if value not in ({}, [])})
        except ValidationError as error:
            faults = list(dict.fromkeys(sentences(error)))
    if faults:
        raise ModelError(faults)
    return content


def tables_of(options: Options) -> Content:
    """Return the tables ``solver`` and ``falls`` of a model file."""
    solver = _given(**asdict(options))
    return {"falls": solver.pop("falls"), "solver": solver}


def _given(**values: Any) -> Content:
    return {key: value for key, value in values.items() if value is not None}


def _fields(thing: Any, *without: str) -> Content:
    """Return the fields of a dataclass that are given, each in the form of a model file."""
    table = _given(
        **{field.name: _plain(getattr(thing, field.name)) for field in fields(thing) if field.name not in without}
    )
    kind: type = type(thing)
    known = quantities_of(kind)
    return {name: known[name][0].in_file(value) if name in known else value for name, value in table.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    return value.item() if isinstance(value, np.generic) else value


def _rock(rock: Rock) -> Content:
    zones = None if rock.zones is None else _fields(rock.zones)
    curve = None if rock.hoek_brown is None else _fields(rock.hoek_brown)
    return _fields(rock, "name", "zones", "hoek_brown") | _given(zones=zones, hoek_brown=curve)


def _joint(joint: Joint) -> Content:
    table = _fields(joint, "name", "law", "filling", "tensile_strength")
    if joint.filling is not None:
        table["filling"] = _fields(joint.filling)
    if joint.law is not None:
        if type(joint.law) not in NAMES:
            over = f", its shear forces over {joint.law.factor:g}" if isinstance(joint.law, Reduced) else ""
            raise NoFormError(f"its law is {law_name(joint.law)}{over}; a model file knows {', '.join(LAWS)}")
        table |= {"law": NAMES[type(joint.law)], **_fields(joint.law), "tensile_strength": joint.tensile_strength}
    return table


def _support(support: Any) -> Content:
    fix = {Fixed: "all", NormalRoller: "normal"}.get(type(support))
    if fix is None and type(support) not in (Roller, PrescribedDisplacement):
        raise NoFormError(f"a {type(support).__name__} has no form in a model file")
    return _fields(support) | _given(fix=fix)


def _load(load: Any) -> Content:
    if type(load) is Pressure:
        return {"boundary": load.boundary, "pressure": _linear(load.pressure)}
    if type(load) is Traction:
        return {"boundary": load.boundary, "traction": [_linear(part) for part in load.traction]}
    if type(load) is EarthPressure:
        return {"boundary": load.boundary, "earth_pressure": _fields(load, "boundary")}
    if type(load) is InSituTraction:
        return {"boundary": load.boundary, "in_situ": True}
    if type(load) is PointLoad:
        return _fields(load)
    raise NoFormError(f"{type(load).__name__} has no form in a model file; give pressures, tractions or point loads")


def _linear(field: LinearField) -> Any:
    return field[0] if field[1:] == (0, 0) else list(field)


def _bolt(bolt: Bolt) -> Content:
    if bolt.plate == math.inf:
        raise NoFormError("a plate of unlimited capacity has no form in a model file; give plate a great number")
    return _fields(bolt) if len(bolt.start) == 2 else _fields(bolt, "spacing")


def _in_situ(in_situ: InSitu) -> Content:
    table = _fields(in_situ, "k0", "k0_across", "stress") | {"k0": dict(zip("abc", in_situ.k0, strict=True))}
    if in_situ.k0_across is not None:
        table["k0_across"] = dict(zip("abc", in_situ.k0_across, strict=True))
    if in_situ.stress is not None:
        names = IN_PLANE if len(in_situ.stress) == len(IN_PLANE) else IN_SPACE
        table["stress"] = {name: list(part) for name, part in zip(names, in_situ.stress, strict=True)}
    return table


def _water(water: Water, spatial: bool) -> Content:
    own = {"joint_pressure": dict(water.joint_pressure)}
    if not spatial:
        return _fields(water, "joint_pressure", "plane") | own
    return own if water.plane is None else {"plane": _fields(water.plane), **own}


def _stage(stage: Stage, spatial: bool) -> Content:
    table = _fields(stage, "water", "flow", "loads", "strength", "gravity", "gravity_trend", "shaking") | {
        "load": [_load(load) for load in stage.loads]
    }
    if stage.strength:
        table["strength"] = dict(stage.strength)
    if stage.gravity is not None:
        horizontal, vertical = stage.gravity
        table["gravity"] = _given(horizontal=horizontal, vertical=vertical, trend=stage.gravity_trend)
    if stage.shaking is not None:
        table["shaking"] = _shaking(stage.shaking)
    if stage.flow is not None:
        table["flow"] = flow_content(stage.flow)
    return table if stage.water is None else table | {"water": _water(stage.water, spatial)}


def _shaking(shaking: Shaking) -> Content:
    table = _fields(shaking, "record", "mass_damping")
    if shaking.record is not None:
        table["record"] = [list(part) for part in shaking.record]
    if shaking.mass_damping is not None:
        table["mass_damping"] = dict(zip(("ratio", "frequency"), shaking.mass_damping, strict=True))
    return table


def _history(history: History) -> Content:
    return _fields(history, "measured") | ({"measured": [NAME]} if history.measured else {})


def _unnamable(blocks: Blocks) -> Iterator[str]:
    """Return the names of groups that the mesh file cannot keep."""
    groups: Mapping[str, Any] = {
        "rock": blocks.rock_names,
        "joint": blocks.joint_names,
        "boundary": blocks.boundaries,
        "excavation": blocks.excavations,
    }
    for kind, known in groups.items():
        for name in known:
            if name != name.strip() or not name.isprintable() or not name:
                yield f"{kind} {name!r}: a mesh file keeps no such name; use letters, digits and signs"


def _notes(blocks: Any) -> Iterator[str]:
    """Return possible differences of the model that is read back from the one that was run."""
    if in_space(blocks):
        return
    _, first, number = np.unique(blocks.nodes, return_index=True, return_inverse=True)
    apart = float(np.abs(blocks.vertices - blocks.vertices[first][number.reshape(-1)]).max())
    if apart > 0:
        yield f"Corners that touch within rounding are one point in {MESH}: read back they differ by {apart:.1g} m."
    empty = sum(len(ids) == 0 for ids in (*blocks.boundaries.values(), *blocks.excavations.values()))
    if empty:
        yield f"{counted(empty, 'group')} of nothing is left out of {MESH}."
