"""The command ``joint-test``: laboratory tests of a model's joint and bolt as tables and pictures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.errors import ModelError, nearest, raise_faults
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.joint_test import BoltCurve, JointCurve, closure_test, direct_shear_test, pull_bolt, shear_bolt
from bsm_mesh.model.bolt_layout import label
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.materials import Joint
from bsm_mesh.model.model import Model
from bsm_mesh.model.quantities import SHEAR_MOVEMENT, STIFFNESS, TEST_STRESS
from bsm_mesh.model.quantity import Quantity, convert
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.named_units import LENGTHS, unit_in
from bsm_mesh.named_units import STRESSES as STRESS_UNITS
from bsm_mesh.pictures.joint_test_pictures import Laboratory, draw_bolt, draw_closure, draw_opening, draw_shear
from bsm_mesh.table_rows import read_rows
from bsm_mesh.text.csv_tables import csv_file
from bsm_mesh.text.tables import engineering, print_table
from bsm_mesh.text.terminal import say, say_json

STRESSES = (0.5e6, 1e6, 2e6)  # Pa, where none are asked for
COLUMNS = {"displacement": (LENGTHS, "m"), "shear_stress": (STRESS_UNITS, "Pa")}  # of a laboratory curve
HEADERS = {
    "normal_stress_of_test": "normal_stress_of_test [Pa]",
    "shear_displacement": "shear_displacement [m]",
    "closure": "closure [m]",
    "normal_stress": "normal_stress [Pa]",
    "shear_stress": "shear_stress [Pa]",
    "strength": "strength [Pa]",
    "slip_path": "slip_path [m]",
    "displacement": "displacement [m]",
    "force": "force [N]",
    "tension": "tension [N]",
    "shear": "shear [N]",
}


def run_joint_test(
    path: Path,
    output: Path | None,
    *,
    joint: str,
    normal_stress: tuple[str, ...],
    normal_stiffness: str | None,
    displacement: str,
    cycles: int,
    bolt: str | None,
    inclination: float,
    laboratory: tuple[Path, ...],
    as_json: bool,
    scripts: bool = True,
) -> None:
    """Test a joint of a model file, and a bolt across it; write tables and pictures, and print the result."""
    loaded = load_model_file(path, scripts=scripts)
    given = _joint_of(loaded.model, joint)
    chosen = None if bolt is None else _bolt_of(loaded.model, bolt)
    stresses = tuple(_number("--normal-stress", text, TEST_STRESS) for text in normal_stress) or STRESSES
    farthest = _number("--displacement", displacement, SHEAR_MOVEMENT)
    overlaid = [read_laboratory(file) for file in laboratory]
    added = AddedFiles(output or loaded.output_folder)
    rock = 0.0 if normal_stiffness is None else _number("--normal-stiffness", normal_stiffness, STIFFNESS)
    shear = {
        stress: direct_shear_test(given, stress, farthest, cycles=cycles, normal_stiffness=rock) for stress in stresses
    }
    closing = closure_test(given, max(stresses))
    _write(added, "joint_shear.csv", shear)
    _write(added, "joint_closure.csv", {max(stresses): closing})
    title = f"joint '{given.name}'"
    with added.file("joint_shear.png") as draft:
        draw_shear(shear, overlaid, title, draft)
    with added.file("joint_closure.png") as draft:
        draw_closure(closing, title, draft)
    files = ["joint_shear.csv", "joint_closure.csv", "joint_shear.png", "joint_closure.png"]
    if given.dilation_angle > 0:
        with added.file("joint_opening.png") as draft:
            draw_opening(shear, title, draft)
        files.append("joint_opening.png")
    bolts: dict[str, BoltCurve] = {}
    if chosen is not None:
        bolts = {
            "pulled": pull_bolt(chosen, farthest, inclination=inclination),
            "sheared": shear_bolt(chosen, farthest, inclination=inclination),
        }
        for name, curve in bolts.items():
            _write(added, f"bolt_{name}.csv", {None: curve})
        with added.file("bolt.png") as draft:
            draw_bolt(bolts, f"bolt '{bolt}' at {inclination:g} degrees to the joint's normal", draft)
        files += ["bolt_pulled.csv", "bolt_sheared.csv", "bolt.png"]
    _tell(given, shear, closing, bolts, [str(added.folder.path / name) for name in files], as_json)


def read_laboratory(path: Path) -> Laboratory:
    """Return a laboratory curve from a CSV file with the columns ``displacement [m]`` and ``shear_stress [Pa]``.

    Both may be in other units (mm, MPa).

    Raises
    ------
    ModelError
        If it cannot be read, lacks a column or its unit, or holds no numbers.
    """
    rows = read_rows(path, f"{' and '.join(COLUMNS)} of a reading")
    columns, faults = rows.columns(*COLUMNS), list[str]()
    factors = []
    for column, (name, (units, unit)) in zip(columns, COLUMNS.items(), strict=True):
        if not unit_in(rows.header[column]):
            raise ModelError(f"{path}: column '{rows.header[column]}' has no unit; call it {name} [{unit}]")
        factors.append(rows.factor(column, units, unit))
    values = np.array([[rows.finite(k, column, faults) for column in columns] for k in range(len(rows.cells))])
    raise_faults(faults)
    displacement, shear_stress = (values * factors).T
    return Laboratory(name=path.stem, displacement=displacement, shear_stress=shear_stress)


def _joint_of(model: Model, name: str) -> Joint:
    found = next((joint for joint in model.joints if joint.name == name), None)
    if found is None:
        names = [joint.name for joint in model.joints]
        raise ModelError(f"joint-test: there is no joint '{name}'{nearest(name, names)}")
    return found


def _bolt_of(model: Model, name: str) -> Bolt:
    names = [label(model.bolts, number) for number in range(len(model.bolts))]
    found = [bolt for bolt, known in zip(model.bolts, names, strict=True) if name in (known, bolt.name)]
    if not found:
        raise ModelError(f"joint-test: there is no bolt '{name}'{nearest(name, names)}")
    return found[0]


def _number(name: str, text: str, quantity: Quantity) -> float:
    """Return a number of the command line, plain or with a unit."""
    try:
        plain: float | str = float(text)
    except ValueError:
        plain = text
    try:
        return convert(plain, quantity)
    except ValueError as error:
        raise ModelError(f"joint-test: {name} {text!a}: {error}") from None


def _write(added: AddedFiles, name: str, curves: Mapping[Any, Any]) -> None:
    """Write curves (dataclasses of columns) below each other, a row a step; their stresses are the first column."""
    with added.file(name) as path, csv_file(path) as writer:
        first = next(iter(curves.values()))
        columns = [field.name for field in fields(first)]
        keyed = None not in curves
        writer.writerow([*(["normal_stress_of_test [Pa]"] if keyed else []), *(HEADERS[name] for name in columns)])
        for key, curve in curves.items():
            writer.writerows(_rows([key] if keyed else [], [getattr(curve, name).tolist() for name in columns]))


def _rows(first: Sequence[Any], columns: Sequence[Sequence[float]]) -> Iterable[tuple[Any, ...]]:
    return ((*first, *row) for row in zip(*columns, strict=True))


def _tell(
    joint: Joint,
    shear: dict[float, JointCurve],
    closing: JointCurve,
    bolts: dict[str, BoltCurve],
    files: list[str],
    as_json: bool,
) -> None:
    """Print peaks, ends and the closure, as JSON or as a table."""
    told = [
        {
            "normal_stress": stress,
            "peak_shear_stress": curve.peak,
            "last_shear_stress": float(curve.shear_stress[-1]),
            "slip_path": float(curve.slip_path[-1]),
            "work": curve.work,
        }
        for stress, curve in shear.items()
    ]
    greatest = float(closing.closure.max())
    pulled = {name: float(np.abs(curve.force).max()) for name, curve in bolts.items()}
    if as_json:
        say_json({"joint": joint.name, "shear": told, "closure": greatest, "bolt": pulled, "files": files})
        return
    rows = [
        (
            f"shear under {engineering(row['normal_stress'], 'Pa')}",
            f"peak {engineering(row['peak_shear_stress'], 'Pa')}, at the end "
            f"{engineering(row['last_shear_stress'], 'Pa')}",
        )
        for row in told
    ]
    rows.append((f"closure under {engineering(max(shear), 'Pa')}", engineering(greatest, "m")))
    rows += [(f"bolt {name}", f"at most {engineering(force, 'N')}") for name, force in pulled.items()]
    print_table(f"joint '{joint.name}'", ("", ""), rows)
    for file in files:
        say(file)
