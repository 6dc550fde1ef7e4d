"""Answers of a run and of an analysis cannot be changed, also after a copy or in another process."""

from __future__ import annotations

import copy
import dataclasses
import pickle

import numpy as np
import pytest

import bsm_mesh as bsm
from tests.scenes.polyhedra import box
from tests.scenes.pushed_block import example_2

pytestmark = pytest.mark.heavy
MODEL = example_2(1e9).replace(histories=[bsm.History("block", block=1)])


def key_blocks():
    blocks = bsm.Polyhedra.from_solids([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))], rock="r", joint="J")
    blocks = blocks.with_boundary("top", lambda x, y, z: z > 1.9)
    joint = bsm.Joint("J", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=35))
    return bsm.key_blocks(blocks, rocks=[bsm.Rock("r", unit_weight=26e3)], joints=[joint], free=["top"])


@pytest.mark.parametrize(
    "copied", [lambda answer: answer, copy.deepcopy, lambda answer: pickle.loads(pickle.dumps(answer))]
)
@pytest.mark.parametrize(
    "make", [lambda: bsm.limit_analysis(MODEL), key_blocks, lambda: bsm.run(MODEL).histories["block"]]
)
def test_arrays_of_answers_are_read_only(make, copied):
    answer = copied(make())
    arrays = [getattr(answer, field.name) for field in dataclasses.fields(answer)]
    assert not any(array.flags.writeable for array in arrays if isinstance(array, np.ndarray))
