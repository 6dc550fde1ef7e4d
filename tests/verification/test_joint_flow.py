"""Flow in joints against closed forms: Dupuit's discharge through a dam of closely spaced joints.

J. Dupuit, Etudes theoriques et pratiques sur le mouvement des eaux, 1863. That his discharge, though not his free
surface, is exact for a dam with a seepage face was shown by I.A. Charny (1951); P.Ya. Polubarinova-Kochina, Theory of
ground water movement, Princeton 1962, VII 1.
"""

import numpy as np
import pytest

from bsm_mesh.flow.steady import solve_steady
from tests.scenes.flow_networks import VISCOSITY, WEIGHT, conductance, dam

APERTURE = 0.5e-3
EXACT = 1e-10  # the joints' discharge sums up to Dupuit's, as the continuum's does: measured 1e-15


@pytest.mark.parametrize("spacing", [1, 0.5, 0.25])
@pytest.mark.parametrize(("width", "upstream", "downstream"), [(10, 10, 0), (10, 8, 2), (5, 10, 2), (20, 10, 1)])
def test_dupuit(spacing, width, upstream, downstream):
    net, given, number = dam(width, 10, spacing, upstream, downstream)
    flow = solve_steady(net, conductance(net, APERTURE), given)
    permeability = APERTURE**3 * WEIGHT / (12 * VISCOSITY) / spacing
    expected = permeability * (upstream**2 - downstream**2) / (2 * width)
    through = flow.outflow[number[-1]].sum()
    assert through == pytest.approx(expected, rel=EXACT)
    assert flow.imbalance <= 1e-12


def test_the_free_surface_leaves_the_dam_above_the_tailwater():
    """On a seepage face, from the tailwater up to where the surface ends, it comes out without pressure."""
    net, given, number = dam(10, 10, 0.25, 10, 2)
    flow = solve_steady(net, conductance(net, APERTURE), given)
    face = number[-1][net.point[number[-1], 1] > 2]
    wet = flow.outflow[face] > 0
    assert wet[0]
    assert not wet[-1]
    assert (np.diff(wet.astype(int)) <= 0).all()
    assert not flow.pressure_head[face].any()
