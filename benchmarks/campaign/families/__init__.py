"""The families of random models."""

from __future__ import annotations

from benchmarks.campaign.families import arches, closed, corners, layers, rocking, slopes, tunnels, walls
from benchmarks.campaign.families.variants import bolted, staged, tilted, watered, with_nodes
from benchmarks.campaign.trial import Draw, Family

BASE: dict[str, tuple[str, Draw, int]] = {
    "slope": ("slopes whose columns lean out", slopes.draw_slope, 160),
    "leaning": ("slopes whose columns lean in", slopes.draw_leaning, 110),
    "wall": ("tilted walls in bond", walls.draw_wall, 110),
    "pile": ("piles of convex blocks", walls.draw_pile, 120),
    "incline": ("a block on an incline", closed.draw_incline, 120),
    "column": ("tilted columns", closed.draw_column, 110),
    "tower": ("overhanging towers", closed.draw_tower, 100),
    "plane": ("plane failure: water, a bolt", closed.draw_plane, 120),
    "arch": ("semicircular arches", arches.draw_arch, 110),
    "beam": ("flat arches of two stones", arches.draw_beam, 80),
    "stiff beam": ("flat arches with stiff shear springs", arches.draw_stiff_beam, 60),
    "corner": ("blocks that touch by corners alone", corners.draw_corner, 100),
    "layers": ("layers above a toe", layers.draw_layers, 90),
    "rocking": ("columns, dams and stacks that rock on water", rocking.draw_rocking, 60),
    "tunnel": ("openings between two joint sets", tunnels.draw_tunnel, 110),
    "cavern": ("openings in Voronoi rock", tunnels.draw_cavern, 90),
}
BOLTED = {
    "slope": 60, "leaning": 40, "wall": 30, "pile": 30, "column": 30, "arch": 30, "layers": 25, "tunnel": 40,
    "cavern": 30,
}  # fmt: skip
WATERED = {"slope": 50, "leaning": 30, "wall": 25, "pile": 25, "layers": 20, "tunnel": 30, "cavern": 20}
STAGED = {"slope": 50, "leaning": 30, "wall": 30, "pile": 30, "arch": 20, "layers": 20}
TILTED = {"wall": 60, "column": 30, "incline": 20}
NODED = {"slope": 40, "leaning": 30, "wall": 40, "pile": 30, "column": 20, "arch": 20, "corner": 40, "tunnel": 30}
VARIANTS = {"bolts": (bolted, BOLTED), "water": (watered, WATERED), "stages": (staged, STAGED)}
VARIANTS |= {"tilted": (tilted, TILTED), "nodes": (with_nodes, NODED)}


def _families() -> dict[str, Family]:
    found = {name: Family(name=name, title=title, draw=draw, models=n) for name, (title, draw, n) in BASE.items()}
    for variant, (change, models) in VARIANTS.items():
        for base, count in models.items():
            name, (title, draw, _) = f"{base}+{variant}", BASE[base]
            found[name] = Family(name=name, title=f"{title}; {variant}", draw=change(draw), models=count)
    return found


FAMILIES = _families()
