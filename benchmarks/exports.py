"""One model, three programs: ``python -m benchmarks.exports --python PYTHON`` beside compas_dem (RBE) and LMGC90.

PYTHON is one with compas_dem, compas_cra and compas_lmgc90. Forces are summed between every two blocks; where statics
does not determine them the programs may well differ: rigid contacts here, springs there. With ``--into PAGE`` the table
takes the place of what is between that page's marks.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import add_into, tell
from bsm_mesh.converters.exports import export
from bsm_mesh.results import Results
from examples.numbers.pages import markdown
from tests.scenes.arch import arch
from tests.scenes.shapes import turned

Pairs = dict[tuple[int, int], np.ndarray]
COMMAND = "python -m benchmarks.exports"
HEADER = (
    "model",
    "program",
    "verdict or movement",
    "on the supports, vertical",
    "greatest difference of a pair",
)
STEPS = 400  # of 0.01 s, LMGC90
OTHERS = ("compas_dem", "compas_cra", "compas_lmgc90")
AT_REST = 1e-3  # m in these 4 s: less is rounding and settling


def wall(rows: int = 6, bricks: int = 5) -> bsm.Model:
    """Return a wall in running bond on a fixed plate."""
    plate = [(-1, -0.5), (bricks + 1, -0.5), (bricks + 1, 0), (-1, 0)]
    stones = [plate]
    for row in range(rows):
        cuts = np.arange(bricks + 1) if row % 2 == 0 else np.array([0, *(np.arange(bricks) + 0.5), bricks])
        stones += [[(a, row), (b, row), (b, row + 1), (a, row + 1)] for a, b in pairwise(cuts)]
    return _model(stones, 35.0)


def slope(friction: float, dip: float = 30.0, blocks: int = 4) -> bsm.Model:
    """Return blocks behind each other on a fixed plane that dips; they stay where friction is above the dip."""
    base = [(-2, -1), (blocks + 2, -1), (blocks + 2, 0), (-2, 0)]
    stones = [base, *([(k, 0), (k + 1, 0), (k + 1, 1), (k, 1)] for k in range(blocks))]
    return _model([turned(stone, dip) for stone in stones], friction)


def _model(polygons: list, friction: float) -> bsm.Model:
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons([np.array(p, dtype=float) for p in polygons], rock="stone"),
        rocks=[bsm.Rock("stone", unit_weight=25e3)],
        joints=[bsm.Joint("J", 1e10, 1e10, law=bsm.MohrCoulomb(friction=friction))],
        default_joint="J",
        supports=[bsm.Fixed(blocks=[0])],
    )


def forces_between(results: Results) -> Pairs:
    """Return the force on the block of the lower number of every pair, (2,) [N/m]."""
    contacts, found = results.stages[-1].contacts, Pairs()
    for a, b, force in zip(contacts.block_a, contacts.block_b, contacts.force, strict=True):  # force is on b
        low, high = sorted((int(a), int(b)))
        found[low, high] = found.get((low, high), np.zeros(2)) + (force if low == b else -force)
    return found


def read_pairs(path: Path) -> Pairs:
    """Return the same of a table that an exported script wrote."""
    found = Pairs()
    with path.open(newline="") as file:
        for row in csv.DictReader(file):
            a, b = int(row["block_a"]), int(row["block_b"])
            force = np.array([float(row["force_x [N/m]"]), float(row["force_y [N/m]"])])
            found[min(a, b), max(a, b)] = found.get((min(a, b), max(a, b)), np.zeros(2)) + (force if a < b else -force)
    return found


def on_supports(pairs: Pairs, fixed: list[int]) -> float:
    """Return the vertical force of all blocks on the fixed ones [N/m], downwards positive."""
    return -sum(
        (f[1] if low in fixed else -f[1]) for (low, high), f in pairs.items() if (low in fixed) != (high in fixed)
    )


def rows_of(name: str, model: bsm.Model, python: str) -> list[tuple[str, ...]]:
    """Return the rows of a model, one a program."""
    fixed = list(model.supports[0].blocks)
    results = bsm.run(model)
    ours = forces_between(results)
    scale = float(-results.stages[0].loads[:, 1].sum())
    moves = results.status != "stable"
    found = [(name, "bsm-mesh", str(results.status), None if moves else ours)]
    with TemporaryDirectory() as folder:
        for program, arguments in (("compas_dem", ["RBE", "forces.csv"]), ("lmgc90", [str(STEPS), "forces.csv"])):
            script = Path(folder) / f"for_{program}.py"
            export(model, program, script)
            done = subprocess.run([python, script.name, *arguments], cwd=folder, capture_output=True, text=True)
            pairs = read_pairs(Path(folder) / "forces.csv") if done.returncode == 0 else None
            said = "forces found" if done.returncode == 0 else (done.stderr.strip().splitlines() or ["none"])[-1]
            if program == "lmgc90" and done.returncode == 0:
                said, pairs = _movement(Path(folder) / "movements.csv", pairs)
            found.append((name, program, said, pairs))
            (Path(folder) / "forces.csv").unlink(missing_ok=True)
    return [_row(*one, ours, scale, fixed) for one in found]


def _movement(path: Path, pairs: Pairs) -> tuple[str, Pairs | None]:
    with path.open(newline="") as file:
        moved = [(float(row["displacement_x [m]"]), float(row["displacement_y [m]"])) for row in csv.DictReader(file)]
    greatest = float(np.hypot(*np.array(moved).T).max())
    return f"moved {greatest:.2g} m in {STEPS / 100:g} s", pairs if greatest < AT_REST else None


def _row(
    name: str, program: str, said: str, pairs: Pairs | None, ours: Pairs, scale: float, fixed: list[int]
) -> tuple[str, ...]:
    if pairs is None:
        return name, program, said, "", ""
    zero = np.zeros(2)
    worst = max(float(np.hypot(*(pairs.get(k, zero) - ours.get(k, zero)))) for k in {*pairs, *ours})
    weight = f"{on_supports(pairs, fixed) / 1e3:.3f} kN/m"
    return name, program, said, weight, f"{worst / scale:.2g} of the weight"


def versions(python: str) -> str:
    """Return the sentence that names the other programs' versions."""
    ask = f"from importlib.metadata import version; print(*[version(name) for name in {OTHERS}])"
    done = subprocess.run([python, "-c", ask], capture_output=True, text=True, check=True)
    told = ", ".join(f"{name} {number}" for name, number in zip(OTHERS, done.stdout.split(), strict=True))
    return f"{told}; LMGC90: {STEPS} steps of 0.01 s."


def main() -> None:
    """Make the table, and print it or put it into a page."""
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__)
    parser.add_argument("--python", default=sys.executable, help="a Python with compas_dem, compas_cra, compas_lmgc90")
    add_into(parser, COMMAND)
    given = parser.parse_args()
    models = {
        "arch of 9 stones": arch(9, 0.2),
        "arch too thin (t/R = 0.08)": arch(9, 0.08),
        "wall of 33 bricks": wall(),
        "blocks on 30 degrees, friction 32": slope(32.0),
        "blocks on 30 degrees, friction 28": slope(28.0),
    }
    said = versions(given.python)
    table = markdown(HEADER, [row for name, model in models.items() for row in rows_of(name, model, given.python)])
    tell(f"{said}\n\n{table}", COMMAND, given.into)


if __name__ == "__main__":
    main()
