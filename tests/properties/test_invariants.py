"""What must not change, over random block systems: frames, numbering, units, superposition, the linear solver."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.solve.algebra import pardiso
from tests.scenes.models import model_of
from tests.scenes.reference import dense_solution, face_forces
from tests.scenes.shapes import rectangle, turned

RTOL = 1e-8  # of the largest force: stiffnesses within three orders, conditions of 1e6, and 1e-16 a number
FEW = settings(max_examples=15, derandomize=True, deadline=None)


@dataclass(frozen=True)
class Scene:
    """Random rectangles in courses on a base, some leaning; rocks of random stiffness; loads; a jointed base."""

    polygons: tuple[np.ndarray, ...]
    rock: tuple[int, ...]
    young: tuple[float, ...]
    gravity: float
    forces: tuple[tuple[int, float, float], ...]
    lean: float
    gauss: bool


@st.composite
def scenes(draw):
    rng = np.random.default_rng(draw(st.integers(0, 10_000)))
    courses, width = draw(st.integers(1, 4)), 4.0
    polygons, y = [rectangle(0.0, -1.0, width, 0.0)], 0.0
    for _ in range(courses):
        height = rng.uniform(0.4, 1.5)
        cuts = np.sort(rng.uniform(0.3, width - 0.3, rng.integers(0, 4)))
        cuts = cuts[np.diff(cuts, prepend=0.0) > 0.1]
        lines = np.concatenate([[0.0], cuts, [width]])
        polygons += [rectangle(a, y, b, y + height) for a, b in pairwise(lines)]
        y += height
    lean = draw(st.sampled_from([0.0, 0.3, -0.5]))  # sheared: parallelograms
    polygons = [p @ np.array([(1.0, 0.0), (lean, 1.0)]) for p in polygons]
    n = len(polygons)
    forces = tuple((int(b), *rng.normal(scale=5e4, size=2)) for b in rng.integers(0, n, draw(st.integers(0, 3))))
    return Scene(
        tuple(polygons),
        tuple(int(r) for r in rng.integers(0, 3, n)),
        tuple(10.0 ** rng.uniform(8, 11, 3)),
        draw(st.sampled_from([-90.0, -100.0, -60.0, 45.0])),
        forces,
        lean,
        draw(st.booleans()),
    )


def solved(
    scene, *, degrees=0.0, shift=(0.0, 0.0), order=None, scale=1.0, force=1.0, solver="auto", weight=1.0, push=1.0
):
    """Run the scene in another frame, numbering or system of units; results come back in its own."""
    n = len(scene.polygons)
    order = np.arange(n) if order is None else np.asarray(order)
    place = np.argsort(order)  # new number of each block
    polygons = [scale * turned(scene.polygons[b], degrees, shift) for b in order]
    names = [f"rock{scene.rock[b]}" for b in order]
    rocks = [
        bsm.Rock(f"rock{i}", unit_weight=weight * 25e3 * force / scale**2, young=E * force / scale, poisson=0.2)
        for i, E in enumerate(scene.young)
    ]
    centroid = [scale * turned(p.mean(axis=0), degrees, shift) for p in scene.polygons]
    loads = [
        bsm.PointLoad(block=place[b], point=centroid[b], force=push * force * turned(np.array(f), degrees))
        for b, *f in scene.forces
    ]
    corner = scale * turned(scene.polygons[0][0], degrees, shift)
    model = bsm.Model(
        blocks=bsm.Blocks.from_polygons(polygons, rock=names, merge_tolerance=1e-9 * scale),
        rocks=rocks,
        joints=[bsm.Joint("J", 1e9 * force / scale**2, 4e8 * force / scale**2)],
        default_joint="J",
        supports=[bsm.Fixed(point=tuple(corner)), bsm.Fixed(blocks=[place[0]])],
        loads=loads,
        gravity_direction=scene.gravity + degrees,
        contact_points="gauss" if scene.gauss else "ends",
    )
    results = bsm.run(model, bsm.Options(scheme="linear", linear_solver=solver))
    stage = results.stages[-1]
    assert results.check().ok
    pairs = {}
    for (i, j), f in face_forces(stage.contacts).items():
        one, other = int(order[i]), int(order[j])
        f = turned(f, -degrees) / force
        pairs[min(one, other), max(one, other)] = f if one < other else -f
    U = stage.displacement[place]
    moved = np.column_stack([turned(U[:, :2], -degrees) / scale, U[:, 2]])
    back = turned(np.eye(2), -degrees).T
    return pairs, moved, back @ stage.stress[place] @ back.T * scale / force


def same(one, other):
    (f1, u1, s1), (f2, u2, s2) = one, other
    assert f1.keys() == f2.keys()
    size = max((np.abs(f).max() for f in f2.values()), default=0.0) + 1.0
    for pair in f2:
        assert_allclose(f1[pair], f2[pair], rtol=0, atol=RTOL * size)
    assert_allclose(u1, u2, rtol=0, atol=RTOL * np.abs(u2).max() + 1e-18)
    assert_allclose(s1, s2, rtol=0, atol=RTOL * np.abs(s2).max() + 1e-9)


@pytest.mark.heavy
@FEW
@given(scenes(), st.floats(-180, 180), st.sampled_from([(0.0, 0.0), (37.0, -12.0), (2e3, 1e3)]))
def test_a_rigid_motion_of_the_whole_model_changes_nothing(scene, degrees, shift):
    same(solved(scene, degrees=degrees, shift=shift), solved(scene))


@pytest.mark.heavy
@FEW
@given(scenes(), st.randoms(use_true_random=False))
def test_renumbering_the_blocks_changes_nothing(scene, random):
    order = list(range(len(scene.polygons)))
    random.shuffle(order)
    same(solved(scene, order=order), solved(scene))


@pytest.mark.heavy
@FEW
@given(scenes(), st.sampled_from([1e-2, 1e2, 3.281]), st.sampled_from([1e-3, 1.0, 1 / 4.448e3]))
def test_units_change_nothing(scene, scale, force):
    same(solved(scene, scale=scale, force=force), solved(scene))


@pytest.mark.heavy
@FEW
@given(scenes(), st.floats(-3, 3), st.floats(-3, 3))
def test_loads_superpose(scene, a, b):
    """The response to a x weight + b x loads is a x that to the weight + b x that to the loads."""
    assume(any(fx or fy for _, fx, fy in scene.forces) and (a or b))  # a model without any load has no response
    from_weight, from_loads = solved(scene, weight=1.0, push=0.0), solved(scene, weight=0.0, push=1.0)
    a = abs(a)  # a unit weight is not negative
    both = solved(scene, weight=a, push=b)
    expected = {pair: a * from_weight[0][pair] + b * from_loads[0][pair] for pair in both[0]}
    total = (a * from_weight[1] + b * from_loads[1], a * from_weight[2] + b * from_loads[2])
    same(both, (expected, *total))


@pytest.mark.heavy
@pytest.mark.skipif(not pardiso.is_available(), reason="mkl is not installed")
@FEW
@given(scenes())
def test_pardiso_and_superlu_agree(scene):
    same(solved(scene, solver="pardiso"), solved(scene, solver="superlu"))


@FEW
@given(scenes())
def test_forces_on_every_block_balance(scene):
    """Sum of the contact forces on every free block is minus its weight and loads, from the pairs alone."""
    pairs, _, _ = solved(scene)
    total = np.zeros((len(scene.polygons), 2))
    direction = np.array([np.cos(np.radians(scene.gravity)), np.sin(np.radians(scene.gravity))])
    for b, p in enumerate(scene.polygons):
        x, y = p.T
        total[b] += 25e3 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2 * direction
    for b, fx, fy in scene.forces:
        total[b] += (fx, fy)
    for (i, j), f in pairs.items():
        total[i] += f
        total[j] -= f
    assert_allclose(total[1:], 0, atol=1e-9 * np.abs(total[0]).max() + 1e-6)


@FEW
@given(scenes())
def test_against_dense_sums(scene):
    """Rigid rock on one joint, solved by dense matrices that share no code with the package."""
    n = len(scene.polygons)
    polygons = scene.polygons
    blocks = bsm.Blocks.from_polygons(polygons, rock="r")
    direction = np.array([np.cos(np.radians(scene.gravity)), np.sin(np.radians(scene.gravity))])
    loads = np.zeros((n, 3))
    loads[:, :2] = 25e3 * blocks.moments.area[:, None] * direction
    centroid = blocks.moments.centroid
    bars = [(0, centroid[0], 0.0, 0.0), (0, centroid[0], 90.0, 0.0), (0, centroid[0] + (0.5, 0.0), 90.0, 0.0)]
    expected = dense_solution(polygons, (1e9, 4e8), loads, bars)
    model = model_of(blocks, joint=bsm.Joint("J", 1e9, 4e8), gravity_direction=scene.gravity)
    stage = bsm.run(model, bsm.Options(scheme="linear")).stages[-1]
    atol = RTOL * np.abs(expected.displacement).max()
    assert_allclose(stage.displacement, expected.displacement, rtol=0, atol=atol)
