"""How many calls lie between `bsm_mesh.run` and a joint's law: whoever follows a run to its forces reads them all."""

import sys
import traceback

import pytest

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle, turned

# docs/architecture.md says what each is for. A layer that only passes on is none.
MAX_FRAMES = 14


class Watched(bsm.MohrCoulomb):
    """A law that remembers the deepest stack in which it was asked, from `run` on."""

    deepest: list[str] = []  # noqa: RUF012

    def respond(self, pressure, trial_shear, length, failed, slip_path=None):
        codes = [frame.f_code for frame, _ in traceback.walk_stack(sys._getframe())]
        names = [f"{code.co_filename.rpartition('/')[2]}: {code.co_name}" for code in codes]
        names = names[: names.index("run.py: run") + 1] if "run.py: run" in names else []
        if len(names) > len(self.deepest):
            self.deepest[:] = names
        return super().respond(pressure, trial_shear, length, failed)


@pytest.mark.heavy
@pytest.mark.parametrize(("slope", "status"), [(10.0, "stable"), (45.0, "unstable")])
def test_few_calls_lie_between_a_run_and_a_law(slope, status):
    Watched.deepest.clear()
    polygons = [rectangle(-4, -1, 8, 0), rectangle(0, 0, 1, 1), rectangle(0, 1, 1, 2)]
    results = bsm.run(model_of([turned(p, slope) for p in polygons], law=Watched(friction=35)))
    assert results.status == status
    assert Watched.deepest[0] == "test_depth.py: respond"
    assert len(Watched.deepest) <= MAX_FRAMES, Watched.deepest[::-1]
