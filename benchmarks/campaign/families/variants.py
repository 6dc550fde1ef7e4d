"""The same families with bolts, with water, in stages, tilted in stages, and with nodes on all edges."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.scene import DOWN, Dig, Line, Scene, polygon_centre
from benchmarks.campaign.transforms import noded
from benchmarks.campaign.trial import Draft, Draw

TRIES = 20  # to place bolts whose ends lie in blocks


def bolted(draw: Draw) -> Draw:
    """Return a family's models with one to ten bolts each, between blocks that may move and others."""

    def drawn(generator: np.random.Generator) -> Draft:
        draft = draw(generator)
        count = int(generator.integers(1, 11))
        bolts: list[bsm.Bolt] = []
        for _ in range(TRIES * count):
            bolt = _bolt(generator, draft.scene)
            if bolt is not None and _fits(draft.scene, (*bolts, bolt)):
                bolts.append(bolt)
            if len(bolts) == count:
                break
        grouted = sum(bolt.kind == "grouted" for bolt in bolts)
        given = {"bolts": len(bolts), "grouted": grouted, "tensioned": sum(bolt.pretension > 0 for bolt in bolts)}
        return Draft(scene=replace(draft.scene, bolts=tuple(bolts)), parameters={**draft.parameters, **given})

    return drawn


def _bolt(generator: np.random.Generator, scene: Scene) -> bsm.Bolt | None:
    """Return a bolt from the middle of a free block to that of another, two to six block sizes away."""
    taken = np.concatenate([np.zeros(0, int), *(dig.blocks for dig in scene.digs)])
    head = int(generator.choice(scene.free))
    start = polygon_centre(scene.polygons[head])
    there = np.setdiff1d(np.arange(scene.count), [head, *taken])
    centres = np.array([polygon_centre(scene.polygons[block]) for block in there])
    away = np.hypot(*(centres - start).T) / scene.size
    near = np.flatnonzero((away > 1) & (away < 6))
    if not near.size:
        return None
    end = centres[generator.choice(near)]
    tension = float(generator.choice([0.0, generator.uniform(20e3, 150e3)]))
    common: dict[str, Any] = {"start": tuple(start), "end": tuple(end), "diameter": 0.025, "yield_strength": 500e6}
    common |= {"pretension": tension, "spacing": float(generator.uniform(1, 2))}
    if scene.digs and generator.random() < 0.5:
        common["stage"] = "1"
    kind = generator.random()
    if kind < 0.25:
        return bsm.Bolt(kind="end_anchored", anchor_capacity=200e3, **common)
    strength = float(generator.uniform(50e3, 400e3))
    dowel: dict[str, Any] = {"bearing_stiffness": 1e9, "bearing_strength": 100e6} if kind > 0.75 else {}
    return bsm.Bolt(bond_strength=strength, **common, **dowel)


def _fits(scene: Scene, bolts: tuple[bsm.Bolt, ...]) -> bool:
    try:
        replace(scene, bolts=bolts).model()
    except bsm.ModelError:  # a bolt through a void
        return False
    return True


def watered(draw: Draw) -> Draw:
    """Return a family's models with a water table, there from the start or raised in a stage."""

    def drawn(generator: np.random.Generator) -> Draft:
        draft = draw(generator)
        scene = draft.scene
        low = min(float(polygon[:, 1].min()) for polygon in scene.polygons)
        high = max(float(polygon[:, 1].max()) for polygon in scene.polygons)
        depth = float(generator.uniform(0.1, 0.9))
        table = _below(scene.surface, depth) if scene.surface else ((0.0, low + (1 - depth) * (high - low)),)
        later = not scene.digs and generator.random() < 0.5
        digs = (Dig(blocks=np.zeros(0, int), table=table),) if later else scene.digs
        changed = replace(scene, table=() if later else table, digs=digs)
        return Draft(scene=changed, parameters={**draft.parameters, "depth_of_water": depth, "raised": int(later)})

    return drawn


def _below(surface: Line, depth: float) -> Line:
    """Return the ground lowered by a part of its height over its lowest point, which stays."""
    lowest = min(y for _, y in surface)
    if max(y for _, y in surface) == lowest:  # level ground over an opening
        return tuple((x, y * (1 - depth)) for x, y in surface)
    return tuple((x, lowest + (1 - depth) * (y - lowest)) for x, y in surface)


def staged(draw: Draw) -> Draw:
    """Return a family's models from which one to three stages take blocks: from above, below or anywhere."""

    def drawn(generator: np.random.Generator) -> Draft:
        draft = draw(generator)
        scene = draft.scene
        stages = int(generator.integers(1, 4))
        count = max(stages, round(len(scene.free) * generator.uniform(0.03, 0.15)))
        where = str(generator.choice(["above", "below", "anywhere"]))
        level = np.array([polygon_centre(scene.polygons[block])[1] for block in scene.free])
        order = {"above": np.argsort(-level), "below": np.argsort(level)}.get(where)
        chosen = scene.free[generator.permutation(len(level)) if order is None else order][:count]
        relaxation = ((1.0,), (0.5, 1.0))[int(generator.random() < 0.4)]
        digs = tuple(Dig(blocks=np.sort(part), relaxation=relaxation) for part in np.array_split(chosen, stages))
        given: dict[str, Any] = {"stages": stages, "taken": count, "where": where, "relaxation": len(relaxation)}
        return Draft(scene=replace(scene, digs=digs), parameters={**draft.parameters, **given})

    return drawn


def tilted(draw: Draw) -> Draw:
    """Return a family's models, which are on an incline, built on the level and tilted in two to twelve stages."""

    def drawn(generator: np.random.Generator) -> Draft:
        draft = draw(generator)
        stages = int(generator.choice([2, 6, 12]))
        base = draft.scene.polygons[0]
        along = base[1] - base[0]
        level = float(np.degrees(np.arctan2(along[1], along[0])))
        turns = level * (1 - np.arange(1, stages + 1) / stages)
        digs = tuple(Dig(blocks=np.zeros(0, int), gravity=DOWN + float(turn)) for turn in turns)
        scene = replace(draft.scene, gravity=DOWN + level, digs=digs)
        return replace(draft, scene=scene, parameters={**draft.parameters, "stages": stages})

    return drawn


def with_nodes(draw: Draw) -> Draw:
    """Return a family's models with nodes where corners of others lie, as in conforming meshes, and more."""

    def drawn(generator: np.random.Generator) -> Draft:
        draft = draw(generator)
        return replace(draft, scene=noded(draft.scene, generator))

    return drawn
