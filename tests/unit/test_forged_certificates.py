"""Forged certificates: each is refused, by what the numbers themselves give away or by the model file beside them."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned
from tests.unit.test_certificate import checked

Change = Callable[[dict[str, Any], dict[str, Any]], None]  # of a stage's arrays, and of its words


def arch() -> bsm.Model:
    """Return a flat arch of two tapered stones between abutments, which stands."""
    left = [np.array(p, float) for p in ([(-3, 0), (-1.4, 0), (-2, 2), (-3, 2)], [(-1.4, 0), (0, 0), (0, 2), (-2, 2)])]
    right = [p[::-1] * (-1, 1) for p in left]
    return model_of([left[0], right[0], left[1], right[1]], friction=45.0, fixed=(0, 1), kn=1e10)


def incline(friction: float, **given: Any) -> bsm.Model:
    return model_of(
        [turned(p, 30.0) for p in (rectangle(-9, -2, 3, 0), rectangle(-0.5, 0, 0.5, 0.5))], friction=friction, **given
    )


def wall() -> bsm.Model:
    """Return a tilted wall in bond: faces of several blocks on each other."""
    cells = [rectangle(-1, -1, 3, 0)]
    for course in range(2):
        heads = [0, 1, 2] if course % 2 == 0 else [0, 0.5, 1.5, 2]
        cells += [rectangle(x, course, u, course + 1) for x, u in pairwise(heads)]
    return model_of([turned(cell, -20.0) for cell in cells], friction=15.0)


def hanging() -> bsm.Model:
    """Return a block that hangs below another, and falls: the joint carries less than half of its weight."""
    joint = bsm.Joint("J", 1e9, 1e9, law=bsm.MohrCoulomb(friction=30, cohesion=1e5), tensile_strength=1e4)
    return model_of([rectangle(0, 1, 1, 2), rectangle(0, 0, 1, 1)], joint=joint)


SCENES: dict[str, Callable[[], bsm.Model]] = {
    "arch": arch,
    "on tips": lambda: model_of(
        [np.array(p, float) for p in ([(0, 0), (2, 0), (1, 1)], [(4, 0), (6, 0), (5, 1)])] + [rectangle(0, 1, 6, 2)],
        friction=40.0,
        fixed=(0, 1),
    ),
    "rests": lambda: incline(35.0),
    "light": lambda: incline(35.0).replace(rocks=[bsm.Rock("rock", unit_weight=200.0)]),
    "slides": lambda: incline(25.0),
    "wall": wall,
    "loaded": lambda: incline(40.0, loads=[bsm.PointLoad(block=1, point=(0.0, 0.2), force=(2e3, -1e3))]),
    "held by a load": lambda: incline(25.0, loads=[bsm.PointLoad(block=1, point=(0.0, 0.2), force=(2e3, 1e3))]),
    "hangs": hanging,
    "water": lambda: incline(40.0, water=bsm.Water(table=[(-20, -0.2), (20, 0.2)])),
    "two tables": lambda: incline(
        40.0, water=bsm.Water(table=[[(-20, -0.4), (1, 0.3)], [(-3, -0.2), (20, 0.2)]], head="parallel")
    ),
    "rocks on water": lambda: model_of(
        [rectangle(-4, -1, 6, 0), rectangle(0, 0, 2, 8)],
        friction=75.0,
        water=bsm.Water(table=[(-4, 5.85), (0, 5.85), (2, 0), (6, 0)]),
    ),
}


@cache
def results_of(scene: str) -> bsm.Results:
    return bsm.run(SCENES[scene]())


def forge(scene: str, change: Change, folder: Path) -> tuple[int, str]:
    """Return exit code and last line of the check of a scene's results with a stage changed."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", bsm.ResultsWarning)
        out = results_of(scene).save(folder / "out")
    told = json.loads((out / "certificate.json").read_text(encoding="utf-8"))
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    stage = told["stages"][0]
    with np.load(out / stage["arrays"]) as file:
        arrays = {name: file[name].copy() for name in file.files}
    change(arrays, stage)
    np.savez(out / stage["arrays"], **arrays)
    summary["stages"][0]["status"] = stage["verdict"]
    (out / "certificate.json").write_text(json.dumps(told), encoding="utf-8")
    (out / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    code, lines = checked(out)
    return code, lines[-1]


def scale(factor: float, *names: str) -> Change:
    def change(a: dict[str, Any], stage: dict[str, Any]) -> None:
        for name in names:
            a[name] = a[name] * factor

    return change


def without_contacts(rows: slice, prefix: str = "proof_") -> Change:
    """Leave out contacts of a mechanism."""

    def change(a: dict[str, Any], stage: dict[str, Any]) -> None:
        names = ("law", "tension", "block_a", "block_b", "point", "normal", "length", "lines")
        kept = np.ones(len(a[prefix + "law"]), dtype=bool)
        kept[rows] = False
        for name in names:
            a[prefix + name] = a[prefix + name][kept]

    return change


def false_mechanism(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Say of an arch that stands that it falls straight down, between no contacts."""
    slides = results_of("slides")
    proof = {name: values for name, values in arrays_of(slides).items() if name.startswith("proof_")}
    count = len(a["present"])
    for name, values in proof.items():
        a[name] = values[:0]
    a["proof_velocity"] = np.zeros((count, 3))
    a["proof_velocity"][2:, 1] = -1.0
    a["proof_loads"] = np.column_stack([a["weight"], np.zeros(count)])
    falls(a, stage)
    stage.update(ground="proved", proof={"text": "", "laws": []})


def falls(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Say that the last block falls, with no force on it."""
    last = len(a["present"]) - 1
    for name in ("contact_normal_force", "contact_shear_force"):
        a[name] = a[name] * 0
    a["reactions"] *= 0
    a["support_reaction"] *= 0
    a["support_moment"] *= 0
    a["contact_utilisation"] *= 0
    moved = float(np.hypot(*a["displacement"][last, :2]))
    stage.update(verdict="unstable", ground="followed", unstable_blocks=[last])
    stage["movement"] = [{"block": last, "moved": moved, "speed": None}]


@cache
def arrays_of(results: bsm.Results) -> dict[str, Any]:
    from bsm_mesh.certificate.certificate import certificate_arrays

    return certificate_arrays(results, results.stages[0])


def doubled_weights(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Double the weights, and all forces with them."""
    names = ("weight", "reactions", "contact_normal_force", "contact_shear_force", "support_reaction", "support_moment")
    scale(2.0, *names)(a, stage)
    stage["reference_weight"] *= 2


def doubled_unit_weights(a: dict[str, Any], stage: dict[str, Any]) -> None:
    doubled_weights(a, stage)
    a["unit_weight"] = a["unit_weight"] * 2


def turned_normal(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Turn normals by a degree, and the forces back, so that they balance as before."""
    n = a["contact_normal"]
    force = a["contact_normal_force"][:, None] * n
    force += a["contact_shear_force"][:, None] * n[:, ::-1] * (-1, 1)
    n = np.array([turned(v[None], 1.0)[0] for v in n])
    a["contact_normal"] = n
    a["contact_normal_force"] = (force * n).sum(axis=1)
    a["contact_shear_force"] = (force * n[:, ::-1] * (-1, 1)).sum(axis=1)


def moved_along_force(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Move contacts along the lines of their forces, which changes no balance."""
    n = a["contact_normal"]
    force = a["contact_normal_force"][:, None] * n
    force += a["contact_shear_force"][:, None] * n[:, ::-1] * (-1, 1)
    a["contact_point"] = a["contact_point"] + 0.1 * force / np.hypot(*force.T)[:, None]


def other_friction(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Change friction with all that follows from it."""
    slope = np.tan(np.radians(31.0))
    stage["laws"] = [{**law, "friction": 31.0} for law in stage["laws"]]
    pressure = -a["contact_normal_force"]
    a["contact_utilisation"] = np.abs(a["contact_shear_force"]) / np.maximum(slope * pressure, 1e-300)
    a["contact_utilisation"][a["contact_shear_force"] == 0] = 0.0


def slippery(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Make joints of a sliding block slippery in its proof, where nothing carries more than is so."""
    laws = [{**law, "friction": 20.0} if "friction" in law else law for law in stage["proof"]["laws"]]
    stage["proof"]["laws"] = stage["laws"] = laws
    a["proof_lines"][:, :, 0] = np.where(np.isfinite(a["proof_lines"][:, :, 1]), np.tan(np.radians(20.0)), 0.0)
    falls(a, stage)
    stage["ground"] = "proved"


def invented_support(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Hold the block that slides at its centroid, by bars that no model has."""
    here = a["position"][1, :2] + a["vertices"][4:].mean(axis=0)
    for name, values in (("block", [1, 1]), ("point", [here, here]), ("direction", np.eye(2)), ("turns", [False] * 2)):
        a[f"bar_{name}"] = np.concatenate([a[f"bar_{name}"], np.array(values, dtype=a[f"bar_{name}"].dtype)])


def pushed_by_no_support(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Let a support carry the block, and no contact."""
    for name in ("contact_normal_force", "contact_shear_force", "contact_utilisation"):
        a[name] = a[name] * 0
    a["reactions"] = -np.column_stack([a["weight"], np.zeros(2)])
    a["support_block"] = np.array([0, 1], np.int32)
    a["support_point"] = a["position"][:, :2] + np.array([a["vertices"][k : k + 4].mean(axis=0) for k in (0, 4)])
    a["support_reaction"] = a["reactions"][:, :2].copy()
    a["support_moment"] = np.zeros(2)
    for name in ("contact_status",):
        a[name] = np.zeros_like(a[name])


def dropped_support(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Take the supports from the base, which then falls with its block, as if nothing carried it."""
    for name in ("bar_block", "bar_point", "bar_direction", "bar_turns"):
        a[name] = a[name][:0]
        a["proof_" + name] = a["proof_" + name][:0]
    a["proof_velocity"][0] = a["proof_velocity"][1]


def held_base_moves(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Let the mechanism leave out the supports alone."""
    for name in ("bar_block", "bar_point", "bar_direction", "bar_turns"):
        a["proof_" + name] = a["proof_" + name][:0]
    a["proof_velocity"][:] = (0, -1, 0)


def larger(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Make all blocks larger, and the unit weight less, so that they weigh the same."""
    a["vertices"] = a["vertices"] * 1.001
    a["unit_weight"] = a["unit_weight"] / 1.001**2


def dropped_load(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Take a load away, from the forces and from the block."""
    for name in ("load_block", "load_point", "load_force"):
        a[name] = a[name][:0]
    a["applied"] = a["applied"] * 0


def dropped_load_row(a: dict[str, Any], stage: dict[str, Any]) -> None:
    for name in ("load_block", "load_point", "load_force"):
        a[name] = a[name][:0]


def less_water(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Lower the water on a block, and give the difference to its weight."""
    a["weight"] = a["weight"] + 0.1 * a["water"][:, :2]
    a["water"] = a["water"] - 0.1 * np.column_stack([a["water"][:, :2], np.zeros(2)])


def no_gravity(a: dict[str, Any], stage: dict[str, Any]) -> None:
    scale(0.0, "weight", "gravity", "contact_normal_force", "contact_shear_force", "contact_utilisation")(a, stage)
    scale(0.0, "reactions", "support_reaction", "support_moment")(a, stage)


def other_table(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Turn the last piece of the table about its start: dry there, so that the water on the blocks is as before."""
    a["water_pieces"][-1, :2] += 0.1 * a["water_breaks"][-1], -0.1


def invented_bolt(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Hold a block by a bolt, and give the difference to its weight."""
    from bsm_mesh.certificate.verify_certificate.geometry import moments

    force, centroid = np.array([[1e3, 2e3]]), moments(a["vertices"], a["offsets"])["centroid"]
    a["bolt_block"], a["bolt_point"], a["bolt_force"] = np.array([1]), centroid[1:2], force
    a["weight"][1] -= force[0]


def stiffer_water(a: dict[str, Any], stage: dict[str, Any]) -> None:
    a["load_stiffness"] = a["load_stiffness"] + 1e6 * np.eye(3)


def of_nothing(a: dict[str, Any], stage: dict[str, Any]) -> None:
    for name in ("unit_weight", "gravity"):
        del a[name]


def shifted(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Move the contacts of a mechanism to the middle of their faces, where they turn no block."""
    a["proof_point"] = np.repeat(a["proof_point"].mean(axis=0)[None], len(a["proof_point"]), axis=0)


def shorter(a: dict[str, Any], stage: dict[str, Any]) -> None:
    a["proof_length"] = a["proof_length"] / 10


def turned_in_proof(a: dict[str, Any], stage: dict[str, Any]) -> None:
    a["proof_normal"] = np.array([turned(v[None], 5.0)[0] for v in a["proof_normal"]])


def long_contact(a: dict[str, Any], stage: dict[str, Any]) -> None:
    a["contact_length"] = a["contact_length"] * 100


def other_blocks(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Let the contacts of one abutment be those of the other."""
    for side in "ab":
        block = a[f"contact_block_{side}"]
        a[f"contact_block_{side}"] = np.where(block == 1, 0, block)


def without_its_load(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Say of a block that a load holds that it slides, as it would without."""
    slides = arrays_of(results_of("slides"))
    a |= {name: values for name, values in slides.items() if name != "told"}
    told = json.loads(str(slides["told"]))
    moved = float(np.hypot(*a["displacement"][1, :2]))
    stage.update(told, verdict="unstable", ground="proved", unstable_blocks=[1])
    stage["movement"] = [{"block": 1, "moved": moved, "speed": None}]
    stage["reference_weight"] = results_of("slides").stages[0].reference_weight


def without_tension(a: dict[str, Any], stage: dict[str, Any]) -> None:
    a["proof_tension"] = a["proof_tension"] * 0


def higher_water(a: dict[str, Any], stage: dict[str, Any]) -> None:
    """Raise the table, with all the water on the blocks."""
    from bsm_mesh.certificate.verify_certificate.geometry import moments
    from bsm_mesh.certificate.verify_certificate.water import water_on

    a["water_pieces"][:, 0] += 1e-3
    a["water"], _ = water_on(a | moments(a["vertices"], a["offsets"]), a["position"])


def heavier_in_proof(a: dict[str, Any], stage: dict[str, Any]) -> None:
    a["proof_loads"][1, 2] += 1e4


FORGED: dict[str, tuple[str, Change, str]] = {
    "an arch that stands is said to fall, between no contacts": ("arch", false_mechanism, "which share a face"),
    "a lintel on two tips is said to fall": ("on tips", false_mechanism, "the mechanism proves nothing"),
    "half of a mechanism's contacts": ("slides", without_contacts(slice(0, 1)), "leaves out a contact"),
    "every second contact of a wall": ("wall", without_contacts(slice(None, None, 2)), "leaves out a contact"),
    "all contacts of a mechanism": ("slides", without_contacts(slice(None)), "leaves out a contact"),
    "contacts of a mechanism moved": ("slides", shifted, "leaves out a contact"),
    "contacts of a mechanism turned": ("slides", turned_in_proof, "leaves out a contact"),
    "contacts of a mechanism for less": ("slides", shorter, "leaves out a contact"),
    "moments of a mechanism": ("slides", heavier_in_proof, "loaded otherwise"),
    "less friction in a proof": ("slides", slippery, "no joint or rock of model.toml"),
    "supports left out of a mechanism": ("slides", held_base_moves, "leaves out a support"),
    "supports taken away": ("slides", dropped_support, "is left out"),
    "an unbalanced block is said to fall": ("rests", falls, "of their size only"),
    "weights doubled": ("rests", doubled_weights, "weighs otherwise"),
    "unit weights doubled, given with a unit": ("light", doubled_unit_weights, "another unit weight than its rock"),
    "unit weights doubled too": ("rests", doubled_unit_weights, "another unit weight than its rock"),
    "no gravity": ("rests", no_gravity, "gravity of stage"),
    "outlines larger": ("rests", larger, "outlines of the blocks are not those of mesh.vtu"),
    "normals turned, forces as before": ("rests", turned_normal, "has another normal than the edge"),
    "contacts moved along their forces": ("rests", moved_along_force, "does not lie where its blocks touch"),
    "contacts between other blocks": ("arch", other_blocks, "does not lie where its blocks touch"),
    "contacts for more than a face": ("rests", long_contact, "represents more than any edge"),
    "other friction, with its utilisation": ("rests", other_friction, "no joint or rock of model.toml"),
    "a support invented": ("rests", invented_support, "is held by no support of model.toml"),
    "a support pushes what none holds": ("rests", pushed_by_no_support, "which none holds"),
    "a load left out": ("loaded", dropped_load, "out of balance"),
    "a load without its force": ("loaded", dropped_load_row, "loaded otherwise than by the loads"),
    "a load that holds left out of a proof": ("held by a load", without_its_load, "load of block 1 in model.toml"),
    "no tension in a proof": ("hangs", without_tension, "less tensile strength"),
    "less water, less weight": ("water", less_water, "has other water than the table's"),
    "a higher table, with its water": ("water", higher_water, "water table is not that of model.toml"),
    "another table of two": ("two tables", other_table, "water table is not that of model.toml"),
    "a bolt invented": ("rests", invented_bolt, "held by a bolt, and there is none in model.toml"),
    "water that holds blocks": ("rocks on water", stiffer_water, "stiffness of loads and water is not theirs"),
    "no unit weights": ("rests", of_nothing, "has no unit_weight, gravity"),
}


@pytest.mark.parametrize("forgery", FORGED)
def test_a_forgery_is_refused(forgery: str, tmp_path: Path) -> None:
    scene, change, words = FORGED[forgery]
    code, line = forge(scene, change, tmp_path)
    assert code == 1, line
    assert words in line


@pytest.mark.parametrize("scene", SCENES)
def test_what_is_true_holds(scene: str, tmp_path: Path) -> None:
    code, line = forge(scene, lambda a, stage: None, tmp_path)
    assert code == 0, line
    assert "as model.toml and mesh.vtu give them" in line
