"""The linear scheme on a mesh of triangles, compared with scikit-fem's P1 elasticity on the same mesh.

Each is done twice in a process of its own and the second time counts: a virtual machine may hand fresh memory out at
half a gigabyte a second, which says nothing about either program. Times are from the mesh in memory to stresses.
"""

from __future__ import annotations

import time
from argparse import Namespace
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.measure import Split, peak_memory, timed

YOUNG, POISSON, UNIT_WEIGHT = 10e9, 0.25, 26e3
SIDE = 100.0  # m
SMALL = 200  # triangles of the model that compiled code is warmed up on
Row = dict[str, Any]


def mesh_in_memory(n_triangles: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 2) [m] and triangles (m, 3) of a square, a disturbed grid triangulated."""
    from scipy.spatial import Delaunay

    n = round(np.sqrt(n_triangles / 2))
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    inner = ((points > 1e-9) & (points < 1 - 1e-9)).all(axis=1)
    points[inner] += np.random.default_rng(7).uniform(-0.3, 0.3, (inner.sum(), 2)) / n
    return SIDE * points, Delaunay(points).simplices.astype(np.int32)


def make_model(points: np.ndarray, triangles: np.ndarray) -> bsm.Model:
    """Return the model of a mesh: a block a triangle, the bottom held."""
    count = len(triangles)
    blocks = bsm.Blocks(
        vertices=points[triangles].reshape(-1, 2),
        offsets=np.arange(0, 3 * count + 1, 3),
        nodes=triangles.reshape(-1),
        rock=np.zeros(count, dtype=np.int32),
        rock_names=("rock",),
        edge_joint=np.full(3 * count, -1, dtype=np.int32),
    )
    return bsm.Model(
        blocks=blocks.with_boundary("bottom", lambda x, y: y < 1e-9),
        rocks=[bsm.Rock("rock", UNIT_WEIGHT, YOUNG, POISSON)],
        supports=[bsm.Fixed(boundary="bottom")],
    )


def run_blocks(n: int, given: Namespace) -> Row:
    """Return the row of the linear scheme."""
    options = bsm.Options(scheme="linear", linear_solver=given.solver, threads=given.threads)
    bsm.run(make_model(*mesh_in_memory(SMALL)), options)
    points, triangles = mesh_in_memory(n)
    row: Row = {}
    for _ in range(2):
        split, model, results = Split(), None, None
        began = time.perf_counter()
        with timed(row, "model"):
            model = make_model(points, triangles)
        with split.watch():
            results = bsm.run(model, options)
        wall = time.perf_counter() - began
    memory = peak_memory()
    row["parts"].update(split.seconds)
    return row | {
        "blocks": model.blocks.count,
        "verdict": str(results.status),
        "seconds": wall,
        "processor": sum(row["parts"].values()),
        "factorizations": split.factorizations,
        "memory": memory,
        "residual": results.check().block_residual,
        "drift": results.stages[-1].max_displacement,
        "note": results.linear_solver,
    }


def run_fem(n: int, given: Namespace) -> Row:
    """Return the row of scikit-fem: P1 plane strain on the same mesh, its own solver, stresses in the elements."""
    import skfem
    from skfem.helpers import sym_grad
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    points, triangles = mesh_in_memory(n)
    row: Row = {}
    for _ in range(2):
        began = time.perf_counter()
        with timed(row, "assembly"):
            mesh = skfem.MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T))
            basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP1()))
            lame, shear = lame_parameters(YOUNG, POISSON)
            K = linear_elasticity(lame, shear).assemble(basis)
            f = skfem.LinearForm(lambda v, w: -UNIT_WEIGHT * v[1]).assemble(basis)
            held = basis.get_dofs(lambda x: x[1] < 1e-9)
        with timed(row, "factorization"):
            u = skfem.solve(*skfem.condense(K, f, D=held))
        with timed(row, "rest"):
            strain = sym_grad(basis.interpolate(u))[:, :, :, 0]
            stress = 2 * shear * strain + lame * np.trace(strain) * np.eye(2)[:, :, None]
        wall = time.perf_counter() - began
    return row | {
        "blocks": stress.shape[2],
        "verdict": "solved",
        "seconds": wall,
        "processor": sum(row["parts"].values()),
        "memory": peak_memory(),
        "drift": float(np.abs(u).max()),
        "note": "factorization: its whole linear solution",
    }
