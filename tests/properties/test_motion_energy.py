"""Explicit motion gives no energy: of weight, springs and movement there is never more after a window than before."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bsm_mesh.solve.motion.explicit import ExplicitMotion
from bsm_mesh.solve.motion.following import FREE
from tests.scenes.random_models import jointed_banks, piles
from tests.scenes.steps import begun

WINDOWS = 80
ROUNDING = 1e-6  # of the kinetic energy and the work of weights: forces of a window have single precision


def energy(motion: ExplicitMotion, start: np.ndarray) -> tuple[float, float]:
    """Return the energy of a dry model since its start [N], and the size of its parts."""
    at, position = motion.residual.at, motion.residual.position
    springs = (at.normal_stiffness > 0) & at.closed
    normal = at.pressure[springs] ** 2 / at.normal_stiffness[springs]
    shear = at.shear[springs] ** 2 / at.springs.stiffness[springs]
    lost = (motion.system.loads_at(position) * (position - start)).sum()
    moves, stored = motion.kinetic_energy, (normal.sum() + shear.sum()) / 2
    return moves - lost + stored, moves + abs(lost) + stored


@pytest.mark.heavy
@settings(max_examples=8, derandomize=True, deadline=None)
@given(st.one_of(piles(), jointed_banks()))
def test_what_falls_lands_and_slides_gains_no_energy(model):
    step = begun(model, threads=1)
    motion = ExplicitMotion(step, FREE)
    before, most = energy(motion, step.start)
    for _ in range(WINDOWS):
        motion.advance()
        assert not motion.diverged
        after, size = energy(motion, step.start)
        most = max(most, size)
        assert after <= before + ROUNDING * most
        if motion.passed > motion.system.d:
            motion.search()
            after, _ = energy(motion, step.start)
        before = after
