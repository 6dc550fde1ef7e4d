"""Layers on an inclined plane above a toe: they stay, or slide to it and stop (Wang's Example 3 in kind)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from benchmarks.campaign.families.closed import SLIDING
from benchmarks.campaign.families.draws import near, stiffness
from benchmarks.campaign.scene import Scene, box, turn
from benchmarks.campaign.trial import Draft, Expected


def draw_layers(generator: np.random.Generator) -> Draft:
    """Return layers of blocks: they slide where the dip is more than the friction."""
    layers, blocks = int(generator.integers(1, 7)), int(generator.integers(2, 26))
    length, thickness = generator.uniform(1.0, 3.0), generator.uniform(0.5, 1.5)
    dip, gap = generator.uniform(15, 50), generator.uniform(0.1, 3.0)
    friction = near(generator, dip) if generator.random() < 0.5 else generator.uniform(10, 50)
    friction = min(friction, 60.0)
    shift = float(generator.choice([0.0, 0.5])) * length  # of every second layer
    kn, ks = stiffness(generator)
    cells = []
    for layer in range(layers):
        heads = length * np.arange(-blocks, 1.0) - (shift if layer % 2 else 0.0)
        cells += [box(a, layer * thickness, b, (layer + 1) * thickness) for a, b in pairwise(heads)]
    top, crest = layers * thickness, -length * (blocks + 1)
    frame = [box(crest, -length, gap + 2 * top, 0.0), box(gap, 0.0, gap + 2 * top, top)]
    scene = Scene(
        polygons=[turn(cell, -dip) for cell in (*frame, *cells)],
        held=np.array([0, 1]),
        friction=friction,
        kn=kn,
        ks=ks,
    )
    parameters = {
        "layers": layers, "blocks": blocks, "length": length, "thickness": thickness, "dip": dip, "gap": gap,
        "shift": shift, "friction": friction, "kn": kn, "ks": ks,
    }  # fmt: skip
    margin = np.tan(np.radians(friction)) / np.tan(np.radians(dip)) - 1
    lean = 26e3 * top / kn / length * top / length  # of a column of blocks on its springs
    tips = np.tan(np.radians(dip)) > 0.9 * length / top
    known = margin < 0 or not (tips or shift)
    expected = Expected(form="layers", margin=float(margin), tolerance=SLIDING + lean) if known else None
    return Draft(scene=scene, parameters=parameters, expected=expected)
