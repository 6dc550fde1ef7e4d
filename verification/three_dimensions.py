"""Blocks in three dimensions: wedges, a roof block, torsion, toppling."""

from __future__ import annotations

from functools import partial

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.geometries import three_d
from bsm_mesh.three_d.limit.analysis import LimitAnalysis3D, weights
from bsm_mesh.three_d.limit.points import LimitPoints
from bsm_mesh.three_d.limit.strength import ConeStrength
from tests.scenes.rock_3d import WEDGES, wedge_factor, wedge_rock
from verification.case import Answer, Case


def joint(name: str, friction: float, cohesion: float = 0.0) -> bsm.Joint:
    """Return a joint of a strength."""
    law = bsm.MohrCoulomb(friction=friction, cohesion=cohesion)
    return bsm.Joint(name, normal_stiffness=1e9, shear_stiffness=1e9, law=law)


def wedge(name: str) -> Answer:
    """Compare factor of safety of a wedge on two planes, with cohesion or without."""
    first, second, face, top, height, friction, cohesion, unit_weight = WEDGES[name]
    blocks, number, volume, areas = wedge_rock(first, second, face, top, height)
    joints = [joint(n, f, c) for n, f, c in zip("AB", friction, cohesion, strict=True)]
    rocks = [bsm.Rock("rock", unit_weight=unit_weight)]
    found = bsm.key_blocks(blocks, rocks=rocks, joints=joints, free=["slope"])
    exact = wedge_factor(first, second, volume, areas, unit_weight, friction, cohesion)
    return float(exact), float(found.factor[found.block == number][0])


def chart() -> Answer:
    """Compare the factor of the worked example of the friction charts, given with two decimals."""
    return 1.30, wedge("Wyllie and Mah's chart")[1]


def wedge_geometry() -> Answer:
    """Compare volumes and areas of the six wedges, over the closed forms."""
    ratios = []
    for first, second, face, top, height, *_ in WEDGES.values():
        blocks, number, volume, areas = wedge_rock(first, second, face, top, height)
        polygons = blocks.contact_polygons
        of_wedge = polygons.some(polygons.of(number))
        ratios += [blocks.moments.volume[number] / volume]
        ratios += [of_wedge.area[of_wedge.joint == k].sum() / areas[k] for k in (0, 1)]
    return np.ones(len(ratios)), np.array(ratios)


def roof_pyramid() -> Answer:
    """Compare weight and support pressure of a pyramid of four planes over a roof [kN, kPa]."""
    joints = [
        three_d.JointPlane(name="J", dip=60, dip_direction=d, point=(np.sin(np.radians(d)), np.cos(np.radians(d)), 2))
        for d in (0, 90, 180, 270)
    ]
    body = three_d.prism([(-5, 0), (5, 0), (5, 2), (-5, 2)], origin=(0, -5, 0), length=10.0)
    rock = three_d.RockMass(
        box=((-6, -6, -1), (6, 6, 6)), joints=joints, bodies=[three_d.Opening(body=body, boundary="cavern")]
    )
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
    rocks = [bsm.Rock("rock", unit_weight=26e3)]
    found = bsm.key_blocks(blocks, rocks=rocks, joints=[joint("J", 30)], free=["cavern"])
    row = found.modes.index("falls")
    weight = 26.0 * 4 * np.sqrt(3) / 3
    return np.array([weight, weight / 4]), np.array([found.weight[row], found.support[row]]) / 1e3


def column(height: float) -> tuple[bsm.Polyhedra, LimitAnalysis3D]:
    """Return a column of 1 x 1 m on a fixed block, and its limit analysis."""
    joints = [three_d.JointPlane(name="J", dip=0, dip_direction=0, point=(0, 0, 0))]
    rock = three_d.RockMass(box=((0, 0, -1), (1, 1, height)), joints=joints)
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
    fixed = blocks.moments.centroid[:, 2] < 0
    return blocks, LimitAnalysis3D(blocks.moments, LimitPoints.of(blocks.contact_polygons), fixed)


def torsion() -> Answer:
    """Compare torque on a cube over friction times weight times side: its corners carry it."""
    blocks, analysis = column(1.0)
    twist = np.zeros((2, 6))
    twist[:, 5] = 1
    strength = ConeStrength.coulomb(analysis.points.area, 45)
    return np.sqrt(0.5), analysis.load_factor(weights(blocks.moments, np.ones(2)), twist, strength).value


def toppling(azimuth: float) -> Answer:
    """Compare push over weight that topples a column of 1 x 1 x 3 m, in a direction."""
    blocks, analysis = column(3.0)
    push, turn = np.zeros((2, 6)), np.radians(azimuth)
    push[:, :2] = 3 * np.array([np.sin(turn), np.cos(turn)])
    strength = ConeStrength.coulomb(analysis.points.area, 89)
    found = analysis.load_factor(weights(blocks.moments, np.ones(2)), push, strength).value
    return 1 / (3 * max(np.sin(turn), np.cos(turn))), found


CASES: tuple[Case, ...] = (
    Case(name="wedge-geometry", what="Six wedges between two joints, face and top of a slope", source="statics",
         quantity="volumes and areas over the closed forms", compute=wedge_geometry, tolerance=1e-12),
    *(Case(name=f"wedge-of-two-joints-{number}",
           what=f"Wedge {first[0]:g}/{first[1]:03d}, {second[0]:g}/{second[1]:03d} in a slope of {face[0]:g} degrees, "
           f"cohesion {cohesion[0] / 1e3:g} and {cohesion[1] / 1e3:g} kPa", source="hoek-bray",
           quantity="factor of safety", compute=partial(wedge, name), tolerance=1e-8)
      for number, (name, (first, second, face, _, _, _, cohesion, _)) in enumerate(WEDGES.items(), 1)),
    Case(name="wedge-chart", what="Worked example of the charts: 40/165 with 35 degrees, 70/285 with 20 degrees",
         source="hoek-bray", quantity="factor of safety, given as 1.30", compute=chart, tolerance=4e-3),
    Case(name="roof-pyramid", what="Pyramid of four joints of 60 degrees in a level roof", source="statics",
         quantity="weight [kN], support pressure [kPa]", compute=roof_pyramid, tolerance=1e-8),
    Case(name="twisted-cube", what="Cube twisted on its face", source="statics",
         quantity="torque over friction, weight and side", compute=torsion, tolerance=1e-6),
    *(Case(name=f"toppling-towards-{azimuth}",
           what=f"Column of 1 x 1 x 3 m pushed at mid-height towards {azimuth} degrees", source="statics",
           quantity="push over weight", compute=partial(toppling, float(azimuth)), tolerance=1e-5)
      for azimuth in (0, 20, 45, 70)),
)  # fmt: skip
