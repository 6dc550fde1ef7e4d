"""Data of this example: published numbers, its models with their options, displacements of the points."""

import math
import re
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

import bsm_mesh as bsm
from bsm_mesh import converters
from bsm_mesh.converters.beside_files import read_beside
from bsm_mesh.geometries import cassiar_slope
from bsm_mesh.model.locate import blocks_at

HERE = Path(__file__).parent
SIZE = 50.0  # m, of an element
CONDITIONS = ("none", "low", "intermediate-low", "intermediate", "high")
CREST = -330 / math.tan(math.radians(40))  # m
OPTIONS = bsm.Options(displacement_limit=10.0)  # m: further is a slide


def published(source):
    """Return the displacements (7,) [m] of the points under high water by a source of Wang Table 8.4; None: none."""
    table = read_beside(HERE / "published.csv")
    listed = ({one.source: one.value for one in table[f"point_{k}"]} for k in range(1, 8))
    return tuple(values.get(source) for values in listed)


UDEC, BLOSMER, OBSERVED = map(published, ("UDEC", "BLOSMER", "observed"))


def load(name="model"):
    """Return the model of a file."""
    return bsm.load(HERE / f"{name}.toml")


def with_geometry(model, blocks="elements", **parameters):
    """Return the model on blocks of another geometry, and its monitoring points."""
    size = {"size": SIZE} if blocks == "elements" else {}
    with tempfile.TemporaryDirectory() as folder:
        path = cassiar_slope.build(Path(folder) / "slope.msh", **{**size, **parameters})
        cut = converters.read_blocks(path, blocks=blocks)
    known = ("height", "slope_angle", "fault_level", "joint_f_level")
    points = cassiar_slope.monitoring_points(**{k: v for k, v in parameters.items() if k in known})
    return model.replace(blocks=cut, histories=()), points  # the histories' points may lie in the air there


def with_joints(model, change, which=None):
    """Return the model with `change(joint)` for the joints of these names, or all."""
    return model.replace(joints=[change(j) if which is None or j.name in which else j for j in model.joints])


def with_rocks(model, **change):
    """Return the model with rock that fails as Table 8.3 says of the mass, and what `change` says besides."""
    strength = {"argillite": (7.0e5, 32.0), "serpentinite": (2.0e5, 26.0)}
    rocks = []
    for rock in model.rocks:
        cohesion, friction = strength[rock.name]
        given = {name: share * cohesion for name, share in change.items()}
        rocks.append(replace(rock, cohesion=cohesion, friction=friction, **given))
    return model.replace(rocks=rocks)


def with_levels(model, highest=0.8, shape=0.5, crest=CREST):
    """Return the model with four tables, from 0.5 to `highest` of the height at the crest."""
    share = np.linspace(1, 0, 41)
    stages = []
    for stage, part in zip(model.stages, np.linspace(0.5, highest, 4), strict=True):
        level = np.minimum(part * 330 * share**shape, 330 * share)
        table = tuple(zip((crest * share).tolist(), level.tolist(), strict=True))
        stages.append(replace(stage, water=replace(stage.water, table=table)))
    return model.replace(stages=tuple(stages))


def with_head(model, head):
    """Return the model with another rule for the pressure under its tables."""
    return model.replace(stages=[replace(stage, water=replace(stage.water, head=head)) for stage in model.stages])


def with_k0(model, k0):
    """Return the model with the stress set before, under a ground that follows the slope."""
    ground = ((CREST - 250, 330.0), (CREST, 330.0), (0.0, 0.0), (200.0, 0.0))
    return model.replace(in_situ=bsm.InSitu(method="direct", surface=ground, k0=k0))


def at_once(model, water=None):
    """Return the model from zero stress, weight and the highest water (or that of `water`) together, in one stage."""
    return model.replace(in_situ=None, stages=(), water=model.stages[-1].water if water is None else water)


def write_from_zero_stress(folder):
    """Write the model files from zero stress: under each water table at once, and under water that rises.

    ``none.toml``, ``low.toml``, ``intermediate_low.toml``, ``intermediate.toml`` and ``rising.toml``.
    """
    text = (HERE / "high_water.toml").read_text(encoding="utf-8").replace('measured = "published.csv"\n', "")
    water = re.search(r"\[water\].*?\ntable = .*\n", text).group()
    rising = (HERE / "model.toml").read_text(encoding="utf-8")
    tables = dict(re.findall(r'name = "(\w+)".*\nwater = \{ (table = .*) \}', rising))
    del tables["high"]
    (folder / "none.toml").write_text(text.replace(water, ""), encoding="utf-8")
    for name, table in tables.items():
        (folder / f"{name}.toml").write_text(text.replace(water, f"[water]\n{table}\n"), encoding="utf-8")
    in_situ = re.search(r"\[in_situ\].*\nmethod = .*\n", rising).group()
    (folder / "rising.toml").write_text(rising.replace(in_situ, ""), encoding="utf-8")


def moved(results, stage, points):
    """Return the vectors by which points on the blocks moved, from zero stress and from the dry state, (k, 2) [m]."""
    centroid = results.blocks.moments.centroid
    found = []
    for motion in (stage.origin + stage.displacement, stage.origin):
        vectors = []
        for point in points:
            block = blocks_at(results.blocks, point, tolerance=1e-6)[0]
            (x, y), (u, v, turn) = np.array(point) - centroid[block], motion[block]
            versed, sine = math.cos(turn) - 1, math.sin(turn)
            vectors.append((u + versed * x - sine * y, v + sine * x + versed * y))
        found.append(np.array(vectors))
    return found[0], found[0] - found[1]


def rising(results, points=None):
    """Return the displacements of a run in which the water rises, from zero stress and from the dry state.

    Lengths [m], (conditions, points) each.
    """
    points = cassiar_slope.monitoring_points() if points is None else points
    both = [moved(results, stage, points) for stage in results.stages]
    whole, since_dry = (np.array([np.hypot(*vectors.T) for vectors in kind]) for kind in zip(*both, strict=True))
    since_dry[0] = 0.0  # the first stage is the dry state
    return whole, since_dry


def at_the_end(results, points=None):
    """Return the displacements (points,) [m] from zero stress at the end of a run."""
    points = cassiar_slope.monitoring_points() if points is None else points
    return np.hypot(*moved(results, results.stages[-1], points)[0].T)


def from_blosmer(displacement):
    """Return the root mean square of the difference from BLOSMER's points [m]."""
    return float(np.sqrt(np.mean((np.asarray(displacement) - BLOSMER) ** 2)))
