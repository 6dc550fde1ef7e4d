"""docs/theory_contacts.md: reactions against loads 1e-10, every block to 1e-9 of a block's weight.

Held on large models, on soft rock beside hard, far from the origin, in small and large units, without weight.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.results.check import block_residuals
from tests.scenes.models import LINEAR, framed
from tests.scenes.shapes import gmsh_triangles, grid, running_bond, turned

BLOCK = 1e-9  # of a block's weight
BALANCE = 1e-10  # of the loads
SOFT, HARD = 1e6, 100e9


def held(stage, results, balance=BALANCE):
    check = results.check()
    assert check.block_residual <= BLOCK, str(check)
    assert check.balance <= balance, str(check)
    assert results.status.is_at_rest
    size = np.abs(stage.total_load).max() + np.hypot(*stage.reactions[:, :2].T).sum()
    assert_allclose(stage.total_reaction, -stage.total_load, rtol=0, atol=balance * size)


def mixed(columns, rows, pattern, *, shift=(0.0, 0.0), scale=1.0, degrees=0.0, force=1.0, solver="auto", points="ends"):
    """Run a rectangle of squares of soft and hard rock; `force` is the unit of force in newton."""
    n = columns * rows
    j, i = np.divmod(np.arange(n), columns)
    soft = {
        "random": np.random.default_rng(5).integers(0, 2, n) == 0,
        "layers": j // 5 % 2 == 0,
        "columns": i // 5 % 2 == 0,
        "none": np.zeros(n, dtype=bool),
    }[pattern]
    flat = framed(bsm.Blocks.from_polygons(grid(columns, rows), rock="any"), columns, rows)
    polygons = [scale * turned(flat.polygon(b), degrees) + shift for b in range(n)]
    blocks = bsm.Blocks.from_polygons(
        polygons, rock=np.where(soft, "soft", "hard").tolist(), merge_tolerance=1e-9 * scale
    )
    blocks = bsm.Blocks(
        **{k: getattr(blocks, k) for k in ("vertices", "offsets", "nodes", "rock", "rock_names", "edge_joint")},
        boundaries=flat.boundaries,
    )
    weight, modulus = force / scale**2, force / scale  # per metre of thickness: force = gamma A = E times displacement
    rocks = [
        bsm.Rock(name, unit_weight=26e3 * weight, young=E * modulus, poisson=0.25)
        for name, E in (("soft", SOFT), ("hard", HARD))
    ]
    model = bsm.Model(
        blocks=blocks,
        rocks=rocks,
        supports=[bsm.NormalRoller(boundary="bottom"), bsm.NormalRoller(boundary="left")],
        gravity_direction=degrees - 90.0,
        contact_points=points,
    )
    results = bsm.run(model, bsm.Options(scheme="linear", linear_solver=solver))
    return model, results, results.stages[-1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pattern", "solver"),
    [
        *((pattern, "auto") for pattern in ("none", "random", "layers", "columns")),
        ("layers", "superlu"),
        *(pytest.param(pattern, "superlu", marks=pytest.mark.slow) for pattern in ("none", "random", "columns")),
    ],
)
def test_fifty_thousand_blocks(pattern, solver):
    """Soft layers let the hard rock above sink by hundreds of metres: the forces must not be lost in those digits."""
    model, results, stage = mixed(200, 250, pattern, solver=solver)
    held(stage, results)
    residual = np.abs(block_residuals(results, stage)).max(axis=1)
    assert (residual / model.weights).max() <= BLOCK
    if pattern == "layers":
        assert stage.max_displacement > 100.0


@pytest.mark.parametrize("points", ["ends", "gauss"])
@pytest.mark.parametrize("degrees", [0.0, 30.0])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (1e6, -1e6), (3e5, 5e6)])
@pytest.mark.parametrize("pattern", ["random", "layers", "columns"])
def test_far_from_the_origin(pattern, shift, degrees, points):
    _, results, stage = mixed(20, 20, pattern, shift=shift, degrees=degrees, points=points)
    held(stage, results)


@pytest.mark.parametrize("force", [1e-6, 1.0, 30.0])  # within what a unit weight may be
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_units(scale, force):
    _, results, stage = mixed(12, 12, "random", scale=scale, force=force)
    held(stage, results)
    _, _, plain = mixed(12, 12, "random")
    size = np.abs(plain.contacts.normal_force).max()
    assert_allclose(stage.contacts.normal_force / force, plain.contacts.normal_force, rtol=0, atol=1e-7 * size)
    assert_allclose(stage.displacement[:, :2] / scale, plain.displacement[:, :2], rtol=0, atol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("soft", [0.0, 0.5])
@pytest.mark.parametrize("solver", ["auto", "superlu"])
def test_two_hundred_thousand_triangles(solver, soft):
    pytest.importorskip("gmsh")
    triangles = gmsh_triangles(100.0, 100.0, 0.34)
    assert len(triangles) > 190_000
    names = np.where(np.random.default_rng(0).random(len(triangles)) < soft, "soft", "hard").tolist()
    blocks = framed(bsm.Blocks.from_polygons(triangles, rock=names), 100.0, 100.0)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("soft", 26e3, SOFT, 0.25), bsm.Rock("hard", 26e3, HARD, 0.25)],
        supports=[bsm.NormalRoller(boundary="bottom"), bsm.NormalRoller(boundary="left")],
    )
    results = bsm.run(model, bsm.Options(scheme="linear", linear_solver=solver))
    held(results.stages[-1], results)
    residual = np.abs(block_residuals(results, results.stages[-1])).max(axis=1)
    assert (residual / model.weights).max() <= BLOCK


def test_a_wall_in_bond_on_soft_joints_beside_hard_ones():
    polygons = running_bond(40, 30)
    blocks = bsm.Blocks.from_polygons(polygons, rock="r").with_boundary("bottom", lambda x, y: y < 1e-9)
    blocks = blocks.with_joint("soft", lambda x, y: (y > 4.9) & (y < 5.1))
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=25e3)],
        joints=[bsm.Joint("soft", 1e5, 1e5), bsm.Joint("hard", 1e13, 1e13)],
        default_joint="hard",
        supports=[bsm.Fixed(boundary="bottom")],
        gravity_direction=-95.0,
    )
    results = bsm.run(model, LINEAR)
    held(results.stages[-1], results)


def test_blocks_of_very_different_size():
    """Each block is held to its own weight too: bricks of 1 cm on a block of 100 m."""
    polygons = [
        np.array([(0, 0), (100, 0), (100, 100), (0, 100)], dtype=float),
        *[p * 1e-2 + (0, 100.0) for p in grid(20, 5)],
    ]
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock="r"),
        rocks=[bsm.Rock("r", unit_weight=26e3, young=1e10, poisson=0.2)],
        supports=[bsm.Fixed(blocks=[0])],
        gravity_direction=-80.0,
    )
    results = bsm.run(model, LINEAR)
    stage = results.stages[-1]
    held(stage, results)
    residual = np.abs(block_residuals(results, stage)).max(axis=1)
    assert (residual / model.weights).max() <= BLOCK


@pytest.mark.parametrize("E", [SOFT, 50e9, 50e12])
def test_prescribed_displacements_without_weight(E):
    """The reference is then the mean contact force, not zero: a stiff rock is in equilibrium as well as a soft one."""
    blocks = framed(bsm.Blocks.from_polygons(grid(20, 20), rock="r"), 20, 20)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=0, young=E, poisson=0.25)],
        supports=[
            bsm.Fixed(boundary="bottom"),
            bsm.PrescribedDisplacement(boundary="top", direction=33.0, displacement=0.1),
        ],
    )
    results = bsm.run(model, LINEAR)
    held(results.stages[-1], results)
    assert results.stages[-1].reference_weight > 0


def test_nothing_acts():
    blocks = framed(bsm.Blocks.from_polygons(grid(3, 3), rock="r"), 3, 3)
    rock = bsm.Rock("r", unit_weight=0, young=1e9, poisson=0.2)
    model = bsm.Model(blocks=blocks, rocks=[rock], supports=[bsm.Fixed(boundary="bottom")])
    with pytest.raises(bsm.ModelError, match="nothing loads the model"):
        bsm.run(model, LINEAR)


def test_the_smallest_model():
    rock = bsm.Rock("r", unit_weight=26e3)
    for solver in ("auto", "superlu"):
        blocks = bsm.Blocks.from_polygons(grid(1, 1), rock="r")
        model = bsm.Model(blocks=blocks, rocks=[rock], supports=[bsm.Fixed(blocks=[0])])
        results = bsm.run(model, bsm.Options(scheme="linear", linear_solver=solver))
        held(results.stages[-1], results)
        assert_allclose(results.stages[-1].reactions, [(0, 26e3, 0)])
