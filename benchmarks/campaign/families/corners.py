"""Blocks that touch by corners alone: on edges, on nodes of edges, on corners."""

from __future__ import annotations

import numpy as np

from benchmarks.campaign.families.draws import near, stiffness
from benchmarks.campaign.scene import FloatArray, Scene, box, turn
from benchmarks.campaign.trial import Draft, Expected

SLIDING = 1e-3  # of the friction angle: the elastic turn of a lintel adds to its tilt
BESIDE = 1e-6  # of the length of a lintel: a node beside a tip
KINDS = ("none", "on tips", "beside tips", "one tip", "halves")


def draw_corner(generator: np.random.Generator) -> Draft:
    """Return a tilted lintel on the tips of two triangles, or two bars that lean on each other by a corner."""
    return _lintel(generator) if generator.random() < 0.7 else _leaning(generator)


def _lintel(generator: np.random.Generator) -> Draft:
    """Return a lintel whose contacts slip together, where its tilt is the friction angle.

    Its lower edge has nodes on the tips, beside them, on one of them, or none; or it is two halves in the middle of one
    tip, of which each rests on that corner by its own corner: nothing is known of these.
    """
    span, height = generator.uniform(3.0, 8.0), generator.uniform(0.5, 1.0)
    friction = generator.uniform(15, 50)
    tilt = near(generator, friction)
    kn, ks = stiffness(generator)
    kind = str(generator.choice(KINDS))
    tips = np.array([span / 5, 4 * span / 5])
    under = [*tips, span / 2] if kind == "halves" else tips
    supports = [np.array([(x - span / 7, -1.0), (x + span / 7, -1.0), (x, 0.0)]) for x in under]
    nodes = {"on tips": tips, "beside tips": tips + BESIDE * span, "one tip": tips[:1]}.get(kind, tips[:0])
    lintel = [np.concatenate([[(0, 0)], np.column_stack([nodes, 0 * nodes]), [(span, 0), (span, height), (0, height)]])]
    if kind == "halves":
        lintel = [box(0, 0, span / 2, height), box(span / 2, 0, span, height)]
    held = np.arange(len(supports))
    cells: list[FloatArray] = [turn(cell, tilt) for cell in (*supports, *lintel)]
    scene = Scene(polygons=cells, held=held, friction=friction, kn=kn, ks=ks)
    parameters = {"kind": kind, "span": span, "height": height, "tilt": tilt, "friction": friction, "kn": kn, "ks": ks}
    sag = 26e3 * span * height / (kn * height) / span  # a contact of a corner alone closes, and the lintel turns by it
    middle = span / 2 + height / 2 * np.tan(np.radians(tilt))  # where the weight acts on the lower edge
    rests = kind != "halves" and tips[0] < middle - height and middle + height < tips[1]
    expected = Expected(form="lintel", margin=1 - tilt / friction, tolerance=SLIDING + 10 * sag)
    return Draft(scene=scene, parameters=parameters, expected=expected if rests else None)


def _leaning(generator: np.random.Generator) -> Draft:
    """Return two bars between abutments that touch at one point at the crown."""
    span, rise, thickness = generator.uniform(3.0, 6.0), generator.uniform(1.0, 3.0), generator.uniform(0.4, 1.2)
    friction = generator.uniform(10, 60)
    kn, ks = stiffness(generator)
    slope = np.array([span, rise]) / np.hypot(span, rise)
    up = thickness * np.array([-slope[1], slope[0]])
    foot, crown = np.array([-span, 0.0]), np.array([0.0, rise])
    bar = np.array([foot, crown, crown + up, foot + up])
    abutment = np.array([foot - (3, 2), foot - (0, 2), foot, foot + up, foot + up - (2.5, 0)])
    mirror = np.array([-1.0, 1.0])
    cells = [abutment, (abutment * mirror)[::-1].copy(), bar, (bar * mirror)[::-1].copy()]
    scene = Scene(polygons=cells, held=np.array([0, 1]), friction=friction, kn=kn, ks=ks)
    parameters = {
        "kind": "bars", "span": span, "rise": rise, "thickness": thickness, "friction": friction, "kn": kn, "ks": ks,
    }  # fmt: skip
    return Draft(scene=scene, parameters=parameters)
