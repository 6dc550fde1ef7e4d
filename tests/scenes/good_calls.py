"""Good calls from Python, a row each, whose arguments are then exchanged."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

SQUARES = [[(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)] for y in range(2) for x in range(2)]
Call = tuple[str, Callable[..., Any], dict[str, Any], str]  # name, what is called, arguments, how it enters a model


def flat_blocks() -> dict[str, Any]:
    """Return four squares as `Blocks` has them, with their lower and upper boundaries."""
    import numpy as np

    import bsm_mesh as bsm

    blocks = bsm.Blocks.from_polygons(SQUARES, rock="gneiss")
    return {
        "vertices": np.array(SQUARES, dtype=float).reshape(-1, 2),
        "offsets": np.array([0, 4, 8, 12, 16], dtype=np.int32),
        "nodes": blocks.nodes.copy(),
        "rock": np.zeros(4, dtype=np.int32),
        "rock_names": ("gneiss",),
        "edge_joint": np.full(16, -1, dtype=np.int32),
        "boundaries": {"bottom": np.array([0, 4]), "top": np.array([10, 14])},
    }


@cache
def good_calls() -> list[Call]:
    """Return the calls."""
    import numpy as np

    import bsm_mesh as bsm

    blocks, law = bsm.Blocks(**flat_blocks()), bsm.MohrCoulomb(friction=35)
    stiff = {"normal_stiffness": 1e9, "shear_stiffness": 1e9}
    model = {
        "blocks": blocks,
        "rocks": [bsm.Rock("gneiss", unit_weight=26e3)],
        "joints": [bsm.Joint("J1", **stiff, law=law)],
        "default_joint": "J1",
        "supports": [bsm.Fixed(blocks=[0, 1])],
        "loads": [bsm.PointLoad(block=2, point=(0.5, 1.5), force=(1e3, 0.0))],
        "bolts": [bsm.Bolt(start=(0.5, 1.9), end=(0.5, 0.3), diameter=0.025)],
        "gravity_direction": -90.0,
        "contact_points": "ends",
        "in_situ": bsm.InSitu(surface=2.0),
        "water": bsm.Water(table=[(0, 0.5)]),
        "stages": [bsm.Stage(name="dig", excavate=[3])],
        "title": "a model",
    }
    keys = {"diameter": 0.025, "pretension": 1e3}
    patterns = bsm.bolt_patterns
    return [
        ("bsm.Blocks.from_polygons", bsm.Blocks.from_polygons, {"polygons": SQUARES, "rock": "gneiss"}, "blocks"),
        (
            "bsm.Blocks.from_polygons",
            bsm.Blocks.from_polygons,
            {"polygons": SQUARES, "rock": ["a", "gneiss", "a", "b"]},
            "",
        ),
        ("bsm.Blocks", bsm.Blocks, flat_blocks(), "blocks"),
        ("bsm.Rock", bsm.Rock, {"name": "gneiss", "unit_weight": 26e3, "young": 1e10, "poisson": 0.25}, "rocks"),
        (
            "bsm.Rock",
            bsm.Rock,
            {
                "name": "gneiss",
                "unit_weight": 26e3,
                "young": 1e10,
                "poisson": 0.25,
                "cohesion": 1e6,
                "friction": 40.0,
                "tensile_strength": 1e5,
                "stiffness": "wang",
            },
            "rocks",
        ),
        ("bsm.Filling", bsm.Filling, {"thickness": 1e-3, "young": 5e7, "poisson": 0.3}, "filling"),
        ("bsm.Joint", bsm.Joint, {"name": "J1", **stiff, "law": law, "tensile_strength": 0.0}, "joints"),
        ("bsm.MohrCoulomb", bsm.MohrCoulomb, {"friction": 30.0, "cohesion": 1e4, "residual_friction": 28.0}, "law"),
        (
            "bsm.Patton",
            bsm.Patton,
            {"friction": 30.0, "dilation": 5.0, "cohesion": 1e4, "residual_friction": 28.0},
            "law",
        ),
        ("bsm.Fixed", bsm.Fixed, {"blocks": [0, 1]}, "supports"),
        ("bsm.Fixed", bsm.Fixed, {"point": (0.5, 0.5)}, "supports"),
        ("bsm.Fixed", bsm.Fixed, {"boundary": "bottom"}, "supports"),
        ("bsm.Roller", bsm.Roller, {"direction": 90.0, "blocks": [0, 1]}, "supports"),
        ("bsm.NormalRoller", bsm.NormalRoller, {"boundary": "bottom"}, "supports"),
        (
            "bsm.PrescribedDisplacement",
            bsm.PrescribedDisplacement,
            {"direction": 90.0, "displacement": 1e-3, "blocks": [0]},
            "supports",
        ),
        ("bsm.PointLoad", bsm.PointLoad, {"block": 2, "point": (0.5, 1.5), "force": (1e3, -1e3)}, "loads"),
        ("bsm.Pressure", bsm.Pressure, {"boundary": "top", "pressure": (1e5, 0.0, 1.0)}, "loads"),
        ("bsm.Traction", bsm.Traction, {"boundary": "top", "traction": (1e5, (0.0, 1.0, 0.0))}, "loads"),
        ("bsm.EdgeTractions", bsm.EdgeTractions, {"boundary": "top", "values": np.full((2, 2, 2), -1e4)}, "loads"),
        ("bsm.InSituTraction", bsm.InSituTraction, {"boundary": "top"}, "loads"),
        (
            "bsm.InSitu",
            bsm.InSitu,
            {"surface": [(0, 2), (2, 2.5)], "k0": {"a": 100.0, "b": 0.3}, "surcharge": 1e3, "method": "direct"},
            "in_situ",
        ),
        ("bsm.InSitu", bsm.InSitu, {"surface": 2.0, "k0": 0.5}, "in_situ"),
        ("bsm.InSitu", bsm.InSitu, {"stress": {"xx": (-1e5, 0, 0), "yy": -1e5, "xy": 0.0}}, "in_situ"),
        (
            "bsm.Water",
            bsm.Water,
            {"table": [(0, 1.5), (2, 1)], "unit_weight": 9810.0, "head": "vertical", "joint_pressure": {"J1": 1e3}},
            "water",
        ),
        (
            "bsm.Bolt",
            bsm.Bolt,
            {
                "start": (0.5, 1.9),
                "end": (0.5, 0.3),
                **keys,
                "yield_strength": 5e8,
                "bond_strength": 1e5,
                "bond_stiffness": 1e9,
                "bearing_stiffness": 1e9,
                "plate": 1e5,
                "spacing": 1.5,
            },
            "bolts",
        ),
        (
            "bsm.Bolt",
            bsm.Bolt,
            {
                "start": (0.5, 1.9),
                "end": (0.5, 0.3),
                **keys,
                "kind": "end_anchored",
                "anchor_capacity": 8e4,
                "name": "B",
            },
            "bolts",
        ),
        (
            "bolt_patterns.radial_bolts",
            patterns.radial_bolts,
            {"centre": (1, 1), "radius": 0.1, "length": 0.7, "count": 2, "first": 20.0, "last": 160.0, **keys},
            "bolts",
        ),
        (
            "bolt_patterns.row_of_bolts",
            patterns.row_of_bolts,
            {"blocks": blocks, "boundary": "top", "length": 0.8, "interval": 0.6, **keys},
            "bolts",
        ),
        (
            "bolt_patterns.bolts_on_curves",
            patterns.bolts_on_curves,
            {"pieces": np.array([[[0.2, 0.2], [1.0, 1.0]]]), **keys},
            "bolts",
        ),
        (
            "bsm.Stage",
            bsm.Stage,
            {
                "name": "dig",
                "excavate": [3, [(0, 1), (1, 1), (1, 2), (0, 2)]],
                "relaxation": [0.5, 1.0],
                "pressure": 1e3,
                "water": bsm.Water(table=[(0, 0.5)]),
            },
            "stages",
        ),
        (
            "bsm.Options",
            bsm.Options,
            {
                "scheme": "continuation",
                "tolerance": 1e-6,
                "max_steps": 60,
                "displacement_limit": 5.0,
                "linear_solver": "auto",
                "threads": 1,
            },
            "options",
        ),
        ("bsm.Options", bsm.Options, {"scheme": "linear", "threads": 1}, "options"),
        ("bsm.Model", bsm.Model, model, "model"),
        ("bsm.Model", bsm.Model, {**model, "in_situ": None, "water": None, "stages": [], "bolts": []}, "model"),
        ("bsm.library.rock", bsm.library.rock, {"name": "sandstones", "unit_weight": 24e3}, ""),
        ("bsm.library.joint", bsm.library.joint, {"name": "serpentine joints", "law": law}, ""),
        ("bsm.load", bsm.load, {"path": "model.toml"}, ""),
        ("bsm.Results.load", bsm.Results.load, {"folder": "out"}, ""),
        (
            "geometries.JointSet(...).traces",
            _joint_set,
            {
                "name": "J1",
                "dip": 60.0,
                "spacing": 1.0,
                "start": (0, 0),
                "scatter": 2.0,
                "persistence": 0.7,
                "bridge": 0.5,
                "ends": "crossing",
            },
            "",
        ),
        ("geometries.Fault(...).traces", _fault, {"name": "F", "lines": [[(0, 0), (1, 1)]], "extends": False}, ""),
    ]


def _joint_set(**arguments: Any) -> None:
    import numpy as np

    from bsm_mesh.geometries import JointSet

    JointSet(**arguments).traces(np.zeros(2), np.full(2, 10.0), 1)


def _fault(**arguments: Any) -> None:
    import numpy as np

    from bsm_mesh.geometries import Fault

    Fault(**arguments).traces(np.zeros(2), np.full(2, 10.0), 1)
