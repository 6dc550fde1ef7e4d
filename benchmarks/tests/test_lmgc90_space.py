"""Models that LMGC90 gets: every block closed and turned outwards, with its volume; the bottom is held."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks.lmgc90_space import cubes, rock, solids


@pytest.mark.parametrize(("build", "count"), [(lambda: cubes(3), 27), (lambda: rock(20), None)])
def test_solids_have_the_volumes_of_the_blocks(build, count):
    blocks, fixed = build()
    assert count in (None, blocks.count)
    assert 0 < fixed.sum() < blocks.count
    volumes = []
    for corners, faces in solids(blocks):
        loops = [np.array(corners)[face] for face in faces]
        cones = [
            np.einsum("ij,ij->", np.cross(loop[1:-1], loop[2:]), np.tile(loop[0], (len(loop) - 2, 1))) for loop in loops
        ]
        volumes.append(sum(cones) / 6)
    assert_allclose(volumes, blocks.moments.volume, rtol=1e-6, atol=1e-9)
