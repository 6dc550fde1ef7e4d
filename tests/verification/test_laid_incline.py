"""A slab on a plane of 15 degrees: the joint laid through any mesh has the verdict of the one that Gmsh cut.

The slab slides where tan(friction) < tan(15 degrees), whatever the elements are.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import bsm_mesh as bsm
from tests.scenes.cut_incline import plane, slab, write_section

DIP = 15.0
LINE = plane(DIP)


@pytest.mark.heavy
def test_the_verdict_is_that_of_the_joint_in_the_mesh(tmp_path: Path) -> None:
    bare = write_section(tmp_path / "bare.msh", 2.0, quads=False)
    cut = write_section(tmp_path / "cut.msh", 2.0, quads=False, joint=LINE)
    for friction, status in ((DIP - 0.2, "unstable"), (DIP + 0.2, "stable")):
        laid, given = slab(bare, friction, "regions", LINE), slab(cut, friction, "regions")
        assert laid.blocks.count == given.blocks.count == 2
        assert len(laid.blocks.vertices) == 8  # the joint is one straight face
        assert bsm.run(laid).status == bsm.run(given).status == status


@pytest.mark.slow
@pytest.mark.parametrize("blocks", ["regions", "elements"])
@pytest.mark.parametrize("quads", [False, True])
@pytest.mark.parametrize(("dip", "level"), [(15.0, 5.0), (25.0, 6.0), (31.0, 7.0), (-18.0, 5.0)])
def test_verdicts_at_other_angles(dip: float, level: float, quads: bool, blocks: str, tmp_path: Path) -> None:
    line = plane(dip, level=level)
    bare = write_section(tmp_path / "bare.msh", 1.5, quads=quads)
    cut = write_section(tmp_path / "cut.msh", 1.5, quads=quads, joint=line)
    for friction, status in ((abs(dip) - 3, "unstable"), (abs(dip) + 0.5, "stable"), (abs(dip) + 10, "stable")):
        laid, given = slab(bare, friction, blocks, line), slab(cut, friction, blocks)
        assert bsm.run(laid).status == bsm.run(given).status == status
