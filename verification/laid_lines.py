"""Joints laid along lines through meshes that do not know them: their length in the rock, and verdicts."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.converters import read_mesh
from bsm_mesh.converters.meshes.laid_lines import lay_lines
from tests.scenes.cut_incline import WIDTH, plane, slab, write_section
from tests.scenes.mesh_files import FORMATS, SHAPES, write_mesh
from tests.scenes.random_lines import KINDS, length_laid, random_line
from verification.case import Answer, Case

EACH, GROUPS = 5, {"*": "rock:a"}  # lines a mesh
SHORT = 1e-3  # m: errors of shorter lines count as of this length


def lengths(meshes: int) -> Answer:
    """Compare lengths of random lines that are laid, over their lengths in the rock, with 1: five lines a mesh.

    Triangles and recombined quadrilaterals of Gmsh, Voronoi polygons, and jittered grids, in files of four formats.
    """
    found = []
    for number in range(meshes):
        shape, rng = SHAPES[number % 4], np.random.default_rng(number)
        with TemporaryDirectory() as folder:
            size = float(rng.choice([3.0, 1.5, 0.8]))
            path = write_mesh(shape, FORMATS[shape][number // 4 % len(FORMATS[shape])], size, number, Path(folder))
            given, _ = read_mesh(path, groups=GROUPS)
            for kind in (KINDS[(EACH * number + k) % len(KINDS)] for k in range(EACH)):
                line = random_line(kind, given, rng)
                laid, _, _ = lay_lines(given, {"f": [line]})
                length = length_laid(given, laid, "f", [line], kind)
                found.append(1 + (length.laid - length.near) / max(length.near, SHORT))
    return np.ones(len(found)), np.array(found)


def verdicts(count: int) -> Answer:
    """Compare verdicts of random slabs with their friction: the plane laid through a mesh, and cut by Gmsh."""
    rng, exact, found = np.random.default_rng(5), [], []
    for number in range(count):
        dip = float(rng.choice([-1, 1]) * rng.uniform(10, 35))
        level = WIDTH / 2 * math.tan(math.radians(abs(dip))) + float(rng.uniform(0.5, 2.5))  # daylights above the base
        quads, blocks = bool(number % 2), ("regions", "elements")[number // 2 % 2]
        friction = abs(dip) + float(rng.choice([-1, 1]) * rng.uniform(0.5, 5))
        size, line = float(rng.uniform(1.2, 2.5)), plane(dip, level=level)
        with TemporaryDirectory() as folder:
            bare = write_section(Path(folder) / "bare.msh", size, quads=quads, seed=number + 1)
            cut = write_section(Path(folder) / "cut.msh", size, quads=quads, joint=line, seed=number + 1)
            models = slab(bare, friction, blocks, line), slab(cut, friction, blocks)
            found += [float(bsm.run(model).status == "stable") for model in models]
        exact += [float(math.tan(math.radians(friction)) > math.tan(math.radians(abs(dip))))] * 2
    return np.array(exact), np.array(found)


_LENGTHS, _VERDICTS = "length laid over length in the rock", "at rest: 1, slides: 0; laid and cut by Gmsh"
CASES = (
    Case(name="laid-lengths", what="20 random lines over 4 meshes", source="shapely", quantity=_LENGTHS,
         compute=partial(lengths, 4), tolerance=1e-9),
    Case(name="laid-verdicts", what="slabs on planes of 10 to 35 degrees", source="statics", quantity=_VERDICTS,
         compute=partial(verdicts, 2), tolerance=0.0),
    Case(name="laid-lengths-of-300", what="300 random lines over 60 meshes in four formats", source="shapely",
         quantity=_LENGTHS, compute=partial(lengths, 60), tolerance=1e-9, is_slow=True),
    Case(name="laid-verdicts-of-40", what="40 random slabs: triangles, quads; regions, elements", source="statics",
         quantity=_VERDICTS, compute=partial(verdicts, 40), tolerance=0.0, is_slow=True),
)  # fmt: skip
