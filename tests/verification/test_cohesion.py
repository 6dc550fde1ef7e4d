"""Books with cohesion: limit equilibrium takes the whole of it, so a plastic joint gives their factors of safety.

Strength reduced by a factor of safety F leaves a block just at its limit: friction tan(phi) / F and cohesion c / F.
"""

import numpy as np
import pytest

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.plane_failure import hoek_and_bray
from tests.scenes.shapes import rectangle, turned

MARGIN = 1e-3


def stands(model):
    """Return whether the block rests where it is: one that slides leaves water behind, and may rest further down."""
    results = bsm.run(model)
    return results.status == "stable" and results.stages[0].max_displacement < 1e-3


@pytest.mark.heavy
@pytest.mark.parametrize(("zw", "printed"), [(3.0, 1.247), (4.348, 1.072), (0.0, 1.544)])
def test_plane_failure_stands_up_to_the_books_factor(zw, printed):
    slope = hoek_and_bray(zw=zw)
    assert slope.factor == pytest.approx(printed, abs=2e-3)
    assert stands(slope.model(slope.factor * (1 - MARGIN)))
    assert not stands(slope.model(slope.factor * (1 + MARGIN)))


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("peak", "left", "status"), [(1.01, None, "stable"), (0.99, None, "unstable"), (1.01, 0.5, "stable")]
)
def test_cohesion_alone_on_an_incline(peak, left, status):
    """A block without friction; the rest of its cohesion matters only once it has slipped."""
    polygons = [turned(p, 30.0) for p in (rectangle(-20, -5, 5, 0), rectangle(-1, 0, 1, 0.5))]
    need = 25e3 * 0.5 * np.sin(np.radians(30.0))  # Pa: weight along the incline over the base's length
    law = bsm.MohrCoulomb(
        friction=0.0, cohesion=peak * need, residual_cohesion=None if left is None else left * peak * need
    )
    assert bsm.run(model_of(polygons, law=law)).status == status
