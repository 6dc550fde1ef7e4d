"""The linear scheme on 1e4, 1e5 and 1e6 triangles, beside scikit-fem's P1 elasticity on the same mesh.

Run ``python -m benchmarks.linear [N ...] [--solver superlu] [--no-fem]``. Every size and program runs in a process
of its own, so that peak memory is its own; the compiled code is warmed up on a small model first. Each is done
twice and the second time counts: a virtual machine may hand fresh memory out at half a gigabyte a second, which says
nothing about either program; the column "first" has the total of the first time.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import numpy as np

YOUNG, POISSON, UNIT_WEIGHT = 10e9, 0.25, 26e3


def mesh_in_memory(n_triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 2) [m] and triangles (m, 3) of a square of 100 m, a disturbed grid triangulated."""
    from scipy.spatial import Delaunay

    n = round(np.sqrt(n_triangles / 2))
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    inner = ((points > 1e-9) & (points < 1 - 1e-9)).all(axis=1)
    points[inner] += np.random.default_rng(7).uniform(-0.3, 0.3, (inner.sum(), 2)) / n
    return 100 * points, Delaunay(points).simplices.astype(np.int32)


class Clock:
    """Wall times by name."""

    def __init__(self) -> None:
        self.times: dict[str, float] = {}

    @contextmanager
    def __call__(self, name: str):
        """Time what runs within."""
        began = time.perf_counter()
        yield
        self.times[name] = time.perf_counter() - began


