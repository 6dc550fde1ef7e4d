"""The command ``kinematics``: mapped joints against a slope face, its tables and stereonets."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import BoolArray
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.added_files import AddedFiles
from bsm_mesh.folder.result_tables import write_table
from bsm_mesh.model.notes import of_small_angle
from bsm_mesh.results.tables import ResultTable
from bsm_mesh.text.tables import percent, print_table
from bsm_mesh.text.terminal import say, say_json

if TYPE_CHECKING:
    from bsm_mesh.geometries.kinematics import Kinematics

ON_LINES = ("wedge sliding", "direct toppling")
PLANES, LINES, PICTURE = "kinematic_planes.csv", "kinematic_lines.csv", "kinematics.png"


def screen_slope(
    table: Path,
    output: Path | None,
    *,
    face: tuple[float, float],
    friction: float,
    lateral_limit: float,
    toppling_limit: float,
    as_json: bool,
    picture: bool,
) -> None:
    """Screen a table of joints against a slope; write tables and stereonets, and print the possible failures."""
    from bsm_mesh.geometries.errors import GeometryError
    from bsm_mesh.geometries.kinematics import kinematic_screening
    from bsm_mesh.geometries.trace_tables import read_orientations

    try:
        sets = read_orientations(table)
        given: dict[str, Any] = {
            "face": face,
            "friction": friction,
            "lateral_limit": lateral_limit,
            "toppling_limit": toppling_limit,
        }
        found = kinematic_screening(sets, **given)
        means = kinematic_screening(sets, **given, means=True)
    except GeometryError as error:
        raise ModelError(error.faults) from None
    added = AddedFiles(output or table.parent / "out" / table.stem)
    files = _write(added, found, f"{table.stem}: slope {face[0]:g}/{face[1]:03g}, friction {friction:g}", picture)
    notes = list(of_small_angle("friction", friction))
    if as_json:
        modes = {name: {"possible": count, "of": of} for name, (count, of) in found.modes.items()}
        say_json(
            {
                "sets": _told_sets(found, means),
                "intersections": _told_lines(means),
                "modes": modes,
                "notes": notes,
                "files": [str(added.folder.path / name) for name in files],
            }
        )
        return
    _print(found, means)
    for note in notes:
        say(f"note: {note}")
    say(f"{', '.join(files)} written to {added.folder.path}")


def _write(added: AddedFiles, found: Kinematics, title: str, picture: bool) -> list[str]:
    """Write the files, and return their names."""
    from bsm_mesh.geometries.kinematic_net import draw_kinematics

    names = np.array(found.sets, dtype=object)
    slides = np.where(found.slides_on < 0, "both", names[found.of_set[found.slides_on]])
    tables = {
        PLANES: {
            "set": names[found.of_set],
            "dip": found.dip,
            "dip_direction": found.dip_direction,
            "planar": found.planar,
            "flexural": found.flexural,
            "base": found.base,
        },
        LINES: {
            "first": found.first,
            "second": found.second,
            "first_set": names[found.of_set[found.first]],
            "second_set": names[found.of_set[found.second]],
            "trend": found.trend,
            "plunge": found.plunge,
            "wedge": found.wedge,
            "slides_on": np.where(found.wedge, slides, "").astype(object),
            "direct": found.direct,
        },
    }
    units = dict.fromkeys(("dip", "dip_direction", "trend", "plunge"), "deg")
    for name, columns in tables.items():
        with added.file(name) as draft:
            write_table(
                ResultTable(columns=columns, units={key: unit for key, unit in units.items() if key in columns}), draft
            )
    if picture:
        with added.file(PICTURE) as draft:
            draw_kinematics(draft, found, title=title)
    return [*tables, *([PICTURE] if picture else [])]


def _told_sets(found: Kinematics, means: Kinematics) -> dict[str, Any]:
    """Return of every set its mean plane, and the parts of its planes that permit each movement.

    Planes of a table without sets have no mean plane.
    """
    from bsm_mesh.geometries.trace_tables import UNNAMED_SET

    told = {}
    for k, name in enumerate(found.sets):
        own, is_set = found.of_set == k, name != UNNAMED_SET
        told[name] = {
            "planes": int(own.sum()),
            "dip": round(float(means.dip[k]), 6) if is_set else None,
            "dip_direction": round(float(means.dip_direction[k]), 6) if is_set else None,
            "planar": float(found.planar[own].mean()),
            "flexural": float(found.flexural[own].mean()),
            "base": float(found.base[own].mean()),
            "mean_plane_slides": bool(means.planar[k]) if is_set else None,
            "mean_plane_topples": bool(means.flexural[k]) if is_set else None,
        }
    return told


def _told_lines(means: Kinematics) -> list[dict[str, Any]]:
    """Return of every pair of sets the line of their mean planes, and the movements that it permits."""
    return [
        {
            "sets": [means.sets[means.first[k]], means.sets[means.second[k]]],
            "trend": round(float(means.trend[k]), 6),
            "plunge": round(float(means.plunge[k]), 6),
            "wedge": bool(means.wedge[k]),
            "slides_on": "both" if means.slides_on[k] < 0 else means.sets[means.slides_on[k]],
            "direct": bool(means.direct[k]),
        }
        for k in range(len(means.trend))
        if np.isfinite(means.trend[k])
    ]


def _print(found: Kinematics, means: Kinematics) -> None:
    sets = [
        (
            name,
            str(row["planes"]),
            "-" if row["dip"] is None else f"{row['dip']:.0f}/{row['dip_direction']:03.0f}",
            *(percent(row[key]) for key in ("planar", "flexural", "base")),
        )
        for name, row in _told_sets(found, means).items()
    ]
    print_table("Joint sets", ("set", "planes", "mean", "planar sliding", "flexural toppling", "toppling base"), sets)
    shares = _shares(found)
    lines = [
        (
            ", ".join(row["sets"]),
            f"{row['plunge']:.1f}/{row['trend']:05.1f}",
            percent(shares[tuple(row["sets"])][0]),
            row["slides_on"] if row["wedge"] else "-",
            percent(shares[tuple(row["sets"])][1]),
        )
        for row in _told_lines(means)
    ]
    if lines:
        header = ("sets", "mean line", "wedge sliding", "slides on", "direct toppling")
        print_table("Lines of intersection, plunge/trend", header, lines)
    for name, (count, of) in found.modes.items():
        say(f"{name}: {count} of {of} {'lines' if name in ON_LINES else 'planes'} permit it")
    if found.direct.any() and not found.base.any():
        say("direct toppling needs a base: no plane is flat enough")


def _shares(found: Kinematics) -> dict[tuple[str, ...], tuple[float, float]]:
    """Return the parts of the lines of every pair of sets that permit wedges and direct toppling."""
    pairs = list(itertools.combinations(range(len(found.sets)), 2))
    a, b = found.of_set[found.first], found.of_set[found.second]
    own: list[BoolArray] = [(a == i) & (b == j) for i, j in pairs]
    return {
        (found.sets[i], found.sets[j]): (float(found.wedge[of].mean()), float(found.direct[of].mean()))
        for (i, j), of in zip(pairs, own, strict=True)
    }
