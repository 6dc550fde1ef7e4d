"""The linear solver on two MPI ranks gives what the others give, and says what it needs where that is not there."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.solve.algebra import pardiso, pardiso_mpi
from tests.scenes.shapes import grid

ROOT = Path(__file__).parents[2]
BESIDE = str(Path(sys.executable).parent)
MPIEXEC = shutil.which("mpiexec", path=os.pathsep.join([BESIDE, os.environ.get("PATH", "")]))
LINEAR, NONLINEAR = 1e-9, 1e-8  # relative: rounding alone; rounding through joints that slip

needs_mpi = pytest.mark.skipif(
    MPIEXEC is None or importlib.util.find_spec("mpi4py") is None or not pardiso.is_available(),
    reason="needs mkl, mpi4py and mpiexec: pip install mkl mpi4py mpich",
)

SCRIPT = """
import json
import numpy as np
import bsm_mesh as bsm
from bsm_mesh.solve.algebra.pardiso_mpi import ranks

square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)
wall = [square + (i, j) for j in range(8) for i in range(8)]
base = np.array([(-1, -1), (10, -1), (10, 0), (-1, 0)], dtype=float)
blocks = bsm.Blocks.from_polygons([base, *wall], rock="rock")
law = bsm.MohrCoulomb(friction=35)

def solve(scheme, name):
    model = bsm.Model(
        blocks=blocks, rocks=[bsm.Rock("rock", unit_weight=25e3)], default_joint="joint",
        joints=[bsm.Joint("joint", normal_stiffness=1e10, shear_stiffness=1e10, law=law)],
        supports=[bsm.Fixed(blocks=[0])], gravity_direction=-85.0,
    )
    results = bsm.run(model, bsm.Options(scheme=scheme, linear_solver=name))
    return results.linear_solver, results.status.value, results.stages[-1].displacement

with ranks() as first:
    if first:
        found = {}
        for scheme in ("linear", "continuation"):
            (name, verdict, ours), (_, expected, theirs) = solve(scheme, "cluster"), solve(scheme, "superlu")
            difference = float(np.abs(ours - theirs).max() / np.abs(theirs).max())
            found[scheme] = [name, verdict, expected, difference]
        print(json.dumps(found))
"""


def on_ranks(count, *arguments):
    """Return the standard output of a Python program on MPI ranks."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    command = [MPIEXEC, "-n", str(count), sys.executable, *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr + done.stdout
    return done.stdout


@needs_mpi
@pytest.mark.heavy
def test_two_ranks_give_the_serial_results():
    found = json.loads(on_ranks(2, "-c", SCRIPT).splitlines()[-1])
    for scheme, tolerance in (("linear", LINEAR), ("continuation", NONLINEAR)):
        name, verdict, expected, difference = found[scheme]
        assert name == "cluster"
        assert verdict == expected == ("no_verdict" if scheme == "linear" else "stable")
        assert difference < tolerance, scheme


@needs_mpi
@pytest.mark.heavy
def test_without_help_every_rank_says_what_to_do():
    outside = SCRIPT.replace("with ranks() as first:", "for first in [True]:")
    with pytest.raises(AssertionError, match=r"needs the help of all MPI ranks; start with 'mpiexec"):
        on_ranks(2, "-c", outside)


@needs_mpi
@pytest.mark.heavy
def test_command_line(tmp_path):
    model = (ROOT / "examples" / "tilted_wall" / "model.toml").read_text(encoding="utf-8")
    (tmp_path / "model.toml").write_text(model.replace("[solver]", '[solver]\nlinear_solver = "cluster"'))
    out = on_ranks(2, "-m", "bsm_mesh.commands.mpi", "run", str(tmp_path / "model.toml"), "-o", str(tmp_path / "out"))
    assert out.count("verdict") == 1  # one rank speaks
    told = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert told["linear_solver"] == "cluster"
    assert told["status"] == "stable"


def test_without_mpi(monkeypatch):
    monkeypatch.setitem(sys.modules, "mpi4py", None)
    pardiso_mpi._communicator.cache_clear()
    rock = bsm.Rock("rock", unit_weight=25e3, young=1e9, poisson=0.25)
    blocks = bsm.Blocks.from_polygons(grid(2, 1), rock="rock")
    model = bsm.Model(blocks=blocks, rocks=[rock], supports=[bsm.Fixed(blocks=[0])])
    with pytest.raises(bsm.ModelError, match=r"'cluster' needs .* mpi4py .*pip install mkl mpi4py mpich"):
        bsm.run(model, bsm.Options(scheme="linear", linear_solver="cluster"))
