"""Lines made straight to the digits of a file, and the rest as it is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.arrays import FloatArray
from bsm_mesh.converters import convert_mesh
from bsm_mesh.converters.meshes.straight import Precision, straightened
from bsm_mesh.model.faces import find_faces
from bsm_mesh.solve.limit.program import LimitProgram
from tests.scenes.models import model_of
from tests.scenes.shapes import grid, rectangle, running_bond, turned

ANGLE = 17.0  # of the grid: no coordinate is a short decimal


def cells(change: object = None, at: tuple[float, float] = (0.0, 0.0), n: int = 5) -> list[FloatArray]:
    polygons = [turned(np.asarray(polygon, float), ANGLE) + at for polygon in grid(n, n)]
    return polygons if change is None else [change(polygon) for polygon in polygons]  # type: ignore[operator]


def blocks_of(polygons: list[FloatArray]) -> bsm.Blocks:
    return bsm.Blocks.from_polygons(polygons, rock="rock")


def straight(polygons: list[FloatArray]) -> bsm.Blocks:
    blocks = blocks_of(polygons)
    return straightened(blocks, np.arange(len(blocks.vertices)), Precision.of(np.concatenate(polygons)))


def spread_of_angles(blocks: bsm.Blocks) -> float:
    """Return how far edges are from two directions at right angles [rad]."""
    angle = np.arctan2(*blocks.edge_vectors.T[::-1]) % (np.pi / 2)
    return float(np.ptp(angle))


@pytest.mark.parametrize("decimals", [4, 5, 6, 7, 8, 9])
def test_a_rounded_grid_is_straight_again(decimals: int) -> None:
    rounded = cells(lambda polygon: polygon.round(decimals))
    assert spread_of_angles(blocks_of(rounded)) > 10.0 ** -(decimals + 1)
    found = straight(rounded)
    exact = blocks_of(cells())
    for k in range(exact.count):  # every line is one
        of = slice(4 * k, 4 * k + 4)
        assert np.abs(found.vertices[of] - exact.vertices[of]).max() < 2 * 10.0**-decimals
    rows = found.vertices.reshape(-1, 4, 2)
    along = turned(np.array([[1.0, 0.0]]), ANGLE)[0]
    across = np.array([-along[1], along[0]])
    for edge in range(4):  # the lower edges of a row of cells lie on one line, fitted to its points
        line = rows[:5, edge] - rows[0, edge]
        fitted = np.polynomial.Polynomial.fit(line @ along, line @ across, 1)
        assert np.abs(line @ across - fitted(line @ along)).max() < 1e-13


@pytest.mark.parametrize("decimals", [4, 6, 8])
@pytest.mark.parametrize("at", [(0.0, 0.0), (512345.0, 4501234.0)])
def test_a_rounded_wall_in_bond_has_all_its_faces(decimals: int, at: tuple[float, float]) -> None:
    """Corners within edges are on them: the wall was refused, for bricks that overlap by half a digit."""
    polygons = [turned(np.asarray(p, float), 10.0) + at for p in [rectangle(-1, -0.5, 9, 0), *running_bond(6, 8)]]
    offsets = np.cumsum([0, *map(len, polygons)])
    elements = [("polygon", [list(range(a, b))]) for a, b in pairwise(offsets.tolist())]
    groups = {"rock:rock": [[0]] * len(polygons)}
    exact, _ = convert_mesh(np.concatenate(polygons), elements, groups)
    found, _ = convert_mesh(np.concatenate(polygons).round(decimals), elements, groups)
    assert len(find_faces(found).edge_a) == len(find_faces(exact).edge_a)
    angle = np.arctan2(*found.edge_vectors.T[::-1]) % np.pi
    height = (found.vertices - at) @ (-np.sin(np.radians(10)), np.cos(np.radians(10)))
    of_bed = np.where(np.abs(angle - np.radians(10)) < 0.1, height.round(1), np.nan)
    for bed in np.arange(0.0, 3.1, 0.5):
        assert np.ptp(angle[of_bed == bed]) < (1e-7 if any(at) else 1e-12)  # map coordinates: a nanometre


def test_exact_meshes_stay_as_they_are() -> None:
    for polygons in (cells(), [np.asarray(polygon, float) for polygon in grid(4, 4)]):
        blocks = blocks_of(polygons)
        found = straightened(blocks, np.arange(len(blocks.vertices)), Precision.of(blocks.vertices))
        assert found is blocks


@pytest.mark.parametrize("kink", [0.3, 0.01, 2e-3])
def test_kinks_that_are_meant_stay(kink: float) -> None:
    """On a grid of whole numbers, whose last digit is as large as its cells."""
    polygons = [np.array([(0, 0), (1, 0), (2, 0), (2, 1), (1, 1 + kink), (0, 1)], float) * 1000.0]
    blocks = blocks_of(polygons)
    assert straightened(blocks, np.arange(6), Precision.of(blocks.vertices)) is blocks


def test_a_circle_of_short_edges_is_no_line() -> None:
    angle = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    blocks = blocks_of([np.column_stack([5 * np.cos(angle), 5 * np.sin(angle)]).round(4)])
    found = straightened(blocks, np.arange(4000), Precision.of(blocks.vertices))
    edge = 10 * np.pi / 4000
    assert np.abs(found.vertices - blocks.vertices).max() < 1e-3 * edge
    assert found.moments.area[0] == pytest.approx(blocks.moments.area[0], rel=1e-8)


@pytest.mark.parametrize(
    ("values", "digits"),
    [
        ([0.1234, 55.4321, 7.5], 0.5e-4),
        ([512345.12, 4501234.07], 0.5e-2),
        ([0.00012345678, 12.345, 45.678], 0.5e-3),  # as many digits each: the greatest count
        ([1.0, 2.0, 3.0], 0.5),
        ([np.pi, np.e, 1 / 3], 0.0),
    ],
)
def test_digits_of_a_file(values: list[float], digits: float) -> None:
    found = Precision.of(np.array(values))
    assert found.digits == pytest.approx(digits, abs=1e-15)
    assert found.rounding == pytest.approx(16 * 2.0**-52 * max(values))
    assert Precision.of(np.array(values), 0.001).digits == pytest.approx(digits / 1000, abs=1e-15)


def test_single_precision_is_known() -> None:
    values = np.linspace(0.1, 60, 77, dtype=np.float32).astype(float)
    assert Precision.of(values).digits == pytest.approx(60 * 2.0**-25)


def test_what_a_mesher_leaves_is_put_straight() -> None:
    """Far below the merge tolerance, above rounding: corners that are none, and kinks."""
    jitter = np.random.default_rng(5).uniform(-2e-12, 2e-12, (25, 4, 2))
    polygons = [np.concatenate(cells())]
    points = polygons[0].reshape(25, 4, 2) + jitter
    elements = [("quad", [list(range(4 * k, 4 * k + 4))]) for k in range(25)]
    found, _ = convert_mesh(points.reshape(-1, 2), elements, {"rock:rock": [[0]] * 25}, blocks="regions")
    assert (found.count, len(found.vertices)) == (1, 4)


@pytest.mark.parametrize("at", [(0.0, 0.0), (5e5, 5e6)])
@pytest.mark.parametrize("angle", [0.0, 17.0, 90.0, 135.0])
def test_limit_analysis_has_parallel_faces(at: tuple[float, float], angle: float) -> None:
    """Coordinates of a map leave a nanometre to a double; faces of one plane have one normal all the same."""
    polygons = [turned(np.asarray(polygon, float), angle) + at for polygon in [*grid(4, 3)]]
    normal = LimitProgram(model_of(polygons)).contacts.normal
    for one in np.unique(normal.round(5), axis=0):
        mine = normal[np.abs(normal - one).max(axis=1) < 1e-4]
        assert np.ptp(mine, axis=0).max() < 1e-15


def test_limit_analysis_keeps_wedges() -> None:
    """A taper of a micrometre in a metre is none of rounding."""
    taper = 1e-6
    polygons = [
        rectangle(-3, 0, 0, 1),
        [(0, 0), (1, 0), (1 - taper, 1), (0, 1)],
        [(1, 0), (4, 0), (4, 1), (1 - taper, 1)],
    ]
    normal = LimitProgram(model_of([np.asarray(p, float) for p in polygons], fixed=(0, 2))).contacts.normal
    assert np.ptp(np.abs(normal[:, 1])) == pytest.approx(taper, rel=1e-3)
