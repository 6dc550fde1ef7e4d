"""Closed form: a circular hole under sigma_v = 10 MPa, K = 0.5 (Kirsch 1898; Jumikis in Wang Eq. 3.46).

A quarter of a plate of radius 20 a in rays and rings of near-squares, rollers on the two axes, Kirsch's tractions on
the edge. With the stiffness ``homogeneous`` such quads are isotropic (c11 - c12 = 2 c66) and tend to Kirsch's stresses.
"""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from tests.scenes.kirsch import error_near, kirsch, model_of, plate
from tests.scenes.models import LINEAR


@cache
def solved(around, stiffness):
    corners = plate(around)
    results = bsm.run(model_of(corners, stiffness), LINEAR)
    assert results.check().ok
    return error_near(results.stages[-1].stress, corners)


def test_formula():
    """C12's table: tangential and radial stress at springline and crown, compression positive there."""
    r = np.array([1, 1.5, 2, 3, 5])
    springline, crown = -kirsch(r, 0 * r) / 1e6, -kirsch(0 * r, r) / 1e6
    assert_allclose(springline[:, 1, 1], [25, 14.8148, 12.3438, 10.9259, 10.312], atol=5e-5)
    assert_allclose(springline[:, 0, 0], [0, 4.6296, 5.1563, 5.1852, 5.088], atol=6e-5)
    assert_allclose(crown[:, 0, 0], [5, 6.8519, 6.4063, 5.7407, 5.288], atol=5e-5)


def test_blocks_converge():
    assert solved(48, "homogeneous") < 0.6 * solved(24, "homogeneous")


@pytest.mark.parametrize("around", [24, 48])
def test_the_thesis_stiffness_does_not_tend_to_kirsch_on_quads(around):
    """Quads with Eq. 3.24 are another material, soft in shear: a fact about the model that the documents state."""
    assert solved(around, "wang") > 0.15
