"""The thesis's own examples: verdicts and numbers that its text gives; all sizes are reconstructions."""

from __future__ import annotations

import math

import numpy as np

from examples.numbers import runs
from examples.numbers.thesis import DAM, HEEL_ROCK, OPENING, PUSHED, SLOPE, TOE_ROCK, layers
from examples.numbers.tunnel import MESHES, section, solved
from verification.case import Answer, Case, limit_between

PAGES = {
    1: "../examples/01_circular_tunnel/README.md",
    2: f"../examples/{PUSHED}/README.md",
    3: f"../examples/{SLOPE}/README.md",
    4: f"../examples/{OPENING}/README.md",
    5: f"../examples/{DAM}/README.md",
}


def tunnel() -> Answer:
    """Compare Example 1: L2 error of the vertical stress on section I-I, triangles, over that of the continuum."""
    model, comparison = solved("triangles", "wang", MESHES[0][2][1])
    return 0.0, section.errors(model, comparison)[0] / 100


def pushed_block() -> Answer:
    """Compare Example 2: block 2 moves 0.5 m and leans on block 3."""
    results = runs.run(f"{PUSHED}/model")
    return 0.5, float(runs.moved(results, [1])[0]) if results.status == "stable" else math.inf


def block_3_away() -> Answer:
    """Compare Example 2 with block 3 away: which blocks are unstable, in the thesis's numbers."""
    down = runs.run(f"{PUSHED}/apart").unstable_blocks
    return "block 2", " and ".join(f"block {number + 1}" for number in down)


def stratified_slope() -> Answer:
    """Compare Example 3: dip at which the layers slide; friction of joint set 1."""

    def sticks(dip: float) -> bool:
        return bool(runs.moved(runs.run(f"{SLOPE}/dip_{str(dip).replace('.', '_')}")).max() < 0.01)

    return 25.0, limit_between(sticks, 24.5, 25.5)


def layers_at_the_toe() -> Answer:
    """Compare Example 3: how far the layers slide until the toe stops them, as the reconstruction lays them [m]."""
    name = f"{SLOPE}/model"
    found = [runs.moved(runs.run(name), rows).mean() for rows in layers(runs.load(name), 40.0)]
    return np.array([2.0, 3.0]), np.array(found)


def bolted_opening() -> Answer:
    """Compare Example 4: every unstable block without bolts, with the roof bolt, with two, with three."""
    words = {(15,): "roof", (10,): "wall", (): "none"}
    names = ("unbolted", "roof_bolt", "two_bolts", "model")
    down = [tuple(runs.run(f"{OPENING}/{name}").unstable_blocks.tolist()) for name in names]
    return "roof, wall, none, none", ", ".join(words.get(each, str(each)) for each in down)


def roof_bolt() -> Answer:
    """Compare Example 4: the roof bolt carries the weight of its wedge [kN]."""
    name = f"{OPENING}/model"
    weight = runs.load(name).weights[15]
    return float(weight) / 1e3, float(runs.run(name).stages[-1].bolts.greatest_force[0]) / 1e3


def dam_foundation() -> Answer:
    """Compare Example 5: how the dam moves, whether it parts from the rock upstream, whether its toe rises."""
    u = runs.run(f"{DAM}/slip").stages[-1].displacement
    dam, upstream, toe = u[0], u[HEEL_ROCK], u[TOE_ROCK]
    words = ("downstream" if dam[0] > 0 else "upstream", "parts" if dam[0] - upstream[0] > dam[0] / 2 else "holds",
             "up" if toe[1] > dam[0] / 4 else "not up")  # fmt: skip
    return "downstream, parts, up", ", ".join(words)


CASES = (
    Case(name="example-1", what="Example 1: triangles, the thesis's stiffness, sigma_v on section I-I beside finite "
         "elements", source="skfem", quantity="L2 error", compute=tunnel, tolerance=0.06, page=PAGES[1], is_slow=True),
    Case(name="example-2", what="Example 2: block 2 reaches rest against block 3", source="wang",
         quantity="displacement [m]", compute=pushed_block, tolerance=2e-4, page=PAGES[2]),
    Case(name="example-2-apart", what="Example 2, block 3 away from block 1", source="wang", quantity="unstable",
         compute=block_3_away, tolerance=0.0, page=PAGES[2]),
    Case(name="example-3", what="Example 3: dips of 24.5 and 25.5 degrees", source="wang",
         quantity="dip at which layers slide [degrees]", compute=stratified_slope, tolerance=0.021, page=PAGES[3]),
    Case(name="example-3-toe", what="Example 3: the layers slide to the toe and stop", source="wang",
         quantity="displacement [m]", compute=layers_at_the_toe, tolerance=1e-4, page=PAGES[3]),
    Case(name="example-4", what="Example 4: an opening bolted wedge by wedge", source="wang", quantity="falls",
         compute=bolted_opening, tolerance=0.0, page=PAGES[4]),
    Case(name="example-4-bolt", what="Example 4: the roof bolt takes the weight of its wedge", source="wang",
         quantity="tension [kN]", compute=roof_bolt, tolerance=1e-5, page=PAGES[4]),
    Case(name="example-5", what="Example 5: a dam on jointed rock under water", source="wang",
         quantity="dam, upstream joint, toe block", compute=dam_foundation, tolerance=0.0, page=PAGES[5]),
)  # fmt: skip
