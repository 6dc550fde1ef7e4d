"""Blocks on inclines, in meshes of tetrahedra: do they slide? (``python -m benchmarks.meshed_inclines``).

A plane joint cuts a box at a random dip into a random direction; the mesh is of random size. The blocks are regions of
many elements. The joint's friction is reduced to a thousandth of a degree beside its dip, and to a tenth below it.
"""

from __future__ import annotations

import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.pages import seeds_command
from bsm_mesh.converters.three_d import read_polyhedra
from examples.numbers.pages import markdown
from tests.scenes.solid_meshes import incline

MAKER = "python -m benchmarks.meshed_inclines"
FRICTION = 36.0  # degrees, as given: above every dip
BESIDE = {"0.001 above the dip": 0.001, "0.001 below": -0.001, "0.1 below": -0.1}  # friction as reduced, degrees


def judged(seed: int) -> dict[str, Any]:
    """Return verdicts by friction."""
    rng = np.random.default_rng(seed)
    dip, direction, size = rng.uniform(15, 35), rng.uniform(0, 360), rng.uniform(0.5, 1.0)
    found: dict[str, Any] = {"seed": seed}
    begun = time.process_time()
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", bsm.MeshWarning)
        mesh = incline(Path(folder) / "incline.msh", dip=dip, direction=direction, size=size)
        for name, beside in BESIDE.items():
            found[name] = str(bsm.run(_model(mesh, dip + beside), bsm.Options(threads=1)).stages[-1].status)
    return found | {"seconds": round(time.process_time() - begun, 1)}


def _model(mesh: Path, friction: float) -> bsm.Model:
    """Return the model: the lid is excavated, then the joint's strength is reduced to a friction [degrees]."""
    law = bsm.MohrCoulomb(friction=FRICTION)
    strength = {"J1": np.tan(np.radians(friction)) / np.tan(np.radians(FRICTION))}
    return bsm.Model(
        blocks=read_polyhedra(mesh),
        rocks=[bsm.Rock("granite", unit_weight=26e3)],
        joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=law)],
        supports=[bsm.Fixed(boundary="bottom")],
        stages=[bsm.Stage(name="lid off", excavate=["lid"]), bsm.Stage(name="weaker", strength=strength)],
        default_joint="J1",
    )


def table(records: list[dict[str, Any]]) -> str:
    """Return the verdicts at every friction."""
    rows = []
    for name in BESIDE:
        verdicts = Counter(record[name] for record in records)
        rows.append((name, *(str(verdicts[status]) for status in ("stable", "unstable", "not_converged"))))
    return markdown(("friction [degrees]", "stable", "unstable", "not converged"), rows)


if __name__ == "__main__":
    sys.exit(seeds_command(MAKER, __doc__, 24, judged, table))
