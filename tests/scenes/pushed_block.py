"""Wang's Example 2 (section 4.6): a block that is pushed over a fixed one towards another, 0.5 m off."""

from __future__ import annotations

import bsm_mesh as bsm
from tests.scenes.models import model_of
from tests.scenes.shapes import rectangle

GAMMA, WIDTH, PUSH, FRICTION, GAP = 26e3, 1.0, 30e3, 30.0, 0.5


def example_2(kn: float, *, apart: bool = False) -> bsm.Model:
    """Return block 2 on block 1, pushed towards block 3; `apart`: block 3 away from block 1 (Wang Figs. 4.16, 4.18)."""
    end, wall = (2.0, 4.0) if apart else (3.0, 2.0)
    polygons = [
        rectangle(-0.5, -1, end, 0),
        rectangle(0.5, 0, 0.5 + WIDTH, 1),
        rectangle(wall, 0 if not apart else -1, wall + 1, 2),
    ]
    push = [bsm.PointLoad(block=1, point=(0.5, 0.3), force=(PUSH, 0))]
    return model_of(polygons, friction=FRICTION, kn=kn, gamma=GAMMA, fixed=(0, 2), loads=push)
