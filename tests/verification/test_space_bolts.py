"""Wedges on two planes that yielding bolts hold: the factor of limit equilibrium."""

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.geometries.orientations import upward_normals
from tests.scenes.rock_3d import WEDGES, wedge_factor, wedge_rock

DIAMETER = 0.4  # m: one bar stands for a whole anchor
STEEP = np.radians(10)  # fall of the bolts into the slope


@pytest.mark.parametrize("name", ["symmetric", "to the north", "two cohesions"])
@pytest.mark.parametrize(("count", "kind"), [(1, "end_anchored"), (3, "end_anchored"), (3, "grouted")])
@pytest.mark.parametrize("share", [0.999, pytest.param(1.001, marks=pytest.mark.heavy)])
def test_bolted_wedge(name, count, kind, share):
    """Bolts at their yield force pull a fifth of the weight into the slope.

    At a thousandth less than the factor by hand the wedge stays. At a thousandth more it slides until the bolts have
    turned into its way.
    """
    first, second, face, top, height, friction, _, weight = WEDGES[name]
    blocks, wedge, volume, areas = wedge_rock(first, second, face, top, height)
    turn = np.radians(face[1])
    into = -np.array([np.sin(turn) * np.cos(STEEP), np.cos(turn) * np.cos(STEEP), np.sin(STEEP)])
    pull = 0.2 * weight * volume / count
    factor = share * wedge_factor(first, second, volume, areas, weight, friction, (0, 0), count * pull * into)
    laws = [bsm.MohrCoulomb(friction=np.degrees(np.arctan(np.tan(np.radians(phi)) / factor))) for phi in friction]
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock(blocks.rock_names[0], unit_weight=weight)],
        joints=[
            bsm.Joint(n, normal_stiffness=1e10, shear_stiffness=1e10, law=law)
            for n, law in zip("AB", laws, strict=True)
        ],
        supports=[bsm.Fixed(blocks=[b for b in range(blocks.count) if b != wedge])],
        bolts=[
            bsm.Bolt(
                start=tuple(head),
                end=tuple(head + 2.4 * blocks.moments.size[wedge] * into),
                kind=kind,
                diameter=DIAMETER,
                yield_strength=pull / (np.pi * DIAMETER**2 / 4),
                pretension=pull,
            )
            for head in _heads(blocks, wedge, face, into, count)
        ],
    )
    stage = bsm.run(model, bsm.Options(threads=1)).stages[-1]
    moved = np.linalg.norm(stage.displacement[wedge, :3]) / blocks.moments.size[wedge]
    assert moved < 5e-4 if share < 1 else moved > 5e-3


def _heads(blocks, wedge, face, into, count):
    """Return points just inside the slope's face, side by side, in front of the wedge's centroid."""
    normal = upward_normals(np.array(face[:1], float), np.array(face[1:], float))[0]
    side = np.cross(into, [0, 0, 1.0])
    apart = 0.12 * blocks.moments.size[wedge] * side / np.linalg.norm(side)
    points = blocks.moments.centroid[wedge] + (np.arange(count) - (count - 1) / 2)[:, None] * apart
    return points - (points @ normal / (into @ normal))[:, None] * into + 1e-3 * into
