"""Where a slab pushes a chip ahead, the answer names the slab too, although the chip moves farther for its size."""

import math
from dataclasses import replace

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.results.movement import moved_beside
from bsm_mesh.results.records import Status
from bsm_mesh.safety.criterion import Ended
from bsm_mesh.solve.stages.falls import note_on_others

DIP, FRICTION = 30.0, 35.0
CHIP, SLAB = 2, 1


def slope(friction: float, *, stop: bool) -> bsm.Model:
    """Return a slab of 2 m x 1 m on a plane, a chip of 0.25 m below it, and 20 mm on a stop or the end of the plane."""
    end = -0.25 - 0.02
    shapes = [
        [(end - (0.5 if stop else 0.0), -1), (4, -1), (4, 0), (end - (0.5 if stop else 0.0), 0)],
        [(0, 0), (2, 0), (2, 1), (0, 1)],
        [(-0.25, 0), (0, 0), (0, 0.25), (-0.25, 0.25)],
    ]
    if stop:
        shapes.append([(end - 0.5, 0), (end, 0), (end, 1), (end - 0.5, 1)])
    c, s = math.cos(math.radians(DIP)), math.sin(math.radians(DIP))
    turn = np.array([[c, -s], [s, c]])
    return bsm.Model(
        blocks=bsm.Blocks.from_polygons([np.array(shape, dtype=float) @ turn.T for shape in shapes], rock="rock"),
        rocks=(bsm.Rock("rock", unit_weight=26e3),),
        joints=(bsm.Joint("joint", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=friction)),),
        default_joint="joint",
        supports=(bsm.Fixed(blocks=[0, 3] if stop else [0]),),
    )


def test_the_factor_names_the_blocks_that_the_proof_moves():
    found = bsm.factor_of_safety(slope(FRICTION, stop=True))
    assert found.limit.factor == pytest.approx(math.tan(math.radians(FRICTION)) / math.tan(math.radians(DIP)), rel=1e-4)
    assert found.mechanism.blocks.tolist() == [SLAB, CHIP]
    assert found.collapse.blocks.tolist() == [SLAB, CHIP]
    assert found.collapse.area == pytest.approx(2.0 + 0.25**2)


@pytest.mark.heavy
def test_blocks_that_moved_far_as_another_fell_are_found():
    model = slope(20.0, stop=False)
    stage = bsm.run(model).stages[-1]
    assert stage.unstable_blocks.tolist() == [SLAB, CHIP]
    assert moved_beside(model.blocks, stage).tolist() == []
    chip_alone = replace(stage, unstable_blocks=np.array([CHIP]))
    assert moved_beside(model.blocks, chip_alone).tolist() == [SLAB]
    (note,) = note_on_others(model.blocks, chip_alone, np.array([False, True, True]))
    assert note.startswith(f"the fall of block {CHIP} ended the run")
    assert f"block {SLAB} moved by more than a tenth of its size" in note
    assert moved_beside(model.blocks, replace(stage, status=Status.STABLE)).tolist() == []


def test_a_trial_that_ends_as_a_chip_falls_names_the_slab_that_moved_as_far_as_counts():
    blocks = slope(20.0, stop=False).blocks
    displacement = np.zeros((3, 3))
    displacement[[SLAB, CHIP], 0] = -0.1, -6.0  # 7 % of the slab's size
    ended = Ended(
        value=1.0,
        status=Status.UNSTABLE,
        reason="",
        displacement=displacement,
        down=np.array([CHIP], dtype=np.int32),
        seconds=0.0,
        results=None,
    )
    counts = np.ones(3, dtype=bool)
    assert bsm.Failure().judge(ended, None, blocks, counts).blocks.tolist() == [SLAB, CHIP]
    assert bsm.Failure(movement=0.08).judge(ended, None, blocks, counts).blocks.tolist() == [CHIP]
