"""Random convex blocks that begin just above each other and fall: hulls, boxes and piles of two hulls."""

import time
from types import SimpleNamespace

import numpy as np
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

import bsm_mesh as bsm
from bsm_mesh.solve.continuation.loop import Continuation
from bsm_mesh.three_d.overlap import unexplained_overlap
from tests.scenes.polyhedra import box, hull, model_in_space

KINDS = ("hulls", "boxes", "pile")
FRICTIONS = (20, 35, 50)  # degrees
GAP = 1e-3  # m: between a block and the next below it, along the vertical


def random_block(rng, kind):
    """Return corners and faces of a box of random sides, or of the hull of 6 to 12 points, turned at random."""
    if kind == "boxes":
        half = rng.uniform(0.3, 0.9, size=3)
        corners, faces = box(-half, half)
    else:
        count = int(rng.integers(6, 13))
        points = rng.normal(size=(count, 3))
        points *= (rng.uniform(0.8, 1.0, size=count) / np.linalg.norm(points, axis=1))[:, None]
        corners, faces = hull(points * rng.uniform(0.4, 0.9, size=3))
    return Rotation.random(random_state=int(rng.integers(1 << 30))).apply(corners), faces


def lift(corners, below):
    """Return by how much a block must be lifted to lie on another (corners each); -inf where it passes beside it."""
    n, m = len(corners), len(below)
    rows = np.zeros((5, n + m + 1))
    rows[:3, :n], rows[:3, n : n + m], rows[2, -1] = corners.T, -below.T, 1
    rows[3, :n] = rows[4, n : n + m] = 1
    found = linprog(
        [0] * (n + m) + [-1], A_eq=rows, b_eq=[0, 0, 0, 1, 1], bounds=[(0, None)] * (n + m) + [(None, None)]
    )
    return found.x[-1] if found.status == 0 else -np.inf


def dropped_blocks(seed):
    """Return a kind, and the model of one or two blocks above a fixed one that lies on a fixed floor."""
    rng, kind = np.random.default_rng(seed), KINDS[seed % 3]
    corners, faces = random_block(rng, kind)
    solids = [box((-6, -6, -1), (6, 6, -GAP)), (corners - (0, 0, corners[:, 2].min()), faces)]
    for _ in range(2 if kind == "pile" else 1):
        corners, faces = random_block(rng, kind)
        corners[:, :2] += rng.uniform(-0.35, 0.35, 2)
        corners[:, 2] += max(lift(corners, other) for other, _ in solids) + GAP
        solids.append((corners, faces))
    return kind, model_in_space(solids, fixed=(0, 1), friction=float(rng.choice(FRICTIONS)), kn=1e8, ks=1e8)


def judged(seed):
    """Return kind and verdict of a model, and the greatest overlap and the last, over the smallest block's volume."""
    kind, model = dropped_blocks(seed)
    overlaps = []

    def observe(_, state):
        overlaps.append(overlap(model.blocks, state().position))

    begun = time.process_time()
    end = Continuation(model, bsm.Options(threads=1), observe).run()
    seconds = round(time.process_time() - begun, 1)
    found = {"worst": round(max(overlaps), 4), "last": round(overlaps[-1], 4)}
    return {"seed": seed, "kind": kind, "verdict": str(end.status), "seconds": seconds, **found}


def overlap(blocks, movement):
    """Return the overlap of the worst pair of blocks after a movement (n, 6), over the smallest free block's volume."""
    columns = ("block_a", "block_b", "opening", "length")
    stage = SimpleNamespace(
        origin=np.zeros_like(movement),
        displacement=movement,
        present=np.ones(blocks.count, dtype=bool),
        contacts=SimpleNamespace(**{name: np.zeros(0, int) for name in columns}),
    )
    volume = blocks.moments.volume
    return unexplained_overlap(blocks, stage) * float(np.median(volume) / volume[2:].min())
