"""What straight lines and parallel faces are worth: ``python -m benchmarks.origin_and_digits [--slopes N]``.

Random slopes with two joint sets are meshed once. The same mesh is read from other files: in map coordinates, feet and
millimetres, with all digits or some decimals. Its bound of the factor of strength should be that of the mesh at the
origin. The table takes the place of that of `PAGE`.
"""

from __future__ import annotations

import argparse
import math
import random
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

from bsm_mesh.converters.meshes import outlines, regions
from bsm_mesh.solve.limit import program
from bsm_mesh.solve.limit_analysis import strength_limit
from examples.numbers.pages import with_table
from tests.scenes.slope_mesh import moved, slope_mesh, slope_model, with_coordinates

PAGE = Path(__file__).parents[1] / "docs/experiments/limit_analysis.md"
MAP, FOOT = (512345.0, 4501234.0), 0.3048
FILES: dict[str, tuple[dict[str, Any], float]] = {
    "map": ({"by": MAP}, 1.0),
    "feet on a map": ({"by": MAP, "scale": 1 / FOOT}, FOOT),
    "map, 4 decimals": ({"by": MAP, "decimals": 4}, 1.0),
    "map, 6 decimals": ({"by": MAP, "decimals": 6}, 1.0),
    "mm, 1 decimal": ({"scale": 1e3, "decimals": 1}, 1e-3),
    "feet, 4 decimals": ({"scale": 1 / FOOT, "decimals": 4}, FOOT),
    **{f"{decimals} decimals": ({"decimals": decimals}, 1.0) for decimals in range(4, 10)},
}
SAME = 1e-5  # of the factor: half a unit of the fourth decimal turns a face of metres by as much
STRAIGHT = (
    (regions, "straightened", lambda blocks, *_: blocks),
    (outlines, "straight_points", lambda points, *_: points),
)
PARALLEL = ((program, "with_parallel_faces", lambda model, contacts: contacts),)
LEFT_OUT: dict[str, tuple[tuple[Any, str, Any], ...]] = {
    "nothing": (),
    "straight lines": STRAIGHT,
    "parallel faces": PARALLEL,
    "both": STRAIGHT + PARALLEL,
}
HEADER = "| left out | blocks | models | same contacts | proved | same factor | greatest difference |"


def slopes(count: int) -> list[tuple[float, float, float, float]]:
    """Return dip of the bedding, dip of the cross joints, height and spacing of random slopes."""
    draw = random.Random(7).uniform
    ranges = ((22, 50), (75, 125), (8, 30), (1.5, 6))
    found = [tuple(round(draw(*ends), 2) for ends in ranges) for _ in range(count)]
    return found  # type: ignore[return-value]


def bounds(path: Path, count: int, blocks: str) -> list[list[tuple[int, bool, float]]]:
    """Return for every slope contacts, proof and factor: of the mesh at the origin, then of the others."""
    found = []
    for slope in slopes(count):
        mesh = slope_mesh(*slope)
        files = [(mesh, 1.0), *((with_coordinates(mesh, moved(**given)), unit) for given, unit in FILES.values())]
        limits = [strength_limit(slope_model(path, text, unit=unit, blocks=blocks)) for text, unit in files]
        found.append([(of.contacts.count, math.isfinite(of.beyond), of.factor) for of in limits])
    return found


def row(
    name: str, blocks: str, found: list[list[tuple[int, bool, float]]], right: list[tuple[int, bool, float]]
) -> str:
    """Return a row of the table: bounds of files beside those of the mesh at the origin, with nothing left out."""
    pairs = [(of, expected) for rows, expected in zip(found, right, strict=True) for of in rows]
    difference = [0.0 if of[2] == expected[2] else abs(of[2] / expected[2] - 1) for of, expected in pairs]
    contacts = sum(of[0] == expected[0] for of, expected in pairs)
    proved, same = sum(of[1] for of, _ in pairs), sum(part <= SAME for part in difference)
    return f"| {name} | {blocks} | {len(pairs)} | {contacts} | {proved} | {same} | {max(difference):.1e} |"


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--slopes", type=int, default=12)
    count = parser.parse_args().slopes
    lines, right = [HEADER, "|---|---|---:|---:|---:|---:|---:|"], {}
    with TemporaryDirectory() as folder:
        for name, patches in LEFT_OUT.items():
            for blocks in ("regions", "elements"):
                with ExitStack() as stack:
                    for where, function, other in patches:
                        stack.enter_context(patch.object(where, function, other))
                    found = bounds(Path(folder) / "slope.msh", count, blocks)
                right.setdefault(blocks, [rows[0] for rows in found])
                lines.append(row(name, blocks, found, right[blocks]))
                print(lines[-1], flush=True)
    PAGE.write_text(
        with_table(PAGE.read_text(encoding="utf-8"), "origin-and-digits", "\n".join(lines)), encoding="utf-8"
    )


if __name__ == "__main__":
    main()
