"""Numbers of the pages on key blocks and verification in space: a tunnel, wedges of Hoek & Bray, cut rock, a dome."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.geometries import three_d
from bsm_mesh.modelfile.space_file import load_space_file
from bsm_mesh.pictures.key_block_pictures import draw_key_blocks
from bsm_mesh.three_d.key_blocks.record import KeyBlocks
from bsm_mesh.three_d.limit.analysis import LimitAnalysis3D, weights
from bsm_mesh.three_d.limit.points import LimitPoints
from bsm_mesh.three_d.limit.strength import ConeStrength
from docs.code_blocks import ROOT, files_of
from examples.numbers.pages import Table, markdown
from tests.scenes.rock_3d import WEDGES, dome, planes, wedge_factor, wedge_rock

PAGE, PICTURE = "docs/key_blocks.md", "docs/key_blocks.png"
VERIFICATION = "docs/verification_3d.md"


@cache
def _tunnel() -> tuple[bsm.Polyhedra, KeyBlocks]:
    """Return the blocks of the page's tunnel, and its key blocks in two rounds."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tunnel.toml"
        path.write_text(files_of((ROOT / PAGE).read_text(encoding="utf-8"))["tunnel.toml"], encoding="utf-8")
        loaded = load_space_file(path)
    found = bsm.key_blocks(
        loaded.blocks,
        rocks=loaded.rocks,
        joints=loaded.joints,
        excavated=["tunnel"],
        required=loaded.file.key_blocks.required,
    )
    return loaded.blocks, found


def tunnel() -> str:
    """Return what is found of the page's tunnel."""
    blocks, found = _tunnel()
    rows = np.flatnonzero((found.round > 0) & ~found.sliver)
    rows = rows[np.argsort(-found.weight[rows])][:8]
    lines = [
        (
            str(found.block[k]),
            found.modes[k],
            f"{found.factor[k]:.3f}",
            f"{found.volume[k]:.3f}",
            f"{found.weight[k] / 1e3:.2f}",
            f"{found.support[k] / 1e3:.2f}",
            f"{found.apex[k]:.2f}",
        )
        for k in rows
    ]
    header = ("block", "mode", "factor", "volume [m³]", "weight [kN]", "support [kPa]", "apex [m]")
    told = (
        f"The rock has {blocks.count} blocks, {len(blocks.slivers)} of them slivers. {found.count} lie at the wall, "
        f"and {int(found.held.sum())} of these reach the ends of the box. {int(found.removable.sum())} are removable: "
        f"{found.modes.count('falls')} fall, and {int(found.unstable.sum()) - found.modes.count('falls')} slide at a "
        "factor below 1. The heaviest below the required factor are:"
    )
    return f"{told}\n\n{markdown(header, lines)}"


def draw() -> None:
    """Draw the page's tunnel."""
    blocks, found = _tunnel()
    draw_key_blocks(ROOT / PICTURE, blocks, found, title="Tunnel in three joint sets")


def wedges() -> str:
    """Return six wedges: volume, factor by the formula and by `bsm.key_blocks`, bound by limit analysis."""
    lines = []
    for name, (first, second, face, top, height, friction, cohesion, unit_weight) in WEDGES.items():
        blocks, wedge, volume, areas = wedge_rock(first, second, face, top, height)
        laws = [bsm.MohrCoulomb(friction=f, cohesion=c) for f, c in zip(friction, cohesion, strict=True)]
        joints = [
            bsm.Joint(n, normal_stiffness=1e9, shear_stiffness=1e9, law=law) for n, law in zip("AB", laws, strict=True)
        ]
        rocks = [bsm.Rock("rock", unit_weight=unit_weight)]
        found = bsm.key_blocks(blocks, rocks=rocks, joints=joints, free=["slope"])
        factor = float(found.factor[found.block == wedge][0])
        formula = wedge_factor(first, second, volume, areas, unit_weight, friction, cohesion)
        analysis = LimitAnalysis3D(
            blocks.moments, LimitPoints.of(blocks.contact_polygons), np.arange(blocks.count) != wedge
        )
        joint = analysis.points.joint
        strength = ConeStrength(
            slope=np.tan(np.radians(friction))[joint][:, None],
            intercept=(np.array(cohesion)[joint] * analysis.points.area)[:, None],
            tension=np.zeros(len(joint)),
        )
        bound = analysis.strength_factor(weights(blocks.moments, np.full(blocks.count, unit_weight)), strength)
        error = abs(blocks.moments.volume[wedge] / volume - 1)
        lines.append(
            (
                f"{first[0]:g}/{first[1]:03d}, {second[0]:g}/{second[1]:03d}",
                f"{friction[0]}°, {friction[1]}°",
                f"{cohesion[0] / 1e3:g}, {cohesion[1] / 1e3:g}",
                f"{volume:.1f}",
                "below 1e-12" if error < 1e-12 else f"{error:.0e}",
                f"{formula:.4f}",
                f"{factor:.4f}",
                f"{bound:.3f}",
            )
        )
        assert name
    header = (
        "planes", "friction", "cohesion [kPa]", "volume [m³]", "its error", "Hoek & Bray", "`key_blocks`", "upper bound"
    )  # fmt: skip
    return markdown(header, lines)


def cut() -> str:
    """Return blocks, slivers and the error of the volume of rock in three sets, by its size."""
    lines = []
    for side in (10.0, 21.5, 46.0):
        rock = three_d.RockMass(box=((0, 0, 0), (side,) * 3), joints=planes((0, 0, 0), (side,) * 3, 1.0, 0))
        blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
        volume = blocks.moments.volume
        error = abs(volume.sum() / side**3 - 1)
        lines.append(
            (
                f"{side:g} m",
                str(blocks.count),
                str(blocks.contact_polygons.count),
                str(len(blocks.slivers)),
                f"{volume.min() / volume.mean():.0e}",
                "below 1e-12" if error < 1e-12 else f"{error:.0e}",
            )
        )
    return markdown(("side", "blocks", "contact polygons", "slivers", "least over mean volume", "error of all"), lines)


def domes() -> str:
    """Return the least thickness of a hemispherical dome by limit analysis."""
    lines = []
    for sectors, courses in ((16, 10), (16, 20), (16, 40)):
        low, high = 0.038, 0.048
        while high - low > 1e-4:
            middle = (low + high) / 2
            low, high = (low, middle) if _stands(middle, sectors, courses) else (middle, high)
        lines.append((f"{sectors} x {courses}", f"{high:.4f}"))
    return markdown(("sectors x courses", "least thickness over radius"), lines)


def _stands(thickness: float, sectors: int, courses: int) -> bool:
    blocks, base = dome(thickness, sectors, courses)
    analysis = LimitAnalysis3D(blocks.moments, LimitPoints.of(blocks.contact_polygons), base)
    strength = ConeStrength.coulomb(analysis.points.area, 70.0)
    return analysis.analyse(weights(blocks.moments, np.full(blocks.count, 25e3)), strength).admissible


TABLES = (
    Table(name="key_blocks_tunnel", page=PAGE, make=tunnel, draw=draw),
    Table(name="key_blocks_wedges", page=PAGE, make=wedges),
    Table(name="cut_rock", page=VERIFICATION, make=cut),
    Table(name="domes", page=VERIFICATION, make=domes, is_slow=True),
)