def peak_memory() -> float:
    """Return the peak memory of this process [GB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2


def make_model(points: np.ndarray, triangles: np.ndarray):
    import bsm_mesh as bsm

    count = len(triangles)
    blocks = bsm.Blocks(
        vertices=points[triangles].reshape(-1, 2),
        offsets=np.arange(0, 3 * count + 1, 3),
        nodes=triangles.reshape(-1),
        rock=np.zeros(count, dtype=np.int32),
        rock_names=("rock",),
        edge_joint=np.full(3 * count, -1, dtype=np.int32),
    )
    blocks = blocks.with_boundary("bottom", lambda x, y: y < 1e-9)
    return bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", UNIT_WEIGHT, YOUNG, POISSON)],
        supports=[bsm.Fixed(boundary="bottom")],
    )


def run_blocks(n: int, solver: str) -> dict:
    """Time the linear scheme: from the mesh in memory to stresses, and apart from it reading and writing."""
    import bsm_mesh as bsm

    bsm.run(make_model(*mesh_in_memory(200)), bsm.Options(linear_solver=solver))
    points, triangles = mesh_in_memory(n)
    _, _, first = analyse(points, triangles, solver)
    model, results, clock = analyse(points, triangles, solver)
    clock.times["first"] = sum(first.times.values())
    memory = peak_memory()
    with tempfile.TemporaryDirectory() as folder, clock("write"):
        results.save(folder)
    with tempfile.TemporaryDirectory() as folder:
        clock.times["read"] = time_reading(Path(folder) / "mesh.msh", points, triangles)
    stage = results.stages[-1]
    return {
        "blocks": model.blocks.count,
        **clock.times,
        "memory": memory,
        "residual": results.check().block_residual,
        "solver": results.linear_solver,
        "settlement": stage.max_displacement,
    }


def analyse(points: np.ndarray, triangles: np.ndarray, solver: str):
    """Return the model, its results, and a clock with the time of every part."""
    import bsm_mesh as bsm

    clock = Clock()
    with clock("model"):
        model = make_model(points, triangles)
    marks: list[tuple[str, float]] = []
    results = bsm.run(
        model, bsm.Options(linear_solver=solver), report=lambda text: marks.append((text, time.perf_counter()))
    )
    marks.append(("", time.perf_counter()))
    for (name, began), (_, ended) in pairwise(marks):
        clock.times[name] = ended - began
    return model, results, clock


def time_reading(path: Path, points: np.ndarray, triangles: np.ndarray) -> float:
    """Return the time to read and convert a binary MSH 4.1 file of the mesh [s]."""
    import gmsh

    import converters

    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.model.addDiscreteEntity(2, 1)
    numbers = np.arange(1, len(points) + 1)
    gmsh.model.mesh.addNodes(2, 1, numbers, np.column_stack([points, np.zeros(len(points))]).ravel())
    gmsh.model.mesh.addElementsByType(1, 2, [], triangles.ravel() + 1)
    gmsh.model.addPhysicalGroup(2, [1], name="rock:rock")
    gmsh.write(str(path))
    gmsh.finalize()
    began = time.perf_counter()
    converters.read_mesh(path)
    return time.perf_counter() - began


def run_fem(n: int) -> dict:
    """Time scikit-fem: P1 plane strain on the same mesh, its own solver, stresses in the elements."""
    points, triangles = mesh_in_memory(n)
    first = solve_fem(points, triangles)[2]
    u, stress, clock = solve_fem(points, triangles)
    clock.times["first"] = sum(first.times.values())
    return {"blocks": stress.shape[2], **clock.times, "memory": peak_memory(), "settlement": float(np.abs(u).max())}


def solve_fem(points: np.ndarray, triangles: np.ndarray):
    """Return displacements, stresses, and a clock with the time of every part."""
    import skfem
    from skfem.helpers import sym_grad
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    clock = Clock()
    with clock("assembly"):
        mesh = skfem.MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T))
        basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP1()))
        lame, shear = lame_parameters(YOUNG, POISSON)
        K = linear_elasticity(lame, shear).assemble(basis)
        f = skfem.LinearForm(lambda v, w: -UNIT_WEIGHT * v[1]).assemble(basis)
        held = basis.get_dofs(lambda x: x[1] < 1e-9)
    with clock("linear solution"):
        u = skfem.solve(*skfem.condense(K, f, D=held))
    with clock("forces and stresses"):
        strain = sym_grad(basis.interpolate(u))[:, :, :, 0]
        stress = 2 * shear * strain + lame * np.trace(strain) * np.eye(2)[:, :, None]
    return u, stress, clock


def in_own_process(kind: str, n: int, solver: str) -> dict:
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.linear", "--worker", kind, str(n), "--solver", solver],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        return {"blocks": n, "failed": (done.stderr.strip().splitlines() or [str(done.returncode)])[-1]}
    return json.loads(done.stdout.splitlines()[-1])


SPAN = ("model", "contacts", "assembly", "linear solution", "forces and stresses")


def print_rows(rows: list[tuple[str, dict]]) -> None:
    columns = (*SPAN, "total", "first", "read", "write")
    print(f"{'':14s}{'blocks':>9s}" + "".join(f"{name[:10]:>11s}" for name in columns) + f"{'GB':>7s}{'residual':>10s}")
    for name, row in rows:
        if "failed" in row:
            print(f"{name:14s}{row['blocks']:9d}  failed: {row['failed']}")
            continue
        row["total"] = sum(row.get(part, 0.0) for part in SPAN)
        numbers = "".join(f"{row[part]:11.3f}" if part in row else f"{'-':>11s}" for part in columns)
        residual = f"{row['residual']:10.1e}" if "residual" in row else f"{'-':>10s}"
        print(f"{name:14s}{row['blocks']:9d}{numbers}{row['memory']:7.2f}{residual}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sizes", nargs="*", type=float, default=[1e4, 1e5, 1e6])
    parser.add_argument("--solver", default="auto")
    parser.add_argument("--no-fem", action="store_true")
    parser.add_argument("--worker", choices=("blocks", "fem"), help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.worker:
        n = int(given.sizes[0])
        print(json.dumps(run_blocks(n, given.solver) if given.worker == "blocks" else run_fem(n)))
        return
    rows = []
    for size in given.sizes:
        blocks = in_own_process("blocks", int(size), given.solver)
        rows.append((f"bsm {blocks.get('solver', '')}", blocks))
        if not given.no_fem:
            rows.append(("scikit-fem P1", in_own_process("fem", int(size), given.solver)))
    print("wall seconds; total: mesh in memory to stresses")
    print_rows(rows)
    if not given.no_fem:
        for (_, ours), (_, theirs) in zip(rows[::2], rows[1::2], strict=True):
            if "total" in ours and "total" in theirs:
                rest = ours["total"] - ours["linear solution"]
                print(
                    f"{ours['blocks']} blocks: scikit-fem takes {theirs['total'] / ours['total']:.1f} times as long; "
                    f"all but the linear solution is {rest / ours['linear solution']:.2f} of it"
                )


if __name__ == "__main__":
    main()
